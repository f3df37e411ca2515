//! Ghosts of periodic, wedge and decomposed meshes.
#![allow(clippy::unwrap_used)]

use granflow_base::{Vec3, add, apply, dot, norm, rotation_about, scale, sub};
use granflow_mesh::{
    CyclicTransform, Mesh, MeshError, PatchKind, PolyMesh, decompose, partition, shapes,
};
use granflow_par::{Exec, InProcess};

/// Sum of outward areas of every cell, relative to the largest face.
fn openness(m: &Mesh) -> f64 {
    let sum = |c| m.faces_of(c).fold([0.0; 3], |s: Vec3, (f, k)| add(s, scale(m.area[f], k)));
    let largest = m.mag_area.iter().copied().fold(0.0, f64::max);
    (0..m.n_cells).map(|c| norm(sum(c))).fold(0.0, f64::max) / largest
}

fn unrotated_centres(m: &Mesh) -> Vec<Vec3> {
    let mut x = m.cell_centre.clone();
    x[m.n_cells..].fill([f64::NAN; 3]);
    m.halo.update(&Exec::serial(), &mut x);
    x
}

#[test]
fn periodic_box_images_lie_beside_their_faces() {
    let poly = shapes::displaced(&shapes::periodic_box([4, 3, 2], [true, false, true]), 0.2, 3);
    let m = Mesh::new(&poly).unwrap();
    assert_eq!((m.n_cells, m.n_ghosts, m.patches[0].coupled_faces.len()), (24, 36, 6));
    assert!(openness(&m) < 1e-14);
    let copied = unrotated_centres(&m);
    for f in 0..m.n_inner {
        let (o, n) = (m.owner[f] as usize, m.neighbour[f] as usize);
        assert!(norm(sub(add(m.cell_centre[o], m.delta[f]), m.cell_centre[n])) < 1e-14);
        assert!(dot(m.area[f], m.delta[f]) > 0.0);
        let shift = sub(m.cell_centre[n], copied[n]);
        if n >= m.n_cells {
            assert!(shift.iter().all(|x| (x - x.round()).abs() < 1e-13), "{shift:?}");
            assert!((norm(shift) - 1.0).abs() < 1e-13);
        }
    }
    let (a, b) = (&m.patches[0].coupled_faces, &m.patches[1].coupled_faces);
    for (&a, &b) in a.iter().zip(b) {
        let (a, b) = (a as usize, b as usize);
        assert_eq!(m.area[a], m.area[b].map(|x| -x));
        assert_eq!(m.delta[a], m.delta[b].map(|x| -x));
        assert_eq!(m.weight[b], 1.0 - m.weight[a]);
    }
}

#[test]
fn unordered_cyclic_faces_are_matched() {
    // Sorted the other way round within one half, as a foreign mesher may leave them.
    let mut poly = shapes::periodic_box([3, 4, 5], [false, true, false]);
    let p = poly.patches[3].clone();
    let faces: Vec<_> = p.faces().map(|f| (poly.face(f).to_vec(), poly.owner[f])).collect();
    for (f, (ring, owner)) in p.faces().zip(faces.into_iter().rev()) {
        let at = poly.face_ptr[f] as usize;
        poly.face_points[at..at + ring.len()].copy_from_slice(&ring);
        poly.owner[f] = owner;
    }
    let m = Mesh::new(&poly).unwrap();
    for &f in m.patches.iter().flat_map(|p| &p.coupled_faces) {
        let d = m.delta[f as usize];
        assert!(norm(sub(d, scale(m.normal(f as usize), 0.25))) < 1e-14);
    }
}

#[test]
fn a_cyclic_pair_that_does_not_match_names_the_worst_face() {
    let mut poly = shapes::periodic_box([2, 3, 2], [true, false, false]);
    let p = poly.face(poly.patches[0].start + 2)[0] as usize;
    poly.points[p][1] += 0.03;
    insta::assert_snapshot!(
        Mesh::new(&poly).err().unwrap(),
        @"cyclic patches `xMin` and `xMax` do not match: face 1 of `xMin` at (0, 0.507608, 0.246411) is 0.00841153 m from the nearest face of `xMax` (allowed: 3.10583e-5 m)"
    );
    let mut poly = shapes::periodic_box([2, 3, 2], [true, false, false]);
    poly.patches[1].kind = PatchKind::Wall;
    insta::assert_snapshot!(
        Mesh::new(&poly).err().unwrap(),
        @"cyclic patch `xMin`: its neighbourPatch `xMax` is of type wall, not cyclic"
    );
}

