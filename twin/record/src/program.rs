//! The identity of this program, which recordings, reports and trained weights name.

use std::sync::OnceLock;

/// Version of the program, as its package states it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

static COMMIT: OnceLock<&'static str> = OnceLock::new();

/// States the commit that the program was built from. `main` calls this once, before anything else; later calls change nothing.
///
/// `main` gives the commit. A build script of a library would have to read it, too, and every commit would then rebuild every crate.
pub fn set_commit(commit: &'static str) {
    COMMIT.get_or_init(|| commit);
}

/// Commit that the program was built from, twelve hex digits; `unknown` outside a checkout and in tests.
pub fn commit() -> &'static str {
    COMMIT.get().copied().unwrap_or("unknown")
}
