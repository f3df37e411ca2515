//! Are two meshes the same?

use super::foam_mesh::FoamMesh;
use std::collections::HashMap;

/// How far apart points may be, relative to the extent of the mesh.
const CLOSE: f64 = 1e-10;

/// How two meshes compare.
#[derive(Debug, PartialEq)]
pub(super) enum Verdict {
    /// The same points, faces, cells, patches and zones, in the same order.
    Same,
    /// The same but for the numbers of points, faces or cells.
    Renumbered,
    /// What differs.
    Differs(String),
}

/// Compares the second mesh with the first.
pub(super) fn compare(a: &FoamMesh, b: &FoamMesh) -> Verdict {
    let count = |m: &FoamMesh| (m.n_cells(), m.points.len(), m.faces.len(), m.neighbour.len());
    if count(a) != count(b) {
        let what = format!("cells, points, faces, inner faces {:?} and {:?}", count(a), count(b));
        return Verdict::Differs(what);
    }
    if a.patches != b.patches {
        let odd = a.patches.iter().zip(&b.patches).find(|(p, q)| p != q);
        return Verdict::Differs(match odd {
            Some((p, q)) => format!("patch {p:?} and {q:?}"),
            None => format!("{} patches and {}", a.patches.len(), b.patches.len()),
        });
    }
    let zones = |m: &FoamMesh| -> Vec<(String, usize)> {
        m.zones.iter().map(|(n, c)| (n.clone(), c.len())).collect()
    };
    if zones(a) != zones(b) {
        return Verdict::Differs(format!("zones {:?} and {:?}", zones(a), zones(b)));
    }
    let allowed = CLOSE * extent(a);
    let worst = a.points.iter().zip(&b.points).map(|(p, q)| apart(p, q)).fold(0.0, f64::max);
    if worst <= allowed && a.faces == b.faces && a.owner == b.owner && a.neighbour == b.neighbour {
        return match a.zones == b.zones {
            true => Verdict::Same,
            false => Verdict::Differs("the cells of a zone".into()),
        };
    }
    let Some(to_b) = matched(a, b, allowed.max(1e-300)) else {
        let at = (0..a.points.len())
            .find(|&i| apart(&a.points[i], &b.points[i]) > allowed)
            .unwrap_or_default();
        let far = worst / extent(a);
        return Verdict::Differs(format!(
            "points: {far:.1e} of the extent at most; first {at}: {:?} and {:?}",
            a.points[at], b.points[at]
        ));
    };
    same_faces(a, b, &to_b)
}

