//! The inner loops of the networks, compiled for several instruction sets; one of them is chosen when the weights are read.
//!
//! In: f32 rows and weights packed in panels of [`LANES`] outputs. Out: f32 rows. No state.
//!
//! Every loop is written once, and a wrapper with the matching `target_feature` compiles it for each instruction set. The product
//! names its registers through `Lanes`; the compiler chooses the registers of the other loops. Calling a wrapper on a processor
//! without the feature is undefined behaviour, hence `unsafe`. A [`Kernel`] exists only where the processor has the features.
//! Instruction sets round differently (a fused multiply-add rounds once), so the name of the kernel is part of a run's identity.
#![allow(
    clippy::inline_always,
    reason = "a loop left uninlined is not compiled for the instruction set"
)]
#![allow(
    unsafe_code,
    reason = "calls of functions compiled for instruction sets found at run time"
)]

use super::elementwise::{dot_body, gelu_body, norm_body, softmax_body, spread_body};
use super::product::{Plain, Product, Weight, product_body};

/// Outputs per panel of packed weights: two AVX2 registers, or one of AVX-512.
pub const LANES: usize = 16;

/// Instruction set of the inner loops. A value exists only if this processor supports it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kernel(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Set {
    Scalar,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Kernel {
    /// The instruction set that every processor has; it gives the same numbers everywhere.
    pub const SCALAR: Self = Self(Set::Scalar);

    /// The kernels that this processor supports, slowest first.
    pub fn available() -> Vec<Self> {
        #[allow(unused_mut, reason = "other architectures have one")]
        let mut all = vec![Self::SCALAR];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                all.push(Self(Set::Avx2));
                if is_x86_feature_detected!("avx512f") {
                    all.push(Self(Set::Avx512));
                }
            }
        }
        all
    }

    /// The fastest kernel that this processor supports.
    pub fn best() -> Self {
        Self::available().pop().unwrap_or(Self::SCALAR)
    }

    /// Its name in scenarios, recordings and reports.
    pub fn name(self) -> &'static str {
        match self.0 {
            Set::Scalar => "scalar",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "avx512",
        }
    }

    /// The kernel called `name`; `None` if no kernel has that name or this processor does not support it.
    pub fn named(name: &str) -> Option<Self> {
        Self::available().into_iter().find(|kernel| kernel.name() == name)
    }
}

/// [`LANES`] numbers in registers.
pub(crate) trait Lanes: Copy {
    /// True if multiply-add is one instruction.
    const FUSED: bool;
    /// Number of rows of a product whose sums fit into registers.
    const ROWS: usize;
    fn splat(value: f32) -> Self;
    fn load(values: &[f32; LANES]) -> Self;
    /// Converts bf16 numbers.
    fn widen(values: &[u16; LANES]) -> Self;
    /// `self * factor + sum`.
    fn times(self, factor: Self, sum: Self) -> Self;
    fn plus(self, other: Self) -> Self;
    fn store(self) -> [f32; LANES];
    /// Prefetches memory that will be read soon.
    fn fetch<T>(_soon: &T) {}
}

