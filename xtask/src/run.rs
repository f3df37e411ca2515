//! Child processes: cargo, granflow, and whatever they are compared with.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;

/// The root of the repository.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}

/// The cargo that started this program, in the root of the repository.
pub(crate) fn cargo(args: &[&str]) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(args).current_dir(root()).stdin(Stdio::null());
    command
}

/// A command line as a person would repeat it.
pub(crate) fn shown(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_name().unwrap_or(command.get_program());
    let args = command.get_args().map(|a| a.to_string_lossy().into_owned());
    std::iter::once(program.to_string_lossy().into_owned())
        .chain(args)
        .collect::<Vec<_>>()
        .join(" ")
}

/// What a child said and whether it succeeded.
pub(crate) struct Heard {
    pub(crate) success: bool,
    /// Lines of both streams, each stream in its own order, without colours.
    pub(crate) lines: Vec<String>,
}

/// Runs `command`, passing on what it says line by line, and keeps a copy.
pub(crate) fn tee(command: &mut Command) -> Result<Heard, String> {
    let failed = |what: &str, e: &dyn std::fmt::Display| format!("{what}: {e}");
    let name = shown(command);
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|e| failed(&format!("`{name}` did not start"), &e))?;
    let streams = (child.stdout.take(), child.stderr.take());
    let (Some(out), Some(err)) = streams else { return Err(format!("`{name}` has no output")) };
    let errors = thread::spawn(move || pass_on(err, io::stderr()));
    let mut lines = pass_on(out, io::stdout());
    lines.extend(errors.join().unwrap_or_default());
    let status = child.wait().map_err(|e| failed(&name, &e))?;
    Ok(Heard { success: status.success(), lines })
}

fn pass_on(from: impl Read, mut to: impl Write) -> Vec<String> {
    let mut lines = Vec::new();
    let mut reader = BufReader::new(from);
    let mut line = Vec::new();
    while matches!(reader.read_until(b'\n', &mut line), Ok(n) if n > 0) {
        // A closed terminal is no reason to lose the outcome.
        let _ = to.write_all(&line).and_then(|()| to.flush());
        lines.push(plain(&String::from_utf8_lossy(&line)).trim_end().to_owned());
        line.clear();
    }
    lines
}

/// `text` without terminal colours.
pub(crate) fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        if c != '\u{1b}' {
            out.push(c);
        } else if rest.next() == Some('[') {
            rest.by_ref().find(|c| c.is_ascii_alphabetic());
        }
    }
    out
}

/// Builds the `granflow` binary with `profile` and returns where it is.
pub(crate) fn build_granflow(profile: &str) -> Result<PathBuf, String> {
    let mut command = cargo(&["build", "--profile", profile, "-p", "granflow-cli"]);
    command.args(["--bin", "granflow", "--message-format", "json-render-diagnostics"]);
    let output = command.stderr(Stdio::inherit()).output().map_err(|e| e.to_string())?;
    if !output.status.success() {
        return Err(format!("`{}` failed", shown(&command)));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let messages = text.lines().rev().filter_map(|l| serde_json::from_str(l).ok());
    let mut built =
        messages.filter_map(|m: serde_json::Value| m["executable"].as_str().map(PathBuf::from));
    built.next().ok_or_else(|| "cargo built no `granflow` binary".into())
}

/// A command to be run in `dir`, its words to `log` there, with what the reference tool needs around it.
pub(crate) fn logged_command(
    words: &[&str],
    program: Option<&Path>,
    dir: &Path,
    log: &str,
) -> Result<Command, String> {
    let file = std::fs::File::create(dir.join(log)).map_err(|e| format!("{log}: {e}"))?;
    let twin = file.try_clone().map_err(|e| format!("{log}: {e}"))?;
    let (name, rest) = words.split_first().ok_or("no command")?;
    let mut command = program.map_or_else(|| Command::new(name), Command::new);
    command.args(rest).current_dir(dir).stdin(Stdio::null()).stdout(file).stderr(twin);
    command.env("FOAM_SIGFPE", "false");
    if std::env::var_os("WM_PROJECT_DIR").is_none() {
        command.env("WM_PROJECT_DIR", "/usr/share/openfoam");
    }
    Ok(command)
}

/// The whole of a directory, copied.
pub(crate) fn copy_dir(from: &Path, to: &Path) -> io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_dir(&entry.path(), &target)?;
        } else {
            std::fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}

/// Every file below `dir` whose name ends with `ending`, sorted.
pub(crate) fn files_below(dir: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(dir).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files_below(&path, ending));
        } else if path.to_string_lossy().ends_with(ending) {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_taken_out() {
        assert_eq!(plain("\u{1b}[32;1m     Summary\u{1b}[0m [1s]"), "     Summary [1s]");
    }

    #[test]
    fn both_streams_are_heard_and_the_status_is_kept() {
        let mut shell = Command::new("sh");
        shell.args(["-c", "echo one; echo two >&2; exit 3"]);
        let heard = tee(&mut shell).unwrap();
        assert!(!heard.success);
        assert_eq!(heard.lines, ["one", "two"]);
    }
}
