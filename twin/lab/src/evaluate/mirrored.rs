//! Pictures of a mirrored flight: commanded thrust relative to the force that moved the mass, vertical residual, and adapter.

use super::pictures::{Curve, Picture, stacked};
use twin_core::notation::GRAVITY_M_S2;
use twin_core::tick::Tick;

/// Index of z among the coordinates.
const Z: usize = 2;

/// Largest number of points of a curve; more would not be visible.
const MOST_POINTS: usize = 4000;

/// Share of the weight below which the ratio is not drawn: then something else carries the vehicle, such as the ground.
const LEAST_SHARE: f64 = 0.5;

/// Data of the pictures, tick by tick.
#[derive(Clone, Debug)]
pub struct FlightPicture {
    weight_n: f64,
    /// Time in s and the values to draw; `None` where the vertical residual is unknown.
    ticks: Vec<(f64, Option<Drawn>)>,
    resets_s: Vec<f64>,
}

/// Values of one tick, N.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    force: f64,
    residual: f64,
    estimate: f64,
    innovation: f64,
}

impl FlightPicture {
    /// Pictures of a vehicle of mass `mass_kg`, kg.
    pub fn new(mass_kg: f64) -> Self {
        let weight_n = mass_kg * GRAVITY_M_S2;
        Self { weight_n, ticks: Vec::new(), resets_s: Vec::new() }
    }

    /// Adds a tick; a tick with an unknown vertical residual is not drawn.
    pub fn add(&mut self, tick: &Tick) {
        let t_s = tick.measurement.t_s;
        if tick.adapted.reset {
            self.resets_s.push(t_s);
        }
        let drawn = |residual| Drawn {
            force: tick.measurement.tau_applied[Z],
            residual,
            estimate: tick.adapted.r_hat_prior[Z],
            innovation: tick.adapted.innovation_mean_norm,
        };
        self.ticks.push((t_s, tick.residual.get(Z).map(drawn)));
    }

    /// The pictures as SVG.
    pub fn svg(&self, name: &str) -> String {
        let weight = self.weight_n;
        // Force that moved the mass, its weight included: the applied force minus the part of the residual beyond the weight.
        let gain = |force: f64, residual: f64| {
            let moved = force - residual + weight;
            if moved > LEAST_SHARE * weight { force / moved } else { f64::NAN }
        };
        let gains = Picture {
            title: format!("{name}: vertical force as commanded / force that moved the mass"),
            y: "1 = as commanded".to_owned(),
            curves: vec![
                self.curve("by the measured residual", true, |d| gain(d.force, d.residual)),
                self.curve("by the adapter, a priori", false, |d| gain(d.force, d.estimate)),
            ],
            ..self.picture()
        };
        let residuals = Picture {
            title: "vertical residual".to_owned(),
            y: "N".to_owned(),
            curves: vec![
                self.curve("measured", true, |d| d.residual),
                self.curve("adapter, a priori", false, |d| d.estimate),
                self.curve("weight", false, |_| weight),
            ],
            ..self.picture()
        };
        let innovation = Picture {
            title: "mean innovation of the adapter".to_owned(),
            y: "standard deviations".to_owned(),
            curves: vec![self.curve("all known rows", false, |d| d.innovation)],
            ..self.picture()
        };
        stacked(&[gains, residuals, innovation])
    }

    fn picture(&self) -> Picture {
        let marks = self.resets_s.iter().map(|t_s| (*t_s, "reset".to_owned())).collect();
        Picture { x: "t, s".to_owned(), marks, ..Picture::default() }
    }

    fn curve(&self, name: &str, measured: bool, of: impl Fn(&Drawn) -> f64) -> Curve {
        let every = (self.ticks.len() / MOST_POINTS).max(1);
        let known = self.ticks.iter().step_by(every);
        let points = known.filter_map(|(t_s, drawn)| Some((*t_s, of(drawn.as_ref()?)))).collect();
        Curve { name: name.to_owned(), points, measured }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::notation::KnownCoords;
    use twin_record::fixture;

    #[test]
    fn the_picture_shows_gain_residual_and_resets_and_nothing_of_unknown_ticks() {
        let mut picture = FlightPicture::new(2.0);
        for i in 0..200_u32 {
            let mut tick = fixture::tick(3);
            tick.measurement.t_s = f64::from(i) * 0.01;
            tick.measurement.tau_applied[Z] = 26.0;
            tick.residual[Z] = 26.0;
            tick.adapted.reset = i == 50;
            if i >= 100 {
                tick.residual = KnownCoords::unknown();
            }
            picture.add(&tick);
        }
        // The applied force is 26 N where only the weight of 19.62 N was moved: 1.325 times as much.
        let gain = picture.curve("", true, |d| d.force / (d.force - d.residual + 19.62));
        assert_eq!(gain.points.len(), 100);
        assert!(gain.points.iter().all(|(_, k)| (k - 26.0 / 19.62).abs() < 1e-12));
        let svg = picture.svg("x8.mcap");
        for word in ["x8.mcap", "reset", "adapter, a priori", "weight"] {
            assert!(svg.contains(word), "{word}");
        }
        assert!(!svg.contains("NaN"));
    }
}
