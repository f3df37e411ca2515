//! Least squares in a few parameters: K. Levenberg, Quart. Appl. Math. 2 (1944) 164; D. W. Marquardt, J. SIAM 11
//! (1963) 431, with steps cut at the bounds.

/// Most steps.
const MOST_STEPS: usize = 40;
/// Relative change of the sum of squares, and of the parameters over their scale, that ends the search.
const SETTLED: f64 = 1e-7;
const STANDING: f64 = 1e-7;
/// Effect of a parameter over that of the strongest, each for a change of its own size, below which it is noise.
const UNTOLD: f64 = 1e-5;
/// Damping at first, its factor after a step that helped or not, and what is too much.
const FIRST: f64 = 1e-3;
const FACTOR: f64 = 10.0;
const STIFF: f64 = 1e9;

/// A parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) start: f64,
    pub(super) least: f64,
    pub(super) most: f64,
}

/// What it comes to.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    /// The parameters.
    pub(super) at: Vec<f64>,
    /// Differences over their errors there.
    pub(super) residuals: Vec<f64>,
    /// `(J^T J)^-1`, row by row, infinite for parameters that the data do not tell; none where others cannot be told
    /// apart.
    pub(super) covariance: Option<Vec<Vec<f64>>>,
    /// Whether the search came to its end.
    pub(super) converged: bool,
}

/// The model at several points: residuals, or nothing where it has no solution. An error ends all.
pub(super) type Model<'a, E> = dyn FnMut(&[Vec<f64>]) -> Result<Vec<Option<Vec<f64>>>, E> + 'a;

/// Finds the parameters with the least sum of squares. None where the model has no solution at the start.
pub(super) fn minimise<E>(
    bounds: &[Bounds],
    model: &mut Model<'_, E>,
    tell: &mut dyn FnMut(usize, &[f64], f64),
) -> Result<Option<Minimum>, E> {
    let n = bounds.len();
    let mut at: Vec<f64> = bounds.iter().map(|b| b.start).collect();
    let Some(mut residuals) = model(&[at.clone()])?.pop().flatten() else { return Ok(None) };
    let mut sum = squares(&residuals);
    let (mut damping, mut converged, mut steps) = (FIRST, false, 0);
    let mut normal;
    loop {
        let Some(slopes) = jacobian(bounds, &at, &residuals, model)? else {
            return Ok(Some(Minimum { at, residuals, covariance: None, converged: false }));
        };
        let product = |i: usize, j: usize| -> f64 {
            slopes[i].iter().zip(&slopes[j]).map(|(a, b)| a * b).sum()
        };
        normal = (0..n).map(|i| (0..n).map(|j| product(i, j)).collect()).collect::<Vec<Vec<f64>>>();
        let downhill: Vec<f64> = slopes
            .iter()
            .map(|s| -s.iter().zip(&residuals).map(|(a, b)| a * b).sum::<f64>())
            .collect();
        let told = told(bounds, &normal);
        tell(steps, &at, sum);
        if converged || steps == MOST_STEPS {
            break;
        }
        steps += 1;
        loop {
            let mut damped = normal.clone();
            (0..n).for_each(|i| damped[i][i] += damping * normal[i][i].max(f64::MIN_POSITIVE));
            // What the data do not tell stays where it is.
            let step = inverse_of(&damped, &told).map(|inverse| times(&inverse, &downhill));
            let Some(step) = step else {
                converged = false;
                break;
            };
            let trial: Vec<f64> =
                (0..n).map(|i| (at[i] + step[i]).clamp(bounds[i].least, bounds[i].most)).collect();
            let moved = (0..n).map(|i| (trial[i] - at[i]).abs() / bounds[i].scale());
            let moved = moved.fold(0.0, f64::max);
            if trial.iter().any(|x| !x.is_finite()) {
                break;
            }
            let found = model(std::slice::from_ref(&trial))?.pop().flatten();
            let better = found.map(|r| (squares(&r), r)).filter(|(s, _)| *s < sum);
            if let Some((less, there)) = better {
                converged = (sum - less) <= SETTLED * sum || moved <= STANDING;
                (at, residuals, sum) = (trial, there, less);
                damping = (damping / FACTOR).max(1e-12);
                break;
            }
            if moved <= STANDING || damping > STIFF {
                // Nothing near by is better.
                converged = true;
                break;
            }
            damping *= FACTOR;
        }
    }
    let told = told(bounds, &normal);
    let covariance = inverse_of(&normal, &told).map(|mut c| {
        (0..n).filter(|i| !told[*i]).for_each(|i| c[i][i] = f64::INFINITY);
        c
    });
    Ok(Some(Minimum { at, residuals, covariance, converged }))
}

impl Bounds {
    /// What a change of the parameter is measured by.
    fn scale(&self) -> f64 {
        self.start.abs().max(1e-3 * (self.most - self.least))
    }
}

/// Derivatives of the residuals, one column a parameter, by differences into the bounds.
fn jacobian<E>(
    bounds: &[Bounds],
    at: &[f64],
    residuals: &[f64],
    model: &mut Model<'_, E>,
) -> Result<Option<Vec<Vec<f64>>>, E> {
    let step = |i: usize| {
        let h = 1e-3 * bounds[i].scale();
        let Bounds { least, most, .. } = bounds[i];
        if at[i] + h <= most {
            h
        } else if at[i] - h >= least {
            -h
        } else {
            most - at[i]
        }
    };
    let beside = |i: usize| {
        let mut x = at.to_vec();
        x[i] += step(i);
        x
    };
    let points: Vec<Vec<f64>> = (0..at.len()).map(beside).collect();
    let mut out = Vec::new();
    for (i, there) in model(&points)?.into_iter().enumerate() {
        let Some(there) = there else { return Ok(None) };
        out.push(there.iter().zip(residuals).map(|(a, b)| (a - b) / step(i)).collect());
    }
    Ok(Some(out))
}

