//! Sections of formats 4.0 and 4.1.

use super::stream::Stream;
use super::{Mesh, known_kind};
use granflow_dict::Diag;

pub(super) fn entities(s: &mut Stream<'_>, mesh: &mut Mesh) -> Result<(), Diag> {
    begin(s);
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = s.size("the number of entities")?;
    }
    for (dimension, n) in counts.into_iter().enumerate() {
        for _ in 0..s.plausible(n, "entities")? {
            let entity = s.int("the number of an entity")?;
            // Format 4.1 gives the place of a point, everything else a box.
            let numbers = if dimension == 0 && !s.version_40 { 3 } else { 6 };
            for _ in 0..numbers {
                s.double("a coordinate")?;
            }
            let n = s.size("the number of physical groups")?;
            let mut groups = Vec::new();
            for _ in 0..s.plausible(n, "physical groups")? {
                groups.push(s.int("the number of a physical group")?);
            }
            if dimension > 0 {
                let n = s.size("the number of bounding entities")?;
                for _ in 0..s.plausible(n, "bounding entities")? {
                    s.int("the number of a bounding entity")?;
                }
            }
            mesh.physical.insert((dimension, entity), groups);
        }
    }
    Ok(())
}

/// What stands in front of a block of nodes or elements: dimension and number of the entity.
fn entity(s: &mut Stream<'_>) -> Result<(usize, i64), Diag> {
    let at = s.here();
    let (a, b) = (s.int("an entity")?, s.int("an entity")?);
    let (dimension, number) = if s.version_40 { (b, a) } else { (a, b) };
    match usize::try_from(dimension) {
        Ok(d) if d < 4 => Ok((d, number)),
        _ => Err(Diag::error(&at, format!("an entity of dimension {dimension}"))),
    }
}

fn begin(s: &mut Stream<'_>) {
    if s.binary() {
        s.line_end();
    }
}

pub(super) fn nodes(s: &mut Stream<'_>, mesh: &mut Mesh) -> Result<(), Diag> {
    begin(s);
    let blocks = s.size("the number of blocks")?;
    s.size("the number of nodes")?;
    if !s.version_40 {
        s.size("the smallest node")?;
        s.size("the largest node")?;
    }
    for _ in 0..s.plausible(blocks, "blocks")? {
        let (dimension, _) = entity(s)?;
        let parametric = s.int("0 or 1")? != 0;
        let n = s.size("the number of nodes")?;
        let n = s.plausible(n, "nodes")? as usize;
        let coordinates = |s: &mut Stream<'_>| -> Result<[f64; 3], Diag> {
            let mut x = [0.0; 3];
            for x in &mut x {
                *x = s.double("a coordinate")?;
            }
            for _ in 0..if parametric { dimension } else { 0 } {
                s.double("a parameter")?;
            }
            Ok(x)
        };
        if s.version_40 {
            for _ in 0..n {
                let label = s.int("the number of a node")? as u64;
                let x = coordinates(s)?;
                mesh.add_point(label, x);
            }
            continue;
        }
        let mut labels = Vec::with_capacity(n);
        for _ in 0..n {
            labels.push(s.size("the number of a node")?);
        }
        for label in labels {
            let x = coordinates(s)?;
            mesh.add_point(label, x);
        }
    }
    Ok(())
}

pub(super) fn elements(s: &mut Stream<'_>, mesh: &mut Mesh) -> Result<(), Diag> {
    begin(s);
    let blocks = s.size("the number of blocks")?;
    s.size("the number of elements")?;
    if !s.version_40 {
        s.size("the smallest element")?;
        s.size("the largest element")?;
    }
    for _ in 0..s.plausible(blocks, "blocks")? {
        let (dimension, entity) = entity(s)?;
        let at = s.here();
        let kind = known_kind(s.int("the type of elements")?, &at)?;
        let n = s.size("the number of elements")?;
        let groups = mesh.physical.get(&(dimension, entity));
        let physical = groups.and_then(|g| g.first().copied()).unwrap_or(0);
        let several = groups.is_some_and(|g| g.len() > 1);
        for _ in 0..s.plausible(n, "elements")? {
            // Format 4.0 has numbers of four bytes here.
            let old = s.version_40;
            let number = |s: &mut Stream<'_>, what: &str| {
                if old { s.int(what).map(|n| n as u64) } else { s.size(what) }
            };
            number(s, "the number of an element")?;
            let at = s.here();
            let mut nodes = [0; 8];
            for node in &mut nodes[..kind.corners()] {
                *node = number(s, "the number of a node")?;
            }
            // The sign tells in which direction the group runs.
            mesh.add_element(kind, entity, physical.abs(), &nodes[..kind.corners()], &at)?;
            mesh.repeated += usize::from(several);
        }
    }
    Ok(())
}
