//! The channels of wind and force budget, which only a simulation knows.

use super::Builder;
use twin_core::force_budget::ForceBudget;
use twin_core::tick::Tick;

/// Names of the axes of the world.
const AXES: [&str; 3] = ["x", "y", "z"];

impl Builder {
    /// One channel for each axis of the wind.
    pub(super) fn world(&mut self) {
        for (axis, name) in ["wind.x", "wind.y", "wind.z"].into_iter().enumerate() {
            self.add("world", "m/s", name, &name.replace('.', " "), move |tick, _| {
                tick.truth.as_ref().map(|truth| truth.wind_in_world[axis])
            });
        }
    }

    /// One channel for each force and axis, then mass times acceleration and what no force explains.
    pub(super) fn forces(&mut self) {
        for (index, name) in ForceBudget::NAMES.iter().enumerate() {
            self.force(name, name, move |budget| budget.forces()[index]);
        }
        self.force("inertia", "mass times acceleration", |budget| budget.inertia);
        self.force("unexplained", "unexplained", |budget| budget.unexplained);
    }

    fn force(
        &mut self,
        name: &str,
        label: &str,
        take: impl Fn(&ForceBudget) -> nalgebra::Vector3<f64> + Copy + Send + Sync + 'static,
    ) {
        for (axis, letter) in AXES.iter().enumerate() {
            let info = self.add(
                "forces",
                "N",
                &format!("force.{name}.{letter}"),
                &format!("{label} {letter}"),
                move |tick, _| budget(tick).map(|budget| take(budget)[axis]),
            );
            info.row = Some((*letter).to_owned());
        }
    }
}

fn budget(tick: &Tick) -> Option<&ForceBudget> {
    tick.truth.as_ref()?.budget.as_ref()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{channels, value};
    use super::*;
    use nalgebra::Vector3;
    use twin_record::fixture;

    #[test]
    fn each_force_has_its_channels_and_they_are_unknown_without_a_budget() {
        let mut tick = fixture::tick(3);
        let channels = channels(4);
        assert!(value(&channels, &tick, "force.inflow.z").is_nan());
        let budget = ForceBudget {
            inertia: Vector3::new(0.5, 0.25, 1.5),
            thrust: Vector3::new(0.5, 0.0, 30.0),
            wake: Vector3::new(0.0, 0.25, -0.5),
            ..ForceBudget::default()
        };
        tick.truth.as_mut().expect("a simulation").budget = Some(budget.closed());
        for (name, wanted) in [
            ("force.thrust.z", 30.0_f32),
            ("force.wake.y", 0.25),
            ("force.push.x", 0.0),
            ("force.inertia.z", 1.5),
            ("force.unexplained.z", -28.0),
        ] {
            assert_eq!(value(&channels, &tick, name).to_bits(), wanted.to_bits(), "{name}");
        }
    }
}
