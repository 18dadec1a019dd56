//! Mechanisms some of whose joints repeat others move as if these were not there.
//!
//! All are turned so that nothing lies along an axis of the world: what repeats does so but for rounding and gaps.

use crate::common::Run;
use longspan::glam::{DMat4, DQuat, DVec3, EulerRot, Vec3};
use longspan::{
    BodyDef, BodyId, JointDef, JointId, JointKind, Limits, Mass, Motor, Pose, Shape, ShapeDef, SleepSettings, Solver, World,
    WorldDef,
};
use longspan_scenes::Random;

const DT: f32 = 1.0 / 60.0;
const SECONDS: f32 = 6.0;
const MASS: f32 = 4.0;
const GRAVITY: f64 = 9.81;

fn turned() -> DQuat {
    DQuat::from_euler(EulerRot::XYZ, 0.4, 0.9, 0.3)
}

fn world() -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    let gravity = (turned() * DVec3::NEG_Y * GRAVITY).as_vec3();
    World::new(&WorldDef { gravity, sleep, ..WorldDef::default() }).expect("a valid world")
}

fn part(world: &mut World, at: DVec3, turn: DQuat, half: Vec3) -> BodyId {
    let mut shape = ShapeDef::new(Shape::cuboid(half).expect("a valid shape"));
    shape.filter.collides_with = 0;
    let pose = Pose::at(turned() * at).rotated((turned() * turn).as_quat());
    world.create_body(&BodyDef::dynamic(pose).with_shape(shape).with_mass(Mass::Total(MASS))).expect("a valid body")
}

fn join(world: &mut World, kind: JointKind, a: BodyId, b: BodyId, at: DVec3, axis: DVec3) -> JointId {
    let turn = DQuat::from_rotation_arc(DVec3::X, (turned() * axis).normalize());
    let seen_by = |body: BodyId| {
        let pose = if body == BodyId::NULL { Pose::IDENTITY } else { world.pose(body).expect("bodies stay") };
        let back = pose.rotation.as_dquat().normalize().inverse();
        Pose::at(back * (turned() * at - pose.position)).rotated((back * turn).as_quat())
    };
    let mut def = JointDef::new(kind, a, b);
    (def.frame_a, def.frame_b) = (seen_by(a), seen_by(b));
    world.create_joint(&def).expect("a valid joint")
}

/// Where a body is after each step, in the axes of the mechanism.
fn path(world: &mut World, body: BodyId) -> Vec<DVec3> {
    let steps = (SECONDS / DT) as usize;
    let after_step = |_| {
        world.step(DT).expect("a valid step");
        turned().inverse() * world.pose(body).expect("bodies stay").position
    };
    (0..steps).map(after_step).collect()
}

/// A door of 4 kg, 1 m wide, on a post that leans, held at these heights.
fn hang_door(world: &mut World, kind: JointKind, heights: &[f64]) -> (BodyId, Vec<JointId>) {
    let door = part(world, DVec3::X * 0.5, DQuat::IDENTITY, Vec3::new(0.5, 1.0, 0.02));
    let post = DVec3::new(0.2, 1.0, 0.3).normalize();
    let joints = heights.iter().map(|&height| join(world, kind, BodyId::NULL, door, post * height, post)).collect();
    (door, joints)
}

/// The path of such a door, and the greatest force that holds it at the end.
fn door(kind: JointKind, heights: &[f64]) -> (Vec<DVec3>, f32) {
    let mut world = world();
    let (door, joints) = hang_door(&mut world, kind, heights);
    let path = path(&mut world, door);
    let force = |&joint: &JointId| world.joint_state(joint).expect("joints stay").force.length();
    let force = joints.iter().map(force).fold(0.0, f32::max);
    (path, force)
}

#[test]
fn a_door_swings_on_many_hinges_or_points_as_on_one_hinge() {
    let (one, _) = door(JointKind::HINGE, &[0.0]);
    for (kind, name) in [(JointKind::HINGE, "hinges"), (JointKind::SPHERICAL, "points")] {
        for heights in [&[-0.9, 0.8][..], &[-0.9, 0.1, 0.8], &[-0.9, -0.37, 0.0, 0.41, 0.8]] {
            let (path, force) = door(kind, heights);
            let apart = one.iter().zip(&path).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            let count = heights.len();
            println!("{count} {name}: {apart} m apart, {force} N");
            assert!(apart < 5e-3, "on {count} {name} it is {apart} m from its path on one hinge, bound 5e-3 m");
            // Of what they push against each other alone; the door weighs 39 N.
            assert!(force < 5e3, "{count} {name} bear up to {force} N, bound 5e3 N");
        }
    }
}

