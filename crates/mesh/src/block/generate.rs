//! Blocks to cells and faces.

use super::points::points;
use super::topology::{Side, Topology, Walk};
use super::{Block, BlockMesh, FACES};
use crate::polymesh::{CellZone, PolyMesh, PolyPatch, place, short};
use granflow_base::{Vec3, norm, sub};
use granflow_dict::Diag;

/// Greatest gap between points that two blocks share, relative to their spacing.
const FIT: f64 = 0.01;

/// Labels of merged points, the smallest of each set standing for it.
struct Merged(Vec<u32>);

impl Merged {
    fn root(&mut self, mut p: u32) -> u32 {
        while self.0[p as usize] != p {
            let up = self.0[self.0[p as usize] as usize];
            self.0[p as usize] = up;
            p = up;
        }
        p
    }
    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a as u32), self.root(b as u32));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// First point and first cell of every block.
struct Offsets {
    point: Vec<usize>,
    cell: Vec<usize>,
}

pub(super) fn generate(mesh: &BlockMesh, topology: &Topology) -> Result<PolyMesh, Vec<Diag>> {
    let mut offsets = Offsets { point: vec![0], cell: vec![0] };
    for b in &mesh.blocks {
        let count = |n: [usize; 3]| n.iter().try_fold(1usize, |a, &b| a.checked_mul(b));
        let points = count(b.n_points()).filter(|&n| n < 1 << 28);
        let (Some(points), last) = (points, offsets.point[offsets.point.len() - 1]) else {
            return Err(vec![Diag::error(&b.span, "too many cells for 32-bit numbering")]);
        };
        if last + points >= 1 << 29 {
            return Err(vec![Diag::error(&b.span, "too many cells for 32-bit numbering")]);
        }
        offsets.point.push(last + points);
        offsets.cell.push(offsets.cell[offsets.cell.len() - 1] + b.n_cells());
    }
    let mut raw: Vec<Vec3> = Vec::with_capacity(offsets.point[mesh.blocks.len()]);
    let mut faults = Vec::new();
    for b in 0..mesh.blocks.len() {
        match points(mesh, b) {
            Ok(p) => raw.extend(p),
            Err(d) => faults.push(d),
        }
    }
    if !faults.is_empty() {
        faults.dedup_by(|a, b| a.span == b.span);
        return Err(faults);
    }
    let mut merged = Merged((0..raw.len() as u32).collect());
    collapse(mesh, &offsets, &mut merged);
    merge_joints(mesh, topology, &offsets, &raw, &mut merged, &mut faults);
    if !faults.is_empty() {
        return Err(faults);
    }
    let mut label = vec![0u32; raw.len()];
    let mut kept = Vec::new();
    for p in 0..raw.len() {
        let root = merged.root(p as u32) as usize;
        if root == p {
            label[p] = kept.len() as u32;
            kept.push(raw[p]);
        } else {
            label[p] = label[root];
            // Of blocks that differ in rounding the last one is right, as in OpenFOAM's tool.
            kept[label[p] as usize] = raw[p];
        }
    }
    let cells = Cells { mesh, topology, offsets, label };
    let mut poly = PolyMesh { points: kept, face_ptr: vec![0], ..PolyMesh::default() };
    cells.inner_faces(&mut poly);
    cells.patches(&mut poly);
    cells.zones(&mut poly);
    Ok(poly)
}

/// Merges points along edges and sides whose corners coincide.
fn collapse(mesh: &BlockMesh, offsets: &Offsets, merged: &mut Merged) {
    for (b, block) in mesh.blocks.iter().enumerate() {
        for (s, corners) in FACES.iter().enumerate() {
            let v = block.side(s);
            let walk = Walk::new(corners, block.n_points());
            let [nu, nv] = walk.n;
            let mut join = |p: (usize, usize), q: (usize, usize)| {
                let at = |(u, v)| offsets.point[b] + block.point(walk.at(u, v));
                merged.join(at(p), at(q));
            };
            // Lines along u or v shrink to a point: at one end, or everywhere if at both.
            let (low, high) = (v[0] == v[1], v[3] == v[2]);
            for row in lines(low, high, nv) {
                (1..nu).for_each(|u| join((0, row), (u, row)));
            }
            let (low, high) = (v[0] == v[3], v[1] == v[2]);
            for row in lines(low, high, nu) {
                (1..nv).for_each(|v| join((row, 0), (row, v)));
            }
        }
    }
}

fn lines(low: bool, high: bool, n: usize) -> std::ops::Range<usize> {
    match (low, high) {
        (true, true) => 0..n,
        (true, false) => 0..1,
        (false, true) => n - 1..n,
        (false, false) => 0..0,
    }
}

