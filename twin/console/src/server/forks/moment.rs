//! The served flight with everything that has to be copied with it.

use crate::server::served_flight::ServedFlight;
use crate::server::world::World;
use twin_core::flight::Flight;
use twin_core::flight::snapshots::{Change, Moment as Copied};
use twin_core::notation::TICK_S;
use twin_core::tick::Tick;
use twin_scenario::{Judge, Scenario, Verdict};

/// A moment of a served flight.
#[derive(Clone)]
pub(in crate::server) struct Moment {
    flight: Flight,
    judge: Judge,
    world: World,
}

impl Moment {
    /// The present moment of `served`.
    pub(super) fn of(served: &ServedFlight) -> Self {
        let ServedFlight { flight, judge, world, .. } = served;
        Self { flight: flight.clone(), judge: judge.clone(), world: world.clone() }
    }

    /// Flies a tick; the second result is the verdict and its sentence once the flight is over.
    pub(super) fn fly(&mut self) -> (Tick, Option<(Verdict, String)>) {
        let tick = self.flight.tick();
        self.world.advance(tick.measurement.t_s);
        let end = self.judge.watch(&tick);
        (tick, end)
    }

    /// The flight, to alter it.
    pub(super) fn flight_mut(&mut self) -> &mut Flight {
        &mut self.flight
    }

    /// Eigenvalues of the adapter's covariance, largest first.
    pub(super) fn spectrum(&self) -> Vec<f64> {
        self.flight.covariance_spectrum()
    }

    /// `scenario` as it stands at this moment: with the gains and the world in force.
    pub(super) fn in_force(&self, scenario: &Scenario) -> Scenario {
        let mut settings = scenario.settings.clone();
        self.world.put_into(&mut settings);
        let now_s = self.flight.index() as f64 * TICK_S;
        settings.changes.retain(|change| change.at_s > now_s);
        Scenario { settings, ..scenario.clone() }.with_gains(self.flight.tuning())
    }
}

impl Copied for Moment {
    fn flight(&self) -> &Flight {
        &self.flight
    }

    fn tick(&mut self) {
        self.fly();
    }

    fn take(&mut self, change: &Change) {
        if let Change::Disturb(disturbance) | Change::Prolong(disturbance) = change {
            self.world.change(disturbance);
        }
        self.flight.take(change);
    }
}
