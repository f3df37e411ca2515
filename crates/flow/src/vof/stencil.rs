//! The cells that share a corner with a cell, wherever they live.
//!
//! Faces alone know too few neighbours to tell the direction of an interface. Cells beyond a
//! cyclic, wedge or processor patch are ghosts here too, but there are more of them than the mesh
//! has: those that only share an edge or a corner. So wide arrays hold own cells first, then
//! these ghosts, and have a halo of their own.

use super::VofError;
use granflow_base::{Tensor, Vec3, add, apply, norm, sub};
use granflow_mesh::{Mesh, PolyMesh};
use granflow_par::{Exec, Halo, Link};
use std::collections::{BTreeMap, HashMap};

/// Motions chained at most to find the images of a point: the corner of a box that is periodic
/// three ways takes three.
const CHAIN: usize = 3;

/// Neighbours across corners, and the arrays' layout that goes with them.
pub struct Stencil {
    /// Own cells.
    pub n_cells: usize,
    /// Own cells and wide ghosts.
    pub n_all: usize,
    /// Fills the ghosts of a wide array.
    pub halo: Halo,
    /// Centroids, ghosts at their image's place, m.
    pub centre: Vec<Vec3>,
    /// Wide index of the cell behind every inner face.
    pub neighbour: Vec<u32>,
    start: Vec<u32>,
    cells: Vec<u32>,
    point_start: Vec<u32>,
    point_cells: Vec<u32>,
}

impl Stencil {
    /// Cells that share a corner with the own cell `c`, itself left out. For a ghost: the own
    /// cells that have it among theirs.
    #[inline]
    pub fn around(&self, c: usize) -> &[u32] {
        &self.cells[self.start[c] as usize..self.start[c + 1] as usize]
    }
    /// Points of the undecomposed mesh.
    pub fn n_points(&self) -> usize {
        self.point_start.len() - 1
    }
    /// Cells around point `p` of the undecomposed mesh; complete for points of own cells.
    #[inline]
    pub fn around_point(&self, p: usize) -> &[u32] {
        &self.point_cells[self.point_start[p] as usize..self.point_start[p + 1] as usize]
    }
    /// Finds the neighbours. Every rank must call, with the same `poly`.
    ///
    /// # Errors
    /// [`VofError::Mesh`] when `poly` is not a sound mesh.
    pub fn new(exec: &Exec, poly: &PolyMesh, mesh: &Mesh) -> Result<Stencil, VofError> {
        let rebuilt;
        let whole = if exec.ranks() == 1 {
            mesh
        } else {
            rebuilt = Mesh::new(poly)?;
            &rebuilt
        };
        let images = Images::new(poly, whole);
        let [part, local] = layout(exec, mesh, whole.n_cells);
        let me = exec.rank();

        let mut seen = Seen::default();
        let (mut start, mut cells) = (vec![0u32], Vec::new());
        let mut mine = vec![false; poly.points.len()];
        let mut row: Vec<Found> = Vec::new();
        // All ranks' needs in one order, so that both ends of a link agree on theirs.
        let mut exchange: BTreeMap<(usize, Turn), Exchange> = BTreeMap::new();
        for c in 0..whole.n_cells {
            let rank = part[c] as usize;
            if rank != me && exec.ranks() == 1 {
                continue;
            }
            for &p in images.points_of(c) {
                images.around(p, &mut row);
                for found in &row {
                    let from = part[found.cell as usize] as usize;
                    let concerns_me = rank == me || from == me;
                    if !concerns_me || (found.still && from == rank) {
                        continue;
                    }
                    let at = found.at(&images.centre);
                    if seen.insert(rank, found.cell, at) {
                        let turn = Turn::of(found.rotation.as_ref());
                        if rank == me {
                            let both = exchange.entry((from, turn)).or_default();
                            both.needs.push((found.cell, at));
                        }
                        if from == me {
                            let both = exchange.entry((rank, turn)).or_default();
                            both.sends.push(local[found.cell as usize] as u32);
                        }
                    }
                }
                mine[p as usize] |= rank == me;
            }
        }

        let n_cells = mesh.n_cells;
        let mut centre = mesh.cell_centre[..n_cells].to_vec();
        let mut links = Vec::new();
        let mut ghosts: HashMap<u32, Vec<(Vec3, u32)>> = HashMap::new();
        for ((peer, turn), both) in exchange {
            let first = centre.len();
            for (cell, at) in both.needs {
                ghosts.entry(cell).or_default().push((at, centre.len() as u32));
                centre.push(at);
            }
            let (recv, rotation) = (first..centre.len(), turn.tensor());
            links.push(Link { rank: peer, send: both.sends, recv, rotation });
        }
        let wide = |found: &Found| -> u32 {
            if found.still && part[found.cell as usize] as usize == me {
                return local[found.cell as usize] as u32;
            }
            let at = found.at(&images.centre);
            let list = ghosts.get(&found.cell).map_or(&[][..], Vec::as_slice);
            nearest(list, at)
        };
        for c in 0..n_cells {
            let first = cells.len();
            for &p in images.points_of(mesh.global_cell[c] as usize) {
                images.around(p, &mut row);
                for found in &row {
                    let w = wide(found);
                    if w as usize != c && !cells[first..].contains(&w) {
                        cells.push(w);
                    }
                }
            }
            cells[first..].sort_unstable();
            start.push(cells.len() as u32);
        }
        let n_all = centre.len();
        let mut beside = vec![Vec::new(); n_all - n_cells];
        for c in 0..n_cells {
            for &w in &cells[start[c] as usize..start[c + 1] as usize] {
                if w as usize >= n_cells {
                    beside[w as usize - n_cells].push(c as u32);
                }
            }
        }
        for own in beside {
            cells.extend(own);
            start.push(cells.len() as u32);
        }
        let (mut point_start, mut point_cells) = (vec![0u32], Vec::new());
        for p in 0..poly.points.len() as u32 {
            if mine[p as usize] {
                images.around(p, &mut row);
                point_cells.extend(row.iter().map(wide));
            }
            point_start.push(point_cells.len() as u32);
        }
        let mut neighbour = mesh.neighbour.clone();
        let global = mesh_ghost_cells(exec, mesh);
        for n in neighbour.iter_mut().filter(|n| **n as usize >= n_cells) {
            let g = *n as usize;
            let list = ghosts.get(&global[g]).map_or(&[][..], Vec::as_slice);
            *n = nearest(list, mesh.cell_centre[g]);
        }
        Ok(Stencil {
            n_cells,
            n_all,
            halo: Halo::new(links),
            centre,
            neighbour,
            start,
            cells,
            point_start,
            point_cells,
        })
    }
}

