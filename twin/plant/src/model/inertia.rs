//! The conditions that an inertia tensor meets: it is positive definite, and no principal moment exceeds the sum of the other two.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Relative slack of the triangle inequality: a flat plate meets it with equality, and files hold rounded decimals.
const TRIANGLE_SLACK: f64 = 1e-9;

/// The condition that the tensor violates, in words; `None` if it is the tensor of a rigid body.
pub(super) fn impossible(inertia: &Matrix3<f64>) -> Option<String> {
    let Some(eigen) = SymmetricEigen::try_new(*inertia, f64::EPSILON, 1000) else {
        return Some("has no principal moments".into());
    };
    let mut moments: [f64; 3] = Vector3::from(eigen.eigenvalues).into();
    moments.sort_by(f64::total_cmp);
    let [low, middle, high] = moments;
    let positive = low > 0.0;
    let triangle = low + middle >= high * (1.0 - TRIANGLE_SLACK);
    let moments = format!("{low:.4e}, {middle:.4e}, {high:.4e} kg m²");
    if !positive {
        return Some(format!("is not positive definite (principal moments {moments})"));
    }
    (!triangle).then(|| format!("violates the triangle inequality (principal moments {moments})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solids_pass_and_impossible_tensors_do_not() {
        let diagonal = |a, b, c| Matrix3::from_diagonal(&Vector3::new(a, b, c));
        assert_eq!(impossible(&diagonal(0.04, 0.04, 0.07)), None);
        // A flat plate meets the triangle inequality with equality.
        assert_eq!(impossible(&diagonal(0.1, 0.2, 0.3)), None);
        assert!(impossible(&diagonal(0.1, 0.2, 0.300_001)).unwrap().contains("triangle"));
        assert!(impossible(&diagonal(0.1, -0.1, 0.1)).unwrap().contains("definite"));
        assert!(impossible(&Matrix3::zeros()).unwrap().contains("definite"));
        // Positive diagonal, but the off-diagonal term is too large: eigenvalues 1.5 and -0.5 in the xy plane.
        let coupled = Matrix3::new(0.5, 1.0, 0.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.9);
        assert!(impossible(&coupled).unwrap().contains("definite"));
    }
}
