//! A limit, and the error that names it.

/// The largest amount of something that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// The largest amount that is read.
    pub most: u64,
    /// What is counted, in the plural.
    pub of: &'static str,
    /// What the user can do about an excess.
    pub remedy: &'static str,
}

impl Limit {
    /// At most `most` of what `of` names; `remedy` says what to do about more.
    pub const fn new(most: u64, of: &'static str, remedy: &'static str) -> Self {
        Self { most, of, remedy }
    }

    /// Refuses an amount above the limit; the limit itself is allowed.
    ///
    /// # Errors
    /// [`Excess`], which says what was found, what is allowed, and what to do.
    pub fn check(&self, found: u64) -> Result<(), Excess> {
        if found > self.most { Err(Excess { found, limit: *self }) } else { Ok(()) }
    }

    /// Refuses a number of items above the limit.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn check_count(&self, found: usize) -> Result<(), Excess> {
        self.check(u64::try_from(found).unwrap_or(u64::MAX))
    }

    /// The limit as a number of items or bytes in memory.
    pub fn count(&self) -> usize {
        usize::try_from(self.most).unwrap_or(usize::MAX)
    }
}

/// More than the budget allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("found {found} {}, at most {} are allowed; {}", .limit.of, .limit.most, .limit.remedy)]
pub struct Excess {
    /// The amount that was found.
    pub found: u64,
    /// The limit that it exceeds.
    pub limit: Limit,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_passes_and_one_more_is_refused_with_limit_finding_and_remedy() {
        let limit = Limit::new(3, "links", "merge some");
        assert_eq!(limit.check(3), Ok(()));
        assert_eq!(limit.check_count(3), Ok(()));
        let said = limit.check_count(4).unwrap_err().to_string();
        assert_eq!(said, "found 4 links, at most 3 are allowed; merge some");
    }
}
