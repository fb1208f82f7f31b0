//! Broken URDFs: the loader refuses each at its line, and never panics.

use std::path::Path;

use proptest::prelude::*;

use super::*;

const VEHICLE: &str = include_str!("../../../../urdf/aerial_manipulator.urdf");

fn parse(text: &str) -> Result<Robot, ModelError> {
    Robot::parse(text, Path::new("urdf/test.urdf"), &Packages::default())
}

/// Asserts that the loader refuses the vehicle with one edit, on the line where `anchor` then stands and with these words.
fn refused(from: &str, to: &str, anchor: &str, words: &str) {
    let text = VEHICLE.replacen(from, to, 1);
    assert_ne!(text, VEHICLE, "{from:?} is not in the vehicle");
    let place = text.find(anchor).unwrap_or_else(|| panic!("{anchor:?} is not in the text"));
    let line = text[..place].lines().count().max(1) + usize::from(text[..place].ends_with('\n'));
    let error = parse(&text).expect_err(words).to_string();
    assert!(error.starts_with(&format!("urdf/test.urdf:{line}: ")), "line {line}: {error}");
    assert!(error.contains(words), "{words}: {error}");
    assert!(!error.ends_with('.') && error.contains(';'), "{error}");
}

#[test]
fn structure() {
    refused("<robot ", "<sdf ", "</robot>", "not well-formed XML");
    let error = parse("<sdf name=\"a\"/>").unwrap_err().to_string();
    assert!(error.starts_with("urdf/test.urdf:1: the document element is <sdf>"), "{error}");
    assert!(parse("<robot name=\"a\"/>").unwrap_err().to_string().contains("without links"));
    refused("<link name=\"tool\"/>", "<link/>", "<link/>", "<link> without name");
    refused(
        "\"link2\">",
        "\"link1\">",
        "<link name=\"link1\">\n    <inertial><origin xyz=\"0 0 -0.067",
        "is already defined on line",
    );
    refused(
        "name=\"joint2\"",
        "name=\"joint1\"",
        "<joint name=\"joint1\" type=\"revolute\">\n    <parent link=\"link1\"",
        "is already defined on line",
    );
    refused("<child link=\"link2\"/>", "", "<joint name=\"joint2\"", "<joint> without <child>");
    refused("<box size=\"0.15 0.11 0.040\"/>", "<cone/>", "<cone/>", "unknown shape <cone>");
    refused("<box size=\"0.15 0.11 0.040\"/>", "", "<geometry></geometry>", "without shape");
    refused(
        "<link name=\"tool\"/>",
        "<link name=\"tool\"><xacro:if xmlns:xacro=\"http://ros.org/wiki/xacro\"/></link>",
        "<xacro:if",
        "xacro",
    );
}

#[test]
fn tree() {
    refused(
        "<child link=\"tool\"/>",
        "<child link=\"tol\"/>",
        "<joint name=\"tool_joint\"",
        "unknown link \"tol\"",
    );
    refused(
        "<child link=\"tool\"/>",
        "<child link=\"link2\"/>",
        "<joint name=\"tool_joint\"",
        "child of both",
    );
    refused(
        "<link name=\"tool\"/>",
        "<link name=\"tool\"/><link name=\"stray\"/>",
        "<link name=\"stray\"/>",
        "both without parent",
    );
    // Apart from the root, link1 is the child of the tool, and the tool hangs on link1.
    refused(
        "<parent link=\"base_link\"/><child link=\"link1\"/>",
        "<parent link=\"tool\"/><child link=\"link1\"/>",
        "<joint name=\"joint1\"",
        "the joints form a loop",
    );
    let ring = r#"<robot name="ring"><link name="a"/><link name="b"/>
        <joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>
        <joint name="ba" type="fixed"><parent link="b"/><child link="a"/></joint></robot>"#;
    let error = parse(ring).unwrap_err().to_string();
    assert!(error.starts_with("urdf/test.urdf:2: the joints form a loop"), "{error}");
}

#[test]
fn masses() {
    let link1 = "<inertial><origin xyz=\"0 0 -0.09\"/><mass value=\"0.25\"/>\n      <inertia ixx=\"6.890625e-4\" ixy=\"0\" ixz=\"0\" iyy=\"6.890625e-4\" iyz=\"0\" izz=\"2.8125e-5\"/></inertial>";
    refused(link1, "", "<link name=\"link1\">", "\"link1\" moves but has no <inertial>");
    refused("<mass value=\"2.30\"/>", "<mass value=\"0\"/>", "<mass value=\"0\"/>", "above 0");
    refused("<mass value=\"2.30\"/>", "<mass value=\"-1\"/>", "<mass value=\"-1\"/>", "above 0");
    refused(
        "<mass value=\"2.30\"/>",
        "",
        "<inertial><origin xyz=\"0 0 0\"/>",
        "<inertial> without <mass>",
    );
    refused(
        "ixx=\"0.04\"",
        "ixx=\"-0.04\"",
        "<inertial><origin xyz=\"0 0 0\"/>",
        "not positive definite",
    );
    refused(
        "izz=\"0.07\"",
        "izz=\"0.09\"",
        "<inertial><origin xyz=\"0 0 0\"/>",
        "triangle inequality",
    );
}

