//! Which face lies behind which across cyclic and wedge patches, and by what motion.

use crate::geometry::Geometry;
use crate::polymesh::{CyclicTransform, MeshError, PatchKind, PolyMesh, PolyPatch, place};
use granflow_base::{
    IDENTITY, Tensor, Vec3, add, apply, cross, dot, norm, rotation_about, scale, sub, transpose,
    unit,
};

/// Greatest gap between matched face centres, relative to the size of the face.
const MATCH_TOLERANCE: f64 = 1e-4;

/// A rigid motion `x -> origin + rotation (x - origin) + shift`.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    pub(crate) rotation: Option<Tensor>,
    origin: Vec3,
    shift: Vec3,
}

impl Motion {
    fn translation(shift: Vec3) -> Motion {
        Motion { rotation: None, origin: [0.0; 3], shift }
    }
    fn rotation(axis: Vec3, angle: f64, origin: Vec3) -> Motion {
        Motion { rotation: Some(rotation_about(axis, angle)), origin, shift: [0.0; 3] }
    }
    /// Where a point goes.
    pub(crate) fn point(&self, x: Vec3) -> Vec3 {
        match &self.rotation {
            None => add(x, self.shift),
            Some(r) => add(add(self.origin, apply(r, sub(x, self.origin))), self.shift),
        }
    }
    /// What becomes of a vector.
    pub(crate) fn vector(&self, v: Vec3) -> Vec3 {
        self.rotation.as_ref().map_or(v, |r| apply(r, v))
    }
    fn inverse(&self) -> Motion {
        let back = self.rotation.as_ref().map(transpose);
        let shift = scale(back.as_ref().map_or(self.shift, |r| apply(r, self.shift)), -1.0);
        Motion { rotation: back, origin: self.origin, shift }
    }
}

/// One coupled patch: what lies behind its faces.
#[derive(Clone, Debug)]
pub(crate) struct Coupling {
    /// The patch.
    pub(crate) patch: usize,
    /// The patch its ghosts come from.
    pub(crate) partner: usize,
    /// For every face of the patch, the face of `partner` (counted within it) it lies on.
    pub(crate) pairs: Vec<u32>,
    /// Brings the partner's side behind this patch.
    pub(crate) motion: Motion,
}

/// Area-weighted summary of a patch.
struct Summary {
    area: Vec3,
    mag: f64,
    centre: Vec3,
}

fn summary(p: &PolyPatch, g: &Geometry) -> Summary {
    let (mut area, mut mag, mut moment) = ([0.0; 3], 0.0, [0.0; 3]);
    for f in p.faces() {
        let m = norm(g.area[f]);
        area = add(area, g.area[f]);
        mag += m;
        moment = add(moment, scale(g.face_centre[f], m));
    }
    Summary { area, mag, centre: scale(moment, 1.0 / mag.max(f64::MIN_POSITIVE)) }
}

/// All couplings of a mesh, in patch order; patches without faces are left out.
pub(crate) fn couplings(poly: &PolyMesh, g: &Geometry) -> Result<Vec<Coupling>, MeshError> {
    let mut all: Vec<Coupling> = Vec::new();
    for (i, p) in poly.patches.iter().enumerate() {
        let PatchKind::Cyclic { neighbour, transform } = &p.kind else { continue };
        let j = partner(poly, i, neighbour)?;
        if p.len == 0 {
            continue;
        }
        if let Some(done) = all.iter().find(|c| c.patch == j) {
            // The second half is the exact inverse of the first: fluxes then agree bit for bit.
            let mut pairs = vec![0u32; p.len];
            done.pairs.iter().enumerate().for_each(|(a, &b)| pairs[b as usize] = a as u32);
            let motion = done.motion.inverse();
            all.push(Coupling { patch: i, partner: j, pairs, motion });
            continue;
        }
        let motion = cyclic_motion(poly, g, i, j, transform)?;
        let pairs = match_faces(poly, g, i, j, &motion)?;
        all.push(Coupling { patch: i, partner: j, pairs, motion });
    }
    all.extend(wedges(poly, g)?);
    all.sort_by_key(|c| c.patch);
    Ok(all)
}

