//! Ridge regression by normal equations that are summed up block by block.
//!
//! In: blocks of inputs and targets. Out: coefficients `[inputs, targets]` of a model with the first inputs alone.

use nalgebra::DMatrix;

/// Ridges that are tried, relative to the variance 1 of a z-scored input. The sums round by about 1e-13 of it, so the first is still
/// above their roundings.
pub(crate) const RIDGES: [f64; 7] = [1e-11, 1e-10, 1e-9, 1e-8, 1e-6, 1e-4, 1e-2];

/// Sums of the normal equations.
#[derive(Clone)]
pub(crate) struct Normal {
    gram: DMatrix<f64>,
    moment: DMatrix<f64>,
    /// Sum of the squares of all targets.
    squares: f64,
    count: f64,
}

/// A fitted model.
pub(crate) struct Fitted {
    pub(crate) ridge: f64,
    /// `[inputs, targets]`.
    pub(crate) coefficients: DMatrix<f64>,
}

impl Fitted {
    /// Mean squared error over the samples of `sums` and all targets.
    pub(crate) fn error(&self, sums: &Normal) -> f64 {
        sums.error(&self.coefficients)
    }
}

impl Normal {
    pub(crate) fn new(inputs: usize, targets: usize) -> Self {
        Self {
            gram: DMatrix::zeros(inputs, inputs),
            moment: DMatrix::zeros(inputs, targets),
            squares: 0.0,
            count: 0.0,
        }
    }

    /// Adds a block: inputs `[inputs, samples]` and targets `[targets, samples]`.
    pub(crate) fn add(&mut self, x: &DMatrix<f64>, y: &DMatrix<f64>) {
        self.gram.gemm(1.0, x, &x.transpose(), 1.0);
        self.moment.gemm(1.0, x, &y.transpose(), 1.0);
        self.squares += y.norm_squared();
        self.count += x.ncols() as f64;
    }

    /// The coefficients of the first `inputs`; the constant, which comes first, is free. `None` without samples.
    fn solve(&self, inputs: usize, ridge: f64) -> Option<DMatrix<f64>> {
        if self.count == 0.0 {
            return None;
        }
        let mut a = self.gram.view((0, 0), (inputs, inputs)) / self.count;
        for i in 1..inputs {
            a[(i, i)] += ridge;
        }
        let moment = self.moment.rows(0, inputs) / self.count;
        Some(a.cholesky()?.solve(&moment))
    }

    /// Mean squared error of `coefficients` over all targets.
    fn error(&self, coefficients: &DMatrix<f64>) -> f64 {
        let inputs = coefficients.nrows();
        let (gram, moment) =
            (self.gram.view((0, 0), (inputs, inputs)), self.moment.rows(0, inputs));
        let quadratic = (gram * coefficients).dot(coefficients);
        let sum = self.squares - 2.0 * moment.dot(coefficients) + quadratic;
        sum / (self.count * coefficients.ncols() as f64)
    }

    /// Adds what white noise of this variance on `input` adds to the sums in the mean.
    pub(crate) fn add_noise(&mut self, input: usize, variance: f64) {
        self.gram[(input, input)] += variance * self.count;
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            gram: &self.gram + &other.gram,
            moment: &self.moment + &other.moment,
            squares: self.squares + other.squares,
            count: self.count + other.count,
        }
    }
}

/// The model of the first `inputs`, fitted to `part` with the ridge that has the smallest error on `validation`. `None` if a part has no
/// samples.
pub(crate) fn choose(part: &Normal, validation: &Normal, inputs: usize) -> Option<Fitted> {
    let error = |ridge: f64| {
        let fitted = Fitted { ridge, coefficients: part.solve(inputs, ridge)? };
        let error = fitted.error(validation);
        error.is_finite().then_some((fitted, error))
    };
    let tried = RIDGES.into_iter().filter_map(error);
    tried.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(fitted, _)| fitted)
}

/// The model of the first `inputs` with the ridge that [`choose`] finds, fitted to both parts. `None` if a part has no samples.
pub(crate) fn fit(part: &Normal, validation: &Normal, inputs: usize) -> Option<Fitted> {
    let ridge = choose(part, validation, inputs)?.ridge;
    Some(Fitted { ridge, coefficients: part.plus(validation).solve(inputs, ridge)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Inputs 1, u and v without noise, and y = 2 + 3 u - v.
    fn block(from: usize, to: usize) -> (DMatrix<f64>, DMatrix<f64>) {
        let u = |i: usize| ((i * 7) % 11) as f64 - 5.0;
        let v = |i: usize| ((i * 5) % 13) as f64 - 6.0;
        let x = DMatrix::from_fn(3, to - from, |row, i| [1.0, u(from + i), v(from + i)][row]);
        let y = DMatrix::from_fn(1, to - from, |_, i| 2.0 + 3.0 * u(from + i) - v(from + i));
        (x, y)
    }

    #[test]
    fn blocks_give_the_law_behind_them_and_its_error() {
        let (mut part, mut validation) = (Normal::new(3, 1), Normal::new(3, 1));
        for from in [0, 100, 200] {
            let (x, y) = block(from, from + 100);
            part.add(&x, &y);
        }
        let (x, y) = block(300, 400);
        validation.add(&x, &y);
        let fitted = fit(&part, &validation, 3).unwrap();
        // Without noise a small ridge wins; 1e-8 moves coefficients near 3 by 3e-9 at most, because u and v have a variance above 1.
        assert!(fitted.ridge <= 1e-8);
        for (found, expected) in fitted.coefficients.iter().zip([2.0, 3.0, -1.0]) {
            assert!((found - expected).abs() < 1e-8, "{found} {expected}");
        }
        // The error from the sums is that of the samples.
        let wrong = DMatrix::from_column_slice(2, 1, &[1.0, 2.5]);
        let direct = (&y - wrong.transpose() * x.rows(0, 2)).norm_squared() / 100.0;
        assert!((validation.error(&wrong) - direct).abs() < 1e-10);
        assert!(fit(&Normal::new(3, 1), &validation, 3).is_none());
    }

    #[test]
    fn a_large_ridge_shrinks_to_the_mean() {
        let mut part = Normal::new(3, 1);
        let (x, y) = block(0, 143);
        part.add(&x, &y);
        let flat = part.solve(3, 1e12).unwrap();
        // 143 = 11 · 13 ticks hold each value equally often, so u and v have the mean 0 and y has 2.
        assert!((flat[0] - 2.0).abs() < 1e-9 && flat.rows(1, 2).norm() < 1e-9);
    }
}
