//! The commands and their flags.

mod signals;
mod viewers;
mod orders;
mod fly;
mod forked;
mod mirror_beside;
mod mirror_report;
mod mirror;
mod test_table;
mod test;
mod check;
mod info;
mod acceptance;
mod evaluate;
mod train;
mod collect;
mod diff;
mod compare;
mod recover;
mod export_csv;
mod export_html;
mod export_viewers;

#[cfg(feature = "train")]
mod allocator;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use clap::{Args, Parser, Subcommand};
use twin_core::residual::weights::Weights;
use twin_input::budget::WEIGHTS_BYTES;
use twin_input::interruption::{self, Signal};
use twin_record::output::{Output, OutputError, Outputs, note};
use twin_scenario::Verdict;

/// Digital twin of an aerial manipulator: contacts, residual learning, adaptive control, live console.
#[derive(Parser)]
#[command(name = "twin", version, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    fly: fly::FlyArgs,
}

const EXAMPLES: &str = "Examples:
  twin                                          the default scenario in the console at http://127.0.0.1:8080
  twin fly scenarios/b_500g_fast.toml           another scenario, live
  twin fly scenarios/a_300g_slow.toml --headless --json --record flight.mcap
  twin fly scenarios/hover.toml --headless --set gains.preset=paper --set wind.velocity_m_s=[3,0,0]
  twin fly scenarios/hover.toml --headless --fork-at 4 --set payload.mass_kg=0.3    what if, from an instant on
  twin collect --out data                       flights to learn from: 0, 200, 400 g, and the 300 g test flight
  twin evaluate tracking --seeds 10             the tracking table beside the paper's
  twin test scenarios --junit out/j.xml         every scenario as a test: bounds, events, verdicts
  twin diff a.mcap b.mcap                       where two recorded flights differ
  twin compare a.mcap b.mcap --html ab.html     metrics, curves and settings of flights side by side
  twin export html flight.mcap                  one page of a recorded flight, for any browser
  twin export viser flight.mcap -o flight.viser the flight for viser; `twin export meshcat` for MeshCat
  twin mirror flight.mcap --headless --json     a real flight through the loop in shadow
  twin export csv flight.mcap -o flight.csv     ticks, residuals and predictions as CSV; `-o -` is stdout
  twin info flight.mcap                         what a recording holds, and what is wrong with it
  twin recover cut.mcap -o whole.mcap           everything readable of a damaged or unfinished recording
  twin check scenarios/*.toml urdf/*.urdf       are these files usable?
  twin train flights/*.mcap                     the residual's model from recorded flights
  twin viewers fetch                            the stock viewers, for /meshcat/ and /viser

Every input is a regular file: pipes, devices and standard input are not read. What a file may hold has limits, which errors name.

Exit code 0: as expected; 1: not as expected, or a recording failed although the flight went on; 2: unusable input; 128 + signal:
interrupted by SIGINT (Ctrl+C), SIGTERM or SIGHUP. An interrupted command finishes its recordings, and --json prints its object with
the verdict `interrupted`; a second SIGINT or SIGTERM ends the program at once.";

#[derive(Subcommand)]
enum Command {
    /// Fly one scenario: live in the browser, or headless to a verdict.
    Fly(fly::FlyArgs),
    /// Fly and record the flights that a residual is learned from, and the one it is tested on.
    Collect(collect::CollectArgs),
    /// Tables of the paper, measured on the twin.
    Evaluate(evaluate::EvaluateArgs),
    /// Fly scenarios as tests, side by side. Exit code 0: all as expected, 1: some failed, 2: some could not run.
    Test(test::TestArgs),
    /// Compare two recordings: the first tick and channel that differ, and the largest differences.
    Diff(diff::DiffArgs),
    /// Compare two to six recordings: metrics, signals and settings side by side, aligned in time.
    Compare(compare::CompareArgs),
    /// Mirror a real flight: read it from MCAP and run the loop beside it in shadow, which predicts and adapts but never acts.
    Mirror(mirror::MirrorArgs),
    /// List the content of an MCAP file and its defects.
    Info(info::InfoArgs),
    /// Salvage a recording that was cut off, never finished, or damaged: everything that can be read, as a finished file.
    Recover(recover::RecoverArgs),
    /// Export a recording to another format.
    #[command(subcommand)]
    Export(Export),
    /// Read scenarios, URDF files and trained weights, and say whether they can be used.
    Check(check::CheckArgs),
    /// Train a model of the residual on recorded flights: the FDT, its ablations and the baselines (feature `train`).
    Train(train::TrainArgs),
    /// Install the stock MeshCat and viser viewers, which are served at /meshcat/ and /viser.
    Viewers(viewers::ViewersArgs),
}

/// Formats that a recording can be exported to.
#[derive(Subcommand)]
enum Export {
    /// One page that opens offline: 3-D view, charts, events.
    Html(export_html::HtmlArgs),
    /// One page that plays the flight in MeshCat's viewer.
    Meshcat(export_viewers::MeshcatArgs),
    /// viser's recording of the flight, or a page with viser's client that plays it.
    Viser(export_viewers::ViserArgs),
    /// One line for each tick: measurement, residual, predictions, resets.
    Csv(export_csv::CsvArgs),
}

/// The flags of every command that reads a scenario.
#[derive(Args, Clone)]
struct Overrides {
    /// Override any key of the scenario, e.g. `--set gains.preset=paper` (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// The flag of every command that writes files.
#[derive(Args, Clone)]
struct Overwrite {
    /// Replace output files that exist. Without it the command refuses them, and a recording takes the next free number.
    #[arg(long)]
    overwrite: bool,
}

impl Overwrite {
    /// The outputs of this run.
    fn outputs(&self) -> Outputs {
        Outputs::new(self.overwrite)
    }

    /// The outputs of a run that reads `inputs`, and with `json` prints its object on stdout.
    fn outputs_beside<P: AsRef<Path>>(
        &self,
        inputs: impl IntoIterator<Item = P>,
        json: bool,
    ) -> anyhow::Result<Outputs> {
        let outputs = self.outputs();
        outputs.protect(inputs);
        if json {
            outputs.reserve_stdout("--json")?;
        }
        Ok(outputs)
    }
}

/// Reserves the place of the report that `flag` names, if it names one.
fn place(
    outputs: &Outputs,
    path: Option<&Path>,
    flag: &'static str,
) -> anyhow::Result<Option<Output>> {
    Ok(path.map(|path| outputs.reserve_with_folder(path, flag)).transpose()?)
}

/// The outcome of a command, which determines its exit code.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Passed,
    Failed,
    Unusable,
    /// A signal ended the command before its work was done; its files are finished.
    Interrupted(Signal),
}

impl Command {
    /// Whether the command may have files to finish when a signal arrives. Any other command ends at once, as the system does it.
    fn writes(&self) -> bool {
        !matches!(self, Self::Diff(_) | Self::Info(_) | Self::Check(_) | Self::Viewers(_))
    }

    /// Whether stdout is to hold one JSON object, also if a signal arrives before there is anything to report.
    fn prints_json(&self) -> bool {
        match self {
            Self::Fly(args) => args.json,
            Self::Collect(args) => args.json,
            Self::Evaluate(args) => args.prints_json(),
            Self::Test(args) => args.prints_json(),
            Self::Mirror(args) => args.json,
            Self::Train(args) => args.json,
            Self::Recover(args) => args.json,
            Self::Compare(args) => args.json,
            Self::Diff(_) | Self::Info(_) | Self::Check(_) | Self::Viewers(_) | Self::Export(_) => {
                false
            }
        }
    }
}

pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_target(false)
        // A log line that a full stderr does not take is lost; reporting that on stderr would panic.
        .log_internal_errors(false)
        .with_env_filter(tracing_subscriber::EnvFilter::new("warn,twin=info"))
        .init();
    let command = cli.command.unwrap_or(Command::Fly(cli.fly));
    match run(&command) {
        Ok(End::Passed) => ExitCode::SUCCESS,
        Ok(End::Failed) => ExitCode::from(1),
        Ok(End::Unusable) => ExitCode::from(2),
        Ok(End::Interrupted(signal)) => {
            note(format_args!("interrupted by {signal}"));
            ExitCode::from(signal.exit_code())
        }
        // A command that a signal stopped before it had anything to report.
        Err(error) if let Some(signal) = interruption::requested() => {
            note(format_args!("error: {}", sentence(&error)));
            if command.prints_json() {
                let found = serde_json::json!({ "verdict": Verdict::Interrupted, "reason": signal.to_string() });
                // The signal decides the exit code, whether stdout takes the object or not.
                let _ = print(&Outputs::default(), |out| Ok(writeln!(out, "{found}")?));
            }
            ExitCode::from(signal.exit_code())
        }
        Err(error) => {
            note(format_args!("error: {}", sentence(&error)));
            ExitCode::from(if is_failed_write(&error) { 1 } else { 2 })
        }
    }
}

fn run(command: &Command) -> anyhow::Result<End> {
    if command.writes() {
        signals::catch()?;
    }
    match command {
        Command::Fly(args) if args.orders.forks.is_empty() => fly::run(args),
        Command::Fly(args) => forked::run(args),
        Command::Collect(args) => collect::run(args),
        Command::Evaluate(args) => evaluate::run(args),
        Command::Test(args) => test::run_tests(args),
        Command::Diff(args) => diff::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Mirror(args) => mirror::run(args),
        Command::Info(args) => info::run(args),
        Command::Export(Export::Html(args)) => export_html::run(args),
        Command::Export(Export::Meshcat(args)) => export_viewers::meshcat(args),
        Command::Export(Export::Viser(args)) => export_viewers::viser(args),
        Command::Export(Export::Csv(args)) => export_csv::run(args),
        Command::Recover(args) => recover::run(args),
        Command::Check(args) => check::run(args),
        Command::Train(args) => train::run(args),
        Command::Viewers(args) => viewers::run(args),
    }
}

/// The error followed by its causes; a cause that the text already contains is left out.
fn sentence(error: &anyhow::Error) -> String {
    error.chain().skip(1).fold(error.to_string(), |said, cause| {
        let cause = cause.to_string();
        if said.contains(&cause) { said } else { format!("{said}: {cause}") }
    })
}

/// Whether an output could not be written to its end, such as on a full disk. That is a failure; every other error is an unusable input.
fn is_failed_write(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        let io = cause.downcast_ref::<std::io::Error>().and_then(std::io::Error::get_ref);
        let inner = io.and_then(|inner| inner.downcast_ref::<OutputError>());
        cause.downcast_ref().or(inner).is_some_and(OutputError::is_failed_write)
    })
}

/// Prints the results of a command on stdout, or on stderr if one of its outputs has taken stdout.
fn print(
    outputs: &Outputs,
    write: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut out = outputs.results();
    write(&mut out)?;
    Ok(out.flush()?)
}

/// Reads the weights in `file`.
fn read_weights(file: &Path) -> anyhow::Result<Weights> {
    let bytes = twin_input::file::read(file, WEIGHTS_BYTES).with_context(|| {
        format!("{}: cannot be read; make weights with `twin train`", file.display())
    })?;
    Weights::from_bytes(&bytes).with_context(|| file.display().to_string())
}

/// The scenario that is flown when the command line names none.
fn default_scenario() -> PathBuf {
    PathBuf::from("scenarios/a_300g_slow.toml")
}
