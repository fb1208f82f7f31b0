//! `--set` and `--fork-at` in the order in which they stand: a `--set` behind a `--fork-at` belongs to that fork.

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches, value_parser};
use twin_scenario::fork::Order;

/// The overrides of the flight, and its forks with theirs.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Orders {
    /// Overrides of the scenario, `key=value` each.
    pub(super) set: Vec<String>,
    /// Forks of the flight, in the order of the command line.
    pub(super) forks: Vec<Order>,
}

/// A flag with its place on the command line.
enum Flag {
    Set(String),
    ForkAt(f64),
}

impl FromArgMatches for Orders {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut flags: Vec<(usize, Flag)> = Vec::new();
        if let (Some(places), Some(values)) = (matches.indices_of("set"), matches.get_many("set")) {
            flags.extend(places.zip(values.cloned().map(Flag::Set)));
        }
        let times = (matches.indices_of("fork_at"), matches.get_many("fork_at"));
        if let (Some(places), Some(values)) = times {
            flags.extend(places.zip(values.copied().map(Flag::ForkAt)));
        }
        flags.sort_by_key(|(place, _)| *place);
        let mut orders = Self::default();
        for (_, flag) in flags {
            match (flag, orders.forks.last_mut()) {
                (Flag::ForkAt(at_s), _) if !at_s.is_finite() => {
                    let text =
                        format!("--fork-at {at_s}: expected a time of the flight in seconds");
                    return Err(Error::raw(ErrorKind::ValueValidation, text));
                }
                (Flag::ForkAt(at_s), _) => orders.forks.push(Order { at_s, set: Vec::new() }),
                (Flag::Set(set), Some(fork)) => fork.set.push(set),
                (Flag::Set(set), None) => orders.set.push(set),
            }
        }
        Ok(orders)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for Orders {
    fn augment_args(command: Command) -> Command {
        let set =
            Arg::new("set").long("set").value_name("KEY=VALUE").action(ArgAction::Append).help(
                "Override any key of the scenario, e.g. `--set gains.preset=paper` (repeatable)",
            );
        let fork_at = Arg::new("fork_at")
            .long("fork-at")
            .value_name("SECONDS")
            .action(ArgAction::Append)
            .value_parser(value_parser!(f64))
            .allow_negative_numbers(true)
            .requires("headless")
            .help(
                "Copy the flight at this time and fly the copy to its own end, too (with --headless; up to six). Each `--set` behind it \
                 changes that fork alone: gains, predictor, controller.kind, payload, wind, effects, more faults. The exit code is that \
                 of the flight itself",
            );
        command.arg(set).arg(fork_at)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(flags: &[&str]) -> Result<Orders, Error> {
        let headless = Arg::new("headless").long("headless").action(ArgAction::SetTrue);
        let command = Orders::augment_args(Command::new("twin").arg(headless));
        let flags = ["twin", "--headless"].into_iter().chain(flags.iter().copied());
        Orders::from_arg_matches(&command.try_get_matches_from(flags)?)
    }

    #[test]
    fn a_key_belongs_to_the_fork_before_it_and_to_the_scenario_before_any_fork() {
        let flags = ["--set", "a=1", "--fork-at", "2.5", "--set", "b=2", "--fork-at", "4"];
        let orders =
            read(&[&flags[..], &["--set", "c=3", "--set", "d=4"]].concat()).expect("valid");
        let fork =
            |at_s, set: &[&str]| Order { at_s, set: set.iter().map(|s| (*s).into()).collect() };
        assert_eq!(orders.set, ["a=1"]);
        assert_eq!(orders.forks, [fork(2.5, &["b=2"]), fork(4.0, &["c=3", "d=4"])]);
    }

    #[test]
    fn a_time_that_is_no_number_is_refused_and_a_negative_one_is_left_to_the_flight() {
        assert!(read(&["--fork-at", "nan"]).is_err());
        assert!(read(&["--fork-at", "soon"]).is_err());
        let early = read(&["--fork-at", "-1"]).expect("a number");
        assert_eq!(early.forks, [Order { at_s: -1.0, set: Vec::new() }]);
    }
}
