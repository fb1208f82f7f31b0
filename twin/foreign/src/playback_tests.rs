use std::sync::atomic::{AtomicUsize, Ordering};

use super::super::effort::Effort;
use super::super::recorded::Derivation;
use super::*;
use twin_core::notation::{N, TICK_S};

/// Turn rate of the vehicle in these tests, rad per tick: it makes several turns in the flight.
const TURN_RAD: f64 = 0.02;

/// A turning vehicle. Every part of its flight starts with a yaw between -pi and pi; nothing is known from tick 700 to 720.
#[derive(Debug, Default)]
struct Turning {
    reads: AtomicUsize,
}

const TICKS: usize = 2345;

fn yaw(tick: usize) -> f64 {
    tick as f64 * TURN_RAD
}

impl PartReader for Turning {
    fn ticks(&self) -> usize {
        TICKS
    }

    fn part(&self, from: usize, to: usize) -> RecordedFlight {
        self.reads.fetch_add(1, Ordering::Relaxed);
        let turns = yaw(from) - wrap_angle(yaw(from));
        let instant = |tick: usize| {
            let mut chi = [Some(tick as f64); N];
            chi[PSI] = Some(yaw(tick) - turns);
            if (700..720).contains(&tick) {
                RecordedTick::default()
            } else {
                RecordedTick { chi, ..RecordedTick::default() }
            }
        };
        RecordedFlight {
            times_s: (from..to).map(|tick| tick as f64 * TICK_S).collect(),
            instants: (from..to).map(instant).collect(),
            effort: Effort::Recorded,
            mass_kg: 1.0,
            airborne: vec![true; to - from],
            nominal_inertia: None,
            acceleration: [Derivation::Unknown; 2],
            spans: Vec::new(),
            yardsticks: crate::phases::Yardsticks::default(),
            joint_names: Vec::new(),
        }
    }

    fn troubles(&self) -> Vec<String> {
        Vec::new()
    }
}

fn played(playback: &Arc<Playback>, first: usize) -> Vec<Measurement> {
    let mut source = RecordedSource::new(playback, first).unwrap();
    (first..TICKS).map(|_| source.play()).collect()
}

#[test]
fn yaw_goes_on_over_the_edges_of_blocks_and_nothing_is_made_up_for_unknown_coordinates() {
    let parts: Arc<dyn PartReader> = Arc::new(Turning::default());
    let playback = Arc::new(Playback::of(&parts));
    let all = played(&playback, 0);
    assert_eq!(all.len(), TICKS);
    for (tick, measurement) in all.iter().enumerate() {
        if (700..720).contains(&tick) {
            assert_eq!(measurement.chi, KnownCoords::unknown(), "{tick}");
            continue;
        }
        // Tolerance for the sum of some thousand steps of 0.02.
        assert!((measurement.chi[PSI] - yaw(tick)).abs() < 1e-9, "{tick}");
        assert_eq!(measurement.chi.get(0), Some(tick as f64), "{tick}");
        for unknown in [measurement.chi_dot, measurement.chi_ddot, measurement.tau_applied] {
            assert_eq!(unknown, KnownCoords::unknown(), "{tick}: the recording does not say it");
        }
    }
    // A playback that starts in the middle differs from the whole one by full turns only.
    for (ours, whole) in played(&playback, 1200).iter().zip(&all[1200..]) {
        assert!(wrap_angle(ours.chi[PSI] - whole.chi[PSI]).abs() < 1e-9);
        assert_eq!(ours.t_s.to_bits(), whole.t_s.to_bits());
    }
}

#[test]
fn a_block_on_the_shelf_is_not_read_again_and_the_shelf_is_bounded() {
    let turning = Arc::new(Turning::default());
    let parts: Arc<dyn PartReader> = turning.clone();
    let cache = BlockCache::new(parts);
    for _ in 0..3 {
        for number in 0..4 {
            cache.block(number, 0);
        }
    }
    assert_eq!(turning.reads.load(Ordering::Relaxed), 4);
    for number in 0..10 * KEPT_TICKS / BLOCK_TICKS {
        cache.block(number, 0);
        assert!(cache.blocks.len() * BLOCK_TICKS <= KEPT_TICKS);
    }
    assert_eq!(cache.block(4, 0).len(), TICKS - 4 * BLOCK_TICKS);
}

#[test]
fn nothing_is_beyond_the_end() {
    let parts: Arc<dyn PartReader> = Arc::new(Turning::default());
    let playback = Arc::new(Playback::of(&parts));
    assert!(RecordedSource::new(&playback, TICKS).is_none());
    assert_eq!(Cursor::new(&playback).frame(TICKS), None);
    let mut source = RecordedSource::new(&playback, TICKS - 1).unwrap();
    let last = source.play();
    assert_eq!(source.play(), last);
}
