//! Elements that all SVG pictures share: ground, colours, mesh of the axes, legend, range of an axis.

use std::ops::Range;

use plotters::chart::MeshStyle;
use plotters::coord::ranged1d::Ranged;
use plotters::coord::{CoordTranslate, Shift};
use plotters::prelude::*;

/// The error of plotters that prevents a picture.
pub type DrawingError = Box<dyn std::error::Error>;

/// A picture, or a part of one.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Width and height of a picture with its legend inside, px.
pub const SIZE_PX: (u32, u32) = (760, 460);

/// Okabe and Ito's vermilion.
pub const VERMILION: RGBColor = RGBColor(213, 94, 0);

/// Okabe and Ito's blue.
pub const BLUE: RGBColor = RGBColor(0, 114, 178);

/// Okabe and Ito's bluish green.
pub const GREEN: RGBColor = RGBColor(0, 158, 115);

/// Okabe and Ito's colours without black and yellow.
pub const COLOURS: [RGBColor; 6] = [
    VERMILION,
    BLUE,
    GREEN,
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// A white picture of `size_px`. `text` contains the SVG after the picture was presented and dropped.
///
/// # Errors
/// [`DrawingError`] if plotters fails.
pub fn ground(text: &mut String, size_px: (u32, u32)) -> Result<Area<'_>, DrawingError> {
    let area = SVGBackend::with_string(text, size_px).into_drawing_area();
    area.fill(&WHITE)?;
    Ok(area)
}

/// Configures the mesh of two axes called `names` with main lines only; `sizes_px` are the sizes of labels and names, px.
pub fn plain<'m, 'a, 'b, 'text, X: Ranged, Y: Ranged>(
    mesh: &'m mut MeshStyle<'a, 'b, X, Y, SVGBackend<'text>>,
    names: [&str; 2],
    sizes_px: [u32; 2],
) -> &'m mut MeshStyle<'a, 'b, X, Y, SVGBackend<'text>> {
    mesh.x_desc(names[0])
        .y_desc(names[1])
        .label_style(("sans-serif", sizes_px[0]))
        .axis_desc_style(("sans-serif", sizes_px[1]))
        .light_line_style(WHITE)
}

/// Draws the legend of the labelled series into the upper right corner of `chart`.
///
/// # Errors
/// [`DrawingError`] if plotters fails.
pub fn legend<'a, 'text: 'a, Coordinates: CoordTranslate>(
    chart: &mut ChartContext<'a, SVGBackend<'text>, Coordinates>,
) -> Result<(), DrawingError> {
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .label_font(("sans-serif", 14))
        .draw()?;
    Ok(())
}

/// The symbol of a curve in a legend: a short line from the pixel `(x, y)` to the right.
pub fn key((x, y): (i32, i32), style: impl Into<ShapeStyle>) -> PathElement<(i32, i32)> {
    PathElement::new([(x, y), (x + 18, y)], style)
}

/// The range from the smallest to the largest finite value, extended below and above by these shares of the range. A range below
/// `least` counts as `least`, so that a constant is visible.
pub fn span(values: impl Iterator<Item = f64>, least: f64, [below, above]: [f64; 2]) -> Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if !low.is_finite() {
        return 0.0..1.0;
    }
    let size = (high - low).max(least);
    low - below * size..high + above * size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_has_its_margins_and_is_never_empty() {
        let of = |values: &[f64]| span(values.iter().copied(), 0.5, [0.25, 0.5]);
        assert_eq!(of(&[2.0, f64::NAN, 0.0, f64::INFINITY]), -0.5..3.0);
        assert_eq!(of(&[1.0, 1.0]), 0.875..1.25);
        assert_eq!(of(&[f64::NAN]), 0.0..1.0);
    }
}
