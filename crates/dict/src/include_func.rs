//! `#includeFunc`: a function's dictionary from `system/`, or one that is built in.
//!
//! `#includeFunc name` reads `system/name` into a dictionary of that name. Arguments replace entries:
//! `mag(U)` sets `field`, `residuals(p, U)` sets `fields`, `patchAverage(name=outlet, p)` sets `name`
//! as well. Where there is no such file, the functions below are known without one. What is
//! neither becomes a dictionary that holds `includeFunc`, for its reader to refuse.

use crate::diag::Diag;
use crate::parse::{Cursor, Parser, Scope};
use crate::source::{Source, Span};
use crate::tree::{Dict, Entry, Key, Token, Value};

/// Functions that need no file: their names, and the entries they stand for.
pub const PACKAGED_FUNCTIONS: &[(&str, &str)] = &[
    ("CourantNo", "type CourantNo; writeControl writeTime;"),
    ("Q", "type Q; writeControl writeTime;"),
    ("cellMax", "type volFieldValue; operation max; fields (U p);"),
    ("cellMin", "type volFieldValue; operation min; fields (U p);"),
    ("div", "type div; field U; writeControl writeTime;"),
    ("flowRatePatch", "type surfaceFieldValue; regionType patch; operation sum; fields (phi);"),
    ("flowType", "type flowType; writeControl writeTime;"),
    ("grad", "type grad; field U; writeControl writeTime;"),
    ("mag", "type mag; field U; writeControl writeTime;"),
    ("magSqr", "type magSqr; field U; writeControl writeTime;"),
    ("minMaxComponents", "type fieldMinMax; mode component; fields (U p);"),
    ("minMaxMagnitude", "type fieldMinMax; mode magnitude; fields (U p);"),
    (
        "patchAverage",
        "type surfaceFieldValue; regionType patch; operation areaAverage; fields (p);",
    ),
    (
        "patchIntegrate",
        "type surfaceFieldValue; regionType patch; operation areaIntegrate; fields (p);",
    ),
    ("residuals", "type solverInfo; fields (p U); writeControl timeStep; writeInterval 1;"),
    ("vorticity", "type vorticity; writeControl writeTime;"),
    ("wallShearStress", "type wallShearStress; writeControl writeTime;"),
    ("writeCellCentres", "type writeCellCentres; writeControl writeTime;"),
    ("writeCellVolumes", "type writeCellVolumes; writeControl writeTime;"),
];

impl Parser<'_> {
    /// Adds the dictionary of the function whose name stands next.
    pub(crate) fn include_func(&mut self, c: &mut Cursor, span: &Span) {
        let at = argument(c, span);
        let whole = at.text().trim().trim_matches('"').to_owned();
        if whole.is_empty() {
            let d = Diag::error(span, "the name of a function is needed behind `#includeFunc`");
            self.push(d.label("such as `#includeFunc residuals`"));
            return;
        }
        let (name, arguments) = match whole.split_once('(') {
            Some((name, rest)) => (name.trim(), rest.strip_suffix(')').unwrap_or(rest)),
            None => (whole.as_str(), ""),
        };
        let root = self.files.case_root();
        let parts = [root.as_str(), "system", name];
        let path = parts.iter().filter(|p| !p.is_empty()).copied().collect::<Vec<_>>().join("/");
        if self.open_files.contains(&path) {
            self.push(Diag::error(&at, format!("`{path}` includes itself")).label("endless"));
            return;
        }
        let packaged = PACKAGED_FUNCTIONS.iter().find(|f| f.0 == name);
        let src = match self.files.load(&path).and_then(crate::decompress) {
            Ok(bytes) => Source::new(path.clone(), bytes),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                let text =
                    packaged.map_or_else(|| format!("includeFunc \"{name}\";"), |f| f.1.into());
                Source::new(format!("etc/{name} (built in)"), text.into_bytes())
            }
            Err(e) => {
                let d = Diag::error(&at, format!("cannot include `{path}`: {e}"));
                self.push(d.label("included here"));
                return;
            }
        };
        let dict = Dict { open: at.clone(), close: at.clone(), ..Dict::new() };
        self.scopes.push(Scope { name: whole.clone(), dict });
        self.open_files.push(path);
        self.entries(&mut Cursor::new(&src), None);
        self.open_files.pop();
        let Some(mut scope) = self.scopes.pop() else { return };
        scope.dict.remove("FoamFile");
        set_arguments(&mut scope.dict, arguments, &at);
        let key = Key::Word(whole.split_whitespace().collect());
        self.add(Entry::new(key, at, Value::Dict(scope.dict)));
    }
}

