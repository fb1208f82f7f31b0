//! The line of best fit: a ridge regression from the last ticks of every channel to every forecast, solved in closed form.
//!
//! In: [`Windows`], all of them without stride. Out: [`Line`]. It is a model of its own, and the start of the linear path of an FDT.

use nalgebra::DMatrix;

use super::LearnError;
use super::parameters::Parameters;
use super::windows::{WindowEnd, Windows};
use crate::ridge::{Normal, choose};

/// Number of windows that are summed up at a time.
const CHUNK: usize = 2048;

/// The solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Coefficients `[(horizon + 1) * outputs, channels * ticks]`, z-scored; the tick runs fastest, oldest first.
    pub weight: Vec<f32>,
    /// Constants, `[(horizon + 1) * outputs]`, z-scored.
    pub bias: Vec<f32>,
    /// Weight of the squared coefficients, relative to the variance 1 of a z-scored input; the best on the validation windows.
    pub penalty: f64,
    /// Mean squared z-scored error over the training windows, with the noise that the windows would get.
    pub train_loss: f64,
}

impl Line {
    /// The line from the last `ticks` ticks, fitted to the training windows.
    ///
    /// # Errors
    /// [`LearnError::Unsolvable`] if the normal equations have no solution.
    pub fn of(windows: &Windows, ticks: usize) -> Result<Self, LearnError> {
        let inputs = 1 + windows.channels * ticks;
        let mut training = sums(windows, windows.training(), ticks);
        for input in 1..inputs {
            training.add_noise(input, windows.noise_variance((input - 1) / ticks));
        }
        let validation = sums(windows, windows.validation(), ticks);
        let fitted = choose(&training, &validation, inputs).ok_or(LearnError::Unsolvable)?;
        let coefficients = fitted.coefficients.map(|value| value as f32);
        Ok(Self {
            // The columns of the coefficients are the rows of the weight.
            weight: coefficients.rows(1, inputs - 1).iter().copied().collect(),
            bias: coefficients.row(0).iter().copied().collect(),
            penalty: fitted.ridge,
            train_loss: fitted.error(&training),
        })
    }

    /// Writes the line to the tensors `stem.weight` and `stem.bias`.
    pub fn write(&self, parameters: &mut Parameters, stem: &str) {
        for parameter in &mut parameters.0 {
            if parameter.name == format!("{stem}.weight") {
                parameter.values.clone_from(&self.weight);
            } else if parameter.name == format!("{stem}.bias") {
                parameter.values.clone_from(&self.bias);
            }
        }
    }
}

/// The normal equations over the windows in `places`; the constant comes first.
fn sums(windows: &Windows, places: &[WindowEnd], ticks: usize) -> Normal {
    let inputs = 1 + windows.channels * ticks;
    let targets = windows.targets();
    let mut sums = Normal::new(inputs, targets);
    for part in places.chunks(CHUNK) {
        let batch = windows.batch(part, None);
        let long = batch.x.len() / (part.len() * windows.channels).max(1);
        let input = |input: usize, sample: usize| match input.checked_sub(1) {
            None => 1.0,
            Some(at) => {
                let row = sample * windows.channels + at / ticks;
                f64::from(batch.x[(row + 1) * long - ticks + at % ticks])
            }
        };
        let x = DMatrix::from_fn(inputs, part.len(), input);
        let y = DMatrix::from_fn(targets, part.len(), |target, sample| {
            f64::from(batch.y[sample * targets + target])
        });
        sums.add(&x, &y);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::config::TrainConfig;
    use crate::learn::made::{dataset, tiny};

    /// The residual is an exact line of the inputs in f32, and the smallest ridge moves it by less.
    const F32_TOLERANCE: f64 = 1e-4;

    /// The waves of the made flights are not whole periods, so they are a little correlated.
    const NEARLY: f32 = 0.05;

    #[test]
    fn the_line_is_the_law_behind_made_flights() {
        let config = TrainConfig { tau_noise: 0.0, horizon: 0, ..tiny() };
        let windows = Windows::new(&dataset(2, 600), &config).unwrap();
        let line = Line::of(&windows, 1).unwrap();
        let z = &windows.normalisation;
        // r_x = 0.8 tau_x - 0.5 chi_dot_x and r_z = 3 + 0.6 tau_z, z-scored; the channels are chi.x, chi_dot.x, tau.x, tau.z.
        let scaled =
            |law: f32, input: usize, output: usize| law * z.input_std[input] / z.output_std[output];
        let wanted =
            [[0.0, scaled(-0.5, 1, 0), scaled(0.8, 2, 0), 0.0], [0.0, 0.0, 0.0, scaled(0.6, 3, 1)]];
        for (found, wanted) in line.weight.iter().zip(wanted.iter().flatten()) {
            assert!(f64::from((found - wanted).abs()) < F32_TOLERANCE, "{found} {wanted}");
        }
        assert!(line.train_loss < F32_TOLERANCE * F32_TOLERANCE, "{}", line.train_loss);
    }

    #[test]
    fn noise_on_the_forces_shrinks_their_coefficients_and_leaves_its_variance() {
        let config = TrainConfig { tau_noise: 1.0, horizon: 0, ..tiny() };
        let windows = Windows::new(&dataset(1, 3000), &config).unwrap();
        let line = Line::of(&windows, 1).unwrap();
        // r_z depends on tau_z alone, both z-scored: noise of variance 1 halves the coefficient, and half of the variance stays.
        // r_x has a share without noise and is left out.
        assert!((line.weight[7] - 0.5).abs() < NEARLY, "{:?}", line.weight);
        assert!(line.train_loss > 0.25, "{}", line.train_loss);
    }
}