#[test]
fn the_hinges_of_a_door_share_what_holds_it() {
    for heights in [&[-0.9, 0.8][..], &[-0.9, 0.1, 0.8], &[-0.9, -0.37, 0.0, 0.41, 0.8]] {
        let (mut world, count) = (world(), heights.len());
        let (door, hinges) = hang_door(&mut world, JointKind::HINGE, heights);
        let velocity = |world: &World| world.linear_velocity(door).expect("bodies stay").as_dvec3();
        let (mut off, mut most) = (0.0_f64, 0.0_f64);
        for _ in 0..(SECONDS / DT) as usize {
            let before = velocity(&world);
            world.step(DT).expect("a valid step");
            let acceleration = (velocity(&world) - before) / f64::from(DT) - turned() * DVec3::NEG_Y * GRAVITY;
            let needed = f64::from(MASS) * acceleration;
            let forces: Vec<DVec3> =
                hinges.iter().map(|&hinge| world.joint_state(hinge).expect("joints stay").force.as_dvec3()).collect();
            off = off.max((forces.iter().sum::<DVec3>() - needed).length() / needed.length());
            most = most.max(forces.iter().map(|force| force.length()).fold(0.0, f64::max) / needed.length());
        }
        assert!(off < 0.01, "the forces of {count} hinges are off by {off} of m (a − g) together, bound 0.01");
        assert!(most < 2.0, "one of {count} hinges bears {most} times m (a − g), bound 2");
    }
}

/// A ring of bars between these hinges, the last of which hang from the world; centres and principal moments of inertia of the bars.
struct Ring {
    world: World,
    bars: Vec<(BodyId, DVec3)>,
}

impl Ring {
    /// Each hinge has a point and an axis.
    fn of(hinges: &[(DVec3, DVec3)]) -> Self {
        Self::with(hinges, &[])
    }

    /// Hinges with these numbers hold points instead.
    fn with(hinges: &[(DVec3, DVec3)], points: &[usize]) -> Self {
        let mut world = world();
        let bar = |pair: &[(DVec3, DVec3)]| {
            let (from, to) = (pair[0].0, pair[1].0);
            let half = DVec3::new(0.5 * from.distance(to), 0.04, 0.02);
            let turn = DQuat::from_rotation_arc(DVec3::X, (to - from).normalize());
            let squares = half * half * f64::from(MASS) / 3.0;
            (part(&mut world, from.midpoint(to), turn, half.as_vec3()), DVec3::splat(squares.element_sum()) - squares)
        };
        let bars: Vec<(BodyId, DVec3)> = hinges.windows(2).map(bar).collect();
        for (number, &(at, axis)) in hinges.iter().enumerate() {
            let body = |number: usize| bars.get(number).map_or(BodyId::NULL, |bar| bar.0);
            let kind = if points.contains(&number) { JointKind::SPHERICAL } else { JointKind::HINGE };
            join(&mut world, kind, body(number.wrapping_sub(1)), body(number), at, axis);
        }
        Self { world, bars }
    }

    /// Kinetic energy, and that of height (J).
    fn energies(&self) -> (f64, f64) {
        let of_bar = |&(bar, inertia): &(BodyId, DVec3)| {
            let pose = self.world.pose(bar).expect("bodies stay");
            let linear = self.world.linear_velocity(bar).expect("bodies stay").as_dvec3();
            let angular =
                pose.rotation.as_dquat().conjugate() * self.world.angular_velocity(bar).expect("bodies stay").as_dvec3();
            let kinetic = 0.5 * (f64::from(MASS) * linear.length_squared() + angular.dot(inertia * angular));
            (kinetic, f64::from(MASS) * GRAVITY * (turned().conjugate() * pose.position).y)
        };
        self.bars.iter().map(of_bar).fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
    }

