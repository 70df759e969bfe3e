//! Vector registers of `f32` and `f64` with operators, and masks of eight lanes.
//!
//! A register is as wide as the instruction set `S`, so eight lanes take one register or several.
//! Products and sums are never fused, so that every processor gives the same bits.

use std::ops::{Add, Mul, Sub};

use pulp::Simd;

use super::LANES;

/// Defines a register type; the two types differ only in the names of the instructions.
macro_rules! register {
    ($name:ident, $element:ty, $values:ident, $lanes:ident, $as_simd:ident, $as_mut_simd:ident,
     $splat:ident, $add:ident, $sub:ident, $mul:ident, $min:ident, $max:ident) => {
        /// A vector register of the instruction set `S`.
        #[derive(Clone, Copy)]
        pub struct $name<S: Simd> {
            simd: S,
            values: S::$values,
        }

        impl<S: Simd> $name<S> {
            /// Number of registers that hold eight lanes.
            pub const COUNT: usize = LANES / S::$lanes;

            /// Returns a register with the same value in all lanes.
            #[inline(always)]
            pub fn splat(simd: S, value: $element) -> Self {
                Self { simd, values: simd.$splat(value) }
            }

            /// Loads register number `at` of eight lanes.
            #[inline(always)]
            pub fn load(simd: S, lanes: &[$element; LANES], at: usize) -> Self {
                Self { simd, values: S::$as_simd(lanes).0[at] }
            }

            /// Stores into register number `at` of eight lanes.
            #[inline(always)]
            pub fn store(self, lanes: &mut [$element; LANES], at: usize) {
                S::$as_mut_simd(lanes).0[at] = self.values;
            }

            /// Returns the minimum of each lane.
            #[inline(always)]
            pub fn min(self, other: Self) -> Self {
                Self { values: self.simd.$min(self.values, other.values), ..self }
            }

            /// Returns the maximum of each lane.
            #[inline(always)]
            pub fn max(self, other: Self) -> Self {
                Self { values: self.simd.$max(self.values, other.values), ..self }
            }
        }

        impl<S: Simd> Add for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self { values: self.simd.$add(self.values, other.values), ..self }
            }
        }

        impl<S: Simd> Sub for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self { values: self.simd.$sub(self.values, other.values), ..self }
            }
        }

        impl<S: Simd> Mul for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                Self { values: self.simd.$mul(self.values, other.values), ..self }
            }
        }
    };
}

register!(
    F32s,
    f32,
    f32s,
    F32_LANES,
    as_simd_f32s,
    as_mut_simd_f32s,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    min_f32s,
    max_f32s
);
register!(
    F64s,
    f64,
    f64s,
    F64_LANES,
    as_simd_f64s,
    as_mut_simd_f64s,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    min_f64s,
    max_f64s
);

impl<S: Simd> F32s<S> {
    /// Returns the absolute value of each lane.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { values: self.simd.abs_f32s(self.values), ..self }
    }

    /// Returns the square root of each lane.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self { values: self.simd.sqrt_f32s(self.values), ..self }
    }
}

/// Returns a mask with one bit per lane, set if the sign of the lane is.
#[inline(always)]
pub fn negative(values: &[f32; LANES]) -> u32 {
    wide::f32x8::from(*values).to_bitmask()
}

/// Returns a mask with one bit per lane, set if the sign of the lane is.
#[inline(always)]
pub fn negative_f64(values: &[f64; LANES]) -> u32 {
    let [a, b, c, d, e, f, g, h] = *values;
    wide::f64x4::from([a, b, c, d]).to_bitmask() | wide::f64x4::from([e, f, g, h]).to_bitmask() << 4
}

/// Iterates over the lanes that are set in `mask`, ascending.
#[inline(always)]
pub fn lanes_of(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (mask != 0).then(|| {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            lane
        })
    })
}
