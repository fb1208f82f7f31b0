//! Commands and their flags.

mod check;
mod evaluate;
mod fly;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

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
  twin evaluate tracking --seeds 10             the tracking table beside the paper's
  twin check scenarios/*.toml urdf/*.urdf       are these files usable?";

#[derive(Subcommand)]
enum Command {
    /// Fly one scenario: live in the browser, or headless to a verdict.
    Fly(fly::FlyArgs),
    /// Tables of the paper, measured on the twin.
    Evaluate(evaluate::EvaluateArgs),
    /// Read scenario and URDF files and say whether they are usable.
    Check(check::CheckArgs),
}

/// What every command that reads a scenario takes.
#[derive(Args, Clone)]
struct Overrides {
    /// Override any key of the scenario, e.g. `--set gains.preset=paper` (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// How a command ended.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Passed,
    Failed,
}

pub(crate) fn main() -> ExitCode {
    let cli = Cli::parse();
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_target(false)
        .with_env_filter(tracing_subscriber::EnvFilter::new("warn,twin=info"))
        .init();
    let result = match cli.command {
        Some(Command::Fly(args)) => fly::run(&args),
        None => fly::run(&cli.fly),
        Some(Command::Evaluate(args)) => Ok(evaluate::run(&args)),
        Some(Command::Check(args)) => Ok(check::run(&args)),
    };
    match result {
        Ok(End::Passed) => ExitCode::SUCCESS,
        Ok(End::Failed) => ExitCode::from(1),
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// The scenario that is flown when none is named.
fn default_scenario() -> PathBuf {
    PathBuf::from("scenarios/a_300g_slow.toml")
}
