//! One rank's part of a mesh.

use crate::mesh::{Mesh, Patch};
use crate::polymesh::{MeshError, PatchKind, PolyMesh, link_cells};
use granflow_base::{Vec3, scale};
use granflow_par::{Halo, Link};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Cuts a mesh into the parts `0..=max(part)`: `part[c]` is the rank of cell `c`.
///
/// Geometry is worked out once, on the whole mesh, so it is the same to the last bit for any
/// number of ranks.
///
/// # Errors
/// As [`Mesh::new`], and [`MeshError::Partition`] when `part` does not fit or a rank is empty.
pub fn decompose(poly: &PolyMesh, part: &[u32]) -> Result<Vec<Mesh>, MeshError> {
    let whole = Mesh::new(poly)?;
    let ranks = part.iter().max().map_or(1, |&r| r as usize + 1);
    (0..ranks).map(|r| extract(&whole, part, r)).collect()
}

/// What lies behind a coupled face of the whole mesh.
struct Behind {
    /// Cell the ghost images.
    source: u32,
    /// Link of the whole mesh that fills the ghost.
    link: usize,
}

/// A stretch of ghosts of one rank: ordered by peer, then so that both ends agree.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct LinkKey {
    peer: usize,
    /// 0 for a plain cut; else 1 + the patch's link as the lower rank sees it.
    order: usize,
    /// The patch's link on this rank (`usize::MAX` for a plain cut).
    link: usize,
}

/// The part of `rank`: its own cells in the order of the whole mesh, then its ghosts.
///
/// # Errors
/// [`MeshError::Partition`] when `part` does not fit the mesh or `rank` has no cells.
pub fn extract(whole: &Mesh, part: &[u32], rank: usize) -> Result<Mesh, MeshError> {
    if part.len() != whole.n_cells {
        let (n, m) = (part.len(), whole.n_cells);
        return Err(MeshError::Partition(format!("has {n} entries for {m} cells")));
    }
    if whole.halo.links().iter().any(|l| l.rank != 0) {
        return Err(MeshError::Partition("is of a mesh that is already cut".into()));
    }
    let mine = |c: u32| part[c as usize] as usize == rank;
    let global_cell: Vec<u32> = (0..whole.n_cells as u32).filter(|&c| mine(c)).collect();
    if global_cell.is_empty() {
        return Err(MeshError::Partition(format!("leaves rank {rank} without cells")));
    }
    let mut local = vec![u32::MAX; whole.n_cells];
    global_cell.iter().enumerate().for_each(|(l, &c)| local[c as usize] = l as u32);

    let links = whole.halo.links();
    let partners = partner_links(whole);
    let behind = |f: usize| {
        let n = whole.neighbour[f] as usize;
        let link = links.iter().position(|l| l.recv.contains(&n))?;
        Some(Behind { source: links[link].send[n - links[link].recv.start], link })
    };
    let mut cut = Cut::new(whole, &global_cell);
    // Ghost faces and outgoing cells of every link; BTreeMap: one order on every rank.
    let mut ghosts: BTreeMap<LinkKey, Vec<(usize, bool)>> = BTreeMap::new();
    let mut sends: BTreeMap<LinkKey, Vec<u32>> = BTreeMap::new();
    for f in 0..whole.n_inner {
        let (o, n) = (whole.owner[f], whole.neighbour[f]);
        if (n as usize) < whole.n_cells {
            match (mine(o), mine(n)) {
                (true, true) => cut.push(f, local[o as usize], Some(local[n as usize]), false),
                (false, false) => {}
                (own, _) => {
                    let (here, there) = if own { (o, n) } else { (n, o) };
                    let peer = part[there as usize] as usize;
                    let key = || LinkKey { peer, order: 0, link: usize::MAX };
                    ghosts.entry(key()).or_default().push((f, !own));
                    sends.entry(key()).or_default().push(local[here as usize]);
                }
            }
        } else if let Some(b) = behind(f) {
            let (near, far) = (part[o as usize] as usize, part[b.source as usize] as usize);
            let order = |lower: usize| 1 + lower;
            if near == rank {
                let lower = if rank <= far { b.link } else { partners[b.link] };
                let key = LinkKey { peer: far, order: order(lower), link: b.link };
                ghosts.entry(key).or_default().push((f, false));
            }
            if far == rank {
                // The value travels on the link of the other half, as this rank sees it (a link
                // to oneself is both ends at once).
                let link = if near == rank { b.link } else { partners[b.link] };
                let lower = if rank <= near { link } else { partners[link] };
                let key = LinkKey { peer: near, order: order(lower), link };
                sends.entry(key).or_default().push(local[b.source as usize]);
            }
        }
    }
    let mut halo = Vec::with_capacity(ghosts.len());
    let mut coupled: Vec<Vec<(usize, u32)>> = vec![Vec::new(); links.len()];
    for (key, faces) in ghosts {
        let first = cut.mesh.volume.len();
        for (f, flipped) in faces {
            let (near, far) = if flipped {
                (whole.neighbour[f], whole.owner[f])
            } else {
                (whole.owner[f], whole.neighbour[f])
            };
            let ghost = cut.mesh.volume.len() as u32;
            cut.mesh.volume.push(whole.volume[far as usize]);
            cut.mesh.cell_centre.push(whole.cell_centre[far as usize]);
            if key.link != usize::MAX {
                coupled[key.link].push((f, cut.mesh.owner.len() as u32));
            }
            cut.push(f, local[near as usize], Some(ghost), flipped);
        }
        let rotation = links.get(key.link).and_then(|l| l.rotation);
        let recv = first..cut.mesh.volume.len();
        let send = sends.remove(&key).unwrap_or_default();
        halo.push(Link { rank: key.peer, send, recv, rotation });
    }
    Ok(cut.finish(whole, halo, coupled, &local))
}

