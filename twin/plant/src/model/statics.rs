//! `g(chi)`, the generalised gravity force of the empty vehicle.
//!
//! With the first moment `S(q) = sum m_i c_i(q)` in the body frame and `k = world_from_body^T e_z`, the potential is
//! `U = g (m z + k . S)`, so `g(chi) = dU/dchi` needs `dk/d(phi, theta)` and one column `dS/dq` for each joint.

use nalgebra::{Vector2, Vector3};

use super::Robot;
use super::kinematics::Skeleton;
use twin_core::elementary::sin_cos;
use twin_core::notation::{Coords, GRAVITY_M_S2};

/// Mass and centre of mass of the parts of the vehicle, lumped by the arm joint that carries them.
#[derive(Clone, Debug)]
pub struct Statics {
    skeleton: Skeleton,
    lumps: Vec<LumpedMass>,
    mass_kg: f64,
}

#[derive(Clone, Copy, Debug)]
struct LumpedMass {
    carrier: Option<usize>,
    mass_kg: f64,
    /// Centre of mass in the moved frame of the carrier, m.
    com: Vector3<f64>,
}

impl Statics {
    /// The statics of `robot`; `arm_joints` are the indices of `q1 q2`, none to two. Every other joint rests at zero or at its limit
    /// nearest to zero.
    pub fn new(robot: &Robot, arm_joints: &[usize]) -> Self {
        let skeleton = Skeleton::new(robot, arm_joints);
        let lumps = [None, Some(0), Some(1)].map(|carrier| lump(robot, &skeleton, carrier));
        let lumps = lumps.into_iter().filter(|lump| lump.mass_kg > 0.0).collect();
        Statics { skeleton, lumps, mass_kg: robot.total_mass_kg() }
    }

    /// Generalised gravity `g(chi)`, N and N m: the generalised force `+g(chi)` balances the weight of the vehicle.
    pub fn gravity(&self, chi: &Coords) -> Coords {
        let q = Vector2::new(chi[6], chi[7]);
        let frames = self.skeleton.frames(&q);
        let (sp, cp) = sin_cos(chi[3]);
        let (st, ct) = sin_cos(chi[4]);
        let k = Vector3::new(-st, ct * sp, ct * cp);
        let dk_dphi = Vector3::new(0.0, ct * cp, -ct * sp);
        let dk_dtheta = Vector3::new(-ct, -st * sp, -st * cp);

        let mut first_moment = Vector3::zeros();
        let mut columns = [Vector3::zeros(); 2];
        for lump in &self.lumps {
            let com = match lump.carrier {
                Some(row) => (frames[row] * nalgebra::Point3::from(lump.com)).coords,
                None => lump.com,
            };
            first_moment += lump.mass_kg * com;
            for (row, column) in columns.iter_mut().enumerate() {
                if self.skeleton.moves(row, lump.carrier) {
                    *column += lump.mass_kg * self.skeleton.column(row, &frames, &com);
                }
            }
        }
        let mut g = Coords::zeros();
        g[2] = self.mass_kg;
        g[3] = dk_dphi.dot(&first_moment);
        g[4] = dk_dtheta.dot(&first_moment);
        g[6] = k.dot(&columns[0]);
        g[7] = k.dot(&columns[1]);
        g * GRAVITY_M_S2
    }
}

fn lump(robot: &Robot, skeleton: &Skeleton, carrier: Option<usize>) -> LumpedMass {
    let mut mass_kg = 0.0;
    let mut moment = Vector3::zeros();
    for (link, (_, pose)) in
        robot.links.iter().zip(&skeleton.links).filter(|(_, (on, _))| *on == carrier)
    {
        mass_kg += link.inertial.mass_kg;
        let com = pose * nalgebra::Point3::from(link.inertial.com_in_link);
        moment += link.inertial.mass_kg * com.coords;
    }
    let com = if mass_kg > 0.0 { moment / mass_kg } else { Vector3::zeros() };
    LumpedMass { carrier, mass_kg, com }
}
