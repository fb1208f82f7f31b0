//! The vehicle, or a piece of scenery, as its URDF describes it: links, joints, inertias, shapes, kinematics, gravity.
//!
//! This module does not know the simulator. Frames follow URDF: a link's frame is its parent joint's frame, moved by the joint;
//! the vehicle's body frame is the root link's frame. SI units, radians.
//!
//! A URDF is read twice on purpose. `check` reads the raw XML, because there a missing `<inertial>` differs from a zero one and
//! a finding has a line; `load` then takes the values from `urdf-rs`.

mod numbers;
mod check;
mod tree;
mod inertia;
mod packages;
mod mesh;
mod load;
mod kinematics;
mod statics;

#[cfg(test)]
mod many_tests;
#[cfg(test)]
mod refusals;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use nalgebra::{Isometry3, Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use ts_rs::TS;

pub use kinematics::{Arm, link_poses};
pub use packages::Packages;
pub use statics::Statics;

/// A tree of links and joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// `<robot name>`.
    pub name: String,
    /// Links in the order of the file.
    pub links: Vec<Link>,
    /// Joints in topological order: a joint comes after the joint that moves its parent link.
    pub joints: Vec<Joint>,
    /// Index into `links` of the one link that is no joint's child.
    pub root: usize,
}

/// A rigid body or a massless frame fixed to one.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Unique name among the links.
    pub name: String,
    /// Mass properties; all zero for a massless frame.
    pub inertial: Inertial,
    /// Shapes that viewers draw, in the link frame.
    pub visuals: Vec<Geometry>,
    /// Shapes that collide, in the link frame.
    pub collisions: Vec<Geometry>,
}

/// Mass properties of one link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass in the link frame, m.
    pub com_in_link: Vector3<f64>,
    /// Inertia about the centre of mass, in the axes of the link frame (`<inertial>` rpy applied), kg m².
    pub inertia_in_link: Matrix3<f64>,
}

/// A shape with its pose and colour.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Geometry {
    /// `link_from_shape`, m.
    pub origin: Isometry3<f64>,
    /// The shape in its own frame.
    pub shape: Shape,
    /// Red, green, blue, alpha in 0..=1; grey where the file names no colour.
    pub rgba: [f32; 4],
}

/// A solid. Cylinders and capsules lie along z. All shapes but meshes are centred on their origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[ts(rename = "SceneShape")]
pub enum Shape {
    /// A cuboid.
    Box {
        /// Full edge lengths along x, y, z, m.
        size_m: [f64; 3],
    },
    /// A circular cylinder along z.
    Cylinder {
        /// Radius, m.
        radius_m: f64,
        /// Full length along z, m.
        length_m: f64,
    },
    /// A ball.
    Sphere {
        /// Radius, m.
        radius_m: f64,
    },
    /// A cylinder along z closed by two half balls.
    Capsule {
        /// Radius, m.
        radius_m: f64,
        /// Length of the cylindrical part along z, m.
        length_m: f64,
    },
    /// Triangles, scale applied.
    Mesh {
        /// Corners, m.
        vertices: Vec<[f64; 3]>,
        /// Indices into `vertices`, counter-clockwise from outside.
        triangles: Vec<[u32; 3]>,
    },
}

/// A joint between a parent link and a child link.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Unique name among the joints.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link.
    pub child: usize,
    /// `parent_from_joint` at position zero, m.
    pub origin: Isometry3<f64>,
    /// Unit axis in the joint frame.
    pub axis: Vector3<f64>,
    /// Smallest position, rad or m; minus infinity where the joint has no limit.
    pub lower: f64,
    /// Largest position, rad or m; infinity where the joint has no limit.
    pub upper: f64,
    /// Largest torque or force, N m or N; infinity where the joint has no limit.
    pub effort: f64,
    /// Largest speed, rad/s or m/s; infinity where the joint has no limit.
    pub velocity: f64,
    /// Viscous damping, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, N m or N.
    pub friction: f64,
    /// The mimic relation, if the joint follows another.
    pub mimic: Option<Mimic>,
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Does not move.
    Fixed,
    /// Turns about its axis between limits.
    Revolute,
    /// Turns about its axis without limits.
    Continuous,
    /// Slides along its axis between limits.
    Prismatic,
}

/// Mimic relation: `position = multiplier * leader's position + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mimic {
    /// Index of the leading joint, which follows no other joint.
    pub joint: usize,
    /// Ratio of the positions.
    pub multiplier: f64,
    /// Position at the leader's zero, rad or m.
    pub offset: f64,
}

impl Robot {
    /// Index of the link called `name`.
    pub fn link(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// Index of the joint called `name`.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Sum of the links' masses, kg.
    pub fn total_mass_kg(&self) -> f64 {
        self.links.iter().map(|link| link.inertial.mass_kg).sum()
    }
}

/// Errors of reading a URDF.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// The file cannot be opened or is not text.
    #[error("{}: {reason}; expected a readable URDF file in UTF-8, check the path", .file.display())]
    Unreadable {
        /// The URDF.
        file: PathBuf,
        /// The message of the operating system.
        reason: String,
    },
    /// An element or attribute is not allowed.
    #[error("{}:{line}: {found}; allowed: {allowed}; {remedy}", .file.display())]
    Refused {
        /// The URDF.
        file: PathBuf,
        /// Line of the element, from 1.
        line: u32,
        /// Content that was found there.
        found: String,
        /// Content that is allowed there.
        allowed: String,
        /// Remedy.
        remedy: String,
    },
    /// A mesh that the URDF names cannot be used.
    #[error("{}:{line}: mesh {mesh:?}: {found}; {remedy}", .file.display())]
    Mesh {
        /// The URDF.
        file: PathBuf,
        /// Line of the `<mesh>` element, from 1.
        line: u32,
        /// The reference as written.
        mesh: String,
        /// Defect of the mesh.
        found: String,
        /// Remedy.
        remedy: String,
    },
}