/// The ghost whose image lies at `at`.
fn nearest(list: &[(Vec3, u32)], at: Vec3) -> u32 {
    let distance = |x: &(Vec3, u32)| norm(sub(x.0, at));
    let best = list.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    best.map_or(u32::MAX, |x| x.1)
}

/// Rank and local number of every cell of the whole mesh.
fn layout(exec: &Exec, mesh: &Mesh, n: usize) -> [Vec<f64>; 2] {
    let (mut part, mut local) = (vec![0.0; n], vec![0.0; n]);
    for (l, &g) in mesh.global_cell.iter().enumerate() {
        part[g as usize] = exec.rank() as f64;
        local[g as usize] = l as f64;
    }
    exec.comm().sum(&mut part);
    exec.comm().sum(&mut local);
    [part, local]
}

/// Number in the whole mesh of every cell and ghost of `mesh`.
fn mesh_ghost_cells(exec: &Exec, mesh: &Mesh) -> Vec<u32> {
    let mut global: Vec<f64> = mesh.global_cell.iter().map(|&g| f64::from(g)).collect();
    global.resize(mesh.n_all(), 0.0);
    mesh.halo.update(exec, &mut global);
    global.into_iter().map(|g| g as u32).collect()
}

/// A rotation as a key: its bits. Both ends of a link find it by the same arithmetic.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Turn(Option<[u64; 9]>);

impl Turn {
    fn of(r: Option<&Tensor>) -> Turn {
        Turn(r.map(|r| r.map(f64::to_bits)))
    }
    fn tensor(self) -> Option<Tensor> {
        self.0.map(|b| b.map(f64::from_bits))
    }
}

