//! Cell numbering for short memory strides.

use crate::polymesh::{PolyMesh, PolyPatch};

/// Where the cells and faces of a renumbered mesh came from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Renumbering {
    /// Old cell of every new cell.
    pub cells: Vec<u32>,
    /// Old face of every new face: `face << 1`, plus 1 when it was turned round.
    pub faces: Vec<u32>,
}

impl Renumbering {
    /// Values in the new order from values in the old one.
    pub fn to_new<T: Copy>(&self, old: &[T]) -> Vec<T> {
        self.cells.iter().map(|&c| old[c as usize]).collect()
    }
    /// Values in the old order from values in the new one.
    pub fn to_old<T: Copy + Default>(&self, new: &[T]) -> Vec<T> {
        let mut old = vec![T::default(); self.cells.len()];
        self.cells.iter().zip(new).for_each(|(&c, &v)| old[c as usize] = v);
        old
    }
}

/// Numbers the cells by reverse Cuthill-McKee (Cuthill & McKee, Proc. 24th ACM Conf., 1969), then
/// the inner faces by owner and neighbour. Points, patches and the order of faces within a patch
/// stay. The mesh must be valid ([`PolyMesh::validate`]).
pub fn renumber(poly: &PolyMesh) -> (PolyMesh, Renumbering) {
    let cells = reverse_cuthill_mckee(poly);
    let mut new_of_old = vec![0u32; cells.len()];
    cells.iter().enumerate().for_each(|(n, &o)| new_of_old[o as usize] = n as u32);

    let n_inner = poly.n_inner();
    let mut inner: Vec<(u32, u32, u32)> = (0..n_inner)
        .map(|f| {
            let (o, n) =
                (new_of_old[poly.owner[f] as usize], new_of_old[poly.neighbour[f] as usize]);
            let turned = u32::from(o > n);
            (o.min(n), o.max(n), (f as u32) << 1 | turned)
        })
        .collect();
    inner.sort_unstable();
    let mut faces: Vec<u32> = inner.iter().map(|x| x.2).collect();
    faces.extend((n_inner..poly.n_faces()).map(|f| (f as u32) << 1));

    let mut new = PolyMesh {
        points: poly.points.clone(),
        face_ptr: Vec::with_capacity(poly.face_ptr.len()),
        face_points: Vec::with_capacity(poly.face_points.len()),
        owner: inner.iter().map(|x| x.0).collect(),
        neighbour: inner.iter().map(|x| x.1).collect(),
        patches: poly.patches.iter().map(PolyPatch::clone).collect(),
        cell_zones: poly.cell_zones.clone(),
    };
    for zone in &mut new.cell_zones {
        zone.cells.iter_mut().for_each(|c| *c = new_of_old[*c as usize]);
        zone.cells.sort_unstable();
    }
    new.owner.extend(poly.owner[n_inner..].iter().map(|&c| new_of_old[c as usize]));
    let mut turned = Vec::new();
    for &e in &faces {
        let points = poly.face((e >> 1) as usize);
        if e & 1 == 0 {
            new.push_face(points);
        } else {
            // Same first point, other way round.
            turned.clear();
            turned.extend_from_slice(&points[..1]);
            turned.extend(points[1..].iter().rev());
            new.push_face(&turned);
        }
    }
    (new, Renumbering { cells, faces })
}

/// Old cell of every new cell.
fn reverse_cuthill_mckee(poly: &PolyMesh) -> Vec<u32> {
    let (ptr, links) = poly.cell_faces();
    let n_cells = ptr.len() - 1;
    let around = |c: u32| {
        let links = &links[ptr[c as usize] as usize..ptr[c as usize + 1] as usize];
        links.iter().filter_map(|&e| {
            let f = (e >> 1) as usize;
            let n = *poly.neighbour.get(f)?;
            Some(if e & 1 == 0 { n } else { poly.owner[f] })
        })
    };
    let degree: Vec<u32> = (0..n_cells as u32).map(|c| around(c).count() as u32).collect();
    let mut order: Vec<u32> = Vec::with_capacity(n_cells);
    let mut placed = vec![false; n_cells];
    let mut next = Vec::new();
    let mut first_free = 0;
    // Breadth-first from `start`, low degree first; returns the last cell reached.
    let mut sweep = |start: u32, placed: &mut [bool], order: &mut Vec<u32>| {
        let mut at = order.len();
        order.push(start);
        placed[start as usize] = true;
        while let Some(&c) = order.get(at) {
            at += 1;
            next.clear();
            next.extend(around(c).filter(|&n| !placed[n as usize]));
            next.sort_unstable_by_key(|&n| (degree[n as usize], n));
            next.dedup();
            next.iter().for_each(|&n| placed[n as usize] = true);
            order.extend_from_slice(&next);
        }
    };
    while order.len() < n_cells {
        while placed[first_free] {
            first_free += 1;
        }
        // The far end of the component, found by two trial sweeps, makes narrow levels.
        let mut start = first_free as u32;
        let from = order.len();
        for _ in 0..2 {
            sweep(start, &mut placed, &mut order);
            start = order[order.len() - 1];
            order.drain(from..).for_each(|c| placed[c as usize] = false);
        }
        sweep(start, &mut placed, &mut order);
    }
    order.reverse();
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Geometry, shapes};
    use granflow_base::{norm, sub};

    fn bandwidth(m: &PolyMesh) -> u32 {
        m.neighbour.iter().zip(&m.owner).map(|(n, o)| n - o).max().unwrap_or(0)
    }

    #[test]
    fn geometry_survives_and_bandwidth_shrinks() {
        let ordered = shapes::unit_box([8, 5, 3]);
        let messy = shapes::shuffled(&ordered, 7);
        let (tidy, map) = renumber(&messy);
        assert_eq!(tidy.validate(), Ok(()));
        assert!(bandwidth(&tidy) <= 20 && bandwidth(&messy) > 60);
        let (old, new) = (Geometry::new(&messy), Geometry::new(&tidy));
        for (n, &o) in map.cells.iter().enumerate() {
            assert!(norm(sub(new.cell_centre[n], old.cell_centre[o as usize])) < 1e-15);
        }
        for (n, &e) in map.faces.iter().enumerate() {
            let s = if e & 1 == 0 { 1.0 } else { -1.0 };
            let old = old.area[(e >> 1) as usize].map(|a| s * a);
            assert!(norm(sub(new.area[n], old)) < 1e-15);
        }
        let sorted = |m: &PolyMesh| {
            let pairs: Vec<_> = m.owner.iter().zip(&m.neighbour).collect();
            pairs.is_sorted() && pairs.iter().all(|(o, n)| o < n)
        };
        assert!(sorted(&tidy));
        let values: Vec<f64> = (0..120).map(f64::from).collect();
        assert_eq!(map.to_old(&map.to_new(&values)), values);
    }

    #[test]
    fn separate_pieces_are_all_numbered() {
        let m = shapes::two_boxes([3, 2, 1]);
        let (tidy, map) = renumber(&m);
        assert_eq!(tidy.validate(), Ok(()));
        let mut cells = map.cells;
        cells.sort_unstable();
        assert!(cells.iter().enumerate().all(|(i, &c)| i as u32 == c));
    }
}
