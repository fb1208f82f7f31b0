//! Turns the values of `urdf-rs` into a [`Robot`]: indices instead of names, an isometry for each origin, meshes read.

use std::cell::Cell;
use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;

use super::check::{Source, children};
use super::{
    Geometry, Inertial, Joint, JointKind, Link, Mimic, ModelError, Packages, Robot, Shape, inertia,
    mesh, tree,
};
use twin_input::budget::URDF_BYTES;
use twin_input::{file, work};

/// Colour of a visual without one.
const GREY: [f32; 4] = [0.7, 0.7, 0.7, 1.0];

/// Most names that an error lists.
const SHOWN_NAMES: usize = 30;

/// Shortest axis; below it the direction is noise.
const MIN_AXIS_LENGTH: f64 = 1e-9;

impl Robot {
    /// Reads the URDF file `path`.
    ///
    /// # Errors
    /// [`ModelError`] if the file cannot be read, or for the reasons of [`Robot::parse`].
    pub fn load(path: &Path, packages: &Packages) -> Result<Robot, ModelError> {
        let text = file::read_text(path, URDF_BYTES).map_err(|error| ModelError::Unreadable {
            file: path.to_path_buf(),
            reason: error.to_string(),
        })?;
        Robot::parse(&text, path, packages)
    }

    /// Reads `text`, the content of the URDF `file`; meshes are looked up beside the file and in `packages`.
    ///
    /// # Errors
    /// [`ModelError`] if the twin cannot simulate the URDF; the error names the line.
    pub fn parse(text: &str, file: &Path, packages: &Packages) -> Result<Robot, ModelError> {
        let source = Source::parse(text, file)?;
        let urdf = urdf_rs::read_from_string(text).map_err(|error| {
            let found = format!("not readable as URDF: {error}");
            source.refuse(source.root(), found, "URDF 1.0 to 1.2", "compare with urdf/")
        })?;
        let loader = Loader {
            source: &source,
            file,
            packages,
            colours: colours(&urdf),
            mesh_bytes: Cell::new(0),
        };
        let nodes = source.links();
        let links: Vec<Link> = urdf
            .links
            .iter()
            .zip(&nodes)
            .map(|(link, node)| loader.link(link, *node))
            .collect::<Result<_, _>>()?;
        let places = Places::of(links.iter().map(|link| &*link.name));
        let mut joints: Vec<Joint> = urdf
            .joints
            .iter()
            .zip(source.joints())
            .map(|(joint, node)| loader.joint(joint, node, &places))
            .collect::<Result<_, _>>()?;
        let (order, root) = tree::order(&source, &links, &joints)?;
        let leaders = Places::of(order.iter().map(|&place| &*urdf.joints[place].name));
        for (index, joint) in urdf.joints.iter().enumerate() {
            joints[index].mimic = loader.mimic(joint, index, &urdf.joints, (&order, &leaders))?;
        }
        let joints: Vec<Joint> = order.iter().map(|&index| joints[index].clone()).collect();
        loader.check_masses(&nodes, &links, &joints)?;
        Ok(Robot { name: urdf.name.clone(), links, joints, root })
    }
}

struct Loader<'a> {
    source: &'a Source<'a>,
    file: &'a Path,
    packages: &'a Packages,
    colours: HashMap<String, [f32; 4]>,
    /// Bytes of the mesh files so far.
    mesh_bytes: Cell<u64>,
}

/// The places of names in a list.
struct Places<'a> {
    by_name: HashMap<&'a str, usize>,
    /// The names in order.
    names: Vec<&'a str>,
}

impl<'a> Places<'a> {
    fn of(names: impl Iterator<Item = &'a str>) -> Self {
        let names: Vec<&str> = names.collect();
        work::steps(names.len());
        Self { by_name: names.iter().enumerate().map(|(at, name)| (*name, at)).collect(), names }
    }

    fn get(&self, name: &str) -> Option<usize> {
        work::steps(1);
        self.by_name.get(name).copied()
    }
}

