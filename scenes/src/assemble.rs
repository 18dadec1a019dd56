//! Bodies between two points and joints at a point of the world: what ropes, bridges and machines are put together from.

use longspan::glam::{DQuat, DVec3, Quat};
use longspan::{BodyDef, BodyId, CollisionFilter, Geometry, JointDef, JointKind, Mass, Pose, ShapeDef};

use crate::params::SceneError;
use crate::scene::{Scene, shape};

/// Touches nothing.
pub(crate) const INTANGIBLE: CollisionFilter = CollisionFilter { member_of: 1, collides_with: 0 };

/// The rotation that takes the y axis to `along`.
pub(crate) fn y_to(along: DVec3) -> Quat {
    DQuat::from_rotation_arc(DVec3::Y, along.normalize()).normalize().as_quat()
}

/// The rotation that takes the x axis, which is the axis of every joint, to `along`.
pub(crate) fn x_to(along: DVec3) -> Quat {
    DQuat::from_rotation_arc(DVec3::X, along.normalize()).normalize().as_quat()
}

/// A capsule of this radius (m) and mass (kg) whose tips are `from` and `to`, its y axis from the second to the first.
pub(crate) fn rod(from: DVec3, to: DVec3, radius: f32, mass: f32) -> Result<BodyDef, SceneError> {
    let half_height = (0.5 * from.distance(to)) as f32 - radius;
    let capsule = shape(Geometry::Capsule { half_height, radius })?;
    Ok(solid(Pose::at(0.5 * (from + to)).rotated(y_to(from - to)), capsule, mass))
}

/// A body of one shape and this mass (kg).
pub(crate) fn solid(pose: Pose, shape: ShapeDef, mass: f32) -> BodyDef {
    BodyDef::dynamic(pose).with_shape(shape).with_mass(Mass::Total(mass))
}

/// The same body, filtered so.
pub(crate) fn filtered(mut def: BodyDef, filter: CollisionFilter) -> BodyDef {
    for shape in &mut def.shapes {
        shape.filter = filter;
    }
    def
}

impl Scene {
    /// Joins two bodies as they stand, with both joint frames at this place of the world.
    pub(crate) fn join(&mut self, a: usize, b: usize, kind: JointKind, place: &Pose) -> usize {
        let mut def = JointDef::new(kind, BodyId::NULL, BodyId::NULL);
        def.frame_a = local(&self.bodies[a].pose, place);
        def.frame_b = local(&self.bodies[b].pose, place);
        self.joint(Some(a), Some(b), def)
    }

    /// Joins two bodies by a ball joint at a point of the world.
    pub(crate) fn tie(&mut self, a: usize, b: usize, point: DVec3) -> usize {
        let mut def = JointDef::new(JointKind::SPHERICAL, BodyId::NULL, BodyId::NULL);
        def.frame_a = Pose::at(local(&self.bodies[a].pose, &Pose::at(point)).position);
        def.frame_b = Pose::at(local(&self.bodies[b].pose, &Pose::at(point)).position);
        self.joint(Some(a), Some(b), def)
    }

    /// Joins two bodies by a hinge about `axis` at a point of the world.
    pub(crate) fn hinge(&mut self, a: usize, b: usize, kind: JointKind, point: DVec3, axis: DVec3) -> usize {
        self.join(a, b, kind, &Pose::at(point).rotated(x_to(axis)))
    }
}

/// `place` in the frame of `body`, carried out in `f64` so that the joint starts closed to the last bit of its own frame.
fn local(body: &Pose, place: &Pose) -> Pose {
    let back = body.rotation.as_dquat().normalize().conjugate();
    Pose { position: back * (place.position - body.position), rotation: (back * place.rotation.as_dquat()).normalize().as_quat() }
}

#[cfg(test)]
mod tests {
    use longspan::glam::Quat;
    use longspan::{BodyKind, JointKind};

    use crate::catalogue::build;
    use crate::engine::{Effort, Engine};
    use crate::longspan_engine::LongspanEngine;
    use crate::metrics::gap_of;

