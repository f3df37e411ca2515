//! From a [`PolyMesh`] to the numerics' [`Mesh`].

use crate::coupled::{Coupling, couplings, turns};
use crate::geometry::Geometry;
use crate::mesh::{Mesh, Patch};
use crate::polymesh::{MeshError, PatchKind, PolyMesh, link_cells, place};
use granflow_base::{Vec3, add, dot, norm, scale, sub};
use granflow_par::{Halo, Link};
use std::sync::Arc;

/// Least `n . delta` relative to the length of `delta`: keeps face gradients finite on faces
/// beyond 87 degrees of non-orthogonality.
const MIN_COS: f64 = 0.05;

/// One inner face's interpolation geometry.
pub(crate) struct FaceStencil {
    delta: Vec3,
    inv_dist: f64,
    weight: f64,
    nonorth: Vec3,
    skew: Vec3,
}

impl FaceStencil {
    /// Between the cell centres `o` and `n` through a face.
    fn new(o: Vec3, n: Vec3, centre: Vec3, area: Vec3) -> FaceStencil {
        let normal = scale(area, 1.0 / norm(area));
        let delta = sub(n, o);
        let across = dot(normal, delta).max(MIN_COS * norm(delta));
        let inv_dist = 1.0 / across;
        let (to, from) = (dot(normal, sub(centre, o)), dot(normal, sub(n, centre)));
        let span = to.abs() + from.abs();
        let weight = if span > 0.0 { from.abs() / span } else { 0.5 };
        let pierced = add(o, scale(delta, to * inv_dist));
        FaceStencil {
            delta,
            inv_dist,
            weight,
            nonorth: sub(normal, scale(delta, inv_dist)),
            skew: sub(centre, pierced),
        }
    }
}

impl Mesh {
    /// Works out geometry, couplings and ghosts of a whole mesh (one rank).
    ///
    /// # Errors
    /// Any [`MeshError`]: broken topology, cells of no volume, faces of no area, cyclic halves
    /// that do not match, wedges or empty patches of a wrong shape.
    pub fn new(poly: &PolyMesh) -> Result<Mesh, MeshError> {
        poly.validate()?;
        let g = Geometry::new(poly);
        sound(poly, &g)?;
        let solved_dirs = solved_dirs(poly, &g)?;
        let couplings = couplings(poly, &g)?;
        let n_cells = poly.n_cells();
        let mut m = Mesh {
            n_cells,
            n_ghosts: 0,
            n_inner: 0,
            owner: Vec::with_capacity(poly.n_faces()),
            neighbour: Vec::with_capacity(poly.n_inner()),
            area: Vec::with_capacity(poly.n_faces()),
            mag_area: Vec::new(),
            face_centre: Vec::with_capacity(poly.n_faces()),
            delta: Vec::with_capacity(poly.n_faces()),
            inv_dist: Vec::with_capacity(poly.n_faces()),
            weight: Vec::with_capacity(poly.n_inner()),
            nonorth: Vec::with_capacity(poly.n_faces()),
            skew: Vec::with_capacity(poly.n_inner()),
            cell_centre: g.cell_centre.clone(),
            volume: g.volume.clone(),
            patches: Vec::with_capacity(poly.patches.len()),
            halo: Arc::new(Halo::none()),
            cell_ptr: Vec::new(),
            cell_faces: Vec::new(),
            poly_face: Vec::with_capacity(poly.n_faces()),
            global_cell: (0..n_cells as u32).collect(),
            solved_dirs,
            extent: extent(poly, solved_dirs),
            max_nonorth_deg: 0.0,
            max_skew: 0.0,
        };
        for f in 0..poly.n_inner() {
            let nb = poly.neighbour[f];
            m.push_face(poly, &g, f);
            let n = g.cell_centre[nb as usize];
            let o = g.cell_centre[poly.owner[f] as usize];
            m.push_stencil(nb, FaceStencil::new(o, n, g.face_centre[f], g.area[f]));
        }
        let mut first_coupled = vec![0; poly.patches.len()];
        let mut links = Vec::with_capacity(couplings.len());
        for c in &couplings {
            first_coupled[c.patch] = m.owner.len();
            links.push(m.push_coupled(poly, &g, c, &first_coupled));
        }
        m.halo = Arc::new(Halo::new(links));
        m.n_ghosts = m.volume.len() - n_cells;
        m.n_inner = m.owner.len();
        for (i, p) in poly.patches.iter().enumerate() {
            let start = m.owner.len();
            let mut patch = Patch {
                name: p.name.clone(),
                kind: p.kind.clone(),
                faces: start..start,
                coupled_faces: Vec::new(),
                in_groups: p.in_groups.clone(),
            };
            if p.kind.coupled() {
                let first = first_coupled[i] as u32;
                patch.coupled_faces = (first..first + p.len as u32).collect();
            } else if p.kind != PatchKind::Empty {
                p.faces().for_each(|f| m.push_boundary(poly, &g, f));
                patch.faces = start..m.owner.len();
            }
            m.patches.push(patch);
        }
        m.mag_area = m.area.iter().map(|&a| norm(a)).collect();
        (m.cell_ptr, m.cell_faces) = link_cells(n_cells, &m.owner, &m.neighbour);
        // Coupled patches have no boundary faces: nothing passes a wedge to be corrected.
        m.max_nonorth_deg = (0..m.n_faces())
            .map(|f| dot(m.area[f], m.delta[f]) / (m.mag_area[f] * norm(m.delta[f])))
            .fold(1.0, f64::min)
            .clamp(-1.0, 1.0)
            .acos()
            .to_degrees();
        // Wedge faces do not make a mesh skewed: nothing passes them that their partner does not
        // give back.
        let wedge = |p: &&Patch| p.kind == PatchKind::Wedge;
        let images: Vec<u32> =
            m.patches.iter().filter(wedge).flat_map(|p| p.coupled_faces.clone()).collect();
        let relative = |f: usize| norm(m.skew[f]) / norm(m.delta[f]);
        m.max_skew = (0..m.n_inner)
            .filter(|f| images.binary_search(&(*f as u32)).is_err())
            .map(relative)
            .fold(0.0, f64::max);
        Ok(m)
    }

