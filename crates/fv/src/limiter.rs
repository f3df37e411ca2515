//! Flux limiters: how much of the central correction a limited scheme takes, as a function of
//! the ratio `r` of successive gradients (Sweby 1984).

/// A limiter function psi(r). Zero-sized or one number; the loops are compiled once per limiter.
pub trait Limiter: Copy + Sync {
    /// The share of the difference between central and upwind.
    fn psi(self, r: f64) -> f64;
}

/// Work that is compiled for each limiter; see [`LimiterKind::run`].
pub trait LimiterVisitor {
    /// What the work returns.
    type Out;
    /// The work with limiter `l`.
    fn with<L: Limiter>(self, l: L) -> Self::Out;
}

macro_rules! limiters {
    ($($(#[$doc:meta])* $name:ident = $key:literal => |$k:ident, $r:ident| $body:expr;)*) => {
        $( $(#[$doc])* #[derive(Clone, Copy, Debug)] struct $name(f64);
           impl Limiter for $name {
               #[inline(always)] fn psi(self, $r: f64) -> f64 { let $k = self.0; let _ = $k; $body }
           } )*
        /// A limiter chosen by name, with its parameter where it has one.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum LimiterKind { $( $(#[$doc])* $name(f64)),* }
        impl LimiterKind {
            /// All names, as in `fvSchemes`.
            pub const NAMES: &[&str] = &[$($key),*];
            /// The limiter of that name; `k` is the number behind it (1 where none is given).
            pub fn parse(name: &str, k: f64) -> Option<Self> {
                match name { $($key => Some(Self::$name(k)),)* _ => None }
            }
            /// The name in `fvSchemes`.
            pub fn name(self) -> &'static str { match self { $(Self::$name(_) => $key),* } }
            /// Runs `v` compiled for this limiter: the choice stays outside the loop.
            pub fn run<V: LimiterVisitor>(self, v: V) -> V::Out {
                match self { $(Self::$name(k) => v.with($name(k))),* }
            }
        }
    };
}

limiters! {
    /// Limited central differences, `clamp(2 r / k, 0, 1)`; the smaller k the nearer to central.
    LimitedLinear = "limitedLinear" => |k, r| (2.0 / k.max(1e-10) * r).clamp(0.0, 1.0);
    /// van Leer (1974).
    VanLeer = "vanLeer" => |_k, r| (r + r.abs()) / (1.0 + r.abs());
    /// van Albada, van Leer & Roberts (1982).
    VanAlbada = "vanAlbada" => |_k, r| if r <= 0.0 { 0.0 } else { r * (r + 1.0) / (r * r + 1.0) };
    /// Roe (1986).
    MinMod = "Minmod" => |_k, r| r.clamp(0.0, 1.0);
    /// Roe (1985).
    SuperBee = "SuperBee" => |_k, r| (2.0 * r).min(1.0).max(r.min(2.0)).max(0.0);
    /// Monotonised central: van Leer (1977).
    Muscl = "MUSCL" => |_k, r| (2.0 * r).min(0.5 * r + 0.5).clamp(0.0, 2.0);
    /// QUICK (Leonard 1979) kept within the bounds of total variation diminishing schemes.
    Quick = "QUICK" => |_k, r| (2.0 * r).min(0.25 * r + 0.75).clamp(0.0, 2.0);
    /// Waterson & Deconinck (1995).
    Ospre = "OSPRE" => |_k, r| if r <= 0.0 { 0.0 } else { 1.5 * r * (r + 1.0) / (r * (r + 1.0) + 1.0) };
    /// Lien & Leschziner (1994).
    Umist = "UMIST" => |_k, r| (2.0 * r).min(0.75 * r + 0.25).min(0.25 * r + 0.75).clamp(0.0, 2.0);
    /// Jasak, Weller & Gosman (1999): central where the normalised value is above half of k.
    Gamma = "Gamma" => |k, r| if r <= 0.0 { 0.0 } else { (2.0 * r / (k.max(1e-10) * (1.0 + r))).min(1.0) };
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    struct Psi(f64);
    impl LimiterVisitor for Psi {
        type Out = f64;
        fn with<L: Limiter>(self, l: L) -> f64 {
            l.psi(self.0)
        }
    }

    proptest! {
        /// Sweby's region: 0 <= psi <= min(2 r, 2), and zero at extrema.
        #[test]
        fn limiters_are_tvd(r in -5.0f64..20.0) {
            for name in LimiterKind::NAMES {
                let psi = LimiterKind::parse(name, 1.0).expect("listed").run(Psi(r));
                prop_assert!(psi >= 0.0);
                prop_assert!(psi <= (2.0 * r).clamp(0.0, 2.0) + 1e-12, "{name} {r} {psi}");
            }
        }
    }

    #[test]
    fn smooth_flow_gets_the_central_scheme() {
        for name in LimiterKind::NAMES {
            let psi = LimiterKind::parse(name, 1.0).expect("listed").run(Psi(1.0));
            assert!((psi - 1.0).abs() < 1e-12, "{name}");
        }
    }
}
