//! Two small good cases, and the program run on copies of them.

#![allow(dead_code, clippy::unwrap_used, reason = "each test file uses its part, and may fail")]

mod flume;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A case in a directory of its own.
pub(crate) struct Case {
    dir: TempDir,
    /// What was done to it, for the snapshots.
    pub(crate) edits: String,
}

/// Lid-driven cavity of 4 x 4 cells, PISO.
pub(crate) fn cavity() -> Case {
    Case::new(CAVITY)
}

/// Wedge of an annular cell of 8 cells, nonlocal granular fluidity.
pub(crate) fn ring() -> Case {
    Case::new(RING)
}

/// A flume, 4 m long and 0.4 m deep, with small waves from the left for three periods of 1.5 s.
pub(crate) fn flume() -> Case {
    Case::new(flume::FLUME)
}

/// The breaking dam of the catalogue on 16 x 8 cells, for 20 ms.
pub(crate) fn dam() -> Case {
    let mut case = of_two_phases("dam_break", "alpha.water")
        .edit("system/blockMeshDict", "(80 40 1)", "(16 8 1)")
        .edit("system/controlDict", "endTime         0.3;", "endTime         0.02;")
        .edit("system/controlDict", "writeInterval   0.05;", "writeInterval   0.01;");
    case.edits.clear();
    case
}

/// The column of grains that collapses in air, `cases/column_collapse`, coarse and short.
pub(crate) fn collapse() -> Case {
    let mut case = of_two_phases("column_collapse", "alpha.grains")
        .edit("system/blockMeshDict", "(60 20 1) simple", "(15 5 1) simple")
        .edit("system/controlDict", "endTime         0.7;", "endTime         0.01;")
        .edit("system/controlDict", "writeInterval   0.1;", "writeInterval   0.005;");
    case.edits.clear();
    case
}

/// A case of the catalogue, whole.
pub(crate) fn of_catalogue(name: &str) -> Case {
    whole(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases").join(name))
}

/// All of a case's files but what runs have made.
fn whole(root: &Path) -> Case {
    fn add(case: &Case, root: &Path, rel: &Path) {
        for entry in fs::read_dir(root.join(rel)).unwrap() {
            let rel = rel.join(entry.unwrap().file_name());
            let path = root.join(&rel);
            let made = ["postProcessing", "polyMesh", "sweep", "fit", "log.jsonl"];
            let name = rel.file_name().unwrap().to_string_lossy();
            if made.contains(&&*name) || name.parse::<f64>().is_ok() {
                continue;
            }
            if path.is_dir() {
                add(case, root, &rel);
            } else {
                case.put(&rel.to_string_lossy(), &fs::read(path).unwrap());
            }
        }
    }
    let case = Case { dir: tempfile::tempdir().unwrap(), edits: String::new() };
    add(&case, root, Path::new(""));
    case
}

fn of_two_phases(name: &str, alpha: &str) -> Case {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases").join(name);
    let alpha = format!("0.orig/{alpha}");
    let files = [
        "0.orig/U",
        "0.orig/p_rgh",
        &alpha,
        "constant/g",
        "constant/transportProperties",
        "system/blockMeshDict",
        "system/controlDict",
        "system/fvSchemes",
        "system/fvSolution",
        "system/setFieldsDict",
    ];
    let texts: Vec<String> =
        files.iter().map(|f| fs::read_to_string(folder.join(f)).unwrap()).collect();
    let pairs: Vec<(&str, &str)> =
        files.iter().copied().zip(texts.iter().map(String::as_str)).collect();
    Case::new(&pairs)
}

impl Case {
    /// A case that lies in a folder beside the tests.
    pub(crate) fn below(folder: &str, name: &str) -> Case {
        whole(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(folder).join(name))
    }
    fn new(files: &[(&str, &str)]) -> Case {
        let case = Case { dir: tempfile::tempdir().unwrap(), edits: String::new() };
        for (path, text) in files {
            case.put(path, text.trim_start().as_bytes());
        }
        case
    }
    pub(crate) fn path(&self) -> &Path {
        self.dir.path()
    }
    pub(crate) fn read(&self, file: &str) -> String {
        fs::read_to_string(self.path().join(file)).unwrap()
    }
    pub(crate) fn put(&self, file: &str, bytes: &[u8]) {
        let path = self.path().join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    /// Replaces the only `from` of a file.
    #[must_use]
    pub(crate) fn edit(mut self, file: &str, from: &str, to: &str) -> Case {
        let text = self.read(file);
        assert_eq!(text.matches(from).count(), 1, "`{from}` in {file}:\n{text}");
        self.put(file, text.replace(from, to).as_bytes());
        self.edits += &format!("{file}: `{from}` -> `{to}`\n");
        self
    }
    #[must_use]
    pub(crate) fn write(mut self, file: &str, text: &str) -> Case {
        self.put(file, text.as_bytes());
        self.edits += &format!("{file} is `{text}`\n");
        self
    }
    #[must_use]
    pub(crate) fn remove(mut self, file: &str) -> Case {
        fs::remove_file(self.path().join(file)).unwrap();
        self.edits += &format!("{file} is missing\n");
        self
    }
    #[must_use]
    pub(crate) fn rename(mut self, from: &str, to: &str) -> Case {
        fs::rename(self.path().join(from), self.path().join(to)).unwrap();
        self.edits += &format!("{from} is called {to}\n");
        self
    }
    /// Makes `constant/polyMesh`.
    #[must_use]
    pub(crate) fn meshed(self) -> Case {
        let out = self.run(&["mesh", "-q"]);
        assert!(out.status.success(), "{out:?}");
        self
    }
    /// Runs the program in the case.
    pub(crate) fn run(&self, args: &[&str]) -> Output {
        granflow(args).current_dir(self.path()).output().unwrap()
    }
    /// Every file and what it holds.
    pub(crate) fn tree(&self) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        let mut all = BTreeMap::new();
        tree(self.path(), &mut all);
        all
    }
}

fn tree(dir: &Path, all: &mut BTreeMap<PathBuf, Option<Vec<u8>>>) {
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.insert(path.clone(), None);
            tree(&path, all);
        } else {
            all.insert(path.clone(), Some(fs::read(&path).unwrap()));
        }
    }
}

