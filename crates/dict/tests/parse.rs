//! What OpenFOAM's syntax means.

use granflow_base::Dims;
use granflow_dict::*;

fn ok(text: &str) -> Dict {
    let (d, diags) = parse_str(text);
    assert!(diags.is_empty(), "{}", Diags::from(diags));
    d
}

#[test]
fn scopes_of_macros() {
    let d = ok("a 1; s { a 2; t { x $a; y $..a; z $:a; w $:s.a; v $.x; u ${...a}; } }\n\
                alpha.water 7; b $alpha.water; c ${{ $a + 1 }}; k key; $k 5; q $s;\n\
                a-b { m 1; } f { $a-b } g ${none:-4}; h #calc \"${none:-4} + $a\";");
    let t = d.sub("s").and_then(|s| s.sub("t")).unwrap();
    let n = |k: &str| t.number(k).unwrap();
    assert_eq!([n("x"), n("y"), n("z"), n("w"), n("v"), n("u")], [2., 2., 1., 2., 2., 1.]);
    assert_eq!((d.number("b"), d.number("c"), d.number("key")), (Some(7.), Some(2.), Some(5.)));
    assert_eq!((d.number("g"), d.number("h")), (Some(4.), Some(5.)));
    assert_eq!(d.sub("f").unwrap().number("m"), Some(1.0));
    assert_eq!(d.sub("q").unwrap().number("a"), Some(2.0));
}

#[test]
fn repeated_dictionaries_merge_and_modes_are_obeyed() {
    let d = ok("s { a 1; b 2; } s { b 3; c $a; } v 1; v 2;");
    let s = d.sub("s").unwrap();
    assert_eq!((s.number("a"), s.number("b"), s.number("c")), (Some(1.), Some(3.), Some(1.)));
    assert_eq!(d.number("v"), Some(2.0));
    let d = ok(
        "s { a 1; } v 1; #inputMode overwrite\n s { b 1; } #inputMode protect\n v 2; #inputMode merge\n w 1; w 2;",
    );
    assert_eq!(d.sub("s").unwrap().number("a"), None);
    assert_eq!((d.number("v"), d.number("w")), (Some(1.0), Some(2.0)));
    let d = ok("base { a 1; b 2; } new { $base; b 3; } #remove base\n #remove (\"ne.*x\" y)");
    assert_eq!(d.sub("new").unwrap().number("b"), Some(3.0));
    assert!(d.sub("base").is_none());
}

#[test]
fn includes_share_the_scope_and_drop_their_header() {
    let mut files = MemoryFiles::default();
    files.0.insert(
        "0/include/init".into(),
        compress(b"FoamFile { class x; } p 5; #include \"more\"").unwrap(),
    );
    files.0.insert("0/include/more".into(), b"q $p;".to_vec());
    files.0.insert("0/list".into(), b"(0 0 0) (1 0 0)".to_vec());
    let text = "FoamFile { class y; } #include \"include/init\"\n#sinclude \"no\"\nr $q; v ( #include \"../0/list\" (2 0 0) );";
    let (d, diags) = parse(Source::new("0/U", text), &mut files);
    assert!(diags.is_empty(), "{diags:?}");
    assert_eq!(d.number("r"), Some(5.0));
    assert_eq!(d.header().unwrap().word("class"), Some("y"));
    assert_eq!(d.stream("v").unwrap()[0].vectors().unwrap().len(), 3);
}

#[test]
fn conditionals_choose_a_branch() {
    let d = ok(
        "n 2;\n#ifeq $n 2\na 1;\n#if false\nb 1;\n#else\nb 2;\n#endif\n#else\na 3;\n#if 1\n#endif\n#endif\nc 4;",
    );
    assert_eq!((d.number("a"), d.number("b"), d.number("c")), (Some(1.), Some(2.), Some(4.)));
}

