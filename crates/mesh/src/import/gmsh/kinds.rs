//! Gmsh's numbers of element types.

use crate::import::elements::Shape;

/// What an element is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Point,
    Line,
    Triangle,
    Quadrilateral,
    Volume(Shape),
}

impl Kind {
    pub(super) fn dimension(self) -> usize {
        match self {
            Kind::Point => 0,
            Kind::Line => 1,
            Kind::Triangle | Kind::Quadrilateral => 2,
            Kind::Volume(_) => 3,
        }
    }
    pub(super) fn corners(self) -> usize {
        match self {
            Kind::Point => 1,
            Kind::Line => 2,
            Kind::Triangle => 3,
            Kind::Quadrilateral => 4,
            Kind::Volume(shape) => shape.corners(),
        }
    }
}

/// The kind of type `number`; otherwise the name of a type that cannot be used, if there is one.
pub(super) fn kind(number: i64) -> Result<Kind, Option<&'static str>> {
    Ok(match number {
        15 => Kind::Point,
        1 => Kind::Line,
        2 => Kind::Triangle,
        3 => Kind::Quadrilateral,
        4 => Kind::Volume(Shape::Tetrahedron),
        5 => Kind::Volume(Shape::Hexahedron),
        6 => Kind::Volume(Shape::Prism),
        7 => Kind::Volume(Shape::Pyramid),
        8 => return Err(Some("3-node line")),
        9 => return Err(Some("6-node triangle")),
        10 => return Err(Some("9-node quadrilateral")),
        11 => return Err(Some("10-node tetrahedron")),
        12 => return Err(Some("27-node hexahedron")),
        13 => return Err(Some("18-node prism")),
        14 => return Err(Some("14-node pyramid")),
        16 => return Err(Some("8-node quadrilateral")),
        17 => return Err(Some("20-node hexahedron")),
        18 => return Err(Some("15-node prism")),
        19 => return Err(Some("13-node pyramid")),
        20..=31 => return Err(Some("element of third or higher order")),
        32..=140 => return Err(Some("element of high order or a special kind")),
        _ => return Err(None),
    })
}
