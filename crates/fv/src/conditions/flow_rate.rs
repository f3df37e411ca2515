//! A given volume or mass per second through a patch.

use super::read::leave_value;
use super::{Condition, Entry, PatchClosure, PatchContext, PatchView};
use crate::time_function::TimeFunction;
use granflow_base::{Dims, Vec3, add, dot, norm, scale};
use granflow_dict::{Reader, number};

/// What goes through, against time.
pub struct FlowRate {
    /// m3/s, or kg/s.
    pub rate: TimeFunction<f64>,
    /// Of a mass: the density of the case's fluid, or what the user gives for it, kg/m3.
    pub density: Option<f64>,
    /// What the user gave, for [`Condition::entries`].
    given: Vec<(String, String)>,
}

impl FlowRate {
    /// A volume per second.
    pub fn volume(rate: TimeFunction<f64>) -> Self {
        FlowRate { given: rate.entries("volumetricFlowRate"), rate, density: None }
    }
    /// Reads `volumetricFlowRate` or `massFlowRate`; the density of one fluid may stand under
    /// `density`.
    pub(super) fn read(r: &Reader<'_>, c: &PatchContext<'_>, density: &str) -> Self {
        leave_value(r);
        for key in ["phi", "rhoInlet", "rhoOutlet"] {
            r.ignore(key);
        }
        let named = r.opt_word("rho", "rho");
        if !r.has("massFlowRate") {
            let key = "volumetricFlowRate";
            return Self::volume(TimeFunction::read(r, key, Dims::VOLUME_FLUX, c.case));
        }
        if r.has("volumetricFlowRate") {
            r.ignore("volumetricFlowRate");
            let message = "a rate is either a mass or a volume";
            r.error_at_key("massFlowRate", message, "and `volumetricFlowRate` is there too", None);
        }
        let rate = TimeFunction::read(r, "massFlowRate", Dims::MASS_FLUX, c.case);
        let mut given = rate.entries("massFlowRate");
        let mut rho = c.case.density;
        if named == "none" {
            given.push(("rho".into(), "none".into()));
            rho = 1.0;
        } else if r.has(density) {
            rho = r.positive(density, Dims::DENSITY);
            given.push((density.to_owned(), number(rho)));
        }
        FlowRate { rate, density: Some(rho), given }
    }
    /// What a m3 of the fluid at face `i` counts for: 1, or its density in kg.
    fn weight(&self, view: &PatchView<'_, Vec3>, i: usize) -> f64 {
        match self.density {
            None => 1.0,
            // Two fluids have the density of their mixture.
            Some(rho) if view.around.face_fraction.is_empty() => rho,
            Some(rho) => view.around.density.get(view.owner[i] as usize).copied().unwrap_or(rho),
        }
    }
}

/// Inflow of a given rate: with the same speed along the normal on every face, or with the profile
/// of the cells behind the patch, scaled where they bring more than half of the rate, else shifted.
pub struct FlowRateInlet {
    /// What enters.
    pub rate: FlowRate,
    /// Whether the profile is that of the cells.
    pub extrapolates: bool,
}

impl Condition<Vec3> for FlowRateInlet {
    fn name(&self) -> &'static str {
        "flowRateInletVelocity"
    }
    fn n_totals(&self) -> usize {
        2
    }
    fn totals(&self, view: &PatchView<'_, Vec3>, out: &mut [f64]) {
        for (i, s) in view.area.iter().enumerate() {
            let area = norm(*s) * self.rate.weight(view, i);
            out[0] += area;
            out[1] += area * inward(view, i);
        }
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        closure.fix([0.0; 3]);
        let (area, found) = (view.totals[0].max(f64::MIN_POSITIVE), view.totals[1]);
        let rate = self.rate.rate.at(view.around.time);
        let (factor, shift) = match found > 0.5 * rate && found > 0.0 {
            true => (rate / found, 0.0),
            false => (1.0, (rate - found) / area),
        };
        for (i, n) in view.normal.iter().enumerate() {
            closure.offset[i] = if self.extrapolates {
                let u = view.cells[view.owner[i] as usize];
                let along = add(u, scale(*n, -dot(u, *n)));
                add(along, scale(*n, -factor * inward(view, i) - shift))
            } else {
                scale(*n, -rate / area)
            };
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        let mut out = self.rate.given.clone();
        if self.extrapolates {
            out.push(("extrapolateProfile".into(), "true".into()));
        }
        out
    }
}

/// Outflow of a given rate: the profile of the cells behind the patch, scaled where they bring more
/// than half of the rate, else shifted. What would come in stands still; what is along the patch
/// passes freely.
pub struct FlowRateOutlet {
    /// What leaves.
    pub rate: FlowRate,
}

