//! Files of sampled surfaces: VTK's PolyData (`.vtp`) and columns of numbers (`.raw`).

use super::cut::Cut;
use super::field::Components;
use super::{Named, Written};
use crate::export::poly_data;
use granflow_base::Vec3;
use granflow_dict::{Reader, number};

/// How surfaces are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SurfaceFormat {
    /// `<surface>.vtp` with all fields.
    Vtp,
    /// `<field>_<surface>.raw` for each field.
    Raw,
}

/// Formats of OpenFOAM's that are refused by name.
const REFUSED: &[&str] = &[
    "boundaryData",
    "csv",
    "dx",
    "ensight",
    "foam",
    "foamFile",
    "nastran",
    "obj",
    "off",
    "proxy",
    "starcd",
    "stl",
    "tri",
    "x3d",
];

impl SurfaceFormat {
    /// Reads `surfaceFormat`.
    pub(super) fn read(r: &Reader<'_>) -> SurfaceFormat {
        r.ignore("formatOptions");
        if let Some(word) = r.maybe_word("surfaceFormat").filter(|w| REFUSED.contains(w)) {
            let message = format!("surfaces are not written as `{word}`");
            let help = "ParaView opens `vtp`; `raw` is columns of numbers";
            r.error_at_key("surfaceFormat", message, "refused", Some(help));
            return SurfaceFormat::Vtp;
        }
        let known =
            [("vtk", SurfaceFormat::Vtp), ("vtp", SurfaceFormat::Vtp), ("raw", SurfaceFormat::Raw)];
        r.opt_one_of("surfaceFormat", &known, SurfaceFormat::Vtp)
    }
}

/// A field on a surface.
pub(super) struct OnSurface<'a> {
    pub(super) field: &'a Named,
    pub(super) values: Vec<Components>,
}

/// The files of one surface; values belong to its points or to its faces.
pub(super) fn files(
    format: SurfaceFormat,
    name: &str,
    time: f64,
    cut: &Cut,
    on_points: bool,
    fields: &[OnSurface<'_>],
) -> Vec<Written> {
    if format == SurfaceFormat::Vtp {
        let arrays = fields.iter().map(|f| {
            let n = f.field.quantity.n();
            let flat = f.values.iter().flat_map(|v| v[..n].to_vec()).collect();
            poly_data::Array { name: f.field.name.clone(), components: n, data: flat }
        });
        let arrays: Vec<poly_data::Array> = arrays.collect();
        let bytes = poly_data::file(&cut.points, &cut.faces, &[], on_points, Some(time), &arrays);
        return vec![Written::File { file: format!("{name}.vtp"), bytes }];
    }
    let middles = if on_points { Vec::new() } else { cut.middles() };
    let places = if on_points { &cut.points } else { &middles };
    let one = |f: &OnSurface<'_>| Written::File {
        file: format!("{}_{name}.raw", f.field.name),
        bytes: raw(f, places, on_points).into_bytes(),
    };
    fields.iter().map(one).collect()
}

fn raw(f: &OnSurface<'_>, places: &[Vec3], on_points: bool) -> String {
    let kind = if on_points { "POINT_DATA" } else { "FACE_DATA" };
    let mut text = format!("# {}  {kind} {}\n", f.field.name, places.len());
    text += &format!("# x  y  z  {}\n", f.field.columns().join("  "));
    for (x, v) in places.iter().zip(&f.values) {
        let cells = x.iter().chain(&v[..f.field.quantity.n()]);
        text += &cells.map(|x| number(*x)).collect::<Vec<_>>().join(" ");
        text.push('\n');
    }
    text
}
