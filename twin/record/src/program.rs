//! Which program flies: recordings, reports and trained weights name it.

use std::sync::OnceLock;

/// Version of the program, as its package states it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

static COMMIT: OnceLock<&'static str> = OnceLock::new();

/// States the commit that the program was built from. `main` calls this once, before anything else; later calls change nothing.
///
/// The commit comes from `main` and not from a build script of a library, because a commit would otherwise rebuild every crate.
pub fn set_commit(commit: &'static str) {
    COMMIT.get_or_init(|| commit);
}

/// Commit that the program was built from, twelve hex digits; `unknown` outside a checkout and in tests.
pub fn commit() -> &'static str {
    COMMIT.get().copied().unwrap_or("unknown")
}
