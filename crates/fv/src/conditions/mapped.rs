//! Values from `constant/boundaryData/<patch>`: measured or computed elsewhere at points near the
//! patch, at some times.

mod planar;

use super::read::leave_value;
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use crate::time_function::TimeFunction;
use granflow_base::{Value, Vec3};
use granflow_dict::{Diag, Payload, Reader, Severity, Source, parse_list_file};
use planar::Stencil;

/// How values get from the points to the faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Method {
    /// Linearly in the triangles between the points (B. Delaunay, Bull. Acad. Sci. URSS (1934) 793).
    Planar,
    /// From the nearest point.
    Nearest,
}

/// Dirichlet: linear in time between the times that are given, and as `Method` says in space.
struct TimeVaryingMapped<T> {
    points: Vec<Vec3>,
    /// Time (s) and the values at the points, in the units of the field inside.
    times: Vec<(f64, Vec<T>)>,
    offset: Option<TimeFunction<T>>,
    method: Method,
    /// Which points each face takes its value from; found when it is first asked for.
    stencils: Option<Vec<Stencil>>,
    entries: Vec<(String, String)>,
}

impl<T: Value> Condition<T> for TimeVaryingMapped<T> {
    fn name(&self) -> &'static str {
        "timeVaryingMappedFixedValue"
    }
    fn update(&mut self, view: &PatchView<'_, T>, closure: &mut PatchClosure<'_, T>) {
        closure.fix(T::ZERO);
        let (points, method) = (&self.points, self.method);
        let stencils = self.stencils.get_or_insert_with(|| match method {
            Method::Planar => planar::linear(points, view.centre),
            Method::Nearest => planar::nearest(points, view.centre),
        });
        let time = view.around.time;
        let offset = self.offset.as_ref().map_or(T::ZERO, |f| f.at(time));
        let k = self.times.partition_point(|t| t.0 <= time);
        let before = self.times.get(k.max(1) - 1);
        let Some((t0, v0)) = before else { return };
        let next = if k == 0 { None } else { self.times.get(k) };
        for (o, stencil) in closure.offset.iter_mut().zip(stencils) {
            let here = stencil.value(v0);
            *o = offset.plus(match next {
                Some((t1, v1)) => here.axpy((time - t0) / (t1 - t0), stencil.value(v1).minus(here)),
                None => here,
            });
        }
    }
    fn fixes_value(&self) -> bool {
        true
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.entries.clone()
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "timeVaryingMappedFixedValue",
    summary: "Dirichlet: values at points and times from constant/boundaryData/<patch>, linear between \
              them",
    formula: "phi_f = offset(t) + (1 - s) sum_k w_k v_k(t_0) + s sum_k w_k v_k(t_1), s = (t - \
              t_0)/(t_1 - t_0); w_k: shares of the corners of the triangle of points around \
              x_f, or 1 of the nearest",
    keys: &[
        ("mapMethod", "`planarInterpolation` (default) or `nearest`"),
        ("offset", "units of the field, a function of time, optional"),
        ("fieldTable", "name of the file with the values, default that of the field"),
        ("setAverage", "`off`: values are not shifted to an average"),
    ],
    reference: "B. Delaunay, Bull. Acad. Sci. URSS (1934) 793",
    scalar: Some(read),
    vector: Some(read),
};

