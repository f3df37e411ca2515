//! The cases of the repository, inside the program.

/// One built-in case.
pub(crate) struct Builtin {
    /// Its name.
    pub(crate) name: &'static str,
    /// Paths in the case and what the files hold.
    pub(crate) files: &'static [(&'static str, &'static [u8])],
}

/// All of them, by name; `build.rs` collects them.
pub(crate) static ALL: &[Builtin] = include!(concat!(env!("OUT_DIR"), "/cases.rs"));

impl Builtin {
    /// Whether it holds the file `path`.
    pub(crate) fn has(&self, path: &str) -> bool {
        self.files.iter().any(|(p, _)| *p == path)
    }
    /// Whether it takes minutes: run when asked for by its name.
    pub(crate) fn is_slow(&self) -> bool {
        self.text("expect.toml").is_some_and(granflow_case::expect::is_slow)
    }
    /// How many of its steps may use up their passes.
    pub(crate) fn may_not_converge(&self) -> f64 {
        self.text("expect.toml").map_or(0.0, granflow_case::expect::may_not_converge)
    }
    fn text(&self, path: &str) -> Option<&'static str> {
        let (_, bytes) = self.files.iter().find(|(p, _)| *p == path)?;
        std::str::from_utf8(bytes).ok()
    }
    /// One line: the title of its README.
    pub(crate) fn summary(&self) -> String {
        let title =
            self.text("README.md").and_then(|t| t.lines().find_map(|l| l.strip_prefix("# ")));
        title.unwrap_or("no description").trim().trim_end_matches('.').to_owned()
    }
    /// The literature it is compared with: the README's line that starts with `Reference:`.
    pub(crate) fn reference(&self) -> String {
        let text = self.text("README.md").unwrap_or("");
        let mut lines = text.lines().skip_while(|l| !l.starts_with("Reference:"));
        let first = lines.next().and_then(|l| l.strip_prefix("Reference:")).unwrap_or("").trim();
        let rest = lines.take_while(|l| !l.trim().is_empty()).map(str::trim);
        let all: Vec<&str> = std::iter::once(first).chain(rest).filter(|l| !l.is_empty()).collect();
        match all.join(" ").trim_end_matches('.') {
            "" => "see its README".to_owned(),
            known => known.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn every_case_of_the_repository_is_built_in() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases");
        let mut names: Vec<String> = std::fs::read_dir(root)
            .map(|d| d.flatten().collect::<Vec<_>>())
            .unwrap_or_default()
            .iter()
            .filter(|e| e.path().join("system/controlDict").is_file())
            .map(|e| e.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        let known: Vec<&str> = ALL.iter().map(|c| c.name).collect();
        assert_eq!(known, names, "a case was added: touch crates/cli/build.rs");
    }

    #[test]
    fn built_in_cases_hold_input_only() {
        for case in ALL {
            for (path, _) in case.files {
                let top = path.split('/').next().unwrap_or("");
                assert!(!matches!(top, "postProcessing" | "log.jsonl"), "{path}");
                assert!(top == "0" || top.parse::<f64>().is_err(), "{path}");
            }
            assert!(case.text("README.md").is_some(), "{} has no README", case.name);
        }
    }

    #[test]
    fn title_and_reference_come_from_the_readme() {
        static README: &[u8] = b"# A cell of two rings.\n\ntext\n\nReference: A. Author,\nJ. Grains 1 (2000) 1.\n\nmore";
        static FILES: &[(&str, &[u8])] = &[("README.md", README)];
        let case = Builtin { name: "x", files: FILES };
        assert_eq!(case.summary(), "A cell of two rings");
        assert_eq!(case.reference(), "A. Author, J. Grains 1 (2000) 1");
    }
}
