//! Hinge chains keep their plane, whatever the effort (Müller et al. 2017, §3.4).

use crate::common::Run;
use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, BodyKind, JointDef, JointKind, Pose, Shape, ShapeDef, Solver, World, WorldDef};

const DT: f32 = 1.0 / 60.0;

/// The effort of the paper's figure, and the default one.
const EFFORTS: [&[(&str, &str)]; 3] =
    [&[("solver", "gs")], &[("solver", "gs"), ("substeps", "1"), ("iterations", "5")], &[("substeps", "1"), ("iterations", "5")]];

fn keeps_flat(keys: &[(&str, &str)]) {
    let run = Run::of("hinge_loop", keys);
    run.keeps("plane_rms_m", 1e-4, "m");
    run.keeps("axis_rms_deg", 0.05, "°");
    run.keeps("lin_momentum_err_pct", 1e-3, "%");
    run.keeps("ang_momentum_err_pct", 0.2, "%");
}

#[test]
fn a_struck_loop_with_offsets_stays_flat_at_five_iterations() {
    EFFORTS.into_iter().for_each(keeps_flat);
}

#[test]
fn a_struck_loop_without_offsets_stays_flat() {
    for effort in EFFORTS {
        keeps_flat(&[effort, &[("offset", "off")]].concat());
    }
}

#[test]
fn each_part_does_what_the_figure_shows() {
    let effort = [("solver", "gs"), ("substeps", "1"), ("iterations", "5")];
    let with = |keys: &[(&str, &str)]| {
        let run = Run::of("hinge_loop", &[&effort[..], keys].concat());
        (run.error("plane_rms_m"), run.error("axis_rms_deg"))
    };
    let (both, none) = (with(&[]), with(&[("plane_axis", "off"), ("plane_position", "off")]));
    assert!(both.0 < 1e-4 && both.1 < 0.05, "with both parts: {both:?}");
    assert!(none.0 > 0.1, "without either it is floppy: {none:?}");
    // With its axes free the loop crumples, and how far depends on the last bit of the blow: the middle one of five tells.
    let mut position = ["49", "49.9", "50", "50.1", "51"].map(|impulse| with(&[("plane_axis", "off"), ("impulse", impulse)]));
    position.sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
    assert!(position[2].0 < 1e-3, "without the axis part it stays planar: {position:?}");
    let least = position.iter().map(|run| run.1).fold(f64::INFINITY, f64::min);
    assert!(least > 10.0 * both.1, "without the axis part axes are off: {position:?}");
}

/// A run of links along x, hinges along z; the first hangs on `holder` if there is one.
fn run_of(world: &mut World, holder: Option<BodyId>, count: usize) -> Vec<BodyId> {
    let about_z = Quat::from_rotation_arc(Vec3::X, Vec3::Z);
    let mut links = Vec::new();
    let mut before = holder;
    for i in 0..count {
        let mut shape = ShapeDef::new(Shape::cuboid(Vec3::new(0.08, 0.02, 0.05)).unwrap());
        shape.filter.collides_with = 0;
        let pose = Pose::at_xyz(0.1 + 0.2 * i as f64, 0.0, 0.0);
        let link = world.create_body(&BodyDef::dynamic(pose).with_shape(shape)).unwrap();
        if let Some(before) = before {
            let on_before = if Some(before) == holder { Vec3::ZERO } else { Vec3::X * 0.1 };
            let mut hinge = JointDef::new(JointKind::HINGE, before, link).at(on_before, Vec3::X * -0.1);
            (hinge.frame_a.rotation, hinge.frame_b.rotation) = (about_z, about_z);
            world.create_joint(&hinge).unwrap();
        }
        before = Some(link);
        links.push(link);
    }
    links
}

fn gauss_seidel(gravity: Vec3) -> World {
    World::new(&WorldDef { gravity, solver: Solver::GaussSeidel, substeps: 1, iterations: 5, ..WorldDef::default() }).unwrap()
}

#[test]
fn an_end_made_kinematic_holds_and_turns_the_plane() {
    let mut world = gauss_seidel(Vec3::Y * -9.81);
    let holder = world.create_body(&BodyDef { kind: BodyKind::Kinematic, ..BodyDef::default() }).unwrap();
    let links = run_of(&mut world, Some(holder), 30);
    let mut turned = 0.0_f64;
    for step in 0..240 {
        if step >= 60 {
            turned += 0.01;
            world.move_to(holder, Pose::IDENTITY.rotated(Quat::from_rotation_y(turned as f32))).unwrap();
        }
        if step == 30 || step == 120 {
            world.add_impulse(links[20], Vec3::Z * 3.0).unwrap();
        }
        world.step(DT).unwrap();
        let normal = DVec3::new(turned.sin(), 0.0, turned.cos());
        for &link in &links {
            let pose = world.pose(link).unwrap();
            let off = pose.position.dot(normal).abs();
            let askew = (pose.rotation * Vec3::Z).as_dvec3().cross(normal).length();
            assert!(off < 1e-4, "step {step}: a link lies {off} m off the plane");
            assert!(askew < 1e-3, "step {step}: a link's hinge is {askew} rad off");
        }
    }
}

