//! Fluxes and walls of zones in turning frames ([`crate::sources::RotatingFrame`]).
//!
//! On every face of a cell of such a zone the flux is that relative to the frame, `(U - omega x r) . S`: it
//! carries what is carried, and of a closed cell the frame's part is none, so that continuity is that of the
//! absolute flux. Walls in the zone turn with it, but for patches that are named to be still.

use crate::Flow;
use granflow_base::{Vec3, dot, scale};
use granflow_fv::{FaceField, Unknown};
use granflow_mesh::{Mesh, PatchKind};

/// What turning frames do to faces.
pub(crate) struct Frames {
    /// Faces with the frame's flux per unit of angular velocity, m3, by the source that turns them.
    fluxes: Vec<(usize, Vec<(u32, f64)>)>,
    /// Boundary faces that turn, with their velocity per unit of angular velocity, m.
    walls: Vec<(usize, Vec<(u32, Vec3)>)>,
    /// The frame's flux at one time, all faces, m3/s.
    flux: Vec<f64>,
}

impl Flow {
    /// To be called when the sources are given: prepares what turning frames among them need. Where the
    /// state's flux was just made from its velocity (`fresh`), it becomes the relative one.
    pub fn turn_frames(&mut self, fresh: bool) {
        if !self.sources.iter().any(|s| s.frame().is_some()) {
            return;
        }
        let Flow { exec, mesh, state, sources, .. } = self;
        let mut frames =
            Frames { fluxes: Vec::new(), walls: Vec::new(), flux: vec![0.0; mesh.n_faces()] };
        for (k, source) in sources.iter().enumerate() {
            let Some(frame) = source.frame() else { continue };
            let mut within = vec![0.0; mesh.n_all()];
            frame.zone.each(mesh.n_cells, |c| within[c] = 1.0);
            mesh.halo.update(exec, &mut within);
            let touches = |f: &usize| {
                let of = |c: u32| within[c as usize] > 0.0;
                of(mesh.owner[*f]) || mesh.neighbour.get(*f).is_some_and(|n| of(*n))
            };
            let of = |f: usize| (f as u32, dot(frame.arm(mesh.face_centre[f]), mesh.area[f]));
            frames.fluxes.push((k, (0..mesh.n_faces()).filter(touches).map(of).collect()));
            let turns = |p: &granflow_mesh::Patch| {
                p.kind == PatchKind::Wall && !frame.still.contains(&p.name)
            };
            let with = mesh.patches.iter().zip(&state.u.conditions);
            let faces = with.filter(|(p, c)| turns(p) && c.fixes_value());
            let faces = faces.flat_map(|(p, _)| p.faces.clone()).filter(touches);
            let walls = faces.map(|f| (f as u32, frame.arm(mesh.face_centre[f]))).collect();
            frames.walls.push((k, walls));
        }
        self.frames = Some(Box::new(frames));
        self.update_conditions();
        if fresh {
            let mut phi = std::mem::take(&mut self.state.phi.data);
            let time = self.state.time;
            self.take_frames(time, &mut phi);
            self.state.phi_old.copy_from_slice(&phi);
            self.state.phi.data = phi;
        }
    }

    /// Takes the frames' part at a time from a flux of the velocity.
    pub(crate) fn take_frames(&mut self, time: f64, phi: &mut [f64]) {
        let Flow { exec, sources, frames, .. } = self;
        let Some(frames) = frames else { return };
        frames.flux.fill(0.0);
        for (k, faces) in &frames.fluxes {
            let Some(frame) = sources[*k].frame() else { continue };
            let omega = frame.omega.at(time);
            faces.iter().for_each(|(f, arm)| frames.flux[*f as usize] += omega * arm);
        }
        let flux = &frames.flux;
        exec.for_each(phi, |first, out| {
            out.iter_mut().enumerate().for_each(|(i, phi)| *phi -= flux[first + i]);
        });
        // To the last bit, and before the wall's velocity is known.
        let walls = frames.walls.iter().flat_map(|(_, faces)| faces);
        walls.for_each(|(f, _)| phi[*f as usize] = 0.0);
    }

    /// Takes the frames' part at the present time from a flux that a step works on.
    pub(crate) fn take_frames_from(&mut self, of: impl Fn(&mut Flow) -> &mut FaceField<f64>) {
        if self.frames.is_none() {
            return;
        }
        let mut phi = std::mem::take(&mut of(self).data);
        let time = self.state.time;
        self.take_frames(time, &mut phi);
        of(self).data = phi;
    }
}

/// Gives walls that turn their velocity.
pub(crate) fn turn_walls(
    frames: Option<&Frames>,
    sources: &[Box<dyn crate::Source>],
    mesh: &Mesh,
    time: f64,
    u: &mut Unknown<Vec3>,
) {
    for (k, faces) in frames.iter().flat_map(|f| &f.walls) {
        let Some(frame) = sources[*k].frame() else { continue };
        let omega = frame.omega.at(time);
        for (f, arm) in faces {
            let b = *f as usize - mesh.n_inner;
            u.closure.offset[b] = scale(*arm, omega);
            (u.closure.slope[b], u.closure.normal[b]) = (0.0, 0.0);
        }
    }
}
