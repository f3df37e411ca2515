//! `blockMesh` of our own beside the reference tool: every `blockMeshDict` of its examples through
//! both, compared point by point, face by face and patch by patch. Needs OpenFOAM and its examples;
//! nothing of either is kept here.
//!
//! Dictionaries that the examples keep compressed are unpacked, those in m4 are expanded where m4
//! is installed. Both programs get the same text in a case that has nothing else but what stands
//! beside it (for `#include`) and a `controlDict` of our own that asks for 16 digits.

mod agree;
mod foam_mesh;

use crate::{bench, run};
use agree::{Verdict, compare};
use foam_mesh::FoamMesh;
use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// All that the tools need of a case beside the dictionary.
const CONTROL: &str =
    "FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }
application icoFoam; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;
writeControl timeStep; writeInterval 1; writeFormat ascii; writePrecision 16;
writeCompression off; timeFormat general; timePrecision 6; runTimeModifiable no;\n";

/// Larger files beside a dictionary are no includes.
const LARGEST: u64 = 1 << 18;

pub(crate) fn task(args: &[String]) -> Result<bool, String> {
    let (mut wanted, mut granflow) = (Vec::new(), None);
    let mut examples = PathBuf::from("/usr/share/doc/openfoam-examples/examples");
    let mut args = args.iter();
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--granflow" => granflow = Some(PathBuf::from(args.next().ok_or("--granflow PATH")?)),
            "--examples" => examples = PathBuf::from(args.next().ok_or("--examples DIR")?),
            part => wanted.push(part),
        }
    }
    let granflow = match granflow {
        Some(path) => path.canonicalize().map_err(|e| format!("{}: {e}", path.display()))?,
        None => run::build_granflow("release")?,
    };
    let mut dicts: Vec<PathBuf> = run::files_below(&examples, "")
        .into_iter()
        .filter(|p| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("blockMeshDict")))
        .collect();
    dicts.retain(|p| wanted.is_empty() || wanted.iter().any(|w| p.to_string_lossy().contains(*w)));
    if dicts.is_empty() {
        return Err(format!("no blockMeshDict below {}", examples.display()));
    }
    let mut seen: HashMap<String, String> = HashMap::new();
    let (mut counts, mut copies, mut differ) = (BTreeMap::new(), 0, 0);
    println!("| dictionary | cells | outcome |\n|---|---|---|");
    for path in &dicts {
        let name = path.strip_prefix(&examples).unwrap_or(path).display().to_string();
        let outcome = match text(path) {
            Err(why) => Outcome::Unusable(why),
            Ok(text) => {
                if seen.contains_key(&text) && !text.contains("#include") {
                    copies += 1;
                    continue;
                }
                seen.insert(text.clone(), name.clone());
                both(path, &text, &name, &granflow)?
            }
        };
        println!("| {name} | {} |", outcome.shown());
        differ += usize::from(matches!(outcome, Outcome::Compared(_, Verdict::Differs(_))));
        *counts.entry(outcome.kind()).or_insert(0) += 1;
    }
    println!("\n{} dictionaries, {copies} of them copies of others", dicts.len());
    for (kind, n) in counts {
        println!("{n:5}  {kind}");
    }
    Ok(differ == 0)
}

enum Outcome {
    /// No dictionary: a template without its preprocessor, a file of another kind.
    Unusable(String),
    /// Both refuse.
    Neither(String),
    /// Only the reference tool refuses.
    TheyRefuse(String),
    /// Only we refuse.
    WeRefuse(String),
    Compared(usize, Verdict),
}

impl Outcome {
    fn kind(&self) -> String {
        match self {
            Outcome::Unusable(_) => "cannot be read by either".into(),
            Outcome::Neither(_) => "refused by both".into(),
            Outcome::TheyRefuse(_) => "refused by the reference tool alone".into(),
            Outcome::WeRefuse(why) => format!("refused by granflow alone: {}", quoted(why)),
            Outcome::Compared(_, Verdict::Same) => "identical, in the same order".into(),
            Outcome::Compared(_, Verdict::Renumbered) => "identical but for the order".into(),
            Outcome::Compared(_, Verdict::Differs(_)) => "different".into(),
        }
    }
    fn shown(&self) -> String {
        match self {
            Outcome::Unusable(why) => format!("- | not a dictionary: {why}"),
            Outcome::Neither(why) => format!("- | refused by both: {why}"),
            Outcome::TheyRefuse(why) => format!("- | only the reference tool refuses: {why}"),
            Outcome::WeRefuse(why) => format!("- | only granflow refuses: {why}"),
            Outcome::Compared(n, Verdict::Same) => format!("{n} | identical"),
            Outcome::Compared(n, Verdict::Renumbered) => format!("{n} | identical, renumbered"),
            Outcome::Compared(n, Verdict::Differs(what)) => format!("{n} | DIFFERS: {what}"),
        }
    }
}

