//! The laminar tutorials of one fluid through both programs, compared cell by cell; see `compare`.

use crate::compare::{Start, Tutorial};
use crate::{bench, foam_field as field};
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

/// Runs and compares what is asked for; says whether all of it could be.
pub(crate) fn compare(
    examples: &Path,
    granflow: &Path,
    again: bool,
    asked: impl Fn(&&Tutorial) -> bool,
) -> bool {
    println!(
        "| tutorial | t, s | U: greatest and mean difference, of the peak | p: mean difference, of the range |"
    );
    println!("|---|---|---|---|");
    let mut complete = true;
    for t in TUTORIALS.iter().filter(|t| asked(t)) {
        let from = examples.join("incompressible").join(t.path);
        let ran = if again { Ok(()) } else { t.run(&from, granflow) };
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
    let [ours, theirs] =
        ["ours", "theirs"].map(|who| bench::scratch_place(&format!("{}-{who}", t.name())));
    let volume = field::scalars(&theirs.join("0/V"), 0)?;
    for k in 1..=(t.end / t.interval).round() as usize {
        let time = k as f64 * t.interval;
        let [a, b] = [time_dir(&ours, time)?, time_dir(&theirs, time)?];
        let [u, v] = [&a, &b].map(|dir| field::vectors(&dir.join("U"), volume.len()));
        let [p, q] = [&a, &b].map(|dir| field::scalars(&dir.join("p"), volume.len()));
        println!(
            "| {}{} | {time:.4} | {} |",
            t.path,
            t.label,
            row(&volume, (&u?, &v?), (&p?, &q?))
        );
    }
    Ok(())
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
    let size = |a: [f64; 3]| a.iter().map(|x| x * x).sum::<f64>().sqrt();
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
    }
}
