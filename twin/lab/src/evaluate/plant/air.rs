//! The air around the vehicle: ground effect, wakes, drag, turbulence.

use super::{Point, Section, picture, published, range, twin};
use crate::evaluate::series::EvaluateError;
use twin_core::elementary::{exp, powf, squared};
use twin_plant::curves::{ground_ratio, turbulence as turbulence_of, wake as wake_of};
use twin_plant::{PlantSettings, WindKind, WindSettings};
use twin_scenario::settings::{PathShape, StartKind, TaskKind};
use twin_scenario::{Scenario, fly};

/// Thrust ratio of one rotor at `z` radii above the ground (Cheeseman and Bennett 1955).
fn cheeseman_bennett(z: f64) -> f64 {
    1.0 / (1.0 - 1.0 / (16.0 * z * z))
}

/// Thrust ratio of a quadrotor in X with rotors of radius `r` at distance `d`, `z` above the ground; all in m.
fn sanchez_cuevas(r: f64, d: f64, z: f64, fountain: f64) -> f64 {
    let term = |square: f64| z / powf(square + 4.0 * z * z, 1.5);
    let diagonal = 2.0 * d * d;
    let lost = squared(r / (4.0 * z))
        + r * r * term(d * d)
        + 0.5 * r * r * term(diagonal)
        + 2.0 * r * r * fountain * term(diagonal);
    1.0 / (1.0 - lost)
}

pub(super) fn ground(settings: &PlantSettings) -> Section {
    let (places, aero) = (&settings.vehicle.rotors, &settings.aero);
    let r = aero.ground_effect_radius_m;
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| squared(a[i] - b[i])).sum::<f64>().sqrt();
    let d = places
        .iter()
        .skip(1)
        .map(|place| near(places[0].position_m, place.position_m))
        .fold(f64::INFINITY, f64::min);
    let all = |z: f64| ground_ratio(places, aero, z * r);
    let one = |z: f64| ground_ratio(&places[..1], aero, z * r);
    let theory = |z: f64| sanchez_cuevas(r, d, z * r, aero.fountain);
    let heights = range(0.8, 8.0, 72);
    let mut points = [1.5, 2.0, 4.0]
        .map(|z| {
            Point::new(format!("one rotor, z = {z} R"), [one(z), cheeseman_bennett(z)], 1e-6, "")
        })
        .to_vec();
    if places.len() == 4 {
        points.extend(
            [1.5, 2.0, 4.0].map(|z| {
                Point::new(format!("quadrotor, z = {z} R"), [all(z), theory(z)], 1e-6, "")
            }),
        );
    }
    Section {
        title: "Ground effect",
        source: "One rotor: Cheeseman and Bennett (1955). Quadrotor with fountain: Sanchez-Cuevas, Heredia and Ollero, Characterization of the \
                 Aerodynamic Ground Effect and Its Influence in Multirotor Control, International Journal of Aerospace Engineering (2017), \
                 equation 11.",
        pictures: vec![picture(
            "Thrust per thrust far above the ground",
            "height / R",
            "",
            vec![
                published("Sanchez-Cuevas 2017", heights.clone().map(|z| (z, theory(z)))),
                twin("twin, all rotors", heights.clone().map(|z| (z, all(z)))),
                twin("Cheeseman, Bennett 1955", heights.clone().map(|z| (z, cheeseman_bennett(z)))),
                twin("twin, one rotor", heights.map(|z| (z, one(z)))),
            ],
        )],
        points,
    }
}

/// Induced velocity at which the wakes are drawn, m/s: that of the standard vehicle in hover.
const INDUCED_M_S: f64 = 5.7;

