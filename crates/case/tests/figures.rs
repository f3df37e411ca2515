//! Figures of fields: slices and volumes of `system/plotDict` from what is on disk.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

use granflow_case::figures;
use granflow_dict::Sink;
use std::fs;
use std::path::{Path, PathBuf};

fn put(dir: &Path, file: &str, text: &str) {
    let path = dir.join(file);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

fn field(class: &str, dims: &str, values: &str, sides: &str) -> String {
    format!(
        "FoamFile {{ version 2.0; format ascii; class {class}; object f; }}
         dimensions [{dims}]; internalField {values};
         boundaryField {{ \".*\" {{ type {sides}; }} }}"
    )
}

/// A box of 2 x 1 x 1 m, 4 x 4 x 4 cells, water in its lower half, U = (1 0 0), at the times 0 and
/// 0.5.
fn case(plot: &str) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    put(
        dir.path(),
        "system/blockMeshDict",
        "scale 1;
         vertices ( (0 0 0) (2 0 0) (2 1 0) (0 1 0) (0 0 1) (2 0 1) (2 1 1) (0 1 1) );
         blocks ( hex (0 1 2 3 4 5 6 7) (4 4 4) simpleGrading (1 1 1) );
         boundary (
             ends  { type patch; faces ((0 4 7 3) (1 2 6 5)); }
             sides { type wall;  faces ((0 1 5 4) (3 7 6 2)); }
             floor { type wall;  faces ((0 3 2 1)); }
             lid   { type wall;  faces ((4 5 6 7)); }
         );",
    );
    let water =
        format!("nonuniform List<scalar> 64 ({} {})", ["1"; 32].join(" "), ["0"; 32].join(" "));
    for time in ["0", "0.5"] {
        let at = |name: &str| format!("{time}/{name}");
        let alpha = field("volScalarField", "0 0 0 0 0 0 0", &water, "zeroGradient");
        put(dir.path(), &at("alpha.water"), &alpha);
        let u = field("volVectorField", "0 1 -1 0 0 0 0", "uniform (1 0 0)", "zeroGradient");
        put(dir.path(), &at("U"), &u);
    }
    put(dir.path(), "system/plotDict", &format!("figures {{ {plot} }}"));
    dir
}

fn draw(dir: &Path) -> (Vec<PathBuf>, String) {
    let sink = Sink::new();
    let made = figures::draw(dir, &sink).unwrap_or_default();
    (made, sink.take().to_string())
}

struct Picture {
    rgb: Vec<[u8; 3]>,
}

impl Picture {
    fn read(dir: &Path, name: &str) -> Picture {
        let file = fs::File::open(dir.join(format!("postProcessing/figures/{name}.png"))).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut data).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        Picture { rgb: data.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect() }
    }

    fn count(&self, wanted: impl Fn([u8; 3]) -> bool) -> f64 {
        self.rgb.iter().filter(|p| wanted(**p)).count() as f64
    }
}

const PLANE: &str = "plane { point (1 0.5 0.5); normal (0 1 0); }";

#[test]
fn a_slice_shows_its_colour_where_it_is_and_nothing_elsewhere() {
    let dir = case(&format!(
        "whole {{ type slice; {PLANE} field U_x; range (0 2); }}
         lower {{ type slice; {PLANE} field U_x; range (0 2); where {{ alpha.water (0.5 1); }}
                  yRange (0 1); }}
         cells {{ type slice; {PLANE} field alpha.water; shading cells; range (0 1); }}"
    ));
    let (made, said) = draw(dir.path());
    assert_eq!((made.len(), &said[..]), (6, ""));
    // The middle of the map; the bar has a few lines of it.
    let middle = |p: [u8; 3]| {
        let off = [p[0].abs_diff(35), p[1].abs_diff(145), p[2].abs_diff(140)];
        off.iter().all(|d| *d <= 2)
    };
    let whole = Picture::read(dir.path(), "whole").count(middle);
    let lower = Picture::read(dir.path(), "lower").count(middle);
    // 560 units by half of that, two pixels a unit. The frame (1.4 pixels inwards over a perimeter
    // of 3360) and its ticks cover some.
    let lost = 1120.0 * 560.0 - whole;
    assert!((4700.0..9400.0).contains(&lost), "{lost}");
    assert!((lower / whole - 0.5).abs() < 0.01, "{lower} of {whole}");
    let cells = Picture::read(dir.path(), "cells");
    let (full, none) = (cells.count(|p| p == [253, 231, 37]), cells.count(|p| p == [68, 1, 84]));
    assert!((full / none - 1.0).abs() < 0.02, "{full} {none}");
    let svg = fs::read_to_string(dir.path().join("postProcessing/figures/whole.svg")).unwrap();
    assert!(svg.contains("<image ") && svg.contains("U_x"), "{}", &svg[..200]);
}

#[test]
fn a_volume_shows_each_phase_in_its_colour() {
    let phases = "phases (
        { where { alpha.water (0.5 1); } colour blue; label water; }
        { where { alpha.water (0 0.5); } colour red; label air; } );";
    let dir = case(&format!(
        "below {{ type volume; axes off; outline off; view {{ elevation -89; }} {phases} }}
         above {{ type volume; axes off; outline off; view {{ elevation 89; }} {phases} }}
         open  {{ type volume; axes off; outline off; view {{ elevation 89; }} hide (lid sides ends);
                  {phases} }}
         speed {{ type volume; field \"mag(U)\"; range (0 2); }}"
    ));
    let (made, said) = draw(dir.path());
    assert_eq!((made.len(), &said[..]), (8, ""));
    let reddish = |p: [u8; 3]| p[0] > p[2].saturating_add(60);
    let bluish = |p: [u8; 3]| p[2] > p[0].saturating_add(60);
    let shares = |name: &str| {
        let picture = Picture::read(dir.path(), name);
        let (red, blue) = (picture.count(reddish), picture.count(bluish));
        assert!(red + blue > 1e5, "{name}: {red} {blue}");
        red / (red + blue)
    };
    assert!(shares("below") < 0.03, "water lies below");
    assert!(shares("above") > 0.97, "air lies above");
    assert!(shares("open") < 0.03, "without lid the surface of the water is seen");
}

#[test]
fn the_same_case_gives_the_same_bytes() {
    let plot = format!(
        "s {{ type slice; {PLANE} field \"U_x*x\"; contours 5; lines {{ alpha.water 0.5; }}
             arrows {{ field U; unit m/s; }} time all; }}
         v {{ type volume; field x; phases ( {{ where {{ alpha.water (0 0.5); }} opacity 0.5; }} ); }}"
    );
    let (a, b) = (case(&plot), case(&plot));
    let (made, said) = draw(a.path());
    assert_eq!((made.len(), &said[..]), (6, ""), "two times of the slice");
    assert!(made[0].ends_with("postProcessing/figures/s_0.png"), "{made:?}");
    let first: Vec<Vec<u8>> = made.iter().map(|f| fs::read(f).unwrap()).collect();
    draw(a.path());
    draw(b.path());
    for (file, old) in made.iter().zip(first) {
        assert!(fs::read(file).unwrap() == old, "{}", file.display());
        let other = b.path().join(file.strip_prefix(a.path()).unwrap());
        assert!(fs::read(other).unwrap() == old, "{}", file.display());
    }
}

