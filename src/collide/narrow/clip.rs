//! Clipping a polygon to a convex region, one side at a time (Sutherland and Hodgman 1974).
//!
//! Vertices carry their height along the contact normal and the id of the edge that leaves them, so that every vertex of
//! the result is named by the two edges that meet there, however it came about.
//!
//! A vertex outside a side by less than the `slop` counts as inside and stays where it is: edges that line up would otherwise
//! come and go with rounding. The cut itself is at the side proper, but never off the edge it cuts: where the inner vertex is
//! within the slop, that is where the edge ends. Cutting at the side without that care would extend edges along the
//! side instead of shortening them.

use glam::Vec2;

/// A vertex in the plane of contact.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct ClipVertex {
    /// In the plane of contact (m).
    pub at: Vec2,
    /// Along the contact normal (m).
    pub height: f32,
    /// Id of the edge to the next vertex.
    pub edge: u16,
    /// Whether this is a crossing that fell on the vertex next to it, and is there only to name edges.
    pub spare: bool,
}

/// The half-plane normal·x ≤ offset; `edge` is its id, and vertices beyond it by `slop` are left alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClipLine {
    pub normal: Vec2,
    pub offset: f32,
    pub slop: f32,
    pub edge: u16,
}

impl ClipLine {
    fn beyond(&self, vertex: &ClipVertex) -> f32 {
        self.normal.dot(vertex.at) - self.offset
    }
}

/// Hands what is inside `side` of a closed polygon to `keep`, in order.
#[inline]
pub(super) fn clip(polygon: &[ClipVertex], side: &ClipLine, mut keep: impl FnMut(ClipVertex)) {
    let Some(last) = polygon.last() else { return };
    let (mut from, mut from_beyond) = (last, side.beyond(last));
    for to in polygon {
        let to_beyond = side.beyond(to);
        if (from_beyond <= side.slop) != (to_beyond <= side.slop) {
            let leaving = to_beyond > side.slop;
            let edge = if leaving { side.edge } else { from.edge };
            keep(crossing((from, from_beyond), (to, to_beyond), edge));
        }
        if to_beyond <= side.slop {
            keep(*to);
        }
        (from, from_beyond) = (to, to_beyond);
    }
}

/// The part of the segment from `ends[0]` to `ends[1]` inside `side`.
pub(super) fn clip_segment(ends: [ClipVertex; 2], side: &ClipLine) -> Option<[ClipVertex; 2]> {
    let [from, to] = ends;
    let (from_beyond, to_beyond) = (side.beyond(&from), side.beyond(&to));
    match (from_beyond <= side.slop, to_beyond <= side.slop) {
        (true, true) => Some(ends),
        (false, false) => None,
        (true, false) => Some([from, crossing((&from, from_beyond), (&to, to_beyond), to.edge)]),
        (false, true) => Some([crossing((&from, from_beyond), (&to, to_beyond), from.edge), to]),
    }
}

/// The point on the side between a vertex inside and one outside.
fn crossing((from, from_beyond): (&ClipVertex, f32), (to, to_beyond): (&ClipVertex, f32), edge: u16) -> ClipVertex {
    let s = (from_beyond / (from_beyond - to_beyond)).clamp(0.0, 1.0);
    let spare = from_beyond.min(to_beyond) >= 0.0;
    ClipVertex { at: from.at.lerp(to.at, s), height: from.height + (to.height - from.height) * s, edge, spare }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(half: f32, height: f32) -> Vec<ClipVertex> {
        let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
        (0..).zip(corners).map(|(edge, (x, y))| ClipVertex { at: Vec2::new(x, y), height, edge, spare: false }).collect()
    }

    fn clipped(polygon: &[ClipVertex], side: ClipLine) -> Vec<ClipVertex> {
        let mut kept = Vec::new();
        clip(polygon, &side, |vertex| kept.push(vertex));
        kept
    }

    #[test]
    fn an_edge_along_the_side_is_kept_or_dropped_but_never_extended() {
        for shift in [-2e-6_f32, -1e-7, 0.0, 1e-7, 2e-6] {
            let mut polygon = square(0.5, 0.0);
            polygon[1].at.x += shift;
            polygon[2].at.x -= shift;
            polygon[2].height = 0.3;
            let result = clipped(&polygon, ClipLine { normal: Vec2::X, offset: 0.5, slop: 1e-6, edge: 9 });
            for vertex in &result {
                let reach = vertex.at.abs().max_element();
                assert!(reach <= 0.5 + 3e-6 && (0.0..=0.3).contains(&vertex.height), "shift {shift}: {vertex:?}");
            }
        }
    }

    #[test]
    fn vertices_are_named_by_the_edges_that_meet_in_them() {
        let result = clipped(&square(1.0, 0.0), ClipLine { normal: Vec2::X, offset: 0.25, slop: 0.0, edge: 9 });
        let named: Vec<_> = result.iter().map(|v| (v.at.x, v.at.y, v.edge)).collect();
        assert_eq!(named, [(-1.0, -1.0, 0), (0.25, -1.0, 9), (0.25, 1.0, 2), (-1.0, 1.0, 3)]);
    }

    #[test]
    fn a_segment_is_cut_where_the_side_crosses_it() {
        let ends =
            [(-1.0, 0.0), (1.0, 2.0)].map(|(x, height)| ClipVertex { at: Vec2::new(x, 0.0), height, ..ClipVertex::default() });
        let cut = clip_segment(ends, &ClipLine { normal: Vec2::X, offset: 0.5, slop: 0.0, edge: 9 }).expect("a part is inside");
        assert_eq!((cut[0].at.x, cut[1].at.x, cut[1].height), (-1.0, 0.5, 1.5));
        assert!(clip_segment(ends, &ClipLine { normal: Vec2::Y, offset: -0.5, slop: 0.0, edge: 9 }).is_none());
    }
}
