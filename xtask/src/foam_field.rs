//! Just enough of OpenFOAM's ASCII files to compare two answers on one mesh.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

fn text(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

/// `internalField` of a scalar field; a uniform one has `n` values.
pub(crate) fn scalars(path: &Path, n: usize) -> Result<Vec<f64>, String> {
    let all = text(path)?;
    let bad = || format!("{}: no scalar field", path.display());
    let (_, field) = all.split_once("internalField").ok_or_else(bad)?;
    let field = field.trim_start();
    if let Some(value) = field.strip_prefix("uniform") {
        let value = value.split(';').next().and_then(|v| v.trim().parse().ok());
        return Ok(vec![value.ok_or_else(bad)?; n]);
    }
    let (_, list) = field.split_once('(').ok_or_else(bad)?;
    let (list, _) = list.split_once(')').ok_or_else(bad)?;
    list.split_whitespace().map(|w| w.parse().map_err(|_| bad())).collect()
}

/// `internalField` of a vector field; a uniform one has `n` values.
pub(crate) fn vectors(path: &Path, n: usize) -> Result<Vec<[f64; 3]>, String> {
    let all = text(path)?;
    let bad = || format!("{}: no vector field", path.display());
    let (_, field) = all.split_once("internalField").ok_or_else(bad)?;
    let (field, _) = field.split_once("boundaryField").unwrap_or((field, ""));
    let uniform = field.trim_start().starts_with("uniform");
    let (_, list) = field.split_once('(').ok_or_else(bad)?;
    let parts: Option<Vec<f64>> = list
        .split(['(', ')', ';', ' ', '\n'])
        .filter(|w| !w.is_empty())
        .map(|w| w.parse().ok())
        .collect();
    let parts = parts.ok_or_else(bad)?;
    let vectors: Vec<[f64; 3]> = parts.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect();
    match (uniform, vectors.first()) {
        (true, Some(v)) => Ok(vec![*v; n]),
        _ => Ok(vectors),
    }
}

/// Cells that have a face on a patch of type `wall`.
pub(crate) fn cells_at_walls(mesh: &Path) -> Result<Vec<usize>, String> {
    let owner = text(&mesh.join("owner"))?;
    // The header's `note` has no parentheses.
    let list = owner.rsplit_once('(').and_then(|l| l.1.split_once(')')).ok_or("owner: no list")?.0;
    let owner: Vec<usize> = list.split_whitespace().filter_map(|w| w.parse().ok()).collect();
    let mut cells = BTreeSet::new();
    for patch in text(&mesh.join("boundary"))?.split('}') {
        let entry = |key: &str| {
            let mut words = patch.split_whitespace().skip_while(|w| *w != key);
            words.nth(1).map(|w| w.trim_end_matches(';').to_owned())
        };
        let number = |key: &str| entry(key).and_then(|w| w.parse::<usize>().ok());
        if entry("type").as_deref() != Some("wall") {
            continue;
        }
        let (Some(n), Some(first)) = (number("nFaces"), number("startFace")) else { continue };
        cells.extend(owner.iter().skip(first).take(n));
    }
    Ok(cells.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_and_walls_are_read() {
        let dir = std::env::temp_dir().join(format!("xtask-foam-field-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        let file = |name: &str, text: &str| fs::write(dir.join(name), text).unwrap();
        file("a", "internalField uniform 2.5;\nboundaryField {}");
        file("b", "internalField nonuniform List<scalar>\n3\n(\n1\n2e-1\n3\n)\n;\n");
        file("owner", "FoamFile { note \"nCells:2\"; }\n5\n(\n0\n0\n1\n1\n0\n)\n");
        file(
            "boundary",
            "2\n(\n open { type patch; nFaces 2; startFace 1; }\n w { type wall; nFaces 2; startFace 3; }\n)",
        );
        assert_eq!(scalars(&dir.join("a"), 2).unwrap(), [2.5, 2.5]);
        assert_eq!(scalars(&dir.join("b"), 9).unwrap(), [1.0, 0.2, 3.0]);
        assert_eq!(cells_at_walls(&dir).unwrap(), [0, 1]);
        assert!(scalars(&dir.join("owner"), 1).is_err());
        file("u", "internalField uniform (1 2 3);\nboundaryField {}");
        file(
            "v",
            "internalField nonuniform List<vector>\n2\n(\n(1 0 0)\n(0 2e1 0)\n)\n;\nboundaryField {}",
        );
        assert_eq!(vectors(&dir.join("u"), 2).unwrap(), [[1.0, 2.0, 3.0]; 2]);
        assert_eq!(vectors(&dir.join("v"), 2).unwrap(), [[1.0, 0.0, 0.0], [0.0, 20.0, 0.0]]);
        fs::remove_dir_all(&dir).unwrap();
    }
}
