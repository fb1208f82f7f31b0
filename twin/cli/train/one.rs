//! One training: its progress, its picture and its figures.

use twin_lab::learn::config::TrainConfig;
use twin_record::output::{Output, note};

use super::{Job, TrainArgs};
use crate::cli::print;

/// Runs one training; a bar shows its steps, and a line each finished epoch.
fn train_with_bar(
    data: &twin_lab::learn::Dataset,
    request: &twin_lab::learn::train::Request<'_>,
) -> anyhow::Result<twin_lab::learn::train::Outcome> {
    use twin_input::interruption;
    use twin_lab::learn::train::{Progress, train};
    let (bar, mut words) = (bar(request.config), String::new());
    let mut observe = |progress: Progress| {
        let per_epoch = progress.steps.1 as u64;
        if let Some(record) = progress.finished {
            let line = format!("validation {:.5}", record.validation_loss);
            bar.suspend(|| {
                note(format_args!(
                    "epoch {:>3}  training {:.5}  {line}  rate {:.1e}  {:.1} s",
                    record.epoch, record.train_loss, record.learning_rate, record.wall_s
                ));
            });
            words = line;
        } else {
            bar.set_length(per_epoch * request.config.epochs as u64);
            bar.set_position((progress.epoch as u64 - 1) * per_epoch + progress.steps.0 as u64);
            bar.set_message(format!("loss {:.4}  {words}", progress.loss));
        }
        match interruption::requested() {
            None => std::ops::ControlFlow::Continue(()),
            Some(_) => std::ops::ControlFlow::Break(()),
        }
    };
    let outcome = train(data, request, &mut observe)?;
    bar.finish_and_clear();
    Ok(outcome)
}

/// Runs one training with its progress bar, picture and messages; returns its figures as JSON.
pub(super) fn one(
    args: &TrainArgs,
    data: &twin_lab::learn::Dataset,
    job: &Job,
    curve: Output,
) -> anyhow::Result<serde_json::Value> {
    let outputs = curve.outputs().clone();
    let request = twin_lab::learn::train::Request {
        config: &job.config,
        seed: args.seed,
        resume: args.resume,
        out: &job.out,
        outputs: &outputs,
        git: twin_record::program::commit(),
    };
    let outcome = train_with_bar(data, &request)?;
    if !outcome.finished {
        return Ok(interrupted(job, &outcome));
    }
    let training = &outcome.head.training;
    let title = format!(
        "{}, {} parameters, seed {}, data {}",
        outcome.head.model,
        outcome.parameters,
        args.seed,
        &outcome.head.data_hash[..12]
    );
    let picture =
        twin_lab::learn::curve::svg(&title, &outcome.curve, training.best_epoch as usize)?;
    curve.write(picture.as_bytes())?;
    let validation = training.validation_loss.unwrap_or(f64::NAN);
    let r2 = 1.0 - validation / outcome.validation_variance;
    let ridge =
        training.ridge_penalty.map_or_else(String::new, |weight| format!(", ridge {weight:.0e}"));
    if !args.json {
        print(&outputs, |out| {
            Ok(writeln!(
                out,
                "{}: {} epochs, the best is {}; validation loss {validation:.5} (forecast of the mean: {:.4}), R² {r2:.4}{ridge}; {:.1} min; curve {}",
                job.out.display(),
                training.epochs,
                training.best_epoch,
                outcome.validation_variance,
                training.wall_s / 60.0,
                job.curve.display(),
            )?)
        })?;
    }
    Ok(serde_json::json!({
        "out": job.out,
        "curve_picture": job.curve,
        "model": outcome.head.model,
        "parameters": outcome.parameters,
        "training_windows": outcome.windows.0,
        "validation_windows": outcome.windows.1,
        "validation_variance": outcome.validation_variance,
        "validation_r2": r2,
        "data_hash": outcome.head.data_hash,
        "git": outcome.head.git,
        "seed": args.seed,
        "training": training,
        "regime_scale": outcome.head.normalisation.regime_scale,
        "settings": job.config,
        "curve": outcome.curve,
    }))
}

fn bar(config: &TrainConfig) -> indicatif::ProgressBar {
    use indicatif::{ProgressBar, ProgressStyle};
    ProgressBar::new(config.epochs as u64).with_prefix(config.model.name()).with_style(
        ProgressStyle::with_template(
            "{elapsed_precise} {prefix} [{wide_bar}] {pos}/{len} steps, {eta} left  {msg}",
        )
        .unwrap_or_else(|_| ProgressStyle::default_bar()),
    )
}

/// The figures of a training that a signal stopped. Its checkpoint holds the finished epochs; weights and picture are not written.
fn interrupted(job: &Job, outcome: &twin_lab::learn::train::Outcome) -> serde_json::Value {
    let checkpoint = twin_lab::learn::checkpoint::path_for(&job.out);
    let epochs = outcome.curve.last().map_or(0, |record| record.epoch);
    if outcome.curve.is_empty() {
        note(format_args!("{}: stopped before the first epoch was finished", job.out.display()));
    } else {
        note(format_args!(
            "{}: stopped after {epochs} epochs; --resume goes on from {}",
            job.out.display(),
            checkpoint.display()
        ));
    }
    serde_json::json!({
        "verdict": twin_scenario::Verdict::Interrupted,
        "out": job.out,
        "checkpoint": (!outcome.curve.is_empty()).then_some(checkpoint),
        "model": outcome.head.model,
        "epochs": epochs,
        "curve": outcome.curve,
    })
}
