//! How blocks meet, and which of their sides belong to which patch.

use super::{Block, BlockMesh, CORNERS, FACES};
use crate::geometry::face_geometry;
use crate::polymesh::{place, short};
use granflow_base::{add, dot, norm, scale, sub};
use granflow_dict::Diag;
use std::collections::HashMap;

/// What a block side borders on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Side {
    /// Fewer than three distinct corners: no faces. Whether a patch names it.
    Collapsed(bool),
    /// Joint number, seen from its first or second side.
    Joint(usize, usize),
    /// A patch by number.
    Patch(usize),
    /// Named by no patch.
    Free,
}

/// A side shared by two blocks.
pub(super) struct Joint {
    /// Block and side, twice.
    pub(super) sides: [(usize, usize); 2],
    /// Corners (0..8) of either block in matching order, starting at the first side's first.
    pub(super) corners: [[usize; 4]; 2],
}

pub(super) struct Topology {
    pub(super) sides: Vec<[Side; 6]>,
    pub(super) joints: Vec<Joint>,
}

/// Walks a side in index space: `at(u, v)` runs from corner 0 towards corners 1 and 3.
pub(super) struct Walk {
    origin: [usize; 3],
    /// Axis and whether it runs backwards, for u and v.
    steps: [(usize, bool); 2],
    /// Index range along u and v.
    pub(super) n: [usize; 2],
}

impl Walk {
    /// Over `size` points or cells a direction, along four corners of a side.
    pub(super) fn new(corners: &[usize; 4], size: [usize; 3]) -> Walk {
        let [c0, c1, c3] = [corners[0], corners[1], corners[3]].map(|c| CORNERS[c]);
        let step = |to: [usize; 3]| {
            let axis = (0..3).find(|&d| to[d] != c0[d]).unwrap_or(0);
            (axis, to[axis] == 0)
        };
        let steps = [step(c1), step(c3)];
        Walk {
            origin: std::array::from_fn(|d| c0[d] * (size[d] - 1)),
            steps,
            n: steps.map(|(axis, _)| size[axis]),
        }
    }
    pub(super) fn at(&self, u: usize, v: usize) -> [usize; 3] {
        let mut i = self.origin;
        for ((axis, back), by) in self.steps.into_iter().zip([u, v]) {
            i[axis] = if back { i[axis] - by } else { i[axis] + by };
        }
        i
    }
}

/// Vertices as a dictionary writes them.
fn listed(side: &[u32; 4]) -> String {
    format!("({})", side.map(|v| v.to_string()).join(" "))
}

/// Distinct vertices of a side, sorted.
fn key(side: &[u32; 4]) -> Vec<u32> {
    let mut k = side.to_vec();
    k.sort_unstable();
    k.dedup();
    k
}

