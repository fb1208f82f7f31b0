//! A single rotor in moving air.

use super::{Point, Section, picture, published, range, twin, zero};
use twin_core::elementary::{exp, powf};
use twin_plant::RotorSettings;
use twin_plant::curves::{published_descent, rotor, thrust_after_jump};

/// Density of the air, kg/m³: that of the standard atmosphere at sea level.
const AIR_KG_M3: f64 = 1.225;

/// What rounding and the steps of 1 ms leave of a settled balance, relative.
const SETTLED: f64 = 1e-4;

/// Speed of a rotor that gives `thrust_n` in still air, rad/s.
fn speed_rad_s(s: &RotorSettings, thrust_n: f64) -> f64 {
    (thrust_n / s.thrust_coefficient_n_s2).sqrt()
}

fn disc_m2(s: &RotorSettings) -> f64 {
    std::f64::consts::PI * s.radius_m * s.radius_m
}

/// Induced velocity of a climbing rotor per induced velocity in hover: `-x/2 + sqrt(x²/4 + 1)`.
fn climbing(x: f64) -> f64 {
    -0.5 * x + (0.25 * x * x + 1.0).sqrt()
}

/// Induced velocity and thrust in climb and descent.
pub(super) fn axial(s: &RotorSettings, thrust_n: f64) -> Section {
    let speed = speed_rad_s(s, thrust_n);
    let at = |velocity: f64| rotor(s, speed, [0.0, 0.0, velocity]);
    let velocities = range(-6.0, 8.0, 70);
    let ratios =
        velocities.clone().map(|v| (v / at(v).hover_m_s, at(v).induced_m_s / at(v).hover_m_s));
    let theory = |x: f64| if x < 0.0 { published_descent(x) } else { climbing(x) };
    let points = [("climb", 2.0_f64), ("climb", 5.0), ("descent", -1.0), ("descent", -3.0)].map(
        |(name, v)| {
            let (x, found) = (v / at(v).hover_m_s, at(v).induced_m_s / at(v).hover_m_s);
            Point::new(
                format!("v / v_h in a {name} of {} m/s", v.abs()),
                [found, theory(x)],
                SETTLED,
                "",
            )
        },
    );
    Section {
        title: "Rotor in climb and descent",
        source: "Climb: momentum theory, Leishman, Principles of Helicopter Aerodynamics (2006), equation 2.87. Descent: fit to measurements, \
                 equation 2.101. A rotor at constant speed loses thrust in climb and gains it in descent, which damps vertical motion.",
        pictures: vec![
            picture(
                "Induced velocity",
                "climb velocity / v_h",
                "v / v_h",
                vec![
                    published("Leishman 2006", range(-1.1, 1.5, 100).map(|x| (x, theory(x)))),
                    twin("twin", ratios),
                ],
            ),
            picture(
                "Thrust at constant speed",
                "climb velocity, m/s",
                "N",
                vec![twin("twin", velocities.map(|v| (v, at(v).thrust_n)))],
            ),
        ],
        points: points.to_vec(),
    }
}

/// Thrust, torque and hub moment in forward flight.
pub(super) fn edgewise(s: &RotorSettings, thrust_n: f64) -> Section {
    let speed = speed_rad_s(s, thrust_n);
    let at = |velocity: f64| rotor(s, speed, [velocity, 0.0, 0.0]);
    let advance = |velocity: f64| velocity / (speed * s.radius_m);
    let velocities = range(0.0, 15.0, 60);
    let theory = |velocity: f64| glauert_n(s, speed, velocity);
    let points = [3.0, 8.0, 12.0].map(|v| {
        let values = [at(v).thrust_n, theory(v)];
        Point::new(format!("thrust at {v} m/s across the rotor"), values, SETTLED * thrust_n, "N")
    });
    let over = |value: &dyn Fn(f64) -> f64| {
        velocities.clone().map(|v| (advance(v), value(v))).collect::<Vec<_>>()
    };
    Section {
        title: "Rotor in forward flight",
        source: "Glauert's momentum balance with blade elements, Leishman (2006), sections 2.14 and 3.3, solved here by bisection. The disc \
                 tilts by a_1 = 2 mu (4/3 theta - lambda), and its stiffness turns the hub.",
        pictures: vec![
            picture(
                "Thrust at constant speed",
                "advance ratio V / (Omega R)",
                "N",
                vec![published("Glauert", over(&theory)), twin("twin", over(&|v| at(v).thrust_n))],
            ),
            picture(
                "Moment of the tilted disc on the hub",
                "advance ratio V / (Omega R)",
                "N m",
                vec![twin("twin", over(&|v| at(v).hub_moment_n_m))],
            ),
        ],
        points: points.to_vec(),
    }
}

