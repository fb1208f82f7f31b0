//! Writes the gains in force as the `[gains]` table of a scenario file.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::server::protocol::GainInfo;
use crate::server::published::Published;
use twin_core::notation::COORDINATE_NAMES;

/// The preset chosen last and the gains whose values differ from it, as TOML. A comment names the flight and the tick.
pub(super) fn text(published: &Published) -> String {
    let state = &published.state;
    let mut text = format!(
        "# Gains in force at tick {} ({:.2} s) of {}, seed {}.\n# Put this table into a scenario file.\n[gains]\npreset = \"{}\"\n",
        state.tick,
        state.t_s,
        state.scenario,
        state.seed,
        crate::server::served_flight::word(&published.base),
    );
    let values: BTreeMap<&str, f64> =
        published.gains.iter().map(|gain| (gain.name.as_str(), gain.value)).collect();
    for stem in ["slope", "damping", "lead"] {
        let row = |row: &&str| values.get(format!("{stem}.{row}").as_str()).copied();
        let all: Option<Vec<String>> =
            COORDINATE_NAMES.iter().map(|r| row(r).map(number)).collect();
        let of_stem = |gain: &&GainInfo| gain.name.split_once('.').is_some_and(|(s, _)| s == stem);
        if let (Some(all), true) = (all, published.gains.iter().filter(of_stem).any(differs)) {
            let _ = writeln!(text, "{stem} = [{}]", all.join(", "));
        }
    }
    for gain in published.gains.iter().filter(|gain| !gain.name.contains('.') && differs(gain)) {
        let _ = writeln!(text, "{} = {}", gain.name, number(gain.value));
    }
    text
}

fn differs(gain: &GainInfo) -> bool {
    gain.value.to_bits() != gain.preset_value.to_bits()
}

/// A number as a TOML float; it always has a decimal point or an exponent, because TOML reads it as an integer otherwise.
fn number(value: f64) -> String {
    format!("{value:?}")
}