    /// What a scene promises of its start: bodies that move, joints, and that these are closed.
    fn check(name: &str, keys: &[(&str, &str)], moving: usize, joints: usize) {
        let given: Vec<(String, String)> = keys.iter().map(|(key, value)| ((*key).into(), (*value).into())).collect();
        let scene = build(name, &given).unwrap_or_else(|error| panic!("{name}: {error}"));
        let dynamic = scene.bodies.iter().filter(|body| body.kind == BodyKind::Dynamic).count();
        assert_eq!((dynamic, scene.joints.len()), (moving, joints), "moving bodies and joints of {name} {keys:?}");

        let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1).unwrap();
        for body in &scene.bodies {
            engine.add_body(body);
        }
        let gap = scene.joints.iter().map(|joint| gap_of(joint, &engine)).fold(0.0, f64::max);
        // Where a joint holds directions, both frames agree too.
        let turn = |side: Option<usize>| side.map_or(Quat::IDENTITY, |body| scene.bodies[body].pose.rotation);
        for joint in scene.joints.iter().filter(|joint| matches!(joint.def.kind, JointKind::Hinge { .. } | JointKind::Fixed)) {
            let [a, b] = [turn(joint.a) * joint.def.frame_a.rotation, turn(joint.b) * joint.def.frame_b.rotation];
            let off = (a.conjugate() * b).normalize().to_scaled_axis().length();
            assert!(off < 2e-6, "{name} {keys:?} starts with frames {off:e} rad apart, bound 2e-6 rad");
        }
        // Rotations and frames are stored in single precision: 6e-8 of a metre-sized lever.
        assert!(gap < 1e-6, "{name} {keys:?} starts with a gap of {gap:e} m, bound 1e-6 m");
    }

    #[test]
    fn a_loop_closer_is_one_body_and_two_joints_more() {
        for seed in ["1", "2", "3"] {
            let tree = build("branched_tree", &[("seed".into(), seed.into())]).unwrap();
            let moving = tree.bodies.len() - 1;
            assert!((130..170).contains(&moving), "{moving} bodies: 100 rods and their leaves");
            check("branched_tree", &[("seed", seed)], moving, moving);
            check("loop_graph", &[("seed", seed)], moving + 25, moving + 50);
        }
    }

    #[test]
    fn jointed_scenes_start_closed_with_the_bodies_they_promise() {
        check("rope_bridge", &[], 792, 1132);
        check("rope_bridge", &[("planks", "29"), ("walk", "on")], 7 * 29 + 8 + 1, 302);
        check("rope_bridge", &[("planks", "449")], 7 * 449 + 8, 4502);
        check("rope_bridge", &[("planks", "1799")], 7 * 1799 + 8, 18_002);
        check("cable_car", &[], 102, 101);
        check("cable_car", &[("n", "101")], 103, 102);
        check("cable_car", &[("cars", "3")], 103, 102);
        check("hinge_loop", &[], 132, 132);
        check("hinge_loop", &[("offset", "off"), ("n", "20")], 20, 20);
        check("mobile", &[], 126, 126);
        check("mobile", &[("levels", "2")], 3 * 2 + 4 * 2, 14);
        check("cantilever", &[], 31, 31);
        check("arm", &[], 7, 7);
        check("crane", &[], 22, 22);
        check("excavator", &[], 3 + 4, 3);
        check("ragdoll_pile", &[("n", "3")], 33, 30);
        check("track", &[], 132 + 2 + 5 + 1, 132 + 7);
        check("crossbow", &[], 2 * 8 + 2 * 10 + 2, 2 * 8 + 2 * 11);
        check("vase", &[], 60, 60 + 50);
        check("vase", &[("pieces", "500")], 493, 493 + 16 * 29);
        check("lifted_chain", &[], 100, 100);
        check("lifted_chain", &[("at", "100"), ("links", "mixed")], 100, 100);
        check("hanging_chain", &[("links", "mixed")], 31, 31);
        check("violent", &[], 101, 101);
        check("violent", &[("what", "mobile")], 126, 126);
    }
}