impl Loader<'_> {
    fn link(&self, link: &urdf_rs::Link, node: Node<'_, '_>) -> Result<Link, ModelError> {
        let mut inertial = MASSLESS;
        if let Some(element) = children(node, "inertial").next() {
            inertial = inertial_of(&link.inertial);
            if let Some(why) = inertia::impossible(&inertial.inertia_in_link) {
                let found = format!("the inertia of link {:?} {why}", link.name);
                let allowed = "the tensor of a rigid body about its centre of mass";
                let remedy = "compute it from the shape and mass, or take it from CAD in kg m²";
                return Err(self.source.refuse(element, found, allowed, remedy));
            }
        }
        let visuals = link.visual.iter().zip(children(node, "visual")).map(|(visual, node)| {
            let rgba = visual.material.as_ref().map_or(GREY, |material| self.colour(material));
            self.geometry(&visual.origin, &visual.geometry, rgba, node)
        });
        let collisions = link.collision.iter().zip(children(node, "collision"));
        Ok(Link {
            name: link.name.clone(),
            inertial,
            visuals: visuals.collect::<Result<_, _>>()?,
            collisions: collisions
                .map(|(shape, node)| self.geometry(&shape.origin, &shape.geometry, GREY, node))
                .collect::<Result<_, _>>()?,
        })
    }

    fn colour(&self, material: &urdf_rs::Material) -> [f32; 4] {
        let own = material.color.as_ref().map(rgba);
        own.or_else(|| self.colours.get(&material.name).copied()).unwrap_or(GREY)
    }

    fn geometry(
        &self,
        origin: &urdf_rs::Pose,
        geometry: &urdf_rs::Geometry,
        rgba: [f32; 4],
        node: Node<'_, '_>,
    ) -> Result<Geometry, ModelError> {
        let shape = match geometry {
            urdf_rs::Geometry::Box { size } => Shape::Box { size_m: **size },
            urdf_rs::Geometry::Cylinder { radius, length } => {
                Shape::Cylinder { radius_m: *radius, length_m: *length }
            }
            urdf_rs::Geometry::Capsule { radius, length } => {
                Shape::Capsule { radius_m: *radius, length_m: *length }
            }
            urdf_rs::Geometry::Sphere { radius } => Shape::Sphere { radius_m: *radius },
            urdf_rs::Geometry::Mesh { filename, scale } => {
                let scale = scale.map_or([1.0; 3], |scale| *scale);
                self.mesh(filename, scale, node)?
            }
        };
        Ok(Geometry { origin: isometry(origin), shape, rgba })
    }

    fn mesh(
        &self,
        reference: &str,
        scale: [f64; 3],
        node: Node<'_, '_>,
    ) -> Result<Shape, ModelError> {
        let element = node.descendants().find(|child| child.has_tag_name("mesh")).unwrap_or(node);
        self.packages
            .resolve(reference, self.file)
            .and_then(|path| mesh::read(&path, &self.mesh_bytes))
            .map(|triangles| triangles.scaled(scale))
            .map_err(|(found, remedy)| ModelError::Mesh {
                file: self.file.to_path_buf(),
                line: self.source.line(element),
                mesh: reference.to_owned(),
                found,
                remedy,
            })
    }

    fn joint(
        &self,
        joint: &urdf_rs::Joint,
        node: Node<'_, '_>,
        links: &Places<'_>,
    ) -> Result<Joint, ModelError> {
        let name = &joint.name;
        let kind = match joint.joint_type {
            urdf_rs::JointType::Revolute => JointKind::Revolute,
            urdf_rs::JointType::Continuous => JointKind::Continuous,
            urdf_rs::JointType::Prismatic => JointKind::Prismatic,
            _ => JointKind::Fixed,
        };
        let axis = Vector3::from(*joint.axis.xyz);
        if axis.norm() < MIN_AXIS_LENGTH {
            let found = format!("joint {name:?} has a zero axis");
            return Err(self.source.refuse(
                node,
                found,
                "a direction",
                "for example xyz=\"0 1 0\"",
            ));
        }
        let limited = children(node, "limit").next().is_some();
        let (lower, upper) = match kind {
            JointKind::Fixed => (0.0, 0.0),
            JointKind::Continuous => (f64::NEG_INFINITY, f64::INFINITY),
            JointKind::Revolute | JointKind::Prismatic => (joint.limit.lower, joint.limit.upper),
        };
        if kind != JointKind::Fixed && lower >= upper {
            let found = format!("joint {name:?} may move from {lower} to {upper}");
            let remedy = "set both limits, or make the joint fixed";
            return Err(self.source.refuse(node, found, "lower below upper", remedy));
        }
        let dynamics = joint.dynamics.as_ref();
        Ok(Joint {
            name: name.clone(),
            kind,
            parent: self.link_index(&joint.parent.link, node, links)?,
            child: self.link_index(&joint.child.link, node, links)?,
            origin: isometry(&joint.origin),
            axis: axis.normalize(),
            lower,
            upper,
            effort: if limited { joint.limit.effort } else { f64::INFINITY },
            velocity: if limited { joint.limit.velocity } else { f64::INFINITY },
            damping: dynamics.map_or(0.0, |dynamics| dynamics.damping),
            friction: dynamics.map_or(0.0, |dynamics| dynamics.friction),
            mimic: None,
        })
    }

    fn link_index(
        &self,
        name: &str,
        node: Node<'_, '_>,
        links: &Places<'_>,
    ) -> Result<usize, ModelError> {
        links.get(name).ok_or_else(|| {
            let found = format!("unknown link {name:?}");
            let known = listed(&links.names);
            self.source.refuse(node, found, known, "correct the name or add the link")
        })
    }

    /// Resolves `<mimic>`; the index of the leader is its place in `order`, which is the order of the finished robot.
    fn mimic(
        &self,
        joint: &urdf_rs::Joint,
        index: usize,
        joints: &[urdf_rs::Joint],
        (order, places): (&[usize], &Places<'_>),
    ) -> Result<Option<Mimic>, ModelError> {
        let Some(mimic) = &joint.mimic else { return Ok(None) };
        let moves = |other: &urdf_rs::Joint| {
            other.mimic.is_none() && other.joint_type != urdf_rs::JointType::Fixed
        };
        let leader = places.get(&mimic.joint).filter(|&place| moves(&joints[order[place]]));
        let Some(leader) = leader else {
            let found = format!("joint {:?} mimics {:?}", joint.name, mimic.joint);
            let free: Vec<&str> =
                joints.iter().filter(|other| moves(other)).map(|other| &*other.name).collect();
            let allowed = format!("a moving joint that mimics none: {}", listed(&free));
            let node = self.source.joints()[index];
            return Err(self.source.refuse(node, found, allowed, "name the leading joint"));
        };
        Ok(Some(Mimic {
            joint: leader,
            multiplier: mimic.multiplier.unwrap_or(1.0),
            offset: mimic.offset.unwrap_or(0.0),
        }))
    }

    fn check_masses(
        &self,
        nodes: &[Node<'_, '_>],
        links: &[Link],
        joints: &[Joint],
    ) -> Result<(), ModelError> {
        let groups = tree::rigid_groups(links.len(), joints);
        let mut mass = vec![0.0; links.len()];
        for (link, &group) in links.iter().zip(&groups) {
            mass[group] += link.inertial.mass_kg;
        }
        let bare = (0..links.len()).find(|&link| groups[link] == link && mass[link] <= 0.0);
        let Some(bare) = bare else { return Ok(()) };
        let found = format!("link {:?} moves but has no <inertial>", links[bare].name);
        let allowed = "massless links only where a fixed joint ties them to one with mass";
        let remedy = "add <inertial> with mass and inertia";
        Err(self.source.refuse(nodes[bare], found, allowed, remedy))
    }
}

