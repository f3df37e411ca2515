//! Just enough of an ASCII `polyMesh` directory to compare two of them.

use std::fs;
use std::path::Path;

/// A patch as `boundary` describes it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Patch {
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) len: usize,
    pub(super) start: usize,
}

/// The mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct FoamMesh {
    pub(super) points: Vec<[f64; 3]>,
    pub(super) faces: Vec<Vec<usize>>,
    pub(super) owner: Vec<usize>,
    pub(super) neighbour: Vec<usize>,
    pub(super) patches: Vec<Patch>,
    /// Names of the cell zones and their cells.
    pub(super) zones: Vec<(String, Vec<usize>)>,
}

/// The words of a file behind its header, brackets on their own.
struct Words<'t> {
    text: &'t str,
    file: String,
}

impl<'t> Words<'t> {
    fn next(&mut self) -> Result<&'t str, String> {
        self.skip();
        let marks = ['(', ')', '{', '}', ';'];
        let end = match self.text.find(|c: char| c.is_whitespace() || marks.contains(&c)) {
            Some(0) => 1,
            Some(n) => n,
            None => self.text.len(),
        };
        if end == 0 {
            return Err(format!("{}: ends early", self.file));
        }
        let (word, rest) = self.text.split_at(end);
        self.text = rest;
        Ok(word)
    }
    fn skip(&mut self) {
        loop {
            self.text = self.text.trim_start();
            let after = if self.text.starts_with("//") {
                self.text.find('\n').map(|n| n + 1)
            } else if self.text.starts_with("/*") {
                self.text.find("*/").map(|n| n + 2)
            } else {
                return;
            };
            self.text = after.map_or("", |n| &self.text[n..]);
        }
    }
    fn number<T: std::str::FromStr>(&mut self) -> Result<T, String> {
        let word = self.next()?;
        word.parse().map_err(|_| format!("{}: `{word}` is no number", self.file))
    }
    /// `n ( .. )` or `n { value }`, each item by `item`.
    fn list<T: Clone>(
        &mut self,
        item: impl Fn(&mut Words<'t>) -> Result<T, String>,
    ) -> Result<Vec<T>, String> {
        let n: usize = self.number()?;
        if self.next()? == "{" {
            let value = item(self)?;
            self.next()?;
            return Ok(vec![value; n]);
        }
        let all = (0..n).map(|_| item(self)).collect();
        self.next()?;
        all
    }
}

impl FoamMesh {
    /// The mesh of a case.
    pub(super) fn read(case: &Path) -> Result<FoamMesh, String> {
        let dir = case.join("constant/polyMesh");
        let text = |name: &str| {
            let path = dir.join(name);
            fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))
        };
        let [points, faces, owner, neighbour, boundary] =
            ["points", "faces", "owner", "neighbour", "boundary"].map(text);
        let mut mesh = FoamMesh {
            points: words(&points?, "points", |w| {
                w.list(|w| {
                    w.next()?;
                    let point = [w.number()?, w.number()?, w.number()?];
                    w.next()?;
                    Ok(point)
                })
            })?,
            faces: words(&faces?, "faces", |w| w.list(|w| w.list(Words::number)))?,
            owner: words(&owner?, "owner", |w| w.list(Words::number))?,
            neighbour: words(&neighbour?, "neighbour", |w| w.list(Words::number))?,
            patches: words(&boundary?, "boundary", |w| w.list(patch))?,
            zones: Vec::new(),
        };
        if let Ok(zones) = text("cellZones") {
            mesh.zones = words(&zones, "cellZones", |w| w.list(zone))?;
        }
        Ok(mesh)
    }
    pub(super) fn n_cells(&self) -> usize {
        self.owner.iter().max().map_or(0, |c| c + 1)
    }
}

fn words<T>(
    text: &str,
    file: &str,
    read: impl Fn(&mut Words<'_>) -> Result<T, String>,
) -> Result<T, String> {
    let body = text.split_once("FoamFile").map_or(text, |t| t.1);
    let body = body.split_once('}').map_or(body, |t| t.1);
    read(&mut Words { text: body, file: file.to_owned() })
}

fn patch(w: &mut Words<'_>) -> Result<Patch, String> {
    let name = w.next()?.to_owned();
    w.next()?;
    let mut patch = Patch { name, kind: String::new(), len: 0, start: 0 };
    loop {
        match w.next()? {
            "}" => return Ok(patch),
            "type" => patch.kind = w.next()?.to_owned(),
            "nFaces" => patch.len = w.number()?,
            "startFace" => patch.start = w.number()?,
            _ => {}
        }
        while !matches!(w.next()?, ";") {}
    }
}

fn zone(w: &mut Words<'_>) -> Result<(String, Vec<usize>), String> {
    let name = w.next()?.to_owned();
    let mut cells = Vec::new();
    loop {
        match w.next()? {
            "}" => return Ok((name, cells)),
            "List<label>" => cells = w.list(Words::number)?,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_every_form_are_read() {
        let text = "/* a */ FoamFile { object faces; }\n// b\n2\n(\n3(0 1 2)\n4{7}\n)\n";
        let faces = words(text, "faces", |w| w.list(|w| w.list(Words::number::<usize>))).unwrap();
        assert_eq!(faces, [vec![0, 1, 2], vec![7; 4]]);
        let text = "FoamFile {} 1 ( a { type wall; inGroups 1(wall); nFaces 2; startFace 5; } )";
        let patches = words(text, "boundary", |w| w.list(patch)).unwrap();
        assert_eq!((patches[0].kind.as_str(), patches[0].len, patches[0].start), ("wall", 2, 5));
        let text = "FoamFile {} 1 ( z { type cellZone; cellLabels List<label> 2(0 4); } )";
        assert_eq!(words(text, "z", |w| w.list(zone)).unwrap(), [("z".into(), vec![0, 4])]);
        assert!(words("FoamFile {} 3(1 2", "owner", |w| w.list(Words::number::<usize>)).is_err());
    }
}