    fn push_face(&mut self, poly: &PolyMesh, g: &Geometry, f: usize) {
        self.owner.push(poly.owner[f]);
        self.area.push(g.area[f]);
        self.face_centre.push(g.face_centre[f]);
        self.poly_face.push((f as u32) << 1);
    }

    fn push_stencil(&mut self, neighbour: u32, s: FaceStencil) {
        self.neighbour.push(neighbour);
        self.delta.push(s.delta);
        self.inv_dist.push(s.inv_dist);
        self.weight.push(s.weight);
        self.nonorth.push(s.nonorth);
        self.skew.push(s.skew);
    }

    fn push_boundary(&mut self, poly: &PolyMesh, g: &Geometry, f: usize) {
        self.push_face(poly, g, f);
        let delta = sub(g.face_centre[f], g.cell_centre[poly.owner[f] as usize]);
        let across = (dot(g.area[f], delta) / norm(g.area[f])).max(MIN_COS * norm(delta));
        self.delta.push(delta);
        self.inv_dist.push(1.0 / across);
        let normal = scale(g.area[f], 1.0 / norm(g.area[f]));
        self.nonorth.push(sub(normal, scale(delta, 1.0 / across)));
    }

    /// Adds the faces and ghosts of one coupled patch and returns how the ghosts are filled.
    fn push_coupled(
        &mut self,
        poly: &PolyMesh,
        g: &Geometry,
        c: &Coupling,
        first_coupled: &[usize],
    ) -> Link {
        let (p, q) = (&poly.patches[c.patch], &poly.patches[c.partner]);
        let wedge = p.kind == PatchKind::Wedge;
        let first_ghost = self.volume.len();
        let mut send = Vec::with_capacity(p.len);
        for (i, f) in p.faces().enumerate() {
            let own = poly.owner[f];
            let pair = c.pairs[i] as usize;
            // Behind a wedge face lies the cell itself; its other face belongs to it too.
            let source = if wedge { own } else { poly.owner[q.start + pair] };
            let ghost = self.volume.len() as u32;
            send.push(source);
            self.volume.push(g.volume[source as usize]);
            self.cell_centre.push(c.motion.point(g.cell_centre[source as usize]));
            self.push_face(poly, g, f);
            // The second half mirrors the first, so that what leaves one enters the other.
            let mirror = (c.partner < c.patch).then(|| first_coupled[c.partner] + pair);
            if let Some(t) = mirror {
                let back = |v: Vec3| scale(c.motion.vector(v), -1.0);
                let here = self.area.len() - 1;
                self.area[here] = back(self.area[t]);
                self.push_stencil(
                    ghost,
                    FaceStencil {
                        delta: back(self.delta[t]),
                        inv_dist: self.inv_dist[t],
                        weight: 1.0 - self.weight[t],
                        nonorth: back(self.nonorth[t]),
                        skew: c.motion.vector(self.skew[t]),
                    },
                );
            } else {
                let o = g.cell_centre[own as usize];
                let n = self.cell_centre[ghost as usize];
                let mut s = FaceStencil::new(o, n, g.face_centre[f], g.area[f]);
                if wedge {
                    s.weight = 0.5;
                }
                self.push_stencil(ghost, s);
            }
        }
        Link {
            rank: 0,
            send,
            recv: first_ghost..self.volume.len(),
            rotation: c.motion.rotation.filter(turns),
        }
    }
}

