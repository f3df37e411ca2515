//! How high the first phase stands over given places: a wave gauge, or the surface of a heap.

use super::locate::clip;
use super::schedule::{Every, Schedule};
use super::{Entry, Function, Plan, Remembered, View, Written, columns};
use crate::CaseConfig;
use granflow_base::{Vec3, add, dot, norm, scale, sub};
use granflow_dict::{Diag, Reader, Sink, Span, number};
use granflow_mesh::Mesh;
use granflow_par::Exec;

pub(super) const ENTRY: Entry = Entry {
    name: "interfaceHeight",
    summary: "height of the first phase over given places, `locations`: the integral of alpha along the vertical",
    formula: "hB = integral of alpha along the vertical through the place, hL = hB less the height of the place",
    reference: "OpenFOAM user guide, function objects",
    read: |r, _| Box::new(Gauges::read(r)),
    schedule: Schedule::always(Every::Steps(1)),
};

/// Shorter pieces of a line, over its length, are rounding.
const GRAIN: f64 = 1e-12;

#[derive(Clone)]
struct Gauges {
    places: Vec<Vec3>,
    /// Upwards where gravity does not say.
    up: Option<Vec3>,
    /// The volume fraction that is asked for, where one is.
    alpha: Option<(String, Span)>,
    places_span: Span,
    type_span: Span,
}

impl Gauges {
    fn read(r: &Reader<'_>) -> Gauges {
        // The value in a cell is what the integral needs.
        r.ignore("interpolationScheme");
        let up = r.has("direction").then(|| r.vector("direction", granflow_base::Dims::NONE));
        if up.is_some_and(|up| norm(up) == 0.0) {
            r.error_at_key("direction", "`direction` has no length", "upwards", None);
        }
        Gauges {
            places: r.vectors("locations"),
            up,
            alpha: r.has("alpha").then(|| (r.word("alpha").to_owned(), r.value_span("alpha"))),
            places_span: r.value_span("locations"),
            type_span: r.key_span("type"),
        }
    }

    /// Upwards, of unit length.
    fn upwards(&self, gravity: Vec3) -> Option<Vec3> {
        let up = self.up.unwrap_or(scale(gravity, -1.0));
        (norm(up) > 0.0).then(|| scale(up, 1.0 / norm(up)))
    }
}

/// Farther than any point of this rank's cells from `x`.
fn beyond(mesh: &Mesh, x: Vec3) -> f64 {
    let far = |f: usize| norm(sub(mesh.face_centre[f], x)) + mesh.mag_area[f].sqrt();
    2.0 * (0..mesh.n_faces()).map(far).fold(0.0, f64::max)
}

/// The vertical through `x` as far as `reach` on either side: where it begins, and all of it as a vector.
fn vertical(x: Vec3, up: Vec3, reach: f64) -> (Vec3, Vec3) {
    (add(x, scale(up, -reach)), scale(up, 2.0 * reach))
}

/// The cells that a vertical crosses, each from where to where along it.
fn crossed(mesh: &Mesh, line: (Vec3, Vec3)) -> Vec<(usize, [f64; 2])> {
    let piece = |c| clip(mesh, c, line.0, line.1).map(|(a, b)| (c, [a, b]));
    (0..mesh.n_cells).filter_map(piece).filter(|(_, [a, b])| b - a > GRAIN).collect()
}

/// Length of a line that lies in the phase, and where the line enters the mesh. Where the line runs between
/// cells, the pieces `[from, to, alpha]` of all of them lie beside each other: it has their mean.
fn filled(pieces: &[[f64; 3]]) -> (f64, f64) {
    let mut ends: Vec<f64> = pieces.iter().flat_map(|[a, b, _]| [*a, *b]).collect();
    ends.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    for pair in ends.windows(2) {
        let middle = 0.5 * (pair[0] + pair[1]);
        let here = pieces.iter().filter(|[a, b, _]| *a < middle && middle < *b);
        let (n, alpha) = here.fold((0.0, 0.0), |(n, s), p| (n + 1.0, s + p[2]));
        if n > 0.0 {
            sum += alpha / n * (pair[1] - pair[0]);
        }
    }
    (sum, ends.first().copied().unwrap_or(0.0))
}

