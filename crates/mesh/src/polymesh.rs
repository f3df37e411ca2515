//! The face-addressed mesh of OpenFOAM's `polyMesh` directory.

use granflow_base::Vec3;
use std::ops::Range;

/// A polyhedral mesh by faces: inner faces in upper-triangular order, then one run a patch.
///
/// Face `f` holds the points `face_points[face_ptr[f]..face_ptr[f + 1]]`; seen from its neighbour
/// (or from outside) they turn counter-clockwise, so that the area vector leaves the owner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolyMesh {
    /// Point coordinates, m.
    pub points: Vec<Vec3>,
    /// Start of every face in `face_points`, and the end of the last one.
    pub face_ptr: Vec<u32>,
    /// Point indices of all faces, one after the other.
    pub face_points: Vec<u32>,
    /// Cell the area vector leaves, one a face.
    pub owner: Vec<u32>,
    /// Cell the area vector enters, inner faces only.
    pub neighbour: Vec<u32>,
    /// Boundary patches; their faces follow the inner ones without a gap.
    pub patches: Vec<PolyPatch>,
    /// Named sets of cells.
    pub cell_zones: Vec<CellZone>,
}

/// A named set of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct CellZone {
    /// Name.
    pub name: String,
    /// Its cells, ascending.
    pub cells: Vec<u32>,
}

/// One boundary patch of a [`PolyMesh`].
#[derive(Clone, Debug, PartialEq)]
pub struct PolyPatch {
    /// Name, as boundary conditions refer to it.
    pub name: String,
    /// Geometric kind.
    pub kind: PatchKind,
    /// First face.
    pub start: usize,
    /// Number of faces.
    pub len: usize,
    /// Groups the patch belongs to.
    pub in_groups: Vec<String>,
}

impl PolyPatch {
    /// The patch's faces of the [`PolyMesh`].
    pub fn faces(&self) -> Range<usize> {
        self.start..self.start + self.len
    }
}

/// Geometric kind of a patch.
#[derive(Clone, Debug, PartialEq)]
pub enum PatchKind {
    /// No special geometry.
    Patch,
    /// A solid wall.
    Wall,
    /// Front or back of a mesh that is one cell thick along an axis: nothing is solved across it.
    Empty,
    /// Symmetry about faces that need not lie in one plane.
    Symmetry,
    /// Symmetry about one plane.
    SymmetryPlane,
    /// One side of an axisymmetric wedge, one cell thick.
    Wedge,
    /// Periodic with another patch.
    Cyclic {
        /// Name of the other half.
        neighbour: String,
        /// How the other half is brought onto this one.
        transform: CyclicTransform,
    },
}

impl PatchKind {
    /// The word a `boundary` file uses.
    pub fn word(&self) -> &'static str {
        match self {
            PatchKind::Patch => "patch",
            PatchKind::Wall => "wall",
            PatchKind::Empty => "empty",
            PatchKind::Symmetry => "symmetry",
            PatchKind::SymmetryPlane => "symmetryPlane",
            PatchKind::Wedge => "wedge",
            PatchKind::Cyclic { .. } => "cyclic",
        }
    }
    /// Whether faces of this kind become inner faces with a ghost cell behind them.
    pub fn coupled(&self) -> bool {
        matches!(self, PatchKind::Wedge | PatchKind::Cyclic { .. })
    }
}

/// How one half of a cyclic pair is brought onto the other.
#[derive(Clone, Debug, PartialEq)]
pub enum CyclicTransform {
    /// Worked out from the faces.
    Unknown,
    /// By a translation, m: from this patch to its neighbour, as OpenFOAM's `separationVector`.
    Translational(Vec3),
    /// By a rotation about an axis.
    Rotational {
        /// Direction of the axis (any length but zero).
        axis: Vec3,
        /// A point of the axis, m.
        origin: Vec3,
        /// Angle, radians; from the faces when absent.
        angle: Option<f64>,
    },
}

/// A number with the six digits a reader of a message can use.
pub(crate) fn short(x: f64) -> String {
    if x == 0.0 || (1e-4..1e7).contains(&x.abs()) {
        let digits = (5 - x.abs().log10().floor().clamp(-4.0, 6.0) as i32).clamp(0, 12) as usize;
        let text = format!("{x:.*}", if x == 0.0 { 0 } else { digits });
        let text = if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.')
        } else {
            &text
        };
        return if text == "-0" { "0".into() } else { text.into() };
    }
    let text = format!("{x:.5e}");
    match text.split_once('e') {
        Some((m, e)) if m.contains('.') => {
            format!("{}e{e}", m.trim_end_matches('0').trim_end_matches('.'))
        }
        _ => text,
    }
}

