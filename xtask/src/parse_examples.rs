//! Every file with a `FoamFile` header below a directory through the parser of `crates/dict`,
//! with macros, includes and directives done. OpenFOAM itself is not needed, only its examples.

use granflow_dict::{Diag, Files, Severity, Source, decompress, parse, parse_list_file};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

const EXAMPLES: &str = "/usr/share/doc/openfoam-examples/examples";

/// What became of a file.
enum Outcome {
    Parsed,
    /// It asks for something that is not done, which was said by name.
    Refused(Vec<Diag>),
    /// The parser takes it for wrong.
    Failed(Vec<Diag>),
}

pub(crate) fn task(args: &[String]) -> Result<bool, String> {
    let dir = match args {
        [] => Path::new(EXAMPLES),
        [dir] => Path::new(dir),
        _ => return Err("`parseExamples` takes one directory".into()),
    };
    if !dir.is_dir() {
        return Err(format!("there is no directory `{}`", dir.display()));
    }
    let begun = Instant::now();
    let mut paths = Vec::new();
    walk(dir, &mut paths).map_err(|e| format!("{}: {e}", dir.display()))?;
    paths.sort();
    let (mut parsed, mut templates, mut agreed) = (0, 0, 0);
    let (mut refused, mut failed) = (Vec::new(), Vec::new());
    for path in &paths {
        let bytes = load(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let Some(body) = behind_header(&bytes) else { continue };
        // Text that `m4` or a script turns into a dictionary.
        let name = path.to_string_lossy();
        if [".m4", ".template"].iter().any(|e| name.trim_end_matches(".gz").ends_with(e)) {
            templates += 1;
            continue;
        }
        match read(path, bytes, body) {
            Outcome::Parsed => parsed += 1,
            Outcome::Refused(why) => refused.push(why),
            Outcome::Failed(why) => {
                agreed += usize::from(peer_refuses(path));
                failed.push(why);
            }
        }
    }
    print!("{}", listed("refused", dir, &refused));
    print!("{}", listed("failed", dir, &failed));
    let all = parsed + refused.len() + failed.len();
    println!("{all} files with a header in {:.1} s", begun.elapsed().as_secs_f64());
    println!("  parsed   {parsed}");
    println!("  refused  {}", refused.len());
    println!("  failed   {}, of which foamDictionary refuses {agreed}", failed.len());
    println!("{templates} templates (.m4, .template) with a header were passed over");
    Ok(failed.len() == agreed)
}

fn walk(dir: &Path, out: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(dir)? {
        let entry = entry?;
        let path = entry.path();
        // Linked directories are met where they are; linked files have includes of another case.
        if entry.file_type()?.is_dir() {
            walk(&path, out)?;
        } else if path.is_file() {
            out.push(path);
        }
    }
    Ok(())
}

fn load(path: &Path) -> io::Result<Vec<u8>> {
    fs::read(path).and_then(decompress)
}

/// Where the text behind the `FoamFile` header starts, `None` of a file without one.
fn behind_header(bytes: &[u8]) -> Option<usize> {
    /// Nothing but comments stands before a header.
    const BANNER: usize = 20_000;
    let mut at = 0;
    for line in bytes[..bytes.len().min(BANNER)].split_inclusive(|&b| b == b'\n') {
        if line.trim_ascii_start().starts_with(b"FoamFile") {
            let close = bytes[at..].iter().position(|&b| b == b'}')?;
            return Some(at + close + 1);
        }
        at += line.len();
    }
    None
}

fn read(path: &Path, bytes: Vec<u8>, body: usize) -> Outcome {
    let list = starts_a_list(&bytes[body..]);
    let src = Source::new(path.to_string_lossy(), bytes);
    let diags = if list {
        parse_list_file(src).2
    } else {
        parse(src, &mut Beside { case: case_of(path) }).1
    };
    let errors: Vec<Diag> = diags.into_iter().filter(|d| d.severity == Severity::Error).collect();
    if errors.is_empty() {
        Outcome::Parsed
    } else if errors.iter().all(|d| d.label == "refused") {
        Outcome::Refused(errors)
    } else {
        Outcome::Failed(errors)
    }
}

/// Whether OpenFOAM's `foamDictionary` cannot expand the file either; false where it is not
/// installed.
fn peer_refuses(path: &Path) -> bool {
    let mut peer = Command::new("foamDictionary");
    peer.arg("-case").arg(case_of(path)).arg("-expand").arg(path);
    if std::env::var_os("WM_PROJECT_DIR").is_none() {
        peer.env("WM_PROJECT_DIR", "/usr/share/openfoam");
    }
    peer.current_dir(case_of(path)).output().is_ok_and(|heard| !heard.status.success())
}

/// Whether what follows the header is one list, perhaps with its length, and not entries.
fn starts_a_list(mut text: &[u8]) -> bool {
    loop {
        text = text.trim_ascii_start();
        if text.starts_with(b"//") {
            let line = text.iter().position(|&b| b == b'\n').unwrap_or(text.len());
            text = &text[line..];
        } else {
            return text.first().is_some_and(|&b| b == b'(' || b.is_ascii_digit());
        }
    }
}

/// The nearest directory above `path` that holds `system`, else the file's own.
fn case_of(path: &Path) -> PathBuf {
    let own = path.parent().unwrap_or(path);
    path.ancestors().find(|a| a.join("system").is_dir()).unwrap_or(own).to_path_buf()
}

/// Included files as OpenFOAM finds them: packed ones stand in for missing ones.
struct Beside {
    case: PathBuf,
}

impl Files for Beside {
    fn load(&mut self, path: &str) -> io::Result<Vec<u8>> {
        match fs::read(path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                fs::read(format!("{path}.gz")).map_err(|_| e)
            }
            other => other,
        }
    }
    fn case_root(&self) -> String {
        self.case.to_string_lossy().into_owned()
    }
}

/// The places of what is wrong below each reason.
fn listed(what: &str, dir: &Path, files: &[Vec<Diag>]) -> String {
    let root = format!("{}/", dir.display());
    let mut reasons: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for d in files.iter().flatten() {
        let place = d.place();
        let place = place.strip_prefix(&root).unwrap_or(&place).to_owned();
        let places = reasons.entry(&d.message).or_default();
        // One file may be included by many.
        if !places.contains(&place) {
            places.push(place);
        }
    }
    let mut out = String::new();
    for (reason, places) in reasons {
        out += &format!("{what}: {reason}\n");
        for place in places {
            out += &format!("    {place}\n");
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_and_lists_are_told_from_other_text() {
        let text = b"/* banner */\nFoamFile\n{\n class x;\n}\n// * //\n\n2\n(1 2)\n";
        let body = behind_header(text).unwrap();
        assert!(starts_a_list(&text[body..]));
        assert!(!starts_a_list(b" // 2\n a 1;"));
        assert_eq!(behind_header(b"echo FoamFile {}\n"), None);
    }

    #[test]
    fn what_is_not_done_is_refused_and_what_is_wrong_fails() {
        let of = |text: &str| read(Path::new("x/y"), text.into(), 0);
        assert!(matches!(of("a 1;"), Outcome::Parsed));
        assert!(matches!(of("a #codeStream { code #{ x #}; };"), Outcome::Refused(_)));
        assert!(matches!(of("a #codeStream { code #{ x #}; }; b $c;"), Outcome::Failed(_)));
    }
}
