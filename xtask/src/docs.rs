//! The book's reference: one page per entry of every registry, written from what
//! `granflow list --json KIND` says and from `book/examples/KIND/NAME.txt`.

use crate::{links, run};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A registry as `granflow list` names it, the title of its chapter, and what a user writes to
/// choose an entry where there is no example.
struct Kind {
    name: &'static str,
    title: &'static str,
    intro: &'static str,
    /// What the symbols of its formulae mean, for every page.
    symbols: &'static str,
    choose: fn(&str) -> Option<String>,
}

const KINDS: &[Kind] = &[
    Kind {
        name: "rheologies",
        title: "Rheologies",
        intro: "Values of `transportModel` in `constant/transportProperties`.",
        symbols: "",
        choose: |_| None,
    },
    Kind {
        name: "conditions",
        title: "Boundary conditions",
        intro: "Values of `type` in the `boundaryField` of a field file. Patches of a coupled or \
                constrained kind (cyclic, wedge, empty, symmetry, symmetryPlane) take the \
                condition of that name.",
        symbols: "`phi_f`: the value on the face, `phi_P`: in the cell behind it, `h`: distance of that cell's centre from the \
                  face, `n`: outward unit normal, `S`: area vector, `flux`: outward volume flux, `t`: time, `x_f`: middle of the face. \
                  `value` may stand in every patch's dictionary as OpenFOAM writes it.",
        choose: |_| None,
    },
    Kind {
        name: "waves",
        title: "Waves",
        intro: "Values of `waveModel` for a patch in `constant/waveProperties`, where its conditions \
                are `waveAlpha` and `waveVelocity`.",
        symbols: "`eta`: elevation of the surface over still water, `H`: height from trough to crest, `T`: period, `h`: depth, `a`: angle \
                  against the inward normal, `theta`: phase, `X`: distance ahead of the crest, `k`: wave number, `z`: height over the bottom.",
        choose: |_| None,
    },
    Kind {
        name: "schemes",
        title: "Schemes",
        intro: "Words of `system/fvSchemes`.",
        symbols: "`phi_f`: value on a face, `_P`, `_N`: of its two cells, `_U`, `_D`: of the cell upstream and downstream, `d`: from one \
                  centre to the other, `n`: unit normal, `w`: weight of linear interpolation, `_0`, `_00`: one and two steps earlier, `k`: the number behind the name.",
        choose: |_| None,
    },
    Kind {
        name: "solvers",
        title: "Linear solvers",
        intro: "Values of `solver`, `preconditioner` and `smoother` in `system/fvSolution`.",
        symbols: "`A x = b`, `r = b - A x`, `A = L + D + U`, `M` the preconditioner.",
        choose: |_| None,
    },
    Kind {
        name: "functions",
        title: "Functions",
        intro: "Values of `type` in the `functions` of `system/controlDict`.",
        symbols: "`phi`: a field, `_P`: of a cell, `_f`: on a face, `V`: volume of a cell, `S`: area vector of a face, `n`: unit normal, \
                  `eta`: viscosity.",
        choose: |_| None,
    },
    Kind {
        name: "sources",
        title: "Sources",
        intro: "Values of `type` in `constant/fvOptions`: forces on the bulk.",
        symbols: "`U`: velocity, `V`: volume of a cell, `eta`: viscosity, `rho`: density. With one fluid forces are over the density, m/s2.",
        choose: |_| None,
    },
    Kind {
        name: "cases",
        title: "Cases",
        intro: "Cases that come with the program.",
        symbols: "",
        choose: |name| Some(format!("granflow new {name}\ngranflow run {name}")),
    },
];

/// The heading of `SUMMARY.md` below which everything is generated.
const GENERATED_PART: &str = "# Reference";

pub(crate) fn task(args: &[String]) -> Result<bool, String> {
    let (mut check, mut granflow) = (false, None);
    let mut args = args.iter();
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--check" => check = true,
            "--granflow" => granflow = Some(PathBuf::from(args.next().ok_or("--granflow PATH")?)),
            other => return Err(format!("`docs` knows --check and --granflow, found `{other}`")),
        }
    }
    let granflow = granflow.map_or_else(|| run::build_granflow("test"), Ok)?;
    if !check {
        write(&granflow)?;
    }
    let mut faults = faults(&granflow)?;
    faults.extend(links::faults(&run::root()));
    faults.iter().for_each(|f| println!("{f}"));
    Ok(faults.is_empty())
}

