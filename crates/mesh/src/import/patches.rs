//! Names, kinds and pieces of patches.

use super::assemble::area;
use crate::polymesh::PatchKind;
use granflow_base::{Vec3, dot, unit};
use std::collections::HashMap;

/// A name as a dictionary can hold it.
pub(super) fn safe(name: &str) -> String {
    let fits = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | ':' | '+');
    let out: String = name.trim().chars().map(|c| if fits(c) { c } else { '_' }).collect();
    if out.is_empty() { "unnamed".into() } else { out }
}

/// The kind that a name suggests.
pub(super) fn kind_of(name: &str) -> Option<PatchKind> {
    let name = name.to_lowercase();
    if name.contains("wall") {
        Some(PatchKind::Wall)
    } else if name == "frontandback" || name == "empty" {
        Some(PatchKind::Empty)
    } else if name.starts_with("symmetry") {
        Some(PatchKind::Symmetry)
    } else {
        None
    }
}

/// Splits faces along edges where their normals turn by more than `angle`, degrees. The pieces and
/// the faces in them keep their order.
pub(super) fn split<'f>(
    points: &[Vec3],
    faces: &[(u32, &'f [u32])],
    angle: f64,
) -> Vec<Vec<(u32, &'f [u32])>> {
    let least = angle.to_radians().cos();
    let normals: Vec<Vec3> = faces.iter().map(|f| unit(area(points, f.1))).collect();
    let mut up: Vec<usize> = (0..faces.len()).collect();
    fn root(up: &mut [usize], mut i: usize) -> usize {
        while up[i] != i {
            up[i] = up[up[i]];
            i = up[i];
        }
        i
    }
    let mut edges: HashMap<(u32, u32), usize> = HashMap::new();
    for (i, (_, ring)) in faces.iter().enumerate() {
        for (k, &p) in ring.iter().enumerate() {
            let q = ring[(k + 1) % ring.len()];
            let Some(j) = edges.insert((p.min(q), p.max(q)), i) else { continue };
            if dot(normals[i], normals[j]) >= least {
                let (a, b) = (root(&mut up, i), root(&mut up, j));
                up[a.max(b)] = a.min(b);
            }
        }
    }
    let mut number: HashMap<usize, usize> = HashMap::new();
    let mut parts: Vec<Vec<(u32, &[u32])>> = Vec::new();
    for (i, face) in faces.iter().enumerate() {
        let n = *number.entry(root(&mut up, i)).or_insert(parts.len());
        if n == parts.len() {
            parts.push(Vec::new());
        }
        parts[n].push(*face);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_suggest_kinds_and_are_made_fit_for_dictionaries() {
        assert_eq!(kind_of("outerWall"), Some(PatchKind::Wall));
        assert_eq!(kind_of("inlet"), None);
        assert_eq!(safe(" hot plate {1} "), "hot_plate__1_");
        assert_eq!(safe(""), "unnamed");
    }
}