#[test]
fn a_given_translation_is_used_whatever_its_sign() {
    for s in [1.0, -1.0] {
        let mut poly = shapes::periodic_box([4, 2, 2], [true, false, false]);
        for p in 0..2 {
            if let PatchKind::Cyclic { transform, .. } = &mut poly.patches[p].kind {
                *transform = CyclicTransform::Translational([s, 0.0, 0.0]);
            }
        }
        let m = Mesh::new(&poly).unwrap();
        assert!(m.delta.iter().take(m.n_inner).all(|d| norm(*d) < 0.51));
    }
}

#[test]
fn annular_sectors_turn_vectors() {
    for given in [false, true] {
        let mut poly = shapes::annular_sector(1.0, 2.0, [3, 4, 2], 6);
        if given {
            for p in 2..4 {
                if let PatchKind::Cyclic { transform, .. } = &mut poly.patches[p].kind {
                    let (axis, origin) = ([0.0, 0.0, 2.0], [0.0; 3]);
                    *transform = CyclicTransform::Rotational { axis, origin, angle: None };
                }
            }
        }
        let m = Mesh::new(&poly).unwrap();
        // The velocity of a solid rotation is continuous across the cyclic faces.
        let swirl = |x: Vec3| [-x[1], x[0], 0.3];
        let mut u: Vec<Vec3> = m.cell_centre.iter().map(|&x| swirl(x)).collect();
        let exact = u.clone();
        u[m.n_cells..].fill([f64::NAN; 3]);
        m.halo.update(&Exec::serial(), &mut u);
        assert!(u.iter().zip(&exact).all(|(a, b)| norm(sub(*a, *b)) < 1e-13));
        assert!(openness(&m) < 1e-13);
        let f = m.patches[2].coupled_faces[0] as usize;
        assert!(norm(m.nonorth[f]) < 1e-13 && (m.weight[f] - 0.5).abs() < 1e-13);
    }
}

#[test]
fn wedge_ghosts_are_the_cell_turned_by_the_whole_angle() {
    let a = 2.5f64.to_radians();
    for inner in [0.0, 0.3] {
        let m = Mesh::new(&shapes::wedge_ring(inner, 1.0, 0.5, 4, 3, a)).unwrap();
        assert_eq!(m.n_ghosts, 24);
        assert!(openness(&m) < 1e-14);
        for (patch, sign) in [("minus", -1.0), ("plus", 1.0)] {
            let turn = rotation_about([0.0, 0.0, 1.0], sign * 2.0 * a);
            for &f in &m.patches[m.patch(patch).unwrap()].coupled_faces {
                let f = f as usize;
                let (o, g) = (m.owner[f] as usize, m.neighbour[f] as usize);
                assert!(m.cell_centre[o][1].abs() < 1e-16);
                assert!(norm(sub(m.cell_centre[g], apply(&turn, m.cell_centre[o]))) < 1e-15);
                assert!(norm(m.nonorth[f]) < 1e-13);
                assert_eq!((m.weight[f], m.volume[g]), (0.5, m.volume[o]));
            }
        }
        let mut u: Vec<Vec3> = m.cell_centre.iter().map(|x| [-x[1], x[0], 0.0]).collect();
        let exact = u.clone();
        m.halo.update(&Exec::serial(), &mut u);
        assert!(u.iter().zip(&exact).all(|(a, b)| norm(sub(*a, *b)) < 1e-15));
    }
}

