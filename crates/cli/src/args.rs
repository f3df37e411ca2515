//! What a user may type.

use clap::{Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Granular and generalised Newtonian flow on OpenFOAM cases.
#[derive(Debug, Parser)]
#[command(name = "granflow", version, about, max_term_width = 100, disable_help_subcommand = true)]
#[command(
    after_help = "Exit codes: 0 done, 2 bad input (nothing changed), 3 the computation failed \
    (state kept), 4 the machine failed (disk full, no permission), 130/143 stopped by a signal \
    after writing."
)]
pub struct Args {
    /// Print nothing but errors
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a case: mesh and initialise what is missing, solve, write, draw the figures
    #[command(allow_negative_numbers = true)]
    Run(Run),
    /// Make constant/polyMesh from system/blockMeshDict, or from another program's file
    Mesh(Mesh),
    /// Make 0 from 0.orig
    Init(Place),
    /// Read and check everything, estimate what a run needs; change nothing
    Check(Check),
    /// Write a built-in case (granflow list cases)
    New(New),
    /// List what can be written in a case
    List(List),
    /// Draw the figures of system/plotDict
    Plot(Place),
    /// Write the times as VTK files: VTK/TIME.vtu and VTK/case.pvd
    Export(Place),
    /// Run a case at many values of a parameter (system/sweepDict): table and figures
    Sweep(Study),
    /// Find parameters of a case from measured profiles (system/fitDict)
    Fit(Study),
    /// Run built-in cases and compare them with their references
    Validate(Validate),
}

/// `granflow run`.
#[derive(Debug, clap::Args)]
pub struct Run {
    /// Directory of the case
    #[arg(default_value = ".")]
    pub case: PathBuf,
    /// Threads; the results are the same bits for any number [default: all cores]
    #[arg(short = 'j', long = "threads", value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Least number of entries of a loop that threads share (tests make small meshes use them)
    #[arg(long, value_name = "N", hide = true)]
    pub share: Option<usize>,
    /// Time directory to start from [default: what controlDict says]
    #[arg(long, value_name = "start|latest|TIME", value_parser = start)]
    pub from: Option<Start>,
    /// Time to run until, s [default: endTime of controlDict]
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    pub until: Option<f64>,
}

/// `granflow mesh`.
#[derive(Debug, clap::Args)]
pub struct Mesh {
    /// Directory of the case
    #[arg(default_value = ".")]
    pub case: PathBuf,
    /// Read a mesh of Gmsh (.msh 2, 4.0, 4.1), Fluent (.msh, text) or VTK (.vtu) instead
    #[arg(long, value_name = "FILE")]
    pub from: Option<PathBuf>,
    /// Factor on the coordinates of FILE, such as 0.001 for millimetres
    #[arg(long, value_name = "X", requires = "from", default_value = "1", value_parser = positive)]
    pub scale: f64,
    /// Thickness of the cells made from a plane mesh, m [default: a tenth of its extent]
    #[arg(long, value_name = "X", requires = "from", value_parser = positive)]
    pub thickness: Option<f64>,
    /// Split faces that FILE gives no patch where the surface turns by more, degrees
    #[arg(long, value_name = "DEGREES", requires = "from", value_parser = positive)]
    pub feature_angle: Option<f64>,
    /// Array on the cells of a .vtu FILE that tells patches and zones apart
    #[arg(long, value_name = "NAME", requires = "from")]
    pub groups: Option<String>,
}

/// `granflow check`.
#[derive(Debug, clap::Args)]
pub struct Check {
    /// Directory of the case
    #[arg(default_value = ".")]
    pub case: PathBuf,
    /// Check the mesh alone
    #[arg(long)]
    pub mesh: bool,
}

/// A command that needs nothing but a case.
#[derive(Debug, clap::Args)]
pub struct Place {
    /// Directory of the case
    #[arg(default_value = ".")]
    pub case: PathBuf,
}

/// `granflow sweep` and `granflow fit`.
#[derive(Debug, clap::Args)]
pub struct Study {
    /// Directory of the case
    #[arg(default_value = ".")]
    pub case: PathBuf,
    /// Threads, or points at a time where they are independent [default: all cores]
    #[arg(short = 'j', long = "threads", value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Another dictionary of the case than system/sweepDict or system/fitDict
    #[arg(short, long, value_name = "FILE")]
    pub dict: Option<String>,
}

impl Study {
    /// As many as asked for, or as there are cores.
    pub(crate) fn threads(&self) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.map_or_else(cores, usize::from)
    }
}

/// `granflow new`.
#[derive(Debug, clap::Args)]
pub struct New {
    /// Name of the case (granflow list cases)
    pub name: String,
    /// Directory to write; must not exist [default: NAME]
    pub dir: Option<PathBuf>,
}

/// `granflow validate`.
#[derive(Debug, clap::Args)]
pub struct Validate {
    /// Names of cases (granflow list cases) [default: all that have a reference and do not take minutes]
    pub names: Vec<String>,
    /// Directory of the report
    #[arg(short, long, value_name = "DIR", default_value = "validation")]
    pub out: PathBuf,
}

/// `granflow list`.
#[derive(Debug, clap::Args)]
pub struct List {
    /// What to list [default: everything]
    pub what: Option<Listing>,
    /// For programs: an array of objects
    #[arg(long)]
    pub json: bool,
}

/// What can be listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Listing {
    /// transportModel in constant/transportProperties
    Rheologies,
    /// type of a patch in a field file
    Conditions,
    /// waveModel of a patch in constant/waveProperties
    Waves,
    /// words of system/fvSchemes
    Schemes,
    /// solver, preconditioner, smoother in system/fvSolution
    Solvers,
    /// type of a function in system/controlDict
    Functions,
    /// type of a force in constant/fvOptions
    Sources,
    /// built-in cases, for granflow new
    Cases,
}

/// `--from`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// `startTime` of controlDict.
    Start,
    /// The latest time directory.
    Latest,
    /// The time directory of that time, s.
    Time(f64),
}

fn start(text: &str) -> Result<Start, String> {
    match text {
        "start" => Ok(Start::Start),
        "latest" => Ok(Start::Latest),
        _ => seconds(text).map(Start::Time).map_err(|_| {
            format!("expected `start`, `latest` or a time in seconds, found `{text}`")
        }),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let finite = text.parse::<f64>().ok().filter(|t| t.is_finite());
    finite.ok_or_else(|| format!("expected a time in seconds, found `{text}`"))
}

fn positive(text: &str) -> Result<f64, String> {
    let found = text.parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0);
    found.ok_or_else(|| format!("expected a positive number, found `{text}`"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_table_of_arguments_is_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn run_reads_its_options() {
        let args = Args::try_parse_from(["granflow", "run", "a", "-j2", "--from", "-0.5"]).unwrap();
        let Command::Run(run) = args.command else { panic!("not run") };
        assert_eq!((run.case, run.threads), ("a".into(), Some(2)));
        assert_eq!((run.from, run.until), (Some(Start::Time(-0.5)), None));
        assert!(Args::try_parse_from(["granflow", "run", "--from", "lastest"]).is_err());
        assert!(Args::try_parse_from(["granflow", "run", "--until", "inf"]).is_err());
        assert!(Args::try_parse_from(["granflow", "run", "-j", "0"]).is_err());
    }
}