/// What two ranks have to tell each other under one rotation. Both list their exchanges in the
/// order of rotations, so that they pair up.
#[derive(Default)]
struct Exchange {
    /// Cells of the whole mesh that the peer owns, and where their images lie.
    needs: Vec<(u32, Vec3)>,
    /// Own cells that the peer needs.
    sends: Vec<u32>,
}

/// Ghosts found so far, by rank and cell.
#[derive(Default)]
struct Seen(HashMap<(usize, u32), Vec<Vec3>>);

impl Seen {
    fn insert(&mut self, rank: usize, cell: u32, at: Vec3) -> bool {
        let list = self.0.entry((rank, cell)).or_default();
        let known = list.iter().any(|&x| norm(sub(x, at)) <= 1e-9 * (norm(x) + norm(at)) + 1e-300);
        if !known {
            list.push(at);
        }
        !known
    }
}

/// A cell near a point, and the motion that brings it there.
#[derive(Clone, Debug)]
struct Found {
    cell: u32,
    /// Whether it lies there without a motion.
    still: bool,
    rotation: Option<Tensor>,
    shift: Vec3,
}

impl Found {
    /// Its place, from the centres of all cells.
    fn at(&self, centre: &[Vec3]) -> Vec3 {
        let x = centre[self.cell as usize];
        if self.still { x } else { self.moved(x) }
    }
    /// `R x + shift`.
    fn moved(&self, x: Vec3) -> Vec3 {
        add(self.rotation.as_ref().map_or(x, |r| apply(r, x)), self.shift)
    }
    /// This motion after another.
    fn after(&self, first: &Motion) -> (Option<Tensor>, Vec3) {
        let shift = self.moved(first.shift);
        let rotation = match (&self.rotation, &first.rotation) {
            (None, r) | (r, None) => *r,
            (Some(a), Some(b)) => {
                let mut c = [0.0; 9];
                for i in 0..9 {
                    c[i] = (0..3).map(|k| a[i / 3 * 3 + k] * b[3 * k + i % 3]).sum();
                }
                Some(c)
            }
        };
        (rotation, shift)
    }
}

/// What brings the cells behind a coupled patch to it: `x -> R x + shift`.
#[derive(Clone, Debug)]
struct Motion {
    rotation: Option<Tensor>,
    shift: Vec3,
}

/// Points of the whole mesh, the cells that have them, and their images. Cells have the user's numbers, whatever
/// those of the mesh are.
struct Images {
    centre: Vec<Vec3>,
    cell_start: Vec<u32>,
    cell_points: Vec<u32>,
    point_start: Vec<u32>,
    point_cells: Vec<u32>,
    /// Points that have images.
    coupled: Vec<bool>,
    /// For points of coupled patches: `(image, motion that brings it here)`.
    links: HashMap<u32, Vec<(u32, usize)>>,
    motions: Vec<Motion>,
}

impl Images {
    fn new(poly: &PolyMesh, whole: &Mesh) -> Images {
        let (ptr, faces) = poly.cell_faces();
        let (mut cell_start, mut cell_points) = (vec![0u32], Vec::new());
        let mut count = vec![0u32; poly.points.len() + 1];
        for c in 0..whole.n_cells {
            let first = cell_points.len();
            for &e in &faces[ptr[c] as usize..ptr[c + 1] as usize] {
                for &p in poly.face((e >> 1) as usize) {
                    if !cell_points[first..].contains(&p) {
                        cell_points.push(p);
                        count[p as usize + 1] += 1;
                    }
                }
            }
            cell_start.push(cell_points.len() as u32);
        }
        for p in 1..count.len() {
            count[p] += count[p - 1];
        }
        let (point_start, mut fill) = (count.clone(), count);
        let mut point_cells = vec![0u32; cell_points.len()];
        for c in 0..whole.n_cells {
            for &p in &cell_points[cell_start[c] as usize..cell_start[c + 1] as usize] {
                point_cells[fill[p as usize] as usize] = c as u32;
                fill[p as usize] += 1;
            }
        }
        let mut centre = vec![[0.0; 3]; whole.n_cells];
        for (x, &user) in whole.cell_centre.iter().zip(&whole.global_cell) {
            centre[user as usize] = *x;
        }
        let mut images = Images {
            centre,
            cell_start,
            cell_points,
            point_start,
            point_cells,
            coupled: vec![false; poly.points.len()],
            links: HashMap::new(),
            motions: Vec::new(),
        };
        images.couple(poly, whole);
        images
    }

