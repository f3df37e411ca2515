//! Arrays of VTK's XML files, appended raw and compressed with zlib.
//!
//! Layout after K. Martin, W. Schroeder and others, "VTK File Formats" (docs.vtk.org): an array is a
//! header of UInt64 (blocks, size of a block, size of the last one or 0, size of each when
//! compressed) and the compressed blocks.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::fmt::Write as _;
use std::io::Write as _;

/// Bytes of a block before compression.
const BLOCK: usize = 1 << 20;

/// Values of a field.
pub(crate) struct Array {
    pub(crate) name: String,
    pub(crate) components: usize,
    /// Component by component.
    pub(crate) data: Vec<f64>,
}

/// What is appended to a file.
#[derive(Default)]
pub(super) struct Appended {
    bytes: Vec<u8>,
}

impl Appended {
    /// Names an array in `xml` and keeps what [`packed`] made of it.
    pub(super) fn put(
        &mut self,
        xml: &mut String,
        kind: &str,
        name: &str,
        more: &str,
        bytes: &[u8],
    ) {
        // Writing to a string does not fail.
        let _ = writeln!(
            xml,
            "<DataArray type=\"{kind}\" Name=\"{}\"{more} format=\"appended\" offset=\"{}\"/>",
            escaped(name),
            self.bytes.len()
        );
        self.bytes.extend(bytes);
    }
    /// A field.
    pub(super) fn field(&mut self, xml: &mut String, f: &Array) {
        let bytes = packed(f.data.iter().flat_map(|x| x.to_le_bytes()).collect());
        let components = format!(" NumberOfComponents=\"{}\"", f.components);
        self.put(xml, "Float64", &f.name, &components, &bytes);
    }
    /// The file: the text, then the arrays.
    pub(super) fn close(self, mut xml: String) -> Vec<u8> {
        xml += "<AppendedData encoding=\"raw\">\n_";
        let mut out = xml.into_bytes();
        out.extend(self.bytes);
        out.extend(b"\n</AppendedData>\n</VTKFile>\n");
        out
    }
}

/// The header of an array and its compressed blocks.
pub(super) fn packed(bytes: Vec<u8>) -> Vec<u8> {
    let blocks: Vec<Vec<u8>> = bytes.chunks(BLOCK).map(deflated).collect();
    let last = bytes.len() % BLOCK;
    let mut header = vec![blocks.len() as u64, BLOCK as u64, last as u64];
    header.extend(blocks.iter().map(|b| b.len() as u64));
    let mut out: Vec<u8> = header.iter().flat_map(|n| n.to_le_bytes()).collect();
    blocks.iter().for_each(|b| out.extend(b));
    out
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    // Writing to memory does not fail.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

pub(super) fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
