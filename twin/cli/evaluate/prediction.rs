//! `twin evaluate prediction`: the prediction table.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use twin_core::residual::REPORTED;
use twin_lab::evaluate::entrants::{Candidate, trained, unfilled, untrained, untrained_names};
use twin_lab::evaluate::fit::{Baseline, fit};
use twin_lab::evaluate::prediction::{COLUMNS, Column, MEASURES, SHOWN_MEASURES, rows, spreads};
use twin_lab::evaluate::{PredictionTable, Series, Statistics, prediction_page};
use twin_record::Outputs;
use twin_scenario::Scenario;

use super::output::{Output, write};
use crate::cli::{End, Overrides, print, read_weights};

#[derive(Args)]
pub(super) struct PredictionArgs {
    /// Recording that is replayed.
    #[arg(default_value = "out/data/test_300g.mcap")]
    recording: PathBuf,
    /// Folder of the training recordings `collect_*.mcap`. Their statistics z-score all errors; `sindy` and `gp` are fitted to them.
    #[arg(long, value_name = "DIR", default_value = "out/data")]
    train: PathBuf,
    /// Lines of the table, in order; each file of `--weights` adds its own.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "persistence,tdc_extrapolated,arx_rls,gravity,bias,random_features,sindy,gp"
    )]
    models: Vec<String>,
    /// File of weights; an FDT gives two lines, without and with the adapter (repeatable).
    #[arg(long, value_name = "FILE")]
    weights: Vec<PathBuf>,
    /// Folder for `sindy.safetensors` and `gp.safetensors`. Files that a fit would change are refused without --overwrite.
    #[arg(long, value_name = "DIR", default_value = "out/models")]
    models_dir: PathBuf,
    /// Scenario that gives the vehicle and the settings of the adapter.
    #[arg(long, value_name = "FILE", default_value = "scenarios/test_300g.toml")]
    scenario: PathBuf,
    #[command(flatten)]
    pub(super) output: Output,
    #[command(flatten)]
    overrides: Overrides,
}

pub(super) fn run(args: &PredictionArgs) -> anyhow::Result<End> {
    let bar = ProgressBar::new_spinner()
        .with_style(ProgressStyle::with_template("{elapsed_precise} {msg}")?);
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
    bar.set_message("reading recordings");
    let scenario = Scenario::load(&args.scenario, &args.overrides.set)?;
    let inputs = args.weights.iter().chain([&args.recording]).cloned();
    let places = args.output.reserve(inputs.chain(scenario.input_files()))?;
    let series = Series::read(&args.recording)
        .with_context(|| format!("record one: twin collect --out {}", args.train.display()))?;
    let training = Series::read_training(&args.train)?;
    places.outputs.protect(training.iter().map(|flight| &flight.file));
    series.compare(&training[0])?;
    let statistics = Statistics::of(&training);
    let data_hash = hash(&training);
    let candidates =
        candidates(args, &scenario, &places.outputs, (&training, &data_hash), &|name| {
            bar.set_message(format!("fitting {name}"));
        })?;
    bar.set_message("replaying");
    let rows = rows(candidates, &series, &statistics, &|name| {
        bar.set_message(format!("{name} replayed"));
    });
    bar.finish_and_clear();
    let table = PredictionTable {
        table: "prediction",
        command: super::command(),
        recording: series.file.clone(),
        recording_sha256: series.sha256.clone(),
        seed: series.seed.clone(),
        training: training.iter().map(|flight| flight.file.clone()).collect(),
        data_hash,
        statistics,
        spreads: spreads(&rows),
        rows,
    };
    let outputs = places.write(&table.sheet(), || Ok(prediction_page(&table, &series)))?;
    print(&outputs, |out| {
        if args.output.json {
            writeln!(out, "{}", serde_json::to_string(&table)?)?;
        } else {
            print_table(out, &table)?;
        }
        Ok(())
    })?;
    Ok(End::Passed)
}

/// One hash of all training recordings, over their hashes in order.
fn hash(training: &[Series]) -> String {
    use sha2::{Digest, Sha256};
    let mut hash = Sha256::new();
    for flight in training {
        hash.update(flight.sha256.as_bytes());
    }
    let bytes: Vec<String> = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    bytes.concat()
}

