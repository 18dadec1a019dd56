//! One object of a world as its record.

use longspan::{
    BodyId, BodyKind, BoundKind, BreakCause, BreakLimit, Contact, Geometry, Handle, JointBreak, JointId, JointKind, LocalPose,
    Piece, PlaneState, ShapeDef, ShapeId, Split, Verdict, World,
};
use longspan_stream_schema::{
    LS_STREAM_BODY_ASLEEP, LS_STREAM_EVENT_BROKEN, LS_STREAM_EVENT_SPLIT, LS_STREAM_JOINT_BREAKABLE, LsStreamBody, LsStreamBound,
    LsStreamBreak, LsStreamContact, LsStreamContactPoint, LsStreamEvent, LsStreamJoint, LsStreamJointLoad, LsStreamPiece,
    LsStreamPlane, LsStreamShape,
};

/// What C calls a kind of body, `LS_BODY_…`.
fn body_kind(kind: BodyKind) -> i32 {
    match kind {
        BodyKind::Static => 0,
        BodyKind::Kinematic => 1,
        BodyKind::Dynamic => 2,
    }
}

/// `LS_SUPPORT_…`.
fn verdict(verdict: Verdict) -> i32 {
    match verdict {
        Verdict::Supported => 0,
        Verdict::HeldByJoints => 1,
        Verdict::Ground => 2,
        Verdict::NoContact => 3,
        Verdict::Sliding => 4,
        Verdict::OnUnsupported => 5,
        Verdict::OutsideHull => 6,
        Verdict::HangingLoose => 7,
        Verdict::Moving => 8,
        Verdict::NoGravity => 9,
        Verdict::Braced => 10,
    }
}

/// `LS_JOINT_…`.
fn joint_kind(kind: &JointKind) -> i32 {
    match kind {
        JointKind::Fixed => 0,
        JointKind::Hinge { .. } => 1,
        JointKind::Spherical { .. } => 2,
        JointKind::Distance { .. } => 3,
        JointKind::Prismatic { .. } => 4,
        JointKind::Generic { .. } => 5,
        // A kind that this schema has no number for.
        _ => -1,
    }
}

