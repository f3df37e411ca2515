//! Elements to a [`PolyMesh`].

use super::elements::{Elements, NONE, Volumes};
use super::patches::{kind_of, safe, split};
use crate::polymesh::{CellZone, PatchKind, PolyMesh, PolyPatch, place};
use granflow_base::{Vec3, add, cross, dot, scale, sub};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Name of the patch of faces that no group names.
const DEFAULT: &str = "defaultFaces";

/// The four smallest points of a face: all of a triangle or a quadrilateral, and of a larger one
/// more than two faces of a mesh have in common.
type Key = [u32; 4];

fn key(ring: &[u32]) -> Key {
    let mut least = [NONE; 4];
    for &p in ring {
        let at = least.partition_point(|&q| q < p);
        if at < 4 {
            least[at..].rotate_right(1);
            least[at] = p;
        }
    }
    least
}

/// Puts the cells together. `notes` gets what the user ought to know.
pub(super) fn assemble(
    mut elements: Elements,
    feature_angle: Option<f64>,
    notes: &mut Vec<String>,
) -> Result<PolyMesh, String> {
    if elements.volumes.is_empty() {
        return Err("the mesh has no cells".into());
    }
    turn_outwards(&elements.points, &mut elements.volumes);
    let sides = sides(&elements)?;
    let mut poly = PolyMesh { face_ptr: vec![0], ..PolyMesh::default() };
    inner_faces(&elements, &sides, &mut poly);
    boundary(&elements, &sides, feature_angle, &mut poly, notes);
    zones(&elements, &mut poly);
    keep_used_points(&elements.points, &mut poly);
    Ok(poly)
}

/// Six times the volume within faces.
fn volume<'f>(points: &[Vec3], faces: impl Iterator<Item = &'f [u32]>) -> f64 {
    let mut origin = None;
    let mut sum = 0.0;
    for face in faces {
        let o = *origin.get_or_insert(points[face[0] as usize]);
        let at = |i: usize| sub(points[face[i] as usize], o);
        sum += (1..face.len().saturating_sub(1))
            .map(|i| dot(at(0), cross(at(i), at(i + 1))))
            .sum::<f64>();
    }
    sum
}

/// Files may number the corners of a cell either way round.
fn turn_outwards(points: &[Vec3], volumes: &mut Volumes) {
    for c in 0..volumes.len() {
        if volume(points, volumes.faces(c)) < 0.0 {
            volumes.flip(c);
        }
    }
}

/// The cells on either side of every face; the second is [`NONE`] at the boundary.
fn sides(elements: &Elements) -> Result<HashMap<Key, [u32; 2]>, String> {
    let mut sides: HashMap<Key, [u32; 2]> = HashMap::with_capacity(3 * elements.volumes.len());
    for c in 0..elements.volumes.len() {
        for ring in elements.volumes.faces(c) {
            let at = || place(elements.points[ring[0] as usize]);
            if ring.len() < 3 {
                return Err(format!("cell {c} at {} has a face of {} points", at(), ring.len()));
            }
            match sides.entry(key(ring)) {
                Entry::Vacant(e) => {
                    e.insert([c as u32, NONE]);
                }
                Entry::Occupied(mut e) => match e.get() {
                    [a, NONE] if *a != c as u32 => {
                        e.get_mut()[1] = c as u32;
                    }
                    [a, b] => {
                        let others = match *b {
                            NONE => format!("cell {a} has it twice"),
                            b => format!("cells {a}, {b} and {c} share it"),
                        };
                        return Err(format!(
                            "a face at {} has more than two cells ({others}): cells overlap or \
                             are there twice",
                            at()
                        ));
                    }
                },
            }
        }
    }
    Ok(sides)
}

fn inner_faces(elements: &Elements, sides: &HashMap<Key, [u32; 2]>, poly: &mut PolyMesh) {
    for c in 0..elements.volumes.len() {
        let own = c as u32;
        let beyond = |ring: &[u32]| sides.get(&key(ring)).map_or(NONE, |s| s[1]);
        let mut found: Vec<(u32, &[u32])> = elements
            .volumes
            .faces(c)
            .map(|ring| (beyond(ring), ring))
            .filter(|&(n, _)| n != NONE && n > own)
            .collect();
        found.sort_by_key(|f| f.0);
        for (n, ring) in found {
            poly.push_face(ring);
            poly.owner.push(own);
            poly.neighbour.push(n);
        }
    }
}

