//! The learning curve as a picture: loss of training and validation over the epochs, on a logarithmic axis.

use plotters::prelude::*;

use super::LearnError;
use super::checkpoint::EpochRecord;
use twin_scenario::plot;

const TRAIN: RGBColor = plot::BLUE;
const VALIDATION: RGBColor = plot::VERMILION;

/// The curve as SVG; `best_epoch` is marked.
///
/// # Errors
/// [`LearnError::Picture`] if the curve has no epoch, or if drawing fails.
pub fn svg(title: &str, curve: &[EpochRecord], best_epoch: usize) -> Result<String, LearnError> {
    if curve.is_empty() {
        return Err(LearnError::Picture("no epoch was trained".to_owned()));
    }
    let mut text = String::new();
    draw(&mut text, title, curve, best_epoch)
        .map_err(|error| LearnError::Picture(error.to_string()))?;
    Ok(text)
}

fn draw(
    text: &mut String,
    title: &str,
    curve: &[EpochRecord],
    best_epoch: usize,
) -> Result<(), plot::DrawingError> {
    let area = plot::ground(text, plot::SIZE_PX)?;
    let losses = curve.iter().flat_map(|r| [r.train_loss, r.validation_loss]);
    let (low, high) = losses.fold((f64::MAX, 1e-9_f64), |(l, h), v| (l.min(v.max(1e-9)), h.max(v)));
    let epoch = |record: Option<&EpochRecord>| record.map_or(0.0, |r| r.epoch as f64);
    let (first, last) = (epoch(curve.first()), epoch(curve.last()));
    let mut chart = ChartBuilder::on(&area)
        .margin(14)
        .caption(title, ("sans-serif", 18))
        .x_label_area_size(44)
        .y_label_area_size(70)
        .build_cartesian_2d(first - 0.5..last + 0.5, (low * 0.8..high * 1.25).log_scale())?;
    plot::plain(&mut chart.configure_mesh(), ["epoch", "mean squared z-score"], [13, 15])
        .y_label_formatter(&|y: &f64| format!("{y:.3}"))
        .draw()?;
    let line = |of: fn(&EpochRecord) -> f64, colour: RGBColor| {
        let points: Vec<(f64, f64)> = curve.iter().map(|r| (r.epoch as f64, of(r))).collect();
        std::iter::once(PathElement::new(points, colour.stroke_width(2)))
    };
    chart
        .draw_series(line(|r| r.train_loss, TRAIN))?
        .label("training, with noise on the forces")
        .legend(|at| plot::key(at, TRAIN.stroke_width(2)));
    chart
        .draw_series(line(|r| r.validation_loss, VALIDATION))?
        .label("validation")
        .legend(|at| plot::key(at, VALIDATION.stroke_width(2)));
    let best = curve.iter().filter(|r| r.epoch == best_epoch);
    chart.draw_series(
        best.map(|r| Circle::new((r.epoch as f64, r.validation_loss), 5, VALIDATION.filled())),
    )?;
    plot::legend(&mut chart)?;
    area.present()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_an_svg_with_both_lines_and_none_is_an_error() {
        let record = |epoch: usize| EpochRecord {
            epoch,
            train_loss: 1.0 / epoch as f64,
            validation_loss: 1.2 / epoch as f64,
            learning_rate: 1e-3,
            wall_s: 1.0,
        };
        let text = svg("fdt", &[record(1), record(2), record(3)], 3).unwrap();
        assert!(text.starts_with("<svg") && text.matches("<polyline").count() >= 2, "{text}");
        assert!(text.contains("validation") && text.contains("<circle"));
        assert!(svg("fdt", &[], 0).is_err());
    }
}
