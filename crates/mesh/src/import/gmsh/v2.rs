//! Sections of format 2.

use super::stream::Stream;
use super::{Mesh, known_kind};
use granflow_dict::Diag;

pub(super) fn nodes(s: &mut Stream<'_>, mesh: &mut Mesh) -> Result<(), Diag> {
    let n = s.text_number("the number of nodes")?;
    let n = s.plausible(n, "nodes")?;
    if s.binary() {
        s.line_end();
    }
    for _ in 0..n {
        let label = s.int("the number of a node")? as u64;
        let mut x = [0.0; 3];
        for x in &mut x {
            *x = s.double("a coordinate")?;
        }
        mesh.add_point(label, x);
    }
    Ok(())
}

pub(super) fn elements(s: &mut Stream<'_>, mesh: &mut Mesh) -> Result<(), Diag> {
    let n = s.text_number("the number of elements")?;
    let n = s.plausible(n, "elements")?;
    if !s.binary() {
        for _ in 0..n {
            s.int("the number of an element")?;
            let at = s.here();
            let kind = known_kind(s.int("the type of an element")?, &at)?;
            let tags = s.int("the number of tags")?;
            element(s, mesh, kind, tags)?;
        }
        return Ok(());
    }
    s.line_end();
    let mut done = 0;
    while done < n {
        let at = s.here();
        let kind = known_kind(s.int("the type of elements")?, &at)?;
        let follow = s.int("the number of elements that follow")?;
        let tags = s.int("the number of tags")?;
        if follow <= 0 {
            return Err(Diag::error(&at, "a group of elements is empty"));
        }
        for _ in 0..follow {
            s.int("the number of an element")?;
            element(s, mesh, kind, tags)?;
        }
        done += follow as u64;
    }
    Ok(())
}

/// The tags (physical group, entity, others) and nodes of one element.
fn element(s: &mut Stream<'_>, mesh: &mut Mesh, kind: super::Kind, tags: i64) -> Result<(), Diag> {
    let mut ids = [0; 2];
    for i in 0..tags.max(0) as usize {
        let tag = s.int("a tag")?;
        if let Some(id) = ids.get_mut(i) {
            *id = tag;
        }
    }
    let at = s.here();
    let mut nodes = [0; 8];
    for node in &mut nodes[..kind.corners()] {
        *node = s.int("the number of a node")? as u64;
    }
    mesh.add_element(kind, ids[1], ids[0], &nodes[..kind.corners()], &at)
}