/// Refuses faces without area and cells without volume, naming the worst cell.
fn sound(poly: &PolyMesh, g: &Geometry) -> Result<(), MeshError> {
    for f in 0..poly.n_faces() {
        let reach = |&k: &u32| norm(sub(poly.points[k as usize], g.face_centre[f]));
        let size = poly.face(f).iter().map(reach).fold(0.0, f64::max);
        let area = norm(g.area[f]);
        if area.is_nan() || area <= 1e-12 * size * size {
            return Err(MeshError::Area { face: f, at: g.face_centre[f] });
        }
    }
    let worst = (0..g.volume.len()).min_by(|&a, &b| g.volume[a].total_cmp(&g.volume[b]));
    match worst {
        Some(cell) if g.volume[cell].is_nan() || g.volume[cell] <= 0.0 => {
            Err(MeshError::Volume { cell, at: g.cell_centre[cell], volume: g.volume[cell] })
        }
        _ => Ok(()),
    }
}

/// Where the mesh begins and ends along the axes that are not solved for; without end along others.
fn extent(poly: &PolyMesh, solved: [bool; 3]) -> [[f64; 2]; 3] {
    let mut extent = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
    for k in (0..3).filter(|&k| !solved[k]) {
        let along = || poly.points.iter().map(|x| x[k]);
        extent[k] =
            [along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max)];
    }
    extent
}

/// Directions that remain once the normals of empty patches are taken out.
fn solved_dirs(poly: &PolyMesh, g: &Geometry) -> Result<[bool; 3], MeshError> {
    let mut solved = [true; 3];
    for p in poly.patches.iter().filter(|p| p.kind == PatchKind::Empty) {
        for f in p.faces() {
            let n = scale(g.area[f], 1.0 / norm(g.area[f]));
            match (0..3).find(|&d| n[d].abs() > 1.0 - 1e-5) {
                Some(d) => solved[d] = false,
                None => {
                    return Err(MeshError::Empty {
                        patch: p.name.clone(),
                        reason: format!(
                            "its face at {} has the normal {}, which is not along an axis",
                            place(g.face_centre[f]),
                            place(n)
                        ),
                    });
                }
            }
        }
    }
    let empty = || poly.patches.iter().filter(|p| p.kind == PatchKind::Empty && p.len > 0);
    let (faces, cells) = (empty().map(|p| p.len).sum::<usize>(), poly.n_cells());
    if let Some(p) = empty().next().filter(|_| !faces.is_multiple_of(2 * cells)) {
        let reason = format!(
            "{cells} cells have {faces} empty faces, but a two-dimensional mesh is one cell thick \
             and has two a cell"
        );
        return Err(MeshError::Empty { patch: p.name.clone(), reason });
    }
    if solved == [false; 3] {
        let named = poly.patches.iter().find(|p| p.kind == PatchKind::Empty);
        return Err(MeshError::Empty {
            patch: named.map_or(String::new(), |p| p.name.clone()),
            reason: "empty patches take out all three directions".into(),
        });
    }
    Ok(solved)
}
