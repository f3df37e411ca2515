//! The laminar tutorials of one fluid through both programs, compared cell by cell; see `compare`. Ours runs
//! twice, as the case is and, by `compatible no;`, with its own forms; and where single cells then differ, once
//! more on a finer mesh, which says whose answer is nearer.

use crate::compare::{Start, Tutorial, logged};
use crate::{bench, finer, foam_field as field};
use std::fs;
use std::path::{Path, PathBuf};

const BLOCKS: &[&str] = &["blockMesh"];

const fn plain(path: &'static str, end: f64, interval: f64) -> Tutorial {
    Tutorial {
        path,
        prepare: BLOCKS,
        start: Start::Own,
        changes: &[],
        end,
        interval,
        axis: 0,
        label: "",
    }
}

/// The cavity's mesh and step as its script makes them for `cavityFine`.
const FINE: &[(&str, &str, &str)] = &[
    ("system/blockMeshDict", "hex", "hex (0 1 2 3 4 5 6 7) (41 41 1) simpleGrading (1 1 1)"),
    ("system/controlDict", "deltaT", "0.0025"),
];
/// And the viscosity for `cavityHighRe`.
const HIGH_RE: &[(&str, &str, &str)] = &[("constant/transportProperties", "nu", "0.001")];
const BLOCK_FINE: &[(&str, &str, &str)] = &[
    ("system/blockMeshDict", "hex", "hex (0 1 2 3 4 5 6 7) (256 128 1) simpleGrading (1 1 1)"),
    ("system/controlDict", "deltaT", "0.0125"),
];

pub(crate) const TUTORIALS: &[Tutorial] = &[
    plain("icoFoam/cavity/cavity", 0.5, 0.1),
    Tutorial { changes: FINE, label: " 41 x 41", ..plain("icoFoam/cavity/cavity", 0.5, 0.1) },
    Tutorial { changes: HIGH_RE, label: " nu = 0.001", ..plain("icoFoam/cavity/cavity", 2.0, 0.5) },
    plain("icoFoam/cavity/cavityGrade", 0.7, 0.1),
    plain("icoFoam/cavity/cavityClipped", 0.6, 0.1),
    Tutorial {
        prepare: &["gunzip -kf elbow.msh.gz", "fluentMeshToFoam elbow.msh"],
        start: Start::Mesh,
        ..plain("icoFoam/elbow", 10.0, 2.0)
    },
    Tutorial {
        prepare: &["blockMesh", "topoSet"],
        ..plain("pisoFoam/laminar/porousBlockage", 10.0, 2.0)
    },
    Tutorial {
        prepare: &["blockMesh", "topoSet"],
        changes: BLOCK_FINE,
        label: " 256 x 128",
        ..plain("pisoFoam/laminar/porousBlockage", 10.0, 2.0)
    },
    plain("pimpleFoam/laminar/planarPoiseuille", 2.0, 0.5),
    plain("nonNewtonianIcoFoam/offsetCylinder", 2.0, 0.5),
];

/// How many times finer, in both directions of the plane and in time, the mesh is that ours is run on besides:
/// by path and label.
const FINER: &[(&str, &str, usize)] = &[
    ("icoFoam/cavity/cavity", " nu = 0.001", 4),
    ("icoFoam/elbow", "", 4),
    ("pisoFoam/laminar/porousBlockage", "", 4),
    ("nonNewtonianIcoFoam/offsetCylinder", "", 2),
];

fn times_finer(t: &Tutorial) -> Option<usize> {
    FINER.iter().find(|f| (f.0, f.1) == (t.path, t.label)).map(|f| f.2)
}

/// Where the case of `who` is.
fn place(t: &Tutorial, who: &str) -> PathBuf {
    bench::scratch_place(&format!("{}-{who}", t.name()))
}

/// Takes the peer's forms (`yes`) or our own (`no`).
fn take_forms(case: &Path, compatible: &str) -> Result<(), String> {
    let schemes = case.join("system/fvSchemes");
    let text = fs::read_to_string(&schemes).map_err(|e| format!("fvSchemes: {e}"))?;
    let text = format!("{text}\ncompatible {compatible};\n");
    fs::write(&schemes, text).map_err(|e| format!("fvSchemes: {e}"))
}

