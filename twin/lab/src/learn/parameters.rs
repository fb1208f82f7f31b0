//! The parameters of a model by name, as plain arrays. They are initialised, optimised, stored and read back.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use twin_core::normal::StandardNormal;

/// Standard deviation of learned tokens, identities and positions at the start. The embedding of a z-scored window has about 0.6,
/// so that the channels differ from the first step on.
const EMBEDDING_STD: f32 = 0.3;

/// One tensor, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name in the file.
    pub name: String,
    /// Shape.
    pub shape: Vec<usize>,
    /// Values.
    pub values: Vec<f32>,
}

/// The tensors of a model in a fixed order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameters(pub Vec<Parameter>);

impl Parameters {
    /// Initial values of tensors with these names and shapes. A `norm` is the identity. A `weight` `[out, inputs]` and the `bias` after
    /// it are uniform within `1 / sqrt(inputs)` (He et al. 2015 with the slope of a linear layer). Every other tensor is an embedding
    /// and is normal.
    pub fn initial(tensors: &[(String, Vec<usize>)], random: &mut Pcg64Mcg) -> Self {
        let mut bound = 1.0_f32;
        let mut all = Self::default();
        for (name, shape) in tensors {
            let norm = name.contains("norm.");
            let kind = name.rsplit('.').next().unwrap_or_default();
            if let (false, "weight", [_, inputs]) = (norm, kind, shape.as_slice()) {
                bound = 1.0 / (*inputs as f32).sqrt();
            }
            let mut one = || match kind {
                "weight" if norm => 1.0,
                "bias" if norm => 0.0,
                "weight" | "bias" => random.random_range(-bound..bound),
                _ => EMBEDDING_STD * random.sample::<f32, _>(StandardNormal),
            };
            let values = (0..shape.iter().product()).map(|_| one()).collect();
            all.0.push(Parameter { name: name.clone(), shape: shape.clone(), values });
        }
        all
    }

    /// Number of scalars.
    pub fn count(&self) -> usize {
        self.0.iter().map(|parameter| parameter.values.len()).sum()
    }

    /// The tensor called `name`.
    pub fn get(&self, name: &str) -> Option<&Parameter> {
        self.0.iter().find(|parameter| parameter.name == name)
    }

    /// Tensors of the same names and shapes, all zero.
    #[must_use]
    pub fn zeros_like(&self) -> Self {
        let zero = |p: &Parameter| Parameter { values: vec![0.0; p.values.len()], ..p.clone() };
        Self(self.0.iter().map(zero).collect())
    }

    /// Whether both hold the same names and shapes in the same order.
    pub fn same_shapes(&self, other: &Self) -> bool {
        let key = |p: &Parameter| (p.name.clone(), p.shape.clone());
        self.0.iter().map(key).eq(other.0.iter().map(key))
    }
}
