//! Shapes carried by known flows: meshes, fluxes and errors for the tests of `vof`.
#![allow(dead_code, unreachable_pub)]

use granflow_base::{Dims, Vec3, add, dot, scale, sub};
use granflow_flow::vof::{self, Corners, Drive, Params, Shape, Vof, VofReport};
use granflow_fv::conditions::{OfPatchType, ZeroGradient};
use granflow_fv::{Condition, FaceField, Surroundings, Unknown};
use granflow_mesh::{Mesh, PatchKind, PolyMesh, shapes};
use granflow_par::Exec;
use std::f64::consts::{PI, TAU};

/// Flux of `curl A` through every face by Stokes's theorem, five Gauss points an edge: every edge
/// counts once each way, so the sum over a cell is zero but for rounding.
pub fn flux_of(poly: &PolyMesh, mesh: &Mesh, a: impl Fn(Vec3) -> Vec3, out: &mut [f64]) {
    const X: [f64; 5] = [
        -0.906_179_845_938_664,
        -0.538_469_310_105_683,
        0.0,
        0.538_469_310_105_683,
        0.906_179_845_938_664,
    ];
    const W: [f64; 5] = [
        0.236_926_885_056_189,
        0.478_628_670_499_366,
        0.568_888_888_888_889,
        0.478_628_670_499_366,
        0.236_926_885_056_189,
    ];
    // One direction per edge, so that both faces get the same bits.
    let edge = |p: u32, q: u32| {
        let (i, j, sign) = if p < q { (p, q, 1.0) } else { (q, p, -1.0) };
        let (x, y) = (poly.points[i as usize], poly.points[j as usize]);
        let along = scale(sub(y, x), 0.5);
        let mid = scale(add(x, y), 0.5);
        let sum: f64 =
            X.iter().zip(W).map(|(&t, w)| w * dot(a(add(mid, scale(along, t))), along)).sum();
        sign * sum
    };
    for (f, &e) in mesh.poly_face.iter().enumerate() {
        let ring = poly.face((e >> 1) as usize);
        let sum: f64 = (0..ring.len()).map(|i| edge(ring[i], ring[(i + 1) % ring.len()])).sum();
        out[f] = if e & 1 == 1 { -sum } else { sum };
    }
    // The two faces of a coupled pair agree but for rounding.
    for p in mesh.patches.iter().filter(|p| p.kind == PatchKind::Empty) {
        p.faces.clone().for_each(|f| out[f] = 0.0);
    }
}

/// Vector potentials of the usual flows.
pub fn uniform(u: Vec3) -> impl Fn(Vec3) -> Vec3 {
    // A = u x r / 2.
    move |x| scale(granflow_base::cross(u, x), 0.5)
}
pub fn plane(psi: impl Fn(f64, f64) -> f64) -> impl Fn(Vec3) -> Vec3 {
    move |[x, y, _]| [0.0, 0.0, psi(x, y)]
}
/// One turn a second about the middle of the unit square.
pub fn rotation() -> impl Fn(Vec3) -> Vec3 {
    plane(|x, y| -PI * ((x - 0.5).powi(2) + (y - 0.5).powi(2)))
}
/// Rider & Kothe's single vortex in the unit square.
pub fn vortex() -> impl Fn(Vec3) -> Vec3 {
    plane(|x, y| -((PI * x).sin() * (PI * y).sin()).powi(2) / PI)
}
/// LeVeque's (1996) deformation of the unit cube.
pub fn deformation([x, y, z]: Vec3) -> Vec3 {
    let s2 = |t: f64| (PI * t).sin().powi(2);
    let (s, c) = (|t: f64| (TAU * t).sin(), |t: f64| (TAU * t).cos());
    let k = 1.0 / TAU;
    [0.0, k * c(x) * s(y) * s2(z), -k * (c(x) * s2(y) * s(z) + c(y) * s(z))]
}

