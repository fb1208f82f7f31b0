//! Bounds what compressed bytes may become.

use crate::budget::{RECORD_BYTES, UNPACKED_BYTES, UNPACKED_RATIO};

/// The compressed and the unpacked bytes of an input so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inflation {
    packed: u64,
    unpacked: u64,
}

/// A piece claims to become more bytes than the budget allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it claims {claimed} bytes unpacked from {packed}, at most {most} are unpacked here")]
pub struct TooInflated {
    /// Unpacked bytes that the piece claims.
    pub claimed: u64,
    /// Its compressed bytes.
    pub packed: u64,
    /// Unpacked bytes that it may have.
    pub most: u64,
}

impl Inflation {
    /// Adds a piece of `packed` bytes that claims to become `claimed` bytes. A refused piece is not added.
    ///
    /// # Errors
    /// [`TooInflated`] if one piece, or all pieces together, would become too large.
    pub fn add(&mut self, packed: u64, claimed: u64) -> Result<(), TooInflated> {
        let all = self.packed.saturating_add(packed);
        let together = UNPACKED_BYTES.saturating_add(all.saturating_mul(UNPACKED_RATIO));
        let most = RECORD_BYTES.most.min(together.saturating_sub(self.unpacked));
        if claimed > most {
            return Err(TooInflated { claimed, packed, most });
        }
        (self.packed, self.unpacked) = (all, self.unpacked + claimed);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_piece_may_be_as_large_as_a_record_and_not_one_byte_larger() {
        let most = RECORD_BYTES.most;
        assert_eq!(Inflation::default().add(1, most), Ok(()));
        let refused = Inflation::default().add(1 << 30, most + 1);
        assert_eq!(refused, Err(TooInflated { claimed: most + 1, packed: 1 << 30, most }));
    }

    #[test]
    fn all_pieces_together_obey_the_ratio() {
        let mut inflation = Inflation::default();
        assert_eq!(inflation.add(1000, UNPACKED_BYTES), Ok(()));
        let left = 1000 * UNPACKED_RATIO;
        let mut other = inflation;
        assert_eq!(other.add(0, left), Ok(()));
        assert!(inflation.add(0, left + 1).is_err());
        // A piece with an ordinary ratio passes however much was read before.
        for _ in 0..100_000 {
            assert_eq!(inflation.add(1 << 20, 20 << 20), Ok(()));
        }
    }
}