fn boundary(
    elements: &Elements,
    sides: &HashMap<Key, [u32; 2]>,
    feature_angle: Option<f64>,
    poly: &mut PolyMesh,
    notes: &mut Vec<String>,
) {
    let mut named: HashMap<Key, u32> = HashMap::with_capacity(elements.surfaces.len());
    let groups = &elements.groups[1];
    let (mut inside, mut astray) = (vec![0usize; groups.len()], 0usize);
    for (ring, group) in elements.surfaces.iter() {
        match sides.get(&key(ring)) {
            Some([_, NONE]) => {
                named.insert(key(ring), group);
            }
            Some(_) if group != NONE => inside[group as usize] += 1,
            Some(_) => {}
            None => astray += 1,
        }
    }
    let mut faces: Vec<Vec<(u32, &[u32])>> = vec![Vec::new(); groups.len() + 1];
    for c in 0..elements.volumes.len() {
        for ring in elements.volumes.faces(c) {
            if sides.get(&key(ring)).is_some_and(|s| s[1] == NONE) {
                let group = named.get(&key(ring)).copied().unwrap_or(NONE);
                faces[(group as usize).min(groups.len())].push((c as u32, ring));
            }
        }
    }
    let rest = faces.pop().unwrap_or_default();
    for ((group, faces), inside) in groups.iter().zip(faces).zip(inside) {
        if inside > 0 {
            let name = &group.name;
            notes.push(format!("{inside} faces of `{name}` lie inside the mesh: left as they are"));
        }
        if faces.is_empty() && inside > 0 {
            continue;
        }
        let (name, guessed) = (safe(&group.name), kind_of(&group.name));
        if let (None, Some(kind)) = (&group.kind, &guessed) {
            notes.push(format!("patch `{name}` is of type {} by its name", kind.word()));
        }
        let kind = group.kind.clone().or(guessed).unwrap_or(PatchKind::Patch);
        push_patch(poly, &name, kind, &faces);
    }
    if astray > 0 {
        notes.push(format!("{astray} surface elements are no faces of cells: left out"));
    }
    let parts = match feature_angle {
        Some(angle) => split(&elements.points, &rest, angle),
        None => vec![rest],
    };
    let many = parts.len() > 1;
    for (i, part) in parts.iter().enumerate().filter(|(_, p)| !p.is_empty()) {
        let name = if many { format!("{DEFAULT}{i}") } else { DEFAULT.to_owned() };
        push_patch(poly, &name, PatchKind::Patch, part);
    }
}

fn push_patch(poly: &mut PolyMesh, name: &str, kind: PatchKind, faces: &[(u32, &[u32])]) {
    let start = poly.owner.len();
    for (c, ring) in faces {
        poly.push_face(ring);
        poly.owner.push(*c);
    }
    let mut name = name.to_owned();
    while poly.patch(&name).is_some() {
        name.push('_');
    }
    poly.patches.push(PolyPatch { name, kind, start, len: faces.len(), in_groups: Vec::new() });
}

fn zones(elements: &Elements, poly: &mut PolyMesh) {
    for (g, group) in elements.groups[2].iter().enumerate() {
        let of = |c: &u32| elements.volumes.group[*c as usize] == g as u32;
        let cells: Vec<u32> = (0..elements.volumes.len() as u32).filter(of).collect();
        if !cells.is_empty() {
            poly.cell_zones.push(CellZone { name: safe(&group.name), cells });
        }
    }
}

fn keep_used_points(points: &[Vec3], poly: &mut PolyMesh) {
    let mut label = vec![NONE; points.len()];
    poly.face_points.iter().for_each(|&p| label[p as usize] = 0);
    for (p, label) in label.iter_mut().enumerate().filter(|(_, l)| **l != NONE) {
        *label = poly.points.len() as u32;
        poly.points.push(points[p]);
    }
    poly.face_points.iter_mut().for_each(|p| *p = label[*p as usize]);
}

/// The area vector of a ring of points, m2.
pub(super) fn area(points: &[Vec3], ring: &[u32]) -> Vec3 {
    let at = |i: usize| sub(points[ring[i] as usize], points[ring[0] as usize]);
    let of = |i: usize| cross(at(i), at(i + 1));
    scale((1..ring.len().saturating_sub(1)).map(of).fold([0.0; 3], add), 0.5)
}