/// For every link of a whole mesh the link of the other half of its patch.
fn partner_links(whole: &Mesh) -> Vec<usize> {
    let linked = |p: &&Patch| !p.coupled_faces.is_empty();
    let patches: Vec<&Patch> = whole.patches.iter().filter(linked).collect();
    let partner = |(i, p): (usize, &&Patch)| match &p.kind {
        PatchKind::Cyclic { neighbour, .. } => {
            patches.iter().position(|q| q.name == *neighbour).unwrap_or(i)
        }
        _ => i,
    };
    patches.iter().enumerate().map(partner).collect()
}

/// A rank's mesh being filled.
struct Cut<'w> {
    whole: &'w Mesh,
    mesh: Mesh,
}

impl<'w> Cut<'w> {
    fn new(whole: &'w Mesh, cells: &[u32]) -> Cut<'w> {
        let mesh = Mesh {
            n_cells: cells.len(),
            n_ghosts: 0,
            n_inner: 0,
            owner: Vec::new(),
            neighbour: Vec::new(),
            area: Vec::new(),
            mag_area: Vec::new(),
            face_centre: Vec::new(),
            delta: Vec::new(),
            inv_dist: Vec::new(),
            weight: Vec::new(),
            nonorth: Vec::new(),
            skew: Vec::new(),
            cell_centre: cells.iter().map(|&c| whole.cell_centre[c as usize]).collect(),
            volume: cells.iter().map(|&c| whole.volume[c as usize]).collect(),
            patches: Vec::new(),
            halo: Arc::new(Halo::none()),
            cell_ptr: Vec::new(),
            cell_faces: Vec::new(),
            poly_face: Vec::new(),
            global_cell: cells.to_vec(),
            solved_dirs: whole.solved_dirs,
            extent: whole.extent,
            max_nonorth_deg: whole.max_nonorth_deg,
            max_skew: whole.max_skew,
        };
        Cut { whole, mesh }
    }

    /// Copies face `f`, turned round when `flipped`.
    fn push(&mut self, f: usize, owner: u32, neighbour: Option<u32>, flipped: bool) {
        let (w, m) = (self.whole, &mut self.mesh);
        let turned = |v: Vec3| if flipped { scale(v, -1.0) } else { v };
        m.owner.push(owner);
        m.area.push(turned(w.area[f]));
        m.mag_area.push(w.mag_area[f]);
        m.face_centre.push(w.face_centre[f]);
        m.delta.push(turned(w.delta[f]));
        m.inv_dist.push(w.inv_dist[f]);
        m.nonorth.push(turned(w.nonorth[f]));
        m.poly_face.push(w.poly_face[f] ^ u32::from(flipped));
        if let Some(n) = neighbour {
            m.neighbour.push(n);
            m.weight.push(if flipped { 1.0 - w.weight[f] } else { w.weight[f] });
            m.skew.push(w.skew[f]);
        }
    }

    fn finish(
        mut self,
        whole: &Mesh,
        links: Vec<Link>,
        coupled: Vec<Vec<(usize, u32)>>,
        local: &[u32],
    ) -> Mesh {
        self.mesh.n_inner = self.mesh.owner.len();
        self.mesh.n_ghosts = self.mesh.volume.len() - self.mesh.n_cells;
        self.mesh.halo = Arc::new(Halo::new(links));
        let mut coupled = coupled.into_iter();
        for p in &whole.patches {
            let start = self.mesh.owner.len();
            for f in p.faces.clone() {
                let own = local[whole.owner[f] as usize];
                if own != u32::MAX {
                    self.push(f, own, None, false);
                }
            }
            let mut here = match p.coupled_faces.is_empty() {
                true => Vec::new(),
                false => coupled.next().unwrap_or_default(),
            };
            here.sort_unstable();
            self.mesh.patches.push(Patch {
                name: p.name.clone(),
                kind: p.kind.clone(),
                faces: start..self.mesh.owner.len(),
                coupled_faces: here.into_iter().map(|(_, f)| f).collect(),
                in_groups: p.in_groups.clone(),
            });
        }
        let mut m = self.mesh;
        (m.cell_ptr, m.cell_faces) = link_cells(m.n_cells, &m.owner, &m.neighbour);
        m
    }
}