fn read<T: Value>(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<T>> {
    leave_value(r);
    // Noise that keeps a triangulation from degenerate triangles: none is needed here.
    r.ignore("perturb");
    let choices = [
        ("planarInterpolation", Method::Planar),
        ("planar", Method::Planar),
        ("nearest", Method::Nearest),
    ];
    let method = r.opt_one_of("mapMethod", &choices, Method::Planar);
    if r.opt_switch("setAverage", false) {
        let message = "values are not shifted to an average";
        r.error_at_key("setAverage", message, "set here", Some("write `setAverage off;`"));
    }
    let offset = TimeFunction::opt_read(r, "offset", c.dims, c.case).map(|f| f.times(c.factor));
    let field = r.maybe_word("fieldTable").unwrap_or(c.field).to_owned();
    let mut out = TimeVaryingMapped {
        points: Vec::new(),
        times: Vec::new(),
        offset,
        method,
        stencils: None,
        entries: r
            .keys()
            .into_iter()
            .filter(|k| !["type", "value"].contains(k))
            .filter_map(|k| Some((k.to_owned(), crate::time_function::raw_text(r.dict().get(k)?))))
            .collect(),
    };
    let folder = format!("constant/boundaryData/{}", c.patch);
    let Some(points) = list(r, c, &format!("{folder}/points"), vectors) else {
        return Box::new(out);
    };
    out.points = points;
    for (time, name) in times(r, c, &folder) {
        let path = format!("{folder}/{name}/{field}");
        let Some(mut values) = list(r, c, &path, of_type::<T>) else { continue };
        if values.len() != out.points.len() {
            let (n, of) = (values.len(), out.points.len());
            let message = format!("{n} values for the {of} points in `{folder}/points`");
            r.sink().push(Diag::file(path, message));
            continue;
        }
        values.iter_mut().for_each(|v| *v = v.scaled(c.factor));
        out.times.push((time, values));
    }
    if let (Some((first, _)), Some((begin, _))) = (out.times.first(), c.case.times)
        && begin < *first
    {
        let message =
            format!("`{folder}` has values from {first} s on, and the run begins at {begin} s");
        r.error_at_key("type", message, "no values at the start", None);
    }
    Box::new(out)
}

/// The times that are there, in order.
fn times(r: &Reader<'_>, c: &PatchContext<'_>, folder: &str) -> Vec<(f64, String)> {
    let names = c.case.files.folders(folder).unwrap_or_default();
    let mut times: Vec<(f64, String)> =
        names.into_iter().filter_map(|n| Some((n.parse().ok()?, n))).collect();
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    if times.is_empty() {
        let message = format!("`{folder}` holds no times with values");
        let help = format!("put the values into `{folder}/0/{}`", c.field);
        r.error_at_key("type", message, "needs values", Some(&help));
    }
    times
}

/// The list in a file of the case; a mistake where there is none.
fn list<V>(
    r: &Reader<'_>,
    c: &PatchContext<'_>,
    path: &str,
    of: fn(&Payload) -> Option<Vec<V>>,
) -> Option<Vec<V>> {
    let bytes = match c.case.files.load(path) {
        Ok(bytes) => bytes,
        Err(e) => {
            let message = format!("cannot read `{path}`: {e}");
            r.error_at_key("type", message, "takes its values from there", None);
            return None;
        }
    };
    let (_, payload, diags) = parse_list_file(Source::new(path, bytes));
    let bad = diags.iter().any(|d| d.severity == Severity::Error);
    r.sink().extend(diags);
    if bad {
        return None;
    }
    let found = of(&payload).filter(|v| !v.is_empty());
    if found.is_none() {
        let message = format!("this list has the wrong type: {}", payload.describe());
        r.sink().push(Diag::file(path, message));
    }
    found
}

fn vectors(p: &Payload) -> Option<Vec<Vec3>> {
    of_type::<Vec3>(p)
}

fn of_type<T: Value>(p: &Payload) -> Option<Vec<T>> {
    let one = crate::time_function::of_components::<T>;
    match p {
        Payload::Scalars(x) if T::N == 1 => Some(x.iter().map(|x| one(&[*x])).collect()),
        Payload::Labels(x) if T::N == 1 => Some(x.iter().map(|x| one(&[*x as f64])).collect()),
        Payload::Vectors(x) if T::N == 3 => Some(x.iter().map(|x| one(x)).collect()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use crate::conditions::testing::*;
    use crate::conditions::{CaseContext, CaseFiles};
    use granflow_base::Vec3;
    use std::io;

    #[derive(Debug)]
    struct Data(Vec<(&'static str, String)>);
    impl CaseFiles for Data {
        fn load(&self, path: &str) -> io::Result<Vec<u8>> {
            let rest = path.strip_prefix("constant/boundaryData/inlet/").unwrap_or("");
            let found = self.0.iter().find(|f| f.0 == rest);
            found.map(|f| f.1.clone().into()).ok_or_else(|| io::ErrorKind::NotFound.into())
        }
        fn folders(&self, _: &str) -> io::Result<Vec<String>> {
            Ok(vec!["10".into(), "2".into(), "notes".into()])
        }
    }
    /// The corners and the middle of the patch, with the plane `u = 1 + 2 y - z` at 2 s and ten
    /// times that at 10 s.
    fn plane() -> Data {
        let at = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [0.0, 1.0], [1.0, 1.0]];
        let list = |item: &dyn Fn(f64, f64) -> String| {
            let items: Vec<String> = at.iter().map(|[y, z]| item(*y, *z)).collect();
            format!("(\n{}\n)\n", items.join("\n"))
        };
        let u = |k: f64| list(&move |y, z| format!("({} 0 0)", k * (1.0 + 2.0 * y - z)));
        let p = list(&|y, _| format!("{y}"));
        Data(vec![
            ("points", list(&|y, z| format!("(0.01 {y} {z})"))),
            ("2/f", u(1.0)),
            ("10/f", u(10.0)),
            ("2/p", p.clone()),
            ("10/p", p),
        ])
    }
    const TEXT: &str = "type timeVaryingMappedFixedValue; setAverage off; perturb 1e-5;";

    #[test]
    fn planes_are_met_between_points_and_times() {
        let data = plane();
        let case = CaseContext { files: &data, ..CaseContext::NONE };
        for (time, k) in [(0.0, 1.0), (2.0, 1.0), (6.0, 5.5), (10.0, 10.0), (99.0, 10.0)] {
            let text = format!("{TEXT} offset (0 1 0);");
            let probe = Probe::within::<Vec3>(&text, case).at(time);
            let mut found = probe.values([[9.0; 3]; 4]).map(|u| u[0] / k);
            found.sort_by(f64::total_cmp);
            for (f, e) in found.iter().zip([0.75, 1.25, 1.75, 2.25]) {
                assert!((f - e).abs() < 1e-12, "{time}: {found:?}");
            }
        }
        let text = format!("{TEXT} mapMethod nearest; fieldTable p;");
        let found = Probe::within::<f64>(&text, case).values([9.0; 4]);
        assert!(found.iter().all(|p| [0.0, 0.5, 1.0].contains(p)), "{found:?}");
    }

    #[test]
    fn what_is_missing_is_named() {
        let said = |data: &Data, text: &str| {
            let case = CaseContext { files: data, times: Some((0.0, 1.0)), ..CaseContext::NONE };
            mistakes_within::<Vec3>(text, case).to_string()
        };
        let mut data = plane();
        assert!(said(&data, TEXT).contains("the run begins at 0 s"));
        data.0[2].1 = "((1 0 0))".into();
        assert!(said(&data, TEXT).contains("1 values for the 5 points"));
        data.0[2].1 = "(1 2)".into();
        assert!(said(&data, TEXT).contains("inlet/10/f"));
        data.0.remove(0);
        assert!(said(&data, TEXT).contains("constant/boundaryData/inlet/points"));
        assert!(said(&data, &format!("{TEXT} setAverage on;")).contains("average"));
    }
}
