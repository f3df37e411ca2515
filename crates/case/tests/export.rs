//! What other programs read of an exported case: the XML and the arrays behind it.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

use granflow_case::export::{COLLECTION, export};
use granflow_case::meshing;
use granflow_case::store::Compression;
use granflow_dict::{Format, Sink};
use granflow_mesh::{PatchKind, shapes};
use std::fs;
use std::io::Read;
use std::path::Path;

/// A case with the mesh and a scalar and a vector at the time 0.25.
fn case(root: &Path) -> usize {
    let kinds = [const { PatchKind::Wall }; 6];
    let poly = shapes::prism_box([3, 2, 2], [0.0; 3], [3.0, 2.0, 1.0], kinds);
    meshing::write(root, &poly, Format::Ascii, Compression::Plain).unwrap();
    let n = poly.n_cells();
    let list = |one: fn(usize) -> String| (0..n).map(one).collect::<Vec<_>>().join(" ");
    let put = |file: &str, class: &str, word: &str, values: String| {
        let text = format!(
            "FoamFile {{ version 2.0; format ascii; class {class}; object {file}; }}\n\
             dimensions [0 0 0 0 0 0 0];\n\
             internalField nonuniform List<{word}> {n} ({values});\n\
             boundaryField {{ \".*\" {{ type zeroGradient; }} }}\n"
        );
        fs::create_dir_all(root.join("0.25/uniform")).unwrap();
        fs::write(root.join("0.25").join(file), text).unwrap();
    };
    put("T", "volScalarField", "scalar", list(|c| format!("{c}.5")));
    put("U", "volVectorField", "vector", list(|c| format!("({c} 0 -1)")));
    put("R", "volSymmTensorField", "symmTensor", list(|c| format!("({c} 1 2 3 4 5)")));
    put("G", "volTensorField", "tensor", list(|c| format!("({c} 1 2 3 4 5 6 7 8)")));
    put("phi", "surfaceScalarField", "scalar", list(|_| "0".into()));
    fs::write(root.join("0.25/notes"), "not a dictionary {").unwrap();
    n
}

/// The header of a `.vtu` and the bytes behind its underscore.
fn halves(file: &[u8]) -> (String, &[u8]) {
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let at = file.windows(mark.len()).position(|w| w == mark).unwrap();
    (String::from_utf8(file[..at].to_vec()).unwrap(), &file[at + mark.len()..])
}

/// The attribute `key` of the array `name`.
fn attribute(xml: &str, name: &str, key: &str) -> String {
    let line = xml.lines().find(|l| l.contains(&format!("Name=\"{name}\""))).unwrap();
    let (_, rest) = line.split_once(&format!("{key}=\"")).unwrap();
    rest.split_once('"').unwrap().0.to_owned()
}

/// The array `name`, unpacked as a reader of VTK files does.
fn array(xml: &str, data: &[u8], name: &str) -> Vec<u8> {
    let at: usize = attribute(xml, name, "offset").parse().unwrap();
    let word = |i: usize| {
        u64::from_le_bytes(data[at + 8 * i..at + 8 * i + 8].try_into().unwrap()) as usize
    };
    let (blocks, size, last) = (word(0), word(1), word(2));
    let mut from = at + 8 * (3 + blocks);
    let mut out = Vec::new();
    for b in 0..blocks {
        let before = out.len();
        let packed = &data[from..from + word(3 + b)];
        flate2::read::ZlibDecoder::new(packed).read_to_end(&mut out).unwrap();
        let whole = b + 1 < blocks || last == 0;
        assert_eq!(out.len() - before, if whole { size } else { last });
        from += word(3 + b);
    }
    out
}

fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn fields_and_mesh_can_be_read_back() {
    let dir = tempfile::tempdir().unwrap();
    let n = case(dir.path());
    let sink = Sink::new();
    let done = export(dir.path(), &sink).unwrap();
    assert_eq!(sink.take().to_string(), "");
    assert_eq!(
        (done.times, done.fields),
        (vec!["0.25".to_owned()], ["G", "R", "T", "U"].map(str::to_owned).to_vec())
    );
    let file = fs::read(dir.path().join("VTK/0.25.vtu")).unwrap();
    let (xml, data) = halves(&file);
    assert!(xml.contains(&format!("<Piece NumberOfPoints=\"36\" NumberOfCells=\"{n}\">")), "{xml}");
    assert_eq!(numbers(&array(&xml, data, "TimeValue")), [0.25]);
    let t: Vec<f64> = (0..n).map(|c| c as f64 + 0.5).collect();
    assert_eq!(numbers(&array(&xml, data, "T")), t);
    assert_eq!(attribute(&xml, "U", "NumberOfComponents"), "3");
    assert_eq!(numbers(&array(&xml, data, "U"))[3..9], [1.0, 0.0, -1.0, 2.0, 0.0, -1.0]);
    // VTK's order of a symmetric tensor is xx yy zz xy yz xz.
    assert_eq!(attribute(&xml, "R", "NumberOfComponents"), "6");
    assert_eq!(numbers(&array(&xml, data, "R"))[6..12], [1.0, 3.0, 5.0, 1.0, 4.0, 2.0]);
    assert_eq!(attribute(&xml, "G", "NumberOfComponents"), "9");
    let rows: Vec<f64> = std::iter::once(1.0).chain((1..9).map(f64::from)).collect();
    assert_eq!(numbers(&array(&xml, data, "G"))[9..18], rows);
    assert_eq!(array(&xml, data, "types"), vec![13; n], "prisms are wedges");
    assert_eq!(array(&xml, data, "connectivity").len(), 8 * 6 * n);
    assert_eq!(numbers(&array(&xml, data, "Points")).len(), 3 * 36);
    assert!(!xml.contains("Name=\"faces\""), "there are no polyhedra");
    let list = fs::read_to_string(dir.path().join(COLLECTION)).unwrap();
    assert!(list.contains("<DataSet timestep=\"0.25\" group=\"\" part=\"0\" file=\"0.25.vtu\"/>"));
}

#[test]
fn a_damaged_field_is_named_and_nothing_is_written() {
    let dir = tempfile::tempdir().unwrap();
    case(dir.path());
    let file = dir.path().join("0.25/T");
    let text = fs::read_to_string(&file).unwrap().replace("(0.5 1.5", "(0.5");
    fs::write(&file, text).unwrap();
    let sink = Sink::new();
    assert!(export(dir.path(), &sink).is_err());
    let said = sink.take().to_string();
    assert!(said.contains("0.25/T"), "{said}");
    assert!(!dir.path().join("VTK").exists());
}