impl Plan for Gauges {
    fn check(&self, mesh: &Mesh, config: &CaseConfig, sink: &Sink) {
        let Some(second) = &config.transport.second else {
            let message = "the function `interfaceHeight` needs two phases";
            sink.push(Diag::error(&self.type_span, message).label("the case has one"));
            return;
        };
        if let Some((asked, span)) = self.alpha.as_ref().filter(|a| a.0 != second.alpha()) {
            let message = format!("there is no volume fraction `{asked}`");
            let help = format!("it is `{}`: leave it out or write that", second.alpha());
            sink.push(Diag::error(span, message).label("not known").help(help));
        }
        if self.places.is_empty() {
            let message = "`interfaceHeight` has no places";
            sink.push(Diag::error(&self.places_span, message).label("an empty list"));
        }
        let Some(up) = self.upwards(config.gravity.unwrap_or_default()) else {
            let message = "`interfaceHeight` does not know where up is: there is no gravity";
            let help = "give it, e.g. `direction (0 0 1);`";
            sink.push(Diag::error(&self.type_span, message).label("no `direction`").help(help));
            return;
        };
        for (i, x) in self.places.iter().enumerate() {
            let reach = beyond(mesh, *x);
            if !reach.is_finite() || crossed(mesh, vertical(*x, up, reach)).is_empty() {
                let at = columns::vector(*x);
                let message = format!("no vertical through location {i} at {at} meets the mesh");
                sink.push(Diag::error(&self.places_span, message).label("beside the mesh"));
            }
        }
    }
    fn build(&self, _: &Mesh, _: &Exec, _: Option<&Remembered>) -> Box<dyn Function> {
        Box::new(Placed { plan: self.clone(), lines: Vec::new(), cells: Vec::new() })
    }
}

struct Placed {
    plan: Gauges,
    /// Empty before the first look.
    lines: Vec<(Vec3, Vec3)>,
    /// What each of them crosses on this rank.
    cells: Vec<Vec<(usize, [f64; 2])>>,
}

impl Placed {
    fn place(&mut self, view: &View<'_>, up: Vec3) {
        let places = &self.plan.places;
        let mut reach: Vec<f64> = places.iter().map(|x| beyond(view.mesh, *x)).collect();
        view.exec.comm().max(&mut reach);
        let lines = places.iter().zip(&reach).map(|(x, reach)| vertical(*x, up, *reach));
        self.lines = lines.collect();
        self.cells = self.lines.iter().map(|line| crossed(view.mesh, *line)).collect();
    }
}

impl Function for Placed {
    fn sample(&mut self, view: &View<'_>) -> Vec<Written> {
        let (Some(alpha), Some(up)) = (view.alpha, self.plan.upwards(view.gravity)) else {
            return Vec::new();
        };
        if self.lines.is_empty() {
            self.place(view, up);
        }
        let Placed { plan, lines, cells } = self;
        let places = &plan.places;
        let (mut heights, mut tops) = (Vec::new(), Vec::new());
        for (i, pieces) in cells.iter().enumerate() {
            let mine = pieces.iter().flat_map(|&(c, [a, b])| [a, b, alpha.cells.data[c]]);
            let Some(all) = view.exec.comm().gather(mine.collect()) else { continue };
            let pieces: Vec<[f64; 3]> =
                all.iter().flatten().copied().collect::<Vec<f64>>().as_chunks::<3>().0.to_vec();
            let (start, whole) = lines[i];
            let (share, enters) = filled(&pieces);
            let height = share * norm(whole);
            let top = add(add(start, scale(whole, enters)), scale(up, height));
            heights.extend([height, dot(top, up) - dot(places[i], up)]);
            tops.push(top);
        }
        if view.exec.rank() != 0 {
            return Vec::new();
        }
        let mut head = String::new();
        for (i, x) in places.iter().enumerate() {
            head += &format!("# Location {i} {}\n", columns::vector(*x));
        }
        let columns_of = |of: &dyn Fn(usize) -> Vec<String>| {
            (0..places.len()).flat_map(of).collect::<Vec<String>>()
        };
        let named = columns_of(&|i| vec![format!("hB_{i}"), format!("hL_{i}")]);
        let what = "# hB_i: height over the lower end of the mesh, hL_i: over location i, m\n";
        let numbers: Vec<String> = heights.iter().map(|h| number(*h)).collect();
        let positions: Vec<String> = tops.iter().map(|x| columns::vector(*x)).collect();
        let at = columns_of(&|i| vec![format!("p_{i}")]);
        vec![
            Written::Line {
                file: "height.dat".into(),
                header: format!("{head}{what}{}", columns::head(&named)),
                line: columns::row(view, &numbers),
            },
            Written::Line {
                file: "position.dat".into(),
                header: format!("{head}{}", columns::head(&at)),
                line: columns::row(view, &positions),
            },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_beside_each_other_counts_once() {
        // Two columns of cells beside the line: full below 0.3, then one of them half full.
        let pieces =
            [[0.1, 0.3, 1.0], [0.1, 0.3, 1.0], [0.3, 0.5, 0.5], [0.3, 0.5, 0.0], [0.5, 0.9, 0.0]];
        let (length, enters) = filled(&pieces);
        assert!((length - (0.2 + 0.25 * 0.2)).abs() < 1e-15);
        assert_eq!(enters, 0.1);
        assert_eq!(filled(&[]), (0.0, 0.0));
    }
}
