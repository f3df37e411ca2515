//! `type volume;`: the outside of the mesh and the surfaces between phases, in space.

use super::field::{Scene, Within, check, within};
use super::slice::ShadeSpec;
use crate::CaseError;
use crate::plot::{Paint, Rgb, Sheet, SolidFigure};
use crate::section::{self, OTHERS, Piece, VECTOR};
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
    limits: Option<(Reader<'a>, Vec<Within>)>,
    colour: Option<Rgb>,
    opacity: f64,
    label: String,
}

fn phase<'a>(r: &Reader<'a>) -> Phase<'a> {
    let fraction = r.opt_scalar("opacity", Dims::NONE, 1.0);
    if !(fraction > 0.0 && fraction <= 1.0) {
        r.error_at_key("opacity", "opacity is above 0 and at most 1", "out of range", None);
    }
    Phase {
        limits: within(r),
        colour: r.has("colour").then(|| r.opt_one_of("colour", &COLOURS, Rgb::BLACK)),
        opacity: fraction,
        label: r.opt_string("label", "").to_owned(),
    }
}

/// The figure at each time; none without times, when only the form is looked at.
pub(super) fn read(r: &Reader<'_>, scenes: &[Scene<'_>]) -> Result<Vec<SolidFigure>, CaseError> {
    let title = r.opt_string("title", "");
    let text = r.opt_string("field", "");
    check(r, "field", text);
    let shades = ShadeSpec::read(r);
    let (mut azimuth, mut elevation, mut up) = (-60.0, 25.0, 2);
    if let Some(view) = r.opt_sub("view") {
        azimuth = view.opt_scalar("azimuth", Dims::NONE, azimuth);
        elevation = view.opt_scalar("elevation", Dims::NONE, elevation);
        if !(-89.0..=89.0).contains(&elevation) {
            let message = "the elevation is -89 to 89 degrees";
            view.error_at_key("elevation", message, "out of range", None);
        }
        up = view.opt_one_of("up", &[("x", 0), ("y", 1), ("z", 2)], 2usize);
    }
    let stretch = r.opt_vector("stretch", Dims::NONE, [1.0; 3]);
    if !stretch.iter().all(|s| *s > 0.0) {
        r.error_at_key("stretch", "stretch is three positive factors", "out of range", None);
    }
    let hide = r.maybe_words("hide").unwrap_or_default();
    let outline = r.opt_switch("outline", true);
    let axes = r.opt_switch("axes", true);
    let mut phases = Vec::new();
    if let Some(mut list) = r.maybe_list("phases") {
        while !list.is_empty() {
            let left = list.rest().len();
            phases.extend(list.dict("phase").map(|p| phase(&p)));
            if list.rest().len() == left {
                break;
            }
        }
    } else {
        phases.push(Phase { limits: within(r), ..phase(r) });
    }
    if text.is_empty() && phases.iter().any(|p| p.colour.is_none()) {
        let help = Some("add `colour red;` to every phase, or `field U_x;` to the figure");
        r.error_here("a phase has no colour and the figure no field", "nothing to colour by", help);
    }

    let mut out = Vec::new();
    for scene in scenes {
        let grid = scene.grid;
        let mut keep = vec![true; grid.kinds().len()];
        for name in &hide {
            match grid.poly.patch(name) {
                Some(p) => {
                    let patch = &grid.poly.patches[p];
                    let first = patch.start - grid.poly.n_inner();
                    keep[first..first + patch.len].fill(false);
                }
                None => {
                    let names = || grid.poly.patches.iter().map(|p| p.name.as_str());
                    let close = nearest(name, names());
                    let all = names().collect::<Vec<_>>().join(", ");
                    let help = close.map_or(format!("the patches are {all}"), |c| {
                        format!("did you mean `{c}`?")
                    });
                    let message = format!("the mesh has no patch `{name}`");
                    r.error_at_key("hide", message, "not there", Some(&help));
                }
            }
        }
        let shown = |v: Vec3| [stretch[0] * v[0], stretch[1] * v[1], stretch[2] * v[2]];
        let coloured = match text {
            "" => None,
            text => scene.at_points(r, "field", text)?.map(|v| section::with_centres(grid, &v)),
        };
        let mut sheets = Vec::new();
        // A surface between two phases belongs to the first that names it.
        let mut drawn: Vec<(String, f64)> = Vec::new();
        for phase in &phases {
            let mut slots: Vec<(usize, Vec<f64>)> = Vec::new();
            if let (Some(v), None) = (&coloured, phase.colour) {
                slots.push((0, v.clone()));
            }
            let (reader, limits) = match &phase.limits {
                Some((reader, limits)) => (reader, &limits[..]),
                None => (r, &[][..]),
            };
            for (k, w) in limits.iter().enumerate() {
                if let Some(v) = scene.at_points(reader, &w.field, &w.field)? {
                    slots.push((OTHERS + k, section::with_centres(grid, &v)));
                }
            }
            let confine = |mut pieces: Vec<Piece>, but: Option<usize>| {
                for (k, w) in limits.iter().enumerate().filter(|(k, _)| Some(*k) != but) {
                    let slack = 1e-9 * (w.range.1 - w.range.0);
                    pieces = section::clip(pieces, OTHERS + k, w.range.0 - slack, 1.0);
                    pieces = section::clip(pieces, OTHERS + k, w.range.1 + slack, -1.0);
                }
                pieces
            };
            let mut pieces = confine(section::outside(grid, &slots, &keep), None);
            for (k, w) in limits.iter().enumerate() {
                for level in [w.range.0, w.range.1] {
                    let surface = (w.field.clone(), level);
                    if drawn.contains(&surface) {
                        continue;
                    }
                    let found = section::iso(grid, &slots, OTHERS + k, level);
                    if !found.is_empty() {
                        pieces.extend(confine(found, Some(k)));
                        drawn.push(surface);
                    }
                }
            }
            if pieces.is_empty() {
                let message = format!("nothing is within `where` at {}", scene.time);
                r.warn_at_key("where", message, "leaves nothing", None);
            }
            let corner = |c: section::Corner| {
                // Normals stretch the other way.
                let n = [VECTOR, VECTOR + 1, VECTOR + 2].map(|k| c.v[k] / stretch[k - VECTOR]);
                (shown(c.at), n, c.v[0])
            };
            sheets.push(Sheet {
                label: phase.label.clone(),
                paint: phase.colour.map_or(Paint::Values, Paint::Plain),
                opacity: phase.opacity,
                triangles: pieces.into_iter().map(|p| p.corners.map(corner)).collect(),
            });
        }
        let painted = || sheets.iter().filter(|s: &&Sheet| s.paint == Paint::Values);
        let values = painted().flat_map(|s| s.triangles.iter().flatten().map(|c| c.2));
        let bar = painted().next().map(|_| shades.over(values, text));
        let edges = if outline { section::edges(grid, &keep) } else { Vec::new() };
        let (a, e) = (azimuth.to_radians(), elevation.to_radians());
        let mut eye = [0.0; 3];
        eye[(up + 1) % 3] = e.cos() * a.cos();
        eye[(up + 2) % 3] = e.cos() * a.sin();
        eye[up] = e.sin();
        let mut upwards = [0.0; 3];
        upwards[up] = 1.0;
        out.push(SolidFigure {
            title: title.replace("<time>", scene.time),
            up: upwards,
            eye,
            edges: edges.into_iter().map(|(a, b)| (shown(a), shown(b))).collect(),
            shades: bar,
            axes: axes.then(|| ["x", "y", "z"].map(String::from)),
            sheets,
        });
    }
    Ok(out)
}
