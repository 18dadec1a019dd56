//! Scenes against their exact motion: makes the references of a scene from its bodies and joints.

use longspan::glam::{DMat3, DQuat, DVec3};
use longspan::{BodyKind, Mass, MassProperties};

use crate::metrics::MotionError;
use crate::reference::{BallTree, HungBody, Link};
use crate::scene::{DT, Scene};

/// Steps that a reference in space makes of one of the scene, and the coarser one that it is compared with: the fastest wave of a
/// light rod under a heavy load must be resolved.
const STEPS: u32 = 240;
const COARSER_STEPS: u32 = 120;

/// Mass properties of a dynamic body, which the scene computed.
fn mass_of(scene: &Scene, body: usize) -> MassProperties {
    match scene.bodies[body].mass {
        Mass::Properties(properties) => properties,
        other => unreachable!("the scene computed the mass of each body: {other:?}"),
    }
}

fn inertia_of(mass: &MassProperties) -> DMat3 {
    let axes = DMat3::from_quat(mass.inertia_frame.as_dquat().normalize());
    axes * DMat3::from_diagonal(mass.principal_inertia.as_dvec3()) * axes.transpose()
}

/// A link of a planar chain about z, of a body as long as twice `half` (m).
pub(crate) fn planar_link(scene: &Scene, body: usize, half: f32) -> Link {
    let mass = mass_of(scene, body);
    let half = f64::from(half);
    // The plane is x–y in the world; bodies lie in it with their own z axis across.
    Link { mass: f64::from(mass.mass), inertia: inertia_of(&mass).z_axis.z, to_center: half, to_bottom: half }
}

/// Compares all bodies of a scene with their exact motion; each must hang by one ball joint, its side B, from an earlier body.
pub(crate) fn judge_ball_tree(scene: &mut Scene) {
    let moving: Vec<usize> = (0..scene.bodies.len()).filter(|&body| scene.bodies[body].kind == BodyKind::Dynamic).collect();
    let index_of = |body: usize| moving.iter().position(|&moving| moving == body);
    let mut hung = Vec::with_capacity(moving.len());
    let mut start: Vec<(DQuat, DVec3, DVec3)> = Vec::with_capacity(moving.len());
    for &body in &moving {
        let held = scene.joints.iter().find(|joint| joint.b == Some(body));
        let Some((holder, joint)) = held.and_then(|joint| Some((joint.a?, joint))) else { return };
        let mass = mass_of(scene, body);
        let parent = index_of(holder);
        let on_parent = match parent {
            Some(_) => joint.def.frame_a.position - mass_of(scene, holder).center_of_mass.as_dvec3(),
            None => {
                let pose = &scene.bodies[holder].pose;
                pose.position + pose.rotation.as_dquat().normalize() * joint.def.frame_a.position
            }
        };
        let top = joint.def.frame_b.position - mass.center_of_mass.as_dvec3();
        hung.push(HungBody { parent, on_parent, top, mass: f64::from(mass.mass), inertia: inertia_of(&mass) });
        let def = &scene.bodies[body];
        start.push((def.pose.rotation.as_dquat(), def.linear_velocity.as_dvec3(), def.angular_velocity.as_dvec3()));
    }
    let tree = BallTree::new(hung, scene.world.gravity.as_dvec3(), &start);
    let motion = |mut tree: BallTree, steps: u32| {
        let mut done = 0;
        move |step: u32| {
            if step > done {
                tree.advance(f64::from(DT) * f64::from(step - done), steps * (step - done));
                done = step;
            }
            tree.centers()
        }
    };
    scene.judge(MotionError::new(moving, motion(tree.clone(), STEPS), motion(tree, COARSER_STEPS)));
}
