//! Elementary functions that give the same bits on every platform.
//!
//! The methods of `f64` and `f32` call the C library of the system. C libraries differ from each other in the last digit, and one C
//! library may choose other code on another processor. The functions here come from the crate `libm`, which computes them with
//! IEEE 754 additions and multiplications alone. `clippy.toml` bans the methods. `sqrt`, `abs`, `floor`, `ceil`, `round` and
//! `mul_add` stay methods, because IEEE 754 prescribes every bit of their results.
//!
//! In and out: f64 or f32, angles in rad. A non-finite input gives the IEEE 754 result: NaN, an infinity or a limit. No state.

use std::ops::{Div, Mul};

macro_rules! functions {
    ($($(#[$doc:meta])* $name:ident($($x:ident),+) = $double:ident, $single:ident;)*) => {
        /// A number type with elementary functions: f64 or f32. No function takes `self`, so that a method of the standard
        /// library cannot replace it by accident.
        pub trait Real: Copy + From<f32> + Mul<Output = Self> + Div<Output = Self> {
            $($(#[$doc])* fn $name($($x: Self),+) -> Self;)*
        }

        impl Real for f64 {
            $(fn $name($($x: Self),+) -> Self { libm::$double($($x),+) })*
        }

        impl Real for f32 {
            $(fn $name($($x: Self),+) -> Self { libm::$single($($x),+) })*
        }

        $($(#[$doc])* pub fn $name<R: Real>($($x: R),+) -> R { R::$name($($x),+) })*
    };
}

functions! {
    /// Sine of an angle, rad.
    sin(x) = sin, sinf;
    /// Cosine of an angle, rad.
    cos(x) = cos, cosf;
    /// Tangent of an angle, rad.
    tan(x) = tan, tanf;
    /// Angle in [-π/2, π/2] whose sine is `x`, rad; NaN where |x| > 1.
    asin(x) = asin, asinf;
    /// Angle in [0, π] whose cosine is `x`, rad; NaN where |x| > 1.
    acos(x) = acos, acosf;
    /// Angle in [-π, π] of the point (`x`, `y`), rad; zero at the origin.
    atan2(y, x) = atan2, atan2f;
    /// Hyperbolic tangent.
    tanh(x) = tanh, tanhf;
    /// Exponential function.
    exp(x) = exp, expf;
    /// Natural logarithm; NaN below zero.
    ln(x) = log, logf;
    /// Decimal logarithm; NaN below zero.
    log10(x) = log10, log10f;
    /// `x` to the power of `exponent`; NaN for a negative `x` with a fractional exponent.
    powf(x, exponent) = pow, powf;
    /// Length of the vector (`x`, `y`), without overflow on the way.
    hypot(x, y) = hypot, hypotf;
    /// Error function.
    erf(x) = erf, erff;
}

/// Sine and cosine of an angle, rad.
pub fn sin_cos<R: Real>(x: R) -> (R, R) {
    (sin(x), cos(x))
}

/// `x` times `x`.
pub fn squared<R: Real>(x: R) -> R {
    x * x
}

/// `x` to a whole power, by multiplications in a fixed order; a negative power gives the reciprocal.
pub fn powi<R: Real>(x: R, power: i32) -> R {
    let (mut square, mut left, mut product) = (x, power.unsigned_abs(), R::from(1.0));
    while left > 0 {
        if left % 2 == 1 {
            product = product * square;
        }
        left /= 2;
        square = square * square;
    }
    if power < 0 { R::from(1.0) / product } else { product }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One case per call: the bits of its correctly rounded value, and the allowed error in units in the last place.
    macro_rules! rows {
        ($($call:expr, $bits:literal, $off:literal;)*) => { [$((stringify!($call), $call, $bits, $off)),*] };
    }

    // The correctly rounded values are from Python's mpmath 1.3.0 at 300 bits:
    // >>> mp.mp.prec = 300; x = mp.sin(mp.mpf(0.5)); mp.mp.prec = 53; struct.pack('>d', float(+x)).hex()

    #[test]
    fn each_function_has_its_bits_in_double_precision() {
        const MOST_OFF: u64 = 1; // what faithful rounding allows
        let rows: &[(&str, f64, u64, i64)] = &rows! {
            sin(0.5), 0x3fde_aee8_744b_05f0, 0;
            sin(3.0), 0x3fc2_1038_6db6_d55b, 0;
            sin(-1000.0), 0xbfea_75cc_150a_206b, 0;
            cos(0.5), 0x3fec_1528_065b_7d50, 0;
            cos(3.0), 0xbfef_ae04_be85_e5d2, 0;
            cos(1e6), 0x3fed_f9df_9906_d32c, 0;
            tan(0.1), 0x3fb9_af88_7743_0b80, 0;
            tan(1.5), 0x402c_33ed_50b8_8777, 0;
            tan(-2.5), 0x3fe7_e79b_4e00_bb15, 0;
            asin(0.1), 0x3fb9_a492_7603_7884, 0;
            asin(0.7), 0x3fe8_d00e_692a_fd95, 0;
            asin(-0.99), 0xbff6_de3c_6f33_d51d, 0;
            acos(0.1), 0x3ff7_87b2_2ce3_f590, 0;
            acos(-0.7), 0x4002_c501_446c_d5f1, 1;
            acos(0.999), 0x3fa6_e634_e566_a29e, 0;
            atan2(0.3, 1.0), 0x3fd2_a73a_661e_af06, 0;
            atan2(1.0, -2.0), 0x4005_6c6e_7397_f5ae, 0;
            atan2(-5.0, 0.25), 0xbff8_555a_2787_981f, 0;
            tanh(0.2), 0x3fc9_4398_30b3_a590, 0;
            tanh(1.1), 0x3fe9_9db0_1fde_2405, 0;
            tanh(-4.0), 0xbfef_fa81_708a_0b42, 0;
            exp(0.1), 0x3ff1_aec7_b35a_00d4, 0;
            exp(-3.3), 0x3fa2_e259_bb85_be85, 0;
            exp(12.5), 0x4110_60c5_2565_ba66, 0;
            ln(0.1), 0xc002_6bb1_bbb5_5515, 0;
            ln(2.0), 0x3fe6_2e42_fefa_39ef, 0;
            ln(12_345.0), 0x4022_d78e_26ae_18e8, 0;
            log10(0.1), 0xbff0_0000_0000_0000, 0;
            log10(2.0), 0x3fd3_4413_509f_79ff, 0;
            log10(12_345.0), 0x4010_5daf_d767_0640, 0;
            powf(0.1, 0.3), 0x3fe0_09b9_cf33_4253, 0;
            powf(10.0, -2.5), 0x3f69_e7c6_e433_90b7, 0;
            powf(1.37, 12.0), 0x4045_dbba_f5dc_ff75, -1;
            hypot(0.1, 0.2), 0x3fcc_9f25_c5bf_edda, -1;
            hypot(3.3, -4.7), 0x4016_f8a6_3a24_9c74, 0;
            hypot(1e200, 1e199), 0x6975_01c9_357b_e18d, 0;
            erf(0.1), 0x3fbc_ca5e_a24f_b334, 0;
            erf(0.9), 0x3fe9_8045_a6c8_a2e6, 0;
            erf(-2.2), 0xbfef_f0bd_5402_5381, 0;
        };
        for &(call, found, rounded, off) in rows {
            assert_eq!(
                found.to_bits().wrapping_sub(rounded).cast_signed(),
                off,
                "{call} = {found}"
            );
            assert!(off.unsigned_abs() <= MOST_OFF, "{call}");
        }
    }

    #[test]
    fn each_function_that_networks_use_has_its_bits_in_single_precision() {
        const MOST_OFF: u32 = 1; // what faithful rounding allows
        let rows: &[(&str, f32, u32, i32)] = &rows! {
            exp(-3.3_f32), 0x3d17_12ce, 0;
            tanh(0.2_f32), 0x3e4a_1cc2, 0;
            erf(0.9_f32), 0x3f4c_022d, 0;
            sin(3.0_f32), 0x3e10_81c3, 0;
            cos(0.5_f32), 0x3f60_a940, 0;
        };
        for &(call, found, rounded, off) in rows {
            assert_eq!(
                found.to_bits().wrapping_sub(rounded).cast_signed(),
                off,
                "{call} = {found}"
            );
            assert!(off.unsigned_abs() <= MOST_OFF, "{call}");
        }
    }

    #[test]
    fn whole_powers_are_products() {
        // The products are exact in binary, so rounding cannot hide a wrong order or number of factors.
        let powers = [powi(1.5, 0), powi(1.5, 3), powi(-3.0, 5), powi(2.0, -4)];
        assert_eq!(powers.map(f64::to_bits), [1.0, 3.375, -243.0, 0.0625].map(f64::to_bits));
        let squares = [squared(-1.5), squared(3.0)];
        assert_eq!(squares.map(f64::to_bits), [2.25, 9.0].map(f64::to_bits));
        assert_eq!(sin_cos(0.5), (sin(0.5), cos(0.5)));
    }
}
