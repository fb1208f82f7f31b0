//! A link whose packets arrive after a delay, late by a random time, or never.

use std::collections::VecDeque;

use rand::Rng;
use rand::RngExt;

use super::settings::LinkSettings;
use twin_core::elementary::ln;

/// Draws by how many steps a packet is late; `None` if it is lost.
pub(super) fn lateness(settings: &LinkSettings, dt_s: f64, rng: &mut impl Rng) -> Option<u64> {
    if !settings.on {
        return Some(0);
    }
    // Both are drawn always, so that the stream of random numbers does not depend on what they are.
    let (lost, late): (f64, f64) = (rng.random(), rng.random());
    let late_s = -settings.jitter_s * ln(1.0 - late);
    (lost >= settings.loss).then_some((late_s / dt_s).round() as u64)
}

/// Packets under way to an actuator, which holds the newest one that has arrived.
#[derive(Clone, Debug)]
pub(super) struct CommandLink<T> {
    delay_steps: u64,
    /// Step of arrival, number and content of each packet.
    under_way: VecDeque<(u64, T)>,
    held: T,
    step: u64,
}

impl<T: Clone> CommandLink<T> {
    /// A link with a smallest delay of `delay_s` in steps of `dt_s`; the actuator holds `initial`.
    pub(super) fn new(delay_s: f64, dt_s: f64, initial: T) -> Self {
        let delay_steps = (delay_s / dt_s).round().clamp(0.0, 1e4) as u64;
        Self { delay_steps, under_way: VecDeque::new(), held: initial, step: 0 }
    }

    /// Sends `packet`, late by `late` steps; `None` loses it. A packet that overtakes older ones makes them worthless.
    pub(super) fn send(&mut self, packet: T, late: Option<u64>) {
        let Some(late) = late else { return };
        let due = self.step + self.delay_steps + late;
        while self.under_way.back().is_some_and(|(older, _)| *older >= due) {
            self.under_way.pop_back();
        }
        self.under_way.push_back((due, packet));
    }

    /// Ends a step; returns what the actuator follows in it.
    pub(super) fn step(&mut self) -> T {
        while self.under_way.front().is_some_and(|(due, _)| *due <= self.step) {
            if let Some((_, packet)) = self.under_way.pop_front() {
                self.held = packet;
            }
        }
        self.step += 1;
        self.held.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    #[test]
    fn a_packet_waits_for_the_delay_and_an_older_one_never_replaces_a_newer_one() {
        let mut link = CommandLink::new(2e-3, 1e-3, 0);
        let mut followed = Vec::new();
        for (packet, late) in [(1, Some(0)), (2, Some(3)), (3, Some(0)), (4, None), (5, Some(0))] {
            link.send(packet, late);
            followed.push(link.step());
        }
        (0..4).for_each(|_| followed.push(link.step()));
        // Packet 2 would arrive after packet 3, so nobody takes it; packet 4 is lost.
        assert_eq!(followed, [0, 0, 1, 1, 3, 3, 5, 5, 5]);
    }

    #[test]
    fn packets_are_late_and_lost_as_often_as_the_settings_say() {
        let settings = LinkSettings { on: true, jitter_s: 0.004, loss: 0.1 };
        let mut rng = Pcg64::seed_from_u64(1);
        let draws: Vec<_> = (0..20_000).map(|_| lateness(&settings, 1e-3, &mut rng)).collect();
        let arrived: Vec<f64> = draws.iter().flatten().map(|late| *late as f64).collect();
        // Three standard errors of 20,000 draws.
        assert!((arrived.len() as f64 / 20_000.0 - 0.9).abs() < 0.0064);
        let mean = arrived.iter().sum::<f64>() / arrived.len() as f64;
        assert!((mean - 4.0).abs() < 0.09, "{mean}");
        let off = LinkSettings { on: false, ..settings };
        assert_eq!(lateness(&off, 1e-3, &mut rng), Some(0));
    }
}
