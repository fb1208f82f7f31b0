//! Pictures as SVG: curves over time or over the horizon, each with a legend.

use plotters::prelude::*;

/// Width and height of a picture, px.
const SIZE_PX: (u32, u32) = (860, 300);

/// Okabe and Ito's colours without black and yellow.
const COLOURS: [RGBColor; 6] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// Part of the height that is kept free for the legend.
const LEGEND: f64 = 0.25;

/// Dashes and gaps of a mark.
const DASHES: u32 = 40;

/// A curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name in the legend.
    pub name: String,
    /// Points.
    pub points: Vec<(f64, f64)>,
    /// Drawn black and first: what was measured.
    pub measured: bool,
}

/// A picture of curves and of moments marked by a dashed line with their name.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Above it.
    pub title: String,
    /// Name and unit of the first axis.
    pub x: String,
    /// Name and unit of the second axis.
    pub y: String,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Moments.
    pub marks: Vec<(f64, String)>,
}

impl Picture {
    /// As SVG; empty if there is nothing to draw.
    pub fn svg(&self) -> String {
        stacked(std::slice::from_ref(self))
    }

    fn draw(&self, area: &Area<'_>) -> Result<(), Box<dyn std::error::Error>> {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let xs = span(points().map(|(x, _)| *x), 0.0, 0.0);
        let ys = span(points().map(|(_, y)| *y), 0.05, LEGEND);
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .caption(&self.title, ("sans-serif", 16))
            .x_label_area_size(38)
            .y_label_area_size(64)
            .build_cartesian_2d(xs, ys.clone())?;
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .label_style(("sans-serif", 12))
            .axis_desc_style(("sans-serif", 14))
            .light_line_style(WHITE)
            .draw()?;
        for (at, name) in &self.marks {
            let part = |i: u32| ys.start + (ys.end - ys.start) * f64::from(i) / f64::from(DASHES);
            let dash = BLACK.mix(0.6).stroke_width(1);
            chart.draw_series(
                (0..DASHES)
                    .step_by(2)
                    .map(|i| PathElement::new([(*at, part(i)), (*at, part(i + 1))], dash)),
            )?;
            let style = ("sans-serif", 12).into_font().color(&BLACK);
            chart.draw_series([Text::new(name.clone(), (*at, ys.start), style)])?;
        }
        let mut colours = COLOURS.iter().cycle();
        for curve in &self.curves {
            let colour =
                if curve.measured { BLACK } else { *colours.next().unwrap_or(&COLOURS[0]) };
            let style = colour.stroke_width(if curve.measured { 2 } else { 1 });
            let finite = curve.points.iter().copied().filter(|(x, y)| (x + y).is_finite());
            chart
                .draw_series([PathElement::new(finite.collect::<Vec<_>>(), style)])?
                .label(&curve.name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .label_font(("sans-serif", 12))
            .draw()?;
        Ok(())
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// One SVG of these pictures below each other; empty if there is nothing to draw.
pub fn stacked(pictures: &[Picture]) -> String {
    let mut text = String::new();
    match draw_all(&mut text, pictures) {
        Ok(()) => text,
        Err(_) => String::new(),
    }
}

fn draw_all(text: &mut String, pictures: &[Picture]) -> Result<(), Box<dyn std::error::Error>> {
    let height = SIZE_PX.1 * u32::try_from(pictures.len())?;
    let area = SVGBackend::with_string(text, (SIZE_PX.0, height)).into_drawing_area();
    area.fill(&WHITE)?;
    for (picture, part) in pictures.iter().zip(area.split_evenly((pictures.len(), 1))) {
        picture.draw(&part)?;
    }
    area.present()?;
    Ok(())
}

/// From the smallest to the largest finite value with a margin below and above, as parts of the range; never empty.
fn span(values: impl Iterator<Item = f64>, below: f64, above: f64) -> std::ops::Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if !low.is_finite() {
        return 0.0..1.0;
    }
    let size = (high - low).max(1e-9);
    low - below * size..high + above * size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_names_its_curves_and_marks_and_leaves_out_what_is_not_finite() {
        let curve = |name: &str, y: f64| Curve {
            name: name.into(),
            points: (0..5).map(|i| (f64::from(i), y)).chain([(9.0, f64::NAN)]).collect(),
            measured: name == "measured",
        };
        let picture = Picture {
            title: "a title".into(),
            x: "t, s".into(),
            y: "N".into(),
            curves: vec![curve("measured", 1.0), curve("forecast", 2.0)],
            marks: vec![(2.0, "reset".into())],
        };
        let svg = picture.svg();
        let both = stacked(&[picture.clone(), picture]);
        assert_eq!(both.matches("a title").count(), 2);
        for word in ["a title", "t, s", "measured", "forecast", "reset"] {
            assert!(svg.contains(word), "{word}");
        }
        assert!(svg.starts_with("<svg") && !svg.contains("NaN"));
        assert_eq!(span([f64::NAN].into_iter(), 0.0, 0.0), 0.0..1.0);
    }
}