fn finite_or_zero(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

pub(super) fn body(world: &World, body: BodyId, flags: u32, union_id: u64) -> longspan::Result<LsStreamBody> {
    let pose = world.pose(body)?;
    let support = world.support(body).ok();
    let load = if support.is_some() { world.load_on(body).unwrap_or(0.0) } else { 0.0 };
    let asleep = world.body_kind(body)? == BodyKind::Dynamic && !world.is_awake(body)?;
    Ok(LsStreamBody {
        body: body.to_bits(),
        user_word: world.user_word(body)?,
        union_id,
        step: world.step_count(),
        position: pose.position.to_array(),
        rotation: pose.rotation.to_array(),
        linear_velocity: world.linear_velocity(body)?.to_array(),
        angular_velocity: world.angular_velocity(body)?.to_array(),
        flags: flags | if asleep { LS_STREAM_BODY_ASLEEP } else { 0 },
        kind: body_kind(world.body_kind(body)?),
        mass: world.mass_properties(body)?.map_or(0.0, |mass| mass.mass),
        support: support.map_or(0, |support| verdict(support.verdict)),
        support_margin: support.map_or(0.0, |support| finite_or_zero(support.margin)),
        support_load: finite_or_zero(load),
    })
}

/// Number and sizes of a form; `None` for a compound, which has none of its own.
fn form(geometry: &Geometry) -> Option<(i32, [f32; 3])> {
    Some(match geometry {
        Geometry::Ball { radius } => (0, [*radius, 0.0, 0.0]),
        Geometry::Box { half_extents } => (1, half_extents.to_array()),
        Geometry::Capsule { half_height, radius } => (2, [*half_height, *radius, 0.0]),
        Geometry::Cylinder { half_height, radius } => (3, [*half_height, *radius, 0.0]),
        Geometry::Cone { half_height, radius } => (4, [*half_height, *radius, 0.0]),
        Geometry::ConvexHull { .. } => (5, [0.0; 3]),
        Geometry::TriangleMesh { .. } => (6, [0.0; 3]),
        Geometry::HeightField { .. } => (7, [0.0; 3]),
        Geometry::HalfSpace { normal } => (8, normal.to_array()),
        _ => return None,
    })
}

/// The parts of a shape, each with its record.
pub(super) fn shape(id: ShapeId, body: BodyId, def: &ShapeDef, mut each: impl FnMut(&Geometry, &LsStreamShape)) {
    let record = |local: &LocalPose, geometry: &Geometry, part: u32, part_count: u32| {
        let (kind, size) = form(geometry)?;
        Some(LsStreamShape {
            shape: id.to_bits(),
            body: body.to_bits(),
            user_word: def.user_word,
            kind,
            part,
            part_count,
            reserved: 0,
            position: local.position.to_array(),
            rotation: local.rotation.to_array(),
            size,
            friction: def.material.friction,
            restitution: def.material.restitution,
        })
    };
    match def.shape.geometry() {
        Geometry::Compound { parts } => {
            for (number, (pose, geometry)) in parts.iter().enumerate() {
                let place = LocalPose {
                    position: def.local_pose.position + def.local_pose.rotation * pose.position,
                    rotation: def.local_pose.rotation * pose.rotation,
                };
                if let Some(record) = record(&place, geometry, number as u32, parts.len() as u32) {
                    each(geometry, &record);
                }
            }
        }
        geometry => {
            if let Some(record) = record(&def.local_pose, geometry, 0, 1) {
                each(geometry, &record);
            }
        }
    }
}

pub(super) fn joint(world: &World, joint: JointId) -> longspan::Result<LsStreamJoint> {
    let def = world.joint_def(joint)?;
    Ok(LsStreamJoint {
        joint: joint.to_bits(),
        user_word: def.user_word,
        body_a: def.body_a.to_bits(),
        body_b: def.body_b.to_bits(),
        position_a: def.frame_a.position.to_array(),
        position_b: def.frame_b.position.to_array(),
        rotation_a: def.frame_a.rotation.to_array(),
        rotation_b: def.frame_b.rotation.to_array(),
        kind: joint_kind(&def.kind),
        flags: if def.strength.can_break() { LS_STREAM_JOINT_BREAKABLE } else { 0 },
        break_force: finite_or_zero(def.break_force),
        break_torque: finite_or_zero(def.break_torque),
    })
}

pub(super) fn joint_load(world: &World, joint: JointId) -> longspan::Result<LsStreamJointLoad> {
    let (def, state, stress) = (world.joint_def(joint)?, world.joint_state(joint)?, world.joint_stress(joint)?);
    let (force, torque) = (state.force.length(), state.torque.length());
    let share = finite_or_zero((force / def.break_force).max(torque / def.break_torque)).max(finite_or_zero(stress.share));
    Ok(LsStreamJointLoad { joint: joint.to_bits(), force, torque, share, gap: state.gap })
}

pub(super) fn plane(plane: &PlaneState) -> LsStreamPlane {
    LsStreamPlane {
        chain: plane.joint.to_bits(),
        point: plane.point.to_array(),
        normal: plane.normal.to_array(),
        radius: plane.radius,
    }
}

/// `LS_STRENGTH_…`.
fn limit(limit: BreakLimit) -> i32 {
    match limit {
        BreakLimit::Tension => 0,
        BreakLimit::Compression => 1,
        BreakLimit::Shear => 2,
        BreakLimit::Bending => 3,
        BreakLimit::Torsion => 4,
    }
}

/// `LS_BREAK_…`.
fn cause(cause: BreakCause) -> i32 {
    match cause {
        BreakCause::Load => 0,
        BreakCause::Damage => 1,
        BreakCause::Applied => 2,
    }
}

pub(super) fn broken(joint: &JointBreak) -> (LsStreamEvent, LsStreamBreak) {
    let [body_a, body_b] = joint.bodies.map(|body| body.to_bits());
    let event = LsStreamEvent {
        step: joint.step,
        a: joint.joint.to_bits(),
        user_word: joint.user_word,
        kind: LS_STREAM_EVENT_BROKEN,
        values: [joint.force.length(), joint.torque.length(), 0.0, 0.0],
        ..LsStreamEvent::default()
    };
    let record = LsStreamBreak {
        step: joint.step,
        joint: joint.joint.to_bits(),
        user_word: joint.user_word,
        body_a,
        body_b,
        point: joint.point.to_array(),
        force: joint.force.to_array(),
        torque: joint.torque.to_array(),
        share: finite_or_zero(joint.share),
        limit: limit(joint.limit),
        cause: cause(joint.cause),
        reserved: 0,
    };
    (event, record)
}

pub(super) fn piece(split: &Split, piece: &Piece, user_word: u64) -> (LsStreamEvent, LsStreamPiece) {
    let (of_body, first_body) = (split.first_body.to_bits(), piece.first_body.to_bits());
    let (step, kind) = (split.step, LS_STREAM_EVENT_SPLIT);
    let event = LsStreamEvent { step, a: of_body, b: first_body, user_word, kind, ..LsStreamEvent::default() };
    let record = LsStreamPiece {
        step,
        of_body,
        first_body,
        center: piece.center.to_array(),
        linear_velocity: piece.linear_velocity.to_array(),
        angular_velocity: piece.angular_velocity.to_array(),
        mass: piece.mass,
        body_count: piece.bodies.1 - piece.bodies.0,
        anchored: piece.anchored.into(),
        cut_loose: piece.cut_loose.into(),
    };
    (event, record)
}

pub(super) fn contact(contact: &Contact) -> LsStreamContact {
    let mut points = [LsStreamContactPoint::default(); 4];
    for (to, from) in points.iter_mut().zip(contact.points()) {
        *to = LsStreamContactPoint {
            position: from.position.to_array(),
            separation: from.separation,
            normal_force: from.normal_force,
        };
    }
    LsStreamContact {
        body_a: contact.pair.body_a.to_bits(),
        body_b: contact.pair.body_b.to_bits(),
        normal: contact.normal.to_array(),
        point_count: contact.points().len() as u32,
        friction_force: contact.friction_force.to_array(),
        reserved: 0,
        points,
    }
}

pub(super) fn bound(bound: &longspan::BoundState) -> LsStreamBound {
    let kind = match bound.kind {
        BoundKind::Attachment => 0,
        BoundKind::Hierarchy => 1,
        BoundKind::Soft => 2,
        _ => u32::MAX,
    };
    LsStreamBound {
        near_joint: bound.near.to_bits(),
        far_joint: bound.far.to_bits(),
        near_point: bound.points[0].to_array(),
        far_point: bound.points[1].to_array(),
        distance: bound.distance,
        upper: bound.upper,
        lower: bound.lower,
        tension: bound.tension,
        kind,
        level: bound.level,
        active: bound.active.into(),
        reserved: 0,
    }
}
