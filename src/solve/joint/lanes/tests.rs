//! All registers give the same bits, and lanes the rows of joints that are swept one by one.

use glam::{DQuat, DVec3, Quat, Vec3};
use proptest::prelude::*;

use super::*;
use crate::id::{BodyId, JointId, Pool, WorldTag};
use crate::joint::JointDef;
use crate::joint_record::Joint;
use crate::platform::with_baseline;
use crate::solve::body_flags::BodyFlags;
use crate::solve::color::Coloring;
use crate::solve::joint::singles::Singles;
use crate::solve::joint::{BatchJoints, JointLink, MovingBodies};
use crate::solve::state::{MotionKind, Symmetric};
use crate::workers::Workers;

const H: f32 = 1.0 / 240.0;

/// Joints of which none shares a body, so that one order of visits is as good as another.
#[derive(Debug, Clone)]
struct Scene {
    entries: Vec<JointEntry>,
    defs: Vec<JointDef>,
    velocities: Vec<BodyVelocity>,
    motions: Vec<BodyMotion>,
}

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from_array)
}

fn body() -> impl Strategy<Value = (BodyVelocity, BodyMotion)> {
    (vector(3.0), vector(5.0), vector(0.01), vector(2.0), 0.1..10.0_f32, 0.3..3.0_f32).prop_map(
        |(linear, angular, displacement, turned, mass, girth)| {
            let rotation = Quat::from_scaled_axis(turned);
            let inertia = Vec3::new(1.0, girth, 1.2) * mass * 0.1;
            let inverse = crate::shape::inertia_tensor(1.0 / inertia, rotation);
            let at_rest = BodyVelocity::new(Vec3::splat(1.0 / mass), Symmetric::from_mat3(inverse));
            let velocity = BodyVelocity { linear, angular, ..at_rest };
            let kind = MotionKind::Tumbling;
            (velocity, BodyMotion { displacement, rotation, inertia, kind, jointed: true, ..BodyMotion::FIXED })
        },
    )
}

type Given = ((BodyVelocity, BodyMotion), (BodyVelocity, BodyMotion), Vec3, Vec3, Vec3, bool, f32);

fn joints(holds: Holds) -> impl Strategy<Value = Scene> {
    let joint = (body(), body(), vector(0.5), vector(1.0e-3), vector(2.0), any::<bool>(), 0.0..1.0_f32);
    prop::collection::vec(joint, 1..20).prop_map(move |joints| scene(holds, joints))
}

/// Bodies that are in their joints but for a millimetre and some milliradians.
fn scene(holds: Holds, joints: Vec<Given>) -> Scene {
    let (mut velocities, mut motions) = (vec![BodyVelocity::FIXED], vec![BodyMotion::FIXED]);
    let (mut entries, mut defs) = (Vec::new(), Vec::new());
    for (number, (a, b, lever, error, impulse, on_world, give)) in joints.into_iter().enumerate() {
        let mut enlist = |(velocity, motion)| {
            velocities.push(velocity);
            motions.push(motion);
            velocities.len() as u32 - 1
        };
        let stands = [if on_world { BodyMotion::FIXED } else { a.1 }, b.1].map(|motion| motion.stance());
        let slots = [if on_world { 0 } else { enlist(a) }, enlist(b)];
        let levers = [
            if on_world { DVec3::ZERO } else { lever.as_dvec3() },
            DVec3::new(f64::from(lever.y), f64::from(lever.z), f64::from(lever.x)),
        ];
        let turned = DQuat::from_scaled_axis(error.as_dvec3());
        let frames = [DQuat::IDENTITY, (stands[1].1.conjugate() * stands[0].1 * turned).normalize()];
        let [at_a, at_b]: [DVec3; 2] = std::array::from_fn(|i| stands[i].0 + stands[i].1 * levers[i]);
        let kind = match holds {
            Holds::Points => JointKind::SPHERICAL,
            Holds::Axis => JointKind::HINGE,
            Holds::Frame => JointKind::Fixed,
        };
        let softness = Softness { compliance: if give > 0.5 { give * 1.0e-5 } else { 0.0 }, damping: give };
        defs.push(JointDef { linear: softness, angular: softness, ..JointDef::new(kind, BodyId::NULL, BodyId::NULL) });
        entries.push(JointEntry {
            joint: number as u32,
            a: slots[0],
            b: slots[1],
            offset: error.as_dvec3() - (at_b - at_a),
            local_lever: levers,
            local_frame: frames,
            impulses: JointImpulses { point: impulse, angular: impulse * 0.1, ..JointImpulses::ZERO },
            ..JointEntry::NONE
        });
    }
    Scene { entries, defs, velocities, motions }
}

fn holds() -> impl Strategy<Value = Holds> {
    prop_oneof![Just(Holds::Points), Just(Holds::Axis), Just(Holds::Frame)]
}

fn predicted_poses(scene: &Scene) -> Vec<PredictedPose> {
    scene.velocities.iter().zip(&scene.motions).map(|(velocity, motion)| PredictedPose::of(velocity, motion, H)).collect()
}