#[test]
fn lists_of_all_forms() {
    let d = ok(
        "a (1 2 3); b 3(1 2 3); c 3{1.5}; d List<vector> 2((0 0 1) (1 0 0)); e ((0 (1 2 3)) (1 (4 5 6)));\n\
                f List<word> 2(x y); g nonuniform List<scalar> 0(); h (in { type patch; } out { n 1; }); i 300{2};",
    );
    let t = |k: &str| &d.stream(k).unwrap()[0];
    assert_eq!(t("a").labels().unwrap(), [1, 2, 3]);
    assert_eq!(t("b").labels().unwrap(), [1, 2, 3]);
    assert_eq!(t("c").scalars().unwrap(), [1.5; 3]);
    assert_eq!(t("d").vectors().unwrap(), [[0., 0., 1.], [1., 0., 0.]]);
    assert_eq!(t("e").list().unwrap()[1].list().unwrap()[1].vec3(), Some([4., 5., 6.]));
    assert_eq!(t("f").words().unwrap(), ["x", "y"]);
    assert_eq!(d.stream("g").unwrap()[1].scalars().unwrap(), []);
    assert_eq!(t("h").list().unwrap()[3].dict().unwrap().number("n"), Some(1.0));
    assert_eq!(t("i").labels().unwrap(), [2; 300]);
}

#[test]
fn comments_crlf_verbatim_and_calc() {
    let d = ok(
        "// x\r\na /* y */ 1; /**/ // z\r\nb #{ raw; } #};\r\nc \"q // no comment\";\r\nd #calc \"$a*pow(2,3)\";",
    );
    assert_eq!((d.number("a"), d.number("d")), (Some(1.0), Some(8.0)));
    assert_eq!(d.word("c"), Some("q // no comment"));
    assert_eq!(d.stream("d").unwrap()[0].label(), Some(8), "whole results are labels");
}

#[test]
fn binary_fields_of_both_widths() {
    for (arch, wide) in [("LSB;label=32;scalar=64", true), ("LSB;label=32;scalar=32", false)] {
        let mut b = format!("FoamFile {{ format binary; arch \"{arch}\"; class volVectorField; object U; }}\ninternalField nonuniform List<vector> \n2\n(").into_bytes();
        for x in [1.0f64, 2.0, 3.0, -1.0, 0.5, 0.0] {
            if wide {
                b.extend(x.to_le_bytes());
            } else {
                b.extend((x as f32).to_le_bytes());
            }
        }
        b.extend_from_slice(b");\nwall { value uniform (0 0 0); }");
        let (d, diags) = parse(Source::new("U", b.clone()), &mut NoFiles);
        assert!(diags.is_empty(), "{diags:?}");
        let sink = Sink::new();
        let r = Reader::new(&d, &sink);
        let want = FieldValue::NonUniform(vec![[1., 2., 3.], [-1., 0.5, 0.]]);
        assert_eq!(r.field_vector("internalField", 2), want);
        assert!(r.sub("wall").unwrap().field_vector("value", 9).is_uniform());
        assert!(!sink.has_errors());
        b.truncate(b.len() - 50);
        let (_, diags) = parse(Source::new("U", b), &mut NoFiles);
        assert!(diags[0].message.contains("cut short"), "{diags:?}");
        assert_eq!(diags.len(), 1);
    }
}

#[test]
fn mesh_files_in_both_formats() {
    let (ptr, points) = (vec![0, 4, 7], vec![0, 1, 2, 3, 4, 5, 6]);
    let xyz = vec![[0.0, 0.1, -1e-9], [1.0, 2.0, 3e30]];
    let labels = vec![0, 5, 70_000];
    for format in [Format::Ascii, Format::Binary] {
        let read = |class: &str, list: List<'_>| {
            let h = Header::new(class, "x").location("constant/polyMesh").format(format);
            let (head, p, diags) = parse_list_file(Source::new("x", list_file(&h, list)));
            assert!(diags.is_empty(), "{diags:?}");
            assert_eq!(head.word("object"), Some("x"));
            p
        };
        let faces = read("faceList", List::Faces { ptr: &ptr, points: &points });
        assert_eq!(faces, Payload::Faces { ptr: ptr.clone(), points: points.clone() });
        assert_eq!(read("vectorField", List::Vectors(&xyz)), Payload::Vectors(xyz.clone()));
        assert_eq!(read("labelList", List::Labels(&labels)), Payload::Labels(vec![0, 5, 70_000]));
        assert_eq!(read("scalarField", List::Scalars(&[])), Payload::Scalars(vec![]));
    }
}

