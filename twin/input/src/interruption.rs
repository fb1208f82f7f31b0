//! The signal that asks this program to end.
//!
//! In: the handlers of the program write the number of a signal into [`inbox`]. Out: [`requested`] and [`check`], which every loop
//! asks once per tick, record or case, so that it ends in order and finishes its files. State: one number for the whole process,
//! because a signal is sent to the whole process.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// A signal that asks the program to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// SIGHUP: the terminal was closed.
    HangUp,
    /// SIGINT: Ctrl+C.
    Interrupt,
    /// SIGTERM: another program asks this one to end.
    Terminate,
}

impl Signal {
    /// All signals that ask the program to end.
    pub const ALL: [Self; 3] = [Self::HangUp, Self::Interrupt, Self::Terminate];

    /// Number of the signal, as in POSIX.
    pub const fn number(self) -> u8 {
        match self {
            Self::HangUp => 1,
            Self::Interrupt => 2,
            Self::Terminate => 15,
        }
    }

    /// Exit code of a program that the signal ended: 128 + its number, as shells report it.
    pub const fn exit_code(self) -> u8 {
        128 + self.number()
    }
}

impl std::fmt::Display for Signal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::HangUp => "SIGHUP",
            Self::Interrupt => "SIGINT (Ctrl+C)",
            Self::Terminate => "SIGTERM",
        })
    }
}

/// A signal asked the program to end before its work was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("interrupted by {0}")]
pub struct Interrupted(pub Signal);

/// The place for the number of a signal; 0 until one arrives. Handlers of signals write into it.
pub fn inbox() -> &'static Arc<AtomicUsize> {
    static INBOX: OnceLock<Arc<AtomicUsize>> = OnceLock::new();
    INBOX.get_or_init(Arc::default)
}

/// The signal that asked the program to end, if there was one.
pub fn requested() -> Option<Signal> {
    let number = inbox().load(Ordering::Relaxed);
    Signal::ALL.into_iter().find(|signal| usize::from(signal.number()) == number)
}

/// Says whether the work may go on.
///
/// # Errors
/// [`Interrupted`] once a signal has asked the program to end.
pub fn check() -> Result<(), Interrupted> {
    requested().map_or(Ok(()), |signal| Err(Interrupted(signal)))
}
