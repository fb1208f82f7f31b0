//! The basis in which the adapter gets the regime `g'`.
//!
//! The network fixes `g'` only up to an invertible linear map `A`: if `W_V` and its bias are multiplied by `A`, and `W_lift` by `A^-1`,
//! every forecast stays the same. Gradient descent leaves most of the power of `g'` in one direction that hardly varies. Recursive
//! least squares under a bounded covariance then learns little more than an offset. So `A` is chosen after the training. It makes
//! the second moment of `g'` over the training windows the identity, except in directions with almost no power.
//!
//! In: the second moment `[d_k, d_k]`. Out: both maps, and the factor that gives `g'` its power.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::parameters::Parameters;
use twin_core::elementary::powf;

/// Mean squared norm of the regime that the adapter gets.
const POWER: f64 = 8.0;

/// Directions with a smaller share of the mean power stay small, because their variation is rounding.
const LEAST_POWER: f64 = 1e-3;

/// Most iterations of the decomposition, so that it ends for every matrix.
const MOST_STEPS: usize = 10_000;

/// The map to the adapter's regime and back.
#[derive(Clone, Debug)]
pub struct Basis {
    /// `A`, `[d_k, d_k]`.
    forth: DMatrix<f64>,
    /// `A^-1`.
    back: DMatrix<f64>,
    /// `regime_scale` of the head: the mean squared norm of `A g'`, times the square of the scale, is 8.
    pub scale: f64,
}

impl Basis {
    /// `A = (C + e I)^-1/2` of the second moment `C = E[g' g'^T]`; the identity where `C` has no power or is not finite.
    pub fn of(moment: &DMatrix<f64>) -> Self {
        let d_k = moment.nrows();
        let least = LEAST_POWER * moment.trace() / d_k.max(1) as f64;
        let unchanged = Self {
            forth: DMatrix::identity(d_k, d_k),
            back: DMatrix::identity(d_k, d_k),
            scale: 1.0,
        };
        if least.is_nan() || least <= 0.0 || least.is_infinite() {
            return unchanged;
        }
        let Some(eigen) = SymmetricEigen::try_new(moment.clone(), f64::EPSILON, MOST_STEPS) else {
            return unchanged;
        };
        let kept = eigen.eigenvalues.map(|value| value.max(0.0) + least);
        let of = |power: f64| -> DMatrix<f64> {
            let diagonal: DVector<f64> = kept.map(|value| powf(value, power));
            &eigen.eigenvectors * DMatrix::from_diagonal(&diagonal) * eigen.eigenvectors.transpose()
        };
        let power: f64 =
            eigen.eigenvalues.iter().zip(kept.iter()).map(|(v, k)| v.max(0.0) / k).sum();
        Self { forth: of(-0.5), back: of(0.5), scale: (POWER / power).sqrt() }
    }

    /// A basis with the scale alone, for a model whose last layer is not linear in its regime.
    pub fn unturned(moment: &DMatrix<f64>) -> Self {
        let (d_k, power) = (moment.nrows(), moment.trace());
        let scale = if power > 0.0 && power.is_finite() { (POWER / power).sqrt() } else { 1.0 };
        let identity = DMatrix::identity(d_k, d_k);
        Self { forth: identity.clone(), back: identity, scale }
    }

    /// Applies the maps to the weights of an FDT; its forecast stays the same.
    pub fn turn(&self, weights: &mut Parameters) {
        for parameter in &mut weights.0 {
            let width = parameter.shape.last().copied().unwrap_or(1);
            let rows = parameter.values.len() / width.max(1);
            let matrix = |rows, columns| {
                let wide = parameter.values.iter().map(|v| f64::from(*v));
                DMatrix::from_row_iterator(rows, columns, wide)
            };
            let turned = match parameter.name.as_str() {
                "cross.value.weight" => &self.forth * matrix(rows, width),
                "cross.value.bias" => &self.forth * matrix(width, 1),
                "cross.lift.weight" => matrix(rows, width) * &self.back,
                _ => continue,
            };
            parameter.values = turned.transpose().iter().map(|v| *v as f32).collect();
        }
    }
}

