//! The state of a case at one time: what a time directory holds.

use crate::fields::{VolField, read_surface, read_vol};
use crate::files::DiskFiles;
use crate::store::{StoreError, TimeName, list_times};
use crate::{CaseConfig, CaseError, files};
use granflow_base::{Dims, Vec3};
use granflow_dict::{Diag, Format, Header, Reader, Severity, Sink, Span, Writer, number};
use granflow_fv::conditions::CaseContext;
use granflow_mesh::PolyMesh;
use std::path::Path;

/// How far a volume fraction may be beyond 0 to 1 where a run wrote it: with loose tolerances transport leaves some, here as in
/// other programs. What is further is no volume fraction.
const BEYOND: f64 = 0.1;
/// How far it may be without a word; where nothing has run yet, at all.
const ROUNDING: f64 = 1e-3;

/// A state on the whole mesh, in the user's numbering and the units of the files.
#[derive(Clone)]
pub struct WholeState {
    /// Name of the time directory it came from.
    pub dir: String,
    /// Time, exact where `uniform/time` says it, s.
    pub time: f64,
    /// Steps since time zero.
    pub step: usize,
    /// Whether a run wrote it.
    pub restarted: bool,
    /// Length of the next step before it is fitted to write times, s (adjustable steps only).
    pub dt: Option<f64>,
    /// Length of the last step, s; 0 when unknown.
    pub dt_old: f64,
    /// Velocity.
    pub u: VolField<Vec3>,
    /// Velocity one step earlier, m/s.
    pub u_old: Option<Vec<Vec3>>,
    /// Pressure in the units of its file.
    pub p: VolField<f64>,
    /// Fluxes through the faces, m3/s.
    pub phi: Option<Vec<f64>>,
    /// Fluxes one step earlier, m3/s.
    pub phi_old: Option<Vec<f64>>,
    /// Volume fraction of the first phase, where there are two.
    pub alpha: Option<VolField<f64>>,
    /// Fluidity; `cells` are zero where there is no file.
    pub fluidity: VolField<f64>,
    /// Whether `fluidity` came from a file.
    pub has_fluidity: bool,
}

impl WholeState {
    /// What there is to say of a volume fraction beyond 0 to 1, once all that sets it has.
    pub(crate) fn judge_fraction(&self, root: &Path, sink: &Sink) {
        let Some(alpha) = &self.alpha else { return };
        let excess = |a: f64| if a.is_nan() { f64::INFINITY } else { (a - 1.0).max(-a) };
        let worst = alpha.cells.iter().map(|a| excess(*a)).fold(0.0, f64::max);
        if worst <= ROUNDING {
            return;
        }
        let cell = alpha.cells.iter().position(|a| excess(*a) >= worst).unwrap_or_default();
        let value = alpha.cells[cell];
        let path = root.join(&self.dir).join(&alpha.name).display().to_string();
        let message = format!("the volume fraction is {value} in cell {cell}, not 0 to 1");
        let mut diag = Diag::file(path, message);
        if self.restarted && worst <= BEYOND {
            diag.severity = Severity::Warning;
            diag = diag.help("tighter tolerances of the pressure keep it within its bounds");
        }
        sink.push(diag);
    }

    /// Whether the pressure is given per density, m2/s2.
    pub fn kinematic(&self) -> bool {
        self.p.dims == Dims::KINEMATIC_PRESSURE
    }

