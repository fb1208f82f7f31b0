use super::*;

const FIVE: Limit = Limit::new(5, "bytes", "shorten it");

#[test]
fn a_file_as_long_as_the_limit_is_read_and_one_byte_more_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.txt");
    std::fs::write(&file, "12345").unwrap();
    assert_eq!(read_text(&file, FIVE).unwrap(), "12345");
    std::fs::write(&file, "123456").unwrap();
    let said = read(&file, FIVE).unwrap_err().to_string();
    assert_eq!(said, "found 6 bytes, at most 5 are allowed; shorten it");
}

#[test]
fn a_file_that_claims_to_be_empty_is_read_up_to_the_limit_too() {
    // The length of this file is 0, and its text is longer than the limit.
    let file = Path::new("/proc/self/status");
    if file.exists() {
        assert!(matches!(read(file, FIVE), Err(InputError::TooMuch(excess)) if excess.found == 6));
    }
}

#[test]
fn text_that_is_not_utf_8_is_refused_with_its_byte() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.txt");
    std::fs::write(&file, b"ab\xff").unwrap();
    assert!(matches!(read_text(&file, FIVE), Err(InputError::NotText { at: 2 })));
}

#[test]
fn only_regular_files_are_opened_through_links_too() {
    let folder = tempfile::tempdir().unwrap();
    let said = open(folder.path()).unwrap_err().to_string();
    assert!(said.contains("a directory") && said.contains("name a file in it"), "{said}");
    assert!(open(&folder.path().join("absent")).unwrap_err().is_absent());
    assert!(check_kind(&folder.path().join("absent")).is_ok());
    #[cfg(unix)]
    {
        let file = folder.path().join("a");
        std::fs::write(&file, "x").unwrap();
        for (target, found) in [(file.as_path(), None), (Path::new("/dev/zero"), Some("a device"))]
        {
            let link = folder.path().join("link");
            std::os::unix::fs::symlink(target, &link).unwrap();
            let said = open(&link).err().map(|error| error.to_string());
            assert_eq!(said.is_some(), found.is_some());
            assert!(said.unwrap_or_default().contains(found.unwrap_or_default()));
            std::fs::remove_file(link).unwrap();
        }
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        assert!(open(&socket).unwrap_err().to_string().contains("a socket"));
        // The command `mkfifo` belongs to POSIX.
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.is_ok_and(|status| status.success()));
        let said = open(&pipe).unwrap_err().to_string();
        assert!(said.contains("a named pipe") && said.contains("into a file"), "{said}");
    }
}

#[test]
fn the_open_file_is_asked_for_its_kind_too() {
    // The kind that the path had may be another by the time that the file is open; here the second question alone decides.
    let kind = File::open("/dev/zero").and_then(|file| file.metadata()).map(|m| m.file_type());
    if let Ok(kind) = kind {
        assert!(matches!(regular(kind), Err(InputError::NotRegular { found: "a device", .. })));
    }
}