/// Everything that a substep's kernels leave behind, as bits.
fn run(holds: Holds, scene: &Scene) -> Vec<u32> {
    let mut lanes = JointLanes::default();
    let joints = scene.entries.iter().zip(&scene.defs).enumerate();
    lanes.add(joints.map(|(number, (entry, def))| (number as u32, entry, [def.linear, def.angular])), holds, H);
    let Scene { mut velocities, mut motions, .. } = scene.clone();
    let blocks = lanes.len();
    begin_all(&mut lanes, &motions);
    prepare_all(&mut lanes, &velocities, &predicted_poses(scene), H);
    warm_start_all(&lanes, &mut velocities);
    sweep_range(&mut lanes, 0, blocks, &mut velocities, false);
    sweep_range(&mut lanes, 0, blocks, &mut velocities, true);
    project_range(&lanes, 0, blocks, &mut velocities, &mut motions, 0.04);
    let mut worst = 0.0;
    worst_gap_of(&lanes, &motions, &mut worst);
    let bodies = velocities.iter().flat_map(|body| body.halves()).chain(motions.iter().flat_map(BodyMotion::halves));
    let rows = lanes.points.iter().flat_map(|block| block.impulse.iter().chain(&block.mass).chain(&block.bias));
    let turns = lanes.directions.iter().flat_map(|block| block.impulse.iter().chain(&block.mass).chain(&block.bias));
    bodies.flatten().chain(rows.chain(turns).flatten()).chain([&worst]).map(|x| x.to_bits()).collect()
}

proptest! {
    #[test]
    fn all_registers_give_the_same_bits(
        (holds, scene) in holds().prop_flat_map(|holds| (Just(holds), joints(holds))),
    ) {
        prop_assert_eq!(run(holds, &scene), with_baseline(|| run(holds, &scene)));
    }
}

fn link_of(entry: &JointEntry) -> JointLink {
    let &JointEntry { joint, a, b, traits, .. } = entry;
    JointLink { joint, a, b, traits, is_withheld: false }
}

/// Velocities and poses after a substep: warm start, a sweep to, a sweep fro, position rows.
fn ends(scene: &Scene, in_lanes: bool) -> (Vec<BodyVelocity>, Vec<BodyMotion>) {
    let tag = WorldTag::acquire().expect("few worlds are alive");
    let mut pool: Pool<Joint, JointId> = Pool::new(&tag);
    for def in &scene.defs {
        pool.insert(Joint::new(*def, [None, None])).expect("the pool has room");
    }
    let Scene { mut velocities, mut motions, entries, .. } = scene.clone();
    if in_lanes {
        let links = entries.iter().map(link_of).collect();
        let (mut joints, alone) = (BatchJoints { links, entries, ..BatchJoints::default() }, Workers::default());
        let body_flags: Vec<BodyFlags> =
            velocities.iter().zip(&motions).map(|(velocity, motion)| BodyFlags::of(velocity, motion)).collect();
        joints.lay_out((&pool, None), &alone, &mut Coloring::default(), (&velocities, &motions, &body_flags), H, 1);
        let moving = MovingBodies { velocities: &velocities, motions: &motions, predicted_poses: &predicted_poses(scene) };
        joints.prepare(&pool, &alone, &moving, H, false);
        joints.warm_start(&alone, &mut velocities);
        joints.sweep(&alone, &mut velocities, false);
        joints.sweep(&alone, &mut velocities, true);
        joints.project(&pool, &alone, &mut velocities, &mut motions, H);
    } else {
        let all = 0..entries.len();
        let mut singles = Singles::default();
        singles.add(&Vec::from_iter(0..entries.len() as u32));
        let moving = MovingBodies { velocities: &velocities, motions: &motions, predicted_poses: &predicted_poses(scene) };
        singles.prepare(&entries, &pool, &moving, (H, H), false);
        singles.warm_start(&mut velocities);
        singles.sweep(all.clone(), &mut velocities, false);
        singles.sweep(all.clone(), &mut velocities, true);
        singles.project(all, &entries, &pool, (&mut velocities, &mut motions), H, 0.0);
    }
    (velocities, motions)
}

proptest! {
    #[test]
    fn lanes_do_what_joints_do_that_are_swept_one_by_one(
        scene in holds().prop_flat_map(joints),
    ) {
        let ((velocities, motions), (singly, places)) = (ends(&scene, true), ends(&scene, false));
        for (own, other) in velocities.iter().zip(&singly) {
            let (linear, angular) = ((own.linear - other.linear).length(), (own.angular - other.angular).length());
            // Rounding, times the ratio of the inertias; and the square of what a substep turns a lever by.
            prop_assert!(linear < 2.0e-3 && angular < 1.0e-2, "velocities differ by {linear} m/s and {angular} rad/s");
        }
        for (own, other) in motions.iter().zip(&places) {
            let (way, turn) = ((own.displacement - other.displacement).length(), 2.0 * (own.rotation - other.rotation).length());
            prop_assert!(way < 1.0e-5 && turn < 1.0e-4, "poses differ by {way} m and {turn} rad");
        }
    }
}
