//! glibc's allocator gives every large buffer back to the kernel, and a training asks for hundreds of them per step: keeping
//! them takes a fifth to a quarter off its processor time (measured with these values at widths 64 and 128). The values are
//! read when a process starts, so the program starts itself again with them.

/// Threshold of mapped buffers, of giving back, and what is asked for in advance, bytes.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const KEEP: [(&str, &str); 3] = [
    ("MALLOC_MMAP_THRESHOLD_", "8000000000"),
    ("MALLOC_TRIM_THRESHOLD_", "16000000000"),
    ("MALLOC_TOP_PAD_", "100000000"),
];

/// Becomes the same program with the same arguments and [`KEEP`]; returns if one of the values is set already, or if that
/// cannot be done: then it is only slower.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(super) fn keep_memory() {
    use std::os::unix::process::CommandExt;
    if KEEP.iter().any(|(name, _)| std::env::var_os(name).is_some()) {
        return;
    }
    if let Ok(program) = std::env::current_exe() {
        let why =
            std::process::Command::new(program).args(std::env::args_os().skip(1)).envs(KEEP).exec();
        tracing::warn!("the allocator's settings could not be changed, training is slower: {why}");
    }
}

/// Other systems have other allocators.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(super) fn keep_memory() {}
