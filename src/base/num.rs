//! Casts that end at the nearest number of the other type instead of wrapping.

macro_rules! nearest {
    ($($to:ident)*) => {$(
        #[doc = concat!("The nearest `", stringify!($to), "`.")]
        #[must_use]
        pub fn $to<T: TryInto<$to> + PartialOrd + Default>(n: T) -> $to {
            let below = n < T::default();
            n.try_into().unwrap_or(if below { $to::MIN } else { $to::MAX })
        }
    )*};
}

nearest! { u8 u16 u32 u64 usize i32 i64 }

/// The nearest single; infinite beyond the largest one.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "rounding to single is meant")]
pub fn f32(value: f64) -> f32 {
    value as f32
}

/// The largest whole number that is not above: `f64::floor`, which is a call where the baseline has no instruction for
/// it. Of −0 it is +0.
#[inline]
#[must_use]
pub fn floor(value: f64) -> f64 {
    // From 2⁵² on all doubles are whole; what is not finite stays.
    if value.abs() < 4_503_599_627_370_496.0 {
        #[expect(clippy::cast_possible_truncation, reason = "below 2⁵²")]
        let toward_zero = value as i64 as f64;
        if toward_zero > value { toward_zero - 1.0 } else { toward_zero }
    } else {
        value
    }
}

/// The whole part of a number as an index, 0 below 0 and for NaN.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates, and NaN becomes 0"
)]
pub fn index(value: f64) -> usize {
    value as usize
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "whole numbers are compared")]
mod tests {
    use super::{floor, i32, u8, usize};

    #[test]
    fn floor_is_the_largest_whole_number_that_is_not_above() {
        let mut values = vec![0.0, 0.5, 1.0, 1e-300, 4.5e15, 4.6e15, 1e19, 1e300, f64::INFINITY];
        values.extend(values.clone().iter().map(|x| -x));
        for x in values {
            assert!(floor(x) == x.floor(), "{x}");
        }
        assert!(floor(f64::NAN).is_nan());
    }

    #[test]
    fn a_cast_ends_at_the_nearest_number() {
        assert_eq!((u8(-1i64), u8(255u64), u8(256u64)), (0, 255, 255));
        assert_eq!((i32(i64::MIN), i32(-7i64), i32(usize::MAX)), (i32::MIN, -7, i32::MAX));
        assert_eq!(usize(-3i32), 0);
    }
}