    /// Lets it swing for so long (s): what it gains at most and what it has lost in the end, over its greatest kinetic energy.
    fn swing(mut self, seconds: f32) -> (f64, f64) {
        let start = self.energies().1;
        let (mut gained, mut most, mut last) = (0.0_f64, 0.0_f64, 0.0);
        for _ in 0..(seconds / DT) as usize {
            self.world.step(DT).expect("a valid step");
            let (kinetic, height) = self.energies();
            last = kinetic + height - start;
            (gained, most) = (gained.max(last), most.max(kinetic));
        }
        (gained / most, -last / most)
    }

    #[track_caller]
    fn swings_as_it_must(self, what: &str) {
        let (gained, lost) = self.swing(SECONDS);
        assert!(gained < 5e-3, "{what} gains {gained} of the energy that it swings with, bound 5e-3");
        assert!(lost < 0.06, "{what} loses {lost} of the energy that it swings with in {SECONDS} s, bound 0.06");
    }
}

/// Four hinges of which opposite bars have equal lengths and twists, a/sin α = b/sin β (Bennett 1903): it moves, though a count of its
/// freedoms says that it is held twice over.
fn bennett() -> Vec<(DVec3, DVec3)> {
    let (twists, length) = ([0.6_f64, 1.1], 0.5);
    let lengths = [length, length * twists[1].sin() / twists[0].sin()];
    let [sum, difference] = [twists[1] + twists[0], twists[1] - twists[0]].map(|angle| (0.5 * angle).sin());
    let first = 1.2_f64;
    let second = 2.0 * (sum / difference / (0.5 * first).tan()).atan();
    let mut place = DMat4::from_quat(DQuat::from_euler(EulerRot::XYZ, 1.4, 0.3, 0.2));
    let hinge = |(number, angle): (usize, f64)| {
        let found = (place.transform_point3(DVec3::ZERO), place.transform_vector3(DVec3::Z));
        let (length, twist) = (lengths[number % 2], twists[number % 2]);
        place *= DMat4::from_rotation_z(angle) * DMat4::from_translation(DVec3::X * length) * DMat4::from_rotation_x(twist);
        found
    };
    [first, second, -first, -second].into_iter().enumerate().map(hinge).collect()
}

/// Hinges a metre from a point in which their axes meet.
fn spherical(axes: &[DVec3]) -> Vec<(DVec3, DVec3)> {
    axes.iter().map(|axis| (axis.normalize(), axis.normalize())).collect()
}

#[test]
fn four_hinges_whose_axes_meet_gain_no_energy() {
    let askew = [(1.0, 0.2, 0.0), (0.6, -0.1, 0.7), (-0.3, 0.3, 0.9), (-0.8, 0.1, -0.3)];
    let square = [(1.0, 0.0, 0.0), (0.7, 0.0, 0.7), (0.0, 0.0, 1.0), (0.0, 0.7, 0.7)];
    for axes in [askew, square] {
        Ring::of(&spherical(&axes.map(DVec3::from))).swings_as_it_must("four hinges whose axes meet");
    }
}

#[test]
fn a_linkage_of_bennett_swings_on() {
    Ring::of(&bennett()).swings_as_it_must("Bennett's linkage");
}

/// Numbers between −½ and ½ (Knuth's MMIX).
fn noise(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}

#[test]
fn a_smooth_substep_that_gains_energy_is_taken_back() {
    let mut next = noise(17108834293985579236);
    let axes: Vec<DVec3> = (0..7).map(|_| DVec3::new(next(), next(), next())).collect();
    let (gained, _) = Ring::with(&spherical(&axes), &[1]).swing(10.0);
    assert!(gained < 5e-3, "seven joints gain {gained} of the energy that they swing with, bound 5e-3");
}

#[test]
fn random_loops_of_hinges_whose_axes_meet_gain_no_energy() {
    let mut next = noise(5);
    for count in [4, 4, 4, 5, 5, 6, 6] {
        let axes: Vec<DVec3> = (0..count).map(|_| DVec3::new(next(), next(), next())).collect();
        Ring::of(&spherical(&axes)).swings_as_it_must(&format!("a loop of {count} hinges"));
    }
}