#[test]
fn boundary_files_are_text_even_in_binary_meshes() {
    let text = "FoamFile { format binary; class polyBoundaryMesh; }\n2 ( in { type patch; nFaces 3; } \n walls { type wall; inGroups 1(wall); } )\n// end";
    let (_, p, diags) = parse_list_file(Source::new("boundary", text));
    assert!(diags.is_empty(), "{diags:?}");
    let Payload::Entries(e) = p else { panic!("{p:?}") };
    assert_eq!(e[1].key.text(), "walls");
    let Value::Dict(d) = &e[1].value else { panic!() };
    assert_eq!(d.stream("inGroups").unwrap()[0].words().unwrap(), ["wall"]);
}

#[test]
fn list_files_that_lie_are_found_out() {
    let faults = [
        ("FoamFile { class labelList; } 3 (1 2)", "announces 3 items and holds 2"),
        ("FoamFile { class labelList; } 2 (1 2.5)", "a whole number is needed"),
        ("FoamFile { class faceList; } 1 (4(0 1 2))", "holds 3 points"),
        ("FoamFile { class vectorField; } 1 ((0 1))", "a number is needed"),
        ("FoamFile { class vectorField; } 1 ((0 1 2)", "ends inside a list"),
        ("FoamFile { class labelList; format binary; } 9 (abc)", "cut short"),
        ("FoamFile { class labelList; } ", "a list is needed"),
    ];
    for (text, want) in faults {
        let (_, _, diags) = parse_list_file(Source::new("x", text));
        assert!(diags.iter().any(|d| d.message.contains(want)), "{text}: {diags:?}");
    }
}

#[test]
fn dimensioned_entries_in_three_forms_and_named_units() {
    let d =
        ok("a 1; b [0 0 1 0 0 0 0] 2; c c [0 0 1 0 0] 3; d [s] 4; e (1 2 3); f [1 -1 -2 0 0] 5;");
    let sink = Sink::new();
    let r = Reader::new(&d, &sink);
    let times = ["a", "b", "c", "d"].map(|k| r.scalar(k, Dims::TIME));
    assert_eq!(times, [1., 2., 3., 4.]);
    assert_eq!(r.vector("e", Dims::LENGTH), [1., 2., 3.]);
    assert_eq!(
        r.scalar_any("f", &[Dims::KINEMATIC_PRESSURE, Dims::PRESSURE]),
        (5.0, Some(Dims::PRESSURE))
    );
    r.finish(Severity::Error);
    assert_eq!(sink.take().to_string(), "");
}

#[test]
fn nesting_and_doubling_do_not_bring_it_down() {
    for text in [
        "(".repeat(100_000),
        "{".repeat(100_000),
        "a {".repeat(50_000),
        "a (".repeat(50_000),
        "a [".repeat(9_999),
        "1{".repeat(50_000),
    ] {
        let (_, diags) = parse_str(&text);
        assert!(!diags.is_empty() && diags.len() <= 100);
    }
    let mut text = String::from("a0 (1 1);");
    for i in 1..60 {
        text.push_str(&format!("a{i} ($a{} $a{});", i - 1, i - 1));
    }
    let (_, diags) = parse_str(&text);
    assert!(diags.iter().any(|d| d.message.contains("too much")));
}

