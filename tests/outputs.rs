//! Outputs through the real program: no input is destroyed, nothing is overwritten unasked, and a failure leaves nothing behind.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::folder;
use twin_record::read_ticks;

/// A temporary folder with a recording, removed when it is dropped.
struct Folder(folder::Folder);

impl Folder {
    fn new(name: &str) -> Self {
        Self(folder::Folder::new(name))
    }

    /// A folder with the recording `f.mcap` of a short hover.
    fn recorded(name: &str) -> Self {
        let folder = Self::new(name);
        let flown = Folder::fly(&["--record", &folder.path("f.mcap")]);
        assert_eq!(flown.status.code(), Some(0), "{}", stderr(&flown));
        folder
    }

    fn path(&self, name: &str) -> String {
        self.0.path(name).to_str().expect("a path of ASCII").to_owned()
    }

    /// Names of all files, in order.
    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path("")).expect("the folder");
        let mut names: Vec<String> = entries
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.0.path(name)).expect("the file")
    }

    /// Flies a hover of half a second without a server.
    fn fly(more: &[&str]) -> Output {
        twin(&flight(more))
    }
}

/// Ticks of the hover.
const TICKS: usize = 50;

fn flight<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let mut arguments =
        vec!["fly", "scenarios/hover.toml", "--headless", "--set", "task.duration_s=0.5"];
    arguments.extend(more);
    arguments
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_twin"));
    command.args(arguments).current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

