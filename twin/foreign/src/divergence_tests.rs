use super::super::divergence_report::Light;
use super::*;
use crate::Effort;
use crate::recorded::{Derivation, RecordedFlight, RecordedTick};
use twin_core::elementary::{cos, sin, squared};
use twin_core::notation::N;

const MASS_KG: f64 = 2.0;
const INERTIA_KG_M2: f64 = 0.02;
const DRIVE_RAD_S: f64 = 3.0;

/// A synthetic flight on a circle with a slow roll motion. The recorded force is `overstated` times the force that explains the
/// motion, and a constant side force acts besides. No filter `H` is applied: a slow signal only gets later in it, so the recorded command
/// is the command of `delay_s` earlier.
fn flight(overstated: f64, torque: bool, delay_s: f64) -> RecordedFlight {
    let side = Vector3::new(1.0, 0.0, 0.0);
    let times_s: Vec<f64> = (0..600).map(|i| f64::from(i) * TICK_S).collect();
    let instant = |t_s: f64| {
        let at = |t: f64| DRIVE_RAD_S * t;
        let chi = [cos(at(t_s)), sin(at(t_s)), 1.0, 0.1 * sin(at(t_s)), 0.0, 0.0];
        let late = at(t_s - delay_s);
        let a = Vector3::new(-cos(late), -sin(late), 0.0) * squared(DRIVE_RAD_S);
        let force = (a + Vector3::z() * GRAVITY_M_S2) * MASS_KG * overstated - side;
        let turn = -0.1 * sin(late) * squared(DRIVE_RAD_S);
        let mut made = RecordedTick::default();
        for row in 0..AXES {
            made.chi[row] = Some(chi[row]);
            made.chi_dot[row] = Some(0.0);
            made.chi_ddot[row] = Some(match row {
                0..3 => a[row],
                3 => turn,
                _ => 0.0,
            });
            let moment = if row == 3 { INERTIA_KG_M2 * turn } else { 0.0 };
            made.tau[row] = if row < 3 { Some(force[row]) } else { torque.then_some(moment) };
        }
        made
    };
    RecordedFlight {
        instants: times_s.iter().map(|t_s| instant(*t_s)).collect(),
        airborne: vec![true; times_s.len()],
        times_s,
        effort: Effort::Recorded,
        mass_kg: MASS_KG,
        acceleration: [Derivation::MeasuredRate; 2],
        spans: Vec::new(),
        yardsticks: crate::phases::Yardsticks::default(),
        nominal_inertia: None,
        joint_names: Vec::new(),
    }
}

fn flyer(recorded: &RecordedFlight) -> Flyer {
    let inertial = Inertial {
        mass_kg: MASS_KG,
        com_in_link: Vector3::zeros(),
        inertia_in_link: Matrix3::identity() * INERTIA_KG_M2,
    };
    assert_eq!(recorded.instants[0].chi.len(), N);
    Flyer {
        playback: Arc::new(Playback::whole(recorded)),
        twin: Twin { form: Form::Body(inertial), says: "made".to_owned() },
        delay_ticks: PASS_TICKS,
        own_attitude: true,
        of_kg: None,
    }
}

/// Error of a slope over 80 ms of a motion at 3 rad/s, from its third derivative: `27 * 0.04² * 0.6 / 6` = 4 mm/s.
const OF_THE_SLOPE: f64 = 0.012;

#[test]
fn a_twin_that_is_the_vehicle_goes_where_it_went_but_for_what_pushes_it() {
    for torque in [false, true] {
        let recorded = flight(1.0, torque, PASS_TICKS * TICK_S);
        let shot = flyer(&recorded).from(200).expect("all is known");
        assert_eq!(shot.free, torque);
        for (i, ticks) in HORIZONS.iter().enumerate() {
            let t_s = *ticks as f64 * TICK_S;
            let [x, y, z, phi, ..] = shot.after[i];
            // No command contains the side force of 1 N: without the residual the twin misses by `t² / 2m`, with it by nothing.
            let missed = -0.5 * t_s * t_s / MASS_KG;
            let near = |found: Option<f64>, wanted: f64| {
                let found = found.expect("compared");
                assert!((found - wanted).abs() < OF_THE_SLOPE, "{t_s}: {found} {wanted}");
            };
            near(x.twin, missed);
            near(x.with_residual, 0.0);
            near(y.twin, 0.0);
            near(z.twin, 0.0);
            if torque { near(phi.twin, 0.0) } else { assert_eq!(phi, PredictionError::default()) }
        }
    }
}

#[test]
fn an_overstated_thrust_is_an_invalid_twin_and_the_residual_of_before_mends_it() {
    let recorded = flight(1.3, false, PASS_TICKS * TICK_S);
    let report = flyer(&recorded).along();
    assert!(report.flights > 5, "{report:?}");
    let z = report.horizons[1].axes[2];
    // It rises by `0.3 g t² / 2` = 0.37 m in half a second.
    assert!((z.twin_rms - 0.368).abs() < 0.01, "{z:?}");
    assert_eq!((z.light, z.light_with_residual), (Light::Invalid, Light::Valid));
    assert_eq!(report.light, Some(Light::Invalid));
}

#[test]
fn forces_per_kilogram_move_a_twin_of_any_mass_and_a_torque_that_is_fitted_does_not_turn_it() {
    let recorded = flight(1.0, true, PASS_TICKS * TICK_S);
    let per_kg = Flyer { own_attitude: false, of_kg: Some(MASS_KG), ..flyer(&recorded) };
    let heavy = Inertial {
        mass_kg: 3.0 * MASS_KG,
        com_in_link: Vector3::zeros(),
        inertia_in_link: Matrix3::identity(),
    };
    let twin = Twin { form: Form::Body(heavy), says: "heavy".to_owned() };
    let heavier = Flyer { twin, ..per_kg.clone() };
    let (one, other) = (per_kg.from(200).expect("known"), heavier.from(200).expect("known"));
    assert!(!one.free && !other.free);
    for row in 0..3 {
        let (one, other) = (one.after[2][row], other.after[2][row]);
        // Rounding of a force and of a mass that are three times as large.
        assert!((one.twin.unwrap() - other.twin.unwrap()).abs() < 1e-9, "{row}");
        assert!((one.with_residual.unwrap() - other.with_residual.unwrap()).abs() < 1e-9, "{row}");
    }
}

#[test]
fn where_force_or_motion_is_unknown_the_twin_does_not_fly() {
    let mut recorded = flight(1.0, true, 0.0);
    recorded.instants[300].tau[2] = None;
    let flyer = flyer(&recorded);
    assert!(flyer.from(150).is_some() && flyer.from(250).is_none() && flyer.from(340).is_none());
    assert!(
        flyer.from(10).is_none()
            && flyer.from(560).is_none()
            && flyer.from(usize::MAX / 2).is_none()
    );
    recorded.instants.iter_mut().for_each(|instant| instant.tau = [None; N]);
    let report = self::flyer(&recorded).along();
    assert_eq!((report.flights, report.light), (0, None));
    assert!(report.commands.starts_with("none"), "{report:?}");
}

#[test]
fn the_light_compares_with_coasting_and_forgives_what_is_not_measured() {
    for (error, coasting, light) in [
        (0.019, 0.0, Light::Valid),
        (-0.4, 1.0, Light::Valid),
        (0.039, 0.0, Light::Doubtful),
        (0.9, 1.0, Light::Doubtful),
        (1.1, 1.0, Light::Invalid),
    ] {
        assert_eq!(Light::of(error, coasting), light, "{error} {coasting}");
    }
}
