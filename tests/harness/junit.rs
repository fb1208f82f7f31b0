//! `JUnit` XML: it is valid, failures and errors are separate, and the evidence is named.

use std::path::Path;

use roxmltree::{Document, Node};

use super::{Folder, TOO_LOW};

/// An element of the schema: its name, the elements it may hold, its attributes (`!` marks a required one), and whether it may hold
/// text.
type Rule = (&'static str, &'static [&'static str], &'static [&'static str], bool);

/// Source: junit-10.xsd of the Jenkins xUnit plugin; where its revisions differ, the stricter form. This is a transcription, in which
/// the order of the elements is free.
const SCHEMA: &[Rule] = &[
    ("testsuites", &["testsuite"], &["name", "time", "tests", "failures", "errors"], false),
    (
        "testsuite",
        &["properties", "testcase", "system-out", "system-err"],
        &[
            "name!",
            "tests!",
            "failures!",
            "errors!",
            "time",
            "skipped",
            "timestamp",
            "hostname",
            "id",
            "package",
        ],
        false,
    ),
    ("properties", &["property"], &[], false),
    ("property", &[], &["name!", "value!"], false),
    (
        "testcase",
        &["skipped", "error", "failure", "system-out", "system-err"],
        &["name!", "time", "classname"],
        false,
    ),
    ("failure", &[], &["type", "message"], true),
    ("error", &[], &["type", "message"], true),
    ("skipped", &[], &["type", "message"], true),
    ("system-out", &[], &[], true),
    ("system-err", &[], &[], true),
];

/// Collects the violations of the schema by an element and all elements below it.
fn violations(node: Node, found: &mut Vec<String>) {
    let name = node.tag_name().name();
    let Some((_, children, attributes, text)) = SCHEMA.iter().find(|rule| rule.0 == name) else {
        return found.push(format!("<{name}> is no element"));
    };
    for attribute in node.attributes() {
        let known = attributes.iter().any(|known| known.trim_end_matches('!') == attribute.name());
        if !known {
            found.push(format!("<{name}> has {:?}", attribute.name()));
        }
        // SUREFIRE_TIME: digits, and a fraction of at most three digits.
        let (whole, part) = attribute.value().split_once('.').unwrap_or((attribute.value(), ""));
        let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        if attribute.name() == "time" && !(digits(whole) && digits(part) && part.len() <= 3) {
            found.push(format!("<{name}> has the time {:?}", attribute.value()));
        }
    }
    for required in attributes.iter().filter_map(|known| known.strip_suffix('!')) {
        if node.attribute(required).is_none() {
            found.push(format!("<{name}> lacks {required:?}"));
        }
    }
    for child in node.children() {
        if child.is_text() && !text && !child.text().unwrap_or("").trim().is_empty() {
            found.push(format!("<{name}> has text"));
        }
        if child.is_element() {
            if !children.contains(&child.tag_name().name()) {
                found.push(format!("<{name}> holds <{}>", child.tag_name().name()));
            }
            violations(child, found);
        }
    }
}

fn assert_valid(document: &Document) {
    assert_eq!(document.root_element().tag_name().name(), "testsuites");
    let mut found = Vec::new();
    violations(document.root_element(), &mut found);
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn the_schema_of_this_test_refuses_what_the_common_one_does() {
    for (text, wanted) in [
        ("<testsuites skipped='0'/>", "has \"skipped\""),
        (
            "<testsuites><testsuite name='a' tests='1' failures='0'/></testsuites>",
            "lacks \"errors\"",
        ),
        ("<testsuites time='1.2345'/>", "time"),
        ("<testsuites><testcase name='a'/></testsuites>", "holds <testcase>"),
        ("<testsuites>words</testsuites>", "text"),
    ] {
        let document = Document::parse(text).expect("it is XML");
        let mut found = Vec::new();
        violations(document.root_element(), &mut found);
        assert!(found.iter().any(|line| line.contains(wanted)), "{text}: {found:?}");
    }
}

/// Type, message and body of the child called `tag`.
fn child(case: &Node, tag: &str) -> Option<(String, String, String)> {
    case.children().find(|node| node.has_tag_name(tag)).map(|node| {
        let attribute = |key: &str| node.attribute(key).unwrap_or_default().to_owned();
        (attribute("type"), attribute("message"), node.text().unwrap_or_default().to_owned())
    })
}

fn property<'a>(suite: &Node<'a, 'a>, name: &str) -> Option<&'a str> {
    let is_it = |node: &Node| node.has_tag_name("property") && node.attribute("name") == Some(name);
    suite.descendants().find(is_it)?.attribute("value")
}

#[test]
fn failure_and_error_are_kept_apart_and_each_case_carries_seed_hash_and_versions() {
    let folder = Folder::new("junit");
    let files = [
        folder.hover("good", ""),
        folder.hover("bad", TOO_LOW),
        folder.hover("unusable", "wrong_key = 1\n"),
    ];
    let xml = folder.path("deep/j.xml");
    let mut arguments = vec!["--seeds", "7,", "--junit", &xml];
    arguments.extend(files.iter().map(String::as_str));
    assert_eq!(folder.test(&arguments).status.code(), Some(2));

    let text = std::fs::read_to_string(&xml).expect("the report");
    let document = Document::parse(&text).expect("it is XML");
    assert_valid(&document);
    let root = document.root_element();
    for (key, value) in [("tests", "3"), ("failures", "1"), ("errors", "1")] {
        assert_eq!(root.attribute(key), Some(value), "{key}");
    }
    let suites: Vec<Node> = root.children().filter(|node| node.has_tag_name("testsuite")).collect();
    let case = |index: usize| {
        suites[index].children().find(|node| node.has_tag_name("testcase")).expect("its case")
    };
    assert_eq!(suites.len(), 3);
    assert_eq!((child(&case(0), "failure"), child(&case(0), "error")), (None, None));
    let (kind, message, body) = child(&case(1), "failure").expect("the bound is broken");
    assert_eq!(kind, "height_m");
    // The message has metric, value, bound and second. The vehicle hovers at 1.2 m, above 1 m from the first tick of the window on.
    for word in ["max of height_m", "found 1.", "at most 1", "0.50 s"] {
        assert!(message.contains(word), "{word:?} in {message:?}");
    }
    let recording = Path::new(&folder.path("failed")).join("bad_seed_7.mcap");
    assert!(body.contains(&recording.display().to_string()) && recording.exists(), "{body}");
    let (_, message, _) = child(&case(2), "error").expect("it cannot be flown");
    assert!(message.contains("wrong_key") && child(&case(2), "failure").is_none(), "{message}");

    assert_eq!(property(&suites[1], "seed"), Some("7"));
    assert_eq!(property(&suites[1], "version"), Some(env!("CARGO_PKG_VERSION")));
    let recorded = twin_record::read_recording(&recording).expect("the evidence can be read");
    let hash = recorded.metadata.get("state_hash").map(String::as_str);
    assert_eq!(property(&suites[1], "state_hash"), hash);
}

#[test]
fn a_case_that_was_not_run_is_skipped_and_a_sweep_is_one_case() {
    let folder = Folder::new("junit-more");
    let sweep = "[sweep]\nmethod = \"grid\"\nmin_success = 0.6\n[[sweep.ranges]]\nkey = \"task.start_position_m.2\"\n\
                 values = [0.8, 1.2]\n";
    let files = [folder.hover("a", TOO_LOW), folder.hover("b", &format!("{TOO_LOW}{sweep}"))];
    let xml = folder.path("j.xml");
    let arguments = ["--jobs", "1", "--junit", &xml, &files[1], &files[0], "--fail-fast"];
    assert_eq!(folder.test(&arguments).status.code(), Some(1));
    let text = std::fs::read_to_string(&xml).expect("the report");
    let document = Document::parse(&text).expect("it is XML");
    assert_valid(&document);
    let root = document.root_element();
    // Half of the samples succeed, but the bound demands six tenths.
    assert_eq!((root.attribute("tests"), root.attribute("failures")), (Some("2"), Some("2")));
    let case = |name: &str| {
        let is_it =
            |node: &Node| node.has_tag_name("testcase") && node.attribute("name") == Some(name);
        root.descendants().find(is_it).expect("the case")
    };
    let (kind, message, _) = child(&case("b"), "failure").expect("too few succeed");
    assert_eq!(kind, "min_success");
    assert!(message.contains("1 of 2 samples succeed"), "{message}");
    let (.., said) = child(&case("b"), "system-out").expect("its samples");
    assert!(said.contains("b sample 2") && said.contains("task.start_position_m.2=1.2"), "{said}");

    let arguments =
        ["--jobs", "1", "--junit", &xml, &files[0], &files[0], "--fail-fast", "--seeds", "2"];
    let arguments = [&arguments[..], &["--overwrite"]].concat();
    assert_eq!(folder.test(&arguments).status.code(), Some(1));
    let text = std::fs::read_to_string(&xml).expect("the report");
    let document = Document::parse(&text).expect("it is XML");
    assert_valid(&document);
    assert_eq!(document.descendants().filter(|node| node.has_tag_name("skipped")).count(), 1);
}