/// Which parameters the residuals depend on by more than the noise of a solution.
fn told(bounds: &[Bounds], normal: &[Vec<f64>]) -> Vec<bool> {
    let effect = |i: usize| normal[i][i].sqrt() * bounds[i].scale();
    let most = (0..bounds.len()).map(effect).fold(0.0, f64::max);
    (0..bounds.len()).map(|i| effect(i) > UNTOLD * most).collect()
}

/// The inverse of the part of `a` that `wanted` names, with zeros elsewhere.
fn inverse_of(a: &[Vec<f64>], wanted: &[bool]) -> Option<Vec<Vec<f64>>> {
    let kept: Vec<usize> = (0..a.len()).filter(|i| wanted[*i]).collect();
    let part: Vec<Vec<f64>> =
        kept.iter().map(|i| kept.iter().map(|j| a[*i][*j]).collect()).collect();
    let part = inverse(&part)?;
    let mut out = vec![vec![0.0; a.len()]; a.len()];
    for (r, i) in kept.iter().enumerate() {
        kept.iter().enumerate().for_each(|(c, j)| out[*i][*j] = part[r][c]);
    }
    Some(out)
}

fn squares(r: &[f64]) -> f64 {
    r.iter().map(|x| x * x).sum()
}

fn times(a: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
    a.iter().map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
}

/// The inverse of a symmetric positive matrix, by Gauss and Jordan; none where it is singular to rounding.
fn inverse(a: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let n = a.len();
    // Of the matrix with ones on its diagonal, so that units do not matter.
    let root: Vec<f64> = (0..n).map(|i| a[i][i].sqrt()).collect();
    if root.iter().any(|r| !(*r > 0.0 && r.is_finite())) {
        return None;
    }
    let mut m: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| a[i][j] / (root[i] * root[j])).collect()).collect();
    let mut out: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for k in 0..n {
        let pivot = m[k][k];
        if pivot <= 1e-12 {
            return None;
        }
        for j in 0..n {
            m[k][j] /= pivot;
            out[k][j] /= pivot;
        }
        for i in (0..n).filter(|i| *i != k) {
            let factor = m[i][k];
            for j in 0..n {
                m[i][j] -= factor * m[k][j];
                out[i][j] -= factor * out[k][j];
            }
        }
    }
    for (i, row) in out.iter_mut().enumerate() {
        row.iter_mut().enumerate().for_each(|(j, x)| *x /= root[i] * root[j]);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `y = a exp(-b x)` from its own values: the parameters, and the known covariance of a straight line.
    #[test]
    fn finds_the_parameters_behind_exact_data() {
        let x: Vec<f64> = (0..20).map(|i| 0.1 * f64::from(i)).collect();
        let of = |p: &Vec<f64>| {
            let r = x.iter().map(|x| p[0] * (-p[1] * x).exp() - 2.0 * (-3.0 * x).exp()).collect();
            Some(r)
        };
        let bounds = [(1.0, 0.1, 5.0), (1.0, 0.1, 9.0)];
        let bounds = bounds.map(|(start, least, most)| Bounds { start, least, most });
        let mut model =
            |p: &[Vec<f64>]| Ok::<_, ()>(p.iter().map(of).collect::<Vec<Option<Vec<f64>>>>());
        let found = minimise(&bounds, &mut model, &mut |_, _, _| ()).unwrap().unwrap();
        assert!(found.converged, "{found:?}");
        assert!((found.at[0] - 2.0).abs() < 1e-5 && (found.at[1] - 3.0).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn the_covariance_of_a_straight_line_is_the_textbook_s() {
        let x = [0.0, 1.0, 2.0, 3.0];
        let of = |p: &Vec<f64>| Some(x.iter().map(|x| p[0] + p[1] * x - 1.0 - x).collect());
        let bounds = [Bounds { start: 0.5, least: -9.0, most: 9.0 }; 2];
        let mut model =
            |p: &[Vec<f64>]| Ok::<_, ()>(p.iter().map(of).collect::<Vec<Option<Vec<f64>>>>());
        let found = minimise(&bounds, &mut model, &mut |_, _, _| ()).unwrap().unwrap();
        let c = found.covariance.unwrap();
        // n sum x^2 - (sum x)^2 = 4 14 - 36 = 20.
        let exact = [[14.0 / 20.0, -6.0 / 20.0], [-6.0 / 20.0, 4.0 / 20.0]];
        for i in 0..2 {
            for j in 0..2 {
                assert!((c[i][j] - exact[i][j]).abs() < 1e-9, "{c:?}");
            }
        }
    }

    /// A parameter that changes nothing has no error.
    #[test]
    fn what_the_data_do_not_tell_is_said() {
        let of = |p: &Vec<f64>| Some(vec![p[0] - 1.0, 2.0 * p[0] - 2.0]);
        let bounds = [Bounds { start: 0.5, least: 0.0, most: 9.0 }; 2];
        let mut model =
            |p: &[Vec<f64>]| Ok::<_, ()>(p.iter().map(of).collect::<Vec<Option<Vec<f64>>>>());
        let found = minimise(&bounds, &mut model, &mut |_, _, _| ()).unwrap().unwrap();
        let c = found.covariance.clone().unwrap();
        assert!((found.at[0] - 1.0).abs() < 1e-6 && found.at[1] == 0.5, "{found:?}");
        assert!((c[0][0] - 0.2).abs() < 1e-6 && c[1][1].is_infinite(), "{found:?}");
    }
}