/// The other half of cyclic patch `i`.
fn partner(poly: &PolyMesh, i: usize, neighbour: &str) -> Result<usize, MeshError> {
    let p = &poly.patches[i];
    let fault = |reason: String| MeshError::CyclicPair { patch: p.name.clone(), reason };
    let j = poly
        .patch(neighbour)
        .ok_or_else(|| fault(format!("there is no patch `{neighbour}` (its neighbourPatch)")))?;
    let q = &poly.patches[j];
    match &q.kind {
        _ if i == j => Err(fault("it names itself as neighbourPatch".into())),
        PatchKind::Cyclic { neighbour: back, .. } if *back == p.name => {
            if p.len == q.len {
                Ok(j)
            } else {
                let (n, m) = (p.len, q.len);
                Err(fault(format!("it has {n} faces, its neighbourPatch `{neighbour}` {m}")))
            }
        }
        PatchKind::Cyclic { neighbour: back, .. } => Err(fault(format!(
            "its neighbourPatch `{neighbour}` names `{back}` as neighbourPatch in return"
        ))),
        other => Err(fault(format!(
            "its neighbourPatch `{neighbour}` is of type {}, not cyclic",
            other.word()
        ))),
    }
}

/// The motion that brings patch `j` onto patch `i`.
fn cyclic_motion(
    poly: &PolyMesh,
    g: &Geometry,
    i: usize,
    j: usize,
    transform: &CyclicTransform,
) -> Result<Motion, MeshError> {
    let fault = |reason: &str| MeshError::CyclicPair {
        patch: poly.patches[i].name.clone(),
        reason: reason.into(),
    };
    let (a, b) = (summary(&poly.patches[i], g), summary(&poly.patches[j], g));
    let step = sub(a.centre, b.centre);
    // A half may leave the transform to its partner.
    let transform = match (transform, &poly.patches[j].kind) {
        (CyclicTransform::Unknown, PatchKind::Cyclic { transform, .. }) => transform,
        (t, _) => t,
    };
    match *transform {
        CyclicTransform::Translational(s) => {
            // Files differ about the sign of the separation: the faces tell.
            let sign = if dot(s, step) < 0.0 { -1.0 } else { 1.0 };
            Ok(Motion::translation(scale(s, sign)))
        }
        CyclicTransform::Rotational { axis, origin, angle } => {
            let k = unit(axis);
            if norm(k) == 0.0 {
                return Err(fault("its rotationAxis is the null vector"));
            }
            let found = turn_between(scale(b.area, -1.0), a.area, k, b.mag)
                .or_else(|| {
                    let (u, v) = (sub(b.centre, origin), sub(a.centre, origin));
                    turn_between(u, v, k, norm(u) + norm(v))
                })
                .ok_or_else(|| fault("its rotation angle cannot be told from its faces"))?;
            // As with translations, the sign convention is settled by the faces.
            let angle = angle.map_or(found, |t| t.abs().copysign(found));
            Ok(Motion::rotation(k, angle, origin))
        }
        CyclicTransform::Unknown => {
            if norm(add(a.area, b.area)) <= 1e-4 * (a.mag + b.mag) {
                return Ok(Motion::translation(step));
            }
            let (u, v) = (scale(b.area, -1.0), a.area);
            let k = cross(u, v);
            if norm(k) <= 1e-6 * a.mag * b.mag {
                return Err(fault(
                    "its motion cannot be told from its faces; give transform, rotationAxis \
                     and rotationCentre",
                ));
            }
            let k = unit(k);
            let angle = dot(k, cross(u, v)).atan2(dot(u, v));
            Ok(Motion::rotation(k, angle, centre_of_turn(b.centre, a.centre, k, angle)))
        }
    }
}

