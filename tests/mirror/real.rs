//! Real flights from the folder `TWIN_FLIGHTS`, or `../shared/flights`. Without the folder the tests are skipped and say so.

use std::path::{Path, PathBuf};

use twin_foreign::topics::Quantity;
use twin_foreign::{Effort, Map, RecordedFlight, Survey};
use twin_foreign::{ShadowReport, shadow};

use super::made::read;

pub(super) fn flights() -> Option<PathBuf> {
    let folder = std::env::var_os("TWIN_FLIGHTS").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/flights"),
        PathBuf::from,
    );
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("SKIPPED: no real flights in {}; set TWIN_FLIGHTS to their folder", folder.display());
    None
}

fn map(path: &Path) -> Map {
    let survey = Survey::read(path).expect("readable");
    let own = survey.family.and_then(Map::shipped).unwrap_or_default();
    Map::over_generic(own).expect("the generic map")
}

fn fly(path: &Path) -> (twin_foreign::signals::Signals, RecordedFlight, ShadowReport) {
    let map = map(path);
    let (signals, recorded) = read(path, &map);
    let report = shadow(&recorded, map.vehicle.inertia_kg_m2, &mut |_| {}).expect("ticks");
    assert_eq!(report.fault_ticks, 0, "{}", path.display());
    (signals, recorded, report)
}

#[test]
fn px4_flights_give_a_thrust_gain_near_twice_gravity_and_the_rows_whose_torque_gain_is_known() {
    let Some(folder) = flights() else { return };
    for name in ["20250612_waypoint4_px4.mcap", "20250605_tactip1_px4.zstd.mcap"] {
        let (_, recorded, report) = fly(&folder.join("px4_arm").join(name));
        let Effort::Fitted { input, fit, torque } = &recorded.effort else {
            panic!("{name}: {:?}", recorded.effort)
        };
        assert_eq!(*input, Quantity::Thrust, "{name}");
        // In hover the gain times the mean thrust equals gravity; this is an independent check of the axes.
        assert!((fit.gain * fit.mean_input / 9.81 - 1.0).abs() < 0.05, "{name}: {fit:?}");
        assert!(fit.standard_error < 0.05 * fit.gain, "{name}: {fit:?}");
        assert!(report.scored.rows[2].residual_known > 0.5, "{name}");
        for (axis, known) in torque.known().iter().enumerate() {
            assert_eq!(report.scored.rows[3 + axis].residual.is_some(), *known, "{name} {axis}");
        }
    }
}

#[test]
fn the_bag_of_a_vehicle_that_is_carried_has_joints_and_no_force() {
    let Some(folder) = flights() else { return };
    let path = folder.join("px4_arm/ros2bag_ats_2025-12-02_12-44-28_0.mcap");
    let (signals, recorded, report) = fly(&path);
    let Effort::Unknown { why } = &recorded.effort else { panic!("{:?}", recorded.effort) };
    assert!(why.contains("not flying"), "{why}");
    assert_eq!(signals.joints.as_ref().expect("an arm").0, ["q0", "q1"]);
    let q0 = |tick: usize| recorded.instants[tick].chi[6];
    let first = (0..recorded.instants.len()).find_map(q0).expect("known");
    let last = (0..recorded.instants.len()).rev().find_map(q0).expect("known");
    // The arm is driven from 0.18 to 1.57 rad.
    assert!((first - 0.18).abs() < 0.05 && (last - 1.57).abs() < 0.05, "{first} {last}");
    // The joint rate in the log is zero, and ours is not.
    let fastest = recorded.instants.iter().filter_map(|i| i.chi_dot[6]).fold(0.0, f64::max);
    assert!(fastest > 0.2, "{fastest}");
    assert!(report.scored.rows.iter().all(|row| row.residual.is_none()));
    // The mcap package for Python counts 32 channels, 8 of them without a message.
    let survey = Survey::read(&path).expect("readable");
    let empty = survey.channels.iter().filter(|info| info.messages == 0).count();
    assert_eq!((survey.channels.len(), empty), (32, 8));
}

#[test]
fn the_x8_commands_more_thrust_than_its_mass_needs() {
    let Some(folder) = flights() else { return };
    let (_, recorded, report) = fly(&folder.join("acsl_x8/log_20240613_115633.zstd.mcap"));
    let Effort::Wrench { fit: Some(fit) } = &recorded.effort else {
        panic!("{:?}", recorded.effort)
    };
    // Independent fits give an effective mass of 2.3 to 2.7 kg where the vehicle has 1.92 kg.
    let mass_kg = 1.0 / fit.gain;
    assert!((2.2..2.8).contains(&mass_kg), "{mass_kg}");
    let z = report.scored.rows[2].residual.expect("known");
    assert!(z.mean > 1.920 * 9.81 * 1.15, "{z:?}");
    // The adapter learns the heavier mass, so the forecast is far better than with the weight of 1.92 kg.
    let now = report.scored.prediction[0].rmse_z.expect("scored");
    assert!(now < 1.0, "{now}");
}

#[test]
fn the_crazyflies_own_messages_are_read_by_its_map_without_code() {
    let Some(folder) = flights() else { return };
    let path = folder.join("crazyflie/path2_kvadrat_2025-05-13-11-21-29.mcap");
    let (signals, recorded, _) = fly(&path);
    let used: Vec<Quantity> = signals.used.iter().map(|used| used.quantity).collect();
    assert_eq!(used[..2], [Quantity::Position, Quantity::Euler]);
    let Effort::Fitted { fit, .. } = &recorded.effort else { panic!("{:?}", recorded.effort) };
    // The thrust leads the acceleration that motion capture measures by 60 to 80 ms.
    assert!((0.03..=0.12).contains(&fit.lag_s), "{fit:?}");
}

#[test]
fn the_ulog_and_the_mcap_that_was_made_of_it_are_the_same_flight() {
    let Some(folder) = flights() else { return };
    let name = |ending: &str| folder.join(format!("px4_arm/20250612_waypoint4_px4.{ending}"));
    let (mcap, ulog) = (fly(&name("mcap")), fly(&name("ulg")));
    let used = |signals: &twin_foreign::signals::Signals| -> Vec<(Quantity, String, usize)> {
        signals
            .used
            .iter()
            // A log names no version of a message; the MCAP does where there is one.
            .map(|used| {
                let topic = used.topic.trim_end_matches("_v1").to_owned();
                (used.quantity, topic, used.timing.samples)
            })
            .collect()
    };
    assert_eq!(used(&mcap.0), used(&ulog.0));
    let (Effort::Fitted { fit: a, .. }, Effort::Fitted { fit: b, .. }) =
        (&mcap.1.effort, &ulog.1.effort)
    else {
        panic!("{:?} {:?}", mcap.1.effort, ulog.1.effort)
    };
    assert_eq!(a, b);
    // The same numbers at the same times give the same flight, bit for bit.
    assert_eq!(mcap.2.state_hash, ulog.2.state_hash);
    assert_eq!(mcap.2.scored, ulog.2.scored);
}