/// The program, about to be run without a terminal.
pub(crate) fn granflow(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_granflow"));
    command.args(args).env_remove("NO_COLOR").env("COLUMNS", "100");
    command
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const CAVITY: &[(&str, &str)] = &[
    (
        "system/blockMeshDict",
        "
FoamFile { version 2.0; format ascii; class dictionary; object blockMeshDict; }
scale 0.1;
vertices
(
    (0 0 0) (1 0 0) (1 1 0) (0 1 0)
    (0 0 0.1) (1 0 0.1) (1 1 0.1) (0 1 0.1)
);
blocks
(
    hex (0 1 2 3 4 5 6 7) (4 4 1) simpleGrading (1 1 1)
);
edges ();
boundary
(
    lid
    {
        type wall;
        faces ((3 7 6 2));
    }
    walls
    {
        type wall;
        faces ((0 4 7 3) (2 6 5 1) (1 5 4 0));
    }
    sides
    {
        type empty;
        faces ((0 3 2 1) (4 5 6 7));
    }
);
",
    ),
    (
        "system/controlDict",
        "
FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }
application     icoFoam;
startFrom       startTime;
startTime       0;
stopAt          endTime;
endTime         0.1;
deltaT          0.005;
writeControl    timeStep;
writeInterval   10;
writeFormat     ascii;
timeFormat      general;
timePrecision   6;
",
    ),
    (
        "system/fvSchemes",
        "
FoamFile { version 2.0; format ascii; class dictionary; object fvSchemes; }
ddtSchemes { default Euler; }
gradSchemes { default Gauss linear; }
divSchemes
{
    default         none;
    div(phi,U)      Gauss linear;
}
laplacianSchemes { default Gauss linear corrected; }
interpolationSchemes { default linear; }
snGradSchemes { default corrected; }
",
    ),
    (
        "system/fvSolution",
        "
FoamFile { version 2.0; format ascii; class dictionary; object fvSolution; }
solvers
{
    p
    {
        solver          PCG;
        preconditioner  DIC;
        tolerance       1e-08;
        relTol          0.01;
    }
    pFinal
    {
        $p;
        relTol          0;
    }
    U
    {
        solver          smoothSolver;
        smoother        symGaussSeidel;
        tolerance       1e-08;
        relTol          0;
    }
}
PISO
{
    nCorrectors     2;
    nNonOrthogonalCorrectors 0;
    pRefCell        0;
    pRefValue       0;
}
",
    ),
    (
        "constant/transportProperties",
        "
FoamFile { version 2.0; format ascii; class dictionary; object transportProperties; }
transportModel  Newtonian;
nu              0.01;
",
    ),
    (
        "0/U",
        "
FoamFile { version 2.0; format ascii; class volVectorField; object U; }
dimensions      [0 1 -1 0 0 0 0];
internalField   uniform (0 0 0);
boundaryField
{
    lid
    {
        type        fixedValue;
        value       uniform (1 0 0);
    }
    walls
    {
        type        noSlip;
    }
    sides
    {
        type        empty;
    }
}
",
    ),
    (
        "0/p",
        "
FoamFile { version 2.0; format ascii; class volScalarField; object p; }
dimensions      [0 2 -2 0 0 0 0];
internalField   uniform 0;
boundaryField
{
    lid
    {
        type        zeroGradient;
    }
    walls
    {
        type        zeroGradient;
    }
    sides
    {
        type        empty;
    }
}
",
    ),
];

