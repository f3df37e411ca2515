//! A plane mesh of triangles and other polygons becomes one layer of cells.

use super::assemble::area;
use super::elements::{Elements, Rings, Volumes};
use crate::polymesh::{PatchKind, place, short};
use granflow_base::Vec3;

/// How far points may lie off their plane, relative to the extent.
const FLAT: f64 = 1e-6;

/// Surfaces become cells, lines faces of patches, groups of surfaces zones. Returns what to tell
/// the user.
pub(super) fn extrude(elements: &mut Elements, thickness: Option<f64>) -> Result<String, String> {
    if elements.surfaces.len() == 0 {
        return Err("the file holds neither volume nor surface elements".into());
    }
    let used: Vec<Vec3> = elements
        .surfaces
        .iter()
        .flat_map(|(ring, _)| ring.iter().map(|&p| elements.points[p as usize]))
        .collect();
    let range = |k: usize| {
        let low = used.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
        (low, used.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max) - low)
    };
    let ranges = [0, 1, 2].map(range);
    let extent = ranges.iter().map(|r| r.1).fold(0.0, f64::max);
    let Some(axis) = (0..3).find(|&k| ranges[k].1 <= FLAT * extent) else {
        let [a, b, c] = ranges.map(|r| short(r.1));
        return Err(format!(
            "the surface elements are no plane mesh normal to x, y or z (extents {a}, {b} and {c}), \
             and there are no volume elements"
        ));
    };
    let thickness = thickness.unwrap_or(0.1 * extent);
    let n = elements.points.len() as u32;
    // All of one plane, so that the empty faces lie along the axis to the last bit.
    for k in 0..n as usize {
        elements.points[k][axis] = ranges[axis].0;
    }
    let mut above = elements.points.clone();
    above.iter_mut().for_each(|p| p[axis] += thickness);

    let (mut volumes, mut surfaces) = (Volumes::default(), Rings::default());
    elements.groups[2] = std::mem::take(&mut elements.groups[1]);
    elements.groups[1] = std::mem::take(&mut elements.groups[0]);
    for (line, group) in elements.lines.iter().filter(|l| l.0.len() == 2) {
        surfaces.push(&[line[0], line[1], line[1] + n, line[0] + n], group);
    }
    let name = elements.front_and_back.unwrap_or("frontAndBack");
    let old = std::mem::take(&mut elements.surfaces);
    let sides = elements.group(2, name, Some(PatchKind::Empty));
    for (ring, group) in old.iter() {
        let mut base = ring.to_vec();
        let vector = area(&elements.points, ring);
        if vector[axis] < 0.0 {
            base.reverse();
        }
        if vector[axis] == 0.0 {
            let at = place(elements.points[ring[0] as usize]);
            return Err(format!("an element at {at} has no area"));
        }
        let top: Vec<u32> = base.iter().map(|p| p + n).collect();
        let low: Vec<u32> = base.iter().rev().copied().collect();
        let mut faces = vec![low, top];
        for (i, &p) in base.iter().enumerate() {
            let q = base[(i + 1) % base.len()];
            faces.push(vec![p, q, q + n, p + n]);
        }
        surfaces.push(&faces[0], sides);
        surfaces.push(&faces[1], sides);
        volumes.push(faces.iter().map(Vec::as_slice), group);
    }
    elements.points.extend(above);
    elements.lines = Rings::default();
    (elements.volumes, elements.surfaces) = (volumes, surfaces);
    let letter = ["x", "y", "z"][axis];
    let t = short(thickness);
    Ok(format!("a plane mesh: made one cell thick, {t} m along {letter}, between `{name}` (empty)"))
}
