//! The evidence of a failure: a page that is complete in itself. Whether it works is a browser's test.

use super::{Folder, TOO_LOW, twin};

#[test]
fn a_failure_leaves_a_page_that_needs_nothing_else_and_the_message_names_it() {
    let folder = Folder::new("replay");
    let output = folder.test(&[&folder.hover("bad", TOO_LOW)]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let page = folder.path("failed/bad.html");
    assert!(said.contains(&format!("replay: {page} opens at 0.50 s")), "{said}");
    let text = std::fs::read_to_string(&page).expect("the page");
    for outside in
        ["src=\"", "href=\"http", "@import", "/*flight*/", "/*replay.js*/", "/*replay.css*/"]
    {
        assert!(!text.contains(outside), "{outside}");
    }
    // The same page from the recording.
    let again = folder.path("again.html");
    let output = twin(&["export", "html", &folder.path("failed/bad.mcap"), "-o", &again]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(std::fs::read_to_string(&again).expect("the page"), text);
}

#[test]
fn a_recording_that_is_none_is_refused() {
    let folder = Folder::new("no-replay");
    let file = folder.hover("none", "");
    let output = twin(&["export", "html", &file]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("not an MCAP file"), "{said}");
}