    fn points_of(&self, c: usize) -> &[u32] {
        &self.cell_points[self.cell_start[c] as usize..self.cell_start[c + 1] as usize]
    }
    fn cells_of(&self, p: u32) -> &[u32] {
        let p = p as usize;
        &self.point_cells[self.point_start[p] as usize..self.point_start[p + 1] as usize]
    }

    /// Pairs the points of coupled faces. The motion of a patch is read off a ghost: it moved the
    /// source's centre to the ghost's.
    fn couple(&mut self, poly: &PolyMesh, whole: &Mesh) {
        for l in whole.halo.links() {
            let (ghost, source) = (l.recv.start, l.send[0] as usize);
            let r = l.rotation;
            let image =
                r.map_or(whole.cell_centre[source], |r| apply(&r, whole.cell_centre[source]));
            let shift = sub(whole.cell_centre[ghost], image);
            let motion = self.motions.len();
            self.motions.push(Motion { rotation: r, shift });
            let to = |x: Vec3| add(r.map_or(x, |r| apply(&r, x)), shift);
            for f in 0..whole.n_inner {
                let n = whole.neighbour[f] as usize;
                if !l.recv.contains(&n) {
                    continue;
                }
                let source = whole.global_cell[l.send[n - l.recv.start] as usize] as usize;
                let here = poly.face((whole.poly_face[f] >> 1) as usize);
                let size =
                    here.iter().map(|&p| norm(sub(poly.points[p as usize], whole.face_centre[f])));
                let size = size.fold(0.0, f64::max);
                for &p in here {
                    let x = poly.points[p as usize];
                    let distance = |q: u32| norm(sub(to(poly.points[q as usize]), x));
                    let candidates = self.points_of(source).iter().copied();
                    let best = candidates.min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
                    let Some(q) = best.filter(|&q| distance(q) < 1e-2 * size) else { continue };
                    self.coupled[p as usize] = true;
                    let list = self.links.entry(p).or_default();
                    if !list.contains(&(q, motion)) {
                        list.push((q, motion));
                    }
                }
            }
        }
    }

    /// All cells around point `p`, those beyond coupled patches moved there.
    fn around(&self, p: u32, out: &mut Vec<Found>) {
        out.clear();
        let still = |&cell: &u32| Found { cell, still: true, rotation: None, shift: [0.0; 3] };
        out.extend(self.cells_of(p).iter().map(still));
        if !self.coupled[p as usize] {
            return;
        }
        // Breadth first over chains of motions; images at one place are one.
        let here = Found { cell: p, still: true, rotation: None, shift: [0.0; 3] };
        let (mut wave, mut known) = (vec![here.clone()], vec![here]);
        for _ in 0..CHAIN {
            let mut next = Vec::new();
            for at in &wave {
                for &(q, m) in self.links.get(&at.cell).map_or(&[][..], Vec::as_slice) {
                    let (rotation, shift) = at.after(&self.motions[m]);
                    let found = Found { cell: q, still: false, rotation, shift };
                    if !known.iter().any(|k| k.cell == q && same(k, &found)) {
                        known.push(found.clone());
                        next.push(found);
                    }
                }
            }
            wave = next;
        }
        for image in &known[1..] {
            for &cell in self.cells_of(image.cell) {
                let found = Found { cell, ..image.clone() };
                if !out.iter().any(|k| k.cell == cell && same(k, &found)) {
                    out.push(found);
                }
            }
        }
    }
}

/// Whether two motions agree but for rounding.
fn same(a: &Found, b: &Found) -> bool {
    let size = 1e-9 * (norm(a.shift) + norm(b.shift));
    let unit = granflow_base::IDENTITY;
    let (ra, rb) = (a.rotation.unwrap_or(unit), b.rotation.unwrap_or(unit));
    let turned = ra.iter().zip(&rb).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    norm(sub(a.shift, b.shift)) <= size.max(1e-14) && turned < 1e-9
}
