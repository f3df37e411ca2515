//! The nonlocal rheology where velocity has more than one component and pressure more than one
//! value: sectors that turn, and cells that stand in gravity.

mod common;
use common::*;
use granflow_flow::{Flow, Report};
use granflow_mesh::{PolyMesh, shapes};
use granflow_physics::rheology::Form;

const RI: f64 = 0.051;
const RO: f64 = 0.063;
const HEIGHT: f64 = 0.01;

/// The annular cell on `poly` at 0.51 mm/s of the inner wall; `g` m/s2 along the axis.
fn annular(poly: &PolyMesh, v: f64, p: f64, g: f64, form: Form) -> Flow {
    let mut numerics = numerics(150, 1);
    numerics.u = solve("GAMG", "none");
    numerics.p = solve("GAMG", "none");
    numerics.compression = solver("GAMG", "none");
    let mut s = Setup::new(poly, numerics);
    s.gravity.hydrostatic = [0.0, 0.0, -g];
    // p_rgh is the pressure where z = 0.
    s.p0 = p + RHO_B * g * HEIGHT;
    let (rheology, p0) = (ngf(&s.exec, &s.mesh, BEADS, form), s.p0);
    s.flow(
        rheology,
        |patch| match patch {
            "inner" => turning(v, RI),
            "outer" => turning(0.0, RO),
            _ => slip(),
        },
        move |patch| if patch == "outer" { fixed(p0) } else { free() },
    )
}

/// A twelfth of the ring, its corners outside the radii, so that the flat faces of the walls are at
/// the right ones.
fn sector(n: [usize; 3]) -> PolyMesh {
    let mut poly = shapes::annular_sector(RI, RO, n, 12);
    let top = poly.points.iter().map(|p| p[2]).fold(0.0, f64::max);
    let out = 1.0 / (0.5 * 30f64.to_radians() / n[1] as f64).cos();
    for p in &mut poly.points {
        *p = [p[0] * out, p[1] * out, p[2] * HEIGHT / top];
    }
    poly
}

fn step(flow: &mut Flow, dt: f64) -> Report {
    let report = flow.step(dt).expect("a step");
    assert!(report.converged, "dt {dt:.0e}: {report:?}");
    report
}

/// In a sector of 30 degrees with cyclic sides the Cartesian components of a profile of one
/// variable are three-dimensional; it meets the same reference.
#[test]
fn sector_meets_the_reference() {
    let rows = reference("annular_shear_cell/reference/annular_steady_neumann_I1e-03.csv");
    let p = 1000.0;
    let v = 2.9256998922e-3 * (p / BEADS.rho_s).sqrt();
    let errors = [[32, 6, 1], [64, 6, 3]].map(|n| {
        let mut flow = annular(&sector(n), v, p, 0.0, Form::Steady);
        step(&mut flow, 1e6);
        let (m, u) = (&flow.mesh, &flow.state.u.cells.data);
        let e = greatest(m, |c| {
            let [x, y, _] = m.cell_centre[c];
            let (r, along) = (x.hypot(y), (u[c][1] * x - u[c][0] * y) / x.hypot(y));
            (along / v - interpolate(&rows, 0, 5, (r - RI) / BEADS.d)).abs()
        });
        let across = greatest(m, |c| {
            let [x, y, _] = m.cell_centre[c];
            ((u[c][0] * x + u[c][1] * y) / x.hypot(y)).hypot(u[c][2]) / v
        });
        println!("sector, {n:?}: V {e:.2e}, across {across:.1e}");
        assert!(across < 1e-4, "across {across:.1e}");
        e
    });
    println!("sector: orders {:?}", orders(&errors));
    // Cells of 5 degrees cost more than the wedge's one (6e-5 with 4 cells a grain).
    assert!(orders(&errors)[0] > 1.8 && errors[1] < 6e-4, "{errors:?}");
}

/// Gravity along the axis, pressure of 75 Pa at the top: both forms, from rest, with steps from a
/// tenth of a millisecond on, in the plane of r and z and in three dimensions.
#[test]
fn gravity_along_the_axis_with_any_step() {
    for form in [Form::Steady, Form::Primitive { t0: 1e-4 }] {
        let plane = shapes::wedge_ring(RI, RO, HEIGHT, 32, 8, 0.5f64.to_radians());
        for poly in [plane, sector([16, 5, 3])] {
            println!("{form:?}, {} cells", poly.owner.iter().max().map_or(0, |c| c + 1));
            for dt in [1e-4, 1e-2, 1.0, 1e6] {
                let mut flow = annular(&poly, 5e-4, 75.0, 9.81, form);
                step(&mut flow, dt);
                step(&mut flow, dt);
            }
        }
    }
}

/// What stands at the end does not depend on the steps that led there.
#[test]
fn one_steady_state_under_gravity() {
    let poly = shapes::wedge_ring(RI, RO, HEIGHT, 24, 6, 0.5f64.to_radians());
    let v = 5e-4;
    let [slow, fast] = [(0.05, 60), (1e6, 2)].map(|(dt, steps)| {
        let mut flow = annular(&poly, v, 75.0, 9.81, Form::Steady);
        for _ in 0..steps {
            step(&mut flow, dt);
        }
        flow.state.u.cells.data
    });
    let n = poly.owner.iter().max().map_or(0, |c| *c as usize + 1);
    let apart = (0..n)
        .flat_map(|c| (0..3).map(move |k| (c, k)))
        .map(|(c, k)| (slow[c][k] - fast[c][k]).abs() / v)
        .fold(0.0, f64::max);
    println!("60 steps of 0.05 s and 2 of 1e6 s: apart by {apart:.1e} of the wall's speed");
    assert!(apart < 1e-6, "{apart:.1e}");
}
