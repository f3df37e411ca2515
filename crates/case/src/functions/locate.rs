//! Which cell holds a point.

use granflow_base::{Vec3, dot, norm, sub};
use granflow_mesh::Mesh;

/// How far outside a face a point may lie, relative to the cell's size: points on faces belong to
/// both cells.
const SKIN: f64 = 1e-7;

/// Finds cells by points; asks the neighbourhood of the last answer first.
pub(crate) struct Locator<'m> {
    mesh: &'m Mesh,
    last: usize,
}

impl<'m> Locator<'m> {
    /// For the cells that this rank owns.
    pub(crate) fn new(mesh: &'m Mesh) -> Self {
        Locator { mesh, last: 0 }
    }

    /// The cell that holds `x`; `None` outside the mesh.
    pub(crate) fn find(&mut self, x: Vec3) -> Option<usize> {
        let skin = self.mesh.extent.map(|[lo, hi]| SKIN * (hi - lo));
        let beside = |k: usize| {
            let [lo, hi] = self.mesh.extent[k];
            skin[k].is_finite() && !(lo - skin[k]..=hi + skin[k]).contains(&x[k])
        };
        if self.mesh.n_cells == 0 || (0..3).any(beside) {
            return None;
        }
        if let Some(c) = self.walk(x) {
            self.last = c;
            return Some(c);
        }
        let found = (0..self.mesh.n_cells).find(|&c| outside(self.mesh, c, x).is_none())?;
        self.last = found;
        Some(found)
    }

    /// Across the face the point is farthest outside of, until it is inside.
    fn walk(&self, x: Vec3) -> Option<usize> {
        let mut c = self.last;
        for _ in 0..self.mesh.n_cells {
            let Some(f) = outside(self.mesh, c, x) else { return Some(c) };
            let n = *self.mesh.neighbour.get(f)? as usize;
            let next = if n == c { self.mesh.owner[f] as usize } else { n };
            if next >= self.mesh.n_cells {
                return None;
            }
            c = next;
        }
        None
    }
}

/// The face that `x` lies farthest outside of, if it lies outside of any.
fn outside(mesh: &Mesh, c: usize, x: Vec3) -> Option<usize> {
    let mut worst = SKIN * mesh.cell_size(c);
    let mut face = None;
    for (f, s) in mesh.faces_of(c) {
        let out = s * dot(sub(x, mesh.face_centre[f]), mesh.area[f]) / mesh.mag_area[f];
        if out > worst {
            worst = out;
            face = Some(f);
        }
    }
    face
}

/// The part of the segment from `a` along `d` (parameters 0 to 1) that lies in cell `c`.
pub(crate) fn clip(mesh: &Mesh, c: usize, a: Vec3, d: Vec3) -> Option<(f64, f64)> {
    let (mut t0, mut t1) = (0.0_f64, 1.0_f64);
    let skin = SKIN * mesh.cell_size(c);
    for (k, [lo, hi]) in mesh.extent.into_iter().enumerate().filter(|(_, e)| e[0].is_finite()) {
        let (enter, leave) = if d[k] < 0.0 { (hi, lo) } else { (lo, hi) };
        if d[k] != 0.0 {
            t0 = t0.max((enter - a[k]) / d[k]);
            t1 = t1.min((leave - a[k]) / d[k]);
        } else if !(lo - skin..=hi + skin).contains(&a[k]) {
            return None;
        }
    }
    for (f, s) in mesh.faces_of(c) {
        let n = mesh.area[f].map(|x| s * x / mesh.mag_area[f]);
        let (out, speed) = (dot(sub(a, mesh.face_centre[f]), n), dot(d, n));
        if speed.abs() <= 1e-12 * norm(d) {
            if out > skin {
                return None;
            }
        } else if speed > 0.0 {
            t1 = t1.min(-out / speed);
        } else {
            t0 = t0.max(-out / speed);
        }
    }
    (t1 - t0 > 1e-9).then_some((t0, t1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use granflow_mesh::shapes;

    #[test]
    fn every_centre_is_found_and_what_is_outside_is_not() {
        let poly = shapes::displaced(&shapes::unit_box([5, 4, 3]), 0.2, 1);
        let mesh = Mesh::new(&poly).unwrap();
        let mut find = Locator::new(&mesh);
        for c in (0..mesh.n_cells).rev() {
            assert_eq!(find.find(mesh.cell_centre[c]), Some(c));
        }
        assert_eq!(find.find([0.5, 0.5, 1.1]), None);
        assert!(find.find([0.0, 0.0, 0.0]).is_some(), "corners belong to the mesh");
    }

    #[test]
    fn a_segment_is_cut_at_the_faces() {
        let mesh = Mesh::new(&shapes::unit_box([4, 1, 1])).unwrap();
        let cut = |c| clip(&mesh, c, [0.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
        let (a, b) = cut(1).unwrap();
        assert!((a - 0.25).abs() < 1e-12 && (b - 0.5).abs() < 1e-12);
        assert_eq!(clip(&mesh, 0, [0.0, 2.0, 0.5], [1.0, 0.0, 0.0]), None);
    }
}