/// What a message says before it says where.
fn quoted(message: &str) -> &str {
    message.split(" at ").next().unwrap_or(message).trim()
}

/// The dictionary as text.
fn text(path: &Path) -> Result<String, String> {
    let shown = path.display().to_string();
    let failed = |e: std::io::Error| format!("{shown}: {e}");
    let mut bytes = if shown.ends_with(".gz") {
        Command::new("gzip").arg("-dc").arg(path).output().map_err(failed)?.stdout
    } else {
        fs::read(path).map_err(failed)?
    };
    if shown.trim_end_matches(".gz").ends_with(".m4") {
        let plain = bench::scratch_place("meshes.m4");
        fs::create_dir_all(plain.parent().unwrap_or(&plain)).map_err(failed)?;
        fs::write(&plain, &bytes).map_err(failed)?;
        let expanded = Command::new("m4").arg(&plain).stderr(Stdio::null()).output();
        bytes = expanded.map_err(|e| format!("m4: {e}"))?.stdout;
    }
    String::from_utf8(bytes).map_err(|e| format!("{shown}: {e}"))
}

/// The directory that holds `system` or `constant` and the dictionary.
fn case_of(dict: &Path) -> &Path {
    let mut at = dict.parent().unwrap_or(dict);
    for _ in 0..2 {
        if at.ends_with("system") || at.ends_with("polyMesh") || at.ends_with("constant") {
            at = at.parent().unwrap_or(at);
        }
    }
    at
}

fn copy_small(from: &Path, to: &Path) -> std::io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let (kind, target) = (entry.metadata()?, to.join(entry.file_name()));
        if kind.is_dir() {
            copy_small(&entry.path(), &target)?;
        } else if kind.len() < LARGEST {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}

fn both(path: &Path, text: &str, name: &str, granflow: &Path) -> Result<Outcome, String> {
    let failed = |e: std::io::Error| format!("{name}: {e}");
    let place = bench::scratch_place("meshes");
    let _ = fs::remove_dir_all(&place);
    let mut logs = Vec::new();
    for (who, program) in [("theirs", None), ("ours", Some(granflow))] {
        let case = place.join(who);
        fs::create_dir_all(case.join("system")).map_err(failed)?;
        let root = case_of(path);
        for part in ["system", "constant"] {
            if root.join(part).is_dir() {
                copy_small(&root.join(part), &case.join(part)).map_err(failed)?;
            }
        }
        let _ = fs::remove_dir_all(case.join("constant/polyMesh"));
        let _ = fs::remove_file(case.join("system/blockMeshDict.gz"));
        let _ = fs::remove_file(case.join("system/controlDict.gz"));
        fs::write(case.join("system/controlDict"), CONTROL).map_err(failed)?;
        fs::write(case.join("system/blockMeshDict"), text).map_err(failed)?;
        let words: &[&str] =
            if program.is_some() { &["granflow", "mesh", "."] } else { &["blockMesh"] };
        let mut command = run::logged_command(words, program, &case, "log.mesh")?;
        let status = command.status().map_err(failed)?;
        let log = fs::read_to_string(case.join("log.mesh")).map_err(failed)?;
        logs.push((status.success(), log));
    }
    let reason = |log: &str, mark: &str| {
        let mut lines = log.lines().skip_while(|l| !l.contains(mark));
        let mut line = lines.next().unwrap_or("no reason given").trim().to_owned();
        if mark.starts_with("-->") {
            line = lines.find(|l| !l.trim().is_empty()).unwrap_or("no reason given").trim().into();
        }
        line.trim_start_matches("error: ").to_owned()
    };
    let (theirs, ours) = (&logs[0], &logs[1]);
    let (their_reason, our_reason) =
        (reason(&theirs.1, "--> FOAM FATAL"), reason(&ours.1, "error"));
    Ok(match (theirs.0, ours.0) {
        (false, false) => Outcome::Neither(our_reason),
        (false, true) => Outcome::TheyRefuse(their_reason),
        (true, false) => Outcome::WeRefuse(our_reason),
        (true, true) => {
            let [a, b] = ["theirs", "ours"].map(|who| FoamMesh::read(&place.join(who)));
            let (a, b) = (a?, b?);
            Outcome::Compared(a.n_cells(), compare(&a, &b))
        }
    })
}
