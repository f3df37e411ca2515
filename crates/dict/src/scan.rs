//! The innermost loops of reading: white space and numbers in bytes.

/// Offset of the next byte that is neither white space nor comment.
#[inline]
pub(crate) fn space(b: &[u8], mut i: usize) -> usize {
    loop {
        match b.get(i) {
            Some(c) if c.is_ascii_whitespace() || *c == 0x0b => i += 1,
            Some(b'/') => match comment(b, i) {
                Some(end) => i = end,
                None => return i,
            },
            _ => return i,
        }
    }
}

/// Offset behind the comment that starts at `i`, if one does. An unclosed one takes the rest.
#[cold]
fn comment(b: &[u8], i: usize) -> Option<usize> {
    let rest = &b[i + 1..];
    match rest.first() {
        Some(b'/') => {
            // A backslash at the end of the line continues the comment, as in C++.
            let mut at = 1;
            loop {
                let n = rest[at..].iter().position(|&c| c == b'\n');
                at = match n {
                    Some(n) => at + n + 1,
                    None => return Some(b.len()),
                };
                if rest[at - 2] != b'\\' {
                    return Some(i + at);
                }
            }
        }
        Some(b'*') => {
            let end = rest[1..].windows(2).position(|w| w == b"*/");
            Some(end.map_or(b.len(), |n| i + n + 4))
        }
        _ => None,
    }
}

/// Whether the comment mark at `i` opens a block comment that nothing closes.
pub(crate) fn unclosed_comment(b: &[u8], i: usize) -> bool {
    b[i..].starts_with(b"/*") && !b[i + 2..].windows(2).any(|w| w == b"*/")
}

/// Whether a number may end before `c`.
#[inline]
fn delimits(c: Option<&u8>) -> bool {
    match c {
        None => true,
        Some(c) => matches!(
            c,
            0..=b' ' | b'(' | b')' | b'[' | b']' | b'{' | b'}' | b';' | b'/' | b'"' | b','
        ),
    }
}

/// A whole number at `i` and the offset behind it.
#[inline]
pub(crate) fn label(b: &[u8], i: usize) -> Option<(i64, usize)> {
    let mut at = i;
    let negative = match b.get(at) {
        Some(b'-') => {
            at += 1;
            true
        }
        Some(b'+') => {
            at += 1;
            false
        }
        _ => false,
    };
    let first = at;
    let mut x: i64 = 0;
    while let Some(d) = b.get(at).map(|c| c.wrapping_sub(b'0')).filter(|d| *d < 10) {
        x = x.checked_mul(10)?.checked_add(i64::from(d))?;
        at += 1;
    }
    (at > first && delimits(b.get(at))).then_some((if negative { -x } else { x }, at))
}

/// What is said of a number that no `f64` holds.
pub(crate) const OUT_OF_RANGE: &str = "this number is out of range";
/// And beside it.
pub(crate) const TOO_LARGE: &str = "its magnitude exceeds 1.8e308";

const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// A decimal number at `i`, the offset behind it, and whether it was written as a whole number.
///
/// Mantissas below 2^53 with powers of ten up to 22 are exact in one operation (Clinger 1990);
/// the rest goes to the standard library, which rounds correctly.
#[inline]
pub(crate) fn number(b: &[u8], i: usize) -> Option<(f64, usize, bool)> {
    let mut at = i;
    let negative = b.get(at) == Some(&b'-');
    if matches!(b.get(at), Some(b'-' | b'+')) {
        at += 1;
    }
    let (mut mantissa, mut digits, mut exponent) = (0u64, 0usize, 0i32);
    let start = at;
    while let Some(d) = b.get(at).map(|c| c.wrapping_sub(b'0')).filter(|d| *d < 10) {
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(d));
        at += 1;
    }
    digits += at - start;
    let mut whole = true;
    if b.get(at) == Some(&b'.') {
        whole = false;
        at += 1;
        let first = at;
        while let Some(d) = b.get(at).map(|c| c.wrapping_sub(b'0')).filter(|d| *d < 10) {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(d));
            at += 1;
        }
        digits += at - first;
        exponent = -i32::try_from(at - first).unwrap_or(i32::MAX);
    }
    if digits == 0 {
        return None;
    }
    if matches!(b.get(at), Some(b'e' | b'E')) {
        whole = false;
        at += 1;
        let minus = b.get(at) == Some(&b'-');
        if matches!(b.get(at), Some(b'-' | b'+')) {
            at += 1;
        }
        let first = at;
        let mut e = 0i32;
        while let Some(d) = b.get(at).map(|c| c.wrapping_sub(b'0')).filter(|d| *d < 10) {
            e = e.saturating_mul(10).saturating_add(i32::from(d));
            at += 1;
        }
        if at == first {
            return None;
        }
        exponent = exponent.saturating_add(if minus { -e } else { e });
    }
    if !delimits(b.get(at)) {
        return None;
    }
    // Leading zeros count as digits here: that only sends a few numbers the slow way.
    if digits <= 19 && mantissa < (1 << 53) && exponent.unsigned_abs() <= 22 {
        let m = mantissa as f64;
        let p = POWERS[exponent.unsigned_abs() as usize];
        let x = if exponent < 0 { m / p } else { m * p };
        return Some((if negative { -x } else { x }, at, whole));
    }
    let text = std::str::from_utf8(&b[i..at]).ok()?;
    Some((text.parse().ok()?, at, whole))
}

/// `nan`, `inf` and their negatives, as a diverged run writes them.
#[cold]
pub(crate) fn not_finite(b: &[u8], i: usize) -> Option<(f64, usize)> {
    let known: [(&[u8], f64); 4] = [
        (b"nan", f64::NAN),
        (b"-nan", f64::NAN),
        (b"inf", f64::INFINITY),
        (b"-inf", f64::NEG_INFINITY),
    ];
    known.into_iter().find_map(|(w, x)| {
        let end = i + w.len();
        let same = b.get(i..end).is_some_and(|s| s.eq_ignore_ascii_case(w));
        (same && delimits(b.get(end))).then_some((x, end))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_to_the_last_bit() {
        for text in [
            "0",
            "-0",
            "1",
            "+1.5",
            ".5",
            "5.",
            "1e-7",
            "0.1",
            "123456789012345678901234567890",
            "2.2250738585072014e-308",
            "1.7976931348623157e308",
            "9007199254740993",
            "-3.25E+2",
            "0.30000000000000004",
            "1e23",
            "6.02214076e23",
            "000000000000000000000000001.5",
        ] {
            let want: f64 = text.parse().unwrap();
            let (x, end, _) = number(text.as_bytes(), 0).unwrap();
            assert_eq!((x.to_bits(), end), (want.to_bits(), text.len()), "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in ["", "-", ".", "e5", "1e", "1e+", "2D", "1.2.3", "0x10", "abc", "1_000"] {
            assert_eq!(number(text.as_bytes(), 0), None, "{text}");
        }
        assert_eq!(number(b"4(0 1)", 0), Some((4.0, 1, true)));
        assert_eq!(label(b"99999999999999999999", 0), None);
        assert_eq!(label(b"1.0", 0), None);
    }

    #[test]
    fn comments_are_space() {
        assert_eq!(space(b" // a\n /* b */ x", 0), 15);
        assert_eq!(space(b"// a \\\n b\nx", 0), 10);
        assert_eq!(space(b"/* never closed", 0), 15);
        assert_eq!(space(b"/x", 0), 0);
        assert_eq!(space(b"//", 0), 2);
    }
}
