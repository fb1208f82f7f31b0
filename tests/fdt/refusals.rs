//! Files of weights that must be refused, each with a sentence that names the defect.

use twin_core::notation::Coords;
use twin_core::residual::Fdt;
use twin_core::residual::nn::Precision;
use twin_core::residual::nn::kernels::Kernel;
use twin_core::residual::weights::{FdtConfig, Head, Tensor, Weights, WeightsError};

use super::made;

fn good() -> Weights {
    made::weights(&FdtConfig::SMALL, 1)
}

/// A part of the expected message, and the change of a good head that causes it.
type Slip = (&'static str, fn(&mut Head));

/// Writes the weights, reads them back and builds the network.
fn outcome(weights: &Weights) -> Result<(), WeightsError> {
    Fdt::new(&Weights::from_bytes(&weights.to_bytes()?)?, Kernel::SCALAR, Precision::F32)
        .map(|_| ())
}

#[test]
fn good_weights_come_back_as_they_were_written() {
    let weights = good();
    assert_eq!(Weights::from_bytes(&weights.to_bytes().unwrap()), Ok(weights.clone()));
    assert_eq!(outcome(&weights), Ok(()));
}

#[test]
fn a_file_that_is_cut_off_anywhere_is_refused() {
    let bytes = good().to_bytes().unwrap();
    let places = (0..200).chain((1..200).map(|part| bytes.len() * part / 200));
    for end in places.chain([bytes.len() - 1]) {
        assert!(Weights::from_bytes(&bytes[..end]).is_err(), "{end} of {} bytes", bytes.len());
    }
    let cut = Weights::from_bytes(&bytes[..bytes.len() - 1]).unwrap_err();
    assert_eq!(cut, WeightsError::CutOff { found_bytes: bytes.len() - 1 });
}

#[test]
fn a_byte_that_was_changed_never_ends_in_a_panic() {
    let bytes = good().to_bytes().unwrap();
    let mut chance = made::Chance::new(3);
    for _ in 0..400 {
        let mut broken = bytes.clone();
        let at = chance.size(6000) - 1;
        broken[at] ^= 1 << (chance.size(8) - 1);
        let _ = Weights::from_bytes(&broken)
            .map(|weights| Fdt::new(&weights, Kernel::SCALAR, Precision::F32).map(|_| ()));
    }
}

#[test]
fn what_the_head_says_must_be_usable() {
    let cases: [Slip; 14] = [
        ("head format 2, this program reads 1", |head| head.format = 2),
        ("model \"lstm\", expected \"fdt\"", |head| head.model = "lstm".into()),
        ("input_std[3] is 0, expected a finite value above 0", |head| {
            head.normalisation.input_std[3] = 0.0;
        }),
        ("output_std[7] is -1", |head| head.normalisation.output_std[7] = -1.0),
        ("input_mean has 23 entries, expected 24", |head| {
            head.normalisation.input_mean.pop();
        }),
        ("regime_scale[0] is 0", |head| head.normalisation.regime_scale = 0.0),
        ("m_bar[2] is -1", |head| head.m_bar[2] = -1.0),
        ("channel_names[1] is \"chi.w\", this vehicle has \"chi.y\"", |head| {
            head.channel_names[1] = "chi.w".into();
            head.normalisation.masked.clear();
        }),
        ("masked[0] is \"wind\"", |head| head.normalisation.masked[0] = "wind".into()),
        ("config.heads is 5, expected a divisor of d_model = 64", |head| {
            head.config["heads"] = 5.into();
        }),
        ("config.t_short is 121, expected 1..=120", |head| head.config["t_short"] = 121.into()),
        ("config.t_skip is 121, expected 0..=120", |head| head.config["t_skip"] = 121.into()),
        ("config.channels is 25, expected 24", |head| head.config["channels"] = 25.into()),
        ("missing field `d_k`", |head| {
            head.config.as_object_mut().unwrap().remove("d_k");
        }),
    ];
    for (wanted, change) in cases {
        let mut weights = good();
        change(&mut weights.head);
        let found = outcome(&weights).unwrap_err().to_string();
        assert!(found.contains(wanted), "wanted {wanted:?}, found {found:?}");
    }
}

#[test]
fn every_tensor_must_be_there_once_with_its_shape_and_finite() {
    let name = "cross.value.weight";
    let mut weights = good();
    weights.tensors.remove(name);
    let missing = WeightsError::Missing { name: name.into(), expected: vec![32, 64] };
    assert_eq!(outcome(&weights), Err(missing));

    let mut weights = good();
    weights.tensors.get_mut(name).unwrap().shape = vec![64, 32];
    let shape =
        WeightsError::Shape { name: name.into(), found: vec![64, 32], expected: vec![32, 64] };
    assert_eq!(outcome(&weights), Err(shape));

    let mut weights = good();
    weights.tensors.insert("more".into(), Tensor { shape: vec![1], values: vec![0.0] });
    assert_eq!(outcome(&weights), Err(WeightsError::Surplus { name: "more".into() }));

    let mut weights = good();
    weights.tensors.get_mut(name).unwrap().values[65] = f32::INFINITY;
    let words = outcome(&weights).unwrap_err().to_string();
    assert!(words.contains("\"cross.value.weight\" holds inf at index 65"), "{words}");
}

#[test]
fn another_inertia_or_rate_is_refused() {
    let head = good().head;
    let m_bar = Coords::repeat(1.0);
    assert_eq!(head.check_loop(&m_bar, 100.0), Ok(()));
    let mut other = m_bar;
    other[4] = 1.1;
    let words = head.check_loop(&other, 100.0).unwrap_err().to_string();
    assert!(words.contains("M̄ theta = 1, the controller has 1.1"), "{words}");
    let words = head.check_loop(&m_bar, 50.0).unwrap_err().to_string();
    assert!(words.contains("trained at 100 Hz, the outer loop runs at 50 Hz"), "{words}");
}
