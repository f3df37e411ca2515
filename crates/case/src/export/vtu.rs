//! The XML of VTK's unstructured grids.

use super::arrays::{Appended, Array, escaped, packed};
use super::cells::Cells;
use granflow_dict::number;
use granflow_mesh::PolyMesh;

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

/// The file of one time.
pub(super) fn file(grid: &Grid, time: f64, fields: &[Array]) -> Vec<u8> {
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n",
    );
    let mut arrays = Appended::default();
    xml += "<FieldData>\n";
    let clock = packed(time.to_le_bytes().to_vec());
    arrays.put(&mut xml, "Float64", "TimeValue", " NumberOfTuples=\"1\"", &clock);
    xml += "</FieldData>\n";
    let (points, cells) = (grid.n_points, grid.n_cells);
    xml += &format!("<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">\n<Points>\n");
    arrays.put(&mut xml, "Float64", "Points", " NumberOfComponents=\"3\"", &grid.points);
    xml += "</Points>\n<Cells>\n";
    for (kind, name, bytes) in &grid.cells {
        arrays.put(&mut xml, kind, name, "", bytes);
    }
    xml += "</Cells>\n<CellData>\n";
    for f in fields {
        arrays.field(&mut xml, f);
    }
    xml += "</CellData>\n</Piece>\n</UnstructuredGrid>\n";
    arrays.close(xml)
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