/// Speed into the domain in the cell behind face `i`, not below zero, m/s.
fn inward(view: &PatchView<'_, Vec3>, i: usize) -> f64 {
    (-dot(view.cells[view.owner[i] as usize], view.normal[i])).max(0.0)
}

/// Speed out of the patch in the cell behind face `i`, not below zero, m/s.
fn outward(view: &PatchView<'_, Vec3>, i: usize) -> f64 {
    dot(view.cells[view.owner[i] as usize], view.normal[i]).max(0.0)
}

impl Condition<Vec3> for FlowRateOutlet {
    fn name(&self) -> &'static str {
        "flowRateOutletVelocity"
    }
    fn n_totals(&self) -> usize {
        2
    }
    fn totals(&self, view: &PatchView<'_, Vec3>, out: &mut [f64]) {
        for (i, s) in view.area.iter().enumerate() {
            let area = norm(*s) * self.rate.weight(view, i);
            out[0] += area;
            out[1] += area * outward(view, i);
        }
    }
    fn update(&mut self, view: &PatchView<'_, Vec3>, closure: &mut PatchClosure<'_, Vec3>) {
        let (area, out) = (view.totals[0], view.totals[1]);
        let rate = self.rate.rate.at(view.around.time);
        let (factor, shift) = match out > 0.5 * rate && out > 0.0 {
            true => (rate / out, 0.0),
            false => (1.0, (rate - out) / area.max(f64::MIN_POSITIVE)),
        };
        closure.fix([0.0; 3]);
        for (i, offset) in closure.offset.iter_mut().enumerate() {
            let (n, u) = (view.normal[i], view.cells[view.owner[i] as usize]);
            let along = add(u, scale(n, -dot(u, n)));
            *offset = add(along, scale(n, factor * outward(view, i) + shift));
        }
    }
    fn entries(&self) -> Vec<(String, String)> {
        self.rate.given.clone()
    }
}