pub(super) fn wake(settings: &PlantSettings) -> Section {
    let radius = settings.vehicle.rotor.radius_m;
    let mut one = settings.vehicle.rotors[..1].to_vec();
    one[0].position_m = [0.0; 3];
    let profile = |depth: f64, forward: f64| {
        let xs: Vec<f64> = range(-0.5, 0.5, 200).collect();
        let points: Vec<[f64; 3]> = xs.iter().map(|x| [*x, 0.0, -depth]).collect();
        let speeds = wake_of(&one, radius, INDUCED_M_S, [forward, 0.0, 0.0], &points);
        xs.into_iter().zip(speeds).collect::<Vec<(f64, f64)>>()
    };
    let width = |depth: f64| {
        let all = profile(depth, 0.0);
        let half = 0.5 * all.iter().map(|(_, v)| *v).fold(0.0, f64::max);
        all.iter().filter(|(_, v)| *v > half).map(|(x, _)| x.abs()).fold(0.0, f64::max)
    };
    let skew = |forward: f64| {
        let all = profile(0.4, forward);
        all.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |(x, _)| -x)
    };
    // A Gaussian of radius b falls to a half at b sqrt(ln 2); the jet's b grows by 0.1 per distance (Pope 2000: half-width 0.094).
    let grows = (width(1.0) - width(0.4)) / 0.6;
    let travel_s = 0.4 / INDUCED_M_S;
    Section {
        title: "Wake of a rotor",
        source: "Contraction: momentum theory. Growth of the half-width of a round turbulent jet: 0.094 per distance, Pope, Turbulent Flows \
                 (2000), section 5.1; a jet keeps its momentum. The air travels down the jet with the induced velocity, so the wake on arm and \
                 payload is late, and flight and wind skew it.",
        pictures: vec![
            picture(
                "Downward velocity below a hovering rotor",
                "m from the axis",
                "m/s",
                [0.1, 0.4, 1.0].map(|d| twin(&format!("{d} m below"), profile(d, 0.0))).to_vec(),
            ),
            picture(
                "The same 0.4 m below a rotor in forward flight",
                "m ahead of the axis",
                "m/s",
                [0.0, 1.0, 2.0].map(|v| twin(&format!("{v} m/s"), profile(0.4, v))).to_vec(),
            ),
        ],
        points: vec![
            // The profile is drawn in steps of 5 mm, which over 0.6 m are 0.008.
            Point::new("growth of the half-width per distance", [grows, 0.094], 0.02, ""),
            Point::new("skew at 2 m/s, 0.4 m below", [skew(2.0), 2.0 * travel_s], 6e-3, "m"),
        ],
    }
}

/// Drag in a flight, from the force budget.
pub(super) fn drag(scenario: &Scenario) -> Result<Section, EvaluateError> {
    let mut flown = scenario.clone();
    let task = &mut flown.settings.task;
    (task.kind, task.start) = (TaskKind::Path, StartKind::Hover);
    (task.path.shape, task.speed_m_s) = (PathShape::FigureEight, 1.5);
    flown.settings.payload.mass_kg = 0.0;
    flown.settings.wind.on = false;
    let aero = flown.settings.aero;
    let mut found: Vec<(f64, f64, f64)> = Vec::new();
    fly(&flown, &mut |tick| {
        let Some(truth) = &tick.truth else { return };
        let Some(budget) = truth.budget else { return };
        let velocity = truth.chi_dot.fixed_rows::<3>(0).into_owned();
        let speed = velocity.norm();
        if speed > 0.2 {
            let collective: f64 = truth.rotor_thrust_n.iter().sum();
            found.push((speed, -budget.drag.dot(&velocity) / speed, collective));
        }
    })?;
    let theory = |speed: f64, collective: f64| {
        aero.rotor_drag_n_s_m[0] * speed * collective / 30.0
            + aero.body_drag_n_s2_m2 * speed * speed
    };
    // Rotor drag acts in the plane of the rotors alone, so the tilt and the climb of the flight take a part of it.
    let ratio = found.iter().map(|(_, drag, _)| drag).sum::<f64>()
        / found.iter().map(|(speed, _, n)| theory(*speed, *n)).sum::<f64>();
    let every = found.len() / 400 + 1;
    let mut some: Vec<(f64, f64)> = found.iter().step_by(every).map(|(v, d, _)| (*v, *d)).collect();
    some.sort_by(|a, b| a.0.total_cmp(&b.0));
    let thrust = found.iter().map(|(_, _, n)| n).sum::<f64>() / found.len().max(1) as f64;
    Ok(Section {
        title: "Drag in flight",
        source: "Rotors: proportional to thrust and velocity, as measured by Martin and Salaün (ICRA 2010) and Faessler, Franchi and \
                 Scaramuzza (2018). Body: quadratic. The curve is the force budget of a flown figure-8.",
        pictures: vec![picture(
            "Drag against the motion, figure-8 at 1.5 m/s",
            "speed, m/s",
            "N",
            vec![
                published(
                    "linear and quadratic",
                    range(0.0, 1.8, 60).map(|v| (v, theory(v, thrust))),
                ),
                twin("twin, flown", some),
            ],
        )],
        points: vec![Point::new("drag of the flight per formula", [ratio, 1.0], 0.1, "")],
    })
}

