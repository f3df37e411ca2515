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
    findings(text, |r| r.ignore_all())
}

#[test]
fn a_missing_semicolon_is_found_by_the_value_it_swallowed() {
    let read = |r: &Reader<'_>| {
        r.scalar("deltaT", Dims::TIME);
        r.scalar("endTime", Dims::TIME);
        r.word("startFrom");
    };
    assert_snapshot!(findings("deltaT 0.1\nendTime 5\nstartFrom latestTime;\n", read), @r##"
    error: missing `;` after entry `deltaT`
     --> system/test:1:11
      |
    1 | deltaT 0.1
      |           ^ expected `;` here
      |
      = help: `endTime` on the next line was read as part of it

    error: missing `;` after entry `endTime`
     --> system/test:2:10
      |
    2 | endTime 5
      |          ^ expected `;` here
      |
      = help: `startFrom` on the next line was read as part of it
    "##);
}

#[test]
fn a_missing_semicolon_before_a_dictionary_or_a_brace() {
    assert_snapshot!(parsed("a\n{\n    b 1\n    c { d 2 }\n}\ne 3;\n"), @r##"
    error: missing `;` after entry `b`
     --> system/test:3:8
      |
    3 |     b 1
      |        ^ expected `;` here
      |
      = help: `c` on the next line was read as part of it

    error: missing `;` after entry `d`
     --> system/test:4:12
      |
    4 |     c { d 2 }
      |            ^ expected `;` here
    "##);
}

#[test]
fn wrong_dimensions_name_both() {
    let read = |r: &Reader<'_>| {
        r.positive("nu", Dims::KINEMATIC_VISCOSITY);
        r.positive("rho", Dims::DENSITY);
    };
    assert_snapshot!(findings("nu nu [0 2 -2 0 0 0 0] 1e-5;\nrho [1 -3 0] -1000;", read), @r##"
    error: wrong dimensions for `nu`: expected [0 2 -1 0 0 0 0], found [0 2 -2 0 0 0 0]
     --> system/test:1:7
      |
    1 | nu nu [0 2 -2 0 0 0 0] 1e-5;
      |       ^^^^^^^^^^^^^^^^ expected [0 2 -1 0 0 0 0]

    error: these are no dimensions: dimensions need 5 or 7 exponents, found 3
     --> system/test:2:5
      |
    2 | rho [1 -3 0] -1000;
      |     ^^^^^^^^ cannot be understood

    error: `rho` must be positive, found -1000
     --> system/test:2:14
      |
    2 | rho [1 -3 0] -1000;
      |              ^^^^^ must be positive
    "##);
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
    assert_snapshot!(findings(text, read), @r##"
    error: unknown value `GMAG` for `solver`
     --> system/test:3:16
      |
    3 |     p { solver GMAG; tolerence 1e-6; maxIter 0; }
      |                ^^^^ not known
      |
      = help: did you mean `GAMG`? known: PCG, GAMG, PBiCGStab

    error: unknown entry `tolerence` in `solvers.p`
     --> system/test:3:22
      |
    3 |     p { solver GMAG; tolerence 1e-6; maxIter 0; }
      |                      ^^^^^^^^^ nothing reads this
      |
      = help: did you mean `tolerance`?

    error: `maxIter` must be 1 or more, found 0
     --> system/test:3:46
      |
    3 |     p { solver GMAG; tolerence 1e-6; maxIter 0; }
      |                                              ^ must be 1 or more
    "##);
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
    assert_snapshot!(findings(text, read), @r##"
    error: `g` must be a vector `(x y z)`, found a list of 2 items
     --> system/test:1:3
      |
    1 | g (0 -9.81);
      |   ^^^^^^^^^ expected a vector `(x y z)`

    error: `adjustTimeStep` must be `yes` or `no`, found the word `maybe`
     --> system/test:2:16
      |
    2 | adjustTimeStep maybe;
      |                ^^^^^ expected `yes` or `no`

    error: `writeInterval` must be a whole number, found the number 0.5
     --> system/test:3:15
      |
    3 | writeInterval 0.5;
      |               ^^^ expected a whole number

    error: `functions` must be a sub-dictionary, found an empty list
     --> system/test:4:11
      |
    4 | functions ();
      |           ^^ expected `{`

    error: `,` is not expected after the value of `sigma`
     --> system/test:5:8
      |
    5 | sigma 0,07;
      |        ^ expected `;` before this
      |
      = help: decimals are written with a point
    "##);
    assert_snapshot!(findings("", |r| {
        r.scalar("rho", Dims::DENSITY);
    }), @r##"
    error: missing entry `rho`
    --> system/test
     = help: add `rho [1 -3 0 0 0 0 0] <number>;`
    "##);
}

#[test]
fn macros_that_are_not_there() {
    assert_snapshot!(parsed("width 2;\na $widht;\nb { $:c.d; }\ne $width;\n$width;\n"), @r##"
    error: `$widht` is not defined
     --> system/test:2:3
      |
    2 | a $widht;
      |   ^^^^^^ unknown here
      |
      = help: did you mean `$width`?

    warning: `$:c.d` is not defined
     --> system/test:3:5
      |
    3 | b { $:c.d; }
      |     ^^^^^ nothing is inserted, as in OpenFOAM
      |
      = help: define it above this line

    error: `$width` is not a sub-dictionary
     --> system/test:5:1
      |
    5 | $width;
      | ^^^^^^ only a sub-dictionary can be inserted here
    "##);
}

#[test]
fn arithmetic_points_into_the_expression() {
    assert_snapshot!(parsed("x 3;\na #calc \"2*sqt($x)\";\nb #eval{ 1 + $y };\nc #calc \"1/2\";"), @r##"
    error: unknown function `sqt` with 1 arguments; did you mean `sqrt`?
     --> system/test:2:12
      |
    2 | a #calc "2*sqt($x)";
      |            ^ in this expression

    error: `$y` is not defined
     --> system/test:3:14
      |
    3 | b #eval{ 1 + $y };
      |              ^ in this expression

    warning: a quotient of whole numbers in `#calc`
     --> system/test:4:9
      |
    4 | c #calc "1/2";
      |         ^^^^^ taken as 0.5 here
      |
      = help: OpenFOAM compiles this as C++ and cuts the quotient; write `1.0/2` to mean the same in both
    "##);
}

#[test]
fn what_granflow_refuses_it_refuses_by_name() {
    let text = "#includeEtc \"caseDicts/general\"\nv #codeStream { code #{ $x; #}; };\n#inclde \"a\"\n#includeFunc mag(U)\n";
    assert_snapshot!(parsed(text), @r##"
    error: `#includeEtc "caseDicts/general"` is not available
     --> system/test:1:1
      |
    1 | #includeEtc "caseDicts/general"
      | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ refused
      |
      = help: granflow does not read OpenFOAM's `etc` folder, but for "caseDicts/setConstraintTypes" and what functions include, which are built in; copy the entries that are needed into the case

    error: `#codeStream` is refused: granflow does not compile C++
     --> system/test:2:3
      |
    2 | v #codeStream { code #{ $x; #}; };
      |   ^^^^^^^^^^^ refused
      |
      = help: write the value, or use `#calc "expression"`

    error: unknown directive `#inclde`
     --> system/test:3:1
      |
    3 | #inclde "a"
      | ^^^^^^^ not known
      |
      = help: did you mean `#include`?
    "##);
}

#[test]
fn numbers_that_no_double_holds_are_refused_where_they_stand() {
    assert_snapshot!(parsed("a 1e400;\nb (1 -1e309 2);\nc List<scalar> 2(0 1e999);\nd 1e-400;\n"), @r##"
    error: this number is out of range
     --> system/test:1:3
      |
    1 | a 1e400;
      |   ^^^^^ its magnitude exceeds 1.8e308

    error: this number is out of range
     --> system/test:2:6
      |
    2 | b (1 -1e309 2);
      |      ^^^^^^ its magnitude exceeds 1.8e308

    error: this number is out of range
     --> system/test:3:20
      |
    3 | c List<scalar> 2(0 1e999);
      |                    ^^^^^ its magnitude exceeds 1.8e308
    "##);
}

#[test]
fn what_a_refused_include_would_have_given_is_not_missed() {
    let read = |r: &Reader<'_>| {
        r.scalar("relTol", Dims::NONE);
        r.scalar("tolerance", Dims::NONE);
    };
    let text = "#includeEtc \"caseDicts/solvers\"\ntolerance $fromThere;\n";
    assert_snapshot!(findings(text, read), @r##"
    error: `#includeEtc "caseDicts/solvers"` is not available
     --> system/test:1:1
      |
    1 | #includeEtc "caseDicts/solvers"
      | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ refused
      |
      = help: granflow does not read OpenFOAM's `etc` folder, but for "caseDicts/setConstraintTypes" and what functions include, which are built in; copy the entries that are needed into the case
    "##);
}

#[test]
fn included_files_are_named() {
    assert_snapshot!(parsed("#include \"nothing\"\n#include \"loop\"\n#include \"bad\"\n"), @r##"
    error: these dimensions are not closed
     --> system/bad:2:3
      |
    2 | b [0 1 2;
      |   ^ no matching `]`

    error: `system/loop` includes itself
     --> system/loop:1:10
      |
    1 | #include "loop"
      |          ^^^^^^ this would never end

    error: cannot include `system/nothing`: no such file
     --> system/test:1:10
      |
    1 | #include "nothing"
      |          ^^^^^^^^^ included here
    "##);
}

#[test]
fn open_brackets_quotes_and_comments() {
    assert_snapshot!(parsed("a (1 2;\nb \"text;\nc [0 1;\nd 1; }\n"), @r##"
    error: this list is not closed
     --> system/test:1:3
      |
    1 | a (1 2;
      |   ^ no matching `)`

    error: this text in quotes is not closed on its line
     --> system/test:2:3
      |
    2 | b "text;
      |   ^^^^^ `"` is missing

    error: these dimensions are not closed
     --> system/test:3:3
      |
    3 | c [0 1;
      |   ^ no matching `]`

    error: unexpected `}`
     --> system/test:4:6
      |
    4 | d 1; }
      |      ^ nothing to close here
    "##);
    assert_snapshot!(parsed("a { b 1;\n"), @r##"
    error: this `{` is not closed
     --> system/test:1:3
      |
    1 | a { b 1;
      |   ^ no matching `}`
    "##);
    assert_snapshot!(parsed("a 1;\n/* never"), @r##"
    error: this comment is not closed
     --> system/test:2:1
      |
    2 | /* never
      | ^^ `*/` is missing
    "##);
    assert_snapshot!(parsed("\"(U|p\" 1;"), @r##"
    error: this key is no regular expression: unclosed group
     --> system/test:1:1
      |
    1 | "(U|p" 1;
      | ^^^^^^ cannot be matched
    "##);
}

#[test]
fn lists_and_fields() {
    let read = |r: &Reader<'_>| {
        r.field_scalar("internalField", 4);
        r.field_vector("value", 4);
        r.field_scalar("p", 4);
    };
    let text = "internalField nonuniform List<scalar> 4(1 2 3);\nvalue uniform 0;\np nonuniform List<scalar> 2(0 oops);";
    assert_snapshot!(findings(text, read), @r##"
    error: this list announces 4 items and holds 3
     --> system/test:1:39
      |
    1 | internalField nonuniform List<scalar> 4(1 2 3);
      |                                       ^ expected 3

    error: `value` needs a vector, found the number 0
     --> system/test:2:15
      |
    2 | value uniform 0;
      |               ^ expected a vector
      |
      = help: write `value uniform <vector>;` or `value nonuniform List<vector> 4 ( ... );`

    error: a number is needed in this list
     --> system/test:3:31
      |
    3 | p nonuniform List<scalar> 2(0 oops);
      |                               ^^^^ not a number
    "##);
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
    assert_snapshot!(findings("div(phi,U) Gaus limitedLinear;\nlaplacian Gauss linear 7 8;", read), @r##"
    error: unknown value `Gaus` for the integration
     --> system/test:1:12
      |
    1 | div(phi,U) Gaus limitedLinear;
      |            ^^^^ not known
      |
      = help: did you mean `Gauss`? known: Gauss

    error: `div(phi,U)` ends where the limiter's coefficient is needed
     --> system/test:1:30
      |
    1 | div(phi,U) Gaus limitedLinear;
      |                              ^ expected a number

    error: the number 7 is not expected after the value of `laplacian`
     --> system/test:2:24
      |
    2 | laplacian Gauss linear 7 8;
      |                        ^ expected `;` before this
    "##);
}

#[test]
fn columns_count_characters_and_odd_bytes_are_shown() {
    let mut text = "größe \"é\"; λ ".as_bytes().to_vec();
    text.extend_from_slice(b"\xff\xfe (1;\r\n");
    let (_, diags) = parse(Source::new("f", text), &mut MemoryFiles::default());
    assert_snapshot!(Diags::from(diags), @r##"
    error: this list is not closed
     --> f:1:17
      |
    1 | größe "é"; λ �� (1;
      |                 ^ no matching `)`
    "##);
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

#[test]
fn one_mistake_is_said_once_and_a_warning_hides_none() {
    let read = |r: &Reader<'_>| {
        r.scalar("a", Dims::NONE);
        r.word("b");
    };
    let said = findings("a $gone;\nb #calc \"1/2\";\n", read);
    assert_eq!(said.matches("error:").count(), 2, "{said}");
    assert!(said.contains("`$gone` is not defined") && !said.contains("has no value"), "{said}");
    assert!(said.contains("`b` must be a word"), "{said}");
}
