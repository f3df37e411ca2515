//! The XML of VTK's unstructured grids, arrays appended raw and compressed with zlib.
//!
//! Layout after K. Martin, W. Schroeder and others, "VTK File Formats" (docs.vtk.org): an array is a
//! header of UInt64 (blocks, size of a block, size of the last one or 0, size of each when
//! compressed) and the compressed blocks.

use super::cells::Cells;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use granflow_dict::number;
use granflow_mesh::PolyMesh;
use std::fmt::Write as _;
use std::io::Write as _;

/// Bytes of a block before compression.
const BLOCK: usize = 1 << 20;

/// Values on cells.
pub(super) struct Array {
    pub(super) name: String,
    pub(super) components: usize,
    pub(super) data: Vec<f64>,
}

/// The mesh, compressed once for all times.
pub(super) struct Grid {
    n_points: usize,
    n_cells: usize,
    points: Vec<u8>,
    /// Type, name and contents of the arrays of `<Cells>`.
    cells: Vec<(&'static str, &'static str, Vec<u8>)>,
}

impl Grid {
    pub(super) fn new(poly: &PolyMesh) -> Grid {
        let of = |x: &[i64]| packed(x.iter().flat_map(|v| v.to_le_bytes()).collect());
        let c = Cells::new(poly);
        let mut cells = vec![
            ("Int64", "connectivity", of(&c.connectivity)),
            ("Int64", "offsets", of(&c.offsets)),
            ("UInt8", "types", packed(c.types)),
        ];
        if !c.faces.is_empty() {
            cells.push(("Int64", "faces", of(&c.faces)));
            cells.push(("Int64", "faceoffsets", of(&c.face_offsets)));
        }
        Grid {
            n_points: poly.points.len(),
            n_cells: poly.n_cells(),
            points: packed(poly.points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect()),
            cells,
        }
    }
}

/// The header of an array and its compressed blocks.
fn packed(bytes: Vec<u8>) -> Vec<u8> {
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

/// The file of one time.
pub(super) fn file(grid: &Grid, time: f64, fields: &[Array]) -> Vec<u8> {
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n",
    );
    let mut appended: Vec<u8> = Vec::new();
    let mut array = |xml: &mut String, kind: &str, name: &str, more: &str, bytes: &[u8]| {
        // Writing to a string does not fail.
        let _ = writeln!(
            xml,
            "<DataArray type=\"{kind}\" Name=\"{}\"{more} format=\"appended\" offset=\"{}\"/>",
            escaped(name),
            appended.len()
        );
        appended.extend(bytes);
    };
    xml += "<FieldData>\n";
    let clock = packed(time.to_le_bytes().to_vec());
    array(&mut xml, "Float64", "TimeValue", " NumberOfTuples=\"1\"", &clock);
    xml += "</FieldData>\n";
    let (points, cells) = (grid.n_points, grid.n_cells);
    xml += &format!("<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">\n<Points>\n");
    array(&mut xml, "Float64", "Points", " NumberOfComponents=\"3\"", &grid.points);
    xml += "</Points>\n<Cells>\n";
    for (kind, name, bytes) in &grid.cells {
        array(&mut xml, kind, name, "", bytes);
    }
    xml += "</Cells>\n<CellData>\n";
    for f in fields {
        let bytes = packed(f.data.iter().flat_map(|x| x.to_le_bytes()).collect());
        let components = format!(" NumberOfComponents=\"{}\"", f.components);
        array(&mut xml, "Float64", &f.name, &components, &bytes);
    }
    xml += "</CellData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
    let mut out = xml.into_bytes();
    out.extend(appended);
    out.extend(b"\n</AppendedData>\n</VTKFile>\n");
    out
}

/// The list of the files of all times, s.
pub(super) fn collection(times: &[(f64, String)]) -> String {
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" \
         byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (time, file) in times {
        let (time, file) = (number(*time), escaped(file));
        xml += &format!("<DataSet timestep=\"{time}\" group=\"\" part=\"0\" file=\"{file}\"/>\n");
    }
    xml + "</Collection>\n</VTKFile>\n"
}

fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
