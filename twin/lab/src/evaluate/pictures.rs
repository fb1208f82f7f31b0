//! Pictures as SVG: curves over time or over the horizon, with a legend.

use plotters::prelude::*;

use twin_scenario::plot::{self, Area, COLOURS, DrawingError};

/// Width and height of a picture, px.
const SIZE_PX: (u32, u32) = (860, 300);

/// Width and height of a map, px.
const MAP_PX: (u32, u32) = (640, 420);

/// Width and height that margins, title and labels of the axes take, px.
const SIDES_PX: (u32, u32) = (74 + LEGEND_PX.0, 84);

/// Width of the legend, which stands right of the curves, and height of its lines, px.
const LEGEND_PX: (u32, i32) = (170, 18);

/// Margin above and below the curves, as a share of their range.
const MARGIN: f64 = 0.05;

/// Smallest range of an axis, in its unit.
const LEAST_RANGE: f64 = 1e-9;

/// Number of dashes of a mark's line.
const DASHES: u32 = 40;

/// A curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Points in the units of the axes.
    pub points: Vec<(f64, f64)>,
    /// Whether the curve is a measurement, which is drawn first and in black.
    pub measured: bool,
}

/// A curve over the horizon: `errors` are those of the forecasts `j = 0..=k` ticks ahead.
pub fn horizon_curve(name: &str, errors: impl Iterator<Item = f64>) -> Curve {
    let points = errors.enumerate().map(|(j, error)| (j as f64, error)).collect();
    Curve { name: name.to_owned(), points, measured: false }
}

/// A picture of curves, and of marks: dashed lines with a name at a point of the first axis.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Title.
    pub title: String,
    /// Name and unit of the first axis.
    pub x: String,
    /// Name and unit of the second axis.
    pub y: String,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Marks: position on the first axis, and name.
    pub marks: Vec<(f64, String)>,
    /// Whether both axes have the same scale, as on a map.
    pub map: bool,
}

impl Picture {
    /// The picture as SVG; empty if there are no points.
    pub fn svg(&self) -> String {
        stacked(std::slice::from_ref(self))
    }

    /// The z-scored error of forecasts over the horizon.
    pub fn over_horizon(title: &str, curves: impl Iterator<Item = Curve>) -> Self {
        Self {
            title: title.to_owned(),
            x: "ticks ahead, j".to_owned(),
            y: "RMSE".to_owned(),
            curves: curves.collect(),
            ..Self::default()
        }
    }

    /// Width and height, px.
    fn size(&self) -> (u32, u32) {
        if self.map { MAP_PX } else { SIZE_PX }
    }

    fn draw(&self, area: &Area<'_>) -> Result<(), DrawingError> {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let aside = if self.map { MARGIN } else { 0.0 };
        let mut xs = plot::span(points().map(|(x, _)| *x), LEAST_RANGE, [aside, aside]);
        let mut ys = plot::span(points().map(|(_, y)| *y), LEAST_RANGE, [MARGIN, MARGIN]);
        if self.map {
            let inner = [MAP_PX.0 - SIDES_PX.0, MAP_PX.1 - SIDES_PX.1].map(f64::from);
            let scale = ((xs.end - xs.start) / inner[0]).max((ys.end - ys.start) / inner[1]);
            (xs, ys) = (about(&xs, scale * inner[0]), about(&ys, scale * inner[1]));
        }
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .margin_right(LEGEND_PX.0)
            .caption(&self.title, ("sans-serif", 16))
            .x_label_area_size(38)
            .y_label_area_size(64)
            .build_cartesian_2d(xs, ys.clone())?;
        plot::plain(&mut chart.configure_mesh(), [&self.x, &self.y], [12, 14]).draw()?;
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
        for (curve, line) in self.curves.iter().zip(1..) {
            let y = 30 + line * LEGEND_PX.1;
            let colour =
                if curve.measured { BLACK } else { *colours.next().unwrap_or(&COLOURS[0]) };
            let style = colour.stroke_width(if curve.measured { 2 } else { 1 });
            let finite = curve.points.iter().copied().filter(|(x, y)| (x + y).is_finite());
            chart.draw_series([PathElement::new(finite.collect::<Vec<_>>(), style)])?;
            let at = (self.size().0.cast_signed() - LEGEND_PX.0.cast_signed() + 12, y);
            area.draw(&plot::key(at, style))?;
            area.draw(&Text::new(curve.name.clone(), (at.0 + 24, y - 6), ("sans-serif", 12)))?;
        }
        Ok(())
    }
}

/// The pictures below each other as one SVG; empty if there are no points.
pub fn stacked(pictures: &[Picture]) -> String {
    let mut text = String::new();
    match draw_all(&mut text, pictures) {
        Ok(()) => text,
        Err(_) => String::new(),
    }
}

fn draw_all(text: &mut String, pictures: &[Picture]) -> Result<(), DrawingError> {
    let width = pictures.iter().map(|picture| picture.size().0).max().unwrap_or(SIZE_PX.0);
    let height = pictures.iter().map(|picture| picture.size().1).sum();
    let mut rest = plot::ground(text, (width, height))?;
    for picture in pictures {
        let (part, below) = rest.split_vertically(picture.size().1);
        picture.draw(&part)?;
        rest = below;
    }
    rest.present()?;
    Ok(())
}

/// A range of length `size` with the same middle.
fn about(range: &std::ops::Range<f64>, size: f64) -> std::ops::Range<f64> {
    let middle = f64::midpoint(range.start, range.end);
    middle - size / 2.0..middle + size / 2.0
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
            map: false,
        };
        let svg = picture.svg();
        let both = stacked(&[picture.clone(), picture]);
        assert_eq!(both.matches("a title").count(), 2);
        for word in ["a title", "t, s", "measured", "forecast", "reset"] {
            assert!(svg.contains(word), "{word}");
        }
        assert!(svg.starts_with("<svg") && !svg.contains("NaN"));
    }
}