/// A place for a message: `(0.5, 0, 1e-5)`.
pub(crate) fn place(at: Vec3) -> String {
    format!("({}, {}, {})", short(at[0]), short(at[1]), short(at[2]))
}

/// Why a [`PolyMesh`] cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// Arrays of unequal lengths, indices out of range, patches with gaps.
    #[error("broken mesh topology: {0}")]
    Topology(String),
    /// A cell of no or negative volume, or a face without area.
    #[error(
        "cell {cell} at {} has volume {} m3, which must be positive",
        place(*at), short(*volume)
    )]
    Volume {
        /// The worst cell.
        cell: usize,
        /// Average of its face centres, m.
        at: Vec3,
        /// Its volume, m3.
        volume: f64,
    },
    /// A face without area.
    #[error("face {face} at {} has no area", place(*at))]
    Area {
        /// Face of the [`PolyMesh`].
        face: usize,
        /// Its centre, m.
        at: Vec3,
    },
    /// A cyclic patch whose other half does not exist, or does not name it in return.
    #[error("cyclic patch `{patch}`: {reason}")]
    CyclicPair {
        /// The patch.
        patch: String,
        /// What is wrong.
        reason: String,
    },
    /// Faces of a cyclic pair that do not lie on each other.
    #[error(
        "cyclic patches `{patch}` and `{neighbour}` do not match: face {face} of `{patch}` at {} \
         is {} m from the nearest face of `{neighbour}` (allowed: {} m)",
        place(*at), short(*distance), short(*tolerance)
    )]
    CyclicMatch {
        /// The patch.
        patch: String,
        /// Its other half.
        neighbour: String,
        /// Worst face, counted within the patch.
        face: usize,
        /// Its centre, m.
        at: Vec3,
        /// Distance to the nearest face of the other half, m.
        distance: f64,
        /// Greatest distance allowed, m.
        tolerance: f64,
    },
    /// Wedge patches that do not form a wedge one cell thick.
    #[error("wedge patch `{patch}`: {reason}")]
    Wedge {
        /// The patch.
        patch: String,
        /// What is wrong.
        reason: String,
    },
    /// Empty patches that are not normal to one axis.
    #[error("empty patch `{patch}`: {reason}")]
    Empty {
        /// The patch.
        patch: String,
        /// What is wrong.
        reason: String,
    },
    /// More than 2^31 faces or 2^32 points.
    #[error("the mesh has {0} entities, more than 32-bit indices can hold")]
    TooLarge(usize),
    /// A partition that does not fit the mesh.
    #[error("the partition {0}")]
    Partition(String),
}

impl PolyMesh {
    /// Number of faces.
    pub fn n_faces(&self) -> usize {
        self.owner.len()
    }
    /// Number of inner faces.
    pub fn n_inner(&self) -> usize {
        self.neighbour.len()
    }
    /// Number of cells.
    pub fn n_cells(&self) -> usize {
        self.owner.iter().chain(&self.neighbour).max().map_or(0, |&c| c as usize + 1)
    }
    /// Point indices of face `f`.
    #[inline]
    pub fn face(&self, f: usize) -> &[u32] {
        &self.face_points[self.face_ptr[f] as usize..self.face_ptr[f + 1] as usize]
    }
    /// The cells of face `f`, owner first.
    pub fn cells_of(&self, f: usize) -> Vec<u32> {
        std::iter::once(self.owner[f]).chain(self.neighbour.get(f).copied()).collect()
    }
    /// Appends a face's points; owner and neighbour are left to the caller.
    pub fn push_face(&mut self, points: &[u32]) {
        if self.face_ptr.is_empty() {
            self.face_ptr.push(0);
        }
        self.face_points.extend_from_slice(points);
        self.face_ptr.push(self.face_points.len() as u32);
    }
    /// Index of the patch called `name`.
    pub fn patch(&self, name: &str) -> Option<usize> {
        self.patches.iter().position(|p| p.name == name)
    }
    /// Faces of every cell: `(ptr, entries)`, an entry being `face << 1 | 1` for the neighbour.
    pub fn cell_faces(&self) -> (Vec<u32>, Vec<u32>) {
        link_cells(self.n_cells(), &self.owner, &self.neighbour)
    }