fn apart(p: &[f64; 3], q: &[f64; 3]) -> f64 {
    (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
}

fn extent(m: &FoamMesh) -> f64 {
    let side = |k: usize| {
        let x = || m.points.iter().map(|p| p[k]);
        x().fold(f64::MIN, f64::max) - x().fold(f64::MAX, f64::min)
    };
    (0..3).map(side).fold(0.0, f64::max)
}

/// For each point of `a` the one of `b` within `allowed`, each taken once.
fn matched(a: &FoamMesh, b: &FoamMesh, allowed: f64) -> Option<Vec<usize>> {
    let cell = |p: &[f64; 3]| p.map(|x| (x / (2.0 * allowed)).floor() as i64);
    let mut boxes: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (i, p) in b.points.iter().enumerate() {
        boxes.entry(cell(p)).or_default().push(i);
    }
    let mut taken = vec![false; b.points.len()];
    let mut out = Vec::with_capacity(a.points.len());
    for p in &a.points {
        let home = cell(p);
        let mut found = None;
        for k in 0..27 {
            let near = [home[0] + k % 3 - 1, home[1] + k / 3 % 3 - 1, home[2] + k / 9 - 1];
            let fit = |i: &&usize| !taken[**i] && apart(p, &b.points[**i]) <= allowed;
            found = found.or_else(|| boxes.get(&near).and_then(|l| l.iter().find(fit)).copied());
        }
        taken[found?] = true;
        out.push(found?);
    }
    Some(out)
}

/// A ring of points that begins with its smallest one.
fn turned(ring: &[usize]) -> Vec<usize> {
    let first = (0..ring.len()).min_by_key(|&i| ring[i]).unwrap_or(0);
    (0..ring.len()).map(|i| ring[(first + i) % ring.len()]).collect()
}

fn same_faces(a: &FoamMesh, b: &FoamMesh, to_b: &[usize]) -> Verdict {
    let mut of_b: HashMap<Vec<usize>, usize> = HashMap::new();
    for (f, ring) in b.faces.iter().enumerate() {
        of_b.insert(turned(ring), f);
    }
    let mut cells: Vec<Option<usize>> = vec![None; a.n_cells()];
    for (f, ring) in a.faces.iter().enumerate() {
        let here: Vec<usize> = ring.iter().map(|&p| to_b[p]).collect();
        let back: Vec<usize> = here.iter().rev().copied().collect();
        let (g, same_way) = match (of_b.get(&turned(&here)), of_b.get(&turned(&back))) {
            (Some(&g), _) => (g, true),
            (None, Some(&g)) => (g, false),
            _ => return Verdict::Differs(format!("face {f} {ring:?} has no counterpart")),
        };
        let sides = |m: &FoamMesh, f: usize| (m.owner[f], m.neighbour.get(f).copied());
        let (mine, mut theirs) = (sides(a, f), sides(b, g));
        if let (false, Some(n)) = (same_way, theirs.1) {
            theirs = (n, Some(theirs.0));
        }
        if mine.1.is_some() != theirs.1.is_some() || (mine.1.is_none() && !same_way) {
            return Verdict::Differs(format!("face {f} is turned or at the boundary in one mesh"));
        }
        let patch = |m: &FoamMesh, f: usize| {
            m.patches.iter().position(|p| (p.start..p.start + p.len).contains(&f))
        };
        if mine.1.is_none() && patch(a, f) != patch(b, g) {
            return Verdict::Differs(format!("face {f} belongs to another patch"));
        }
        let pairs = [(Some(mine.0), Some(theirs.0)), (mine.1, theirs.1)];
        for (x, y) in pairs {
            let (Some(x), Some(y)) = (x, y) else { continue };
            if *cells[x].get_or_insert(y) != y {
                return Verdict::Differs(format!("cell {x} has faces of two cells"));
            }
        }
    }
    Verdict::Renumbered
}

#[cfg(test)]
mod tests {
    use super::super::foam_mesh::Patch;
    use super::*;

    /// Two unit cubes in a row, their outer faces in one patch.
    fn two_cubes() -> FoamMesh {
        let mut m = FoamMesh::default();
        for x in 0..3 {
            for (y, z) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                m.points.push([f64::from(x), f64::from(y), f64::from(z)]);
            }
        }
        m.faces = vec![vec![4, 5, 6, 7], vec![0, 3, 2, 1], vec![8, 9, 10, 11]];
        m.owner = vec![0, 0, 1];
        m.neighbour = vec![1];
        for x in [0, 4] {
            for i in 0..4 {
                let j = (i + 1) % 4;
                m.faces.push(vec![x + i, x + j, x + 4 + j, x + 4 + i]);
                m.owner.push(x / 4);
            }
        }
        let len = m.faces.len() - 1;
        m.patches.push(Patch { name: "all".into(), kind: "wall".into(), len, start: 1 });
        m
    }

    #[test]
    fn numbers_may_differ_and_nothing_else() {
        let a = two_cubes();
        assert_eq!(compare(&a, &a), Verdict::Same);
        let mut b = a.clone();
        b.points.swap(0, 11);
        for p in b.faces.iter_mut().flatten() {
            *p = match *p {
                0 => 11,
                11 => 0,
                p => p,
            };
        }
        assert_eq!(compare(&a, &b), Verdict::Renumbered);
        b.points[3][0] += 1e-6;
        assert!(matches!(compare(&a, &b), Verdict::Differs(_)));
        let mut c = a.clone();
        c.owner[2] = 0;
        assert!(matches!(compare(&a, &c), Verdict::Differs(_)));
        let mut d = a.clone();
        d.faces[2].reverse();
        assert!(matches!(compare(&a, &d), Verdict::Differs(_)));
    }
}
