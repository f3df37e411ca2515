//! `type volume;`: the outside of the mesh and the surfaces between phases, in space.

use super::field::{Scene, check};
use super::limits::Limits;
use super::shades::ShadeSpec;
use crate::CaseError;
use crate::plot::{Paint, Rgb, Sheet, SolidFigure};
use crate::section::{self, Corner, Grid, OTHERS, Piece, VECTOR};
use granflow_base::{Dims, Vec3};
use granflow_dict::{Reader, nearest};

const COLOURS: [(&str, Rgb); 11] = [
    ("red", Rgb(200, 55, 45)),
    ("blue", Rgb(60, 120, 200)),
    ("green", Rgb(0, 158, 115)),
    ("orange", Rgb(230, 159, 0)),
    ("yellow", Rgb(240, 228, 66)),
    ("purple", Rgb(204, 121, 167)),
    ("sky", Rgb(86, 180, 233)),
    ("sand", Rgb(214, 180, 120)),
    ("grey", Rgb(150, 150, 150)),
    ("black", Rgb(40, 40, 40)),
    ("white", Rgb(250, 250, 250)),
];

/// A part of what is shown.
struct Phase<'a> {
    limits: Limits<'a>,
    colour: Option<Rgb>,
    opacity: f64,
    label: &'a str,
}