#[test]
fn wedges_of_a_wrong_shape_are_refused() {
    let mut poly = shapes::wedge_ring(0.3, 1.0, 0.5, 2, 2, 0.04);
    poly.patches[5].kind = PatchKind::Wall;
    insta::assert_snapshot!(
        Mesh::new(&poly).err().unwrap(),
        @"wedge patch `minus`: a wedge has two patches, found 1"
    );
    let mut kinds = shapes::all(PatchKind::Patch);
    kinds[2] = PatchKind::Wedge;
    kinds[3] = PatchKind::Wedge;
    let parallel = shapes::box_mesh([2, 1, 2], [0.0; 3], [1.0; 3], kinds);
    insta::assert_snapshot!(
        Mesh::new(&parallel).err().unwrap(),
        @"wedge patch `yMin`: the wedge planes are parallel: use empty patches"
    );
}

#[test]
fn empty_patches_take_out_their_direction() {
    let m = Mesh::new(&shapes::plane_mesh(
        [3, 2],
        [0.0; 2],
        [3.0, 2.0],
        std::array::from_fn(|_| PatchKind::Wall),
    ))
    .unwrap();
    assert_eq!(m.solved_dirs, [true, true, false]);
    assert_eq!(m.patches[4].faces.len(), 0, "nothing passes them");
    assert_eq!(m.n_faces(), 17);
    assert_eq!(m.extent[0], [f64::NEG_INFINITY, f64::INFINITY]);
    let thickness = m.extent[2][1] - m.extent[2][0];
    assert!((m.volume[0] / thickness - 1.0).abs() < 1e-14, "cells are 1 m wide");
    assert!((m.cell_size(0) - 1.0).abs() < 1e-14, "whatever their thickness");
    let thick = shapes::box_mesh([2, 2, 2], [0.0; 3], [1.0; 3], {
        let mut k = shapes::all(PatchKind::Wall);
        k[4..].fill(PatchKind::Empty);
        k
    });
    insta::assert_snapshot!(Mesh::new(&thick).err().unwrap(), @"empty patch `zMin`: 8 cells have 8 empty faces, but a two-dimensional mesh is one cell thick and has two a cell");
    let skew = shapes::mapped_box(
        [2, 2, 1],
        [0.0; 3],
        [1.0; 3],
        {
            let mut k = shapes::all(PatchKind::Wall);
            k[4] = PatchKind::Empty;
            k
        },
        |p| [p[0], p[1], p[2] + 0.2 * p[0]],
    );
    let error = Mesh::new(&skew).err().unwrap();
    assert!(matches!(&error, MeshError::Empty { patch, .. } if patch == "zMin"), "{error}");
}

/// Every rank exchanges its cell centres; ghosts must then image where the mesh says.
fn decomposition_is_consistent(poly: &PolyMesh, ranks: usize) {
    let whole = Mesh::new(poly).unwrap();
    let parts = decompose(poly, &partition(poly, ranks)).unwrap();
    assert_eq!(parts.len(), ranks);
    let volume: f64 = parts.iter().flat_map(|m| &m.volume[..m.n_cells]).sum();
    let expected: f64 = whole.volume[..whole.n_cells].iter().sum();
    assert!((volume / expected - 1.0).abs() < 1e-13);
    let boundary = |m: &Mesh| m.n_faces() - m.n_inner;
    assert_eq!(parts.iter().map(boundary).sum::<usize>(), boundary(&whole));
    for (i, p) in whole.patches.iter().enumerate() {
        let here: usize = parts.iter().map(|m| m.patches[i].coupled_faces.len()).sum();
        assert_eq!(here, p.coupled_faces.len());
    }
    // What the ghost behind every face of the whole mesh holds.
    let field = |m: &Mesh| -> Vec<Vec3> {
        let g = |c: usize| f64::from(m.global_cell[c]);
        (0..m.n_cells)
            .map(|c| [g(c), g(c).sin(), 1.0])
            .chain(vec![[f64::NAN; 3]; m.n_ghosts])
            .collect()
    };
    let mut reference = field(&whole);
    whole.halo.update(&Exec::serial(), &mut reference);
    let of_poly: std::collections::HashMap<u32, usize> =
        (0..whole.n_inner).map(|f| (whole.poly_face[f] >> 1, f)).collect();
    let world = InProcess::world(ranks);
    std::thread::scope(|s| {
        for (m, comm) in parts.iter().zip(world) {
            let (of_poly, whole, reference) = (&of_poly, &whole, &reference);
            s.spawn(move || {
                let exec = Exec::new(1, Box::new(comm));
                let mut x = field(m);
                m.halo.update(&exec, &mut x);
                for f in 0..m.n_inner {
                    let w = of_poly[&(m.poly_face[f] >> 1)];
                    let flipped = m.poly_face[f] & 1 == 1;
                    let (o, n) = (whole.owner[w] as usize, whole.neighbour[w] as usize);
                    let (o, n) = if flipped { (n, o) } else { (o, n) };
                    let here = m.neighbour[f] as usize;
                    assert_eq!(m.global_cell[m.owner[f] as usize] as usize, o);
                    assert_eq!(x[here], reference[n], "face {f} of rank {}", exec.rank());
                    assert_eq!(m.cell_centre[here], whole.cell_centre[n]);
                    assert_eq!(m.volume[here], whole.volume[n]);
                    let span = sub(m.cell_centre[here], m.cell_centre[m.owner[f] as usize]);
                    assert!(norm(sub(span, m.delta[f])) < 1e-13);
                    assert!(dot(m.area[f], m.delta[f]) > 0.0);
                }
                assert!(openness(m) < 1e-13);
            });
        }
    });
}

