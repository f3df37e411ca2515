//! What a person reads when something is wrong.

use granflow_base::Dims;
use granflow_dict::{Diags, MemoryFiles, Reader, Severity, Sink, Source, parse};
use insta::assert_snapshot;

/// Parses and reads; all findings as text.
fn findings(text: &str, read: impl Fn(&Reader<'_>)) -> String {
    let mut files = MemoryFiles::default();
    files.0.insert("system/loop".into(), b"#include \"loop\"\n".to_vec());
    files.0.insert("system/bad".into(), b"a 1;\nb [0 1 2;\n".to_vec());
    let (dict, diags) = parse(Source::new("system/test", text), &mut files);
    let sink = Sink::new();
    sink.extend(diags);
    let r = Reader::new(&dict, &sink);
    read(&r);
    r.finish(Severity::Error);
    sink.take().to_string()
}
fn parsed(text: &str) -> String {
    findings(text, Reader::ignore_all)
}

#[test]
fn a_missing_semicolon_is_found_by_the_value_it_swallowed() {
    let read = |r: &Reader<'_>| {
        r.scalar("deltaT", Dims::TIME);
        r.scalar("endTime", Dims::TIME);
        r.word("startFrom");
    };
    assert_snapshot!(findings("deltaT 0.1\nendTime 5\nstartFrom latestTime;\n", read), @"");
}

#[test]
fn a_missing_semicolon_before_a_dictionary_or_a_brace() {
    assert_snapshot!(parsed("a\n{\n    b 1\n    c { d 2 }\n}\ne 3;\n"), @"");
}

#[test]
fn wrong_dimensions_name_both() {
    let read = |r: &Reader<'_>| {
        r.positive("nu", Dims::KINEMATIC_VISCOSITY);
        r.positive("rho", Dims::DENSITY);
    };
    assert_snapshot!(findings("nu nu [0 2 -2 0 0 0 0] 1e-5;\nrho [1 -3 0] -1000;", read), @"");
}

#[test]
fn misspelt_keys_and_values_are_put_right() {
    let read = |r: &Reader<'_>| {
        let p = r.sub("solvers").and_then(|s| s.sub("p"));
        if let Some(p) = p {
            p.one_of("solver", &[("PCG", 0), ("GAMG", 1), ("PBiCGStab", 2)]);
            p.opt_positive("tolerance", Dims::NONE, 1e-6);
            p.label_in("maxIter", 1..=i64::MAX);
        }
    };
    let text = "solvers\n{\n    p { solver GMAG; tolerence 1e-6; maxIter 0; }\n}\n";
    assert_snapshot!(findings(text, read), @"");
}

#[test]
fn missing_entries_and_wrong_kinds() {
    let read = |r: &Reader<'_>| {
        r.vector("g", Dims::ACCELERATION);
        r.switch("adjustTimeStep");
        r.label("writeInterval");
        r.sub("functions");
        r.scalar("sigma", Dims::NONE);
    };
    let text =
        "g (0 -9.81);\nadjustTimeStep maybe;\nwriteInterval 0.5;\nfunctions ();\nsigma 0,07;";
    assert_snapshot!(findings(text, read), @"");
    assert_snapshot!(findings("", |r| {
        r.scalar("rho", Dims::DENSITY);
    }), @"");
}

#[test]
fn macros_that_are_not_there() {
    assert_snapshot!(parsed("width 2;\na $widht;\nb { $:c.d; }\ne $width;\n$width;\n"), @"");
}

#[test]
fn arithmetic_points_into_the_expression() {
    assert_snapshot!(parsed("x 3;\na #calc \"2*sqt($x)\";\nb #eval{ 1 + $y };\nc #calc \"1/2\";"), @"");
}

#[test]
fn what_granflow_refuses_it_refuses_by_name() {
    let text =
        "#includeEtc \"caseDicts/general\"\nv #codeStream { code #{ $x; #}; };\n#inclde \"a\"\n";
    assert_snapshot!(parsed(text), @"");
}

#[test]
fn included_files_are_named() {
    assert_snapshot!(parsed("#include \"nothing\"\n#include \"loop\"\n#include \"bad\"\n"), @"");
}

#[test]
fn open_brackets_quotes_and_comments() {
    assert_snapshot!(parsed("a (1 2;\nb \"text;\nc [0 1;\nd 1; }\n"), @"");
    assert_snapshot!(parsed("a { b 1;\n"), @"");
    assert_snapshot!(parsed("a 1;\n/* never"), @"");
    assert_snapshot!(parsed("\"(U|p\" 1;"), @"");
}

#[test]
fn lists_and_fields() {
    let read = |r: &Reader<'_>| {
        r.field_scalar("internalField", 4);
        r.field_vector("value", 4);
        r.field_scalar("p", 4);
    };
    let text = "internalField nonuniform List<scalar> 4(1 2 3);\nvalue uniform 0;\np nonuniform List<scalar> 2(0 oops);";
    assert_snapshot!(findings(text, read), @"");
}

#[test]
fn values_by_position() {
    let read = |r: &Reader<'_>| {
        if let Some(mut t) = r.tokens("div(phi,U)") {
            t.one_of("the integration", &[("Gauss", ())]);
            t.word("the scheme");
            t.number("the limiter's coefficient");
            t.finish();
        }
        if let Some(mut t) = r.tokens("laplacian") {
            t.word("the integration");
            t.word("the interpolation");
            t.finish();
        }
    };
    assert_snapshot!(findings("div(phi,U) Gaus limitedLinear;\nlaplacian Gauss linear 7 8;", read), @"");
}

#[test]
fn columns_count_characters_and_odd_bytes_are_shown() {
    let mut text = "größe \"é\"; λ ".as_bytes().to_vec();
    text.extend_from_slice(b"\xff\xfe (1;\r\n");
    let (_, diags) = parse(Source::new("f", text), &mut MemoryFiles::default());
    assert_snapshot!(Diags::from(diags), @"");
}

#[test]
fn long_lines_are_cut_and_keep_their_column() {
    let text = format!("a ({} 1;", "7 ".repeat(1000));
    let text = text.replace("(7", "7 (7 ").replace("  ", " ");
    let tail = format!("{} b", "x".repeat(900));
    let (_, diags) =
        parse(Source::new("f", format!("{text} {tail} }}")), &mut MemoryFiles::default());
    for d in &diags {
        assert!(d.render(false).lines().all(|l| l.len() < 500));
    }
    assert!(diags.iter().any(|d| d.place().len() > "f:1:1000".len() - 1), "{diags:?}");
}

#[test]
fn order_is_by_file_and_place_and_nothing_is_said_twice() {
    let sink = Sink::new();
    let (d, _) = parse(Source::new("b", "x 1; y 2;"), &mut MemoryFiles::default());
    let (e, _) = parse(Source::new("a", "z 1;"), &mut MemoryFiles::default());
    for dict in [&d, &e, &d] {
        Reader::new(dict, &sink).finish(Severity::Warning);
    }
    let all = sink.take();
    let places: Vec<String> = all.iter().map(|d| d.place()).collect();
    assert_eq!(places, ["a:1:1", "b:1:1", "b:1:6"]);
    assert_eq!((all.n_errors(), all.n_warnings()), (0, 3));
}
