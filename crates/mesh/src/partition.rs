//! Recursive coordinate bisection.

use crate::geometry::Geometry;
use crate::polymesh::PolyMesh;
use granflow_base::Vec3;

/// Rank of every cell: the mesh is halved again and again across its longest extent, in
/// proportion to the ranks on each side (Berger & Bokhari, IEEE Trans. Computers 36, 1987).
///
/// Parts differ by at most one cell a cut and do not depend on the order of the points.
/// Ranks beyond the number of cells stay empty.
pub fn partition(poly: &PolyMesh, ranks: usize) -> Vec<u32> {
    let centre = Geometry::new(poly).cell_centre;
    let mut part = vec![0; centre.len()];
    let mut cells: Vec<u32> = (0..centre.len() as u32).collect();
    bisect(&centre, &mut cells, 0, ranks.max(1), &mut part);
    part
}

fn bisect(centre: &[Vec3], cells: &mut [u32], first: usize, ranks: usize, part: &mut [u32]) {
    if ranks == 1 || cells.is_empty() {
        cells.iter().for_each(|&c| part[c as usize] = first as u32);
        return;
    }
    let along = longest(centre, cells);
    let left = ranks / 2;
    let at = cells.len() * left / ranks;
    // Ties broken by number: the cut is the same on every machine.
    if at > 0 {
        cells.select_nth_unstable_by(at, |&a, &b| {
            let x = |c: u32| centre[c as usize][along];
            x(a).total_cmp(&x(b)).then(a.cmp(&b))
        });
    }
    let (low, high) = cells.split_at_mut(at);
    bisect(centre, low, first, left, part);
    bisect(centre, high, first + left, ranks - left, part);
}

/// Axis of the largest extent of the cells' centres.
fn longest(centre: &[Vec3], cells: &[u32]) -> usize {
    let mut lo = [f64::INFINITY; 3];
    let mut hi = [f64::NEG_INFINITY; 3];
    for &c in cells {
        for d in 0..3 {
            lo[d] = lo[d].min(centre[c as usize][d]);
            hi[d] = hi[d].max(centre[c as usize][d]);
        }
    }
    let extent = |d: usize| hi[d] - lo[d];
    // The first of equals, so that rounding noise in a square box does not choose.
    let longest = (0..3).map(extent).fold(0.0, f64::max);
    (0..3).find(|&d| extent(d) >= longest * (1.0 - 1e-9)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    #[test]
    fn parts_are_even_and_compact() {
        let poly = shapes::unit_box([12, 6, 2]);
        for ranks in [1, 2, 3, 5, 7] {
            let part = partition(&poly, ranks);
            let mut count = vec![0usize; ranks];
            part.iter().for_each(|&r| count[r as usize] += 1);
            let (lo, hi) = (count.iter().min().unwrap(), count.iter().max().unwrap());
            assert!(hi - lo <= 2, "{count:?}");
        }
        // Two ranks: one plane of 12 faces is cut.
        let part = partition(&poly, 2);
        let cut = (0..poly.n_inner())
            .filter(|&f| part[poly.owner[f] as usize] != part[poly.neighbour[f] as usize])
            .count();
        assert_eq!(cut, 12);
    }
}
