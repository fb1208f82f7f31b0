//! The commands that wait for the flight, in their order. A later command replaces an earlier one that it makes void, and restarts keep a
//! least distance in time, so that a burst of them makes one flight and one recording.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::server::command::{Command, Request};
use crate::server::gains::Change;

/// Most commands that wait behind a restart.
const MOST_WAITING: usize = 1024;

/// Counts of commands since the server started.
#[derive(Default)]
pub(super) struct Tally {
    /// Flights that were started anew.
    pub restarts: AtomicU64,
    /// Commands that were dropped because a later one made them void.
    pub coalesced: AtomicU64,
}

/// The commands that wait.
pub(super) struct Agenda {
    waiting: VecDeque<Request>,
    restart_gap: Duration,
    /// The next restart happens no earlier.
    restart_due: Option<Instant>,
    tally: Arc<Tally>,
}

impl Agenda {
    /// Nothing waits; `restart_gap` is the least time between two restarts.
    pub(super) fn new(restart_gap: Duration, tally: Arc<Tally>) -> Self {
        Self { waiting: VecDeque::new(), restart_gap, restart_due: None, tally }
    }

    /// Adds a command; returns it if too many wait.
    pub(super) fn add(&mut self, mut request: Request) -> Option<Request> {
        let before = self.waiting.len();
        match &mut request.command {
            Command::Restart { seed, scenario } => {
                // A restart without a scenario keeps the scenario in use, and with it a seed that was asked for before.
                if let Some((earlier_seed, earlier_scenario)) = self.waiting_restart()
                    && scenario.is_none()
                {
                    *scenario = earlier_scenario;
                    *seed = seed.or(earlier_seed);
                }
                self.waiting.retain(|earlier| outlasts_restart(&earlier.command));
            }
            // The new gains stay in force through a seek; a step does not.
            Command::Seek(_) => self
                .waiting
                .retain(|earlier| !matches!(earlier.command, Command::Seek(_) | Command::Step(_))),
            Command::Change(Change::Gain(gain)) => {
                let name = gain.name().to_owned();
                if let Some(earlier) = self.waiting_gain(&name) {
                    *earlier = request;
                    self.tally.coalesced.fetch_add(1, Ordering::Relaxed);
                    return None;
                }
            }
            command => {
                if self.waiting.back().is_some_and(|last| last.command == *command) {
                    self.waiting.pop_back();
                }
            }
        }
        let void = before - self.waiting.len();
        self.tally.coalesced.fetch_add(void as u64, Ordering::Relaxed);
        if self.waiting.len() >= MOST_WAITING {
            return Some(request);
        }
        self.waiting.push_back(request);
        None
    }

    /// The change of the gain `name` that waits, if nothing but changes of gains follows it.
    fn waiting_gain(&mut self, name: &str) -> Option<&mut Request> {
        let gain = |request: &mut Request| match &request.command {
            Command::Change(Change::Gain(gain)) => Some(gain.name() == name),
            _ => None,
        };
        for earlier in self.waiting.iter_mut().rev() {
            if gain(earlier)? {
                return Some(earlier);
            }
        }
        None
    }

    /// Seed and scenario of the restart that waits.
    fn waiting_restart(&self) -> Option<(Option<u64>, Option<String>)> {
        self.waiting.iter().find_map(|earlier| match &earlier.command {
            Command::Restart { seed, scenario } => Some((*seed, scenario.clone())),
            _ => None,
        })
    }

    /// The next command to carry out at `now`; `None` if none waits, or if a restart waits for its time. Commands after this restart
    /// wait with it, because they are meant for the new flight.
    pub(super) fn next(&mut self, now: Instant) -> Option<Request> {
        if !self.patience(now)?.is_zero() {
            return None;
        }
        let request = self.waiting.pop_front()?;
        if matches!(request.command, Command::Restart { .. }) {
            self.restart_due = Some(now + self.restart_gap);
            self.tally.restarts.fetch_add(1, Ordering::Relaxed);
        }
        Some(request)
    }

    /// The time until the next command is due; `None` if none waits.
    pub(super) fn patience(&self, now: Instant) -> Option<Duration> {
        let first = self.waiting.front()?;
        let is_restart = matches!(first.command, Command::Restart { .. });
        let due = self.restart_due.filter(|_| is_restart);
        Some(due.map_or(Duration::ZERO, |due| due.saturating_duration_since(now)))
    }
}

