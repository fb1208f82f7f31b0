//! The simulated vehicle compared with an independent model of the same URDF, and its gripper with Coulomb's law.

mod dynamics;
mod grasp;
mod joints;
mod oracle;
mod rig;
mod trajectory;
mod energy;
mod budget;
