//! URDFs with very many links: their limits, their work, and their depth.

use std::path::Path;

use super::*;
use twin_input::budget::{ATTRIBUTES, JOINTS, LINKS};
use twin_input::work;

/// A chain of `links` links, each tied to the one before it; the joints are written from the last to the first.
fn chain(links: usize) -> String {
    let inertial = "<inertial><mass value='0.01'/><inertia ixx='1e-3' iyy='1e-3' izz='1e-3' ixy='0' ixz='0' iyz='0'/></inertial>";
    let link = |n| format!("<link name='l{n}'>{inertial}</link>\n");
    let joint = |n| {
        let after = n + 1;
        format!(
            "<joint name='j{n}' type='fixed'><parent link='l{n}'/><child link='l{after}'/></joint>\n"
        )
    };
    let joints: String = (0..links - 1).rev().map(joint).collect();
    format!("<robot name='chain'>{}{joints}</robot>", (0..links).map(link).collect::<String>())
}

fn parse(text: &str) -> Result<Robot, ModelError> {
    Robot::parse(text, Path::new("many.urdf"), &Packages::default())
}

#[test]
fn the_work_of_a_chain_grows_with_its_length_and_not_with_its_square() {
    let growth = work::growth(250, &mut |links| {
        assert_eq!(parse(&chain(links)).map(|robot| robot.joints.len()), Ok(links - 1));
    });
    assert!(growth < work::LINEAR, "four times the links took {growth:.1} times the steps");
}

#[test]
fn a_chain_of_8000_links_fits_a_stack_of_256_kib() {
    let read =
        || parse(&chain(8000)).map(|robot| link_poses(&robot, &Isometry3::identity(), &[]).len());
    let thread = std::thread::Builder::new().stack_size(256 << 10).spawn(read).unwrap();
    assert_eq!(thread.join().unwrap(), Ok(8000));
}

#[test]
fn as_many_links_and_joints_as_the_budget_allows_are_read_and_one_more_is_refused() {
    assert_eq!((LINKS.most, JOINTS.most), (10_000, 10_000));
    assert!(parse(&chain(LINKS.count())).is_ok());
    let said = parse(&chain(LINKS.count() + 1)).unwrap_err().to_string();
    assert!(said.contains("many.urdf:10001") && said.contains("10001 links"), "{said}");
    // The names of the joints are wrong, but their number is found first.
    let joints = |count: usize| {
        parse(&format!("<robot name='r'><link name='l'/>{}</robot>", "<joint/>".repeat(count)))
    };
    let said = joints(JOINTS.count()).unwrap_err().to_string();
    assert!(!said.contains("at most"), "{said}");
    let said = joints(JOINTS.count() + 1).unwrap_err().to_string();
    assert!(said.contains("10001 joints") && said.contains("at most 10000"), "{said}");
}

#[test]
fn as_many_attributes_as_the_budget_allows_are_read_and_one_more_is_refused() {
    let with = |count: usize| {
        let attributes: String =
            (1..count).fold(String::new(), |text, n| text + &format!(" a{n}='>'"));
        parse(&format!("<robot name='r'\n><link name='l'/>\n<gazebo a0='1'{attributes}/></robot>"))
    };
    // The massless link is found only after the attributes.
    let said = with(ATTRIBUTES.count()).unwrap_err().to_string();
    assert!(said.contains("no <inertial>"), "{said}");
    let said = with(ATTRIBUTES.count() + 1).unwrap_err().to_string();
    assert!(said.contains("many.urdf:3") && said.contains("257 attributes"), "{said}");
}

#[test]
fn a_mesh_counts_as_often_as_it_is_named_and_its_triangles_are_limited() {
    use std::cell::Cell;
    use twin_input::budget::{ALL_MESH_BYTES, TRIANGLES};
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.obj");
    let face = "f 1 2 3\n";
    let text = |faces: usize| format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", face.repeat(faces));
    std::fs::write(&file, text(1)).unwrap();
    let length = text(1).len() as u64;
    let all = Cell::new(ALL_MESH_BYTES.most - length);
    assert!(mesh::read(&file, &all).is_ok());
    let (said, _) = mesh::read(&file, &all).unwrap_err();
    assert!(said.contains(&(ALL_MESH_BYTES.most + length).to_string()), "{said}");
    std::fs::write(&file, text(TRIANGLES.count())).unwrap();
    assert!(mesh::read(&file, &Cell::default()).is_ok());
    std::fs::write(&file, text(TRIANGLES.count() + 1)).unwrap();
    let (said, remedy) = mesh::read(&file, &Cell::default()).unwrap_err();
    assert!(said.contains("2000001 triangles") && remedy == "simplify the mesh", "{said}");
}
