//! The models that `twin train` makes, and their names in configurations, flags and heads of files.

use serde::{Deserialize, Serialize};

/// A model that `twin train` makes: all by gradient descent, except for the ridge regression.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModelKind {
    /// Factorized Dynamics Transformer.
    Fdt,
    /// LSTM.
    Lstm,
    /// Causal Transformer over time with sinusoidal positions.
    Transformer,
    /// GPT-2-style decoder over time with learned positions.
    Gpt2,
    /// Neural-Fly (DAIML).
    NeuralFly,
    /// MLP whose last layer adapts in flight.
    Mlp,
    /// Ridge regression on the last ticks, in closed form.
    Ridge,
}

impl ModelKind {
    /// All models, the FDT first.
    pub const ALL: [Self; 7] = [
        Self::Fdt,
        Self::Lstm,
        Self::Transformer,
        Self::Gpt2,
        Self::NeuralFly,
        Self::Mlp,
        Self::Ridge,
    ];

    /// Name of the model in flags and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fdt => "fdt",
            Self::Lstm => "lstm",
            Self::Transformer => "transformer",
            Self::Gpt2 => "gpt2",
            Self::NeuralFly => "neural_fly",
            Self::Mlp => "mlp",
            Self::Ridge => "ridge",
        }
    }

    /// The model called `word`; `None` if there is none.
    pub fn named(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_word_of_a_model_is_the_one_it_is_read_and_written_by() {
        for kind in ModelKind::ALL {
            assert_eq!(ModelKind::named(kind.name()), Some(kind));
            assert_eq!(serde_json::to_value(kind).unwrap(), kind.name());
        }
        assert_eq!(ModelKind::named("sindy"), None);
    }
}
