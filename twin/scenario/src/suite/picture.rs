//! The picture of a sweep: every sample at the values of its first two keys. Shape and colour distinguish success from failure.

use plotters::prelude::*;

use super::{CaseResult, SuiteReport, SweepReport};
use crate::plot;

const SUCCESS: RGBColor = plot::GREEN;
const FAILURE: RGBColor = plot::VERMILION;

/// Margin on each side, as a share of the range of the values.
const MARGIN: f64 = 0.05;

/// Share of the height that stays free for the legend.
const LEGEND: f64 = 0.18;

/// Smallest range of an axis, so that a constant value has a margin too.
const LEAST_RANGE: f64 = 2e-5;

/// The position of a sample in the picture.
struct Dot {
    x: f64,
    y: f64,
    passed: bool,
}

/// The picture of a sweep as SVG; `None` if no sample was flown. If the sweep has one key, the second axis is the number of the
/// sample. The picture does not show keys beyond the second.
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

fn draw(text: &mut String, dots: &[Dot], sweep: &SweepReport) -> Result<(), plot::DrawingError> {
    let area = plot::ground(text, plot::SIZE_PX)?;
    let SweepReport { succeeded, flown, interval_95: (low, high), .. } = sweep;
    let title = format!("{succeeded} of {flown} succeed, 95 % interval {low:.3} to {high:.3}");
    let mut chart = ChartBuilder::on(&area)
        .margin(14)
        .caption(title, ("sans-serif", 18))
        .x_label_area_size(44)
        .y_label_area_size(60)
        .build_cartesian_2d(
            plot::span(dots.iter().map(|dot| dot.x), LEAST_RANGE, [MARGIN, MARGIN]),
            plot::span(dots.iter().map(|dot| dot.y), LEAST_RANGE, [MARGIN, MARGIN + LEGEND]),
        )?;
    let name = |index: usize| sweep.plan.keys.get(index).map_or("sample", String::as_str);
    plot::plain(&mut chart.configure_mesh(), [name(0), name(1)], [13, 15]).draw()?;
    let of = |passed: bool| dots.iter().filter(move |dot| dot.passed == passed);
    chart
        .draw_series(of(true).map(|dot| Circle::new((dot.x, dot.y), 4, SUCCESS.filled())))?
        .label("succeeds")
        .legend(|(x, y)| Circle::new((x + 8, y), 4, SUCCESS.filled()));
    chart
        .draw_series(of(false).map(|dot| Cross::new((dot.x, dot.y), 5, FAILURE.stroke_width(2))))?
        .label("fails")
        .legend(|(x, y)| Cross::new((x + 8, y), 5, FAILURE.stroke_width(2)));
    plot::legend(&mut chart)?;
    area.present()?;
    Ok(())
}
