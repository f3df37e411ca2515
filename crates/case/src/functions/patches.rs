//! Patches by name, group or pattern.

use granflow_dict::{Diag, Key, Pattern, Reader, Sink, Span, nearest};
use granflow_mesh::{Mesh, Patch, PatchKind};

/// Patches a function was asked for.
#[derive(Clone, Debug)]
pub(super) struct Patches {
    /// As they were written; empty for all walls.
    names: Vec<String>,
    /// Where they were written.
    span: Span,
}

impl Patches {
    /// Reads the list, or the one name, under `key`.
    pub(super) fn read(r: &Reader<'_>, key: &str) -> Patches {
        let single = r.raw(key).filter(|t| t.len() == 1).and_then(|t| t[0].text());
        let names = match single {
            Some(_) => vec![r.string(key).to_owned()],
            None => r.words(key).into_iter().map(str::to_owned).collect(),
        };
        Patches { names, span: r.value_span(key) }
    }
    /// The same, or all walls where the key is missing.
    pub(super) fn or_walls(r: &Reader<'_>, key: &str) -> Patches {
        if r.has(key) {
            return Patches::read(r, key);
        }
        Patches { names: Vec::new(), span: Span::none() }
    }

    /// Complains about what is no patch of the mesh, where some are wanted by name.
    pub(super) fn check_named(&self, mesh: &Mesh, sink: &Sink) {
        if self.names.is_empty() {
            let d = Diag::error(&self.span, "no patch is named").label("an empty list");
            sink.push(d.help("name patches, their groups, or patterns: `(inlet \"wall.*\")`"));
        }
        self.check(mesh, sink);
        self.check_open(mesh, sink);
    }

    /// Complains about what is no patch of the mesh.
    pub(super) fn check(&self, mesh: &Mesh, sink: &Sink) {
        for w in self.names.iter().filter(|w| !mesh.patches.iter().any(|p| meant(w, p))) {
            let names = mesh.patches.iter().map(|p| p.name.as_str());
            let known: Vec<&str> = names.clone().collect();
            let help = nearest(w, names).map_or_else(
                || format!("the patches are {}", known.join(", ")),
                |n| format!("did you mean `{n}`?"),
            );
            let d = Diag::error(&self.span, format!("the mesh has no patch `{w}`"));
            sink.push(d.label("no such patch").help(help));
        }
    }
    /// Complains about patches that nothing passes.
    pub(super) fn check_open(&self, mesh: &Mesh, sink: &Sink) {
        for p in self.indices(mesh).into_iter().map(|i| &mesh.patches[i]) {
            if p.kind == PatchKind::Empty && self.names.contains(&p.name) {
                let message = format!("nothing passes patch `{}`: it is empty", p.name);
                let help = "choose a patch of the directions that are solved for";
                sink.push(Diag::error(&self.span, message).label("of type empty").help(help));
            }
        }
    }

    /// Their numbers in the mesh.
    pub(super) fn indices(&self, mesh: &Mesh) -> Vec<usize> {
        let wanted = |p: &Patch| match self.names.is_empty() {
            true => p.kind == PatchKind::Wall,
            false => self.names.iter().any(|w| meant(w, p)),
        };
        (0..mesh.patches.len()).filter(|&i| wanted(&mesh.patches[i])).collect()
    }
}

/// Whether `word` means the patch: its name, its group, or a pattern for its name.
fn meant(word: &str, p: &Patch) -> bool {
    *word == *p.name
        || p.in_groups.iter().any(|g| g == word)
        || word.contains(['.', '*', '|', '(', '['])
            && Key::Regex(Pattern::new(word).0).matches(&p.name)
}