fn candidates(
    args: &PredictionArgs,
    scenario: &Scenario,
    outputs: &Outputs,
    (training, data_hash): (&[Series], &str),
    news: &dyn Fn(&str),
) -> anyhow::Result<Vec<Candidate>> {
    let tuning = scenario.tuning()?;
    let mut all = Vec::new();
    for name in &args.models {
        let baseline = match name.as_str() {
            "sindy" => Baseline::Sindy,
            "gp" => Baseline::Gp,
            name => {
                let row = untrained(name, &args.scenario, &args.overrides.set);
                let also = || {
                    format!("fitted here: sindy, gp; without fit: {}", untrained_names().join(", "))
                };
                all.push(row.with_context(also)?);
                continue;
            }
        };
        news(name);
        let weights = fit(baseline, training, data_hash)
            .with_context(|| format!("{name} cannot be fitted: too few ticks to learn from"))?;
        let file = args.models_dir.join(format!("{name}.safetensors"));
        let bytes = weights.to_bytes()?;
        // An equal fit is no new file.
        if !std::fs::read(&file).is_ok_and(|before| before == bytes) {
            write(outputs.reserve_with_folder(&file, "--models-dir")?, &bytes)?;
        }
        all.extend(trained(&weights, &file, &tuning)?);
    }
    for file in &args.weights {
        all.extend(trained(&read_weights(file)?, file, &tuning)?);
    }
    Ok(all)
}

/// For each of [`COLUMNS`], the number of blanks before it and its width in the terminal.
const PLACES: [(usize, usize); COLUMNS.len()] =
    [(2, 6), (1, 7), (2, 7), (1, 7), (2, 6), (1, 8), (2, 7), (1, 7)];

fn print_table(out: &mut dyn Write, table: &PredictionTable) -> io::Result<()> {
    let columns = || COLUMNS.into_iter().zip(PLACES);
    let heads: Vec<String> = columns()
        .map(|(column, (gap, width))| format!("{:gap$}{:>width$}", "", column.short))
        .collect();
    writeln!(
        out,
        "{:30} {:>8}{}   paper: RMSE    R²     ms",
        "a priori",
        "params",
        heads.concat()
    )?;
    for row in &table.rows {
        let figures: Vec<String> = columns()
            .map(|(Column { decimals, value, .. }, (gap, width))| {
                let text = text(value(&row.replayed), decimals);
                format!("{:gap$}{text:>width$}", "")
            })
            .collect();
        writeln!(
            out,
            "{:30} {:>8}{}   {}",
            row.label,
            row.parameters.map_or_else(|| "-".to_owned(), |n| n.to_string()),
            figures.concat(),
            row.paper.map_or_else(String::new, paper_cells),
        )?;
    }
    let filled: Vec<String> = table.rows.iter().map(|row| row.name.clone()).collect();
    for (name, figures) in unfilled(&filled) {
        writeln!(out, "{name:30} {:>86}   {}", "", paper_cells(figures))?;
    }
    print_horizons(out, table)?;
    writeln!(out, "\n{}", table.command)?;
    writeln!(
        out,
        "recording {} seed {} sha-256 {}",
        table.recording.display(),
        table.seed,
        table.recording_sha256
    )?;
    writeln!(
        out,
        "statistics of {} recordings in the training folder, hash {}",
        table.training.len(),
        table.data_hash
    )
}

fn print_horizons(out: &mut dyn Write, table: &PredictionTable) -> io::Result<()> {
    let shown = &MEASURES[..SHOWN_MEASURES];
    let heads = shown.iter().map(|(name, _)| {
        REPORTED.map(|j| format!("{:>8}", format!("j={j}"))).concat() + &format!("  {name}")
    });
    writeln!(out, "\n{:26}{}", "by horizon", heads.collect::<String>())?;
    for row in &table.rows {
        let cells = shown.iter().map(|(name, value)| {
            let cell = |j| format!("{:>8}", text(row.replayed.at(j).map(value), 3));
            REPORTED.map(cell).concat() + &" ".repeat(2 + name.chars().count())
        });
        writeln!(out, "{:26}{}", row.name, cells.collect::<String>().trim_end())?;
    }
    for s in &table.spreads {
        let pair = |[mean, std]: [f64; 2]| format!("{mean:.3} ± {std:.3}");
        writeln!(out, "{} over {} trainings:", s.name, s.trainings)?;
        for at in &s.horizons {
            writeln!(out, "  j={}: RMSE {}, R² {}", at.j, pair(at.rmse_z), pair(at.r2))?;
        }
    }
    Ok(())
}

/// The figure, or a dash where there is none.
fn text(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
}

fn paper_cells([rmse, r2, ms]: [f64; 3]) -> String {
    format!("{rmse:11.3} {r2:6.3} {ms:6.2}")
}
