use super::*;
use crate::conditions::CaseFiles;
use granflow_dict::{Severity, Sink, parse_str};
use std::io;

/// Files by name.
#[derive(Debug)]
struct Held(&'static [(&'static str, &'static str)]);
impl CaseFiles for Held {
    fn load(&self, path: &str) -> io::Result<Vec<u8>> {
        let found = self.0.iter().find(|f| f.0 == path);
        found.map(|f| f.1.into()).ok_or_else(|| io::ErrorKind::NotFound.into())
    }
    fn folders(&self, _: &str) -> io::Result<Vec<String>> {
        Err(io::ErrorKind::NotFound.into())
    }
}

const FILES: Held = Held(&[
    ("constant/q.dat", "(\n(0 1)\n(0.2 2)\n(0.3 0)\n)\n"),
    ("constant/v.dat", "3\n(\n(0 (1 0 0)) (0.2 (2 0 0)) (0.3 (0 1 0))\n)\n"),
    ("constant/bad.dat", "(\n(0 1)\n(0.2 two)\n)\n"),
    ("constant/q.csv", "t,a,b\n0,1,2\n0.2,3,4\n0.4,0,8\n"),
    ("constant/q.txt", "t a b\n0  1   2\n0.2  3  4\n0.4 0    8\n"),
    ("constant/holes.csv", "t,a\n0,1\n1,\n"),
]);

fn case() -> CaseContext<'static> {
    CaseContext { files: &FILES, times: Some((0.0, 1.0)), ..CaseContext::NONE }
}

fn read<T: Value>(text: &str) -> (TimeFunction<T>, granflow_dict::Diags) {
    let (dict, diags) = parse_str(text);
    assert!(diags.is_empty(), "{diags:?}");
    let sink = Sink::new();
    let r = Reader::new(&dict, &sink);
    let f = TimeFunction::read(&r, "q", Dims::VOLUME_FLUX, case());
    r.finish(Severity::Error);
    (f, sink.take())
}
fn right<T: Value>(text: &str) -> TimeFunction<T> {
    let (f, mistakes) = read(text);
    assert!(mistakes.is_empty(), "{mistakes}");
    f
}
/// Values at 0.05, 0.1, 0.15, ...
fn twentieths(text: &str, n: usize) -> Vec<f64> {
    let f = right::<f64>(text);
    (1..=n).map(|k| f.at(0.05 * k as f64)).collect()
}
#[track_caller]
fn close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() < 6e-6 * e.abs().max(1.0), "{found:?} {expected:?}");
    }
}

#[test]
fn a_number_is_a_constant_however_it_is_written() {
    for text in [
        "q 4;",
        "q constant 4;",
        "q uniform 4;",
        "q [0 3 -1 0 0 0 0] 4;",
        "q { type constant; value 4; }",
    ] {
        assert_eq!(right::<f64>(text).at(5.0), 4.0, "{text}");
    }
    assert_eq!(right::<f64>("q zero;").at(1.0), 0.0);
    assert_eq!(right::<[f64; 3]>("q one;").at(1.0), [1.0; 3]);
}

#[test]
fn a_table_interpolates_and_holds_its_ends() {
    let t = right::<f64>("q table ((1 2) (3 6));");
    assert_eq!([t.at(0.0), t.at(2.0), t.at(9.0)], [2.0, 4.0, 6.0]);
    assert_eq!(t.entries("omega"), [("omega".to_owned(), "table ((1 2) (3 6))".to_owned())]);
    assert_eq!(right::<f64>("q table 2 ((1 2) (3 6));").at(2.0), 4.0);
    assert_eq!(right::<f64>("q { type table; values ((1 2) (3 6)); }").at(2.0), 4.0);
    assert_eq!(right::<f64>("q { type table; q table ((1 2) (3 6)); }").at(2.0), 4.0);
}

