//! The rules of the opener, on real files.

use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::{OutputError, Outputs, replace};

/// A folder of one test, removed when it is dropped.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// Names of all files in the folder.
    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn an_existing_file_stays_unless_it_may_be_replaced() {
    let folder = Folder::new();
    let path = folder.file("a.csv", "before");
    let error = Outputs::new(false).reserve(&path, "-o").unwrap_err();
    assert!(matches!(error, OutputError::Exists { .. }), "{error}");
    assert!(error.to_string().contains("--overwrite"), "{error}");
    assert_eq!(text(&path), "before");
    Outputs::new(true).reserve(&path, "-o").unwrap().write(b"after").unwrap();
    assert_eq!(text(&path), "after");
    assert_eq!(folder.names(), ["a.csv"]);
}

#[cfg(unix)]
#[test]
fn an_input_is_refused_under_every_name_also_to_be_replaced() {
    let folder = Folder::new();
    let input = folder.file("f.mcap", "flight");
    let (link, hard) = (folder.0.path().join("link"), folder.0.path().join("hard"));
    std::os::unix::fs::symlink(&input, &link).unwrap();
    std::fs::hard_link(&input, &hard).unwrap();
    let outputs = Outputs::new(true);
    outputs.protect([&input]);
    for path in [&input, &link, &hard] {
        let error = outputs.reserve(path, "-o").unwrap_err();
        assert!(matches!(error, OutputError::Input { .. }), "{error}");
        let error = outputs.recording(path, "--record").unwrap_err();
        assert!(matches!(error, OutputError::Input { .. }), "{error}");
    }
    assert_eq!(text(&input), "flight");
    assert_eq!(folder.names(), ["f.mcap", "hard", "link"]);
}

#[test]
fn an_input_that_is_named_only_after_the_output_is_still_safe() {
    let folder = Folder::new();
    let path = folder.file("mesh.stl", "solid");
    let outputs = Outputs::new(true);
    let mut sink = outputs.reserve(&path, "-o").unwrap().open().unwrap();
    sink.write_all(b"new").unwrap();
    outputs.protect([&path]);
    assert!(matches!(sink.finish().unwrap_err(), OutputError::Input { .. }));
    assert_eq!((text(&path).as_str(), folder.names().len()), ("solid", 1));
}

#[test]
fn an_output_that_is_dropped_leaves_nothing_behind() {
    let folder = Folder::new();
    let outputs = Outputs::new(false);
    let mut sink = outputs.reserve(&folder.0.path().join("a.csv"), "-o").unwrap().open().unwrap();
    sink.write_all(&vec![b'x'; 100_000]).unwrap();
    assert_eq!(folder.names().len(), 1, "the temporary file");
    drop(sink);
    assert!(folder.names().is_empty(), "{:?}", folder.names());
    let panicked = std::panic::catch_unwind(|| {
        let mut sink =
            Outputs::new(false).reserve(&folder.0.path().join("b"), "-o").unwrap().open().unwrap();
        sink.write_all(b"half").unwrap();
        // A panic without the message of the hook.
        std::panic::resume_unwind(Box::new(()));
    });
    assert!(panicked.is_err() && folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn of_two_that_race_for_one_name_the_second_is_refused() {
    let folder = Folder::new();
    let path = folder.0.path().join("a.csv");
    // Two runs: they share no state.
    let [first, second] =
        [(); 2].map(|()| Outputs::new(false).reserve(&path, "-o").unwrap().open().unwrap());
    first.finish().unwrap();
    assert!(matches!(second.finish().unwrap_err(), OutputError::Exists { .. }));
    assert_eq!(folder.names(), ["a.csv"]);
}

#[test]
fn two_outputs_of_one_run_have_two_places() {
    let folder = Folder::new();
    let outputs = Outputs::new(false);
    let _first = outputs.reserve(&folder.0.path().join("a"), "--junit").unwrap();
    let other_name = folder.0.path().join(".").join("a");
    let error = outputs.reserve(&other_name, "--html").unwrap_err().to_string();
    assert!(error.contains("--junit") && error.contains("--html"), "{error}");
    outputs.reserve_stdout("--json").unwrap();
    let error = outputs.reserve(Path::new("-"), "--csv").unwrap_err().to_string();
    assert!(error.contains("--json") && error.contains("--csv"), "{error}");
}

#[test]
fn a_place_that_takes_no_file_is_refused_with_a_remedy() {
    let folder = Folder::new();
    let outputs = Outputs::new(true);
    for (path, words) in [
        (folder.0.path().to_owned(), ["a folder", "name a file"]),
        (folder.0.path().join("no/such/a.csv"), ["takes no file", "make the folder"]),
        (folder.file("text", "x").join("a.csv"), ["takes no file", "choose"]),
    ] {
        let error = outputs.reserve(&path, "-o").unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
        assert!(error.contains(&path.display().to_string()), "{error}");
    }
    let error = outputs.recording(Path::new("-"), "--record").unwrap_err().to_string();
    assert!(error.contains("name a file"), "{error}");
}

#[test]
fn a_write_protected_file_is_not_replaced() {
    let folder = Folder::new();
    let path = folder.file("a", "before");
    let mut permissions = std::fs::metadata(&path).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&path, permissions).unwrap();
    let error = Outputs::new(true).reserve(&path, "-o").unwrap_err().to_string();
    assert!(error.contains("write-protected"), "{error}");
    assert_eq!(text(&path), "before");
}

#[cfg(unix)]
#[test]
fn a_replaced_file_keeps_its_permissions_and_a_link_stays_a_link() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let path = folder.file("a", "before");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o600)).unwrap();
    let link = folder.0.path().join("link");
    std::os::unix::fs::symlink(&path, &link).unwrap();
    Outputs::new(true).reserve(&link, "-o").unwrap().write(b"after").unwrap();
    assert_eq!(text(&path), "after");
    assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
    assert!(link.symlink_metadata().unwrap().is_symlink());
    replace(&link, b"again").unwrap();
    assert_eq!(text(&path), "again");
    assert!(link.symlink_metadata().unwrap().is_symlink());
}