#[test]
fn the_constraint_types_of_fields_are_built_in() {
    let text = "a 1;\n#includeEtc \"caseDicts/setConstraintTypes\"\nb { type $:wedge.type; }\n";
    let (dict, diags) = parse_str(text);
    assert!(diags.is_empty(), "{diags:?}");
    for name in granflow_dict::CONSTRAINT_TYPES {
        assert_eq!(dict.sub(name).and_then(|d| d.word("type")), Some(*name));
    }
    assert_eq!(dict.sub("b").and_then(|d| d.word("type")), Some("wedge"));
}

#[test]
fn names_within_names_and_what_is_inserted_nowhere() {
    let d =
        ok("name foo; foo { q 1; } h { ${$name}; } i { ${:$name}; } foo_a 3; j ${${name}_a};\n\
                k ${${name}_a}x;");
    assert_eq!(d.sub("h").unwrap().number("q"), Some(1.0));
    assert_eq!(d.sub("i").unwrap().number("q"), Some(1.0));
    assert_eq!((d.number("j"), d.word("k")), (Some(3.0), Some("3x")));
    // foamDictionary inserts nothing for a dictionary that is not there, and says nothing.
    let (d, diags) = parse_str("a { $nope; b 1; } c { ${_${FOAM_EXECUTABLE}}; }");
    assert_eq!(d.sub("a").unwrap().number("b"), Some(1.0));
    assert_eq!(diags.len(), 2);
    assert!(diags.iter().all(|d| d.severity == Severity::Warning), "{diags:?}");
    assert!(diags[1].message.contains("$_granflow"));
    let (_, diags) = parse_str("{} a 1;");
    assert_eq!((diags.len(), diags[0].severity), (1, Severity::Warning));
    let (_, diags) = parse_str("$nope 3;");
    assert_eq!(diags[0].severity, Severity::Error);
    let deep = format!("a {}b{};", "${".repeat(50_000), "}".repeat(50_000));
    assert!(!parse_str(&deep).1.is_empty());
}

#[test]
fn variables_of_the_environment_stand_behind_entries() {
    struct Shell;
    impl Files for Shell {
        fn load(&mut self, _: &str) -> std::io::Result<Vec<u8>> {
            Err(std::io::ErrorKind::NotFound.into())
        }
        fn case_root(&self) -> String {
            "runs/heap".into()
        }
        fn variable(&self, name: &str) -> Option<String> {
            ["SIZE", "MODEL", "FOAM_API"]
                .iter()
                .position(|n| *n == name)
                .map(|i| ["12", "NGF", "2012"][i].to_owned())
        }
    }
    let text = "a $SIZE; b ${MODEL}; MODEL own; c $MODEL; d $FOAM_CASE; e ${FOAM_CASENAME};\n\
                f $FOAM_API; #ifeq $WM_PROJECT OpenFOAM\n g 1; #endif\n h #calc \"2*$SIZE\";";
    let (d, diags) = parse(Source::new("x", text), &mut Shell);
    assert!(diags.is_empty(), "{diags:?}");
    assert_eq!((d.number("a"), d.word("b"), d.word("c")), (Some(12.), Some("NGF"), Some("own")));
    assert_eq!((d.word("d"), d.word("e")), (Some("runs/heap"), Some("heap")));
    assert_eq!((d.number("f"), d.number("g"), d.number("h")), (Some(2012.), Some(1.), Some(24.)));
}

#[test]
fn functions_of_the_case_are_included_as_dictionaries() {
    let mut files = MemoryFiles::default();
    let file = b"FoamFile { class dictionary; }\ntype sets; n $n;";
    files.0.insert("system/graph".into(), file.to_vec());
    let text = "n 3;\nfunctions\n{\n    #includeFunc graph\n    #includeFunc \"graph\"  // again\n    #includeFunc Q\n    #includeFunc components(U)\n}\n";
    let (d, diags) = parse(Source::new("system/controlDict", text), &mut files);
    let graph = d.sub("functions").and_then(|f| f.sub("graph")).unwrap();
    assert_eq!((graph.word("type"), graph.number("n")), (Some("sets"), Some(3.0)));
    assert!(graph.header().is_none());
    // One that is built in, and one that is not known, which its reader refuses.
    assert!(diags.is_empty(), "{diags:?}");
    let of = |name: &str, key: &str| {
        let f = d.sub("functions").and_then(|f| f.sub(name)).unwrap();
        f.entries.iter().any(|e| e.key.text() == key)
    };
    assert!(of("Q", "type") && !of("Q", "includeFunc"));
    assert!(of("components(U)", "includeFunc"));
}