/// Whether `command` still has an effect if a restart follows it.
fn outlasts_restart(command: &Command) -> bool {
    matches!(command, Command::Pause(_) | Command::Speed(_))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::gains;
    use crate::server::pace::now;
    use twin_core::control::Gains;
    use twin_core::residual::lra;
    use twin_core::tuning::Tuning;
    use twin_scenario::Preset;

    const GAP: Duration = Duration::from_secs(1);

    fn agenda() -> Agenda {
        Agenda::new(GAP, Arc::default())
    }

    fn restart(seed: Option<u64>, scenario: Option<&str>) -> Command {
        Command::Restart { seed, scenario: scenario.map(str::to_owned) }
    }

    fn gain(name: &str, value: f64) -> Command {
        let tuning =
            Tuning { gains: Gains::preset(Preset::Tuned), adapter: lra::Settings::default() };
        Command::Change(Change::Gain(gains::check(&tuning, name.to_owned(), value).unwrap()))
    }

    /// The commands that are carried out at `time`.
    fn done(agenda: &mut Agenda, time: Instant) -> Vec<Command> {
        std::iter::from_fn(|| agenda.next(time).map(|request| request.command)).collect()
    }

    fn add(agenda: &mut Agenda, commands: impl IntoIterator<Item = Command>) {
        for command in commands {
            assert!(agenda.add(Request { client: None, command }).is_none());
        }
    }

    #[test]
    fn a_burst_of_restarts_is_one_at_once_and_one_a_second_later_with_the_last_wish() {
        let (mut agenda, start) = (agenda(), now());
        add(&mut agenda, [restart(Some(1), None)]);
        assert_eq!(done(&mut agenda, start), [restart(Some(1), None)]);
        add(&mut agenda, (2..180).map(|seed| restart(Some(seed), None)));
        assert_eq!(done(&mut agenda, start), []);
        assert_eq!(agenda.patience(start), Some(GAP));
        assert_eq!(done(&mut agenda, start + GAP), [restart(Some(179), None)]);
        assert_eq!(agenda.tally.restarts.load(Ordering::Relaxed), 2);
        assert_eq!(agenda.tally.coalesced.load(Ordering::Relaxed), 177);
    }

    #[test]
    fn what_a_restart_makes_void_is_dropped_and_what_follows_it_waits_with_it() {
        let (mut agenda, start) = (agenda(), now());
        add(&mut agenda, [restart(None, None)]);
        done(&mut agenda, start);
        add(&mut agenda, [Command::Pause(true), gain("leak", 2.0), Command::Step(3)]);
        add(&mut agenda, [restart(None, None), gain("leak", 3.0), Command::Step(4)]);
        assert_eq!(done(&mut agenda, start), [Command::Pause(true)]);
        let after = [restart(None, None), gain("leak", 3.0), Command::Step(4)];
        assert_eq!(done(&mut agenda, start + GAP), after);
    }

    #[test]
    fn a_restart_that_names_nothing_keeps_what_the_one_before_named() {
        for (first, second, both) in [
            (restart(Some(4), None), restart(None, None), restart(Some(4), None)),
            (restart(Some(4), Some("a")), restart(None, None), restart(Some(4), Some("a"))),
            (restart(Some(4), Some("a")), restart(Some(5), None), restart(Some(5), Some("a"))),
            (restart(Some(4), None), restart(None, Some("b")), restart(None, Some("b"))),
        ] {
            let mut agenda = agenda();
            add(&mut agenda, [first, second]);
            assert_eq!(done(&mut agenda, now()), [both]);
        }
    }

    #[test]
    fn of_many_moves_of_sliders_the_last_of_each_counts_and_none_is_lost() {
        let mut agenda = agenda();
        let values: Vec<f64> = (0..500).map(|n| f64::from(n) / 100.0).collect();
        add(&mut agenda, values.iter().flat_map(|&v| [gain("slope.y", v), gain("slope.x", v)]));
        let last = *values.last().unwrap();
        assert_eq!(done(&mut agenda, now()), [gain("slope.y", last), gain("slope.x", last)]);
        // A preset between two values of a gain keeps both, because it sets all gains.
        let preset = Command::Change(Change::Preset(Preset::Paper));
        let all = [gain("slope.y", 1.0), preset, gain("slope.y", 2.0)];
        add(&mut agenda, all.clone());
        assert_eq!(done(&mut agenda, now()), all);
    }

    #[test]
    fn the_last_seek_is_flown_with_the_gains_before_it() {
        let mut agenda = agenda();
        add(&mut agenda, [Command::Seek(1.0), gain("leak", 2.0), Command::Step(1)]);
        add(&mut agenda, [Command::Seek(2.0), Command::Seek(3.0)]);
        assert_eq!(done(&mut agenda, now()), [gain("leak", 2.0), Command::Seek(3.0)]);
    }

    #[test]
    fn equal_commands_in_a_row_are_one_and_too_many_are_given_back() {
        let mut agenda = agenda();
        add(&mut agenda, [Command::Step(1), Command::Step(1), Command::Step(2)]);
        assert_eq!(done(&mut agenda, now()), [Command::Step(1), Command::Step(2)]);
        add(&mut agenda, (0..MOST_WAITING).map(|n| Command::Step(1 + n as u32 % 2)));
        let more = Request { client: None, command: Command::Speed(None) };
        assert!(agenda.add(more).is_some());
        assert_eq!(done(&mut agenda, now()).len(), MOST_WAITING);
    }
}
