//! The configuration of a training: `small`, `paper` or a TOML file.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::LearnError;
use twin_core::residual::weights::ModelKind;
use twin_input::budget::SETTINGS_BYTES;

const SMALL: &str = include_str!("configs/small.toml");
const PAPER: &str = include_str!("configs/paper.toml");

/// Architecture of the FDT.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Architecture {
    /// The paper's network.
    Paper,
    /// The paper's network and, beside it, a linear path from the last ticks to every forecast, which starts at the ridge regression.
    Skip,
}

impl Architecture {
    /// Name in flags and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Skip => "skip",
        }
    }
}

/// A configuration. Every key has a default, so a file states only the keys that differ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrainConfig {
    /// The model that is trained.
    pub model: ModelKind,
    /// Architecture of the FDT; a baseline ignores it.
    pub architecture: Architecture,
    /// Ticks of the linear path in the architecture `skip`.
    pub t_skip: usize,
    /// Width `d_model`; for a baseline, its hidden width.
    pub d_model: usize,
    /// Attention heads; their number divides `d_model`.
    pub heads: usize,
    /// Hidden width of the feed-forward blocks.
    pub d_ff: usize,
    /// Width of the regime latent `g'`.
    pub d_k: usize,
    /// Layers of the short-horizon encoder; for a baseline, its layers.
    pub layers: usize,
    /// Ticks of the short horizon.
    pub t_short: usize,
    /// Ticks of the long horizon; for a baseline, of its history.
    pub t_long: usize,
    /// Horizon `k`: forecasts `j = 0..=k`.
    pub horizon: usize,
    /// Whether the global token takes part.
    pub global_token: bool,
    /// Whether the short-horizon encoder takes part.
    pub short_horizon: bool,
    /// Whether the long-horizon memory takes part.
    pub long_memory: bool,
    /// Input channels that are set to zero.
    pub masked: Vec<String>,
    /// Most epochs.
    pub epochs: usize,
    /// Windows in each step of the optimiser.
    pub batch: usize,
    /// Every `stride`-th window is drawn per epoch.
    pub stride: usize,
    /// Largest learning rate of Adam.
    pub learning_rate: f64,
    /// Epochs over which the learning rate rises; it falls by a half cosine after them.
    pub warm_up_epochs: f64,
    /// Largest norm of the gradient.
    pub gradient_clip: f64,
    /// Epochs without improvement of the validation loss after which the training ends.
    pub patience: usize,
    /// Standard deviation of the white noise on the applied forces, z-scored. It weakens the leak from `tau_{t-1}`. Flights with a
    /// multisine do without it: the closed-loop R² of `twin evaluate acceptance` is 0.983 without noise and 0.965 with 0.1.
    pub tau_noise: f32,
    /// Share of each flight, at its end, that is for validation.
    pub validation: f64,
}

impl Default for TrainConfig {
    fn default() -> Self {
        Self {
            model: ModelKind::Fdt,
            architecture: Architecture::Skip,
            t_skip: 10,
            d_model: 64,
            heads: 4,
            d_ff: 256,
            d_k: 32,
            layers: 2,
            t_short: 5,
            t_long: 120,
            horizon: 25,
            global_token: true,
            short_horizon: true,
            long_memory: true,
            masked: ["chi.x", "chi.y", "chi.psi"].map(str::to_owned).to_vec(),
            epochs: 40,
            batch: 256,
            stride: 4,
            learning_rate: 1e-3,
            warm_up_epochs: 1.0,
            gradient_clip: 1.0,
            patience: 8,
            tau_noise: 0.0,
            validation: 0.15,
        }
    }
}

impl TrainConfig {
    /// The configuration `small` or `paper`, or that of the TOML file called `name`.
    ///
    /// # Errors
    /// [`LearnError`] if the file cannot be read, or a key or value is not allowed.
    pub fn named(name: &str) -> Result<Self, LearnError> {
        match name {
            "small" => Self::parse(SMALL, name),
            "paper" => Self::parse(PAPER, name),
            file => {
                let text = twin_input::file::read_text(Path::new(file), SETTINGS_BYTES).map_err(
                    |why| {
                        let why = format!("{why}; allowed are small, paper or a TOML file");
                        LearnError::Config { source_name: file.to_owned(), why }
                    },
                )?;
                Self::parse(&text, file)
            }
        }
    }

    /// Reads a configuration from `text`; errors name `source_name`.
    ///
    /// # Errors
    /// [`LearnError::Config`] with line and key, or with the allowed values.
    pub fn parse(text: &str, source_name: &str) -> Result<Self, LearnError> {
        let refuse = |why: String| LearnError::Config { source_name: source_name.to_owned(), why };
        let config: Self = toml::from_str(text).map_err(|error| refuse(error.to_string()))?;
        config.check().map_err(refuse)?;
        Ok(config)
    }

