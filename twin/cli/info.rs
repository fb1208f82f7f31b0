//! `twin info`: lists the content of an MCAP file and its defects.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use twin_foreign::Survey;
use twin_foreign::opened::survey;
use twin_foreign::topics::Quantity;
use twin_record::Outputs;

use super::{End, print};

#[derive(Args)]
pub(super) struct InfoArgs {
    /// MCAP file; it may be cut off or damaged.
    file: PathBuf,
    /// Map from messages to quantities: a TOML file, or a shipped map (`acsl_x8`, `crazyflie`, `px4_arm`) [default: recognised].
    #[arg(long, value_name = "TOPICS.toml")]
    map: Option<String>,
    /// Print exactly one JSON object on stdout.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &InfoArgs) -> anyhow::Result<End> {
    let (survey, map, _) = survey(&args.file, args.map.as_deref())?;
    let sound = survey.container.complete && survey.container.problems.is_empty();
    print(&Outputs::default(), |out| {
        if args.json {
            let mut value = serde_json::to_value(&survey)?;
            value["file"] = args.file.display().to_string().into();
            value["vehicle"] = serde_json::to_value(&map.vehicle)?;
            writeln!(out, "{value}")?;
        } else {
            print_survey(out, args, &survey)?;
        }
        Ok(())
    })?;
    Ok(if sound { End::Passed } else { End::Failed })
}

fn print_survey(out: &mut dyn Write, args: &InfoArgs, survey: &Survey) -> io::Result<()> {
    let container = &survey.container;
    writeln!(
        out,
        "{}: {} messages in {:.2} s from {:.3} s; profile {:?}, written by {:?}, {} chunks ({}){}",
        args.file.display(),
        survey.messages,
        survey.duration_s,
        survey.start_s,
        container.profile,
        container.library,
        container.chunks,
        container.compressions.iter().cloned().collect::<Vec<_>>().join(", "),
        survey.family.map_or_else(String::new, |name| format!("; map {name}")),
    )?;
    let width = survey.channels.iter().map(|info| info.topic.len()).max().unwrap_or(0);
    for info in &survey.channels {
        let gives: Vec<String> = info.gives.iter().map(|quantity| word(*quantity)).collect();
        writeln!(
            out,
            "  {:width$} {:>7} {:>8.2} Hz  longest gap {:>7.3} s  {} {}{}{}",
            info.topic,
            info.messages,
            info.rate_hz,
            info.longest_gap_s,
            info.schema,
            info.encoding,
            if info.messages == 0 { "  EMPTY" } else { "" },
            if gives.is_empty() { String::new() } else { format!("  -> {}", gives.join(", ")) },
        )?;
    }
    for name in &survey.ambiguous_schemas {
        writeln!(
            out,
            "  schema {name} has more than one definition in this file; each channel uses its own"
        )?;
    }
    for problem in &container.problems {
        writeln!(out, "  PROBLEM: {problem}")?;
    }
    if container.more_problems > 0 {
        writeln!(out, "  PROBLEM: {} more", container.more_problems)?;
    }
    Ok(())
}

/// The name of a quantity in a map.
fn word(quantity: Quantity) -> String {
    serde_json::to_value(quantity)
        .ok()
        .and_then(|value| value.as_str().map(str::to_owned))
        .unwrap_or_default()
}
