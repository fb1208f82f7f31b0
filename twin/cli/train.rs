//! `twin train`: trains a model of the residual.

#[cfg(feature = "train")]
mod one;

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use twin_core::residual::weights::ModelKind;
use twin_lab::learn::config::{Architecture, TrainConfig};
use twin_record::Outputs;
#[cfg(feature = "train")]
use twin_record::output::{Output, make_folder, note};

use super::{End, Overwrite, print};
#[cfg(feature = "train")]
use one::one;

const HELP: &str = "\
What it does: reads the flights, cuts them into windows of 1.2 s, and fits a model that forecasts the residual of the next
0, 10 … 250 ms. The last 15 % of each flight are held back; training ends when the loss there stops falling. Ticks in contact
are not learned from. The file that comes out flies: `twin fly --set predictor.kind=fdt --set predictor.weights=FILE`.

A forecast of the mean has a loss of about 1; R² is about 1 minus the loss. Ctrl+C loses only the present epoch: resume with --resume.
The same data, settings and seed give the same file on one machine.

Examples:
  twin collect && twin train                                        from nothing to the small FDT on two cores
  twin train out/data --seed 2 --out fdt_2.safetensors        another seed
  twin train out/data --config paper                          the paper's size: a night on two cores
  twin train out/data --config paper --device gpu             the same on a graphics processor
  twin train out/data --config mine.toml --epochs 10          own settings; `--print-config` shows every key
  twin train out/data --without long-memory                   an ablation, trained anew
  twin train out/data --architecture paper                    the network without its linear path
  twin train out/data --model lstm                            a baseline of the tables
  twin train out/data --model ridge                           the line of best fit, in closed form: seconds
  twin train out/data --all --out weights/                    the FDT and every baseline, into a folder";

#[derive(Args)]
#[command(after_help = HELP)]
#[allow(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
#[cfg_attr(not(feature = "train"), allow(dead_code, reason = "only training reads them"))]
pub(super) struct TrainArgs {
    /// Flights: recordings of this program, or real flights that `twin mirror` can read. A folder stands for its files
    /// `collect_*.mcap`, so that the test flight is never trained on.
    #[arg(default_value = "out/data")]
    data: Vec<PathBuf>,
    /// `small`, `paper`, or a TOML file that states only the keys that differ from the defaults.
    #[arg(long, default_value = "small", value_name = "small|paper|FILE.toml")]
    config: String,
    /// Model to train [default: the model of the configuration, the FDT].
    #[arg(long, value_parser = model_parser())]
    model: Option<ModelKind>,
    /// Train the FDT and every baseline, one after the other.
    #[arg(long, conflicts_with = "model")]
    all: bool,
    /// Architecture of the FDT: the paper's network, or the same with a linear path beside it that starts at the line of best fit
    /// [default: that of the configuration].
    #[arg(long, value_parser = architecture_parser(), value_name = "paper|skip")]
    architecture: Option<Architecture>,
    /// Leave a part of the FDT out (repeatable).
    #[arg(long, value_enum, value_name = "PART")]
    without: Vec<Part>,
    /// Most epochs [default: those of the configuration].
    #[arg(long)]
    epochs: Option<usize>,
    /// Seed of initialisation, order of the windows and noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// File of weights, or with `--all` their folder [default: out/weights/MODEL.safetensors]. The checkpoint goes beside it.
    #[arg(long, value_name = "W.safetensors")]
    out: Option<PathBuf>,
    /// Device: all cores, or a graphics processor through Vulkan (built with `--features gpu`).
    #[arg(long, value_enum, default_value = "cpu")]
    device: Where,
    /// Resume from the checkpoint beside the file of weights.
    #[arg(long)]
    resume: bool,
    /// Picture of the learning curve; `-` is stdout [default: beside the file of weights].
    #[arg(long, value_name = "C.svg", conflicts_with = "all")]
    curve: Option<PathBuf>,
    /// Print the settings in force as TOML and end.
    #[arg(long)]
    print_config: bool,
    /// Print exactly one JSON object on stdout.
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Device of a training.
#[derive(Clone, Copy, ValueEnum)]
enum Where {
    Cpu,
    Gpu,
}

/// Folder of the weights without `--out`.
const WEIGHTS: &str = "out/weights";

/// Parses the name of a model.
fn model_parser() -> impl TypedValueParser<Value = ModelKind> {
    PossibleValuesParser::new(ModelKind::ALL.map(ModelKind::name))
        .try_map(|word| ModelKind::named(&word).ok_or("no such model"))
}

/// Parses the name of an architecture.
fn architecture_parser() -> impl TypedValueParser<Value = Architecture> {
    let all = [Architecture::Paper, Architecture::Skip];
    PossibleValuesParser::new(all.map(Architecture::name)).try_map(move |word| {
        all.into_iter().find(|one| one.name() == word).ok_or("no such architecture")
    })
}

/// Part of the FDT that an ablation leaves out.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// The learned global token: the mean of the channels' tokens asks the memory.
    GlobalToken,
    /// The short-horizon encoder: a learned constant asks the memory.
    ShortHorizon,
    /// The long-horizon memory: the regime is computed from the short horizon.
    LongMemory,
}

