//! Laws that hold for any input.

use granflow_dict::*;
use proptest::prelude::*;

/// Bytes with a strong taste for syntax.
fn soup() -> impl Strategy<Value = Vec<u8>> {
    let bits: Vec<&'static [u8]> = vec![
        b"{",
        b"}",
        b"(",
        b")",
        b"[",
        b"]",
        b";",
        b" ",
        b"\n",
        b"\"",
        b"$",
        b"${",
        b"#",
        b"#calc ",
        b"#include ",
        b"#if ",
        b"#else",
        b"#endif",
        b"#{",
        b"#}",
        b"//",
        b"/*",
        b"*/",
        b"a",
        b"b.c",
        b"List<vector> ",
        b"List<scalar>",
        b"3",
        b"2(",
        b"4{",
        b"-1.5e3",
        b"FoamFile { format binary; class faceList; }",
        b"FoamFile { class labelList; }",
        b"nonuniform ",
        b"\\",
        b"\xff",
        b"\0",
        "é".as_bytes(),
        b"#eval{",
        b"${{",
        b"}}",
        b"#remove ",
        b"#inputMode ",
        b"#includeFunc a",
        b"${a${b}}",
        b"${a${",
        b"\xef\xbb\xbf",
        b"FoamFile { format binary; arch \"MSB;label=64;scalar=32\"; }",
        b"2{(",
        b"(a|b)",
        b"div(phi,U)",
        b"\"(U|p).*\"",
    ];
    let piece = prop_oneof![
        9 => proptest::sample::select(bits).prop_map(<[u8]>::to_vec),
        1 => proptest::collection::vec(any::<u8>(), 0..6),
    ];
    proptest::collection::vec(piece, 0..60).prop_map(|p| p.concat())
}

fn word() -> impl Strategy<Value = String> {
    "[a-zA-Z_][a-zA-Z0-9_.]{0,6}(\\([a-z,]{1,5}\\))?"
}

fn token() -> impl Strategy<Value = Token> {
    let finite = any::<f64>().prop_filter("finite", |x| x.is_finite());
    let leaf = prop_oneof![
        word().prop_map(|w| Token::of_word(&w)),
        "[ -~&&[^\\\\]]{0,8}".prop_map(|s| Token::of_str(&s)),
        finite.prop_map(|x| Token::generated(Tok::Number(x))),
        any::<i64>().prop_filter("symmetric", |i| *i != i64::MIN).prop_map(Token::of_label),
    ];
    leaf.prop_recursive(3, 20, 4, |t| {
        prop_oneof![
            proptest::collection::vec(t.clone(), 0..4).prop_map(Token::of_list),
            proptest::collection::vec(any::<i8>().prop_map(|i| Token::of_label(i.into())), 0..7)
                .prop_map(|v| Token::generated(Tok::Bracket(v))),
        ]
    })
}

fn tree() -> impl Strategy<Value = Dict> {
    let stream = proptest::collection::vec(token(), 0..4).prop_map(granflow_dict::Value::Stream);
    let leaf = proptest::collection::vec((word(), stream), 0..4).prop_map(dict_of);
    leaf.prop_recursive(3, 16, 4, |d| {
        proptest::collection::vec((word(), d.prop_map(granflow_dict::Value::Dict)), 0..4)
            .prop_map(dict_of)
    })
}
fn dict_of(entries: Vec<(String, granflow_dict::Value)>) -> Dict {
    let mut d = Dict::new();
    entries.into_iter().for_each(|(k, v)| d.set(&k, v));
    d
}

/// The same tree without its places.
fn bare(d: &Dict) -> Dict {
    fn token(t: &Token) -> Token {
        Token::generated(match &t.kind {
            Tok::List(l) => Tok::List(l.iter().map(token).collect()),
            Tok::Bracket(l) => Tok::Bracket(l.iter().map(token).collect()),
            Tok::Dict(d) => Tok::Dict(bare(d)),
            k => k.clone(),
        })
    }
    let mut out = Dict::new();
    for e in &d.entries {
        let value = match &e.value {
            granflow_dict::Value::Dict(d) => granflow_dict::Value::Dict(bare(d)),
            granflow_dict::Value::Stream(t) => {
                granflow_dict::Value::Stream(t.iter().map(token).collect())
            }
        };
        out.set(e.key.text(), value);
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_input_brings_the_parser_down(bytes in soup()) {
        let src = Source::new("soup", bytes);
        let (dict, diags) = parse(src.clone(), &mut NoFiles);
        let sink = Sink::new();
        sink.extend(diags);
        let r = Reader::new(&dict, &sink);
        r.scalar("a", granflow_base::Dims::TIME);
        r.sub("b.c");
        r.field_vector("a", 3);
        r.finish(Severity::Error);
        let _ = sink.take().to_string();
        let (_, _, diags) = parse_list_file(src);
        let _ = Diags::from(diags).render(true);
    }

    #[test]
    fn random_bytes_do_not_either(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = Diags::from(parse(Source::new("x", bytes.clone()), &mut NoFiles).1).to_string();
        let _ = Diags::from(parse_list_file(Source::new("x", bytes)).2).to_string();
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_is_read_back(d in tree()) {
        let mut w = Writer::new(&Header::new("dictionary", "x"));
        w.dict(&d);
        let bytes = w.finish();
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let (mut back, diags) = parse(Source::new("x", bytes), &mut NoFiles);
        prop_assert!(diags.is_empty(), "{}\n{text}", Diags::from(diags));
        back.remove("FoamFile");
        prop_assert_eq!(bare(&back), d, "{}", text);
    }

    #[test]
    fn fields_keep_every_bit(x in proptest::collection::vec(any::<f64>().prop_filter("number", |x| !x.is_nan()), 1..20), binary: bool) {
        let format = if binary { Format::Binary } else { Format::Ascii };
        let mut w = Writer::new(&Header::new("volScalarField", "p").format(format));
        w.nonuniform("internalField", &x);
        let (d, diags) = parse(Source::new("p", w.finish()), &mut NoFiles);
        prop_assert!(diags.is_empty(), "{}", Diags::from(diags));
        let sink = Sink::new();
        let back = Reader::new(&d, &sink).field_scalar("internalField", x.len()).into_vec(x.len());
        let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&back), bits(&x));
    }
}
