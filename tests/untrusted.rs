//! Files that are no files, and files that are made to exhaust the machine, through the real program and every command that reads them.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::folder::Folder;
use crate::mirror::made;
use crate::patience::until;

/// Runs the program; a program that never ends fails the test.
fn ended(arguments: &[&str]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_twin"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    until(&format!("the end of twin {arguments:?}"), || {
        child.try_wait().expect("the system tells").is_some()
    });
    child.wait_with_output().expect("its output")
}

/// Asserts a failure without a panic whose text, wherever it is printed, contains every text of `wanted`.
fn refused(arguments: &[&str], wanted: &[&str]) {
    let output = ended(arguments);
    let said = [&output.stdout[..], &output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    assert!(matches!(output.status.code(), Some(1 | 2)), "{arguments:?}: {said}");
    assert!(!said.contains("panicked"), "{arguments:?}: {said}");
    for part in wanted {
        assert!(said.contains(part), "{arguments:?}: {part:?} is missing in: {said}");
    }
}

/// The commands that read a file from the user, with `FILE` in its place. For `check` the ending of the file decides what it is read as;
/// the files here end in `.toml`.
const COMMANDS: &[&[&str]] = &[
    &["fly", "FILE", "--headless"],
    &["FILE", "--headless"],
    &["check", "FILE"],
    &["info", "FILE"],
    &["mirror", "FILE", "--headless"],
    &["mirror", "FILE", "--follow"],
    &["export", "csv", "FILE", "-o", "OUT"],
    &["export", "html", "FILE", "-o", "OUT"],
    &["export", "viser", "FILE", "-o", "OUT"],
    &["diff", "FILE", "FILE"],
    &["test", "merge", "FILE"],
];

/// Runs every command with `file` in its place; `more` are texts that the errors contain.
fn every_command(folder: &Folder, file: &Path, more: &[&str]) {
    let (file, out) = (file.to_str().expect("a path of ASCII"), folder.path("out"));
    for command in COMMANDS {
        let place = |word: &&'static str| match *word {
            "FILE" => file.to_owned(),
            "OUT" => out.display().to_string(),
            other => other.to_owned(),
        };
        let arguments: Vec<String> = command.iter().map(place).collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let wanted: Vec<&str> = more.iter().copied().chain([file]).collect();
        refused(&arguments, &wanted);
    }
}

#[test]
fn a_directory_a_pipe_a_device_and_a_socket_are_refused_by_every_command() {
    let folder = Folder::new("kinds");
    let directory = folder.path("directory.toml");
    std::fs::create_dir(&directory).expect("a folder");
    every_command(&folder, &directory, &["found a directory", "name a file in it"]);
    #[cfg(unix)]
    {
        let pipe = folder.path("pipe.toml");
        let made = Command::new("mkfifo").arg(&pipe).status().expect("mkfifo belongs to POSIX");
        assert!(made.success());
        let socket = folder.path("socket.toml");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).expect("a socket");
        let link = folder.path("link.toml");
        std::os::unix::fs::symlink("/dev/zero", &link).expect("a link");
        let into_a_file = "write its bytes into a file";
        every_command(&folder, &pipe, &["found a named pipe", into_a_file]);
        refused(&["test", pipe.to_str().expect("a path of ASCII")], &["found a named pipe"]);
        every_command(&folder, &socket, &["found a socket", into_a_file]);
        every_command(&folder, &link, &["found a device", into_a_file]);
    }
}

#[test]
fn files_that_a_scenario_names_are_regular_files_too() {
    let folder = Folder::new("named");
    let zero = "/dev/zero";
    for (name, text) in [
        ("urdf", format!("[vehicle]\nurdf = \"{zero}\"\n")),
        ("weights", format!("[predictor]\nkind = \"trained\"\nweights = \"{zero}\"\n")),
    ] {
        let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/aerial_manipulator.urdf");
        let text = match name {
            "weights" => format!("{text}[vehicle]\nurdf = \"{}\"\n", urdf.display()),
            _ => text,
        };
        let file = folder.write(&format!("{name}.toml"), &text);
        let file = file.to_str().expect("a path of ASCII");
        refused(&["fly", file, "--headless"], &[zero, "found a device"]);
        refused(&["test", file], &[zero, "found a device"]);
    }
    let mesh = "<link name='l'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial><visual><geometry><mesh filename='zero.stl'/></geometry></visual></link>";
    let urdf = folder.write("mesh.urdf", &format!("<robot name='r'>{mesh}</robot>"));
    #[cfg(unix)]
    std::os::unix::fs::symlink(zero, folder.path("zero.stl")).expect("a link");
    #[cfg(unix)]
    refused(&["check", urdf.to_str().expect("a path of ASCII")], &["zero.stl", "found a device"]);
    refused(&["train", "x.mcap", "--config", zero], &[zero, "found a device"]);
    let flight = folder.path("flight.mcap");
    std::fs::write(&flight, made::flight(made::PLAIN)).expect("a temporary file");
    let flight = flight.to_str().expect("a path of ASCII");
    refused(&["info", flight, "--map", zero], &[zero, "found a device"]);
}