/// Ours once more, as the case of `who`, with `compatible` set to yes or no.
pub(crate) fn run_with(
    t: &Tutorial,
    (who, compatible): (&str, &str),
    from: &Path,
    granflow: &Path,
) -> Result<(), String> {
    let case = bench::copy_case(from, &format!("{}-{who}", t.name()))?;
    t.make_ready(&case)?;
    t.hand_over(&place(t, "theirs"), &case)?;
    take_forms(&case, compatible)?;
    logged(&["granflow", "run", ".", "-j", "1"], Some(granflow), &case, "log.run").map(|_| ())
}

/// Ours once more on cells and with steps a `k`-th as long, all by its own means; which coarse cell each of the
/// cells lies in is left in `parents`.
fn run_finer(t: &Tutorial, k: usize, from: &Path, granflow: &Path) -> Result<(), String> {
    let case = bench::copy_case(from, &format!("{}-finer", t.name()))?;
    t.make_ready(&case)?;
    take_forms(&case, "no")?;
    finer::shorten_steps(&case, k)?;
    let parents = if t.start == Start::Mesh {
        t.hand_over(&place(t, "theirs"), &case)?;
        finer::divide_triangles(&case.join("constant/polyMesh"), k.ilog2())?
    } else {
        let dict = case.join("system/blockMeshDict");
        if !dict.is_file() {
            logged(&["gunzip", "system/blockMeshDict.gz"], None, &case, "log.gunzip")?;
        }
        finer::divide_blocks(&dict, k)?
    };
    let lines: Vec<String> = parents.iter().map(usize::to_string).collect();
    fs::write(case.join("parents"), lines.join("\n")).map_err(|e| format!("parents: {e}"))?;
    logged(&["granflow", "run", ".", "-j", "1"], Some(granflow), &case, "log.run").map(|_| ())
}

/// Everything that `rows` reads.
fn run(t: &Tutorial, from: &Path, granflow: &Path) -> Result<(), String> {
    t.run(from, granflow)?;
    run_with(t, ("own", "no"), from, granflow)?;
    times_finer(t).map_or(Ok(()), |k| run_finer(t, k, from, granflow))
}

/// The answer of the finer mesh on the coarse one.
fn averaged(t: &Tutorial, time: f64, n: usize) -> Result<Option<Vec<[f64; 3]>>, String> {
    if times_finer(t).is_none() {
        return Ok(None);
    }
    let case = place(t, "finer");
    let text = fs::read_to_string(case.join("parents")).map_err(|e| format!("parents: {e}"))?;
    let parents: Vec<usize> = text.lines().filter_map(|l| l.parse().ok()).collect();
    let fine = field::vectors(&time_dir(&case, time)?.join("U"), parents.len())?;
    if fine.len() != parents.len() {
        return Err(format!("{} cells on the finer mesh, not {}", fine.len(), parents.len()));
    }
    Ok(Some(finer::means(&parents, &fine, n)))
}

