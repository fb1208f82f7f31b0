//! Turns a flight that another program recorded into series. Only ticks in the air count. A channel that is unknown most of the time
//! is left out; a short gap repeats the last value and is not usable.

use super::raw::Raw;
use twin_core::notation::N;
use twin_foreign::OpenedFlight;
use twin_foreign::Shadow;

/// Smallest share of the ticks in the air in which a channel must be known.
const LEAST_KNOWN: f64 = 0.5;

/// The flight; channels that are unknown are absent. `M_bar` comes from the known mass and inertia, as in `twin mirror`.
pub(super) fn raw(opened: &OpenedFlight) -> Raw {
    let recorded = &opened.recorded;
    let shadow = Shadow::new(recorded, opened.map.vehicle.inertia_kg_m2);
    let nominal_inertia = shadow.tuning().gains.nominal_inertia;
    let (ticks, instants) = (recorded.instants.len(), &recorded.instants);
    let airborne = |tick: usize| recorded.airborne.get(tick).copied().unwrap_or(false);
    let column =
        |of: &dyn Fn(usize) -> Option<f64>| -> Column { Column::new(ticks, of, &airborne) };
    let mut inputs: Vec<Column> = Vec::with_capacity(3 * N);
    inputs.extend((0..N).map(|row| column(&|t| instants[t].chi[row])));
    inputs.extend((0..N).map(|row| column(&|t| instants[t].chi_dot[row])));
    inputs.extend((0..N).map(|row| column(&|t| instants[t.saturating_sub(1)].tau[row])));
    let residual = |t: usize, row: usize| {
        Some(instants[t].tau[row]? - nominal_inertia[row] * instants[t].chi_ddot[row]?)
    };
    let outputs: Vec<Column> = (0..N).map(|row| column(&|t| residual(t, row))).collect();
    let usable = (0..ticks)
        .map(|tick| airborne(tick) && inputs.iter().chain(&outputs).all(|c| c.counts(tick)))
        .collect();
    let take = |columns: Vec<Column>| columns.into_iter().map(|c| c.values).collect();
    Raw {
        path: opened.path.clone(),
        inputs: take(inputs),
        outputs: take(outputs),
        usable,
        nominal_inertia: nominal_inertia.iter().copied().collect(),
    }
}

struct Column {
    /// Values; a gap repeats the last known value. `None` if the channel is unknown.
    values: Option<Vec<f64>>,
    known: Vec<bool>,
}

impl Column {
    fn new(
        ticks: usize,
        of: &dyn Fn(usize) -> Option<f64>,
        airborne: &dyn Fn(usize) -> bool,
    ) -> Self {
        let known: Vec<bool> = (0..ticks).map(|tick| of(tick).is_some()).collect();
        let in_air = (0..ticks).filter(|tick| airborne(*tick)).count();
        let both = (0..ticks).filter(|tick| airborne(*tick) && known[*tick]).count();
        if in_air == 0 || (both as f64) < LEAST_KNOWN * in_air as f64 {
            return Self { values: None, known };
        }
        let mut held = (0..ticks).find_map(of).unwrap_or(0.0);
        let hold = |tick: usize| {
            held = of(tick).unwrap_or(held);
            held
        };
        Self { values: Some((0..ticks).map(hold).collect()), known }
    }

    /// Whether this channel allows the tick to be usable; an absent channel allows every tick.
    fn counts(&self, tick: usize) -> bool {
        self.values.is_none() || self.known[tick]
    }
}