#[test]
fn binary_of_every_architecture_is_read() {
    // Two labels and a vector, big and little endian, 32 and 64 bits each.
    for msb in [false, true] {
        for label in [4usize, 8] {
            for scalar in [4usize, 8] {
                let order = |mut le: Vec<u8>| {
                    if msb {
                        le.reverse();
                    }
                    le
                };
                let arch = format!(
                    "{};label={};scalar={}",
                    if msb { "MSB" } else { "LSB" },
                    8 * label,
                    8 * scalar
                );
                let mut b = format!(
                    "FoamFile {{ format binary; arch \"{arch}\"; class volVectorField; }}\n\
                     l nonuniform List<label> 2("
                )
                .into_bytes();
                for i in [-7i64, 70_000] {
                    b.extend(order(i.to_le_bytes()[..label].to_vec()));
                }
                b.extend_from_slice(b");\nv nonuniform List<vector> 1(");
                for x in [0.5f64, -2.0, 1024.0] {
                    let le = match scalar {
                        4 => (x as f32).to_le_bytes().to_vec(),
                        _ => x.to_le_bytes().to_vec(),
                    };
                    b.extend(order(le));
                }
                b.extend_from_slice(b");\nn 1;");
                let (d, diags) = parse(Source::new("f", b), &mut NoFiles);
                assert!(diags.is_empty(), "{arch}: {diags:?}");
                assert_eq!(d.stream("l").unwrap()[1].labels().unwrap(), [-7, 70_000], "{arch}");
                let v = d.stream("v").unwrap()[1].vectors().unwrap();
                assert_eq!(v, [[0.5, -2.0, 1024.0]], "{arch}");
                assert_eq!(d.number("n"), Some(1.0));
            }
        }
    }
}

#[test]
fn marks_of_editors_and_long_lines_are_no_matter() {
    let d = ok("\u{feff}a 1;\r\nb \"\u{e4}\u{4e2d}\";\r\n");
    assert_eq!((d.number("a"), d.word("b")), (Some(1.0), Some("\u{e4}\u{4e2d}")));
    let (_, p, diags) = parse_list_file(Source::new(
        "points",
        "\u{feff}FoamFile { class vectorField; }\r\n1\r\n((1 2 3))\r\n/ ***** //",
    ));
    assert_eq!(p, Payload::Vectors(vec![[1., 2., 3.]]));
    // OpenFOAM stops behind the list; here it is said.
    assert_eq!((diags.len(), diags[0].severity), (1, Severity::Warning));
    let long = format!("a ({}); b 2;", "x1 ".repeat(200_000));
    let d = ok(&long);
    assert_eq!(d.stream("a").unwrap()[0].list().unwrap().len(), 200_000);
    assert_eq!(d.number("b"), Some(2.0));
}

#[test]
fn patterns_and_their_order_are_those_of_openfoam() {
    let d = ok("\"(U|k)\" 1; \"U.*\" 2; U 3; \"(p|p_rgh)Final\" 4; \"p.*\" 5; div(phi,U) 6;\n\
                \"div\\(phi,.*\\)\" 7;");
    let n = |k: &str| d.number(k);
    assert_eq!((n("U"), n("UFinal"), n("k")), (Some(3.), Some(2.), Some(1.)));
    assert_eq!((n("pFinal"), n("p_rghFinal")), (Some(5.), Some(5.)), "the last one that matches");
    assert_eq!((n("div(phi,U)"), n("div(phi,alpha)")), (Some(6.), Some(7.)));
}
