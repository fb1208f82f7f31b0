//! The handlers of SIGINT, SIGTERM and SIGHUP. The first signal asks the command to end in order; a second SIGINT or SIGTERM ends the
//! program at once. A second SIGHUP does not, because the end of one terminal can send it twice.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::Context;
use signal_hook::flag;
use twin_input::interruption::{Signal, inbox};

/// Installs the handlers, for a command that has files to finish.
pub(super) fn catch() -> anyhow::Result<()> {
    let asked = Arc::new(AtomicBool::new(false));
    for signal in Signal::ALL.into_iter().filter(|signal| !is_ignored(*signal)) {
        install(signal, &asked).with_context(|| format!("{signal} cannot be caught"))?;
    }
    survive_full_files().context("SIGXFSZ cannot be caught")
}

/// A file that reaches the limit of the shell (`ulimit -f`) becomes an error of its writer, instead of the end of the program.
#[cfg(unix)]
fn survive_full_files() -> std::io::Result<()> {
    flag::register(signal_hook::consts::SIGXFSZ, Arc::default()).map(|_| ())
}

#[cfg(not(unix))]
fn survive_full_files() -> std::io::Result<()> {
    Ok(())
}

fn install(signal: Signal, asked: &Arc<AtomicBool>) -> std::io::Result<()> {
    let number = i32::from(signal.number());
    // Actions run in the order of their registration: this one does nothing until one below has run.
    if signal != Signal::HangUp {
        let code = signal.exit_code().into();
        flag::register_conditional_shutdown(number, code, Arc::clone(asked))?;
    }
    flag::register(number, Arc::clone(asked))?;
    flag::register_usize(number, Arc::clone(inbox()), number as usize)?;
    Ok(())
}

/// Whether SIGHUP is not to be caught: the caller asked this program to survive the end of its terminal, as `nohup` does, or the
/// system has no such signal.
fn is_ignored(signal: Signal) -> bool {
    signal == Signal::HangUp && (cfg!(not(unix)) || hang_up_is_ignored())
}

/// Linux tells which signals a program ignores; elsewhere SIGHUP is caught.
fn hang_up_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    (mask >> (Signal::HangUp.number() - 1)) & 1 == 1
}