    /// Reads the time directory `dir` for a run until `end` (s). Mistakes go to the sink; `None` when a needed file is
    /// missing (which is one of them).
    ///
    /// # Errors
    /// A file is there and cannot be read.
    pub fn read(
        root: &Path,
        dir: &str,
        (config, end): (&CaseConfig, f64),
        poly: &PolyMesh,
        sink: &Sink,
    ) -> Result<Option<WholeState>, CaseError> {
        let on_disk = DiskFiles::new(root);
        let case = CaseContext {
            files: &on_disk,
            density: config.transport.rho,
            times: TimeName::parse(dir).map(|begin| (begin, end)),
        };
        let missing = |name: &str, help: &str| {
            let path = root.join(dir).join(name).display().to_string();
            sink.push(Diag::file(path, format!("the field `{name}` is missing")).help(help));
        };
        let u = read_vol::<Vec3>(root, dir, "U", &[Dims::VELOCITY], (poly, case), sink)?;
        if u.is_none() {
            missing("U", "every case needs the velocity and its boundary conditions");
        }
        let pressure = config.pressure();
        let accept = [Dims::PRESSURE, Dims::KINEMATIC_PRESSURE];
        let second = config.transport.second.as_deref();
        // With two densities there is no pressure per density.
        let accept = if second.is_some() { &accept[..1] } else { &accept[..] };
        let p = read_vol::<f64>(root, dir, pressure, accept, (poly, case), sink)?;
        let mut alpha = None;
        if let Some(second) = second {
            let name = second.alpha();
            let none = [Dims::NONE];
            alpha = read_vol::<f64>(root, dir, &name, &none, (poly, case), sink)?;
            if alpha.is_none() {
                // What tutorials copy into place before they fill it.
                let original = format!("{name}.orig");
                alpha = read_vol::<f64>(root, dir, &original, &none, (poly, case), sink)?;
            }
            match &mut alpha {
                Some(field) => field.name = name,
                None => missing(&name, "two phases need the volume fraction of the first one"),
            }
        }
        if p.is_none() {
            let other = if pressure == "p" { "p_rgh" } else { "p" };
            match (files::exists(root, &format!("{dir}/{other}")), pressure) {
                (true, "p_rgh") => missing(
                    "p_rgh",
                    "gravity acts (constant/g), so the unknown is p_rgh = p - rho g.x: rename `p` \
                     and use fixedFluxPressure at walls, prghPressure where p is given; or remove \
                     constant/g",
                ),
                (true, _) => missing(
                    "p",
                    "the case has p_rgh and no constant/g: add constant/g, or rename p_rgh to p",
                ),
                _ => missing(pressure, "every case needs the pressure and its boundary conditions"),
            }
        }
        let rate = [Dims::RATE];
        let from_file = match config.transport.has_fluidity {
            true => read_vol::<f64>(root, dir, "fluidity", &rate, (poly, case), sink)?,
            false => None,
        };
        let has_fluidity = from_file.is_some();
        let fluidity =
            from_file.unwrap_or_else(|| VolField::uniform("fluidity", Dims::RATE, 0.0, poly));
        if has_fluidity && fluidity.cells.iter().any(|g| *g < 0.0) {
            let path = root.join(dir).join("fluidity").display().to_string();
            sink.push(Diag::file(path, "the fluidity is negative somewhere"));
        }
        let phi = read_surface(root, dir, "phi", Dims::VOLUME_FLUX, poly, sink)?;
        let backward = config.schemes.ddt.remembers_two();
        let u_old = match read_vol::<Vec3>(root, dir, "U_0", &[Dims::VELOCITY], (poly, case), sink)?
        {
            Some(f) if backward => Some(f.cells),
            _ => None,
        };
        let phi_old =
            read_surface(root, dir, "phi_0", Dims::VOLUME_FLUX, poly, sink)?.filter(|_| backward);
        let mut clock = Clock::read(root, dir, sink)?;
        if backward && (u_old.is_none() || phi_old.is_none()) {
            // Without an earlier velocity and flux the first step is a plain one.
            clock.dt_old = 0.0;
            if phi.is_some() {
                let path = root.join(dir).join("U_0").display().to_string();
                let message =
                    "the velocity of the step before is not there: the first step is Euler's";
                let d = Diag::file(path, message);
                sink.push(Diag { severity: granflow_dict::Severity::Warning, ..d });
            }
        }
        let (Some(u), Some(p)) = (u, p) else { return Ok(None) };
        if second.is_some() && alpha.is_none() {
            return Ok(None);
        }
        Ok(Some(WholeState {
            dir: dir.into(),
            time: clock.time,
            step: clock.step,
            restarted: phi.is_some(),
            dt: clock.dt,
            dt_old: clock.dt_old,
            u,
            u_old,
            p,
            phi,
            phi_old,
            alpha,
            fluidity,
            has_fluidity,
        }))
    }
}

/// `uniform/time` of a time directory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Time, s.
    pub time: f64,
    /// Steps since time zero.
    pub step: usize,
    /// Length of the next step, s.
    pub dt: Option<f64>,
    /// Length of the last step, s.
    pub dt_old: f64,
}

