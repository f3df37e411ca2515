//! A case, read and checked.

use crate::boundary::Patches;
use crate::collect::tidy;
use crate::config::{ReferenceCell, StartFrom};
use crate::files::DiskFiles;
use crate::functions::{Around, Remembered, remembered};
use crate::restart::{WholeState, start_dir};
use crate::{CaseConfig, CaseError, Notices, WaveTable, Zones, config, figures, files};
use crate::{formulae, frames, meshing, sense, set_fields, strays};
use granflow_base::{Dims, Tensor, Vec3, dot, norm, scale, sub, unit};
use granflow_dict::{Diag, Reader, Sink, number};
use granflow_flow::{Gravity, Source};
use granflow_fv::conditions::CaseContext;
use granflow_mesh::{Mesh, PolyMesh};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Which time directory to start from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum From {
    /// The earliest.
    Start,
    /// The latest.
    Latest,
    /// The one of this time, s.
    Time(f64),
}

/// How to run, beside what the case says.
#[derive(Clone, Debug)]
pub struct Options {
    /// Threads of each rank.
    pub threads: usize,
    /// Ranks within this process.
    pub ranks: usize,
    /// Least number of entries of a loop that threads share, in place of what is worthwhile.
    pub share: Option<usize>,
    /// In place of `startFrom`.
    pub from: Option<From>,
    /// In place of `endTime`, s.
    pub until: Option<f64>,
    /// Set from outside: the run writes and stops after the present step.
    pub stop: Arc<AtomicBool>,
    /// Hears of every outer pass, from rank 0.
    pub watch: Option<granflow_flow::Watch>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            threads: 1,
            ranks: 1,
            share: None,
            from: None,
            until: None,
            stop: Arc::default(),
            watch: None,
        }
    }
}

/// A case, read and checked; nothing on the disk was changed.
pub struct Case {
    /// Its directory.
    pub root: PathBuf,
    /// Its files.
    pub files: DiskFiles,
    /// Its dictionaries.
    pub config: CaseConfig,
    /// Its mesh in the user's numbering.
    pub poly: PolyMesh,
    /// The numerics' view of the whole mesh; `global_cell` and `poly_face` are user's numbers.
    pub mesh: Arc<Mesh>,
    /// Whether the mesh was made from `blockMeshDict` and is not on the disk.
    pub mesh_made: bool,
    /// The state to start from.
    pub start: WholeState,
    /// What the time directory to start from knows of each function.
    pub remembered: Vec<Option<Remembered>>,
    /// Fields that setFieldsDict or setAlphaFieldDict changed, which are not so on the disk.
    pub fields_set: Vec<String>,
    /// Forces on the bulk beside gravity, their cells in the user's numbering.
    pub sources: Vec<Box<dyn Source>>,
    /// Waves at its patches.
    pub waves: WaveTable,
    /// Gravity, split into what p_rgh absorbs and what drives the flow along cyclic directions.
    pub gravity: Gravity,
    /// User's cell and pressure inside (Pa, p or p_rgh) of the reference, if any is needed.
    pub reference: Option<(usize, f64)>,
    /// `endTime`, or what the options say, s.
    pub end: f64,
}

