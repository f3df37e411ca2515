//! The XML of VTK's PolyData: polygons and lines with values at their points or on their faces.

pub(crate) use super::arrays::Array;
use super::arrays::{Appended, packed};
use granflow_base::Vec3;

/// A file of `polygons` and `lines` (points of each), with fields at the points or on polygons.
pub(crate) fn file(
    points: &[Vec3],
    polygons: &[Vec<u32>],
    lines: &[Vec<u32>],
    on_points: bool,
    time: Option<f64>,
    fields: &[Array],
) -> Vec<u8> {
    let mut arrays = Appended::default();
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<PolyData>\n",
    );
    if let Some(time) = time {
        xml += "<FieldData>\n";
        let clock = packed(time.to_le_bytes().to_vec());
        arrays.put(&mut xml, "Float64", "TimeValue", " NumberOfTuples=\"1\"", &clock);
        xml += "</FieldData>\n";
    }
    xml += &format!(
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n<Points>\n",
        points.len(),
        lines.len(),
        polygons.len()
    );
    let places = packed(points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect());
    arrays.put(&mut xml, "Float64", "Points", " NumberOfComponents=\"3\"", &places);
    xml += "</Points>\n";
    for (tag, all) in [("Lines", lines), ("Polys", polygons)] {
        if all.is_empty() {
            continue;
        }
        let whole = |i: i64| i.to_le_bytes();
        let joined = all.iter().flatten().flat_map(|i| whole(i64::from(*i))).collect();
        let ends = all.iter().scan(0, |end, one| {
            *end += one.len() as i64;
            Some(*end)
        });
        let ends = packed(ends.flat_map(whole).collect());
        xml += &format!("<{tag}>\n");
        arrays.put(&mut xml, "Int64", "connectivity", "", &packed(joined));
        arrays.put(&mut xml, "Int64", "offsets", "", &ends);
        xml += &format!("</{tag}>\n");
    }
    let tag = if on_points { "PointData" } else { "CellData" };
    xml += &format!("<{tag}>\n");
    fields.iter().for_each(|f| arrays.field(&mut xml, f));
    xml += &format!("</{tag}>\n</Piece>\n</PolyData>\n");
    arrays.close(xml)
}