/// The condition of every patch for a fraction: what the patch dictates, else free.
pub fn free(mesh: &Mesh) -> Vec<Box<dyn Condition<f64>>> {
    let one = |kind: &PatchKind| -> Box<dyn Condition<f64>> {
        let of = |kind| Box::new(OfPatchType { kind, symmetric: false }) as Box<dyn Condition<f64>>;
        match kind {
            PatchKind::Wedge => of("wedge"),
            PatchKind::Cyclic { .. } => of("cyclic"),
            PatchKind::Empty => of("empty"),
            _ => Box::new(ZeroGradient),
        }
    };
    mesh.patches.iter().map(|p| one(&p.kind)).collect()
}

/// A fraction on its way.
pub struct Run {
    pub exec: Exec,
    pub poly: PolyMesh,
    pub mesh: Mesh,
    pub alpha: Unknown<f64>,
    pub phi: FaceField<f64>,
    /// Fluxes at unit strength.
    pub steady: Vec<f64>,
    pub vof: Vof,
    pub time: f64,
    pub steps: usize,
    /// Greatest violation of 0..1 seen.
    pub beyond: f64,
    /// Sum of the volume errors of the steps relative to the volume.
    pub volume_error: f64,
    pub passes: usize,
    pub courant: f64,
    pub seconds: f64,
    pub first_volume: f64,
    /// Fluid 1 that came and went through the boundary, m3.
    pub crossed_boundary: f64,
}

impl Run {
    pub fn new(exec: Exec, poly: PolyMesh, params: &Params, a: impl Fn(Vec3) -> Vec3) -> Run {
        let mesh = Mesh::new(&poly).expect("a sound mesh");
        let mut alpha = Unknown::new(&mesh, "alpha", Dims::NONE, 0.0, free(&mesh));
        alpha.update(&exec, &mesh, &Surroundings::default(), None);
        let mut phi = FaceField::new(&mesh, "phi", Dims::VOLUME_FLUX, 0.0);
        flux_of(&poly, &mesh, a, &mut phi.data);
        let vof = Vof::new(&exec, &poly, &mesh, params).expect("a method");
        Run {
            steady: phi.data.clone(),
            exec,
            poly,
            mesh,
            alpha,
            phi,
            vof,
            time: 0.0,
            steps: 0,
            beyond: 0.0,
            volume_error: 0.0,
            passes: 0,
            courant: 0.0,
            seconds: 0.0,
            first_volume: 0.0,
            crossed_boundary: 0.0,
        }
    }

    /// The fractions of a sum of shapes, each with its sign.
    pub fn exact(&self, sum: &[(f64, Shape)]) -> Vec<f64> {
        let corners = Corners::new(&self.poly, &self.mesh);
        let mut total = vec![0.0; self.mesh.n_all()];
        let mut one = total.clone();
        for (sign, shape) in sum {
            vof::fill(&self.exec, &self.mesh, &corners, shape, &mut one);
            total.iter_mut().zip(&one).for_each(|(t, o)| *t += sign * o);
        }
        // A difference of two rounded numbers.
        total.iter_mut().for_each(|t| {
            if *t < 1e-12 {
                *t = 0.0;
            }
        });
        total
    }

    pub fn start(mut self, sum: &[(f64, Shape)]) -> Run {
        self.alpha.cells.data = self.exact(sum);
        self.first_volume = self.volume();
        self
    }

    /// Steps of equal length to `end`; the flow's strength is `strength(t)` at mid-step.
    pub fn go(&mut self, end: f64, steps: usize, strength: impl Fn(f64) -> f64) -> VofReport {
        let dt = (end - self.time) / steps as f64;
        let mut report = VofReport::default();
        for _ in 0..steps {
            let k = strength(self.time + 0.5 * dt);
            self.phi.data.iter_mut().zip(&self.steady).for_each(|(p, s)| *p = k * s);
            let around = Surroundings::default();
            let clock = std::time::Instant::now();
            let Run { vof, exec, mesh, alpha, phi, .. } = self;
            report =
                vof.advance(exec, mesh, alpha, Drive { phi, dt, around: &around }).expect("a step");
            self.seconds += clock.elapsed().as_secs_f64();
            let boundary = &self.vof.alpha_phi().data[self.mesh.n_inner..];
            self.crossed_boundary += dt * boundary.iter().map(|q| q.abs()).sum::<f64>();
            self.time += dt;
            self.steps += 1;
            self.beyond = self.beyond.max(-report.min).max(report.max - 1.0);
            self.volume_error += report.volume_error.abs() / report.volume;
            self.passes += report.bound_passes;
            self.courant = self.courant.max(report.interface_courant);
        }
        report
    }

