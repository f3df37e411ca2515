//! Loops for wide vector registers: compiled for what the oldest machines have and again for what
//! newer ones do, chosen when the program runs. No operation is fused or reordered by that, so
//! results have the same bits everywhere.

/// Calls `f`, compiled for the widest vector registers of this machine: `f` and what it calls take
/// part only where they are inlined, hence `wide(#[inline(always)] || ...)`. Worth it for some
/// thousand operations at a time.
#[inline]
pub fn wide<R>(f: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
        {
            // SAFETY: the machine has what the function is compiled for.
            #[allow(unsafe_code)]
            return unsafe { x86_64::avx512(f) };
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: as above.
            #[allow(unsafe_code)]
            return unsafe { x86_64::avx2(f) };
        }
    }
    f()
}

#[cfg(target_arch = "x86_64")]
mod x86_64 {
    #[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq")]
    pub(super) fn avx512<R>(f: impl FnOnce() -> R) -> R {
        f()
    }
    #[target_feature(enable = "avx2")]
    pub(super) fn avx2<R>(f: impl FnOnce() -> R) -> R {
        f()
    }
}

/// `from[at[k]]` for each `k`: one check for all indices, so that the loads can be vector
/// instructions.
///
/// # Panics
/// When an index is not below the length of `from`.
#[inline(always)]
pub fn gather<T: Copy, C: Copy + Into<u32>, const L: usize>(from: &[T], at: &[C; L]) -> [T; L] {
    let at: [u32; L] = at.map(Into::into);
    let len = u32::try_from(from.len()).unwrap_or(u32::MAX);
    let beyond = at.iter().fold(false, |any, &i| any | (i >= len));
    assert!(!beyond, "an index is beyond the end");
    // SAFETY: every index was found to be below the length.
    #[allow(unsafe_code)]
    at.map(|i| unsafe { *from.get_unchecked(i as usize) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bits_are_those_of_the_plain_loop() {
        let x: Vec<f32> = (0..1000).map(|i| (i as f32).sin()).collect();
        let dot = || x.iter().zip(x.iter().rev()).map(|(a, b)| a * b + 0.1).sum::<f32>();
        assert_eq!(wide(dot).to_bits(), dot().to_bits());
    }

    #[test]
    fn gathers_what_is_asked_for() {
        assert_eq!(gather(&[5, 6, 7, 8], &[3u16, 0, 0, 2]), [8, 5, 5, 7]);
    }

    #[test]
    #[should_panic(expected = "beyond the end")]
    fn an_index_beyond_the_end_is_refused() {
        let _ = gather(&[5, 6, 7], &[0u32, 3, 1]);
    }
}