/// Merges the points of sides that two blocks share; they must lie on each other.
fn merge_joints(
    mesh: &BlockMesh,
    topology: &Topology,
    offsets: &Offsets,
    raw: &[Vec3],
    merged: &mut Merged,
    faults: &mut Vec<Diag>,
) {
    for j in &topology.joints {
        let walk = [0, 1].map(|i| Walk::new(&j.corners[i], mesh.blocks[j.sides[i].0].n_points()));
        let at = |i: usize, u: usize, v: usize| {
            let b = j.sides[i].0;
            offsets.point[b] + mesh.blocks[b].point(walk[i].at(u, v))
        };
        let [nu, nv] = walk[0].n;
        let (mut worst, mut place_of, mut spacing) = (0.0, [0.0; 3], f64::INFINITY);
        for v in 0..nv {
            for u in 0..nu {
                let (p, q) = (at(0, u, v), at(1, u, v));
                merged.join(p, q);
                let gap = norm(sub(raw[p], raw[q]));
                if gap > worst {
                    (worst, place_of) = (gap, raw[q]);
                }
                let near = |other: usize| norm(sub(raw[p], raw[other]));
                for h in
                    [(u > 0).then(|| near(at(0, u - 1, v))), (v > 0).then(|| near(at(0, u, v - 1)))]
                {
                    // Collapsed lines have no spacing to compare with.
                    spacing = h.filter(|&h| h > 1e-14).map_or(spacing, |h| spacing.min(h));
                }
            }
        }
        if worst > FIT * spacing {
            let [(a, _), (b, _)] = j.sides;
            let text = format!("blocks {a} and {b} do not fit along their common side");
            let label = format!(
                "points differ by {} m at {}, where cells measure {} m",
                short(worst),
                place(place_of),
                short(spacing)
            );
            let help =
                "give both blocks the same grading along that side, seen in the same direction";
            faults.push(Diag::error(&mesh.blocks[b].span, text).label(label).help(help));
        }
    }
}

struct Cells<'m> {
    mesh: &'m BlockMesh,
    topology: &'m Topology,
    offsets: Offsets,
    label: Vec<u32>,
}

