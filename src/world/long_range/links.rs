//! A joint as the joint graph sees it: which points it ties together, and which rotations it leaves free.

use glam::{Quat, Vec3};

use crate::body::{Body, LockedAxes};
use crate::id::{BodyId, Pool};
use crate::joint::{JointDef, JointKind};
use crate::joint_graph::graph::{PointLink, Turn};
use crate::joint_graph::plane::{Hinge, HingeEnd};
use crate::joint_record::Joint;
use crate::world::unions::Unions;

/// What a joint lets turn, if it holds its points together without give.
fn turn_of(def: &JointDef, frames: [Quat; 2]) -> Option<Turn> {
    if def.linear.compliance > 0.0 {
        return None;
    }
    let stiff = def.angular.compliance == 0.0;
    let stops = stiff && def.limit.compliance == 0.0;
    match def.kind {
        JointKind::Fixed if stiff => Some(Turn::Fixed { frames }),
        JointKind::Hinge { limits, .. } if stops => Some(Turn::Hinge { frames, min: limits.min, max: limits.max }),
        JointKind::Hinge { .. } if stiff => Some(Turn::Hinge { frames, min: f32::NEG_INFINITY, max: f32::INFINITY }),
        JointKind::Spherical { swing_limit, .. } if def.limit.compliance == 0.0 => {
            Some(Turn::Swing { frames, limit: swing_limit })
        }
        JointKind::Fixed | JointKind::Hinge { .. } | JointKind::Spherical { .. } => Some(Turn::Free),
        JointKind::Generic { linear, .. } => {
            let held = linear.iter().all(|axis| axis.limits.min == 0.0 && axis.limits.max == 0.0);
            (held && def.limit.compliance == 0.0).then_some(Turn::Free)
        }
        JointKind::Distance { .. } | JointKind::Prismatic { .. } => None,
    }
}

/// Whether a joint holds two points together without give.
pub(in crate::world) fn holds_points(def: &JointDef) -> bool {
    turn_of(def, [Quat::IDENTITY; 2]).is_some()
}

/// The joint as a hinge of a chain, if it is one without give between bodies that may turn as they like.
pub(super) fn hinge_of(slot: u32, joint: &Joint, unions: &Unions, bodies: &Pool<Body, BodyId>) -> Option<Hinge> {
    let def = &joint.def;
    let rigid = def.linear.compliance == 0.0 && def.angular.compliance == 0.0;
    if !rigid || !def.long_range || !matches!(def.kind, JointKind::Hinge { .. }) {
        return None;
    }
    let end = |side: usize| {
        let frame = if side == 0 { &def.frame_a } else { &def.frame_b };
        let fixed = HingeEnd { body: None, axis: frame.rotation * Vec3::X, point: Vec3::ZERO };
        let Some(index) = joint.bodies[side] else { return Some(fixed) };
        let body = &bodies[index];
        if !body.is_free() || body.quarantined {
            return Some(fixed);
        }
        let point = frame.position.as_vec3() - body.local_center;
        let Some(union) = unions.moving(index) else {
            let unlocked = body.settings.locked_axes == LockedAxes::default();
            return unlocked.then_some(HingeEnd { body: Some(index), point, ..fixed });
        };
        let place = unions.place(index);
        Some(HingeEnd { body: Some(union.lead), axis: place.rotation * fixed.axis, point: place.offset + place.rotation * point })
    };
    let ends = [end(0)?, end(1)?];
    let same = ends[0].body == ends[1].body;
    (!same).then_some(Hinge { joint: slot, ends })
}

/// What a joint holds on each side, a union under its lead; its point and frame there.
pub(in crate::world) fn ends_of(joint: &Joint, unions: &Unions, bodies: &Pool<Body, BodyId>) -> [(Option<u32>, Vec3, Quat); 2] {
    [0, 1].map(|side: usize| {
        let frame = if side == 0 { &joint.def.frame_a } else { &joint.def.frame_b };
        let point = frame.position.as_vec3();
        let Some(index) = joint.bodies[side] else { return (None, point, frame.rotation) };
        let Some(union) = unions.of(index) else { return (Some(index), point, frame.rotation) };
        let place = unions.place(index);
        let point = place.offset + place.rotation * (point - bodies[index].local_center);
        (Some(union.lead), point, (place.rotation * frame.rotation).normalize())
    })
}

/// The joint as a link between what moves as one. `None` for joints inside a union, and for those without bounds past them.
pub(super) fn link_of(joint: &Joint, unions: &Unions, bodies: &Pool<Body, BodyId>) -> Option<PointLink> {
    let [a, b] = ends_of(joint, unions, bodies);
    if !joint.def.long_range || (a.0.is_some() && a.0 == b.0) {
        return None;
    }
    let turn = turn_of(&joint.def, [a.2, b.2])?;
    Some(PointLink { bodies: [a.0, b.0], points: [a.1, b.1], turn })
}
