//! `/metrics` in the text format of Prometheus: the timing of the flight, the number of connected clients, and the recording.

use std::fmt::Write as _;

use crate::server::pace::{EDGES_MS, Lateness};
use crate::server::published::Published;
use twin_record::RecordingState;

/// Counts that the flight does not publish.
pub(super) struct Counts {
    /// Open TCP connections.
    pub connections: usize,
    /// Flights that were started anew.
    pub restarts: u64,
    /// Commands that a later one made void.
    pub coalesced: u64,
    /// Refusals by their label.
    pub refused: Vec<(&'static str, u64)>,
}

/// The text of `/metrics`; `uptime_s` is the time since the server started, s.
pub(super) fn text(published: &Published, uptime_s: f64, counts: &Counts) -> String {
    let state = &published.state;
    let mut text = String::new();
    let mut line = |kind: &str, name: &str, help: &str, values: &[(String, f64)]| {
        let _ = writeln!(text, "# HELP twin_{name} {help}\n# TYPE twin_{name} {kind}");
        for (labels, value) in values {
            let _ = writeln!(text, "twin_{name}{labels} {value}");
        }
    };
    let one = |value: f64| [(String::new(), value)];
    line("counter", "uptime_seconds", "Time since the server started.", &one(uptime_s));
    line("gauge", "clients", "Consoles and viewers connected.", &one(state.clients as f64));
    let connections = counts.connections as f64;
    line("gauge", "connections", "TCP connections open, of both ports.", &one(connections));
    line("counter", "restarts_total", "Flights started anew.", &one(counts.restarts as f64));
    let coalesced = one(counts.coalesced as f64);
    line("counter", "commands_coalesced_total", "Commands that a later one made void.", &coalesced);
    let refusal = |&(label, count): &(&str, u64)| (format!("{{reason=\"{label}\"}}"), count as f64);
    let refused: Vec<_> = counts.refused.iter().map(refusal).collect();
    line(
        "counter",
        "refused_total",
        "Requests and connections refused or ended, by reason.",
        &refused,
    );
    line("gauge", "ticks", "Ticks flown in this flight.", &one(state.tick as f64));
    let factor = state.real_time_factor;
    line("gauge", "real_time_factor", "Simulated seconds per second.", &one(factor));
    let stage = |(name, ms): (&str, f64)| (format!("{{stage=\"{name}\"}}"), ms / 1e3);
    let stages: Vec<_> = state.stages.iter().map(|s| stage((&s.name, s.ms))).collect();
    line("gauge", "stage_seconds", "Mean time of a stage of a tick.", &stages);
    if let Some(recording) = &state.recording {
        let states = [
            ("recording", RecordingState::Recording),
            ("finished", RecordingState::Finished),
            ("failed", RecordingState::Failed),
        ];
        let states = states.map(|(name, state)| {
            (format!("{{state=\"{name}\"}}"), f64::from(u8::from(recording.state == state)))
        });
        line("gauge", "recording_state", "1 for the state of the newest recording.", &states);
        let (bytes, ticks) = (one(recording.bytes as f64), one(recording.ticks as f64));
        line("gauge", "recording_bytes", "Bytes of the newest recording.", &bytes);
        line("gauge", "recording_ticks", "Ticks that are safe in the newest recording.", &ticks);
        let dropped = one(recording.dropped_ticks as f64);
        line("gauge", "recording_dropped_ticks", "Ticks that the newest recording lost.", &dropped);
    }
    histogram(&mut text, &published.lateness);
    text
}

fn histogram(text: &mut String, lateness: &Lateness) {
    let name = "twin_tick_lateness_seconds";
    let _ = writeln!(
        text,
        "# HELP {name} How late a tick began after its deadline.\n# TYPE {name} histogram"
    );
    let mut total = 0;
    let edges = EDGES_MS.iter().map(|ms| format!("{}", ms / 1e3)).chain(["+Inf".to_owned()]);
    for (edge, count) in edges.zip(lateness.counts) {
        total += count;
        let _ = writeln!(text, "{name}_bucket{{le=\"{edge}\"}} {total}");
    }
    let _ = writeln!(text, "{name}_sum {}\n{name}_count {total}", lateness.sum_s);
    let _ = writeln!(
        text,
        "# HELP twin_tick_lateness_max_seconds Latest start of a tick.\n# TYPE twin_tick_lateness_max_seconds gauge\n\
        twin_tick_lateness_max_seconds {}",
        lateness.max_s
    );
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn classes_add_up_and_an_edge_belongs_to_its_class() {
        let mut lateness = Lateness::default();
        for ms in [0.05, 0.1, 0.2, 30.0, 500.0] {
            lateness.count(Duration::from_secs_f64(ms / 1e3));
        }
        let mut text = String::new();
        histogram(&mut text, &lateness);
        let value = |line: &str| {
            let found = text.lines().find_map(|l| l.strip_prefix(line)).expect(line);
            found.trim().to_owned()
        };
        let bucket = |le: &str| value(&format!("twin_tick_lateness_seconds_bucket{{le=\"{le}\"}}"));
        assert_eq!([bucket("0.0001"), bucket("0.00025"), bucket("0.025")], ["2", "3", "3"]);
        assert_eq!([bucket("0.1"), bucket("+Inf")], ["4", "5"]);
        assert_eq!(value("twin_tick_lateness_seconds_count"), "5");
        let sum: f64 = value("twin_tick_lateness_seconds_sum").parse().expect("a number");
        // The tolerance is a few roundings of 0.53.
        assert!((sum - 0.53035).abs() < 1e-9);
        assert_eq!(value("twin_tick_lateness_max_seconds"), "0.5");
    }
}
