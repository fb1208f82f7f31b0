//! The evidence of a failure: a page that needs no other file. A browser test checks that the page works.

use std::path::PathBuf;

use twin_record::Outputs;
use twin_scenario::suite::{Evidence, MakePage, Options, Selection, plan, run};

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
    // The same page, made from the recording.
    let again = folder.path("again.html");
    let output = twin(&["export", "html", &folder.path("failed/bad.mcap"), "-o", &again]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(std::fs::read_to_string(&again).expect("the page"), text);
}

#[test]
fn the_suite_notes_the_page_that_its_caller_makes_or_why_there_is_none() {
    let folder = Folder::new("made-page");
    let paths = vec![folder.hover("bad", TOO_LOW)];
    let plan = plan(&Selection { paths, ..Selection::default() }).expect("the scenario is there");
    let flown = |make_page: Option<MakePage>| {
        let evidence = Some(Evidence { folder: folder.path("kept").into(), make_page });
        // Each run replaces the evidence of the one before; otherwise its files would be numbered.
        let outputs = Outputs::new(true);
        let options = Options { jobs: 1, evidence, outputs, ..Options::default() };
        run(&plan, &options, &|_| {}).cases.remove(0)
    };
    let made = flown(Some(|recording, report| {
        assert!(recording.is_file() && !report.passed);
        Ok(("a page".to_owned(), 0.25))
    }));
    assert_eq!(made.replay, Some((PathBuf::from(folder.path("kept/bad.html")), 0.25)));
    assert_eq!(std::fs::read_to_string(folder.path("kept/bad.html")).expect("it"), "a page");
    let refused = flown(Some(|_, _| Err("no room".to_owned())));
    assert_eq!((refused.replay, refused.artifact_trouble), (None, Some("no room".to_owned())));
    let recorded = flown(None);
    assert_eq!((recorded.replay, recorded.artifact_trouble), (None, None));
    assert_eq!(recorded.artifact, Some(PathBuf::from(folder.path("kept/bad.mcap"))));
}

#[test]
fn a_recording_that_is_none_is_refused() {
    let folder = Folder::new("no-replay");
    let file = folder.hover("none", "");
    let output = twin(&["export", "html", &file]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("not an MCAP file"), "{said}");
}