    /// `E1 = sum V |alpha - exact| / sum V exact`.
    pub fn error(&self, exact: &[f64]) -> f64 {
        let v = &self.mesh.volume;
        let own = 0..self.mesh.n_cells;
        let wrong: f64 =
            own.clone().map(|c| v[c] * (self.alpha.cells.data[c] - exact[c]).abs()).sum();
        wrong / own.map(|c| v[c] * exact[c]).sum::<f64>()
    }
    /// Volume of fluid 1 by compensated summation.
    pub fn volume(&self) -> f64 {
        let (mut s, mut e) = (0.0, 0.0);
        for c in 0..self.mesh.n_cells {
            let y = self.mesh.volume[c] * self.alpha.cells.data[c] - e;
            let t: f64 = s + y;
            e = (t - s) - y;
            s = t;
        }
        s
    }
    /// Change of the volume since the start, relative.
    pub fn drift(&self) -> f64 {
        (self.volume() - self.first_volume).abs() / self.first_volume
    }
    /// Nanoseconds per cell and step.
    pub fn cost(&self) -> f64 {
        1e9 * self.seconds / (self.steps * self.mesh.n_cells) as f64
    }
    pub fn line(&self, what: &str, e1: f64) -> String {
        format!(
            "{what:<34} E1 {e1:.3e}  beyond {:.1e}  volume {:.1e} ({:.1e})  passes/step {:.2}  Co {:.2}  {:.0} ns/cell/step",
            self.beyond,
            self.volume_error,
            self.drift(),
            self.passes as f64 / self.steps as f64,
            self.courant,
            self.cost()
        )
    }
}

pub fn disc(x: f64, y: f64, r: f64) -> Shape {
    Shape::cylinder([x, y, 0.0], [0.0, 0.0, 1.0], r)
}
/// Zalesak's disc: a slot 0.05 wide from below, 0.1 short of the top.
pub fn slotted() -> Vec<(f64, Shape)> {
    let slot = Shape::cuboid([0.475, 0.0, -1.0], [0.525, 0.85, 1.0]);
    vec![(1.0, disc(0.5, 0.75, 0.15)), (-1.0, disc(0.5, 0.75, 0.15).and(&slot))]
}

/// The unit square by squares, or by triangles (cells split along alternating diagonals).
pub fn square(n: usize, kind: PatchKind) -> PolyMesh {
    shapes::plane_mesh([n, n], [0.0; 2], [1.0; 2], std::array::from_fn(|_| kind.clone()))
}
pub fn triangles(n: usize) -> PolyMesh {
    let mut kinds = shapes::all(PatchKind::Patch);
    kinds[4] = PatchKind::Empty;
    kinds[5] = PatchKind::Empty;
    shapes::prism_box([n, n, 1], [0.0; 3], [1.0, 1.0, 1.0 / n as f64], kinds)
}

/// A disc in the unit square with all its images that reach into it.
pub fn periodic_disc(x: f64, y: f64, r: f64) -> Vec<(f64, Shape)> {
    let shift = [-1.0, 0.0, 1.0];
    shift.iter().flat_map(|i| shift.map(|j| (1.0, disc(x + i, y + j, r)))).collect()
}

/// Numbers with two digits, for messages.
pub fn short(x: &[f64]) -> String {
    x.iter().map(|x| format!("{x:.1e}")).collect::<Vec<_>>().join(" ")
}