fn twin(arguments: &[&str]) -> Output {
    command(arguments).output().expect("the program starts")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Asserts exit code 2 and every text of `wanted` on stderr.
fn refused(arguments: &[&str], wanted: &[&str]) {
    let output = twin(arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    for part in wanted {
        assert!(said.contains(part), "{arguments:?}: {part:?} is missing in: {said}");
    }
}

#[test]
fn an_output_that_is_the_input_is_refused_also_with_overwrite() {
    let folder = Folder::recorded("input");
    let file = folder.path("f.mcap");
    let before = folder.bytes("f.mcap");
    let mut names = vec![file.clone()];
    if cfg!(unix) {
        let (link, hard) = (folder.path("link.html"), folder.path("hard.html"));
        #[cfg(unix)]
        std::os::unix::fs::symlink(&file, &link).expect("a symbolic link");
        std::fs::hard_link(&file, &hard).expect("a hard link");
        names.extend([link, hard]);
    }
    let present = folder.names();
    for name in &names {
        for arguments in [
            vec!["export", "csv", &file, "-o", name],
            vec!["export", "html", &file, "-o", name],
            vec!["export", "viser", &file, "-o", name],
            vec!["mirror", &file, "--headless", "--plot", name],
            vec!["mirror", &file, "--headless", "--record", name],
            // The names also the other way round: the link is read, and the file is written.
            vec!["export", "html", name, "-o", &file],
        ] {
            refused(&arguments, &[name, "which this command reads", "choose another file"]);
            let overwriting = [&arguments[..], &["--overwrite"]].concat();
            refused(&overwriting, &[name, "which this command reads"]);
        }
    }
    assert!(folder.bytes("f.mcap") == before && folder.names() == present);
}

#[test]
fn a_scenario_its_model_and_its_weights_are_inputs_of_a_test_and_a_flight() {
    let folder = Folder::new("scenario");
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/aerial_manipulator.urdf");
    std::fs::copy(urdf, folder.path("v.urdf")).expect("a copy");
    let text = "[vehicle]\nurdf = \"v.urdf\"\n[task]\nkind = \"hover\"\nduration_s = 0.5\n";
    let scenario = folder.path("s.toml");
    std::fs::write(&scenario, text).expect("a scenario");
    let model = folder.bytes("v.urdf");
    for name in ["s.toml", "v.urdf"] {
        let path = folder.path(name);
        for flag in ["--junit", "--html"] {
            refused(&["test", &scenario, flag, &path, "--overwrite"], &[flag, name, "reads"]);
        }
        let table = ["evaluate", "l1", &scenario, "--csv", &path, "--overwrite"];
        refused(&table, &["--csv", name, "reads"]);
        let record = ["fly", &scenario, "--headless", "--record", &path, "--overwrite"];
        refused(&record, &["--record", name, "reads"]);
    }
    // Without --overwrite they are refused, too.
    refused(&["test", &scenario, "--junit", &scenario], &["--junit", "s.toml"]);
    assert!(folder.bytes("s.toml") == text.as_bytes() && folder.bytes("v.urdf") == model);
    assert_eq!(folder.names(), ["s.toml", "v.urdf"]);
}

#[test]
fn an_existing_output_is_replaced_only_with_overwrite() {
    let folder = Folder::recorded("exists");
    let (file, page) = (folder.path("f.mcap"), folder.path("page"));
    std::fs::write(&page, "mine").expect("a file");
    refused(&["export", "viser", &file, "-o", &page], &[&page, "would overwrite", "--overwrite"]);
    refused(&["export", "html", &file, "-o", &page], &[&page, "would overwrite", "--overwrite"]);
    refused(&["export", "csv", &file, "-o", &page], &[&page, "--overwrite"]);
    refused(&["mirror", &file, "--headless", "--plot", &page], &[&page, "--overwrite"]);
    refused(&["test", "scenarios/hover.toml", "--junit", &page], &[&page, "--overwrite"]);
    refused(&["evaluate", "l1", "--csv", &page], &[&page, "--overwrite"]);
    refused(&["evaluate", "residual", "--html", &page], &[&page, "--overwrite"]);
    assert_eq!(folder.bytes("page"), b"mine");
    let done = twin(&["export", "viser", &file, "-o", &page, "--overwrite"]);
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    assert!(folder.bytes("page").len() > 1000);
    // The default place is an output like any other.
    assert_eq!(twin(&["export", "viser", &file]).status.code(), Some(0));
    refused(&["export", "viser", &file], &["f.viser", "--overwrite"]);
    assert_eq!(folder.names(), ["f.mcap", "f.viser", "page"]);
}

#[test]
fn a_collection_is_refused_before_its_first_flight_if_one_of_its_files_exists() {
    let folder = Folder::new("collect");
    // The names tell a training what the flights are, so these recordings are not numbered.
    for name in ["collect_200g.mcap", "collect.json"] {
        std::fs::write(folder.path(name), "mine").expect("a file");
        refused(&["collect", "--out", &folder.path("")], &[name, "--out", "--overwrite"]);
        assert_eq!((folder.bytes(name), folder.names()), (b"mine".to_vec(), vec![name.to_owned()]));
        std::fs::remove_file(folder.path(name)).expect("it is there");
    }
}

#[test]
fn a_second_recording_takes_the_next_free_number_and_says_so() {
    let folder = Folder::recorded("second");
    let file = folder.path("f.mcap");
    let first = folder.bytes("f.mcap");
    let again = Folder::fly(&["--record", &file, "--json"]);
    let said = stderr(&again);
    assert!(said.contains("f.mcap exists") && said.contains("f-2.mcap"), "{said}");
    let found: serde_json::Value = serde_json::from_slice(&again.stdout).expect("one object");
    assert_eq!(found["recording"]["file"], folder.path("f-2.mcap"));
    assert!(folder.bytes("f.mcap") == first);
    let replaced = Folder::fly(&["--record", &file, "--overwrite", "--set", "task.duration_s=0.3"]);
    assert_eq!(replaced.status.code(), Some(0), "{}", stderr(&replaced));
    let ticks = |name: &str| read_ticks(&folder.0.path(name)).expect("a recording").len();
    assert_eq!((ticks("f.mcap"), ticks("f-2.mcap")), (30, TICKS));
    assert_eq!(folder.names(), ["f-2.mcap", "f.mcap"]);
}

#[test]
fn two_flights_at_once_never_share_a_recording() {
    let folder = Folder::new("race");
    let file = folder.path("two.mcap");
    let flights: Vec<_> = [(); 4]
        .map(|()| {
            let mut flight = command(&flight(&["--record", &file]));
            flight.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts")
        })
        .into_iter()
        .map(|flight| flight.wait_with_output().expect("it ends"))
        .collect();
    let said: String = flights.iter().map(stderr).collect();
    assert!(flights.iter().all(|flight| flight.status.code() == Some(0)), "{said}");
    assert_eq!(said.matches("two.mcap exists").count(), 3, "{said}");
    let names = folder.names();
    assert_eq!(names, ["two-2.mcap", "two-3.mcap", "two-4.mcap", "two.mcap"]);
    for name in names {
        assert_eq!(read_ticks(&folder.0.path(&name)).expect("a whole recording").len(), TICKS);
    }
}

#[test]
fn a_place_that_takes_no_file_is_refused_before_the_work() {
    let folder = Folder::recorded("places");
    let (file, protected) = (folder.path("f.mcap"), folder.path("protected.html"));
    refused(
        &["export", "html", &file, "-o", &folder.path("no/page.html")],
        &["no/page.html", "No such file", "make the folder first"],
    );
    refused(&["export", "csv", &file, "-o", &folder.path("")], &["a folder", "name a file"]);
    refused(
        &["export", "csv", &file, "-o", &folder.path("f.mcap/a.csv")],
        &["f.mcap/a.csv", "takes no file"],
    );
    std::fs::write(&protected, "mine").expect("a file");
    let mut permissions = std::fs::metadata(&protected).expect("the file").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&protected, permissions).expect("the owner may");
    let page = ["export", "html", &file, "-o", &protected, "--overwrite"];
    refused(&page, &["protected.html", "write-protected"]);
    assert_eq!(folder.bytes("protected.html"), b"mine");
    refused(&["fly", "scenarios/hover.toml", "--headless", "--record", "-"], &["name a file"]);
    assert_eq!(folder.names(), ["f.mcap", "protected.html"]);
}

#[test]
fn two_outputs_of_one_command_have_two_places() {
    let folder = Folder::new("twice");
    let one = folder.path("one");
    let both = |arguments: &[&str], flags: [&str; 2]| {
        let all = [&["test", "scenarios/hover.toml"], arguments].concat();
        refused(&all, &[flags[0], flags[1], "choose two places"]);
    };
    both(&["--junit", &one, "--html", &one], ["--junit", "--html"]);
    both(&["--junit", "-", "--json"], ["--junit", "--json"]);
    both(&["--junit", "-", "--html", "/dev/stdout"], ["--junit", "--html"]);
    assert!(folder.names().is_empty());
}

#[test]
fn a_dash_is_stdout_and_the_text_for_people_then_goes_to_stderr() {
    let folder = Folder::recorded("dash");
    let (file, csv) = (folder.path("f.mcap"), folder.path("f.csv"));
    assert_eq!(twin(&["export", "csv", &file, "-o", &csv]).status.code(), Some(0));
    let table = folder.bytes("f.csv");
    assert_eq!(table.split(|byte| *byte == b'\n').count(), TICKS + 2);
    for arguments in [
        &["export", "csv", &file][..],
        &["export", "csv", &file, "-o", "-"],
        &["export", "csv", &file, "-o", "/dev/stdout"],
    ] {
        let output = twin(arguments);
        assert!(output.status.code() == Some(0) && output.stdout == table, "{arguments:?}");
    }
    let picture = twin(&["mirror", &file, "--headless", "--plot", "-"]);
    assert!(String::from_utf8_lossy(&picture.stdout).starts_with("<svg"), "{picture:?}");
    assert!(stderr(&picture).contains("predictor:"), "{}", stderr(&picture));
    let viser = twin(&["export", "viser", &file, "-o", "-"]);
    // A length of eight bytes, then the first bytes of every zstd frame.
    assert_eq!(viser.stdout.get(8..12), Some(&[0x28, 0xb5, 0x2f, 0xfd][..]), "{}", stderr(&viser));
    assert_eq!(folder.names(), ["f.csv", "f.mcap"]);
}

#[cfg(unix)]
#[test]
fn an_export_that_fails_midway_leaves_nothing_behind() {
    let folder = Folder::recorded("midway");
    let file = folder.path("f.mcap");
    let before = folder.names();
    for (kind, name) in [("csv", "f.csv"), ("viser", "f.viser")] {
        // A limit of 4 KiB on the length of a file stands for a full disk: it needs no mount. The signal would end the program.
        let script = "trap '' XFSZ; ulimit -f 8; exec \"$0\" export \"$1\" \"$2\" -o \"$3\"";
        let output = Command::new("sh")
            .args(["-c", script, env!("CARGO_BIN_EXE_twin"), kind, &file, &folder.path(name)])
            .output()
            .expect("a shell");
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{kind}: {said}");
        assert!(said.contains(name) && said.contains("cannot be written"), "{kind}: {said}");
        assert_eq!(folder.names(), before, "{kind}");
    }
}

/// Commands that print results, and their usual exit code; `F` is a recording and `G` another one.
const PRINTING: &[(&[&str], i32)] = &[
    (&["fly", "scenarios/hover.toml", "--headless", "--json", "--set", "task.duration_s=0.1"], 0),
    (&["fly", "scenarios/hover.toml", "--headless", "--set", "task.duration_s=0.1"], 0),
    (
        &[
            "fly",
            "scenarios/hover.toml",
            "--headless",
            "--set",
            "task.duration_s=0.1",
            "--fork-at",
            "0",
        ],
        0,
    ),
    (&["info", "F", "--json"], 0),
    (&["info", "F"], 0),
    (&["diff", "F", "G", "--json"], 1),
    (&["diff", "F", "G"], 1),
    (&["compare", "F", "G", "--json"], 0),
    (&["compare", "F", "G"], 0),
    (&["check", "--schema"], 0),
    (&["check", "scenarios/hover.toml"], 0),
    (&["mirror", "F", "--headless"], 0),
    (&["mirror", "F", "--headless", "--json"], 0),
    (&["export", "csv", "F"], 0),
    (&["export", "viser", "F", "-o", "-"], 0),
    (&["test", "scenarios/quadrotor.toml", "--json"], 0),
    (&["test", "scenarios/quadrotor.toml"], 0),
    (&["test", "scenarios/quadrotor.toml", "--junit", "-"], 0),
    (&["train", "--print-config"], 0),
];

/// The commands with the recordings of `folder`, and their exit codes.
fn printing(folder: &Folder) -> Vec<(Vec<String>, i32)> {
    let other = Folder::fly(&["--record", &folder.path("g.mcap"), "--set", "seed=7"]);
    assert_eq!(other.status.code(), Some(0), "{}", stderr(&other));
    let named = |argument: &&str| match *argument {
        "F" => folder.path("f.mcap"),
        "G" => folder.path("g.mcap"),
        other => other.to_owned(),
    };
    PRINTING.iter().map(|(words, code)| (words.iter().map(named).collect(), *code)).collect()
}

#[test]
fn a_full_stdout_is_an_error_with_exit_code_1_and_never_a_panic() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").expect("the device");
    let folder = Folder::recorded("full");
    for (words, code) in printing(&folder) {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let output = command(&words).stdout(full()).output().expect("the program starts");
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{words:?}: {said}");
        assert!(said.contains("cannot be written: No space left on device"), "{words:?}: {said}");
        assert!(!said.contains("panicked"), "{words:?}: {said}");
        // Nobody can be told that stderr is full; the results are not touched by that.
        let output = command(&words).stderr(full()).output().expect("the program starts");
        assert!(output.status.code() == Some(code) && !output.stdout.is_empty(), "{words:?}");
    }
}

