//! `[1 -1 -2 0 0 0 0]` and `[kg m^-1 s^-2]`.

use crate::tree::{Tok, Token};
use granflow_base::Dims;

/// Names that may stand in brackets: exponents of kg, m, s, K, mol, A, Cd.
const UNITS: &[(&str, [f64; 7])] = &[
    ("kg", [1., 0., 0., 0., 0., 0., 0.]),
    ("m", [0., 1., 0., 0., 0., 0., 0.]),
    ("s", [0., 0., 1., 0., 0., 0., 0.]),
    ("K", [0., 0., 0., 1., 0., 0., 0.]),
    ("mol", [0., 0., 0., 0., 1., 0., 0.]),
    ("A", [0., 0., 0., 0., 0., 1., 0.]),
    ("Cd", [0., 0., 0., 0., 0., 0., 1.]),
    ("N", [1., 1., -2., 0., 0., 0., 0.]),
    ("Pa", [1., -1., -2., 0., 0., 0., 0.]),
    ("J", [1., 2., -2., 0., 0., 0., 0.]),
    ("W", [1., 2., -3., 0., 0., 0., 0.]),
    ("Hz", [0., 0., -1., 0., 0., 0., 0.]),
    ("rad", [0.; 7]),
];

/// The dimensions between brackets, or what is wrong with them.
pub(super) fn parse(items: &[Token]) -> Result<Dims, String> {
    if let Some(e) = items.iter().map(Token::number).collect::<Option<Vec<f64>>>() {
        return match e.len() {
            0 => Ok(Dims::NONE),
            _ => Dims::from_exponents(&e).map_err(|e| e.to_string()),
        };
    }
    let mut sum = [0.0; 7];
    let mut sign = 1.0;
    for t in items {
        match &t.kind {
            Tok::Word(w) => product(w, &mut sign, &mut sum)?,
            Tok::Label(1) => {}
            _ => return Err(format!("{} is not a unit", t.describe())),
        }
    }
    Dims::from_exponents(&sum).map_err(|e| e.to_string())
}

/// `kg*m^2/s`: everything behind a slash divides.
fn product(text: &str, sign: &mut f64, sum: &mut [f64; 7]) -> Result<(), String> {
    let mut rest = text;
    while !rest.is_empty() {
        if let Some(r) = rest.strip_prefix('/') {
            (*sign, rest) = (-1.0, r);
            continue;
        }
        if let Some(r) = rest.strip_prefix(['*', '.']) {
            rest = r;
            continue;
        }
        let end = rest.find(['/', '*']).unwrap_or(rest.len());
        let (name, power) = rest[..end].split_once('^').unwrap_or((&rest[..end], "1"));
        let power: f64 = power.parse().map_err(|_| format!("`{power}` is not an exponent"))?;
        let unit = UNITS.iter().find(|u| u.0 == name);
        let Some((_, e)) = unit else { return Err(format!("`{name}` is not a known unit")) };
        sum.iter_mut().zip(e).for_each(|(s, e)| *s += *sign * power * e);
        rest = &rest[end..];
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers_mean_the_same() {
        let w = |s: &str| parse(&s.split(' ').map(Token::of_word).collect::<Vec<_>>());
        assert_eq!(w("kg m^-1 s^-2"), Ok(Dims::PRESSURE));
        assert_eq!(w("m^2/s"), Ok(Dims::KINEMATIC_VISCOSITY));
        assert_eq!(w("Pa*s"), Ok(Dims::VISCOSITY));
        let n = [0, 2, -1, 0, 0].map(Token::of_label);
        assert_eq!(parse(&n), Ok(Dims::KINEMATIC_VISCOSITY));
        assert!(w("furlong").is_err_and(|e| e.contains("furlong")));
        assert!(parse(&n[..3]).is_err());
    }
}
