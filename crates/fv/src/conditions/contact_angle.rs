//! The angle at which an interface meets a wall.

use super::read::leave_value;
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use granflow_base::Dims;
use granflow_dict::Reader;

/// What keeps the fraction on the face within 0 and 1 (`limit`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactLimit {
    /// Nothing.
    None,
    /// The gradient is cut.
    Gradient,
    /// The gradient is null.
    ZeroGradient,
    /// The value is cut.
    Alpha,
}

impl ContactLimit {
    /// All, by name.
    pub const ALL: [(&'static str, ContactLimit); 4] = [
        ("none", ContactLimit::None),
        ("gradient", ContactLimit::Gradient),
        ("zeroGradient", ContactLimit::ZeroGradient),
        ("alpha", ContactLimit::Alpha),
    ];
}

/// The volume fraction where the interface meets the wall at a constant angle, measured through
/// fluid 1: its normal gradient is `|grad alpha| cos(angle)`.
pub struct ConstantAlphaContactAngle {
    /// Degrees.
    pub theta0: f64,
    /// See [`ContactLimit`].
    pub limit: ContactLimit,
    /// Number of inner faces of the mesh.
    pub n_inner: usize,
}

impl Condition<f64> for ConstantAlphaContactAngle {
    fn name(&self) -> &'static str {
        "constantAlphaContactAngle"
    }
    fn update(&mut self, view: &PatchView<'_, f64>, closure: &mut PatchClosure<'_, f64>) {
        closure.free();
        let gradient = view.around.contact_gradient;
        if gradient.is_empty() || self.limit == ContactLimit::ZeroGradient {
            return;
        }
        let first = view.first_boundary(self.n_inner);
        for (i, o) in closure.offset.iter_mut().enumerate() {
            let here = view.cells[view.owner[i] as usize];
            let there = here + gradient[first + i] / view.inv_dist[i];
            *o = match self.limit {
                ContactLimit::None => there - here,
                _ => there.clamp(0.0, 1.0) - here,
            };
        }
    }
    fn contact_angle(&self) -> Option<f64> {
        Some(self.theta0.to_radians())
    }
    fn entries(&self) -> Vec<(String, String)> {
        let limit = ContactLimit::ALL.iter().find(|l| l.1 == self.limit);
        vec![
            ("theta0".into(), granflow_dict::number(self.theta0)),
            ("limit".into(), limit.map_or("none", |l| l.0).into()),
        ]
    }
}

pub(super) const ENTRY: Entry = Entry {
    name: "constantAlphaContactAngle",
    summary: "of a volume fraction: the interface meets the wall at the angle theta0 (degrees, \
              through the first fluid)",
    formula: "alpha_f = alpha_P + h |grad alpha|_P cos(theta0), within 0 and 1 unless \
              limit is none; phi_f = phi_P with zeroGradient",
    keys: &[
        ("theta0", "degrees, through the first fluid"),
        ("limit", "`none`, `gradient`, `zeroGradient` or `alpha`"),
    ],
    reference: "J. U. Brackbill, D. B. Kothe, C. Zemach, J. Comput. Phys. 100 (1992) 335",
    scalar: Some(contact_angle),
    vector: None,
};

fn contact_angle(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<f64>> {
    leave_value(r);
    r.ignore("gradient");
    let theta0 = r.in_range("theta0", Dims::NONE, 0.0..=180.0);
    let limit = r.one_of("limit", &ContactLimit::ALL);
    Box::new(ConstantAlphaContactAngle { theta0, limit, n_inner: c.n_inner })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Affine, Surroundings};

    #[test]
    fn the_fraction_follows_the_angle_within_bounds() {
        let gradient = [10.0, 1.0];
        let around = Surroundings { contact_gradient: &gradient, ..Surroundings::default() };
        let view = PatchView {
            faces: 0..2,
            inv_dist: &[10.0, 10.0],
            area: &[[1.0, 0.0, 0.0]; 2],
            normal: &[[1.0, 0.0, 0.0]; 2],
            centre: &[[0.0; 3]; 2],
            owner: &[0, 1],
            owner_centre: &[[0.0; 3]; 2],
            cells: &[0.5, 0.5],
            flux: None,
            totals: &[],
            around: &around,
        };
        let mut closure = Affine::zero_gradient(2);
        let limit = ContactLimit::Gradient;
        let mut condition = ConstantAlphaContactAngle { theta0: 45.0, limit, n_inner: 0 };
        condition.update(&view, &mut closure.patch(0..2));
        assert_eq!(closure.offset, [0.5, 0.09999999999999998]);
        assert_eq!(closure.slope, [1.0, 1.0]);
        condition.limit = ContactLimit::None;
        condition.update(&view, &mut closure.patch(0..2));
        assert_eq!(closure.offset[0], 1.0);
    }
}