const RING: &[(&str, &str)] = &[
    (
        "system/blockMeshDict",
        "
FoamFile { version 2.0; format ascii; class dictionary; object blockMeshDict; }
scale 0.001;
vertices
(
    (51 -0.445070257328698 0)  (63 -0.549792670817804 0)  (63 0.549792670817804 0)  (51 0.445070257328698 0)
    (51 -0.445070257328698 10) (63 -0.549792670817804 10) (63 0.549792670817804 10) (51 0.445070257328698 10)
);
blocks (hex (0 1 2 3 4 5 6 7) (8 1 1) simpleGrading (1 1 1));
boundary
(
    inner  { type wall;  faces ((0 4 7 3)); }
    outer  { type wall;  faces ((1 2 6 5)); }
    bottom { type patch; faces ((0 3 2 1)); }
    top    { type patch; faces ((4 5 6 7)); }
    minus  { type wedge; faces ((0 1 5 4)); }
    plus   { type wedge; faces ((3 7 6 2)); }
);
",
    ),
    (
        "system/controlDict",
        "
FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }
application     granflow;
startFrom       latestTime;
endTime         0.3;
deltaT          0.1;
writeControl    runTime;
writeInterval   0.1;
functions
{
    profile
    {
        type    sets;
        fields  (U fluidity);
        sets ( radius { type midPoint; axis x; start (0.051 0 0.005); end (0.063 0 0.005); } );
    }
    torque
    {
        type    forces;
        patches (inner);
        CofR    (0 0 0);
    }
}
",
    ),
    (
        "system/fvSchemes",
        "
FoamFile { version 2.0; format ascii; class dictionary; object fvSchemes; }
ddtSchemes { default Euler; }
gradSchemes { default Gauss linear; }
divSchemes { default none; div(phi,U) Gauss linearUpwind grad(U); }
laplacianSchemes { default Gauss linear corrected; }
",
    ),
    (
        "system/fvSolution",
        "
FoamFile { version 2.0; format ascii; class dictionary; object fvSolution; }
PIMPLE
{
    pRefCell    0;
    pRefValue   75;
}
",
    ),
    (
        "constant/transportProperties",
        "
FoamFile { version 2.0; format ascii; class dictionary; object transportProperties; }
transportModel NGF;
rho            1519;
NGFCoeffs
{
    mus  0.3819;
    mu2  0.6435;
    I0   0.279;
    A    0.48;
    d    0.75e-3;
    rhos 2450;
    form steady;
}
",
    ),
    (
        "0.orig/U",
        "
FoamFile { version 2.0; format ascii; class volVectorField; object U; }
dimensions      [0 1 -1 0 0 0 0];
internalField   uniform (0 0 0);
boundaryField
{
    inner
    {
        type    rotatingWallVelocity;
        origin  (0 0 0);
        axis    (0 0 1);
        omega   0.2;
    }
    outer   { type noSlip; }
    bottom  { type slip; }
    top     { type slip; }
    minus   { type wedge; }
    plus    { type wedge; }
}
",
    ),
    (
        "0.orig/p",
        "
FoamFile { version 2.0; format ascii; class volScalarField; object p; }
dimensions      [1 -1 -2 0 0 0 0];
internalField   uniform 75;
boundaryField
{
    \"(inner|outer|bottom|top)\" { type zeroGradient; }
    \"(minus|plus)\" { type wedge; }
}
",
    ),
];