    /// The same configuration for another model. If the model changes, the sizes become the defaults of `model`.
    #[must_use]
    pub fn of(self, model: ModelKind) -> Self {
        if self.model == model {
            return self;
        }
        let sized = |t_long, d_model, d_ff, epochs| Self {
            model,
            t_long,
            t_short: self.t_short.min(t_long),
            d_model,
            d_ff,
            epochs,
            ..self.clone()
        };
        match model {
            ModelKind::Fdt => sized(120, 64, 256, self.epochs),
            ModelKind::Lstm => sized(20, 64, 64, 30),
            ModelKind::Transformer | ModelKind::Gpt2 => sized(20, 64, 256, 20),
            ModelKind::NeuralFly => Self { d_k: 16, ..sized(1, 64, 64, 40) },
            ModelKind::Mlp => sized(5, 128, 128, 40),
            // It has neither layers nor epochs.
            ModelKind::Ridge => sized(10, 64, 64, self.epochs),
        }
    }

    /// Ticks of the linear path of an FDT; 0 if it has none.
    pub fn ticks_of_skip(&self) -> usize {
        match (self.model, self.architecture) {
            (ModelKind::Fdt, Architecture::Skip) => self.t_skip,
            _ => 0,
        }
    }

    /// Checks that all values are allowed.
    ///
    /// # Errors
    /// A sentence with the key, the value that was found and the values that are allowed.
    pub fn check(&self) -> Result<(), String> {
        let whole = [
            ("d_model", self.d_model, 1, 4096),
            ("heads", self.heads, 1, 64),
            ("d_ff", self.d_ff, 1, 16384),
            ("d_k", self.d_k, 1, 512),
            ("layers", self.layers, 1, 24),
            ("t_short", self.t_short, 1, self.t_long),
            ("t_long", self.t_long, 1, 2000),
            ("t_skip", self.t_skip, 1, 2000),
            ("horizon", self.horizon, 0, 63),
            ("epochs", self.epochs, 1, 10_000),
            ("batch", self.batch, 1, 65_536),
            ("stride", self.stride, 1, 1000),
            ("patience", self.patience, 1, 10_000),
        ];
        for (key, found, low, high) in whole {
            if !(low..=high).contains(&found) {
                return Err(format!("{key} = {found}: allowed are {low} to {high}"));
            }
        }
        let real = [
            ("learning_rate", self.learning_rate, 1e-8, 1.0),
            ("warm_up_epochs", self.warm_up_epochs, 0.0, 1000.0),
            ("gradient_clip", self.gradient_clip, 1e-6, 1e6),
            ("tau_noise", f64::from(self.tau_noise), 0.0, 10.0),
            ("validation", self.validation, 0.01, 0.9),
        ];
        for (key, found, low, high) in real {
            if !(low..=high).contains(&found) {
                return Err(format!("{key} = {found}: allowed are {low} to {high}"));
            }
        }
        if self.ticks_of_skip() > self.t_long {
            return Err(format!("t_skip = {}: allowed are 1 to {}", self.t_skip, self.t_long));
        }
        if !self.d_model.is_multiple_of(self.heads) {
            let (d, h) = (self.d_model, self.heads);
            return Err(format!("heads = {h}: it must divide d_model = {d}"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_configurations_are_those_of_the_paper_and_of_two_cores() {
        let small = TrainConfig::named("small").unwrap();
        assert_eq!((small.d_model, small.heads, small.d_ff, small.d_k), (64, 4, 256, 32));
        let paper = TrainConfig::named("paper").unwrap();
        assert_eq!((paper.d_model, paper.heads, paper.d_ff, paper.layers), (512, 8, 2048, 2));
        assert_eq!((paper.t_short, paper.t_long, paper.batch, paper.horizon), (5, 120, 256, 6));
        assert_eq!((paper.architecture, paper.ticks_of_skip()), (Architecture::Paper, 0));
        assert_eq!((small.ticks_of_skip(), small.horizon), (10, 25));
    }

    #[test]
    fn a_wrong_key_value_or_file_says_what_is_allowed() {
        for (text, word) in [
            ("d_modl = 3", "d_modl"),
            ("epochs = 0", "epochs = 0: allowed are 1"),
            ("t_skip = 121", "t_skip = 121: allowed are 1 to 120"),
            ("architecture = \"line\"", "line"),
            ("heads = 5", "divide d_model = 64"),
            ("tau_noise = nan", "tau_noise"),
            ("model = \"resnet\"", "resnet"),
        ] {
            let error = TrainConfig::parse(text, "x.toml").unwrap_err().to_string();
            assert!(error.contains("x.toml") && error.contains(word), "{error}");
        }
        let error = TrainConfig::named("no-such-file").unwrap_err().to_string();
        assert!(error.contains("small, paper"), "{error}");
    }
}
