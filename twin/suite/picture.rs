//! The picture of a sweep: every sample at its first two values, those that succeed and those that fail told apart by shape
//! and colour.

use plotters::prelude::*;

use super::{CaseResult, SuiteReport, SweepReport};

const SIZE_PX: (u32, u32) = (760, 460);

/// Okabe and Ito's bluish green and vermilion.
const SUCCESS: RGBColor = RGBColor(0, 158, 115);
const FAILURE: RGBColor = RGBColor(213, 94, 0);

/// Part of the height that is kept free for the legend.
const LEGEND: f64 = 0.18;

/// A sample's place in the picture.
struct Dot {
    x: f64,
    y: f64,
    passed: bool,
}

/// The picture of a sweep as SVG; nothing for a sweep without a flight. With one key the second axis is the number of the
/// sample; keys beyond the second are not shown.
pub(super) fn svg(report: &SuiteReport, sweep: &SweepReport) -> Option<String> {
    let flown = report.samples_of(&sweep.plan.name).filter(|result| result.report().is_some());
    let dots: Vec<Dot> = flown.enumerate().filter_map(dot).collect();
    let mut text = String::new();
    draw(&mut text, &dots, sweep).ok()?;
    (!dots.is_empty()).then_some(text)
}

fn dot((number, result): (usize, &CaseResult)) -> Option<Dot> {
    let values = &result.case.sample.as_ref()?.values;
    let y = values.get(1).copied().unwrap_or(number as f64 + 1.0);
    Some(Dot { x: *values.first()?, y, passed: result.passed() })
}

fn draw(
    text: &mut String,
    dots: &[Dot],
    sweep: &SweepReport,
) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(text, SIZE_PX).into_drawing_area();
    area.fill(&WHITE)?;
    let SweepReport { succeeded, flown, interval_95: (low, high), .. } = sweep;
    let title = format!("{succeeded} of {flown} succeed, 95 % interval {low:.3} to {high:.3}");
    let mut chart = ChartBuilder::on(&area)
        .margin(14)
        .caption(title, ("sans-serif", 18))
        .x_label_area_size(44)
        .y_label_area_size(60)
        .build_cartesian_2d(
            span(dots.iter().map(|dot| dot.x), 0.0),
            span(dots.iter().map(|dot| dot.y), LEGEND),
        )?;
    let name = |index: usize| sweep.plan.keys.get(index).map_or("sample", String::as_str);
    chart
        .configure_mesh()
        .x_desc(name(0))
        .y_desc(name(1))
        .label_style(("sans-serif", 13))
        .axis_desc_style(("sans-serif", 15))
        .light_line_style(WHITE)
        .draw()?;
    let of = |passed: bool| dots.iter().filter(move |dot| dot.passed == passed);
    chart
        .draw_series(of(true).map(|dot| Circle::new((dot.x, dot.y), 4, SUCCESS.filled())))?
        .label("succeeds")
        .legend(|(x, y)| Circle::new((x + 8, y), 4, SUCCESS.filled()));
    chart
        .draw_series(of(false).map(|dot| Cross::new((dot.x, dot.y), 5, FAILURE.stroke_width(2))))?
        .label("fails")
        .legend(|(x, y)| Cross::new((x + 8, y), 5, FAILURE.stroke_width(2)));
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .label_font(("sans-serif", 14))
        .draw()?;
    area.present()?;
    Ok(())
}

/// From the smallest to the largest value with a margin, never empty; `above` is the part of it that stays free at the top.
fn span(values: impl Iterator<Item = f64>, above: f64) -> std::ops::Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if !low.is_finite() || !high.is_finite() {
        return 0.0..1.0;
    }
    let margin = (0.05 * (high - low)).max(1e-6);
    low - margin..high + margin + above * (high - low)
}
