//! Cells cut by a plane.

use super::Grid;
use granflow_base::{Vec3, dot, sub};

/// A corner of a polygon: at `t` of the way between two points of the mesh.
pub(crate) type OnEdge = (u32, u32, f64);

/// A cell's section.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Polygon {
    pub(crate) cell: usize,
    pub(crate) corners: Vec<OnEdge>,
}

/// The sections of all cells with the plane through `point` with `normal`. A plane between two
/// layers of cells cuts the one behind it; on the boundary it shows the faces that lie in it.
pub(crate) fn cut(grid: &Grid, point: Vec3, normal: Vec3) -> Vec<Polygon> {
    let poly = &grid.poly;
    // Points that rounding keeps off the plane lie in it.
    let slack = 1e-9 * grid.size;
    let height: Vec<f64> = poly
        .points
        .iter()
        .map(|p| dot(sub(*p, point), normal))
        .map(|h| if h.abs() <= slack { 0.0 } else { h })
        .collect();
    let (start, faces) = &grid.cell_faces;
    let mut out = Vec::new();
    for cell in 0..poly.n_cells() {
        let own = &faces[start[cell] as usize..start[cell + 1] as usize];
        let points = || own.iter().flat_map(|f| poly.face(*f as usize >> 1));
        let below = points().any(|p| height[*p as usize] < 0.0);
        let above = points().any(|p| height[*p as usize] >= 0.0);
        if !below {
            // Nothing behind: only what lies in the plane and ends the mesh.
            for f in own.iter().map(|f| *f as usize >> 1).filter(|f| *f >= poly.n_inner()) {
                if poly.face(f).iter().all(|p| height[*p as usize] == 0.0) {
                    let corners = poly.face(f).iter().map(|p| (*p, *p, 0.0)).collect();
                    out.push(Polygon { cell, corners });
                }
            }
        } else if above {
            let steps = steps(grid, own, &height);
            out.extend(loops(steps).into_iter().filter_map(|l| {
                let mut corners: Vec<OnEdge> = l.into_iter().map(|e| corner(e, &height)).collect();
                corners.dedup();
                if corners.len() > 1 && corners.first() == corners.last() {
                    corners.pop();
                }
                (corners.len() > 2).then_some(Polygon { cell, corners })
            }));
        }
    }
    out
}

type Edge = (u32, u32);

/// From edge to edge over the faces of a cell, all with the cell on the same side.
fn steps(grid: &Grid, own: &[u32], height: &[f64]) -> Vec<(Edge, Edge)> {
    let mut out = Vec::new();
    for entry in own {
        let face = grid.poly.face(*entry as usize >> 1);
        let n = face.len();
        // Crossings in the order of the face's points, seen from outside the cell.
        let turned = entry & 1 == 1;
        let point = |i: usize| if turned { face[(2 * n - 1 - i) % n] } else { face[i % n] };
        let above = |p: u32| height[p as usize] >= 0.0;
        let crossings: Vec<(Edge, bool)> = (0..n)
            .map(|i| (point(i), point(i + 1)))
            .filter(|(a, b)| above(*a) != above(*b))
            .map(|(a, b)| ((a.min(b), a.max(b)), above(a)))
            .collect();
        for (i, (edge, down)) in crossings.iter().enumerate() {
            if *down {
                out.push((*edge, crossings[(i + 1) % crossings.len()].0));
            }
        }
    }
    out
}

/// Closed rounds through steps.
fn loops(mut steps: Vec<(Edge, Edge)>) -> Vec<Vec<Edge>> {
    let mut out = Vec::new();
    while let Some((first, mut at)) = steps.pop() {
        let mut round = vec![first];
        while at != first {
            round.push(at);
            let Some(i) = steps.iter().position(|s| s.0 == at) else { break };
            at = steps.swap_remove(i).1;
        }
        out.push(round);
    }
    out
}

fn corner((a, b): Edge, height: &[f64]) -> OnEdge {
    let (ha, hb) = (height[a as usize], height[b as usize]);
    match (ha == 0.0, hb == 0.0) {
        (true, _) => (a, a, 0.0),
        (_, true) => (b, b, 0.0),
        _ => (a, b, ha / (ha - hb)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_mesh::shapes;

    fn area(grid: &Grid, p: &Polygon) -> f64 {
        use granflow_base::{add, cross, norm, scale};
        let at = |c: &OnEdge| {
            let (a, b) = (grid.poly.points[c.0 as usize], grid.poly.points[c.1 as usize]);
            add(scale(a, 1.0 - c.2), scale(b, c.2))
        };
        let c: Vec<Vec3> = p.corners.iter().map(at).collect();
        let twice =
            (2..c.len()).map(|i| cross(sub(c[i - 1], c[0]), sub(c[i], c[0]))).fold([0.0; 3], add);
        0.5 * norm(twice)
    }

    #[test]
    fn a_box_is_cut_into_as_many_polygons_as_it_has_cells_there() {
        let grid = Grid::new(shapes::unit_box([4, 3, 5]));
        // Inside a layer, between two layers, on either end.
        for x in [0.4, 0.5, 0.0, 1.0] {
            let all = cut(&grid, [x, 0.0, 0.0], [1.0, 0.0, 0.0]);
            assert_eq!(all.len(), 15, "x = {x}");
            assert!(all.iter().all(|p| p.corners.len() == 4));
            assert!((all.iter().map(|p| area(&grid, p)).sum::<f64>() - 1.0).abs() < 1e-12);
        }
        assert!(cut(&grid, [1.1, 0.0, 0.0], [1.0, 0.0, 0.0]).is_empty());
    }

    #[test]
    fn any_plane_through_any_cells_leaves_no_gap() {
        // A hexagon: the section of a cube across its diagonal.
        let hexagon = 0.75 * 3f64.sqrt();
        let n = [3f64.sqrt().recip(); 3];
        for poly in [
            shapes::unit_box([5, 5, 5]),
            shapes::prism_box(
                [4, 4, 4],
                [0.0; 3],
                [1.0; 3],
                shapes::all(granflow_mesh::PatchKind::Wall),
            ),
        ] {
            let grid = Grid::new(poly);
            let all = cut(&grid, [0.5; 3], n);
            let sum: f64 = all.iter().map(|p| area(&grid, p)).sum();
            assert!((sum - hexagon).abs() < 1e-12, "{sum}");
        }
    }
}