/// Angle about `k` from `u` to `v`, if both have a part normal to `k` (relative to `size`).
fn turn_between(u: Vec3, v: Vec3, k: Vec3, size: f64) -> Option<f64> {
    let normal_part = |x: Vec3| sub(x, scale(k, dot(x, k)));
    let (u, v) = (normal_part(u), normal_part(v));
    let found = norm(u).min(norm(v)) > 1e-3 * size;
    found.then(|| dot(k, cross(u, v)).atan2(dot(u, v)))
}

/// The point about which a turn by `angle` about `k` takes `from` to `to`.
fn centre_of_turn(from: Vec3, to: Vec3, k: Vec3, angle: f64) -> Vec3 {
    let chord = sub(to, from);
    let chord = sub(chord, scale(k, dot(chord, k)));
    let middle = scale(add(from, to), 0.5);
    add(middle, scale(cross(k, chord), 0.5 / (0.5 * angle).tan()))
}

/// Pairs the faces of patch `i` with those of `j` brought over by `motion`.
fn match_faces(
    poly: &PolyMesh,
    g: &Geometry,
    i: usize,
    j: usize,
    motion: &Motion,
) -> Result<Vec<u32>, MeshError> {
    let (p, q) = (&poly.patches[i], &poly.patches[j]);
    let image: Vec<Vec3> = q.faces().map(|f| motion.point(g.face_centre[f])).collect();
    let size = |f: usize| {
        let reach = |&k: &u32| norm(sub(poly.points[k as usize], g.face_centre[f]));
        poly.face(f).iter().map(reach).fold(0.0, f64::max)
    };
    let allowed: Vec<f64> = p.faces().map(|f| MATCH_TOLERANCE * size(f)).collect();
    let gap = |a: usize, b: usize| norm(sub(g.face_centre[p.start + a], image[b]));
    if (0..p.len).all(|a| gap(a, a) <= allowed[a]) {
        return Ok((0..p.len as u32).collect());
    }
    // Sorted along a direction that no mesh is aligned with, few candidates share a window.
    let along = unit([0.628_318, 0.523_129, 0.577_215]);
    let mut sorted: Vec<(f64, u32)> =
        image.iter().enumerate().map(|(b, &x)| (dot(along, x), b as u32)).collect();
    sorted.sort_by(|x, y| x.0.total_cmp(&y.0));
    let mut taken = vec![false; q.len];
    let mut pairs = Vec::with_capacity(p.len);
    let mut worst: Option<(usize, f64)> = None;
    for (a, &reach) in allowed.iter().enumerate() {
        let at = dot(along, g.face_centre[p.start + a]);
        let first = sorted.partition_point(|x| x.0 < at - reach);
        let best = sorted[first..]
            .iter()
            .take_while(|x| x.0 <= at + reach)
            .map(|&(_, b)| (gap(a, b as usize), b))
            .filter(|&(d, b)| d <= reach && !taken[b as usize])
            .min_by(|x, y| x.0.total_cmp(&y.0));
        if let Some((_, b)) = best {
            taken[b as usize] = true;
            pairs.push(b);
        } else {
            // Only on the way to the error, so the full search may be slow: bounded all the same.
            let near = if worst.is_some() && a > 4096 {
                0.0
            } else {
                (0..q.len).map(|b| gap(a, b)).fold(f64::INFINITY, f64::min)
            };
            if worst.is_none_or(|(_, d)| near > d) {
                worst = Some((a, near));
            }
        }
    }
    match worst {
        None => Ok(pairs),
        Some((face, distance)) => Err(MeshError::CyclicMatch {
            patch: p.name.clone(),
            neighbour: q.name.clone(),
            face,
            at: g.face_centre[p.start + face],
            distance,
            tolerance: allowed[face],
        }),
    }
}