/// An MCAP file with these records after its header.
fn mcap(records: &[u8]) -> Vec<u8> {
    let header = [&4_u32.to_le_bytes()[..], b"ros2", &0_u32.to_le_bytes()].concat();
    [mcap::MAGIC, &record(1, &header), records].concat()
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

/// A chunk record without a checksum.
fn chunk(claimed: u64, packed: &[u8]) -> Vec<u8> {
    let times = [0; 16];
    let body = [
        &times[..],
        &claimed.to_le_bytes(),
        &[0; 4],
        &4_u32.to_le_bytes(),
        b"zstd",
        &(packed.len() as u64).to_le_bytes(),
        packed,
    ];
    record(6, &body.concat())
}

/// `length` zeros, compressed; the bytes are made once and repeated as frames, each of a mebibyte.
fn compressed_zeros(length: u64) -> Vec<u8> {
    const FRAME: u64 = 1 << 20;
    let frame = zstd::bulk::compress(&vec![0; FRAME as usize], 1).expect("it is compressed");
    frame.repeat((length / FRAME) as usize)
}

#[test]
fn compressed_bytes_that_claim_too_much_are_damage_and_are_not_unpacked() {
    let folder = Folder::new("inflated");
    let claimed = 4 << 30;
    let bomb = mcap(&chunk(claimed, &compressed_zeros(claimed)));
    assert!(bomb.len() < 1 << 20, "{} bytes", bomb.len());
    let file = folder.path("bomb.mcap");
    std::fs::write(&file, bomb).expect("a temporary file");
    let name = file.to_str().expect("a path of ASCII");
    refused(&["info", name], &["claims 4294967296 bytes", "at most 268435456"]);
    refused(&["mirror", name, "--headless"], &[name]);
    refused(&["export", "csv", name], &[name]);
    refused(&["diff", name, name], &[name, "no tick"]);
}

#[test]
fn opcode_0_and_a_file_of_holes_are_damage_at_their_first_byte() {
    let folder = Folder::new("holes");
    let zero = folder.path("opcode.mcap");
    std::fs::write(&zero, mcap(&record(0, b"abc").repeat(3))).expect("a temporary file");
    let sparse = folder.path("sparse.mcap");
    std::fs::write(&sparse, mcap(&[])).expect("a temporary file");
    let hole = std::fs::OpenOptions::new().write(true).open(&sparse).expect("the file");
    hole.set_len(2 << 30).expect("a file with a hole");
    for file in [zero, sparse] {
        let name = file.to_str().expect("a path of ASCII");
        refused(&["info", name], &["no record at byte 29", "opcode 0"]);
        refused(&["mirror", name, "--headless"], &[name]);
        refused(&["export", "csv", name], &[name]);
        let page = folder.path("page.html").display().to_string();
        refused(&["export", "html", name, "-o", &page], &[name]);
        refused(&["diff", name, name], &[name, "no tick"]);
    }
}

#[test]
fn a_file_longer_than_its_kind_may_be_is_refused_with_limit_and_finding() {
    let folder = Folder::new("long");
    for (name, most) in [
        ("a.toml", twin_input::budget::SCENARIO_BYTES),
        ("a.urdf", twin_input::budget::URDF_BYTES),
        ("a.safetensors", twin_input::budget::WEIGHTS_BYTES),
    ] {
        let file = folder.write(name, "");
        let long = std::fs::OpenOptions::new().write(true).open(&file).expect("the file");
        long.set_len(most.most + 1).expect("a file with a hole");
        let (found, most) = (format!("found {}", most.most + 1), format!("at most {}", most.most));
        refused(&["check", file.to_str().expect("a path of ASCII")], &[name, &found, &most]);
    }
}

#[test]
fn a_vehicle_with_more_moving_joints_than_can_be_simulated_is_refused_before_the_first_step() {
    let folder = Folder::new("joints");
    let inertial = "<inertial><mass value='0.1'/><inertia ixx='1e-3' iyy='1e-3' izz='1e-3' ixy='0' ixz='0' iyz='0'/></inertial>";
    let link = |n: usize| format!("<link name='m{n}'>{inertial}</link>\n");
    let joint = |n: usize| {
        let before = if n == 0 { "base_link".to_owned() } else { format!("m{}", n - 1) };
        format!(
            "<joint name='s{n}' type='continuous'><parent link='{before}'/><child link='m{n}'/><axis xyz='0 1 0'/></joint>\n"
        )
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/aerial_manipulator.urdf");
    let whole = std::fs::read_to_string(path).expect("the URDF");
    let more: String = (0..2000).flat_map(|n| [link(n), joint(n)]).collect();
    folder.write("many.urdf", &whole.replace("</robot>", &format!("{more}</robot>")));
    let file = folder.write("many.toml", "[vehicle]\nurdf = \"many.urdf\"\n");
    let file = file.to_str().expect("a path of ASCII");
    refused(&["fly", file, "--headless"], &["joints that move", "at most 64", "fixed"]);
}