impl Clock {
    /// Reads the file; without one the time is the directory's name.
    ///
    /// # Errors
    /// The file is there and cannot be read.
    pub fn read(root: &Path, dir: &str, sink: &Sink) -> Result<Clock, StoreError> {
        let named = TimeName::parse(dir).unwrap_or(0.0);
        let mut clock = Clock { time: named, step: 0, dt: None, dt_old: 0.0 };
        let Some(dict) = files::dict(root, Path::new(dir).join("uniform/time"), sink)? else {
            return Ok(clock);
        };
        let r = Reader::new(&dict, sink);
        // A renamed or copied directory: its name counts.
        let value = r.opt_scalar("value", Dims::TIME, named);
        let belongs = (value - named).abs() <= 1e-3 * value.abs().max(named.abs());
        r.ignore("name");
        clock.step = r.opt_label_in("index", 0..=i64::MAX, 0) as usize;
        clock.dt = r.maybe_scalar("deltaT", Dims::TIME).filter(|dt| *dt > 0.0);
        clock.dt_old = r.opt_non_negative("deltaT0", Dims::TIME, 0.0);
        r.finish(Severity::Warning);
        if belongs {
            clock.time = value;
        }
        Ok(clock)
    }

    /// The file's text.
    pub fn text(&self, dir: &str) -> Vec<u8> {
        let header = Header::new("dictionary", "time").location(format!("{dir}/uniform"));
        let mut w = Writer::new(&header.format(Format::Ascii));
        w.entry("value", number(self.time));
        w.entry("name", format_args!("\"{dir}\""));
        w.entry("index", self.step);
        w.entry("deltaT", number(self.dt.unwrap_or(self.dt_old)));
        w.entry("deltaT0", number(self.dt_old));
        w.finish()
    }
}

/// The name of the time directory to start from. `said` is where a file asks for it; without,
/// the options do.
///
/// # Errors
/// The case directory cannot be read; [`CaseError::Invalid`] when it has no time directory.
pub fn start_dir(
    root: &Path,
    from: crate::From,
    said: Option<&Span>,
    sink: &Sink,
) -> Result<String, CaseError> {
    let times = list_times(root)?;
    let found = match from {
        crate::From::Start => times.first(),
        crate::From::Latest => times.last(),
        crate::From::Time(t) => {
            let off = |x: &&(f64, _)| (x.0 - t).abs();
            times.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
        }
    };
    if let Some((t, path)) = found {
        if let crate::From::Time(wanted) = from
            && (t - wanted).abs() > 1e-6 * wanted.abs().max(t.abs())
        {
            let names: Vec<String> = times.iter().filter_map(|x| name_of(&x.1)).collect();
            let message = format!("the case has no time {wanted}");
            let times = if names.len() == 1 { "its only time is" } else { "it has the times" };
            let times = format!("{times} {}", names.join(", "));
            let near = name_of(path).unwrap_or_default();
            let copy = TimeName::default().of(wanted);
            let mut help = format!(
                "{times}: write `startTime {near};` to start there, or start at {} s from its \
                 fields: `cp -r {near} {copy}`",
                number(wanted),
            );
            if files::exists(root, "system/mapFieldsDict") {
                help += " (system/mapFieldsDict: OpenFOAM's mapFields would fill that time from another \
                         case; granflow has no such tool)";
            }
            sink.push(match said {
                Some(at) => Diag::error(at, message).label("asked for here").help(help),
                None => Diag::file("", format!("--from {wanted}: {message}; {times}")),
            });
            return Err(CaseError::Invalid);
        }
        if let Some(name) = name_of(path) {
            return Ok(name);
        }
    }
    let d = Diag::file(root.join("0").display().to_string(), "the case has no time directory");
    let help = if root.join("0.orig").is_dir() {
        "`granflow init` copies 0.orig to 0"
    } else {
        "make the directory `0` with the fields U and p (p_rgh where gravity acts)"
    };
    sink.push(d.help(help));
    Err(CaseError::Invalid)
}

fn name_of(path: &Path) -> Option<String> {
    Some(path.file_name()?.to_str()?.to_owned())
}