impl<'a> Phase<'a> {
    fn read(r: &Reader<'a>) -> Phase<'a> {
        let opacity = r.opt_scalar("opacity", Dims::NONE, 1.0);
        if opacity <= 0.0 || opacity > 1.0 {
            r.error_at_key("opacity", "opacity is above 0 and at most 1", "out of range", None);
        }
        Phase {
            limits: Limits::read(r),
            colour: r.has("colour").then(|| r.opt_one_of("colour", &COLOURS, Rgb::BLACK)),
            opacity,
            label: r.opt_string("label", ""),
        }
    }

    /// The triangles of the phase. `field` is that of the figure; `drawn` are the surfaces that
    /// earlier phases drew: one between two phases belongs to the first.
    fn pieces(
        &self,
        scene: &Scene<'_>,
        (r, field): (&Reader<'_>, &str),
        keep: &[bool],
        drawn: &mut Vec<(&'a str, f64)>,
    ) -> Result<Vec<Piece>, CaseError> {
        let grid = scene.grid;
        let mut slots: Vec<(usize, Vec<f64>)> = Vec::new();
        if self.colour.is_none() {
            let values = self.limits.at_points(scene, r, "field", field)?;
            slots.extend(values.map(|v| (0, section::with_centres(grid, &v))));
        }
        for (slot, v) in self.limits.slots(scene, OTHERS)? {
            slots.push((slot, section::with_centres(grid, &v)));
        }
        let confine = |pieces, but| self.limits.confine(pieces, OTHERS, but);
        let mut pieces = confine(section::outside(grid, &slots, keep), None);
        let mut shared = false;
        for (k, field, level) in self.limits.ends() {
            let Some((_, values)) = slots.iter().find(|s| s.0 == OTHERS + k) else { continue };
            // A field that only touches a level has no surface there.
            let beyond = values.iter().any(|v| *v < level) && values.iter().any(|v| *v > level);
            if !beyond {
                continue;
            }
            if drawn.contains(&(field, level)) {
                shared = true;
            } else {
                drawn.push((field, level));
                pieces.extend(confine(section::iso(grid, &slots, OTHERS + k, level), Some(k)));
            }
        }
        // Of a phase whose outside is hidden an earlier one may have drawn all there is.
        if !shared {
            self.limits.warn_if_empty(&pieces, r, scene.time);
        }
        Ok(pieces)
    }
}

/// The direction something is seen from.
struct View {
    eye: Vec3,
    up: Vec3,
}

impl View {
    fn read(r: &Reader<'_>) -> View {
        let (mut azimuth, mut elevation, mut up) = (-60.0, 25.0, 2);
        if let Some(view) = r.opt_sub("view") {
            azimuth = view.opt_scalar("azimuth", Dims::NONE, azimuth);
            elevation = view.opt_in_range("elevation", Dims::NONE, -89.0..=89.0, elevation);
            up = view.opt_one_of("up", &[("x", 0), ("y", 1), ("z", 2)], 2usize);
        }
        let (a, e) = (f64::to_radians(azimuth), f64::to_radians(elevation));
        let mut eye = [0.0; 3];
        eye[(up + 1) % 3] = e.cos() * a.cos();
        eye[(up + 2) % 3] = e.cos() * a.sin();
        eye[up] = e.sin();
        let mut upwards = [0.0; 3];
        upwards[up] = 1.0;
        View { eye, up: upwards }
    }
}

/// Phases in space as the dictionary describes them.
pub(super) struct SolidSpec<'a> {
    r: Reader<'a>,
    title: &'a str,
    /// Empty: every phase has its colour.
    field: &'a str,
    shades: ShadeSpec,
    view: View,
    stretch: Vec3,
    hide: Vec<&'a str>,
    outline: bool,
    axes: bool,
    phases: Vec<Phase<'a>>,
}

impl<'a> SolidSpec<'a> {
    pub(super) fn read(r: &Reader<'a>) -> SolidSpec<'a> {
        let field = r.opt_string("field", "");
        check(r, "field", field);
        let stretch = r.opt_vector("stretch", Dims::NONE, [1.0; 3]);
        if stretch.iter().any(|s| *s <= 0.0) {
            r.error_at_key("stretch", "stretch is three positive factors", "out of range", None);
        }
        let mut phases = Vec::new();
        if let Some(mut list) = r.maybe_list("phases") {
            while !list.is_empty() {
                let left = list.rest().len();
                phases.extend(list.dict("phase").map(|p| Phase::read(&p)));
                if list.rest().len() == left {
                    break;
                }
            }
        } else {
            phases.push(Phase::read(r));
        }
        if field.is_empty() && phases.iter().any(|p| p.colour.is_none()) {
            let help = "add `colour red;` to every phase, or `field U_x;` to the figure";
            let message = "a phase has no colour and the figure no field";
            r.error_here(message, "nothing to colour by", Some(help));
        }
        SolidSpec {
            r: r.clone(),
            title: r.opt_string("title", ""),
            field,
            shades: ShadeSpec::read(r),
            view: View::read(r),
            stretch,
            hide: r.maybe_words("hide").unwrap_or_default(),
            outline: r.opt_switch("outline", true),
            axes: r.opt_switch("axes", true),
            phases,
        }
    }

    /// Whether a boundary face is shown.
    fn shown(&self, grid: &Grid) -> Vec<bool> {
        let poly = &grid.poly;
        let mut keep = vec![true; poly.n_faces() - poly.n_inner()];
        for name in &self.hide {
            if let Some(p) = poly.patch(name) {
                let patch = &poly.patches[p];
                let first = patch.start - poly.n_inner();
                keep[first..first + patch.len].fill(false);
                continue;
            }
            let names = || poly.patches.iter().map(|p| p.name.as_str());
            let help = match nearest(name, names()) {
                Some(close) => format!("did you mean `{close}`?"),
                None => format!("the patches are {}", names().collect::<Vec<_>>().join(", ")),
            };
            let message = format!("the mesh has no patch `{name}`");
            self.r.error_at_key("hide", message, "not there", Some(&help));
        }
        keep
    }

    /// The figure at a time; mistakes are reported.
    pub(super) fn draw(&self, scene: &Scene<'_>) -> Result<SolidFigure, CaseError> {
        let (grid, r) = (scene.grid, &self.r);
        let keep = self.shown(grid);
        let [sx, sy, sz] = self.stretch;
        let place = |v: Vec3| [sx * v[0], sy * v[1], sz * v[2]];
        let corner = |c: Corner| {
            // Normals stretch the other way.
            let n = [c.v[VECTOR] / sx, c.v[VECTOR + 1] / sy, c.v[VECTOR + 2] / sz];
            (place(c.at), n, c.v[0])
        };
        let (mut sheets, mut drawn) = (Vec::new(), Vec::new());
        for phase in &self.phases {
            let pieces = phase.pieces(scene, (r, self.field), &keep, &mut drawn)?;
            sheets.push(Sheet {
                label: phase.label.to_owned(),
                paint: phase.colour.map_or(Paint::Values, Paint::Plain),
                opacity: phase.opacity,
                triangles: pieces.into_iter().map(|p| p.corners.map(corner)).collect(),
            });
        }
        let painted = || sheets.iter().filter(|s| s.paint == Paint::Values);
        let shades = painted().next().map(|_| {
            let values = painted().flat_map(|s| s.triangles.iter().flatten().map(|c| c.2));
            self.shades.over(values, self.field)
        });
        let edges = if self.outline { section::edges(grid, &keep) } else { Vec::new() };
        Ok(SolidFigure {
            title: self.title.replace("<time>", scene.time),
            up: self.view.up,
            eye: self.view.eye,
            sheets,
            edges: edges.into_iter().map(|(a, b)| (place(a), place(b))).collect(),
            shades,
            axes: self.axes.then(|| ["x", "y", "z"].map(String::from)),
        })
    }
}
