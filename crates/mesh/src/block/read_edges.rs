//! The list `edges` of a `blockMeshDict`.

use super::curve::Curve;
use super::names::Names;
use super::{Edge, HELP_PROJECT};
use granflow_base::scale;
use granflow_dict::{Span, Token, TokenReader, nearest};

/// `None`: out of step; `Some(None)`: a straight line, nothing to keep.
pub(super) fn read_edge(
    list: &mut TokenReader<'_>,
    names: &Names,
    unit: f64,
) -> Option<Option<Edge>> {
    const KNOWN: [&str; 6] = ["arc", "line", "polyLine", "spline", "simpleSpline", "BSpline"];
    let start = list.here();
    let word = list.word("an edge type");
    if word == "project" {
        return projected(list, &start, names);
    }
    if !KNOWN.contains(&word) {
        let help = nearest(word, KNOWN).map(|n| format!("did you mean `{n}`?"));
        let what = format!("edges of type `{word}` are not supported");
        list.error_at(
            &start,
            &what,
            "expected arc, line, polyLine, spline or BSpline",
            help.as_deref(),
        );
        return None;
    }
    let a = names.vertex(list, "the edge's first vertex")?;
    let b = names.vertex(list, "the edge's second vertex")?;
    let curve = match word {
        "line" => return Some(None),
        "arc" => {
            if list.peek().and_then(Token::number).is_some()
                || list.peek().is_some_and(|t| t.word().is_some())
            {
                let help = "write `arc a b (x y z)` with a point the arc passes through";
                list.error("this form of arc is not supported", "not a point", Some(help));
                return None;
            }
            Curve::Arc(scale(list.vector("a point on the arc"), unit))
        }
        _ => {
            let at = list.here();
            let Some(points) = list.next().and_then(Token::vectors) else {
                list.error_at(&at, "expected the points of the edge", "not a list of points", None);
                return None;
            };
            let points = points.into_iter().map(|p| scale(p, unit)).collect();
            match word {
                "polyLine" => Curve::PolyLine(points),
                "BSpline" => Curve::BSpline(points),
                _ => Curve::Spline(points),
            }
        }
    };
    let span = start.to(&list.last_span());
    Some(Some(Edge { ends: [a, b], curve, span }))
}

/// `project a b (surfaces)` is refused, and the rest of the list is still read.
fn projected(list: &mut TokenReader<'_>, start: &Span, names: &Names) -> Option<Option<Edge>> {
    names.vertex(list, "the edge's first vertex")?;
    names.vertex(list, "the edge's second vertex")?;
    let surfaces = list.next().map(|t| t.span.clone());
    let span = surfaces.map_or_else(|| start.clone(), |s| start.to(&s));
    let what = "edges of type `project` are not supported";
    list.error_at(&span, what, "this edge", Some(HELP_PROJECT));
    Some(None)
}
