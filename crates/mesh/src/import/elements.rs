//! Volumes, surfaces and lines by their points.

use crate::polymesh::PatchKind;
use granflow_base::{Vec3, scale};

/// No group.
pub(super) const NONE: u32 = u32::MAX;

/// Lists of points one after the other, each of a group.
#[derive(Clone, Debug)]
pub(super) struct Rings {
    ptr: Vec<u32>,
    points: Vec<u32>,
    pub(super) group: Vec<u32>,
}

impl Default for Rings {
    fn default() -> Rings {
        Rings { ptr: vec![0], points: Vec::new(), group: Vec::new() }
    }
}

impl Rings {
    pub(super) fn push(&mut self, points: &[u32], group: u32) {
        self.points.extend_from_slice(points);
        self.ptr.push(self.points.len() as u32);
        self.group.push(group);
    }
    pub(super) fn len(&self) -> usize {
        self.group.len()
    }
    pub(super) fn get(&self, i: usize) -> &[u32] {
        &self.points[self.ptr[i] as usize..self.ptr[i + 1] as usize]
    }
    fn get_mut(&mut self, i: usize) -> &mut [u32] {
        &mut self.points[self.ptr[i] as usize..self.ptr[i + 1] as usize]
    }
    pub(super) fn iter(&self) -> impl Iterator<Item = (&[u32], u32)> {
        (0..self.len()).map(|i| (self.get(i), self.group[i]))
    }
    fn largest(&self) -> Option<u32> {
        self.points.iter().max().copied()
    }
}

/// Cells by their faces, which turn counter-clockwise seen from outside.
#[derive(Clone, Debug)]
pub(super) struct Volumes {
    ptr: Vec<u32>,
    /// Their groups are not used.
    faces: Rings,
    pub(super) group: Vec<u32>,
}

impl Default for Volumes {
    fn default() -> Volumes {
        Volumes { ptr: vec![0], faces: Rings::default(), group: Vec::new() }
    }
}

impl Volumes {
    pub(super) fn push<'f>(&mut self, faces: impl IntoIterator<Item = &'f [u32]>, group: u32) {
        faces.into_iter().for_each(|f| self.faces.push(f, NONE));
        self.ptr.push(self.faces.len() as u32);
        self.group.push(group);
    }
    /// A cell of a known shape.
    pub(super) fn push_shape(&mut self, shape: Shape, points: &[u32], group: u32) {
        for side in shape.sides() {
            let mut ring = [0; 4];
            side.iter().zip(&mut ring).for_each(|(&i, p)| *p = points[i]);
            self.faces.push(&ring[..side.len()], NONE);
        }
        self.ptr.push(self.faces.len() as u32);
        self.group.push(group);
    }
    pub(super) fn len(&self) -> usize {
        self.group.len()
    }
    pub(super) fn is_empty(&self) -> bool {
        self.group.is_empty()
    }
    pub(super) fn faces(&self, c: usize) -> impl Iterator<Item = &[u32]> {
        (self.ptr[c]..self.ptr[c + 1]).map(|f| self.faces.get(f as usize))
    }
    /// Turns all faces of a cell inside out.
    pub(super) fn flip(&mut self, c: usize) {
        (self.ptr[c]..self.ptr[c + 1]).for_each(|f| self.faces.get_mut(f as usize).reverse());
    }
}

/// Shapes of cells that files give by their corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Tetrahedron,
    Pyramid,
    Prism,
    Hexahedron,
}

impl Shape {
    /// Corners of the sides: base first, then upwards, as Gmsh and VTK number them.
    fn sides(self) -> &'static [&'static [usize]] {
        match self {
            Shape::Tetrahedron => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
            Shape::Pyramid => &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
            Shape::Prism => &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]],
            Shape::Hexahedron => &[
                &[0, 3, 2, 1],
                &[4, 5, 6, 7],
                &[0, 1, 5, 4],
                &[1, 2, 6, 5],
                &[2, 3, 7, 6],
                &[3, 0, 4, 7],
            ],
        }
    }
    pub(super) fn corners(self) -> usize {
        match self {
            Shape::Tetrahedron => 4,
            Shape::Pyramid => 5,
            Shape::Prism => 6,
            Shape::Hexahedron => 8,
        }
    }
}

/// A named set of elements of one dimension.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) name: String,
    /// What the file says the patch is.
    pub(super) kind: Option<PatchKind>,
}

/// What a file holds.
#[derive(Clone, Debug, Default)]
pub(super) struct Elements {
    pub(super) points: Vec<Vec3>,
    pub(super) volumes: Volumes,
    pub(super) surfaces: Rings,
    pub(super) lines: Rings,
    /// Groups of lines, surfaces and volumes; the elements' numbers count within each.
    pub(super) groups: [Vec<Group>; 3],
    /// Name of the two sides of a mesh that is made one cell thick.
    pub(super) front_and_back: Option<&'static str>,
    pub(super) notes: Vec<String>,
}

impl Elements {
    /// Number of the group `name` of dimension 1, 2 or 3, which is made when it is new.
    pub(super) fn group(&mut self, dimension: usize, name: &str, kind: Option<PatchKind>) -> u32 {
        let groups = &mut self.groups[dimension - 1];
        let found = groups.iter().position(|g| g.name == name);
        found.unwrap_or_else(|| {
            groups.push(Group { name: name.to_owned(), kind });
            groups.len() - 1
        }) as u32
    }
    pub(super) fn scale(&mut self, by: f64) {
        self.points.iter_mut().for_each(|p| *p = scale(*p, by));
    }
    /// Whether all points exist and are finite.
    pub(super) fn check(&self) -> Result<(), String> {
        let n = self.points.len();
        let lists = [&self.volumes.faces, &self.surfaces, &self.lines];
        let largest = lists.iter().filter_map(|l| l.largest()).max();
        if let Some(p) = largest.filter(|&p| p as usize >= n) {
            return Err(format!("an element uses point {p} of {n} (counted from 0)"));
        }
        match self.points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            Some(p) => Err(format!("point {p} (counted from 0) is not finite")),
            None => Ok(()),
        }
    }
}