#[cfg(unix)]
#[test]
fn a_device_is_written_directly_and_a_full_one_is_an_error_that_names_it() {
    let outputs = Outputs::new(false);
    outputs.reserve(Path::new("/dev/null"), "-o").unwrap().write(b"x").unwrap();
    outputs.reserve(Path::new("/dev/null"), "--html").unwrap().write(b"x").unwrap();
    if Path::new("/dev/full").exists() {
        let full = outputs.reserve(Path::new("/dev/full"), "-o").unwrap();
        let error = full.write(&vec![b'x'; 100_000]).unwrap_err();
        assert!(error.is_failed_write(), "{error}");
        assert_eq!(error.to_string().matches("/dev/full").count(), 1, "{error}");
    }
}

#[test]
fn a_recording_takes_the_next_free_number_and_says_so() {
    let folder = Folder::new();
    let path = folder.0.path().join("flight.mcap");
    let outputs = Outputs::new(false);
    let files = [(); 3].map(|()| outputs.recording(&path, "--record").unwrap());
    let names = files.each_ref().map(|file| file.path().file_name().unwrap().to_owned());
    assert_eq!(
        names,
        ["flight.mcap", "flight-2.mcap", "flight-3.mcap"].map(std::ffi::OsString::from)
    );
    assert_eq!(files[0].renamed(), None);
    let said = files[2].renamed().unwrap();
    assert!(said.contains("flight.mcap exists") && said.contains("flight-3.mcap"), "{said}");
}

#[test]
fn only_a_finished_recording_is_replaced() {
    let folder = Folder::new();
    let path = folder.0.path().join("flight.mcap");
    let growing = Outputs::new(false).recording(&path, "--record").unwrap();
    let error = Outputs::new(true).recording(&path, "--record").unwrap_err().to_string();
    assert!(error.contains("another process is recording"), "{error}");
    drop(growing);
    let again = Outputs::new(true).recording(&path, "--record").unwrap();
    assert_eq!((again.path(), again.renamed()), (path.as_path(), None));
    // Neither a second recording of the same run nor that of a restart replaces one.
    let run = Outputs::new(true);
    drop(again);
    drop(run.recording(&path, "--record").unwrap());
    assert_ne!(run.recording(&path, "--record").unwrap().path(), path);
    assert_ne!(Outputs::new(true).next_recording(&path, "--record").unwrap().path(), path);
    assert_eq!(folder.names(), ["flight-2.mcap", "flight-3.mcap", "flight.mcap"]);
}

#[test]
fn a_failed_replacement_leaves_the_file_before_it_and_nothing_else() {
    let folder = Folder::new();
    let path = folder.file("w.checkpoint", "before");
    replace(&path, b"after").unwrap();
    assert_eq!(text(&path), "after");
    // A folder of this name cannot be replaced by a file.
    let taken = folder.0.path().join("taken");
    std::fs::create_dir_all(taken.join("inside")).unwrap();
    assert!(replace(&taken, b"x").unwrap_err().is_failed_write());
    assert_eq!(folder.names(), ["taken", "w.checkpoint"]);
}