/// The values that icoFoam of OpenFOAM v1912 gave to an inlet with `flowRateInletVelocity` at
/// 0.05, 0.1, ... s, six digits of them.
#[test]
fn forms_are_what_openfoam_makes_of_them() {
    let sine = [0.27103, 0.60285, 1.0, 1.3971, 1.729, 1.9409, 1.998, 1.891, 1.6374, 1.279];
    let settings = "amplitude 2; frequency 1.3; t0 0.15; scale 0.5; level 1;";
    for text in [
        format!("q sine; {settings}"),
        format!("q sine; qCoeffs {{ {settings} }}"),
        format!("q {{ type sine; {settings} }}"),
    ] {
        let f = twentieths(&text, 10);
        for (f, e) in f.iter().zip(sine) {
            assert!((f - e).abs() < 5e-5 * e, "{text}: {f} {e}");
        }
    }
    let square = format!("q square; {settings} markSpace 0.5;");
    // Before t0 it is high; after it for a third of a period of 1/1.3 s.
    close(&twentieths(&square, 11), &[2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 0.0, 0.0, 0.0]);
    let ramp = |form: &str| twentieths(&format!("q {form}; start 0.1; duration 0.25;"), 7);
    close(&ramp("linearRamp"), &[0.0, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
    close(&ramp("quadraticRamp"), &[0.0, 0.0, 0.04, 0.16, 0.36, 0.64, 1.0]);
    close(&ramp("quarterSineRamp"), &[0.0, 0.0, 0.309017, 0.587785, 0.809017, 0.951057, 1.0]);
    close(&ramp("quarterCosineRamp"), &[0.0, 0.0, 0.0489435, 0.190983, 0.412215, 0.690983, 1.0]);
    close(&ramp("halfCosineRamp"), &[0.0, 0.0, 0.0954915, 0.345492, 0.654508, 0.904508, 1.0]);
    let f = twentieths("q polynomial ((1 0) (2 1) (3 2));", 4);
    close(&f, &[1.1075, 1.23, 1.3675, 1.52]);
    let f = twentieths("q table ((0.1 1) (0.2 2) (0.25 5)); outOfBounds repeat;", 7);
    close(&f, &[1.0, 1.0, 1.5, 2.0, 5.0, 1.5, 2.0]);
    for file in ["<case>/constant/q.dat", "$FOAM_CASE/constant/q.dat", "constant/q.dat"] {
        let f = twentieths(&format!("q {{ type tableFile; file \"{file}\"; }}"), 7);
        close(&f, &[1.25, 1.5, 1.75, 2.0, 1.0, 0.0, 0.0]);
    }
    let columns = "nHeaderLine 1; refColumn 0; componentColumns (2);";
    for rest in [
        "separator \",\"; file \"<constant>/q.csv\";",
        "separator \" \"; mergeSeparators yes; file \"constant/q.txt\";",
    ] {
        let f = twentieths(&format!("q {{ type csvFile; {columns} {rest} }}"), 5);
        close(&f, &[2.5, 3.0, 3.5, 4.0, 5.0]);
    }
}

#[test]
fn vectors_have_the_same_forms() {
    let near = |text: &str, time: f64, expected: [f64; 3]| {
        close(&right::<[f64; 3]>(text).at(time), &expected);
    };
    near(
        "q sine; qCoeffs { amplitude 1; frequency 1; scale (1 2 3); level (1 0 0); }",
        0.05,
        [1.309016994, 0.6180339887, 0.9270509831],
    );
    near("q polynomial ( ((1 2 3) (0 1 2)) ((0 1 0)(1 1 1)) );", 0.3, [1.0, 0.9, 0.27]);
    near("q { type tableFile; file \"constant/v.dat\"; }", 0.25, [1.0, 0.5, 0.0]);
    let csv = "q { type csvFile; nHeaderLine 1; refColumn 0; componentColumns (1 2 1); \
               separator \",\"; file \"constant/q.csv\"; }";
    near(csv, 0.25, [2.25, 5.0, 2.25]);
    near(
        "q { type scale; scale { type linearRamp; duration 0.4; } value (1 2 0); }",
        0.1,
        [0.25, 0.5, 0.0],
    );
}

#[test]
fn entries_are_given_back_as_they_were() {
    let pair = |k: &str, v: &str| (k.to_owned(), v.to_owned());
    let f = right::<f64>("q sine; frequency 2; level 1;");
    assert_eq!(f.entries("q"), [pair("q", "sine"), pair("frequency", "2"), pair("level", "1")]);
    let f = right::<f64>("q linearRamp; qCoeffs { duration 2; }").times(3.0);
    assert_eq!(f.entries("q"), [pair("q", "linearRamp"), pair("qCoeffs", "{ duration 2; }")]);
    assert_eq!(f.at(1.0), 1.5);
}

#[test]
fn mistakes_are_named_where_they_stand() {
    let said = |text: &str| read::<f64>(text).1.to_string();
    let expect = |text: &str, part: &str| {
        let found = said(text);
        assert!(found.contains(part), "{text}: {found}");
    };
    expect("q sinee; frequency 1;", "did you mean `sine`?");
    expect("q coded;", "compiled");
    expect("q sine;", "missing entry `frequency`");
    expect("q linearRamp; duration 0;", "duration");
    expect("q { type tableFile; file \"<case>/constant/no.dat\"; }", "`constant/no.dat`");
    expect("q { type tableFile; file \"constant/bad.dat\"; }", "constant/bad.dat:3:6");
    expect("q table ((0 1) (0.5 2)); outOfBounds error;", "covers 0 to 0.5 s and the run 0 to 1 s");
    expect("q table ((0 1) (0 2));", "do not increase");
    expect("q table ();", "is empty");
    expect("q table ((0 1)); interpolationScheme spline;", "interpolated linearly");
    let csv = "q { type csvFile; nHeaderLine 1; refColumn 0; componentColumns (1); file";
    expect(&format!("{csv} \"constant/holes.csv\"; }}"), "line 3: column 1 holds ``");
    let text = read::<[f64; 3]>("q linearRamp; duration 1;").1.to_string();
    assert!(text.contains("is no function of time"), "{text}");
}
