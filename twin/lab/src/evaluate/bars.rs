//! Pictures of bars as SVG: groups of bars beside each other, or on top of each other, with a legend.

use plotters::prelude::*;

use twin_scenario::plot::{self, Area, COLOURS, DrawingError};

/// Width and height of a picture, px.
const SIZE_PX: (u32, u32) = (860, 230);

/// Width of the legend, which stands right of the bars, and height of its lines, px.
const LEGEND_PX: (u32, i32) = (170, 18);

/// Share of a group that its bars take.
const FILLED: f64 = 0.8;

/// Margin above and below the bars, as a share of their range.
const MARGIN: f64 = 0.05;

/// A smaller range of the axis has the margins of this one, in its unit, so that bars near zero look small.
const LEAST_RANGE: f64 = 10.0;

/// A picture of bars.
#[derive(Clone, Debug, Default)]
pub(super) struct Bars {
    /// Title.
    pub(super) title: String,
    /// Name and unit of the axis.
    pub(super) y: String,
    /// Names of the groups.
    pub(super) groups: Vec<String>,
    /// Name of each series, and its bar in each group. A bar that is not finite is left out.
    pub(super) series: Vec<(String, Vec<f64>)>,
    /// Whether the bars of a group stand on top of each other.
    pub(super) stacked: bool,
}

impl Bars {
    /// The picture as SVG; empty if it cannot be drawn.
    pub(super) fn svg(&self) -> String {
        let mut text = String::new();
        match self.draw(&mut text) {
            Ok(()) => text,
            Err(_) => String::new(),
        }
    }

    /// The bars: series, and corners in groups and in units of the axis.
    fn bars(&self) -> Vec<(usize, [(f64, f64); 2])> {
        let wide = FILLED / if self.stacked { 1.0 } else { self.series.len().max(1) as f64 };
        let mut bars = Vec::new();
        for group in 0..self.groups.len() {
            let mut below = 0.0;
            for (series, (_, values)) in self.series.iter().enumerate() {
                let Some(value) = values.get(group).filter(|value| value.is_finite()) else {
                    continue;
                };
                let place = if self.stacked { 0.0 } else { series as f64 * wide };
                let left = group as f64 + (1.0 - FILLED) / 2.0 + place;
                bars.push((series, [(left, below), (left + wide, below + value)]));
                if self.stacked {
                    below += value;
                }
            }
        }
        bars
    }

    fn draw(&self, text: &mut String) -> Result<(), DrawingError> {
        let area: Area<'_> = plot::ground(text, SIZE_PX)?;
        let bars = self.bars();
        let ends = bars.iter().flat_map(|(_, corners)| corners.map(|(_, y)| y)).chain([0.0]);
        let ys = plot::span(ends, LEAST_RANGE, [MARGIN, MARGIN]);
        let mut chart = ChartBuilder::on(&area)
            .margin(10)
            .margin_right(LEGEND_PX.0)
            .caption(&self.title, ("sans-serif", 16))
            .x_label_area_size(26)
            .y_label_area_size(64)
            .build_cartesian_2d(0.0..self.groups.len().max(1) as f64, ys.clone())?;
        plot::plain(&mut chart.configure_mesh(), ["", &self.y], [12, 14])
            .disable_x_mesh()
            .x_label_formatter(&|_| String::new())
            .draw()?;
        let colour = |series: usize| COLOURS[series % COLOURS.len()];
        chart.draw_series(
            bars.iter().map(|(series, corners)| Rectangle::new(*corners, colour(*series).filled())),
        )?;
        let ends = [(0.0, 0.0), (self.groups.len() as f64, 0.0)];
        chart.draw_series([PathElement::new(ends, BLACK.stroke_width(1))])?;
        for (group, name) in self.groups.iter().enumerate() {
            let (x, y) = chart.backend_coord(&(group as f64 + 0.5, ys.start));
            area.draw(&Text::new(name.clone(), (x - 8, y + 8), ("sans-serif", 13)))?;
        }
        for ((series, (name, _)), line) in self.series.iter().enumerate().zip(1..) {
            let y = 30 + line * LEGEND_PX.1;
            let x = SIZE_PX.0.cast_signed() - LEGEND_PX.0.cast_signed() + 12;
            area.draw(&plot::key((x, y), colour(series).stroke_width(8)))?;
            area.draw(&Text::new(name.clone(), (x + 24, y - 6), ("sans-serif", 12)))?;
        }
        area.present()?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_stand_beside_each_other_or_on_top_of_each_other() {
        let mut bars = Bars {
            title: "a title".to_owned(),
            y: "%".to_owned(),
            groups: vec!["x".to_owned(), "y".to_owned()],
            series: vec![
                ("low".to_owned(), vec![1.0, f64::NAN]),
                ("high".to_owned(), vec![-2.0, 3.0]),
            ],
            stacked: false,
        };
        let beside = bars.bars();
        assert_eq!(beside.len(), 3, "the bar that is not finite is left out");
        assert!((beside[0].1[1].0 - beside[1].1[0].0).abs() < 1e-12, "{beside:?}");
        let svg = bars.svg();
        for word in ["a title", "low", "high", "%", ">\nx"] {
            assert!(svg.contains(word), "{word}: {svg}");
        }
        bars.stacked = true;
        let stacked = bars.bars();
        // The second bar begins where the first ends.
        assert_eq!((stacked[0].1[1].1, stacked[1].1[0].1, stacked[1].1[1].1), (1.0, 1.0, -1.0));
        assert!(bars.svg().starts_with("<svg"));
    }
}