impl Case {
    /// Reads and checks all files of the case. Every mistake of every file goes to the sink,
    /// facts worth saying to `notices`.
    ///
    /// # Errors
    /// [`CaseError::Invalid`] when there are mistakes, [`CaseError::Store`] when a file cannot be
    /// read.
    pub fn load(
        root: &Path,
        options: &Options,
        sink: &Sink,
        notices: &Notices,
    ) -> Result<Case, CaseError> {
        let mut config = CaseConfig::read(root, sink, notices)?;
        let loaded = meshing::load(root, sink)?;
        let poly = loaded.poly;
        let mesh = match meshing::prepare(&poly) {
            Ok(m) => m,
            Err(e) => {
                let file = if loaded.made { meshing::BLOCK_MESH } else { meshing::POLY_MESH };
                let path = root.join(file).display().to_string();
                sink.push(Diag::file(path, e.to_string()).help("`granflow check` says more"));
                return Err(CaseError::Invalid);
            }
        };
        let from = options.from.unwrap_or(match config.control.start {
            StartFrom::Latest => From::Latest,
            StartFrom::First => From::Start,
            StartFrom::Time(t) => From::Time(t),
        });
        // What the options ask for has no place in a file.
        let said = options.from.is_none().then_some(&config.control.start_span);
        let dir = start_dir(root, from, said, sink)?;
        let end = options.until.unwrap_or(config.control.end);
        let start = WholeState::read(root, &dir, (&config, end), &poly, sink)?;
        strays::check(root, &dir, &config, sink)?;
        let zones = zones_of(root, &config, (&poly, &mesh), sink)?;
        let around = Around { poly: &poly, mesh: &mesh, zones: &zones };
        config.functions.iter_mut().for_each(|f| f.plan.place(&around, sink));
        for f in &config.functions {
            f.plan.check(&mesh, &config, sink);
        }
        figures::check(root, sink)?;
        let gravity = split_gravity(root, &config, &mesh, sink, notices);
        let Some(mut start) = start else { return Err(CaseError::Invalid) };
        let mut fields_set = Vec::new();
        if start.step == 0 && !start.restarted {
            fields_set = set_fields::apply(root, &poly, &mesh, &mut start, sink, notices)?;
        }
        start.judge_fraction(root, sink);
        let functions = &config.functions;
        let remembered = remembered::read(root, &start.dir, functions, &poly, notices)?;
        let whole = config.gravity.unwrap_or_default();
        let waves = WaveTable::read(root, &start, whole, (&poly, &mesh), sink)?;
        let times = Some((start.time, end));
        let clock = (start.restarted, times);
        let sources = read_sources(root, &dir, &config, clock, (&zones, &mesh), (sink, notices))?;
        frames::meet(root, &mut start, &sources, sink, notices)?;
        need_time_ahead(&config, options, &start, end, sink);
        let mut case = Case {
            root: root.to_owned(),
            files: DiskFiles::new(root),
            config,
            poly,
            mesh: Arc::new(mesh),
            mesh_made: loaded.made,
            start,
            remembered,
            fields_set,
            sources,
            waves,
            gravity,
            reference: None,
            end,
        };
        case.reference = case.find_reference(sink);
        if !sink.has_errors() {
            formulae::check(&case, sink);
        }
        if !sink.has_errors() {
            sense::check(&case, sink);
        }
        if sink.has_errors() {
            return Err(CaseError::Invalid);
        }
        case.say(notices);
        Ok(case)
    }

    /// Pressure inside over pressure in the files: the density where those are kinematic.
    pub fn pressure_factor(&self) -> f64 {
        if self.start.kinematic() { self.config.transport.rho } else { 1.0 }
    }

    /// Pressure gradients that hold mean velocities, as they stand in files.
    pub(crate) fn gradients_of(&self, flow: &[f64]) -> Vec<f64> {
        flow.iter().map(|g| tidy(g / self.config.acceleration_to_force())).collect()
    }