pub(super) const INLET: Entry = Entry {
    name: "flowRateInletVelocity",
    summary: "inflow of a given volume (or mass) per second, a function of time: the same speed \
              along the normal everywhere, or with extrapolateProfile as it arrives",
    formula: "U_f = -(Q/A) n, A = sum |S|; with extrapolateProfile U_f = U_P - (U_P . n) n \
              - (k u + s) n, u = max(-U_P . n, 0), k = Q/q and s = 0 where q = sum u |S| > \
              Q/2, else k = 1 and s = (Q - q)/A; of a mass, rho Q instead of Q",
    keys: &[
        ("volumetricFlowRate", "m3/s, a function of time"),
        ("massFlowRate", "kg/s, a function of time, in its place"),
        ("rhoInlet", "kg/m3, default that of the fluid"),
        ("extrapolateProfile", "`true`: the profile that arrives; default `false`"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(flow_rate_inlet),
};
pub(super) const OUTLET: Entry = Entry {
    name: "flowRateOutletVelocity",
    summary: "outflow of a given volume (or mass) per second with the profile that arrives, a \
              function of time",
    formula: "U_f = U_P - (U_P . n) n + (k u + s) n, u = max(U_P . n, 0), k = Q/q and s = \
              0 where q = sum u |S| > Q/2, else k = 1 and s = (Q - q)/sum |S|; of a mass, \
              rho Q instead of Q",
    keys: &[
        ("volumetricFlowRate", "m3/s, a function of time"),
        ("massFlowRate", "kg/s, a function of time, in its place"),
        ("rhoOutlet", "kg/m3, default that of the fluid"),
    ],
    reference: "OpenFOAM user guide, boundary conditions",
    scalar: None,
    vector: Some(flow_rate_outlet),
};

fn flow_rate_inlet(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    let extrapolates = r.opt_switch("extrapolateProfile", false);
    Box::new(FlowRateInlet { rate: FlowRate::read(r, c, "rhoInlet"), extrapolates })
}
fn flow_rate_outlet(r: &Reader<'_>, c: &PatchContext<'_>) -> Box<dyn Condition<Vec3>> {
    Box::new(FlowRateOutlet { rate: FlowRate::read(r, c, "rhoOutlet") })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::testing::*;
    use crate::conditions::{CaseContext, ZeroGradient};
    use crate::{Surroundings, Unknown};
    use granflow_mesh::{Mesh, shapes};
    use granflow_par::Exec;

    /// Speeds out of patch `xMin`, two by two faces of 1/4 m2 each, while the cells have (u, 3, 0).
    fn outflow(condition: Box<dyn Condition<Vec3>>, u: [f64; 4]) -> Vec<Vec3> {
        let mesh = Mesh::new(&shapes::unit_box([1, 2, 2])).unwrap();
        let patch = mesh.patches[0].faces.clone();
        assert_eq!(patch.len(), 4);
        let mut conditions: Vec<Box<dyn Condition<Vec3>>> = vec![condition];
        conditions.extend((1..mesh.patches.len()).map(|_| Box::new(ZeroGradient) as _));
        let mut field = Unknown::new(&mesh, "U", Dims::VELOCITY, [0.0; 3], conditions);
        for (f, u) in patch.clone().zip(u) {
            field.cells.data[mesh.owner[f] as usize] = [u, 3.0, 0.0];
        }
        let around = Surroundings { time: 2.0, ..Surroundings::default() };
        field.update(&Exec::serial(), &mesh, &around, None);
        patch.map(|f| field.boundary_value(&mesh, f)).collect()
    }
    fn rate(v: f64) -> FlowRate {
        FlowRate::volume(TimeFunction::table(vec![(0.0, 0.0), (4.0, 2.0 * v)]).unwrap())
    }

    #[test]
    fn an_inlet_lets_in_what_it_says_at_its_time() {
        let inlet = Box::new(FlowRateInlet { rate: rate(0.5), extrapolates: false });
        assert_eq!(outflow(inlet, [7.0; 4]), [[0.5, 0.0, 0.0]; 4]);
    }

    #[test]
    fn an_outlet_scales_or_shifts_what_arrives() {
        // 0.25 (1 + 3) = 1 m3/s arrive; the third cell comes in, which counts as nothing.
        let u = [-1.0, -3.0, 2.0, 0.0];
        let x = |v: Vec<Vec3>| v.iter().map(|v| v[0]).collect::<Vec<_>>();
        let scaled = outflow(Box::new(FlowRateOutlet { rate: rate(1.5) }), u);
        assert!(scaled.iter().all(|v| v[1] == 3.0));
        assert_eq!(x(scaled), [-1.5, -4.5, 0.0, 0.0]);
        let shifted = outflow(Box::new(FlowRateOutlet { rate: rate(2.5) }), u);
        assert_eq!(x(shifted), [-2.5, -4.5, -1.5, -1.5]);
    }

    #[test]
    fn a_mass_is_a_volume_times_the_density() {
        let x = |v: [Vec3; 4]| v.map(|v| v[0]);
        let cells = [[1.0, 2.0, 0.0]; 4];
        // 3 kg/s through 1 m2.
        let text = "type flowRateInletVelocity; massFlowRate 3; rhoInlet 2;";
        assert_eq!(x(Probe::of::<Vec3>(text).density([8.0; 4]).values(cells)), [1.5; 4]);
        let text = "type flowRateInletVelocity; massFlowRate 3; rho rho;";
        let case = CaseContext { density: 4.0, ..CaseContext::NONE };
        assert_eq!(x(Probe::within::<Vec3>(text, case).values(cells)), [0.75; 4]);
        // Of two fluids: a quarter of a square metre of each density.
        let mixed = Probe::of::<Vec3>(text).density([1.0, 2.0, 3.0, 6.0]).fraction([0.5; 4]);
        assert_eq!(x(mixed.values(cells)), [1.0; 4]);
        let text = "type flowRateOutletVelocity; massFlowRate 3; rhoOutlet 2;";
        assert_eq!(x(Probe::of::<Vec3>(text).values(cells)), [-1.5; 4]);
        let both = "type flowRateInletVelocity; massFlowRate 3; volumetricFlowRate 1;";
        assert!(mistakes::<Vec3>(both).to_string().contains("either a mass or a volume"));
    }

    #[test]
    fn an_inlet_takes_over_the_profile_that_is_there() {
        let of = |rate: f64| {
            let text = format!(
                "type flowRateInletVelocity; volumetricFlowRate {rate}; extrapolateProfile true;"
            );
            let cells = [[1.0, 5.0, 0.0], [3.0, 5.0, 0.0], [-2.0, 5.0, 0.0], [0.0, 5.0, 0.0]];
            let found = Probe::of::<Vec3>(&text).values(cells);
            assert!(found.iter().all(|u| u[1] == 5.0));
            found.map(|u| u[0])
        };
        // 1 m3/s is on its way; what leaves counts as nothing.
        assert_eq!(of(1.5), [1.5, 4.5, 0.0, 0.0]);
        assert_eq!(of(2.5), [2.5, 4.5, 1.5, 1.5]);
    }
}