/// Names for an error; of many only the first.
fn listed(names: &[&str]) -> String {
    let first = names[..names.len().min(SHOWN_NAMES)].join(", ");
    match names.len().saturating_sub(SHOWN_NAMES) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

const MASSLESS: Inertial =
    Inertial { mass_kg: 0.0, com_in_link: Vector3::new(0.0, 0.0, 0.0), inertia_in_link: ZERO };
const ZERO: Matrix3<f64> = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);

fn inertial_of(inertial: &urdf_rs::Inertial) -> Inertial {
    let i = &inertial.inertia;
    let tensor = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
    let link_from_inertial = isometry(&inertial.origin);
    let r = link_from_inertial.rotation.to_rotation_matrix();
    Inertial {
        mass_kg: inertial.mass.value,
        com_in_link: link_from_inertial.translation.vector,
        inertia_in_link: r.matrix() * tensor * r.matrix().transpose(),
    }
}

/// URDF's rpy are angles about the fixed axes x, y, z in this order; nalgebra's Euler angles are the same.
fn isometry(pose: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = *pose.rpy;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(*pose.xyz)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

/// Colours by name of the material: first those of the robot, then those that links define; the first definition counts.
fn colours(urdf: &urdf_rs::Robot) -> HashMap<String, [f32; 4]> {
    let in_links = urdf.links.iter().flat_map(|link| &link.visual);
    let in_links = in_links.filter_map(|visual| visual.material.as_ref());
    let mut colours = HashMap::new();
    for material in urdf.materials.iter().chain(in_links) {
        if let Some(color) = &material.color {
            colours.entry(material.name.clone()).or_insert_with(|| rgba(color));
        }
    }
    colours
}

fn rgba(color: &urdf_rs::Color) -> [f32; 4] {
    color.rgba.map(|channel| channel as f32)
}