/// Sum of `g' g'^T` over `regimes` `[windows, d_k]`, divided by `windows`, the number of all windows.
pub fn second_moment(regimes: &[f32], d_k: usize, windows: usize) -> DMatrix<f64> {
    let rows = regimes.len() / d_k.max(1);
    let all = DMatrix::from_row_iterator(rows, d_k, regimes.iter().map(|g| f64::from(*g)));
    all.tr_mul(&all) / windows.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::parameters::Parameter;
    use twin_core::elementary::{cos, sin, squared};

    /// Products of a few f32 numbers below 10.
    const F32_TOLERANCE: f64 = 1e-4;

    /// Regimes with nearly all power in one direction, as training leaves them.
    fn lopsided() -> Vec<f32> {
        (0..200)
            .flat_map(|i| {
                let t = i as f32 * 0.1;
                [5.0 + 0.1 * sin(t), 3.0 + 0.2 * cos(t), 0.3 * sin(2.0 * t)]
            })
            .collect()
    }

    #[test]
    fn the_turned_regime_has_equal_power_in_every_direction() {
        let regimes = lopsided();
        let moment = second_moment(&regimes, 3, 200);
        let basis = Basis::of(&moment);
        let turned = &basis.forth * &moment * &basis.forth.transpose() * squared(basis.scale);
        assert!((turned.trace() - POWER).abs() < 1e-9, "{turned}");
        let before = SymmetricEigen::new(moment).eigenvalues;
        let after = SymmetricEigen::new(turned).eigenvalues;
        assert!(before.max() / before.min() > 1e3, "{before}");
        // The weakest direction is near the floor, so its power stays below that of the others.
        assert!(after.max() / after.min() < 3.0, "{after}");
        assert!((&basis.forth * &basis.back - DMatrix::identity(3, 3)).norm() < 1e-9);
    }

    #[test]
    fn what_is_lifted_from_the_regime_stays() {
        let values =
            |n: usize, step: f32| (0..n).map(|i| sin(i as f32 * step)).collect::<Vec<f32>>();
        let parameter = |name: &str, shape: &[usize], step: f32| Parameter {
            name: name.to_owned(),
            shape: shape.to_vec(),
            values: values(shape.iter().product(), step),
        };
        let before = Parameters(vec![
            parameter("cross.value.weight", &[3, 4], 0.7),
            parameter("cross.value.bias", &[3], 1.3),
            parameter("cross.lift.weight", &[4, 3], 0.9),
            parameter("cross.lift.bias", &[4], 0.4),
        ]);
        let lifted = |weights: &Parameters| -> DVector<f64> {
            let of = |index: usize, rows: usize| {
                let wide = weights.0[index].values.iter().map(|v| f64::from(*v));
                let columns = weights.0[index].values.len() / rows;
                DMatrix::from_row_iterator(rows, columns, wide)
            };
            let memory = DMatrix::from_column_slice(4, 1, &[1.0, -0.5, 2.0, 0.3]);
            let regime = of(0, 3) * memory + of(1, 3);
            (of(2, 4) * regime + of(3, 4)).column(0).into_owned()
        };
        let basis = Basis::of(&second_moment(&lopsided(), 3, 200));
        let mut after = before.clone();
        basis.turn(&mut after);
        assert_ne!(after.0[0], before.0[0]);
        assert!((lifted(&after) - lifted(&before)).norm() < F32_TOLERANCE);
    }

    #[test]
    fn a_regime_without_power_is_left_as_it_is() {
        for moment in [DMatrix::zeros(2, 2), DMatrix::from_element(2, 2, f64::NAN)] {
            let basis = Basis::of(&moment);
            assert!(basis.forth == DMatrix::identity(2, 2) && basis.scale.total_cmp(&1.0).is_eq());
        }
    }
}