    /// What conditions are made for.
    pub fn patches(&self) -> Patches<'_> {
        let case = CaseContext {
            files: &self.files,
            density: self.config.transport.rho,
            times: Some((self.start.time, self.end)),
        };
        Patches { poly: &self.poly, waves: &self.waves, case }
    }

    fn say(&self, notices: &Notices) {
        if self.start.kinematic() && self.config.transport.rho != 1.0 {
            notices.say(format!(
                "the pressure in the files is kinematic (m2/s2): times rho = {} kg/m3 inside",
                self.config.transport.rho
            ));
        }
    }

    /// The pressure level: needed where no condition fixes it.
    fn find_reference(&self, sink: &Sink) -> Option<(usize, f64)> {
        let p = &self.start.p;
        if p.boundary.len() != self.poly.patches.len() {
            return None;
        }
        let conditions = crate::boundary::conditions::<f64>(
            &p.boundary,
            &self.mesh,
            self.patches(),
            (&p.name, p.dims),
            1.0,
        );
        let fixed = self.mesh.patches.iter().zip(&conditions);
        if fixed.into_iter().any(|(p, c)| !p.faces.is_empty() && c.fixes_value()) {
            return None;
        }
        let Some(given) = &self.config.solution.reference else {
            // Beside another fluid the pressure between grains is measured from their surface.
            let alone = self.config.transport.second.is_none();
            if alone && self.config.transport.grains.is_some() {
                let path = self.root.join("system/fvSolution").display().to_string();
                let message = "no boundary fixes the pressure level, and the friction of grains \
                               depends on it";
                sink.push(Diag::file(path, message).help(
                    "give `pRefCell 0; pRefValue <pressure>;` in PIMPLE, or a fixedValue of the \
                     pressure on a patch",
                ));
            }
            return Some((0, 0.0));
        };
        let cell = match given.cell {
            ReferenceCell::Cell(c) if c < self.mesh.n_cells => c,
            ReferenceCell::Cell(c) => {
                let n = self.mesh.n_cells;
                let d = Diag::error(&given.span, format!("`pRefCell {c}`: the mesh has {n} cells"));
                sink.push(d.label(format!("from 0 to {}", n.saturating_sub(1))));
                return None;
            }
            ReferenceCell::Point(x) => {
                let far = |c: &usize| norm(sub(self.mesh.cell_centre[*c], x));
                let near = (0..self.mesh.n_cells).min_by(|a, b| far(a).total_cmp(&far(b)))?;
                self.mesh.global_cell[near] as usize
            }
        };
        let here = self.mesh.global_cell.iter().position(|&c| c as usize == cell)?;
        if self.config.transport.second.is_some() {
            // Of the pressure itself; the weight above it changes with the interface.
            return Some((cell, given.value));
        }
        // pRefValue is the pressure itself; p_rgh lacks the weight of the fluid.
        let weight =
            self.config.transport.rho * dot(self.gravity.hydrostatic, self.mesh.cell_centre[here]);
        Some((cell, given.value * self.pressure_factor() - weight))
    }
}

/// Refuses an end before the start; an end that is reached already, give or take the rounding of
/// many steps, is none.
fn need_time_ahead(
    config: &CaseConfig,
    options: &Options,
    start: &WholeState,
    end: f64,
    sink: &Sink,
) {
    // With a wrong deltaT this is NaN, and only that is said.
    // A run ends within half a step of its end; what was asked for now is meant.
    let leeway = if options.until.is_some() { 1e-6 } else { 0.5 };
    let late = start.time - leeway * config.control.dt;
    if end >= late || late.is_nan() || end.is_nan() {
        return;
    }
    // Sums of steps have digits that nobody asked for.
    let time = format!("{:.12e}", start.time).parse().unwrap_or(start.time);
    let begin = format!("{} s (directory {})", number(time), start.dir);
    sink.push(match options.until {
        Some(end) => Diag::file("", format!("--until {end} lies before the start at {begin}"))
            .help("give a later --until, or an earlier start with --from"),
        None => {
            let message = format!("endTime {} lies before the start at {begin}", number(end));
            Diag::error(&config.control.end_span, message)
                .label("before the start")
                .help("set a later endTime or --until, or an earlier startTime or --from")
        }
    });
}

/// The zones of a case, where somebody asks for them.
fn zones_of(
    root: &Path,
    config: &CaseConfig,
    (poly, mesh): (&PolyMesh, &Mesh),
    sink: &Sink,
) -> Result<Zones, CaseError> {
    let wanted = config.functions.iter().any(|f| f.plan.wants_zones());
    if !wanted && !config::sources::present(root) && !config::mrf::present(root) {
        return Ok(Zones::default());
    }
    Zones::read(root, poly, mesh, sink)
}