/// Pages that are missing, stale or surplus.
pub(crate) fn faults(granflow: &Path) -> Result<Vec<String>, String> {
    let root = run::root();
    let pages = pages(granflow, &root)?;
    let mut faults = Vec::new();
    for (path, text) in &pages {
        let shown = path.strip_prefix(&root).unwrap_or(path).display();
        match fs::read_to_string(path) {
            Ok(found) if found == *text => (),
            Ok(_) => faults.push(format!("{shown} is stale: run `cargo xtask docs`")),
            Err(_) => faults.push(format!("{shown} is missing: run `cargo xtask docs`")),
        }
    }
    for path in surplus(&root, &pages) {
        let shown = path.strip_prefix(&root).unwrap_or(&path).display();
        faults.push(format!("{shown} describes nothing that exists: run `cargo xtask docs`"));
    }
    Ok(faults)
}

fn write(granflow: &Path) -> Result<(), String> {
    let root = run::root();
    let pages = pages(granflow, &root)?;
    let failed = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    let mut written = 0;
    for (path, text) in &pages {
        if fs::read_to_string(path).is_ok_and(|found| found == *text) {
            continue;
        }
        if let Some(dir) = path.parent() {
            fs::create_dir_all(dir).map_err(|e| failed(dir, e))?;
        }
        fs::write(path, text).map_err(|e| failed(path, e))?;
        written += 1;
    }
    for path in surplus(&root, &pages) {
        fs::remove_file(&path).map_err(|e| failed(&path, e))?;
        written += 1;
    }
    println!("{} pages, {written} of them changed", pages.len());
    Ok(())
}

/// Files among the generated ones that no registry asks for.
fn surplus(root: &Path, pages: &BTreeMap<PathBuf, String>) -> Vec<PathBuf> {
    let found = run::files_below(&root.join("book/src/reference"), ".md");
    found.into_iter().filter(|p| !pages.contains_key(p)).collect()
}

/// Every generated page, by path.
fn pages(granflow: &Path, root: &Path) -> Result<BTreeMap<PathBuf, String>, String> {
    let mut pages = BTreeMap::new();
    let mut contents = String::new();
    commands(granflow, root, &mut pages, &mut contents)?;
    for kind in KINDS {
        let entries = entries(kind, granflow)?;
        let dir = root.join("book/src/reference").join(kind.name);
        contents += &format!("- [{}](reference/{}/index.md)\n", kind.title, kind.name);
        for (name, entries) in &entries {
            contents += &format!("  - [{name}](reference/{}/{name}.md)\n", kind.name);
            let example = root.join("book/examples").join(kind.name).join(format!("{name}.txt"));
            let text = fs::read_to_string(&example).ok().or_else(|| (kind.choose)(name));
            let text =
                text.ok_or_else(|| format!("{}: an example is missing", example.display()))?;
            pages.insert(dir.join(format!("{name}.md")), page(name, entries, kind.symbols, &text));
        }
        pages.insert(dir.join("index.md"), index(kind, &entries));
    }
    let summary = root.join("book/src/SUMMARY.md");
    let text = fs::read_to_string(&summary).map_err(|e| format!("{}: {e}", summary.display()))?;
    let kept = text.split(GENERATED_PART).next().unwrap_or_default();
    pages.insert(summary, format!("{kept}{GENERATED_PART}\n\n{contents}"));
    Ok(pages)
}