/// Checks the blocks and finds what every side borders on.
pub(super) fn connect(mesh: &BlockMesh) -> Result<Topology, Vec<Diag>> {
    let mut faults = Vec::new();
    if mesh.blocks.is_empty() {
        faults.push(Diag::error(&mesh.whole, "the mesh has no blocks"));
    }
    mesh.blocks.iter().for_each(|b| sound(mesh, b, &mut faults));
    for e in &mesh.edges {
        if let Some(&v) = e.ends.iter().find(|&&v| v as usize >= mesh.vertices.len()) {
            faults.push(missing_vertex(mesh, v, Diag::error(&e.span, "")));
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }

    let mut sides = vec![[Side::Free; 6]; mesh.blocks.len()];
    let mut joints: Vec<Joint> = Vec::new();
    let mut seen: HashMap<Vec<u32>, (usize, usize)> = HashMap::new();
    for (b, block) in mesh.blocks.iter().enumerate() {
        for s in 0..6 {
            let k = key(&block.side(s));
            if k.len() < 3 {
                sides[b][s] = Side::Collapsed(false);
                continue;
            }
            let Some(&(b0, s0)) = seen.get(&k) else {
                seen.insert(k, (b, s));
                continue;
            };
            match joint(mesh, (b0, s0), (b, s)) {
                Err(d) => faults.push(d),
                Ok(_) if matches!(sides[b0][s0], Side::Joint(..)) => {
                    let text = format!("a third block uses the side {}", listed(&block.side(s)));
                    faults.push(
                        Diag::error(&block.span, text).label("two other blocks meet here already"),
                    );
                }
                Ok(j) => {
                    sides[b0][s0] = Side::Joint(joints.len(), 0);
                    sides[b][s] = Side::Joint(joints.len(), 1);
                    joints.push(j);
                }
            }
        }
    }
    for (p, patch) in mesh.patches.iter().enumerate() {
        for (face, span) in &patch.faces {
            if let Some(&v) = face.iter().find(|&&v| v as usize >= mesh.vertices.len()) {
                faults.push(missing_vertex(mesh, v, Diag::error(span, "")));
                continue;
            }
            let k = key(face);
            if k.len() < 3 {
                // The axis of a wedge: it may be named, without faces.
                for (b, block) in mesh.blocks.iter().enumerate() {
                    for s in (0..6).filter(|&s| key(&block.side(s)) == k) {
                        if sides[b][s] == Side::Collapsed(false) {
                            sides[b][s] = Side::Collapsed(true);
                        }
                    }
                }
                continue;
            }
            let text = format!("patch `{}`: ", patch.name);
            let Some(&(b, s)) = seen.get(&k) else {
                let what = format!("{text}no block has a side with these vertices");
                let help = near_side(mesh, face);
                let d = Diag::error(span, what).label("not a side of a block");
                faults.push(match help {
                    Some(h) => d.help(h),
                    None => d,
                });
                continue;
            };
            match sides[b][s] {
                Side::Free => sides[b][s] = Side::Patch(p),
                Side::Patch(q) => {
                    let what =
                        format!("{text}this side already belongs to `{}`", mesh.patches[q].name);
                    faults.push(Diag::error(span, what).label("named a second time"));
                }
                Side::Joint(j, _) => {
                    let [(a, _), (b, _)] = joints[j].sides;
                    let what = format!("{text}this side lies inside the mesh");
                    let label = format!("blocks {a} and {b} meet here");
                    faults.push(Diag::error(span, what).label(label));
                }
                Side::Collapsed(_) => {}
            }
        }
    }
    if faults.is_empty() { Ok(Topology { sides, joints }) } else { Err(faults) }
}

/// Names a vertex that does not exist, in a diagnostic that already points at its use.
fn missing_vertex(mesh: &BlockMesh, v: u32, mut d: Diag) -> Diag {
    d.message = format!("there is no vertex {v}");
    let n = mesh.vertices.len();
    d.label(match n {
        0 => "no vertices are given".to_owned(),
        _ => format!("vertices are numbered 0 to {}", n - 1),
    })
}

/// Vertices in range, cells in every direction, right-handed.
fn sound(mesh: &BlockMesh, block: &Block, faults: &mut Vec<Diag>) {
    if let Some(&v) = block.vertices.iter().find(|&&v| v as usize >= mesh.vertices.len()) {
        faults.push(missing_vertex(mesh, v, Diag::error(&block.span, "")));
        return;
    }
    if block.cells.contains(&0) {
        let text = format!("a block needs cells in every direction, found {:?}", block.cells);
        faults.push(Diag::error(&block.span, text).label("no cells"));
        return;
    }
    let corner = block.vertices.map(|v| mesh.vertices[v as usize]);
    let middle = scale(corner.into_iter().fold([0.0; 3], add), 0.125);
    let (mut volume, mut size) = (0.0, 0.0);
    for f in FACES {
        let (centre, area) = face_geometry(&f.map(|v| sub(corner[v], middle)));
        volume += dot(centre, area) / 3.0;
        size += norm(centre) * norm(area) / 3.0;
    }
    let curved = mesh.edges.iter().any(|e| e.ends.iter().all(|v| block.vertices.contains(v)));
    if volume < -1e-9 * size {
        faults.push(
            Diag::error(&block.span, "this block is inside out")
                .label(format!("volume {} m3 about {}", short(volume), place(middle)))
                .help(
                    "seen from the last four vertices, the first four must turn counter-clockwise: \
                     exchange the two groups",
                ),
        );
    } else if volume <= 1e-12 * size && !curved {
        faults.push(Diag::error(&block.span, "this block has no volume").label("flat"));
    }
}

/// Matches the corners of two sides.
fn joint(mesh: &BlockMesh, a: (usize, usize), b: (usize, usize)) -> Result<Joint, Diag> {
    let (block_a, block_b) = (&mesh.blocks[a.0], &mesh.blocks[b.0]);
    let (va, vb) = (block_a.side(a.1), block_b.side(b.1));
    // Neighbours see the side from opposite sides, so the second one is read backwards.
    let turn = (0..4).find(|&r| (0..4).all(|m| vb[(r + 4 - m) % 4] == va[m]));
    let Some(r) = turn else {
        return Err(Diag::error(&block_b.span, format!("block {} overlaps block {}", b.0, a.0))
            .label("both lie on the same side of a common face")
            .help("one of them is inside out, or the vertices cross over"));
    };
    let ca = FACES[a.1];
    let cb: [usize; 4] = std::array::from_fn(|m| FACES[b.1][(r + 4 - m) % 4]);
    let (na, nb) = (Walk::new(&ca, block_a.cells).n, Walk::new(&cb, block_b.cells).n);
    if na != nb {
        let text = format!(
            "blocks {} and {} meet with different numbers of cells: {} x {} and {} x {}",
            a.0, b.0, na[0], na[1], nb[0], nb[1]
        );
        let label = format!("its side {} is the other block's {}", listed(&vb), listed(&va));
        return Err(Diag::error(&block_b.span, text).label(label));
    }
    Ok(Joint { sides: [a, b], corners: [ca, cb] })
}

/// A side that shares three vertices with `face`, as a suggestion.
fn near_side(mesh: &BlockMesh, face: &[u32; 4]) -> Option<String> {
    for (b, block) in mesh.blocks.iter().enumerate() {
        for s in 0..6 {
            let side = block.side(s);
            if face.iter().filter(|v| side.contains(v)).count() == 3 {
                return Some(format!("block {b} has the side {}", listed(&side)));
            }
        }
    }
    None
}