#[test]
fn a_platform_swings_back_on_six_bars_as_on_two() {
    for spots in [&[-0.9, 0.9][..], &[-0.9, -0.53, -0.2, 0.11, 0.47, 0.9]] {
        let mut world = world();
        let platform = part(&mut world, DVec3::new(0.6, -0.8, 0.0), DQuat::IDENTITY, Vec3::new(1.0, 0.05, 0.3));
        for &x in spots {
            let slant = DQuat::from_rotation_z(0.6_f64.atan2(0.8));
            let bar = part(&mut world, DVec3::new(x + 0.3, -0.4, 0.0), slant, Vec3::new(0.02, 0.5, 0.02));
            join(&mut world, JointKind::HINGE, BodyId::NULL, bar, DVec3::X * x, DVec3::Z);
            join(&mut world, JointKind::HINGE, bar, platform, DVec3::new(x + 0.6, -0.8, 0.0), DVec3::Z);
        }
        // Past its first swing: how high it comes again.
        let back = path(&mut world, platform)[200..].iter().map(|at| at.y).fold(f64::NEG_INFINITY, f64::max);
        assert!((back + 0.8).abs() < 2e-3, "on {} bars it swings back to {back} m, from −0.8 m, bound 2e-3 m", spots.len());
    }
}

#[test]
fn a_loop_of_six_hinges_keeps_its_momentum() {
    let run = Run::of("hinge_loop", &[("n", "6")]);
    run.keeps("lin_momentum_err_pct", 4e-4, "%");
    run.keeps("ang_momentum_err_pct", 6e-3, "%");
    Run::of("hinge_loop", &[("n", "40")]).keeps("ang_momentum_err_pct", 1e-3, "%");
}

/// A light and a heavy body on three or four joints to the world and to each other, whose frames lie up to 3 m off in any direction.
fn contradiction(solver: Solver, ratio: f32, seed: u64) -> (World, [BodyId; 2]) {
    let mut random = Random::new(seed);
    let mut world = World::new(&WorldDef { solver, ..WorldDef::default() }).expect("a valid world");
    let bodies = [(0.0, 0.113), (2.0, 0.113 * ratio)].map(|(x, mass)| {
        let mut shape = ShapeDef::new(Shape::cuboid(Vec3::splat(0.5)).expect("a valid shape"));
        shape.filter.collides_with = 0;
        let def = BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)).with_shape(shape).with_mass(Mass::Total(mass));
        world.create_body(&def).expect("a valid body")
    });
    for number in 0..3 + random.index(2) {
        let kinds = [
            JointKind::Fixed,
            JointKind::HINGE,
            JointKind::SPHERICAL,
            JointKind::Prismatic { limits: Limits::NONE, motor: Motor::Off },
        ];
        let ends = [[BodyId::NULL, bodies[0]], [BodyId::NULL, bodies[1]], bodies][number % 3];
        let mut frame = || Pose { position: random.vector(3.0).as_dvec3(), rotation: random.rotation() };
        let (frame_a, frame_b) = (frame(), frame());
        let def = JointDef { frame_a, frame_b, ..JointDef::new(kinds[random.index(4)], ends[0], ends[1]) };
        world.create_joint(&def).expect("a valid joint");
    }
    (world, bodies)
}

#[test]
fn joints_that_contradict_each_other_fling_nothing_about() {
    // Whatever moves has fallen: a light body between joints that cannot be held goes no faster than what it hangs between, from which it has
    // its energy. The heavy one falls for three seconds at most, to 29 m/s; a point at the end of a lever of 5 m is faster than its body's middle.
    const BOUND: f32 = 36.0;
    for solver in [Solver::Auto, Solver::GaussSeidel] {
        for (rate, ratio) in [(60, 7540.0), (30, 0.1), (30, 1000.0), (240, 1.0e5)] {
            for seed in 0..16 {
                let (mut world, bodies) = contradiction(solver, ratio, seed);
                let mut fastest: f32 = 0.0;
                for _ in 0..3 * rate {
                    world.step(1.0 / rate as f32).expect("a valid step");
                    fastest = bodies
                        .iter()
                        .map(|&body| world.linear_velocity(body).expect("bodies stay").length())
                        .fold(fastest, f32::max);
                }
                let what = format!("{solver:?}, {rate} Hz, ratio {ratio}, seed {seed}");
                assert!(fastest < BOUND, "{what}: {fastest} m/s, bound {BOUND} m/s");
            }
        }
    }
}