/// A page for each command, from what it says of itself.
fn commands(
    granflow: &Path,
    root: &Path,
    pages: &mut BTreeMap<PathBuf, String>,
    contents: &mut String,
) -> Result<(), String> {
    let help = |of: &[&str]| -> Result<String, String> {
        let output = Command::new(granflow).args(of).env("COLUMNS", "100").output();
        let output = output.map_err(|e| format!("{}: {e}", granflow.display()))?;
        // Whatever the file is called.
        let called = granflow.file_name().unwrap_or_default().to_string_lossy();
        let text = String::from_utf8_lossy(&output.stdout);
        Ok(text.trim().replace(&format!("Usage: {called} "), "Usage: granflow "))
    };
    let whole = help(&["--help"])?;
    let lines = whole.lines().skip_while(|l| !l.starts_with("Commands:")).skip(1);
    let lines = lines.take_while(|l| l.starts_with("  "));
    let mut list = format!("{NOTE}# Commands\n\n| command | |\n|---|---|\n");
    *contents += "- [Commands](reference/commands/index.md)\n";
    let dir = root.join("book/src/reference/commands");
    for line in lines {
        let Some((name, summary)) = line.trim().split_once(' ') else { continue };
        if name == "help" {
            continue;
        }
        *contents += &format!("  - [{name}](reference/commands/{name}.md)\n");
        list += &format!("| [{name}]({name}.md) | {} |\n", summary.trim());
        let says = help(&[name, "--help"])?;
        let example = root.join("book/examples/commands").join(format!("{name}.txt"));
        let example =
            fs::read_to_string(&example).map_err(|e| format!("{}: {e}", example.display()))?;
        let page = format!(
            "{NOTE}# granflow {name}\n\n```text\n{says}\n```\n\nExample:\n\n```text\n{}\n```\n",
            example.trim()
        );
        pages.insert(dir.join(format!("{name}.md")), page);
    }
    pages.insert(dir.join("index.md"), list);
    Ok(())
}

/// Entries of one registry by name; a name may stand for several things (solver, preconditioner).
type Entries = Vec<(String, Vec<Value>)>;

fn entries(kind: &Kind, granflow: &Path) -> Result<Entries, String> {
    let output = Command::new(granflow).args(["list", "--json", kind.name]).output();
    let output = output.map_err(|e| format!("{}: {e}", granflow.display()))?;
    let said = |what: &str| format!("`granflow list --json {}` {what}", kind.name);
    if !output.status.success() {
        return Err(said(&format!("failed: {}", String::from_utf8_lossy(&output.stderr).trim())));
    }
    let json: Value =
        serde_json::from_slice(&output.stdout).map_err(|e| said(&format!("is no JSON: {e}")))?;
    let list = json.as_array().ok_or_else(|| said("is no array"))?;
    let mut entries = Entries::new();
    for entry in list {
        let text = |key: &str| entry[key].as_str().filter(|t| !t.is_empty());
        let name = text("name").ok_or_else(|| said("has an entry without a name"))?;
        let wanted: &[&str] = match kind.name {
            "cases" => &["summary", "reference"],
            _ => &["summary", "reference", "formula"],
        };
        for key in wanted {
            text(key).ok_or_else(|| said(&format!("has an entry without {key}: {name}")))?;
        }
        if name.contains(['/', '\\', ' ']) {
            return Err(said(&format!("has an entry that cannot name a file: `{name}`")));
        }
        match entries.iter_mut().find(|(n, _)| n == name) {
            Some((_, same)) => same.push(entry.clone()),
            None => entries.push((name.to_owned(), vec![entry.clone()])),
        }
    }
    Ok(entries)
}

const NOTE: &str = "<!-- Written by `cargo xtask docs` from the registry and from book/examples: \
                    change those, not this page. -->\n\n";

fn page(name: &str, entries: &[Value], symbols: &str, example: &str) -> String {
    let mut out = format!("{NOTE}# {name}\n\n");
    for entry in entries {
        let text = |key: &str| entry[key].as_str().filter(|t| !t.is_empty());
        match text("kind") {
            Some(kind) if entries.len() > 1 => out += &format!("## As {kind}\n\n"),
            Some(kind) => out += &format!("*{}.* ", escape(&capital(kind))),
            None => (),
        }
        match text("mapped_onto").filter(|o| *o != name) {
            Some(other) => {
                out += &format!("Served by [{other}]({other}.md); a run says so once.\n\n");
            }
            None => {
                let summary = escape(text("summary").unwrap_or_default());
                out += &format!("{}.\n\n", capital(&summary));
            }
        }
        if let Some(formula) = text("formula") {
            out += &format!("```text\n{}\n```\n\n", formula.trim().replace("; ", "\n"));
            if !symbols.is_empty() {
                out += &format!("{symbols}\n\n");
            }
        }
        out += &keys(entry);
        out += &format!("Reference: {}.\n\n", escape(text("reference").unwrap_or_default()));
    }
    out += &format!("## Example\n\n```text\n{}\n```\n", example.trim_end());
    out.trim_end().to_owned() + "\n"
}