/// Altitude (m) and wind (m/s) of the turbulence: 20 ft, where the specification gives the wind.
const ALTITUDE_M: f64 = 6.096;
const WIND_M_S: f64 = 8.0;

/// Values of the turbulence, and the time between two of them, s.
const SAMPLES: usize = 40_000;
const SAMPLE_S: f64 = 0.05;

/// Standard deviations (m/s) and correlation times (s) along the wind and vertically by MIL-F-8785C at 20 ft.
fn specified() -> [[f64; 2]; 2] {
    let base: f64 = 0.177 + 0.000_823 * 20.0;
    let vertical = 0.1 * WIND_M_S;
    let times = [ALTITUDE_M / powf(base, 1.2) / WIND_M_S, ALTITUDE_M / WIND_M_S];
    [[vertical / powf(base, 0.4), vertical], times]
}

/// Standard deviation and correlation of Dryden turbulence by altitude.
pub(super) fn turbulence(wind: &WindSettings) -> Section {
    let settings = WindSettings {
        on: true,
        kind: WindKind::DrydenAltitude,
        velocity_m_s: [WIND_M_S, 0.0, 0.0],
        ..*wind
    };
    let series = turbulence_of(&settings, ALTITUDE_M, SAMPLES, SAMPLE_S);
    let product = |axis: usize, lag: usize| {
        let pairs = series.iter().zip(&series[lag..]);
        pairs.map(|(a, b)| a[axis] * b[axis]).sum::<f64>() / (SAMPLES - lag) as f64
    };
    let std = |axis: usize| product(axis, 0).sqrt();
    let correlation = |axis: usize, lag: usize| product(axis, lag) / product(axis, 0);
    let [[sigma_u, sigma_w], [long_s, short_s]] = specified();
    // Along the wind exp(-t/tau); across it (1 - t / 2 tau) exp(-t/tau).
    let along = |t_s: f64| exp(-t_s / long_s);
    let across = |t_s: f64| (1.0 - 0.5 * t_s / short_s) * exp(-t_s / short_s);
    let curve = |axis: usize| {
        let lags = (0..240).step_by(4);
        lags.map(|lag| (lag as f64 * SAMPLE_S, correlation(axis, lag))).collect::<Vec<_>>()
    };
    let curves = vec![
        published("along, MIL-F-8785C", range(0.0, 12.0, 120).map(|t| (t, along(t)))),
        twin("twin, along", curve(0)),
        published("vertical, MIL-F-8785C", range(0.0, 12.0, 120).map(|t| (t, across(t)))),
        twin("twin, vertical", curve(2)),
    ];
    Section {
        title: "Turbulence by altitude",
        source: "Dryden's model near the ground, MIL-F-8785C, section 3.7.3.4, at 20 ft in a wind of 8 m/s. A field of turbulence passes with \
                 the air speed, so a scale length becomes a correlation time.",
        pictures: vec![picture("Correlation of the turbulence", "s", "", curves)],
        points: vec![
            // 2000 s at a correlation time of 5 s are 400 samples: three standard errors are 11 %; vertically 2600 samples, 4 %.
            Point::new("standard deviation along", [std(0), sigma_u], 0.11 * sigma_u, "m/s"),
            Point::new("standard deviation vertical", [std(2), sigma_w], 0.05 * sigma_w, "m/s"),
            Point::new("correlation along after 5 s", [correlation(0, 100), along(5.0)], 0.15, ""),
            Point::new(
                "correlation vertical after 1 s",
                [correlation(2, 20), across(1.0)],
                0.08,
                "",
            ),
        ],
    }
}