/// The name behind a directive with its arguments, over several lines if it must be.
fn argument(c: &mut Cursor, span: &Span) -> Span {
    let text = &c.src.text;
    let blank = |b: &u8| *b == b' ' || *b == b'\t';
    let start = c.at + text[c.at..].iter().take_while(|b| blank(b)).count();
    let (mut end, mut depth) = (start, 0usize);
    while let Some(b) = text.get(end) {
        match b {
            b'(' => depth += 1,
            b')' if depth == 0 => break,
            b')' => depth -= 1,
            b'{' | b'}' | b';' if depth == 0 => break,
            b if b.is_ascii_whitespace() && depth == 0 => break,
            _ => {}
        }
        end += 1;
    }
    c.at = end;
    if start == end { span.clone() } else { Span::new(&c.src, start..end) }
}

/// Puts `(a, b, key=value)` in place of what the file says.
fn set_arguments(dict: &mut Dict, arguments: &str, at: &Span) {
    let (mut fields, mut named) = (Vec::new(), Vec::new());
    for argument in split(arguments) {
        match argument.split_once('=') {
            Some((key, value)) => named.push((key.trim().to_owned(), value.trim().to_owned())),
            None => fields.push(Token { span: at.clone(), ..Token::of_word(&argument) }),
        }
    }
    let mut put = |key: &str, value: Vec<Token>| {
        dict.insert(Entry::new(Key::Word(key.into()), at.clone(), Value::Stream(value)));
    };
    for (key, value) in named {
        let (parsed, _) = crate::parse_str(&format!("value {value};"));
        let tokens = parsed.stream("value").map(<[Token]>::to_vec).unwrap_or_default();
        put(&key, tokens.into_iter().map(|t| Token { span: at.clone(), ..t }).collect());
    }
    match fields.len() {
        0 => {}
        1 if dict.find("fields").is_none() => dict_field(dict, fields, at),
        _ => {
            let list = Token { span: at.clone(), ..Token::of_list(fields) };
            let entry =
                Entry::new(Key::Word("fields".into()), at.clone(), Value::Stream(vec![list]));
            dict.insert(entry);
        }
    }
}

fn dict_field(dict: &mut Dict, field: Vec<Token>, at: &Span) {
    dict.insert(Entry::new(Key::Word("field".into()), at.clone(), Value::Stream(field)));
}

/// At commas outside of parentheses.
fn split(arguments: &str) -> Vec<String> {
    let (mut out, mut depth) = (vec![String::new()], 0i32);
    for c in arguments.chars() {
        depth += i32::from(c == '(') - i32::from(c == ')');
        match (c, out.last_mut()) {
            (',', _) if depth == 0 => out.push(String::new()),
            (c, Some(last)) => last.push(c),
            _ => {}
        }
    }
    out.into_iter().map(|s| s.trim().to_owned()).filter(|s| !s.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use crate::{MemoryFiles, Source, parse};

    #[test]
    fn functions_come_from_system_or_are_built_in() {
        let mut files = MemoryFiles::default();
        let line = "start (0 0 0); end (1 0 0); fields (U p);\n#includeEtc \"caseDicts/postProcessing/graphs/sampleDict.cfg\"
            #includeEtc \"caseDicts/postProcessing/graphs/graph.cfg\"";
        files.0.insert("system/singleGraph".into(), line.into());
        let text = "functions { #includeFunc residuals // of all\n #includeFunc mag(U)
            #includeFunc patchAverage(name=outlet, p, U);
            #includeFunc singleGraph\n #includeFunc nobody }";
        let (dict, diags) = parse(Source::new("system/controlDict", text), &mut files);
        assert!(diags.is_empty(), "{diags:?}");
        let functions = dict.sub("functions").unwrap();
        let of = |name: &str| functions.sub(name).unwrap_or_else(|| panic!("{name}"));
        assert_eq!(of("residuals").word("type"), Some("solverInfo"));
        assert_eq!(of("mag(U)").word("field"), Some("U"));
        let average = of("patchAverage(name=outlet,p,U)");
        assert_eq!(average.word("name"), Some("outlet"));
        let fields = average.stream("fields").unwrap()[0].words();
        assert_eq!(fields, Some(vec!["p", "U"]));
        assert_eq!(of("singleGraph").word("type"), Some("sets"));
        assert!(of("nobody").get("includeFunc").is_some());
    }
}