#[test]
fn times_that_are_not_there_are_said_once_and_leave_the_rest() {
    let dir = case(&format!(
        "a {{ type slice; {PLANE} field U_x; time (0.5 0.7 0.9); }}
         b {{ type volume; colour red; time 0.7; }}"
    ));
    let (made, said) = draw(dir.path());
    assert_eq!(made.len(), 2, "{made:?}");
    assert!(made[0].ends_with("postProcessing/figures/a.png"), "{made:?}");
    assert_eq!(said.matches("warning").count(), 1, "{said}");
    assert!(said.contains("warning: the case has no times 0.7, 0.9"), "{said}");
    assert!(said.contains("3 figures are left out"), "{said}");
    for time in ["0", "0.5"] {
        fs::remove_dir_all(dir.path().join(time)).unwrap();
    }
    let (made, said) = draw(dir.path());
    assert!(made.is_empty());
    assert!(said.contains("warning: the case has no times 0.5, 0.7, 0.9"), "{said}");
    assert!(said.contains("4 figures are left out"), "{said}");
    put(dir.path(), "system/plotDict", "figures { c { type volume; colour red; } }");
    let (made, said) = draw(dir.path());
    assert!(made.is_empty());
    assert!(said.contains("warning: the case has no time directories"), "{said}");
    assert!(said.contains("the figure is left out"), "{said}");
}

#[test]
fn what_is_not_in_the_data_is_named_in_one_go() {
    let dir = case(&format!(
        "a {{ type slice; {PLANE} field V_x; time all; }}
         b {{ type slice; {PLANE} field U; }}
         c {{ type slice; {PLANE} field U_x; where {{ alpha.wter (0 1); }} }}
         d {{ type volume; colour red; hide (lit); }}
         e {{ type volume; phases ( {{ colour red; where {{ beta (0 1); }} }} ); }}
         f {{ type slice; {PLANE} field U_x; arrows {{ field W; }} }}"
    ));
    let (made, said) = draw(dir.path());
    assert!(made.is_empty());
    for (message, line) in [
        ("there is no field `V_x` at the time 0", 1),
        ("`U` is a vector", 2),
        ("there is no field `alpha.wter` at the time 0.5", 3),
        ("the mesh has no patch `lit`", 4),
        ("there is no field `beta` at the time 0.5", 5),
        ("there is no field `W_x` at the time 0.5", 6),
    ] {
        let at = said.find(message).unwrap_or_else(|| panic!("{message} is not in {said}"));
        assert_eq!(said.matches(message).count(), 1, "{said}");
        let place = said[at..].lines().nth(1).unwrap();
        assert!(place.contains(&format!("system/plotDict:{line}:")), "{message}: {place}");
    }
    for help in ["did you mean `U_x`?", "did you mean `alpha.water`?", "did you mean `lid`?"] {
        assert!(said.contains(help), "{help} is not in {said}");
    }
}

#[test]
fn what_lies_beside_the_mesh_or_within_no_range_warns() {
    let dir = case(
        "a { type slice; plane { point (0 0 9); normal (0 0 1); } field U_x; }
         b { type volume; colour red; where { alpha.water (2 3); } }",
    );
    let (made, said) = draw(dir.path());
    assert_eq!(made.len(), 4);
    assert!(said.contains("warning: the plane does not meet the mesh"), "{said}");
    assert!(said.contains("warning: nothing lies within `where` at the time 0.5"), "{said}");
}
