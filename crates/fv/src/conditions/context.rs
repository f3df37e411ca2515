//! What reading a condition may depend on.

use crate::waves::{Frame, Source};
use granflow_base::{Dims, Vec3};
use granflow_dict::{Dict, Reader, Sink};
use granflow_mesh::PatchKind;
use std::fmt::Debug;
use std::io;

/// The files of the case, for conditions that take values from some. This crate never touches the
/// disk: the case hands it a reader.
pub trait CaseFiles: Debug + Sync {
    /// The bytes of `path`, relative to the case unless it is absolute, unpacked.
    ///
    /// # Errors
    /// What the file system says.
    fn load(&self, path: &str) -> io::Result<Vec<u8>>;
    /// The names of the folders in `path`.
    ///
    /// # Errors
    /// What the file system says.
    fn folders(&self, path: &str) -> io::Result<Vec<String>>;
}

/// A case without files.
#[derive(Clone, Copy, Debug)]
pub struct NoCaseFiles;
impl CaseFiles for NoCaseFiles {
    fn load(&self, _: &str) -> io::Result<Vec<u8>> {
        Err(io::ErrorKind::NotFound.into())
    }
    fn folders(&self, _: &str) -> io::Result<Vec<String>> {
        Err(io::ErrorKind::NotFound.into())
    }
}

/// The case around a condition.
#[derive(Clone, Copy, Debug)]
pub struct CaseContext<'a> {
    /// Its files.
    pub files: &'a dyn CaseFiles,
    /// Density of the (first) fluid, kg/m3.
    pub density: f64,
    /// Begin and end of the run, s, where they are known.
    pub times: Option<(f64, f64)>,
}

impl CaseContext<'static> {
    /// No files, density 1.
    pub const NONE: CaseContext<'static> =
        CaseContext { files: &NoCaseFiles, density: 1.0, times: None };
}

/// What reading a condition may depend on.
#[derive(Clone, Copy, Debug)]
pub struct PatchContext<'a> {
    /// Name of the patch.
    pub patch: &'a str,
    /// Its kind in the mesh.
    pub kind: &'a PatchKind,
    /// Its number of faces (on all ranks together for uniform values this does not matter).
    pub n_faces: usize,
    /// Number of inner faces of the mesh.
    pub n_inner: usize,
    /// Name of the field.
    pub field: &'a str,
    /// Dimensions of the field.
    pub dims: Dims,
    /// From the units of the field in the file to those inside.
    pub factor: f64,
    /// The case around.
    pub case: CaseContext<'a>,
    /// Waves at the patch; `None` where there are none, or before the depth of the water is known.
    pub wave: Option<WavePatch<'a>>,
}

/// Waves at a patch, checked.
#[derive(Clone, Copy, Debug)]
pub struct WavePatch<'a> {
    /// The patch's entry of `waveProperties`.
    pub entry: &'a Dict,
    /// Directions, extent and still water of the whole patch.
    pub frame: Frame,
    /// Of the patch's faces the lowest and highest point over the patch's lowest, m.
    pub spans: &'a [[f64; 2]],
    /// Their centres, m.
    pub centres: &'a [Vec3],
}

impl WavePatch<'_> {
    /// What the conditions need. Mistakes were reported when the entry was checked.
    pub(super) fn source(&self) -> Source {
        let silent = Sink::new();
        let r = Reader::new(self.entry, &silent);
        Source::read(&r, self.frame).on(self.spans.to_vec(), self.centres)
    }
}
