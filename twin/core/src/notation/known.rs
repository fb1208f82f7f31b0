//! Values per coordinate, some of which may be unknown. Every record of the loop carries which of its values are known.
//!
//! In files only [`KnownCoords`] writes an unknown value as `null` and reads `null` as unknown.

use std::ops::{Deref, Index, IndexMut};

use serde::{Deserialize, Deserializer, Serialize, Serializer, ser::SerializeTuple};

use super::{Coords, N};

/// Which coordinates are known, `[x y z phi theta psi q1 q2]`.
pub type KnownMask = [bool; N];

/// One value per generalised coordinate, each known or unknown.
///
/// It dereferences to [`Coords`], in which an unknown value is NaN and so cannot pass for a number. A stage that needs a number in every
/// coordinate calls [`KnownCoords::or`] with the numbers to use. A known value that is not finite is a fault of its source, not an unknown
/// value.
#[derive(Clone, Copy, Debug)]
pub struct KnownCoords {
    values: Coords,
    known: KnownMask,
}

impl KnownCoords {
    /// From one value per coordinate; `None` is unknown.
    pub fn from_rows(rows: &[Option<f64>; N]) -> Self {
        Self {
            values: Coords::from_fn(|row, _| rows[row].unwrap_or(f64::NAN)),
            known: rows.map(|value| value.is_some()),
        }
    }

    /// All coordinates unknown.
    pub fn unknown() -> Self {
        Self::from_rows(&[None; N])
    }

    /// The value of the coordinate `row`; `None` if it is unknown.
    pub fn get(&self, row: usize) -> Option<f64> {
        self.known[row].then_some(self.values[row])
    }

    /// The coordinates that are known.
    pub fn known(&self) -> KnownMask {
        self.known
    }

    /// True if at least one coordinate is known.
    pub fn is_any_known(&self) -> bool {
        self.known.contains(&true)
    }

    /// The same values, where those that are unknown in `known` become unknown.
    #[must_use]
    pub fn only(&self, known: KnownMask) -> Self {
        Self::from_rows(&std::array::from_fn(|row| self.get(row).filter(|_| known[row])))
    }

    /// A number in every coordinate: the value of `stand_in` where the coordinate is unknown.
    pub fn or(&self, stand_in: &Coords) -> Coords {
        Coords::from_fn(|row, _| self.get(row).unwrap_or(stand_in[row]))
    }

    /// True if no known value is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        (0..N).filter_map(|row| self.get(row)).all(f64::is_finite)
    }
}

/// The coordinates that are known in both.
pub fn known_in_both(one: KnownMask, other: KnownMask) -> KnownMask {
    std::array::from_fn(|row| one[row] && other[row])
}

impl From<Coords> for KnownCoords {
    /// All coordinates are known.
    fn from(values: Coords) -> Self {
        Self { values, known: [true; N] }
    }
}

impl Deref for KnownCoords {
    type Target = Coords;

    fn deref(&self) -> &Coords {
        &self.values
    }
}

impl Index<usize> for KnownCoords {
    type Output = f64;

    fn index(&self, row: usize) -> &f64 {
        &self.values[row]
    }
}

impl IndexMut<usize> for KnownCoords {
    /// A coordinate that is written becomes known.
    fn index_mut(&mut self, row: usize) -> &mut f64 {
        self.known[row] = true;
        &mut self.values[row]
    }
}

impl PartialEq for KnownCoords {
    /// Equal if the same coordinates are known and have equal values.
    fn eq(&self, other: &Self) -> bool {
        (0..N).all(|row| self.get(row) == other.get(row))
    }
}

impl Serialize for KnownCoords {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut rows = serializer.serialize_tuple(N)?;
        for row in 0..N {
            rows.serialize_element(&self.get(row))?;
        }
        rows.end()
    }
}

impl<'de> Deserialize<'de> for KnownCoords {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self::from_rows(&<[Option<f64>; N]>::deserialize(deserializer)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn partly() -> KnownCoords {
        let rows = [Some(1.5), None, Some(-2.0), None, Some(0.25), Some(0.0), None, Some(8.0)];
        KnownCoords::from_rows(&rows)
    }

    #[test]
    fn an_unknown_row_is_never_a_number_until_a_stage_says_which_one() {
        let values = partly();
        assert!(values[1].is_nan() && values.get(1).is_none() && values.is_any_known());
        assert_eq!(
            values.or(&Coords::repeat(7.0)).as_slice(),
            [1.5, 7.0, -2.0, 7.0, 0.25, 0.0, 7.0, 8.0]
        );
        assert!(values.is_finite(), "an unknown row is no fault");
        let mut faulty = values;
        faulty[0] = f64::NAN;
        assert!(!faulty.is_finite() && faulty.known()[0], "a known row that is no number is one");
    }

    #[test]
    fn unknown_is_null_in_json_and_known_numbers_are_written_as_plain_coordinates_are() {
        let text = serde_json::to_string(&partly()).unwrap();
        assert_eq!(text, "[1.5,null,-2.0,null,0.25,0.0,null,8.0]");
        assert_eq!(serde_json::from_str::<KnownCoords>(&text).unwrap(), partly());
        let all = Coords::from_fn(|row, _| 0.1 * row as f64);
        let plain = serde_json::to_string(&all).unwrap();
        assert_eq!(serde_json::to_string(&KnownCoords::from(all)).unwrap(), plain);
        assert_eq!(serde_json::from_str::<KnownCoords>(&plain).unwrap(), all.into());
    }

    proptest! {
        #[test]
        fn what_is_taken_away_stays_unknown_and_the_rest_as_it_was(known in any::<KnownMask>(), value in -1e9..1e9f64) {
            let values = KnownCoords::from(Coords::repeat(value)).only(known);
            prop_assert_eq!(values.known(), known);
            prop_assert_eq!(values.only([true; N]), values);
            for (row, known) in known.iter().enumerate() {
                prop_assert_eq!(values.get(row).map(f64::to_bits), known.then_some(value.to_bits()));
            }
        }
    }
}
