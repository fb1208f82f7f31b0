//! A flag of the autopilot over time, such as "landed": it holds until the next message.

/// Longest time for which a message holds, s. Autopilots send these flags once a second or more often.
const HOLDS_S: f64 = 3.0;

/// Values of a flag in order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flags {
    values: Vec<(f64, bool)>,
}

impl Flags {
    /// A flag from times in s and numbers, of which those above one half are true. Samples that run backwards are left out.
    pub fn new(samples: impl Iterator<Item = (f64, f64)>) -> Self {
        let mut values: Vec<(f64, bool)> = Vec::new();
        for (t_s, value) in samples.filter(|(t_s, value)| t_s.is_finite() && value.is_finite()) {
            if values.last().is_none_or(|(last_s, _)| t_s >= *last_s) {
                values.push((t_s, value > 0.5));
            }
        }
        Self { values }
    }

    /// The flag at `t_s`; `None` before the first message, and long after a message.
    pub fn at(&self, t_s: f64) -> Option<bool> {
        let after = self.values.partition_point(|(at_s, _)| *at_s <= t_s);
        let (at_s, value) = *self.values.get(after.checked_sub(1)?)?;
        (t_s - at_s <= HOLDS_S).then_some(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flag_holds_until_the_next_message_and_not_for_ever() {
        let flags = Flags::new([(1.0, 1.0), (2.0, 0.0), (1.5, 1.0), (3.0, f64::NAN)].into_iter());
        assert_eq!(flags.at(0.5), None);
        assert_eq!(flags.at(1.9), Some(true));
        assert_eq!(flags.at(4.0), Some(false));
        assert_eq!(flags.at(6.0), None);
    }
}
