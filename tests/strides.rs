//! What moves smoothly takes fewer substeps, and what is struck takes all of them.

use crate::common::{self, Run, scene};
use longspan::glam::{DVec3, Vec3};
use longspan::{ArticulationSettings, BodyDef, BodyKind, JointKind, Limits, Mass, World};
use longspan_scenes::{Effort, Engine, LongspanEngine, Scene};

/// Substeps in which each articulation that is swept, or solved as one with what it touches, was solved in the last step.
fn substeps_of(world: &World) -> Vec<u32> {
    world.articulations().iter().filter(|report| report.second_order == 0).map(|report| report.safe).collect()
}

/// How a machine stands: in space, so that it is swept with what it lifts, or on the ground, so that all is one problem.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stand {
    Free,
    Ground,
}

const STANDS: [Stand; 2] = [Stand::Free, Stand::Ground];

/// An excavator; the free one is on a mass that hangs in space, and its hinges have stops wide of where it goes.
fn excavator(stand: Stand, keys: &[(&str, &str)]) -> Scene {
    let mut scene = scene("excavator", keys);
    if stand == Stand::Ground {
        return scene;
    }
    let base = &mut scene.bodies[0];
    *base = BodyDef { kind: BodyKind::Dynamic, mass: Mass::Total(1.0e9), gravity_scale: 0.0, ..base.clone() };
    for joint in &mut scene.joints {
        if let JointKind::Hinge { limits, .. } = &mut joint.def.kind {
            *limits = Limits { min: -3.0, max: 3.0 };
        }
    }
    scene
}

/// That machine when it has lifted its stack for a second.
fn lifting(stand: Stand) -> (LongspanEngine, usize, f32) {
    let scene = excavator(stand, &[]);
    let mut engine = LongspanEngine::start(&scene).unwrap_or_else(|error| panic!("{error}"));
    (0..60).for_each(|_| engine.step(scene.dt));
    (engine, scene.bodies.len() - 1, scene.dt)
}

#[test]
fn a_machine_that_lifts_a_load_steadily_takes_half_the_substeps() {
    for stand in STANDS {
        let mut taken = Vec::new();
        let (mut engine, _, dt) = lifting(stand);
        for _ in 0..60 {
            engine.step(dt);
            taken.extend(substeps_of(engine.world()));
        }
        assert_eq!(taken.len(), 60, "one machine is one articulation, with the stack on its fork, {stand:?}");
        let halves = taken.iter().filter(|&&substeps| substeps == 2).count();
        assert!(halves > 50, "{stand:?}: {halves} of 60 steps took two of four substeps: {taken:?}");
    }
}

#[test]
fn what_is_struck_takes_all_substeps_until_it_is_smooth_again() {
    for stand in STANDS {
        let (mut engine, top, dt) = lifting(stand);
        assert_eq!(substeps_of(engine.world()), [2], "substeps of a machine that lifts steadily, {stand:?}");
        let struck = engine.body_id(top);
        engine.world_mut().add_impulse(struck, Vec3::X * 2.5).unwrap();
        for step in 0..5 {
            engine.step(dt);
            let taken = substeps_of(engine.world());
            assert_eq!(taken, [4], "{stand:?}: substeps of the step {step} after a box has been struck at 0.01 m/s");
        }
        (0..60).for_each(|_| engine.step(dt));
        assert_eq!(substeps_of(engine.world()), [2], "substeps a second later, {stand:?}");
    }
}

#[test]
fn an_error_target_or_few_substeps_leave_an_island_all_of_them() {
    for stand in STANDS {
        let (mut engine, _, dt) = lifting(stand);
        engine.world_mut().set_effort(2, 2).unwrap();
        (0..30).for_each(|_| engine.step(dt));
        assert_eq!(substeps_of(engine.world()), [2], "of two substeps, {stand:?}");
        engine.world_mut().set_effort(4, 2).unwrap();
        let settings = ArticulationSettings { error_target: 1e-3, ..ArticulationSettings::default() };
        engine.world_mut().set_articulation_settings(settings).unwrap();
        (0..30).for_each(|_| engine.step(dt));
        assert_eq!(substeps_of(engine.world()), [4], "with an error target, {stand:?}");
    }
}

/// Loads of the machine's joints (N) while it lifts at this effort.
fn loads(stand: Stand, substeps: u32) -> Vec<f32> {
    let scene = excavator(stand, &[]);
    let mut engine = LongspanEngine::new(&scene.world, Effort::N(substeps), 1).unwrap();
    for body in &scene.bodies {
        engine.add_body(body);
    }
    for joint in &scene.joints {
        engine.add_joint(joint);
    }
    (0..120).for_each(|_| engine.step(scene.dt));
    let load = |joint| engine.world().joint_state(engine.joint_id(joint)).unwrap().force.length();
    (0..scene.joints.len()).map(load).collect()
}

#[test]
fn forces_are_those_of_all_substeps() {
    for stand in STANDS {
        let (half, all) = (loads(stand, 4), loads(stand, 16));
        for (joint, (half, all)) in half.iter().zip(&all).enumerate() {
            let off = (half / all - 1.0).abs();
            assert!(off < 0.01, "{stand:?}: joint {joint} bears {half} N by half of 4 substeps, {all} N by 16: off by {off:.4}");
        }
    }
}

/// Positions of an excavator's bodies after three seconds, with so many boxes dropped in heaps 200 m away, created first.
fn positions_beside(stand: Stand, strangers: usize) -> Vec<DVec3> {
    let mut scene = excavator(stand, &[("seconds", "3")]);
    let mut others = common::scene("pile", &[("n", "100")]).bodies;
    others.truncate(strangers);
    others.iter_mut().for_each(|def| def.pose.position.x += 200.0);
    for end in scene.joints.iter_mut().flat_map(|joint| [&mut joint.a, &mut joint.b]) {
        *end = end.map(|body| body + strangers);
    }
    let own = scene.bodies.len();
    scene.bodies.splice(0..0, others);
    scene.metrics.clear();
    let run = Run::on_threads(scene, 1);
    (strangers..strangers + own).map(|body| run.engine.pose(body).position).collect()
}

#[test]
fn what_lies_elsewhere_changes_no_bit_of_it() {
    for stand in STANDS {
        let (alone, beside) = (positions_beside(stand, 0), positions_beside(stand, 60));
        assert_eq!(alone, beside, "{stand:?}: positions alone and beside 60 boxes that fall");
    }
}
