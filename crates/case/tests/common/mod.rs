//! Small cases in temporary directories.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

use granflow_case::{CaseError, End, Event, Notices, Options, Run, meshing, store};
use granflow_dict::{Format, Sink};
use granflow_mesh::{PatchKind, PolyMesh, shapes};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

pub fn case(files: &[(&str, &str)], poly: Option<&PolyMesh>) -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    for (name, text) in files {
        put(dir.path(), name, text);
    }
    if let Some(poly) = poly {
        meshing::write(dir.path(), poly, Format::Ascii, store::Compression::Plain).unwrap();
    }
    dir
}

pub fn put(root: &Path, name: &str, text: &str) {
    let path = root.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

/// A copy of a case, time directories of results left out.
pub fn copy(from: &Path) -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    for part in ["0", "constant/polyMesh", "constant", "system"] {
        let Ok(entries) = fs::read_dir(from.join(part)) else { continue };
        for e in entries.flatten().filter(|e| e.path().is_file()) {
            let to = dir.path().join(part).join(e.file_name());
            fs::create_dir_all(to.parent().unwrap()).unwrap();
            fs::copy(e.path(), to).unwrap();
        }
    }
    dir
}

/// Runs to the end; mistakes of the case are printed.
pub fn run(root: &Path, options: &Options) -> Run {
    let (sink, notices) = (Sink::new(), Notices::new());
    match try_run(root, options, &sink, &notices) {
        Ok(run) => run,
        Err(e) => panic!("{e}\n{}", sink.take()),
    }
}

pub fn try_run(
    root: &Path,
    options: &Options,
    sink: &Sink,
    notices: &Notices,
) -> Result<Run, CaseError> {
    let mut run = Run::load(root, options, sink, notices)?;
    loop {
        if let Event::Done(end) = run.advance()? {
            assert_eq!(end, End::EndTime);
            return Ok(run);
        }
    }
}

pub fn load_errors(root: &Path) -> String {
    let (sink, notices) = (Sink::new(), Notices::new());
    let loaded = granflow_case::Case::load(root, &Options::default(), &sink, &notices);
    assert!(loaded.is_err(), "the case should be refused");
    sink.take().to_string()
}

pub fn read(root: &Path, file: &str) -> String {
    fs::read_to_string(root.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
}

pub const CONTROL: &str = "application icoFoam; startFrom latestTime; endTime 0.1; deltaT 0.01;
writeControl timeStep; writeInterval 5;\n";

pub const CAVITY_U: &str = "FoamFile { version 2.0; format ascii; class volVectorField; object U; }
dimensions [0 1 -1 0 0 0 0];
internalField uniform (0 0 0);
boundaryField
{
    yMax { type fixedValue; value uniform (1 0 0); }
    \"(x.*|yMin)\" { type noSlip; }
    \"z.*\" { type empty; }
}
";
pub const CAVITY_P: &str = "FoamFile { version 2.0; format ascii; class volScalarField; object p; }
dimensions [0 2 -2 0 0 0 0];
internalField uniform 0;
boundaryField
{
    \".*\" { type zeroGradient; }
    \"z.*\" { type empty; }
}
";

/// A lid-driven cavity of unit size; xMin xMax yMin yMax zMin zMax.
pub fn cavity(n: usize) -> PolyMesh {
    use PatchKind::{Empty, Wall};
    let kinds = [Wall, Wall, Wall, Wall, Empty, Empty];
    shapes::box_mesh([n, n, 1], [0.0; 3], [1.0, 1.0, 0.1], kinds)
}

pub fn cavity_case(n: usize) -> TempDir {
    case(
        &[
            ("system/controlDict", CONTROL),
            ("constant/transportProperties", "nu [0 2 -1 0 0 0 0] 0.01;\n"),
            ("0/U", CAVITY_U),
            ("0/p", CAVITY_P),
        ],
        Some(&cavity(n)),
    )
}

pub fn until(t: f64) -> Options {
    Options { until: Some(t), ..Options::default() }
}

pub fn files_of(root: &Path, time: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let mut out = Vec::new();
    for e in fs::read_dir(root.join(time)).unwrap().flatten() {
        if e.path().is_file() {
            let name = e.path().strip_prefix(root).unwrap().to_owned();
            out.push((name, fs::read(e.path()).unwrap()));
        }
    }
    out.sort();
    out
}

/// All numbers of a file.
pub fn numbers(root: &Path, file: &str) -> Vec<f64> {
    let text = read(root, file).replace(['(', ')', ';'], " ");
    text.split_whitespace().filter_map(|w| w.parse().ok()).collect()
}

/// How far the numbers of two runs' files are apart, of the greatest.
pub fn apart(a: &Path, b: &Path, file: &str) -> f64 {
    let (a, b) = (numbers(a, file), numbers(b, file));
    assert_eq!(a.len(), b.len(), "{file}");
    let size = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    a.iter().zip(&b).fold(0.0f64, |m, (x, y)| m.max((x - y).abs())) / size
}

pub fn assert_same(a: &Path, b: &Path, time: &str) {
    let (left, right) = (files_of(a, time), files_of(b, time));
    let names = |v: &[(PathBuf, Vec<u8>)]| v.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&left), names(&right));
    assert!(left.len() > 4, "{:?}", names(&left));
    for ((name, x), (_, y)) in left.iter().zip(&right) {
        assert!(x == y, "{} differs", name.display());
    }
    assert_eq!(read(a, &format!("{time}/uniform/time")), read(b, &format!("{time}/uniform/time")));
}

/// Height of the gap of [`couette`], m.
pub const H: f64 = 0.2;

/// Plane Couette flow, periodic along x: U = y/h (1 0 0), traction eta/h.
pub fn couette(functions: &str) -> tempfile::TempDir {
    use PatchKind::{Empty, Wall};
    let [x0, x1, ..] = shapes::periodic_kinds([true, false, false], Wall);
    let poly =
        shapes::box_mesh([3, 8, 1], [0.0; 3], [0.3, H, 0.1], [x0, x1, Wall, Wall, Empty, Empty]);
    case(
        &[
            (
                "system/controlDict",
                &format!("endTime 3000; deltaT 1000; functions {{ {functions} }}"),
            ),
            ("constant/transportProperties", "transportModel Newtonian; nu 0.02; rho 50;"),
            (
                "0/U",
                "dimensions [0 1 -1 0 0 0 0]; internalField uniform (0 0 0); boundaryField {
                 yMax { type fixedValue; value uniform (1 0 0); } yMin { type noSlip; }
                 \"x.*\" { type cyclic; } \"z.*\" { type empty; } }",
            ),
            (
                "0/p",
                "dimensions [1 -1 -2 0 0 0 0]; internalField uniform 0; boundaryField {
                 \"y.*\" { type zeroGradient; } \"x.*\" { type cyclic; } \"z.*\" { type empty; } }",
            ),
        ],
        Some(&poly),
    )
}