impl Cells<'_> {
    /// Points of a cell's side, without repetitions.
    fn side_points(&self, b: usize, at: [usize; 3], s: usize) -> Vec<u32> {
        let block = &self.mesh.blocks[b];
        let corner = |v: usize| {
            let c = super::CORNERS[v];
            let p = block.point(std::array::from_fn(|d| at[d] + c[d]));
            self.label[self.offsets.point[b] + p]
        };
        let mut ring: Vec<u32> = FACES[s].iter().map(|&v| corner(v)).collect();
        ring.dedup();
        if ring.len() > 1 && ring[0] == ring[ring.len() - 1] {
            ring.pop();
        }
        ring
    }

    /// Cells on the other side of every joint, for the first and the second of its sides.
    fn across(&self) -> Vec<[Vec<(u32, u32)>; 2]> {
        let joint = |j: &super::topology::Joint| {
            let mut pairs = [Vec::new(), Vec::new()];
            let walk =
                [0, 1].map(|i| Walk::new(&j.corners[i], self.mesh.blocks[j.sides[i].0].cells));
            for v in 0..walk[0].n[1] {
                for u in 0..walk[0].n[0] {
                    let c = [0, 1].map(|i| {
                        let b = j.sides[i].0;
                        (self.offsets.cell[b] + self.mesh.blocks[b].cell(walk[i].at(u, v))) as u32
                    });
                    pairs[0].push((c[0], c[1]));
                    pairs[1].push((c[1], c[0]));
                }
            }
            pairs.iter_mut().for_each(|p| p.sort_unstable());
            pairs
        };
        self.topology.joints.iter().map(joint).collect()
    }

    fn inner_faces(&self, poly: &mut PolyMesh) {
        let across = self.across();
        let mut found: Vec<(u32, usize)> = Vec::with_capacity(6);
        for (b, block) in self.mesh.blocks.iter().enumerate() {
            for at in indices(block) {
                let c = (self.offsets.cell[b] + block.cell(at)) as u32;
                found.clear();
                for s in 0..6 {
                    let n = match neighbour_in_block(block, at, s) {
                        Some(n) => Some((self.offsets.cell[b] + n) as u32),
                        None => match self.topology.sides[b][s] {
                            Side::Joint(j, i) => {
                                let pairs = &across[j][i];
                                pairs.binary_search_by_key(&c, |p| p.0).ok().map(|k| pairs[k].1)
                            }
                            _ => None,
                        },
                    };
                    if let Some(n) = n.filter(|&n| n > c) {
                        found.push((n, s));
                    }
                }
                found.sort_unstable();
                for &(n, s) in &found {
                    let ring = self.side_points(b, at, s);
                    if ring.len() > 2 {
                        poly.push_face(&ring);
                        poly.owner.push(c);
                        poly.neighbour.push(n);
                    }
                }
            }
        }
    }

    fn patches(&self, poly: &mut PolyMesh) {
        let (name, kind) = &self.mesh.default_patch;
        let named_default = self.mesh.patches.iter().any(|p| p.name == *name);
        for (p, patch) in self.mesh.patches.iter().enumerate() {
            let start = poly.owner.len();
            for (face, _) in &patch.faces {
                let mut wanted = *face;
                wanted.sort_unstable();
                for (b, block) in self.mesh.blocks.iter().enumerate() {
                    for s in 0..6 {
                        let mut side = block.side(s);
                        side.sort_unstable();
                        if side == wanted && self.topology.sides[b][s] == Side::Patch(p) {
                            self.side_faces(poly, b, s);
                        }
                    }
                }
            }
            if patch.name == *name {
                self.free_faces(poly);
            }
            let len = poly.owner.len() - start;
            let (name, kind) = (patch.name.clone(), patch.kind.clone());
            poly.patches.push(PolyPatch {
                name,
                kind,
                start,
                len,
                in_groups: patch.in_groups.clone(),
            });
        }
        if named_default {
            return;
        }
        let start = poly.owner.len();
        self.free_faces(poly);
        let len = poly.owner.len() - start;
        // A nameless axis leaves a patch without faces, which files of fields may mention.
        let axis = self.topology.sides.iter().flatten().any(|s| *s == Side::Collapsed(false));
        if len > 0 || axis {
            let kind = kind.clone();
            poly.patches.push(PolyPatch {
                name: name.clone(),
                kind,
                start,
                len,
                in_groups: vec![],
            });
        }
    }

    /// Blocks of one zone name make one zone.
    fn zones(&self, poly: &mut PolyMesh) {
        for (b, block) in self.mesh.blocks.iter().enumerate() {
            let Some(name) = &block.zone else { continue };
            let cells = self.offsets.cell[b] as u32..self.offsets.cell[b + 1] as u32;
            match poly.cell_zones.iter_mut().find(|z| z.name == *name) {
                Some(zone) => zone.cells.extend(cells),
                None => {
                    poly.cell_zones.push(CellZone { name: name.clone(), cells: cells.collect() })
                }
            }
        }
    }

    /// Faces of the sides that belong to no patch.
    fn free_faces(&self, poly: &mut PolyMesh) {
        for (b, sides) in self.topology.sides.iter().enumerate() {
            for s in (0..6).filter(|&s| sides[s] == Side::Free) {
                self.side_faces(poly, b, s);
            }
        }
    }

    /// Faces of a block side, in the order OpenFOAM's tool numbers them.
    fn side_faces(&self, poly: &mut PolyMesh, b: usize, s: usize) {
        let block = &self.mesh.blocks[b];
        let across = s / 2;
        let [fast, slow] = match across {
            0 => [1, 2],
            1 => [2, 0],
            _ => [1, 0],
        };
        for v in 0..block.cells[slow] {
            for u in 0..block.cells[fast] {
                let mut at = [0; 3];
                at[across] = if s.is_multiple_of(2) { 0 } else { block.cells[across] - 1 };
                (at[fast], at[slow]) = (u, v);
                self.boundary_face(poly, b, at, s);
            }
        }
    }

    fn boundary_face(&self, poly: &mut PolyMesh, b: usize, at: [usize; 3], s: usize) {
        let ring = self.side_points(b, at, s);
        if ring.len() > 2 {
            poly.push_face(&ring);
            poly.owner.push((self.offsets.cell[b] + self.mesh.blocks[b].cell(at)) as u32);
        }
    }
}

/// All cells of a block in order.
fn indices(block: &Block) -> impl Iterator<Item = [usize; 3]> + use<> {
    let [nx, ny, nz] = block.cells;
    (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
}

/// The cell beyond side `s` within the same block.
fn neighbour_in_block(block: &Block, mut at: [usize; 3], s: usize) -> Option<usize> {
    let d = s / 2;
    at[d] = if s.is_multiple_of(2) { at[d].checked_sub(1)? } else { at[d] + 1 };
    (at[d] < block.cells[d]).then(|| block.cell(at))
}