/// Thrust of blade elements whose induced velocity meets Glauert's balance `T = 2 rho A v sqrt(V² + v²)`, N.
fn glauert_n(s: &RotorSettings, speed: f64, velocity: f64) -> f64 {
    let area = disc_m2(s);
    let solid = AIR_KG_M3 * s.lift_slope_per_rad * s.blade_area_m2;
    let tip = speed * s.radius_m;
    // The pitch follows from the thrust in still air: T = rho a S (Omega R)² (theta / 6 - lambda / 4).
    let hover = (s.thrust_coefficient_n_s2 * speed * speed / (2.0 * AIR_KG_M3 * area)).sqrt();
    let sixth =
        s.thrust_coefficient_n_s2 * speed * speed / (solid * tip * tip) + 0.25 * hover / tip;
    let blades = |v: f64| {
        let lift = sixth * (1.0 + 1.5 * (velocity / tip) * (velocity / tip)) - 0.25 * v / tip;
        solid * tip * tip * lift
    };
    let balance =
        |v: f64| 2.0 * AIR_KG_M3 * area * v * (velocity * velocity + v * v).sqrt() - blades(v);
    blades(zero(balance, 0.0, 3.0 * hover))
}

/// Thrust after a jump of the speed.
pub(super) fn lag(s: &RotorSettings, thrust_n: f64) -> Section {
    let speed = speed_rad_s(s, thrust_n);
    let jump = [0.98 * speed, 1.02 * speed];
    let thrust = thrust_after_jump(s, jump, 40);
    let settled = s.thrust_coefficient_n_s2 * jump[1] * jump[1];
    let area = disc_m2(s);
    let hover = (settled / (2.0 * AIR_KG_M3 * area)).sqrt();
    let lift = 0.25 * AIR_KG_M3 * s.lift_slope_per_rad * s.blade_area_m2 * s.radius_m * jump[1];
    let apparent_kg = 8.0 / 3.0 * AIR_KG_M3 * powf(s.radius_m, 3.0);
    let constant_s = apparent_kg / (4.0 * AIR_KG_M3 * area * hover + lift);
    let first = thrust[0] - settled;
    let theory = |t_s: f64| settled + first * exp(-t_s / constant_s);
    let at_s = 5e-3;
    Section {
        title: "Dynamic inflow",
        source: "Apparent mass 8/3 rho R³ of the induced flow, Pitt and Peters, Vertica 5 (1981). After a jump of the rotor speed by 4 % the \
                 thrust overshoots, because the induced velocity follows late.",
        pictures: vec![picture(
            "Thrust after a jump of the rotor speed by 4 %",
            "s after the jump",
            "N",
            vec![
                published("Pitt and Peters, linear", range(0.0, 0.04, 80).map(|t| (t, theory(t)))),
                twin("twin", thrust.iter().enumerate().map(|(i, n)| (i as f64 * 1e-3, *n))),
            ],
        )],
        points: vec![
            // The linear solution leaves out the square of a change of 4 %, and a step of 1 ms is a fifth of the time constant.
            Point::new("thrust 5 ms after the jump", [thrust[5], theory(at_s)], 0.1 * first, "N"),
            Point::new("thrust 39 ms after the jump", [thrust[39], settled], 1e-3, "N"),
        ],
    }
}
