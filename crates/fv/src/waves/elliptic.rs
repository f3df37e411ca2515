//! Elliptic integrals and functions by the arithmetic-geometric mean (M. Abramowitz, I. A. Stegun,
//! Handbook of Mathematical Functions, 1964, ch. 16.4 and 17.6). They take `m1 = 1 - m`: waves are
//! long where it is small.

/// Steps after which the mean is exact for any `m1` above 1e-300.
const STEPS: usize = 16;

/// The complete integrals K and E.
pub(super) fn complete(m1: f64) -> (f64, f64) {
    let (mut a, mut b) = (1.0, m1.sqrt());
    let (mut sum, mut power) = (0.5 * (1.0 - m1), 1.0);
    for _ in 0..STEPS {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        sum += power * c * c;
        power *= 2.0;
    }
    let k = std::f64::consts::FRAC_PI_2 / a;
    (k, k * (1.0 - sum))
}

/// sn, cn and dn of `u`, which should lie within a period (4 K) of zero.
pub(super) fn functions(u: f64, m1: f64) -> [f64; 3] {
    let (mut a, mut c) = ([1.0; STEPS + 1], [(1.0 - m1).sqrt(); STEPS + 1]);
    let mut b = m1.sqrt();
    for i in 0..STEPS {
        (a[i + 1], c[i + 1]) = (0.5 * (a[i] + b), 0.5 * (a[i] - b));
        b = (a[i] * b).sqrt();
    }
    let mut phi = (1u64 << STEPS) as f64 * a[STEPS] * u;
    for i in (1..=STEPS).rev() {
        phi = 0.5 * (phi + (c[i] / a[i] * phi.sin()).asin());
    }
    let (sn, cn) = phi.sin_cos();
    [sn, cn, (cn * cn + m1 * sn * sn).sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_agree_with_tables_and_with_legendre() {
        // Abramowitz and Stegun, table 17.1, m = 0.5 and 0.9.
        let (k, e) = complete(0.5);
        assert!((k - 1.854_074_677_301_372).abs() < 1e-14);
        assert!((e - 1.350_643_881_047_675).abs() < 1e-14);
        for m1 in [0.9, 0.5, 1e-3, 1e-9] {
            let ((k, e), (k1, e1)) = (complete(m1), complete(1.0 - m1));
            let legendre = e * k1 + e1 * k - k * k1 - std::f64::consts::FRAC_PI_2;
            assert!(
                legendre.abs() < 1e-6 * k * k1 * f64::EPSILON.sqrt().max(m1),
                "{m1}: {legendre:e}"
            );
        }
    }

    #[test]
    fn functions_solve_their_equation() {
        for m1 in [0.7, 0.1, 1e-4] {
            let (k, _) = complete(m1);
            let [sn, cn, dn] = functions(k, m1);
            assert!((sn - 1.0).abs() < 1e-12 && cn.abs() < 1e-9 && (dn - m1.sqrt()).abs() < 1e-9);
            for i in 0..10 {
                let u = 0.4 * k * f64::from(i);
                let d = 1e-5;
                let [[above, ..], [below, ..]] = [functions(u + d, m1), functions(u - d, m1)];
                let [_, cn, dn] = functions(u, m1);
                assert!(((above - below) / (2.0 * d) - cn * dn).abs() < 1e-8);
            }
        }
        // Towards m = 1 they are those of the solitary wave.
        let [sn, cn, dn] = functions(1.5, 1e-12);
        assert!((sn - 1.5f64.tanh()).abs() < 1e-9);
        assert!((cn - 1.0 / 1.5f64.cosh()).abs() < 1e-9 && (dn - cn).abs() < 1e-9);
    }
}