/// Wedge patches: the ghost behind a face is the same cell turned by the whole wedge angle.
fn wedges(poly: &PolyMesh, g: &Geometry) -> Result<Vec<Coupling>, MeshError> {
    let named =
        |i: usize, reason: String| MeshError::Wedge { patch: poly.patches[i].name.clone(), reason };
    let wedge = |i: &usize| poly.patches[*i].kind == PatchKind::Wedge && poly.patches[*i].len > 0;
    let ids: Vec<usize> = (0..poly.patches.len()).filter(wedge).collect();
    let Some(&first) = ids.first() else { return Ok(Vec::new()) };
    let sums: Vec<Summary> = ids.iter().map(|&i| summary(&poly.patches[i], g)).collect();
    for (k, &i) in ids.iter().enumerate() {
        let n = unit(sums[k].area);
        if let Some(f) = poly.patches[i].faces().find(|&f| dot(unit(g.area[f]), n) < 1.0 - 1e-6) {
            let at = place(g.face_centre[f]);
            return Err(named(i, format!("its faces do not lie in one plane (face at {at})")));
        }
    }
    let [&a, &b] = ids.iter().collect::<Vec<_>>()[..] else {
        return Err(named(first, format!("a wedge has two patches, found {}", ids.len())));
    };
    // From the second plane through the cells to the first one.
    let (v, u) = (unit(sums[0].area), scale(unit(sums[1].area), -1.0));
    let k = cross(u, v);
    if norm(k) < 1e-6 {
        return Err(named(a, "the wedge planes are parallel: use empty patches".into()));
    }
    let angle = norm(k).atan2(dot(u, v));
    let axis = unit(k);
    // The axis is where both planes meet: origin . u and origin . v are known.
    let (pu, pv) = (dot(sums[1].centre, u), dot(sums[0].centre, v));
    let c = dot(u, v);
    let det = 1.0 - c * c;
    let origin = add(scale(u, (pu - c * pv) / det), scale(v, (pv - c * pu) / det));
    let motion = Motion::rotation(axis, angle, origin);
    let pairs = wedge_pairs(poly, g, a, b, &motion).map_err(|m| named(a, m))?;
    let mut back = vec![0u32; pairs.len()];
    pairs.iter().enumerate().for_each(|(x, &y)| back[y as usize] = x as u32);
    Ok(vec![
        Coupling { patch: b, partner: a, pairs: back, motion: motion.inverse() },
        Coupling { patch: a, partner: b, pairs, motion },
    ])
}

/// Pairs the two wedge faces of every cell and checks that one turns into the other.
fn wedge_pairs(
    poly: &PolyMesh,
    g: &Geometry,
    a: usize,
    b: usize,
    motion: &Motion,
) -> Result<Vec<u32>, String> {
    let (p, q) = (&poly.patches[a], &poly.patches[b]);
    let n_cells = poly.n_cells();
    if p.len != n_cells || q.len != n_cells {
        let (n, m) = (p.len, q.len);
        return Err(format!(
            "a wedge is one cell thick, but {n_cells} cells have {n} faces in `{}` and {m} in `{}`",
            p.name, q.name
        ));
    }
    let mut behind = vec![u32::MAX; n_cells];
    q.faces().for_each(|f| behind[poly.owner[f] as usize] = (f - q.start) as u32);
    p.faces()
        .map(|f| {
            let at = place(g.face_centre[f]);
            let other = behind[poly.owner[f] as usize];
            if other == u32::MAX {
                return Err(format!("the cell at {at} has no face in `{}`", q.name));
            }
            let image = motion.vector(g.area[q.start + other as usize]);
            if norm(add(image, g.area[f])) > 1e-3 * norm(g.area[f]) {
                return Err(format!(
                    "the face at {at} is no image of its cell's face in `{}`",
                    q.name
                ));
            }
            Ok(other)
        })
        .collect()
}

/// Whether a rotation differs from the unit tensor.
pub(crate) fn turns(r: &Tensor) -> bool {
    r.iter().zip(&IDENTITY).any(|(a, b)| (a - b).abs() > 1e-12)
}