/// Declares a function that runs `$body` compiled for the kernel's instruction set. The type of the registers is the first
/// parameter of the body.
macro_rules! for_each_set {
    ($(#[$doc:meta])* $name:ident <$($g:ident : $b:path)?> ($($arg:ident : $type:ty),*) = $body:ident) => {
        $(#[$doc])*
        pub(crate) fn $name<$($g: $b)?>(kernel: Kernel, $($arg: $type),*) {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,fma")]
            fn avx2<$($g: $b)?>($($arg: $type),*) {
                $body::<x86::Avx2, $($g)?>($($arg),*);
            }
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx512f,avx2,fma")]
            fn avx512<$($g: $b)?>($($arg: $type),*) {
                $body::<x86::Avx512, $($g)?>($($arg),*);
            }
            match kernel.0 {
                Set::Scalar => $body::<Plain, $($g)?>($($arg),*),
                // SAFETY: this value of `Set` is made by `Kernel::available` only, after it found AVX2 and FMA.
                #[cfg(target_arch = "x86_64")]
                Set::Avx2 => unsafe { avx2::<$($g)?>($($arg),*) },
                // SAFETY: this value of `Set` is made by `Kernel::available` only, after it found AVX-512F, AVX2 and FMA.
                #[cfg(target_arch = "x86_64")]
                Set::Avx512 => unsafe { avx512::<$($g)?>($($arg),*) },
            }
        }
    };
}

for_each_set! {
    /// `Y = X W^T + b`.
    product<W: Weight>(operands: Product<'_, W>) = product_body
}

for_each_set! {
    /// `x Phi(x)` in place, see [`super::activation::gelu`].
    gelu<>(x: &mut [f32]) = gelu_body
}

for_each_set! {
    /// Softmax of `scale x` in place over the first `n` numbers of each row, rows `stride` apart.
    softmax<>(x: &mut [f32], stride: usize, n: usize, scale: f32) = softmax_body
}

for_each_set! {
    /// `1 / sqrt(var + eps)` of `x` into `out[0]`.
    spread_into<>(x: &[f32], out: &mut [f32; 1]) = spread_body
}

for_each_set! {
    /// The scalar product into `out[0]`.
    dot_into<>(a: &[f32], b: &[f32], out: &mut [f32; 1]) = dot_body
}

/// `1 / sqrt(var + eps)` of `x`, as layer normalisation defines it.
pub(crate) fn spread(kernel: Kernel, x: &[f32]) -> f32 {
    let mut out = [0.0];
    spread_into(kernel, x, &mut out);
    out[0]
}

/// The scalar product.
pub(crate) fn dot(kernel: Kernel, a: &[f32], b: &[f32]) -> f32 {
    let mut out = [0.0];
    dot_into(kernel, a, b, &mut out);
    out[0]
}

for_each_set! {
    /// Layer normalisation of each row of width `weight.len()` from `x` into `y`.
    norm<>(x: &[f32], weight: &[f32], bias: &[f32], y: &mut [f32]) = norm_body
}

/// Registers of x86-64 with the features that [`Kernel::available`] looks for.
#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{
        __m256, __m512, _MM_HINT_T1, _mm_loadu_si128, _mm_prefetch, _mm256_add_ps,
        _mm256_castsi256_ps, _mm256_cvtepu16_epi32, _mm256_fmadd_ps, _mm256_loadu_ps,
        _mm256_loadu_si256, _mm256_set1_ps, _mm256_slli_epi32, _mm256_storeu_ps, _mm512_add_ps,
        _mm512_castsi512_ps, _mm512_cvtepu16_epi32, _mm512_fmadd_ps, _mm512_loadu_ps,
        _mm512_set1_ps, _mm512_slli_epi32, _mm512_storeu_ps,
    };

    use super::{LANES, Lanes};

    /// Two registers of eight.
    #[derive(Clone, Copy)]
    pub(super) struct Avx2(__m256, __m256);

    // SAFETY of every block below: the methods are inlined into a function compiled for AVX2 and FMA, which runs only where
    // `Kernel::available` found both. Pointers come from arrays of LANES numbers and stay within them.
    impl Lanes for Avx2 {
        const FUSED: bool = true;
        const ROWS: usize = 5;

        #[inline(always)]
        fn splat(value: f32) -> Self {
            // SAFETY: needs AVX, see above.
            unsafe { Self(_mm256_set1_ps(value), _mm256_set1_ps(value)) }
        }

        #[inline(always)]
        fn load(values: &[f32; LANES]) -> Self {
            let from = values.as_ptr();
            // SAFETY: needs AVX, see above; reads the numbers 0..8 and 8..16 of 16.
            unsafe { Self(_mm256_loadu_ps(from), _mm256_loadu_ps(from.add(8))) }
        }

        #[inline(always)]
        fn widen(values: &[u16; LANES]) -> Self {
            let from = values.as_ptr();
            let wide = |part: usize| {
                // SAFETY: needs AVX2, see above; `part` is 0 or 8, so it reads 8 numbers within 16.
                unsafe {
                    let half = _mm_loadu_si128(from.add(part).cast());
                    _mm256_castsi256_ps(_mm256_slli_epi32::<16>(_mm256_cvtepu16_epi32(half)))
                }
            };
            Self(wide(0), wide(8))
        }

        #[inline(always)]
        fn times(self, factor: Self, sum: Self) -> Self {
            // SAFETY: needs FMA, see above.
            unsafe {
                Self(
                    _mm256_fmadd_ps(self.0, factor.0, sum.0),
                    _mm256_fmadd_ps(self.1, factor.1, sum.1),
                )
            }
        }

        #[inline(always)]
        fn plus(self, other: Self) -> Self {
            // SAFETY: needs AVX, see above.
            unsafe { Self(_mm256_add_ps(self.0, other.0), _mm256_add_ps(self.1, other.1)) }
        }

        #[inline(always)]
        fn store(self) -> [f32; LANES] {
            let mut values = [0.0; LANES];
            let to = values.as_mut_ptr();
            // SAFETY: needs AVX, see above; writes the numbers 0..8 and 8..16 of 16.
            unsafe {
                _mm256_storeu_ps(to, self.0);
                _mm256_storeu_ps(to.add(8), self.1);
            }
            values
        }

        #[inline(always)]
        fn fetch<T>(soon: &T) {
            // SAFETY: fetching has no effect on values, whatever the address.
            unsafe { _mm_prefetch::<_MM_HINT_T1>(std::ptr::from_ref(soon).cast()) }
        }
    }

    /// One register of sixteen.
    #[derive(Clone, Copy)]
    pub(super) struct Avx512(__m512);

    // SAFETY of every block below: as for AVX2, with AVX-512F.
    impl Lanes for Avx512 {
        const FUSED: bool = true;
        const ROWS: usize = 13;

        #[inline(always)]
        fn splat(value: f32) -> Self {
            // SAFETY: needs AVX-512F, see above.
            unsafe { Self(_mm512_set1_ps(value)) }
        }

        #[inline(always)]
        fn load(values: &[f32; LANES]) -> Self {
            // SAFETY: needs AVX-512F, see above; reads 16 numbers of 16.
            unsafe { Self(_mm512_loadu_ps(values.as_ptr())) }
        }

        #[inline(always)]
        fn widen(values: &[u16; LANES]) -> Self {
            // SAFETY: needs AVX-512F, see above; reads 16 numbers of 16.
            unsafe {
                let half = _mm256_loadu_si256(values.as_ptr().cast());
                Self(_mm512_castsi512_ps(_mm512_slli_epi32::<16>(_mm512_cvtepu16_epi32(half))))
            }
        }

        #[inline(always)]
        fn times(self, factor: Self, sum: Self) -> Self {
            // SAFETY: needs AVX-512F, see above.
            unsafe { Self(_mm512_fmadd_ps(self.0, factor.0, sum.0)) }
        }

        #[inline(always)]
        fn plus(self, other: Self) -> Self {
            // SAFETY: needs AVX-512F, see above.
            unsafe { Self(_mm512_add_ps(self.0, other.0)) }
        }

        #[inline(always)]
        fn store(self) -> [f32; LANES] {
            let mut values = [0.0; LANES];
            // SAFETY: needs AVX-512F, see above; writes 16 numbers of 16.
            unsafe { _mm512_storeu_ps(values.as_mut_ptr(), self.0) }
            values
        }

        #[inline(always)]
        fn fetch<T>(soon: &T) {
            // SAFETY: fetching has no effect on values, whatever the address.
            unsafe { _mm_prefetch::<_MM_HINT_T1>(std::ptr::from_ref(soon).cast()) }
        }
    }
}