/// The table of an entry's keys, if it has any.
fn keys(entry: &Value) -> String {
    let Some(keys) = entry["keys"].as_array() else { return String::new() };
    let mut out = String::from("| entry | |\n|---|---|\n");
    for key in keys {
        let text = |i: usize| key[i].as_str().unwrap_or_default();
        out += &format!("| `{}` | {} |\n", text(0), escape(text(1)));
    }
    out + "\n"
}

fn index(kind: &Kind, entries: &Entries) -> String {
    let mut out = format!("{NOTE}# {}\n\n{}\n\n", kind.title, kind.intro);
    let kinds = entries.iter().flat_map(|(_, e)| e).any(|e| e["kind"].is_string());
    let columns: &[(&str, &str)] = match kinds {
        true => &[("kind", "kind"), ("what it is", "summary"), ("reference", "reference")],
        false => &[("what it is", "summary"), ("reference", "reference")],
    };
    let titles: Vec<&str> = columns.iter().map(|c| c.0).collect();
    out += &format!("| name | {} |\n|---{}|\n", titles.join(" | "), "|---".repeat(titles.len()));
    for (name, entries) in entries {
        let column = |key: &str| {
            let mut texts: Vec<String> = Vec::new();
            for e in entries {
                let text = escape(e[key].as_str().unwrap_or_default());
                if !texts.contains(&text) {
                    texts.push(text);
                }
            }
            texts.join("; ")
        };
        let row: Vec<String> = columns.iter().map(|c| column(c.1)).collect();
        out += &format!("| [{name}]({name}.md) | {} |\n", row.join(" | "));
    }
    out
}

/// `text` with what Markdown would take for markup taken out of its hands.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut code = false;
    for c in text.trim().trim_end_matches('.').chars() {
        code ^= c == '`';
        match c {
            // Between backticks nothing is markup, but what ends a cell of a table.
            c if code && !"|\n".contains(c) => out.push(c),
            '<' => out += "&lt;",
            '|' | '*' | '[' | ']' | '\\' => {
                out.push('\\');
                out.push(c);
            }
            '\n' => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

fn capital(text: &str) -> String {
    // A symbol such as mu(I) or p_rgh keeps its case.
    let first = text.split([' ', ',']).next().unwrap_or_default();
    if first.len() > 1 && !first.chars().all(|c| c.is_ascii_lowercase() || c == '-') {
        return text.to_owned();
    }
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |c| c.to_uppercase().collect::<String>() + chars.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_page_holds_what_the_registry_says() {
        let entry = json!({"name": "x", "summary": "thin (n < 1) | thick", "formula": "a*b; b",
                           "reference": "A. Author, J. 1 (2000) 1", "keys": [["k", "m/s"]]});
        let text = page("x", &[entry], "`a`: one.", "type x;\n");
        let expected = "# x\n\nThin (n &lt; 1) \\| thick.\n\n```text\na*b\nb\n```\n\n`a`: one.\n\n| entry | \
                        |\n|---|---|\n| `k` | m/s |\n\nReference: A. Author, J. 1 \
                        (2000) 1.\n\n## Example\n\n```text\ntype x;\n```\n";
        assert!(text.ends_with(expected), "{text}");
    }

    #[test]
    fn one_name_for_two_things_makes_one_page() {
        let entry = |kind: &str| json!({"name": "GAMG", "kind": kind, "summary": format!("a {kind}"), "reference": "R"});
        let text = page("GAMG", &[entry("solver"), entry("preconditioner")], "", "x");
        assert!(
            text.contains("## As solver\n\nA solver.") && text.contains("## As preconditioner")
        );
    }

    #[test]
    fn symbols_keep_their_case() {
        assert_eq!(capital("mu(I) made well posed"), "mu(I) made well posed");
        assert_eq!(capital("dense granular flow"), "Dense granular flow");
    }
}