#[test]
fn decomposed_meshes_agree_with_the_whole() {
    let cube = shapes::displaced(&shapes::periodic_box([5, 4, 3], [true, true, false]), 0.2, 1);
    let shuffled = shapes::shuffled(&cube, 5);
    let sector = shapes::annular_sector(1.0, 2.0, [3, 7, 2], 5);
    let wedge = shapes::wedge_ring(0.0, 1.0, 1.0, 5, 6, 0.04);
    let thin = shapes::periodic_box([6, 1, 1], [true, true, true]);
    for poly in [&cube, &shuffled, &sector, &wedge, &thin] {
        for ranks in [1, 2, 3, 4] {
            decomposition_is_consistent(poly, ranks);
        }
    }
}

#[test]
fn a_scattered_partition_works_too() {
    let poly = shapes::periodic_box([4, 4, 2], [true, false, true]);
    let part: Vec<u32> = (0..32).map(|c| (c * 7 % 5) as u32 % 3).collect();
    let parts = decompose(&poly, &part).unwrap();
    assert_eq!(parts.iter().map(|m| m.n_cells).sum::<usize>(), 32);
    let error = decompose(&poly, &[0; 31]).err().unwrap();
    assert_eq!(error.to_string(), "the partition has 31 entries for 32 cells");
    let error = decompose(&poly, &[1; 32]).err().unwrap();
    assert_eq!(error.to_string(), "the partition leaves rank 0 without cells");
}

#[test]
fn inverted_cells_are_named() {
    let mut poly = shapes::unit_box([2, 2, 2]);
    poly.points[13] = [2.5, 2.5, 2.5];
    assert!(matches!(Mesh::new(&poly).err(), Some(MeshError::Volume { .. })));
}

mod laws {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn displaced_points_keep_cells_closed_and_space_filled(
            seed in 0u64..1 << 40, amount in 0.0..0.25f64, n in 2usize..5, prisms: bool,
        ) {
            let (n, kinds) = ([n, 3, 4], shapes::all(PatchKind::Wall));
            let base = if prisms { shapes::prism_box(n, [0.0; 3], [1.0; 3], kinds) }
                       else { shapes::box_mesh(n, [0.0; 3], [1.0; 3], kinds) };
            let m = Mesh::new(&shapes::displaced(&base, amount, seed)).unwrap();
            prop_assert!(openness(&m) < 1e-13);
            prop_assert!((m.volume.iter().sum::<f64>() - 1.0).abs() < 1e-13);
            // Gauss: the integral of x over the cells is that of the centroids.
            for f in 0..m.n_inner {
                prop_assert!(dot(m.area[f], m.delta[f]) > 0.0);
                prop_assert!((0.05..0.95).contains(&m.weight[f]));
                prop_assert!(dot(m.skew[f], m.area[f]).abs() < 1e-12 * m.mag_area[f]);
                let n = m.normal(f);
                let rebuilt = add(scale(m.delta[f], m.inv_dist[f]), m.nonorth[f]);
                prop_assert!(norm(sub(rebuilt, n)) < 1e-12);
            }
        }
    }
}