/// Runs and compares what is asked for; says whether all of it could be.
pub(crate) fn compare(
    examples: &Path,
    granflow: &Path,
    again: bool,
    asked: impl Fn(&&Tutorial) -> bool,
) -> bool {
    println!(
        "| tutorial | t, s | U: greatest and mean difference, of the peak | p: mean difference, of the range | \
         U, own forms | p, own forms | U from the finer mesh's, root mean square: ours, theirs |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut complete = true;
    for t in TUTORIALS.iter().filter(|t| asked(t)) {
        let from = examples.join("incompressible").join(t.path);
        let ran = if again { Ok(()) } else { run(t, &from, granflow) };
        if let Err(why) = ran.and_then(|()| rows(t)) {
            println!("| {}{} | not compared: {why} |", t.path, t.label);
            complete = false;
        }
    }
    println!();
    complete
}

/// A row for each time that both programs wrote.
fn rows(t: &Tutorial) -> Result<(), String> {
    let volume = field::scalars(&place(t, "theirs").join("0/V"), 0)?;
    for k in 1..=(t.end / t.interval).round() as usize {
        let time = k as f64 * t.interval;
        let of = |who: &str| -> Result<_, String> {
            let dir = time_dir(&place(t, who), time)?;
            let u = field::vectors(&dir.join("U"), volume.len())?;
            Ok((u, field::scalars(&dir.join("p"), volume.len())?))
        };
        let (ours, own, theirs) = (of("ours")?, of("own")?, of("theirs")?);
        let [plain, with_own] =
            [&ours, &own].map(|a| row(&volume, (&a.0, &theirs.0), (&a.1, &theirs.1)));
        let off = match averaged(t, time, volume.len())? {
            Some(fine) => {
                let [a, b] = [&own, &theirs].map(|who| distance(&volume, &who.0, &fine));
                format!("{:.2} %, {:.2} %", 100.0 * a, 100.0 * b)
            }
            None => "-".into(),
        };
        println!("| {}{} | {time:.4} | {plain} | {with_own} | {off} |", t.path, t.label);
    }
    Ok(())
}

fn size(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Root mean square of `u - v` over the volume, of the peak of `v`.
fn distance(volume: &[f64], u: &[[f64; 3]], v: &[[f64; 3]]) -> f64 {
    let off = |c: usize| size([0, 1, 2].map(|k| u[c][k] - v[c][k]));
    let square: f64 = volume.iter().enumerate().map(|(c, w)| w * off(c).powi(2)).sum();
    let peak = v.iter().map(|v| size(*v)).fold(0.0, f64::max);
    (square / volume.iter().sum::<f64>()).sqrt() / peak
}

fn time_dir(case: &Path, time: f64) -> Result<PathBuf, String> {
    let near = |name: &str| name.parse::<f64>().is_ok_and(|t| (t - time).abs() < 1e-7);
    let mut dirs = fs::read_dir(case).map_err(|e| e.to_string())?.flatten();
    let dir = dirs.find(|d| near(&d.file_name().to_string_lossy()));
    Ok(dir.ok_or(format!("{} has no time {time}", case.display()))?.path())
}

/// Velocities and pressures, ours first. Pressures are compared without their level.
fn row(volume: &[f64], (u, v): (&[[f64; 3]], &[[f64; 3]]), (p, q): (&[f64], &[f64])) -> String {
    let whole: f64 = volume.iter().sum();
    let mean = |f: &dyn Fn(usize) -> f64| -> f64 {
        volume.iter().enumerate().map(|(c, w)| w * f(c)).sum::<f64>() / whole
    };
    let off = |c: usize| size([0, 1, 2].map(|k| u[c][k] - v[c][k]));
    let peak = v.iter().map(|v| size(*v)).fold(0.0, f64::max);
    let most = (0..u.len()).map(off).fold(0.0, f64::max);
    let level = mean(&|c| p[c] - q[c]);
    let range =
        q.iter().copied().fold(f64::MIN, f64::max) - q.iter().copied().fold(f64::MAX, f64::min);
    // A pressure that is nothing but rounding has no range.
    let pressure = match range > 1e-9 * peak * peak {
        true => format!("{:.2} %", 100.0 * mean(&|c| (p[c] - q[c] - level).abs()) / range),
        false => "-".into(),
    };
    format!("{:.2} %, {:.3} % | {pressure}", 100.0 * most / peak, 100.0 * mean(&off) / peak)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_of_the_peak_and_levels_do_not_count() {
        let u = [[1.0, 0.0, 0.0], [0.0, 2.2, 0.0]];
        let v = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let row = row(&[1.0, 3.0], (&u, &v), (&[5.0, 7.0], &[1.0, 3.0]));
        assert_eq!(row, "10.00 %, 7.500 % | 0.00 %");
        assert!((distance(&[1.0, 3.0], &u, &v) - 0.2 * 0.75_f64.sqrt() / 2.0).abs() < 1e-12);
    }
}