/// The sources of a case as they are at the time directory `dir`, frames that turn behind forces.
fn read_sources(
    root: &Path,
    dir: &str,
    config: &CaseConfig,
    (restarted, times): (bool, Option<(f64, f64)>),
    (zones, mesh): (&Zones, &Mesh),
    (sink, notices): (&Sink, &Notices),
) -> Result<Vec<Box<dyn Source>>, CaseError> {
    if !config::sources::present(root) && !config::mrf::present(root) {
        return Ok(Vec::new());
    }
    let of = (config.acceleration_to_force(), config.transport.second.is_some());
    let mut sources = config::sources::read(root, mesh, zones, of, sink)?;
    for source in &mut sources {
        let Some(m) = source.held_mut() else { continue };
        let file = format!("{dir}/uniform/{}Properties", m.name);
        match files::dict(root, &file, sink)? {
            Some(dict) => {
                let r = Reader::new(&dict, sink);
                let kept = r.opt_scalar("gradient", Dims::NONE, 0.0);
                m.gradient = kept * config.acceleration_to_force();
            }
            None if restarted => notices.say(format!(
                "{file} is not there: what holds the mean velocity (`{}`) starts from no gradient",
                m.name
            )),
            None => {}
        }
    }
    let files = DiskFiles::new(root);
    let case = CaseContext { files: &files, density: config.transport.rho, times };
    sources.extend(config::mrf::read(root, mesh, zones, case, sink)?);
    Ok(sources)
}

/// Splits gravity: p_rgh is periodic, so what acts along a cyclic direction is a body force.
fn split_gravity(
    root: &Path,
    config: &CaseConfig,
    mesh: &Mesh,
    sink: &Sink,
    notices: &Notices,
) -> Gravity {
    let Some(g) = config.gravity else { return Gravity::default() };
    let mut basis: Vec<Vec3> = Vec::new();
    for link in mesh.halo.links() {
        let (Some(&source), true) = (link.send.first(), !link.recv.is_empty()) else { continue };
        if let Some(turn) = &link.rotation {
            let along = scale(turn_axis(turn), dot(turn_axis(turn), g));
            if norm(sub(g, along)) > 1e-6 * norm(g) {
                let path = root.join("constant/g").display().to_string();
                let message = "gravity must point along the axis of the cyclic or wedge patches";
                sink.push(Diag::file(path, message));
            }
            continue;
        }
        let shift = sub(mesh.cell_centre[link.recv.start], mesh.cell_centre[source as usize]);
        let mut new = unit(shift);
        for b in &basis {
            new = sub(new, scale(*b, dot(*b, new)));
        }
        if norm(new) > 1e-6 {
            // Axes are axes to the last bit.
            basis.push(unit(unit(new).map(|x| if x.abs() < 1e-12 { 0.0 } else { x })));
        }
    }
    let mut driving = [0.0; 3];
    for b in &basis {
        driving = granflow_base::add(driving, scale(*b, dot(*b, g)));
    }
    // Rounding of a direction that is meant to be perpendicular.
    if norm(driving) <= 1e-12 * norm(g) {
        driving = [0.0; 3];
    }
    if norm(driving) > 0.0 {
        notices.say(format!(
            "gravity has the component ({} {} {}) m/s2 along the cyclic patches: it acts as a \
             body force, the rest is in p_rgh",
            driving[0], driving[1], driving[2]
        ));
    }
    Gravity { hydrostatic: sub(g, driving), driving }
}

/// Unit vector along the axis of a rotation.
fn turn_axis(r: &Tensor) -> Vec3 {
    let axis = unit([r[7] - r[5], r[2] - r[6], r[3] - r[1]]);
    if norm(axis) > 0.0 {
        return axis;
    }
    // Half a turn: R + 1 = 2 n n.
    let columns = [0, 1, 2].map(|k| [r[k], r[3 + k], r[6 + k]]);
    let plus = |k: usize| {
        let mut c = columns[k];
        c[k] += 1.0;
        c
    };
    (0..3).map(plus).max_by(|a, b| norm(*a).total_cmp(&norm(*b))).map_or([0.0; 3], unit)
}
