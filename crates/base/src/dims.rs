//! Physical dimensions.

use std::fmt;

/// SI exponents of mass, length, time, temperature, amount, current and luminous intensity,
/// held doubled so that half powers stay exact.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Dims([i8; 7]);

impl Dims {
    /// A pure number.
    pub const NONE: Dims = Dims::new(0, 0, 0);
    /// m.
    pub const LENGTH: Dims = Dims::new(0, 1, 0);
    /// m2.
    pub const AREA: Dims = Dims::new(0, 2, 0);
    /// m3.
    pub const VOLUME: Dims = Dims::new(0, 3, 0);
    /// s.
    pub const TIME: Dims = Dims::new(0, 0, 1);
    /// 1/s: strain rate, fluidity.
    pub const RATE: Dims = Dims::new(0, 0, -1);
    /// m/s.
    pub const VELOCITY: Dims = Dims::new(0, 1, -1);
    /// m/s2.
    pub const ACCELERATION: Dims = Dims::new(0, 1, -2);
    /// kg/m3.
    pub const DENSITY: Dims = Dims::new(1, -3, 0);
    /// Pa.
    pub const PRESSURE: Dims = Dims::new(1, -1, -2);
    /// m2/s2: pressure over density.
    pub const KINEMATIC_PRESSURE: Dims = Dims::new(0, 2, -2);
    /// Pa s.
    pub const VISCOSITY: Dims = Dims::new(1, -1, -1);
    /// m2/s.
    pub const KINEMATIC_VISCOSITY: Dims = Dims::new(0, 2, -1);
    /// m3/s.
    pub const VOLUME_FLUX: Dims = Dims::new(0, 3, -1);
    /// kg/s.
    pub const MASS_FLUX: Dims = Dims::new(1, 0, -1);
    /// N.
    pub const FORCE: Dims = Dims::new(1, 1, -2);

    /// `mass^m length^l time^t`.
    pub const fn new(m: i8, l: i8, t: i8) -> Self {
        Dims([2 * m, 2 * l, 2 * t, 0, 0, 0, 0])
    }
    /// From the exponents as a dictionary writes them (5 or 7 numbers, halves allowed).
    ///
    /// # Errors
    /// [`ParseDimsError`] when the count is neither 5 nor 7 or an exponent is not a multiple of ½.
    pub fn from_exponents(e: &[f64]) -> Result<Self, ParseDimsError> {
        if e.len() != 5 && e.len() != 7 {
            return Err(ParseDimsError::Count(e.len()));
        }
        let mut d = [0i8; 7];
        for (d, &x) in d.iter_mut().zip(e) {
            let twice = 2.0 * x;
            if (twice - twice.round()).abs() > 1e-9 || twice.abs() > 100.0 {
                return Err(ParseDimsError::Exponent(x));
            }
            *d = twice.round() as i8;
        }
        Ok(Dims(d))
    }
    /// Dimensions of a product.
    #[must_use]
    pub const fn mul(self, o: Dims) -> Dims {
        let mut e = self.0;
        let mut i = 0;
        while i < 7 {
            e[i] += o.0[i];
            i += 1;
        }
        Dims(e)
    }
    /// Dimensions of the reciprocal.
    #[must_use]
    pub const fn inv(self) -> Dims {
        let mut e = self.0;
        let mut i = 0;
        while i < 7 {
            e[i] = -e[i];
            i += 1;
        }
        Dims(e)
    }
    /// Dimensions of a quotient.
    #[must_use]
    pub const fn div(self, o: Dims) -> Dims {
        self.mul(o.inv())
    }
}

/// Why a set of exponents is no dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParseDimsError {
    /// Neither 5 nor 7 exponents.
    Count(usize),
    /// Not a multiple of one half.
    Exponent(f64),
}
impl fmt::Display for ParseDimsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParseDimsError::Count(n) => write!(f, "dimensions need 5 or 7 exponents, found {n}"),
            ParseDimsError::Exponent(x) => write!(f, "`{x}` is not a whole or half exponent"),
        }
    }
}
impl std::error::Error for ParseDimsError {}

impl fmt::Display for Dims {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[")?;
        for (i, e) in self.0.iter().enumerate() {
            let sep = if i == 0 { "" } else { " " };
            write!(f, "{sep}{}", f64::from(*e) / 2.0)?;
        }
        write!(f, "]")
    }
}
impl fmt::Debug for Dims {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viscosity_is_pressure_times_time() {
        assert_eq!(Dims::PRESSURE.mul(Dims::TIME), Dims::VISCOSITY);
        assert_eq!(Dims::VISCOSITY.div(Dims::DENSITY), Dims::KINEMATIC_VISCOSITY);
    }

    #[test]
    fn reads_what_it_prints_and_refuses_thirds() {
        assert_eq!(Dims::PRESSURE.to_string(), "[1 -1 -2 0 0 0 0]");
        let d = Dims::from_exponents(&[0.0, 0.5, -1.0, 0.0, 0.0]);
        assert_eq!(d.map(|d| d.to_string()), Ok("[0 0.5 -1 0 0 0 0]".into()));
        assert_eq!(Dims::from_exponents(&[1.0; 4]), Err(ParseDimsError::Count(4)));
        assert_eq!(
            Dims::from_exponents(&[0.3, 0.0, 0.0, 0.0, 0.0]),
            Err(ParseDimsError::Exponent(0.3))
        );
    }
}
