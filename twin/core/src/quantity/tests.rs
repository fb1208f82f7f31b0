//! The registry: no name twice, no key twice, bounds that allow their ends, and slips of the unit.

use super::*;

fn path(text: &str) -> Vec<String> {
    text.split('.').map(str::to_owned).collect()
}

#[test]
fn a_quantity_has_a_name_of_its_own_a_range_and_a_step() {
    let mut names: Vec<&str> = all().map(|quantity| quantity.name).collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count, "a name stands twice in {names:?}");
    for quantity in all() {
        assert!(quantity.min < quantity.max, "{}", quantity.name);
        assert!(quantity.step > 0.0 && quantity.step.is_finite(), "{}", quantity.name);
        assert!(!quantity.help.is_empty(), "{}", quantity.name);
        let held = quantity.keys.len() + quantity.keys_or_none.len() + quantity.messages.len();
        assert!(held > 0, "nothing holds {}", quantity.name);
    }
}

#[test]
fn every_key_leads_to_its_quantity_whose_ends_are_allowed_and_nothing_beyond() {
    for quantity in all() {
        for key in quantity.keys.iter().chain(quantity.keys_or_none) {
            // A star may stand for no character.
            let bounds = at(&path(&key.replace('*', ""))).unwrap_or_else(|| panic!("{key}"));
            assert_eq!(bounds.quantity.name, quantity.name, "{key}");
            assert!(bounds.allow(quantity.min) && bounds.allow(quantity.max), "{key}");
            let part = 1e-3 * (quantity.max - quantity.min);
            let [below, above] = [quantity.min - part, quantity.max + part];
            for beyond in [below, above, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert!(!bounds.allow(beyond), "{key} = {beyond}");
            }
        }
    }
}

#[test]
fn a_list_has_the_bounds_of_its_key_and_rows_may_have_their_own() {
    let unit = |key: &str| at(&path(key)).map(|bounds| bounds.quantity.unit);
    assert_eq!(unit("arena.objects.0.position_m.1"), Some("m"));
    assert_eq!(unit("gains.slope.7"), Some("1/s"));
    assert_eq!(unit("gains.damping.2"), Some("N s/m"));
    assert_eq!(unit("gains.damping.3"), Some("N m s/rad"));
    assert_eq!(unit("gains.damping.8"), None);
    assert_eq!(unit("controller.nominal_inertia.0"), Some("kg"));
    assert_eq!(unit("controller.limits.residual_clip.7"), Some("N m"));
    assert_eq!(unit("sensors.other"), None);
}

#[test]
fn a_whole_number_beyond_a_range_does_not_round_into_it() {
    let largest = 1_i128 << 53;
    assert!(SEED.allows(whole(largest)) && SEED.allows(whole(0)));
    for beyond in [largest + 1, largest + 3, i128::from(u64::MAX), -1] {
        assert!(!SEED.allows(whole(beyond)), "{beyond}");
    }
    // These have exact doubles.
    for exact in [0, 5, -5, largest - 1, largest + 2] {
        assert_eq!(whole(exact) as i128, exact);
    }
}

#[test]
fn a_star_stands_for_part_of_one_segment() {
    assert!(fits_one("*_noise_m", "position_noise_m") && !fits_one("*_noise_m", "noise_m_s"));
    assert!(fits_one("*", "anything") && !fits_one("a*a", "a"));
    assert!(fits("wind.*_s", &["wind", "gust_s"]) && !fits("wind.*_s", &["wind"]));
}

#[test]
fn the_same_thing_has_one_range_wherever_it_is_written() {
    for [one, other] in [
        ["payload.mass_kg", "disturbances.kg"],
        ["wind.velocity_m_s.0", "disturbances.velocity_m_s.0"],
        ["wind.gust_m_s", "faults.velocity_m_s.2"],
        ["disturbances.at_s", "faults.at_s"],
        ["disturbances.at_s", "changes.at_s"],
        ["arena.friction", "payload.friction"],
    ] {
        let name = |key: &str| at(&path(key)).unwrap_or_else(|| panic!("{key}")).quantity.name;
        assert_eq!(name(one), name(other), "{one} and {other}");
    }
}

#[test]
fn no_payload_is_written_as_zero_and_no_payload_cannot_be_hung_on_in_flight() {
    let of = |key: &str| at(&path(key)).unwrap();
    assert!(of("payload.mass_kg").allow(0.0) && !of("disturbances.kg").allow(0.0));
    assert_eq!(of("payload.mass_kg").words(), "0 or 0.001..=2 kg");
    assert_eq!(of("disturbances.kg").words(), "0.001..=2 kg");
}

#[test]
fn slips_of_the_unit_are_recognised() {
    for (key, value, slip) in [
        ("payload.mass_kg", 300.0, "300 looks like grams, write 0.3"),
        ("payload.size_m", 5.0, "5 looks like centimetres, write 0.05"),
        ("payload.size_m", 50.0, "50 looks like millimetres, write 0.05"),
        ("sensors.mocap_noise_rad", 20.0, "20 looks like degrees, write 0.349066"),
        ("vehicle.rotors.2.position_m.0", 230.0, "230 looks like centimetres, write 2.3"),
    ] {
        let bounds = at(&path(key)).unwrap();
        assert!(!bounds.allow(value), "{key} = {value}");
        let said = bounds.quantity.slip(value).map(|slip| slip.to_string());
        assert_eq!(said.as_deref(), Some(slip), "{key}");
    }
}

#[test]
fn a_value_that_is_merely_too_large_is_no_slip() {
    for (key, value) in [
        ("payload.mass_kg", 1.5),
        ("payload.mass_kg", 2.5),
        ("payload.mass_kg", -0.3),
        ("payload.mass_kg", f64::NAN),
        ("task.speed_m_s", 3.6),
        ("sensors.mocap_noise_rad", 1.0),
    ] {
        assert_eq!(at(&path(key)).unwrap().quantity.slip(value), None, "{key} = {value}");
    }
}
