//! The simulated vehicle against an independent model of the same URDF, and its gripper against Coulomb.

mod dynamics;
mod grasp;
mod joints;
mod oracle;
mod rig;
mod trajectory;