#[test]
fn numbers() {
    for bad in ["NaN", "inf", "-inf", "1e400", "1e9", "", "abc", "0.04 0.04"] {
        let edit = format!("ixx=\"{bad}\"");
        refused("ixx=\"0.04\"", &edit, &format!("<inertia {edit}"), "<inertia");
    }
    refused("ixx=\"0.04\" ", "", "<inertia ixy=\"0\"", "without ixx");
    refused(
        "<box size=\"0.30 0.30 0.08\"/>",
        "<box size=\"0.30 -0.30 0.08\"/>",
        "<box size=\"0.30 -",
        "above 0",
    );
    refused(
        "<box size=\"0.30 0.30 0.08\"/>",
        "<box size=\"0.30 x 0.30 0.08\"/>",
        "<box size=\"0.30 x",
        "3 finite numbers",
    );
    refused(
        "rgba=\"0.24 0.26 0.28 1\"",
        "rgba=\"9 10 11 255\"",
        "<color rgba=\"9",
        "each in 0..=1",
    );
}

#[test]
fn joints() {
    refused(
        "name=\"joint1\" type=\"revolute\"",
        "name=\"joint1\" type=\"planar\"",
        "<joint name=\"joint1\"",
        "of type \"planar\"; allowed: fixed, revolute, continuous, prismatic",
    );
    refused(
        "<axis xyz=\"0 -1 0\"/>",
        "<axis xyz=\"0 0 0\"/>",
        "<joint name=\"joint1\"",
        "zero axis",
    );
    refused(
        "<limit lower=\"-1.919862\" upper=\"1.919862\" effort=\"3.0\" velocity=\"8.0\"/>",
        "",
        "<joint name=\"joint1\"",
        "has no <limit>",
    );
    refused(
        "lower=\"-1.919862\" upper=\"1.919862\" effort",
        "effort",
        "<joint name=\"joint1\"",
        "from 0 to 0",
    );
    refused("lower=\"-1.919862\"", "lower=\"2\"", "<joint name=\"joint1\"", "from 2 to 1.919862");
    refused(" velocity=\"8.0\"", "", "<limit lower=\"-1.919862\"", "<limit> without velocity");
    refused(
        "<mimic joint=\"finger_left_joint\"",
        "<mimic joint=\"thumb\"",
        "<joint name=\"finger_right_joint\"",
        "mimics \"thumb\"; allowed: a moving joint that mimics none: joint1, joint2, finger_left_joint",
    );
    refused(
        "<mimic joint=\"finger_left_joint\"",
        "<mimic joint=\"finger_right_joint\"",
        "<joint name=\"finger_right_joint\"",
        "mimics \"finger_right_joint\"",
    );
}

#[test]
fn meshes() {
    let mesh = |reference: &str| format!("<mesh filename=\"{reference}\"/>");
    for (reference, words) in [
        ("package://unknown/a.stl", "package \"unknown\" is not known"),
        ("https://host/a.stl", "https:// is not read"),
        ("no/such.stl", "cannot read urdf/no/such.stl"),
        ("a.blend", "unknown extension \"blend\""),
    ] {
        refused("<box size=\"0.15 0.11 0.040\"/>", &mesh(reference), &mesh(reference), words);
    }
    refused("<box size=\"0.15 0.11 0.040\"/>", "<mesh/>", "<mesh/>", "<mesh> without filename");
    refused(
        "<box size=\"0.15 0.11 0.040\"/>",
        "<mesh filename=\"a.stl\" scale=\"1 0 1\"/>",
        "<mesh filename",
        "not 0",
    );
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    for end in 0..VEHICLE.trim_end().len() {
        if let Some(text) = VEHICLE.get(..end) {
            assert!(parse(text).is_err(), "accepted {end} bytes");
        }
    }
}

#[test]
fn deep_nesting_is_refused() {
    let levels = 100_000;
    let text =
        format!("<robot name=\"a\">{}{}</robot>", "<a>".repeat(levels), "</a>".repeat(levels));
    assert!(parse(&text).is_err());
    let text = format!("<robot name=\"a\">{}{}</robot>", "<a>".repeat(40), "</a>".repeat(40));
    assert!(parse(&text).unwrap_err().to_string().contains("nested too deeply"));
}

#[test]
fn a_missing_file_is_named() {
    let error = Robot::load(Path::new("no/such.urdf"), &Packages::default()).unwrap_err();
    assert!(error.to_string().starts_with("no/such.urdf: "), "{error}");
}

proptest! {
    /// Lines swapped, dropped and doubled, and characters overwritten: the loader may answer anything, but it must not panic.
    #[test]
    fn edited_files_do_not_panic(
        edits in prop::collection::vec((0..160usize, 0..160usize, 0..3u8), 0..4),
        place in 0..VEHICLE.len(), with in "[<>\"/ a0-9.eE-]{0,6}",
    ) {
        let mut lines: Vec<&str> = VEHICLE.lines().collect();
        for (from, to, how) in edits {
            let (from, to) = (from % lines.len(), to % lines.len());
            match how {
                0 => lines.swap(from, to),
                1 => { lines.remove(from); }
                _ => lines.insert(to, lines[from]),
            }
        }
        let mut text = lines.join("\n");
        let end = place + with.len();
        if text.is_char_boundary(place) && text.is_char_boundary(end) && end < text.len() {
            text.replace_range(place..end, &with);
        }
        let _ = parse(&text);
    }
}