    /// Checks lengths, index ranges and patch runs: after this no index can be out of range.
    ///
    /// # Errors
    /// [`MeshError::Topology`] naming the first fault, [`MeshError::TooLarge`].
    pub fn validate(&self) -> Result<(), MeshError> {
        let fault = |m: String| Err(MeshError::Topology(m));
        let (n_faces, n_inner) = (self.n_faces(), self.n_inner());
        let largest = n_faces.max(self.face_points.len()).max(self.points.len());
        if largest >= 1 << 31 {
            return Err(MeshError::TooLarge(largest));
        }
        if n_faces == 0 {
            return fault("no faces".into());
        }
        if self.face_ptr.len() != n_faces + 1 {
            let found = self.face_ptr.len().saturating_sub(1);
            return fault(format!("{found} faces but {n_faces} owners"));
        }
        if n_inner > n_faces {
            return fault(format!("{n_inner} neighbours but only {n_faces} faces"));
        }
        if self.face_ptr[0] != 0 || self.face_ptr[n_faces] as usize != self.face_points.len() {
            return fault("face offsets do not span the list of face points".into());
        }
        for f in 0..n_faces {
            if self.face_ptr[f] > self.face_ptr[f + 1] {
                return fault(format!("face offsets decrease at face {f}"));
            }
            if self.face_ptr[f + 1] as usize > self.face_points.len() {
                return fault(format!("face {f} ends beyond the list of face points"));
            }
            let points = self.face(f);
            if points.len() < 3 {
                return fault(format!("face {f} has {} points; it needs 3", points.len()));
            }
            if let Some(p) = points.iter().find(|&&p| p as usize >= self.points.len()) {
                return fault(format!("face {f} uses point {p} of {}", self.points.len()));
            }
        }
        if let Some(p) = self.points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return fault(format!("point {p} is not finite"));
        }
        let n_cells = self.n_cells();
        if n_cells > 4 * n_faces {
            return fault(format!("{n_cells} cells cannot be closed by {n_faces} faces"));
        }
        if let Some(f) = (0..n_inner).find(|&f| self.owner[f] == self.neighbour[f]) {
            return fault(format!("face {f} has cell {} on both sides", self.owner[f]));
        }
        let mut seen = vec![false; n_cells];
        self.owner.iter().chain(&self.neighbour).for_each(|&c| seen[c as usize] = true);
        if let Some(c) = seen.iter().position(|s| !s) {
            return fault(format!("cell {c} has no faces"));
        }
        let mut next = n_inner;
        for p in &self.patches {
            if p.start != next {
                return fault(format!(
                    "patch `{}` starts at face {} where {next} is due",
                    p.name, p.start
                ));
            }
            next = p.start.saturating_add(p.len);
        }
        if next != n_faces {
            return fault(format!("patches end at face {next}, the mesh at {n_faces}"));
        }
        Ok(())
    }
}

/// Cell-to-face links; cells at and after `n_cells` (ghosts) get none.
pub(crate) fn link_cells(n_cells: usize, owner: &[u32], neighbour: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut ptr = vec![0u32; n_cells + 1];
    let own = |c: u32| (c as usize) < n_cells;
    for &c in owner.iter().chain(neighbour).filter(|&&c| own(c)) {
        ptr[c as usize + 1] += 1;
    }
    for c in 0..n_cells {
        ptr[c + 1] += ptr[c];
    }
    let mut at = ptr.clone();
    let mut faces = vec![0u32; ptr[n_cells] as usize];
    let mut put = |c: u32, e: u32| {
        if own(c) {
            let slot = &mut at[c as usize];
            faces[*slot as usize] = e;
            *slot += 1;
        }
    };
    for (f, &o) in owner.iter().enumerate() {
        put(o, (f as u32) << 1);
        if let Some(&nb) = neighbour.get(f) {
            put(nb, (f as u32) << 1 | 1);
        }
    }
    (ptr, faces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    #[test]
    fn messages_show_six_digits() {
        let all = [0.0, -0.0, 1.0, 0.1 + 0.2, 123456.789, -2.5e-9, 1e20, f64::NAN, 1.0 / 3.0];
        let text = all.map(short).join(" ");
        assert_eq!(text, "0 0 1 0.3 123457 -2.5e-9 1e20 NaN 0.333333");
    }

    #[test]
    fn validation_names_the_fault() {
        let good = shapes::unit_box([2, 2, 2]);
        assert_eq!(good.validate(), Ok(()));
        let mut m = good.clone();
        m.face_points[5] = 99;
        assert_eq!(
            m.validate().unwrap_err().to_string(),
            "broken mesh topology: face 1 uses point 99 of 27"
        );
        let mut m = good.clone();
        m.patches[1].start += 1;
        assert!(m.validate().unwrap_err().to_string().contains("starts at face"));
        let mut m = good.clone();
        m.face_ptr[1] = 4000;
        assert!(m.validate().is_err());
        let mut m = good.clone();
        m.owner[0] = u32::MAX;
        assert!(m.validate().is_err());
        let mut m = good.clone();
        m.owner.pop();
        assert!(m.validate().is_err());
        let mut m = good;
        m.points[3][1] = f64::NAN;
        assert!(m.validate().unwrap_err().to_string().contains("point 3 is not finite"));
    }
}
