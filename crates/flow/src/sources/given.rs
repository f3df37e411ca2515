//! One entry of `fvOptions` and what it refers to.

use super::Zone;
use granflow_base::Dims;
use granflow_dict::Reader;
use granflow_mesh::Mesh;

/// What a source is read from.
pub struct Given<'r, 'd> {
    /// The name of the entry.
    pub name: &'r str,
    /// Its dictionary, or the one of its type within.
    pub r: &'r Reader<'d>,
    /// Its dictionary.
    pub outer: &'r Reader<'d>,
    /// The mesh.
    pub mesh: &'r Mesh,
    /// Where the source acts, cells in the user's numbering.
    pub zone: Zone,
    /// Density that accelerations are multiplied with to make forces, 1 where forces are given.
    pub rho: f64,
    /// Whether there are two phases.
    pub two: bool,
}

impl<'d> Given<'_, 'd> {
    /// The reader that has `key`.
    pub fn with(&self, key: &str) -> &Reader<'d> {
        if self.r.has(key) { self.r } else { self.outer }
    }

    /// `timeStart` and `duration`: first and last time, s.
    pub fn window(&self) -> [f64; 2] {
        let start = self.with("timeStart").maybe_scalar("timeStart", Dims::TIME);
        let lasts = self.with("duration").maybe_scalar("duration", Dims::TIME);
        match start {
            None => [f64::NEG_INFINITY, f64::INFINITY],
            Some(start) => [start, start + lasts.unwrap_or(f64::INFINITY)],
        }
    }

    /// Refuses a window where the source acts all the time.
    pub fn always(&self) {
        for key in ["timeStart", "duration"] {
            let r = self.with(key);
            if r.has(key) {
                let help = Some("remove it, or run the times before without the source");
                r.error_at_key(key, "this source acts all the time", "not available", help);
            }
        }
    }

    /// Volume of the zone, m3.
    pub fn volume(&self) -> f64 {
        let volume = &self.mesh.volume;
        match &self.zone {
            Zone::All => volume[..self.mesh.n_cells].iter().sum(),
            Zone::Cells(cells) => {
                let mut here = vec![false; self.mesh.n_cells];
                cells.iter().for_each(|c| here[*c as usize] = true);
                let of = |c: usize| here[self.mesh.global_cell[c] as usize];
                (0..self.mesh.n_cells).filter(|c| of(*c)).map(|c| volume[c]).sum()
            }
        }
    }
}
