//! Laws of ARCHITECTURE.md that the volume fraction can break: the same bits for any number of
//! threads, the same answer for any number of ranks, no allocation after the second step.

#[path = "common/counting.rs"]
mod counting;
mod vof_common;

use counting::ALLOCATIONS;
use granflow_base::Dims;
use granflow_flow::vof::{
    AlgebraicParams, Drive, GeometricParams, Params, Reconstruct, Shape, Vof, VofReport, fill,
};
use granflow_fv::{FaceField, Surroundings, Unknown};
use granflow_mesh::{PolyMesh, decompose, partition, shapes};
use granflow_par::{Exec, InProcess, Solo};
use vof_common::*;

fn all() -> Vec<Params> {
    let geometric = |reconstruction| {
        Params::Geometric(GeometricParams { reconstruction, ..GeometricParams::default() })
    };
    let algebraic = |mules_corr| {
        Params::Algebraic(AlgebraicParams {
            mules_corr,
            n_alpha_corr: 2,
            n_alpha_sub_cycles: 2,
            ic_alpha: 0.1,
            ..AlgebraicParams::default()
        })
    };
    let mut list: Vec<Params> =
        [Reconstruct::IsoAlpha, Reconstruct::GradAlpha, Reconstruct::PlicRdf].map(geometric).into();
    list.extend([algebraic(false), algebraic(true)]);
    list
}

fn ball() -> [(f64, Shape); 1] {
    [(1.0, Shape::sphere([0.35, 0.4, 0.45], 0.2))]
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let poly = shapes::displaced(&shapes::periodic_box([22; 3], [true, false, true]), 0.15, 1);
    for p in all() {
        let fractions = |threads: usize| {
            let exec = Exec::new(threads, Box::new(Solo));
            let mut run = Run::new(exec, poly.clone(), &p, uniform([1.0, 0.6, 0.3])).start(&ball());
            run.go(0.06, 4, |_| 1.0);
            let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
            let n = run.mesh.n_cells;
            [bits(&run.alpha.cells.data[..n]), bits(&run.vof.alpha_phi().data)]
        };
        let serial = fractions(1);
        for threads in [2, 3] {
            assert!(serial == fractions(threads), "{p:?}, {threads} threads");
        }
    }
}

#[test]
fn no_allocation_after_the_second_step() {
    let poly = shapes::displaced(&shapes::periodic_box([12; 3], [true, false, true]), 0.15, 1);
    for p in all() {
        let mut run =
            Run::new(Exec::serial(), poly.clone(), &p, uniform([1.0, 0.6, 0.3])).start(&ball());
        run.go(0.04, 2, |_| 1.0);
        let before = ALLOCATIONS.get();
        run.go(0.3, 12, |_| 1.0);
        assert_eq!(ALLOCATIONS.get() - before, 0, "{p:?}");
    }
}

/// Fractions by cell of the whole mesh after some steps on as many ranks as `part` names.
fn on_ranks(poly: &PolyMesh, part: &[u32], p: &Params) -> (Vec<f64>, VofReport) {
    let meshes = decompose(poly, part).expect("parts");
    let one = |comm: InProcess, mesh: &granflow_mesh::Mesh| {
        let exec = Exec::new(1, Box::new(comm));
        let mut vof = Vof::new(&exec, poly, mesh, p).expect("a method");
        let mut alpha = Unknown::new(mesh, "alpha", Dims::NONE, 0.0, free(mesh));
        let corners = granflow_flow::vof::Corners::new(poly, mesh);
        fill(&exec, mesh, &corners, &ball()[0].1, &mut alpha.cells.data);
        let mut phi = FaceField::new(mesh, "phi", Dims::VOLUME_FLUX, 0.0);
        flux_of(poly, mesh, uniform([1.0, 0.6, 0.3]), &mut phi.data);
        let around = Surroundings::default();
        let drive = Drive { phi: &phi, dt: 0.02, around: &around };
        let mut report = VofReport::default();
        for _ in 0..10 {
            report = vof.advance(&exec, mesh, &mut alpha, drive).expect("a step");
        }
        let cells = &alpha.cells.data[..mesh.n_cells];
        (mesh.global_cell.iter().copied().zip(cells.to_vec()).collect::<Vec<_>>(), report)
    };
    let parts: Vec<_> = std::thread::scope(|s| {
        let one = &one;
        let ranks: Vec<_> = InProcess::world(meshes.len())
            .into_iter()
            .zip(&meshes)
            .map(|(comm, mesh)| s.spawn(move || one(comm, mesh)))
            .collect();
        ranks.into_iter().map(|r| r.join().expect("a rank")).collect()
    });
    let mut whole = vec![f64::NAN; part.len()];
    for (c, a) in parts.iter().flat_map(|p| &p.0) {
        whole[*c as usize] = *a;
    }
    (whole, parts[0].1)
}

#[test]
fn ranks_agree_with_one() {
    let poly = shapes::displaced(&shapes::periodic_box([10; 3], [true, false, true]), 0.15, 1);
    for p in all() {
        let (serial, first) = on_ranks(&poly, &vec![0; 1000], &p);
        for ranks in [2, 3, 5] {
            let (parallel, report) = on_ranks(&poly, &partition(&poly, ranks), &p);
            let differ =
                serial.iter().zip(&parallel).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(differ < 1e-8, "{p:?}, {ranks} ranks: {differ}");
            assert_eq!(report.mixed_cells, first.mixed_cells);
            assert!((report.volume / first.volume - 1.0).abs() < 1e-12);
        }
    }
}