#[test]
fn a_straight_chain_has_a_plane_and_other_joints_keep_what_they_hold() {
    let mut world = gauss_seidel(Vec3::ZERO);
    let links = run_of(&mut world, None, 12);
    // A body on a ball joint beside the chain, and a crossbar on a hinge the other way: a chain of its own.
    let shape = ShapeDef::new(Shape::cuboid(Vec3::splat(0.05)).unwrap());
    let pendant = world.create_body(&BodyDef::dynamic(Pose::at_xyz(1.1, -0.2, 0.0)).with_shape(shape.clone())).unwrap();
    let ball =
        world.create_joint(&JointDef::new(JointKind::SPHERICAL, links[5], pendant).at(Vec3::Y * -0.1, Vec3::Y * 0.1)).unwrap();
    let bar = world.create_body(&BodyDef::dynamic(Pose::at_xyz(0.3, 0.2, 0.0)).with_shape(shape)).unwrap();
    let hinge = world.create_joint(&JointDef::new(JointKind::HINGE, links[1], bar).at(Vec3::Y * 0.1, Vec3::Y * -0.1)).unwrap();
    world.add_impulse(links[0], Vec3::new(0.0, 0.5, 1.0)).unwrap();
    world.add_impulse(pendant, Vec3::new(0.3, 0.0, -0.4)).unwrap();
    let momentum = |world: &World| -> DVec3 {
        let all = links.iter().chain([&pendant, &bar]);
        all.map(|&body| {
            let kilograms = world.mass_properties(body).unwrap().unwrap().mass;
            world.linear_velocity(body).unwrap().as_dvec3() * f64::from(kilograms)
        })
        .sum()
    };
    let start = momentum(&world);
    for _ in 0..300 {
        world.step(DT).unwrap();
    }
    let axes: Vec<DVec3> = links.iter().map(|&link| (world.pose(link).unwrap().rotation * Vec3::Z).as_dvec3()).collect();
    let worst = axes.iter().map(|axis| axis.cross(axes[0]).length()).fold(0.0, f64::max);
    assert!(worst < 2e-3, "axes of the chain are up to {worst} rad apart");
    for joint in [ball, hinge] {
        let gap = world.joint_state(joint).unwrap().gap;
        assert!(gap < 5e-3, "a joint beside the chain gapes by {gap} m");
    }
    let lost = (momentum(&world) - start).length();
    assert!(lost < 1e-5 * start.length(), "{lost} kg·m/s of {} lost", start.length());
    assert!(world.report().counts.planes >= 1);
}

#[test]
fn a_loop_left_alone_does_not_start_to_move() {
    for solver in ["auto", "gs"] {
        let run = Run::of("hinge_loop", &[("solver", solver), ("impulse", "0"), ("seconds", "60")]);
        run.keeps("plane_rms_m", 1e-5, "m");
        run.keeps("drift_m", 1e-5, "m");
    }
}

#[test]
fn a_chain_says_which_plane_it_is_kept_in() {
    let mut world = World::new(&WorldDef::default()).unwrap();
    let holder = world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, 0.0, 0.0))).unwrap();
    let links = run_of(&mut world, Some(holder), 6);
    assert_eq!(world.planes().count(), 0, "chains are found by a step");
    for _ in 0..60 {
        world.step(DT).unwrap();
    }
    let planes: Vec<_> = world.planes().collect();
    let [plane] = planes[..] else { panic!("one chain: {planes:?}") };
    assert_eq!((plane.members, plane.anchored), (6, true));
    assert!(plane.normal.cross(Vec3::Z).length() < 1e-5, "its hinges turn about z: {plane:?}");
    assert!(plane.point.z.abs() < 1e-6 && plane.deviation < 1e-4, "{plane:?}");
    let farthest = links.iter().map(|&link| world.center_of_mass(link).unwrap().distance(plane.point)).fold(0.0, f64::max);
    assert!((f64::from(plane.radius) - farthest).abs() < 1e-6, "{} m, and the farthest link is {farthest} m away", plane.radius);
    world.destroy_body(links[3]).unwrap();
    assert_eq!(world.planes().count(), 0, "a chain that has lost a member has no plane");
    world.step(DT).unwrap();
    assert!(world.planes().all(|plane| plane.members == 3), "three links are left on the holder");
}