#[test]
fn a_reader_that_closes_stdout_ends_the_command_quietly_with_its_usual_code() {
    let folder = Folder::recorded("closed");
    for (words, code) in printing(&folder) {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let mut running = command(&words);
        let mut running =
            running.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        drop(running.stdout.take());
        let output = running.wait_with_output().expect("it ends");
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{words:?}: {said}");
        assert!(!said.contains("error") && !said.contains("panicked"), "{words:?}: {said}");
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_is_written_directly_and_stdout_that_leads_to_the_input_is_refused() {
    let folder = Folder::recorded("pipe");
    let (file, pipe) = (folder.path("f.mcap"), folder.path("pipe"));
    let made = Command::new("mkfifo").arg(&pipe).status().expect("mkfifo of coreutils");
    assert!(made.success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::read(pipe).expect("the pipe")
    });
    let written = twin(&["export", "csv", &file, "-o", &pipe]);
    assert_eq!(written.status.code(), Some(0), "{}", stderr(&written));
    assert!(reader.join().expect("no panic").starts_with(b"tick,t_s,"));
    let before = folder.bytes("f.mcap");
    let appended = std::fs::OpenOptions::new().append(true).open(&file).expect("the file");
    let output = command(&["export", "csv", &file]).stdout(appended).output().expect("it starts");
    assert!(stderr(&output).contains("which this command reads"), "{}", stderr(&output));
    assert!(output.status.code() == Some(2) && folder.bytes("f.mcap") == before);
    assert_eq!(folder.names(), ["f.mcap", "pipe"]);
}