impl Part {
    fn word(self) -> &'static str {
        match self {
            Self::GlobalToken => "global_token",
            Self::ShortHorizon => "short_horizon",
            Self::LongMemory => "long_memory",
        }
    }
}

/// One training of a command.
#[allow(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
#[cfg_attr(not(feature = "train"), allow(dead_code, reason = "only training reads them"))]
struct Job {
    config: TrainConfig,
    out: PathBuf,
    curve: PathBuf,
}

pub(super) fn run(args: &TrainArgs) -> anyhow::Result<End> {
    let jobs = jobs(args)?;
    if args.print_config {
        print(&Outputs::default(), |out| {
            for job in &jobs {
                writeln!(out, "{}", toml::to_string(&job.config)?)?;
            }
            Ok(())
        })?;
        return Ok(End::Passed);
    }
    train(args, &jobs)
}

#[cfg(not(feature = "train"))]
fn train(_: &TrainArgs, _: &[Job]) -> anyhow::Result<End> {
    anyhow::bail!(
        "this program was built without training; build it with `cargo build --release --features train` \
         (ten minutes of processor time the first time), then call target/release/twin again"
    )
}

fn jobs(args: &TrainArgs) -> anyhow::Result<Vec<Job>> {
    let base = TrainConfig::named(&args.config)?;
    let kinds = match (args.all, args.model) {
        (true, _) => ModelKind::ALL.to_vec(),
        (false, model) => vec![model.unwrap_or(base.model)],
    };
    let folder = args.all.then(|| args.out.clone().unwrap_or_else(|| WEIGHTS.into()));
    let job = |kind: ModelKind| -> anyhow::Result<Job> {
        let mut config = base.clone().of(kind);
        config.epochs = args.epochs.unwrap_or(config.epochs);
        config.architecture = args.architecture.unwrap_or(config.architecture);
        config.global_token &= !args.without.contains(&Part::GlobalToken);
        config.short_horizon &= !args.without.contains(&Part::ShortHorizon);
        config.long_memory &= !args.without.contains(&Part::LongMemory);
        config.check().map_err(|why| anyhow::anyhow!("{why}"))?;
        if kind != ModelKind::Fdt && !args.without.is_empty() {
            anyhow::bail!("--without takes parts of the FDT; {} has none of them", kind.name());
        }
        if kind != ModelKind::Fdt && !args.all && args.architecture.is_some() {
            anyhow::bail!("--architecture is of the FDT; {} has only one", kind.name());
        }
        let chosen = args.architecture.filter(|_| kind == ModelKind::Fdt);
        let named = chosen.map_or_else(String::new, |one| format!("_{}", one.name()));
        let stem = args.without.iter().fold(format!("{}{named}", kind.name()), |stem, part| {
            format!("{stem}_without_{}", part.word())
        });
        let file = format!("{stem}.safetensors");
        let out = match (&folder, &args.out) {
            (Some(folder), _) => folder.join(file),
            (None, Some(out)) => out.clone(),
            (None, None) => Path::new(WEIGHTS).join(file),
        };
        let curve = args.curve.clone().unwrap_or_else(|| out.with_extension("svg"));
        Ok(Job { config, out, curve })
    };
    kinds.into_iter().map(job).collect()
}

