//! A tutorial on a finer mesh, whose answer is averaged back onto the tutorial's own: every cell in k x k of
//! the plane, steps a k-th. Blocks are divided along their edges, a plane mesh of triangles at the middles of
//! its edges.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// The coarse cell that each fine cell lies in.
pub(crate) type Parents = Vec<usize>;

fn text(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

/// Means of the fine cells of each coarse one, of which there are `n`.
pub(crate) fn means(parents: &[usize], fine: &[[f64; 3]], n: usize) -> Vec<[f64; 3]> {
    let mut sums = vec![([0.0; 3], 0.0); n];
    for (&parent, v) in parents.iter().zip(fine) {
        (0..3).for_each(|k| sums[parent].0[k] += v[k]);
        sums[parent].1 += 1.0;
    }
    sums.into_iter().map(|(sum, count)| sum.map(|s| s / count)).collect()
}

/// Divides the step of `case` by `k`.
pub(crate) fn shorten_steps(case: &Path, k: usize) -> Result<(), String> {
    let path = case.join("system/controlDict");
    let line = |l: &str| match l.strip_prefix("deltaT").and_then(|l| l.trim().strip_suffix(';')) {
        Some(dt) => {
            dt.trim().parse::<f64>().map_or(l.to_owned(), |dt| format!("deltaT {};", dt / k as f64))
        }
        None => l.to_owned(),
    };
    let lines: Vec<String> = text(&path)?.lines().map(line).collect();
    fs::write(&path, lines.join("\n") + "\n").map_err(|e| format!("{}: {e}", path.display()))
}

/// Multiplies the cells of every block of the plane by `k` in both directions.
pub(crate) fn divide_blocks(dict: &Path, k: usize) -> Result<Parents, String> {
    let (mut lines, mut parents, mut first) = (Vec::new(), Vec::new(), 0);
    for line in text(dict)?.lines() {
        let Some((head, counts, tail)) = counts_of_block(line) else {
            lines.push(line.to_owned());
            continue;
        };
        let [nx, ny, nz] = counts;
        lines.push(format!("{head}({} {} {nz}){tail}", k * nx, k * ny));
        for z in 0..nz {
            for y in 0..k * ny {
                parents.extend((0..k * nx).map(|x| first + x / k + nx * (y / k + ny * z)));
            }
        }
        first += nx * ny * nz;
    }
    fs::write(dict, lines.join("\n") + "\n").map_err(|e| format!("{}: {e}", dict.display()))?;
    Ok(parents)
}

/// What stands before, in and behind the parentheses with the number of cells of a block.
fn counts_of_block(line: &str) -> Option<(&str, [usize; 3], &str)> {
    if !line.trim_start().starts_with("hex") {
        return None;
    }
    let open = line.match_indices('(').nth(1)?.0;
    let close = open + line[open..].find(')')?;
    let words: Option<Vec<usize>> =
        line[open + 1..close].split_whitespace().map(|w| w.parse().ok()).collect();
    let counts = <[usize; 3]>::try_from(words?).ok()?;
    Some((&line[..open], counts, &line[close + 1..]))
}

/// A plane mesh of triangles: corners, and the patch of each edge at the boundary.
struct Plane {
    points: Vec<[f64; 2]>,
    triangles: Vec<[usize; 3]>,
    boundary: BTreeMap<[usize; 2], usize>,
}

/// A patch as `boundary` has it.
struct Patch {
    name: String,
    kind: String,
    faces: std::ops::Range<usize>,
}

/// Divides the triangles of a mesh one prism thick at the middles of their edges, `times` times over.
pub(crate) fn divide_triangles(mesh: &Path, times: u32) -> Result<Parents, String> {
    let points = lists(&mesh.join("points"), |w| w.parse::<f64>().ok())?;
    let faces = lists(&mesh.join("faces"), |w| w.parse::<usize>().ok())?;
    let owner = flat(&mesh.join("owner"))?;
    let patches = patches(&mesh.join("boundary"))?;
    let front = points.iter().map(|p| p[2]).fold(f64::MIN, f64::max);
    let back = points.iter().map(|p| p[2]).fold(f64::MAX, f64::min);
    let is_back = |p: usize| points[p][2] < 0.5 * (front + back);
    let mut plane = Plane {
        points: points.iter().map(|p| [p[0], p[1]]).collect(),
        triangles: vec![[usize::MAX; 3]; owner.iter().max().map_or(0, |c| c + 1)],
        boundary: BTreeMap::new(),
    };
    for (k, patch) in patches.iter().enumerate() {
        for f in patch.faces.clone() {
            let at_back: Vec<usize> = faces[f].iter().copied().filter(|p| is_back(*p)).collect();
            match (patch.kind.as_str(), at_back[..].len()) {
                ("empty", 3) => {
                    plane.triangles[owner[f]] = [at_back[0], at_back[1], at_back[2]];
                }
                ("empty", 0) => {}
                (_, 2) => {
                    plane.boundary.insert(edge(at_back[0], at_back[1]), k);
                }
                _ => return Err(format!("{}: no plane of triangles", mesh.display())),
            }
        }
    }
    if plane.triangles.iter().any(|t| t[0] == usize::MAX) {
        return Err(format!("{}: no plane of triangles", mesh.display()));
    }
    let mut parents: Parents = (0..plane.triangles.len()).collect();
    for _ in 0..times {
        plane = plane.divided();
        parents = parents.iter().flat_map(|p| [*p; 4]).collect();
    }
    plane.write(mesh, [back, front], &patches)?;
    Ok(parents)
}

fn edge(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

impl Plane {
    /// Four triangles in place of each.
    fn divided(&self) -> Plane {
        let mut middles = BTreeMap::new();
        let mut points = self.points.clone();
        let mut middle = |a: usize, b: usize| {
            *middles.entry(edge(a, b)).or_insert_with(|| {
                let ([xa, ya], [xb, yb]) = (points[a], points[b]);
                points.push([0.5 * (xa + xb), 0.5 * (ya + yb)]);
                points.len() - 1
            })
        };
        let of = |&[a, b, c]: &[usize; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        let triangles = self.triangles.iter().flat_map(of).collect();
        let halves = self.boundary.iter().flat_map(|(&[a, b], &patch)| {
            let m = middles[&[a, b]];
            [(edge(a, m), patch), (edge(m, b), patch)]
        });
        let boundary = halves.collect();
        Plane { points, triangles, boundary }
    }

    /// As a mesh one prism thick, between two heights.
    fn write(&self, mesh: &Path, heights: [f64; 2], patches: &[Patch]) -> Result<(), String> {
        let above = self.points.len();
        // Edges with their triangles, in the direction in which the first goes round.
        let mut sides: BTreeMap<[usize; 2], ([usize; 2], Vec<usize>)> = BTreeMap::new();
        let mut counterclockwise = Vec::new();
        for (c, t) in self.triangles.iter().enumerate() {
            let [p, q, r] = t.map(|p| self.points[p]);
            let turn = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
            let t = if turn > 0.0 { *t } else { [t[0], t[2], t[1]] };
            counterclockwise.push(t);
            for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
                sides.entry(edge(a, b)).or_insert(([a, b], Vec::new())).1.push(c);
            }
        }
        // Outwards of the first of its triangles.
        let quad = |[a, b]: [usize; 2]| format!("4({a} {b} {} {})", b + above, a + above);
        let mut inner: Vec<(usize, usize, [usize; 2])> = Vec::new();
        let mut outer: Vec<Vec<(String, usize)>> = patches.iter().map(|_| Vec::new()).collect();
        for (key, (way, cells)) in &sides {
            match cells[..] {
                [owner, neighbour] => inner.push((owner, neighbour, *way)),
                [owner] => {
                    let patch = self.boundary.get(key).ok_or("an edge without a patch")?;
                    outer[*patch].push((quad(*way), owner));
                }
                _ => return Err("an edge of three triangles".into()),
            }
        }
        inner.sort_unstable();
        let empty = patches.iter().position(|p| p.kind == "empty").ok_or("no empty patch")?;
        for (c, [p, q, r]) in counterclockwise.iter().enumerate() {
            outer[empty].push((format!("3({p} {r} {q})"), c));
            outer[empty].push((format!("3({} {} {})", p + above, q + above, r + above), c));
        }
        let mut faces: Vec<String> = inner.iter().map(|f| quad(f.2)).collect();
        let mut owner: Vec<String> = inner.iter().map(|f| f.0.to_string()).collect();
        let neighbour: Vec<String> = inner.iter().map(|f| f.1.to_string()).collect();
        let mut entries = Vec::new();
        for (patch, sides) in patches.iter().zip(outer) {
            entries.push(format!(
                "{} {{ type {}; nFaces {}; startFace {}; }}",
                patch.name,
                patch.kind,
                sides.len(),
                faces.len()
            ));
            for (face, cell) in sides {
                faces.push(face);
                owner.push(cell.to_string());
            }
        }
        let points = heights.iter().flat_map(|z| {
            self.points.iter().map(move |[x, y]| format!("({x:.15e} {y:.15e} {z:.15e})"))
        });
        list(mesh, "points", "vectorField", &points.collect::<Vec<_>>())?;
        list(mesh, "faces", "faceList", &faces)?;
        list(mesh, "owner", "labelList", &owner)?;
        list(mesh, "neighbour", "labelList", &neighbour)?;
        list(mesh, "boundary", "polyBoundaryMesh", &entries)
    }
}

fn list(mesh: &Path, name: &str, class: &str, entries: &[String]) -> Result<(), String> {
    let mut text = format!(
        "FoamFile {{ version 2.0; format ascii; class {class}; object {name}; }}\n{}\n(\n",
        entries.len()
    );
    entries.iter().for_each(|e| {
        let _ = writeln!(text, "{e}");
    });
    fs::write(mesh.join(name), text + ")\n").map_err(|e| format!("{name}: {e}"))
}

/// The list of a mesh's file, without its outer parentheses.
fn body(path: &Path) -> Result<String, String> {
    let all = text(path)?;
    let bad = || format!("{}: no list", path.display());
    let (_, behind) = all.split_once('}').ok_or_else(bad)?;
    let (_, list) = behind.split_once('(').ok_or_else(bad)?;
    Ok(list.rsplit_once(')').ok_or_else(bad)?.0.to_owned())
}

/// A list of lists in parentheses.
fn lists<T>(path: &Path, of: impl Fn(&str) -> Option<T>) -> Result<Vec<Vec<T>>, String> {
    let inner = |part: &str| {
        let (_, list) = part.split_once('(')?;
        list.split_whitespace().map(&of).collect::<Option<Vec<T>>>()
    };
    let body = body(path)?;
    let parts = body.split(')').filter(|p| p.contains('('));
    parts.map(|p| inner(p).ok_or(format!("{}: no list", path.display()))).collect()
}

fn flat(path: &Path) -> Result<Vec<usize>, String> {
    let word = |w: &str| w.parse().map_err(|_| format!("{}: {w}", path.display()));
    body(path)?.split_whitespace().map(word).collect()
}

fn patches(path: &Path) -> Result<Vec<Patch>, String> {
    let mut all = Vec::new();
    for part in body(path)?.split('}') {
        let Some((name, entries)) = part.split_once('{') else { continue };
        let entry = |key: &str| {
            let mut words = entries.split_whitespace().skip_while(|w| *w != key);
            words.nth(1).map(|w| w.trim_end_matches(';').to_owned())
        };
        let number = |key: &str| entry(key).and_then(|w| w.parse::<usize>().ok());
        let (Some(kind), Some(n), Some(first)) =
            (entry("type"), number("nFaces"), number("startFace"))
        else {
            return Err(format!("{}: {name}", path.display()));
        };
        all.push(Patch { name: name.trim().to_owned(), kind, faces: first..first + n });
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(name: &str) -> std::path::PathBuf {
        let dir = std::env::temp_dir().join(format!("xtask-finer-{name}-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        dir
    }

    #[test]
    fn fine_cells_of_blocks_know_the_coarse_one() {
        let dir = place("blocks");
        let dict = dir.join("blockMeshDict");
        fs::write(
            &dict,
            "  hex (0 1 2 3 4 5 6 7) (2 1 1) simpleGrading (1 1 1)\nhex (1 0 0 0 0 0 0 9) (1 2 1) simpleGrading (1 1 1)\n",
        )
        .unwrap();
        let parents = divide_blocks(&dict, 2).unwrap();
        assert_eq!(parents, [0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3]);
        let written = fs::read_to_string(&dict).unwrap();
        assert!(written.contains("6 7) (4 2 1) simple") && written.contains("(2 4 1)"));
        fs::write(dir.join("controlDict"), "").unwrap();
        fs::remove_dir_all(&dir).unwrap();
    }

    /// A square of two triangles, twice over: areas and patches stay, and means are exact.
    #[test]
    fn triangles_are_divided() {
        let dir = place("triangles");
        let plane = Plane {
            points: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            triangles: vec![[0, 1, 2], [0, 3, 2]],
            boundary: [([0, 1], 0), ([1, 2], 1), ([2, 3], 0), ([0, 3], 0)].into(),
        };
        let patch =
            |name: &str, kind: &str| Patch { name: name.into(), kind: kind.into(), faces: 0..0 };
        let all = [patch("sides", "wall"), patch("right", "patch"), patch("planes", "empty")];
        plane.write(&dir, [0.0, 0.1], &all).unwrap();
        let parents = divide_triangles(&dir, 2).unwrap();
        assert_eq!(parents.len(), 32);
        assert_eq!(parents.iter().filter(|p| **p == 0).count(), 16);
        let patches = patches(&dir.join("boundary")).unwrap();
        let counts: Vec<usize> = patches.iter().map(|p| p.faces.len()).collect();
        assert_eq!(counts, [12, 4, 64]);
        assert_eq!(flat(&dir.join("neighbour")).unwrap().len(), (3 * 32 - 16) / 2);
        // The upper triangle lies above the diagonal still.
        let faces = lists(&dir.join("faces"), |w| w.parse::<usize>().ok()).unwrap();
        let points = lists(&dir.join("points"), |w| w.parse::<f64>().ok()).unwrap();
        let owner = flat(&dir.join("owner")).unwrap();
        for f in patches[2].faces.clone() {
            let above: f64 = faces[f].iter().map(|p| points[*p][1] - points[*p][0]).sum();
            assert_eq!(above > 0.0, parents[owner[f]] == 1);
        }
        fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn means_and_steps() {
        let dir = place("steps");
        fs::create_dir_all(dir.join("system")).unwrap();
        fs::write(dir.join("system/controlDict"), "deltaT          0.005;\nendTime 1;\n").unwrap();
        shorten_steps(&dir, 4).unwrap();
        let text = fs::read_to_string(dir.join("system/controlDict")).unwrap();
        assert_eq!(text, "deltaT 0.00125;\nendTime 1;\n");
        let fine = [[1.0, 0.0, 0.0], [3.0, 2.0, 0.0], [5.0, 0.0, 1.0]];
        assert_eq!(means(&[1, 1, 0], &fine, 2), [[5.0, 0.0, 1.0], [2.0, 1.0, 0.0]]);
        fs::remove_dir_all(&dir).unwrap();
    }
}
