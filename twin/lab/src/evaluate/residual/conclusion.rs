//! A sentence about the effect for which the long window helps.

use super::foreseen::Foreseen;
use super::variant::Variant;

/// Smaller differences of the ratio of two errors count as none.
const NOTICEABLE: f64 = 0.005;

const RATIO: &str = "the RMSE with 120 ticks divided by the RMSE with 10 ticks";

/// The sentence; the first of `foresight` has everything on.
pub(super) fn conclusion(foresight: &[Foreseen]) -> String {
    let Some(on) = foresight.first().map(Foreseen::ratio).filter(|ratio| ratio.is_finite()) else {
        return "No forecast was scored: the flights are too short for windows of 1.2 s and the 0.2 s after them."
            .to_owned();
    };
    if 1.0 - on < NOTICEABLE {
        return format!(
            "The long window does not help: {RATIO} is {on:.3} with everything on, as mean over the horizons."
        );
    }
    let without = foresight.iter().filter_map(|foreseen| match foreseen.variant {
        Variant::Without(name) => Some((name, foreseen.ratio())).filter(|(_, r)| r.is_finite()),
        Variant::On | Variant::Off => None,
    });
    match without.max_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((name, ratio)) if ratio - on >= NOTICEABLE => format!(
            "The long window helps most because of {name}: {RATIO} rises from {on:.3} to {ratio:.3} without this effect, as mean \
             over the horizons."
        ),
        _ => format!(
            "The long window helps, but no single effect is the reason: {RATIO} is {on:.3} as mean over the horizons, and no effect \
             raises it by {NOTICEABLE} or more when it is off."
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::ResidualTable;
    use super::super::table::tests::{measured, table};
    use super::*;

    fn foresight(rmse_on: [f64; 3], rmse_without: [f64; 3]) -> Vec<Foreseen> {
        let of = |variant, rmse| measured(variant, [[1.0; 3]; 2], rmse);
        let (on, without) = (of(Variant::On, rmse_on), of(Variant::Without("gust"), rmse_without));
        ResidualTable::new(String::new(), &on, vec![without]).foresight
    }

    #[test]
    fn the_sentence_names_the_effect_whose_removal_makes_the_long_window_useless() {
        let sentence = table().conclusion;
        assert!(sentence.contains("because of big"), "{sentence}");
        assert!(sentence.contains("from 0.800 to 1.000"), "{sentence}");
    }

    #[test]
    fn no_effect_is_named_without_reason() {
        let same = conclusion(&foresight([1.0, 0.5, 0.4], [1.0, 0.5, 0.4]));
        assert!(same.contains("no single effect"), "{same}");
        let useless = conclusion(&foresight([1.0, 0.5, 0.5], [1.0, 0.5, 0.4]));
        assert!(useless.contains("does not help"), "{useless}");
        let unknown = conclusion(&foresight([1.0, f64::NAN, f64::NAN], [1.0, 0.5, 0.4]));
        assert!(unknown.contains("too short"), "{unknown}");
    }
}
