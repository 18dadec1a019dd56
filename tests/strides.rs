//! What moves smoothly takes fewer substeps, and what is struck takes all of them.

mod common;

use common::{Run, scene};
use longspan::glam::{DVec3, Vec3};
use longspan::{ArticulationSettings, BodyDef, BodyKind, JointKind, Limits, Mass, World};
use longspan_scenes::{Effort, Engine, LongspanEngine, Scene};

/// Substeps in which each swept articulation was solved in the last step.
fn substeps_of(world: &World) -> Vec<u32> {
    world.articulations().iter().filter(|report| report.swept).map(|report| report.safe).collect()
}

/// An excavator on a mass that hangs in space, whose hinges have stops wide of where it goes: a free machine, swept with what it lifts.
fn excavator(keys: &[(&str, &str)]) -> Scene {
    let mut scene = scene("excavator", keys);
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
fn lifting() -> (LongspanEngine, usize, f32) {
    let scene = excavator(&[]);
    let mut engine = LongspanEngine::start(&scene).unwrap_or_else(|error| panic!("{error}"));
    (0..60).for_each(|_| engine.step(scene.dt));
    (engine, scene.bodies.len() - 1, scene.dt)
}

#[test]
fn a_machine_that_lifts_a_load_steadily_takes_half_the_substeps() {
    let mut taken = Vec::new();
    let (mut engine, _, dt) = lifting();
    for _ in 0..60 {
        engine.step(dt);
        taken.extend(substeps_of(engine.world()));
    }
    assert_eq!(taken.len(), 60, "one machine is one articulation, swept with the stack on its fork");
    let halves = taken.iter().filter(|&&substeps| substeps == 2).count();
    assert!(halves > 50, "{halves} of 60 steps took two of four substeps: {taken:?}");
}

#[test]
fn what_is_struck_takes_all_substeps_until_it_is_smooth_again() {
    let (mut engine, top, dt) = lifting();
    assert_eq!(substeps_of(engine.world()), [2], "substeps of a machine that lifts steadily");
    let struck = engine.body_id(top);
    engine.world_mut().add_impulse(struck, Vec3::X * 2.5).unwrap();
    for step in 0..5 {
        engine.step(dt);
        assert_eq!(substeps_of(engine.world()), [4], "substeps of the step {step} after a box has been struck at 0.01 m/s");
    }
    (0..60).for_each(|_| engine.step(dt));
    assert_eq!(substeps_of(engine.world()), [2], "substeps a second later");
}

#[test]
fn an_error_target_or_few_substeps_leave_an_island_all_of_them() {
    let (mut engine, _, dt) = lifting();
    engine.world_mut().set_effort(2, 2).unwrap();
    (0..30).for_each(|_| engine.step(dt));
    assert_eq!(substeps_of(engine.world()), [2], "of two substeps");
    engine.world_mut().set_effort(4, 2).unwrap();
    let settings = ArticulationSettings { error_target: 1e-3, ..ArticulationSettings::default() };
    engine.world_mut().set_articulation_settings(settings).unwrap();
    (0..30).for_each(|_| engine.step(dt));
    assert_eq!(substeps_of(engine.world()), [4], "with an error target");
}

/// Loads of the machine's joints (N) while it lifts at this effort.
fn loads(substeps: u32) -> Vec<f32> {
    let scene = excavator(&[]);
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
    let (half, all) = (loads(4), loads(16));
    for (joint, (half, all)) in half.iter().zip(&all).enumerate() {
        let off = (half / all - 1.0).abs();
        assert!(off < 0.01, "joint {joint} bears {half} N by half of 4 substeps, {all} N by 16: off by {off:.4}, bound 0.01");
    }
}

/// Positions of an excavator's bodies after three seconds, with so many boxes dropped in heaps 200 m away, created first.
fn positions_beside(strangers: usize) -> Vec<DVec3> {
    let mut scene = excavator(&[("seconds", "3")]);
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
    assert_eq!(positions_beside(0), positions_beside(60), "positions alone and beside 60 boxes that fall");
}
