//! Whether the free space of a disk lasts for a recording.

use std::path::Path;

/// Bytes per second of a recording, from above: a hover writes 0.26 MB/s, a mission with a payload 0.40 MB/s.
const BYTES_PER_S: f64 = 4.5e5;

/// Bytes of one MB, as people are told.
const MB: f64 = 1e6;

/// A sentence if the disk under `path` has too little space for a recording of `planned_s` seconds.
pub(super) fn shortage(path: &Path, planned_s: f64) -> Option<String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let free = free_bytes(folder.unwrap_or_else(|| Path::new(".")))?;
    sentence(path, free as f64, planned_s)
}

fn sentence(path: &Path, free: f64, planned_s: f64) -> Option<String> {
    let needed = planned_s * BYTES_PER_S;
    (free < needed).then(|| {
        format!(
            "{}: the disk has {:.1} MB free, and a recording of {planned_s:.0} s may need {:.1} MB ({:.2} MB/s); it may end after {:.0} s: free some space, or record to another disk",
            path.display(),
            free / MB,
            needed / MB,
            BYTES_PER_S / MB,
            (free / BYTES_PER_S).floor()
        )
    })
}

/// Bytes that this user may still write to the disk of `folder`; `None` if the system does not tell.
#[cfg(unix)]
fn free_bytes(folder: &Path) -> Option<u64> {
    let disk = rustix::fs::statvfs(folder).ok()?;
    disk.f_bavail.checked_mul(disk.f_frsize)
}

#[cfg(not(unix))]
fn free_bytes(_: &Path) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_that_is_too_small_is_named_with_the_numbers() {
        let path = Path::new("flight.mcap");
        assert_eq!(sentence(path, 1e9, 160.0), None);
        let said = sentence(path, 1e6, 160.0).expect("a warning");
        for part in ["flight.mcap", "1.0 MB free", "160 s", "72.0 MB", "0.45 MB/s", "after 2 s"] {
            assert!(said.contains(part), "{part} is not in: {said}");
        }
        assert!(free_bytes(Path::new(".")).is_none_or(|free| free > 0));
    }
}