#[cfg(feature = "train")]
fn train(args: &TrainArgs, jobs: &[Job]) -> anyhow::Result<End> {
    use twin_lab::learn::{Dataset, device};
    let data = flights(&args.data)?;
    let outputs = args.overwrite.outputs_beside(&data, args.json)?;
    outputs.protect([&args.config]);
    device::choose(match args.device {
        Where::Cpu => device::DeviceKind::Cpu,
        Where::Gpu => device::DeviceKind::Gpu,
    })?;
    super::allocator::keep_memory();
    let data = Dataset::read(&data)?;
    note(format_args!(
        "{} flights, {} usable ticks of {}, {} channels, {} coordinates of the residual, data {}",
        data.flights.len(),
        data.usable_ticks(),
        data.flights.iter().map(twin_lab::learn::dataset::FlightSeries::ticks).sum::<usize>(),
        data.channel_names.len(),
        data.output_names.len(),
        &data.hash()[..12],
    ));
    if !data.left_out.is_empty() {
        note(format_args!(
            "left out because not every flight knows them: {}",
            data.left_out.join(", ")
        ));
    }
    let places = |job| places(&outputs, args.resume, job);
    let curves = jobs.iter().map(places).collect::<anyhow::Result<Vec<_>>>()?;
    let (results, stopped) = train_each(args, &data, jobs, curves)?;
    if args.json {
        let value = match (args.all, stopped) {
            (true, false) => serde_json::json!({ "models": results }),
            (true, true) => {
                serde_json::json!({ "verdict": twin_scenario::Verdict::Interrupted, "models": results })
            }
            (false, _) => results.into_iter().next().unwrap_or_default(),
        };
        print(&outputs, |out| Ok(writeln!(out, "{value}")?))?;
    }
    Ok(match twin_input::interruption::requested() {
        Some(signal) if stopped => End::Interrupted(signal),
        _ => End::Passed,
    })
}

/// Runs the trainings until one is stopped by a signal; returns their figures, and whether one was stopped.
#[cfg(feature = "train")]
fn train_each(
    args: &TrainArgs,
    data: &twin_lab::learn::Dataset,
    jobs: &[Job],
    curves: Vec<Output>,
) -> anyhow::Result<(Vec<serde_json::Value>, bool)> {
    let mut results = Vec::new();
    for (job, curve) in jobs.iter().zip(curves) {
        let result = one(args, data, job, curve)?;
        let stopped = result["verdict"].is_string();
        results.push(result);
        if stopped {
            return Ok((results, true));
        }
    }
    Ok((results, false))
}

/// Refuses places that the files of a training cannot have, before it begins. Returns the place of the curve.
#[cfg(feature = "train")]
fn places(outputs: &Outputs, resume: bool, job: &Job) -> anyhow::Result<Output> {
    use anyhow::Context;
    let checkpoint = twin_lab::learn::checkpoint::path_for(&job.out);
    if let Some(folder) = job.out.parent() {
        make_folder(folder, "--out")?;
    }
    outputs.may_write(&job.out, "--out")?;
    if !resume {
        outputs
            .may_write(&checkpoint, "--out")
            .context("the checkpoint of another training is there; --resume continues that one")?;
    }
    Ok(outputs.reserve_with_folder(&job.curve, "--curve")?)
}

/// The files as they are; for a folder, its `collect_*.mcap` in the order of their names.
#[cfg(feature = "train")]
fn flights(data: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut all = Vec::new();
    for path in data {
        if !path.is_dir() {
            all.push(path.clone());
            continue;
        }
        let mut inside: Vec<PathBuf> = std::fs::read_dir(path)?
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| {
                let stem = path.file_stem().map(|stem| stem.to_string_lossy());
                stem.is_some_and(|stem| stem.starts_with("collect_"))
                    && path.extension().is_some_and(|extension| extension == "mcap")
            })
            .collect();
        inside.sort();
        if inside.is_empty() {
            anyhow::bail!("{}: no collect_*.mcap in it; `twin collect` makes them", path.display());
        }
        all.extend(inside);
    }
    Ok(all)
}
