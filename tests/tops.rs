//! Tops that spin on a floor keep their tilt, their spin and their energy, at any rate of steps and of any size.

use longspan::glam::{DQuat, DVec3, Quat, Vec3};
use longspan::{BodyDef, BodyId, Geometry, LocalPose, Material, Pose, Shape, ShapeDef, SleepSettings, Solver, World, WorldDef};

const GRAVITY: f64 = 9.81;

/// Tilt that tops begin with (rad).
const TILT: f64 = 0.2;

fn world(solver: Solver) -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { solver, sleep, ..WorldDef::default() }).expect("a valid world")
}

fn shape(geometry: Geometry, local_pose: LocalPose, friction: f32) -> ShapeDef {
    let material = Material { friction, ..Material::default() };
    ShapeDef { local_pose, material, ..ShapeDef::new(Shape::new(geometry).expect("a valid shape")) }
}

fn floor(friction: f32) -> ShapeDef {
    shape(Geometry::Box { half_extents: Vec3::new(50.0, 1.0, 50.0) }, LocalPose::at(Vec3::NEG_Y), friction)
}

/// What a top stands on.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Tip {
    /// The end of a capsule.
    Round,
    /// The tip of a cone.
    Sharp,
}

#[derive(Debug, Clone, Copy)]
struct Top {
    /// Over a disc of 3 cm on a pin of 4.8 cm.
    size: f32,
    tip: Tip,
    friction: f32,
    /// About its axis (rad/s).
    spin: f64,
    rate: f32,
    solver: Solver,
}

/// What is known of a top in motion.
#[derive(Debug, Clone, Copy)]
struct State {
    /// From the vertical (rad).
    tilt: f64,
    /// About its axis (rad/s).
    spin: f64,
    /// J.
    energy: f64,
}

impl Top {
    fn make(&self) -> (World, BodyId) {
        let mut world = world(self.solver);
        let of = |geometry: Geometry, pose: LocalPose| shape(geometry, pose, self.friction);
        world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor(self.friction))).expect("a valid floor");
        let s = self.size;
        let disc = of(Geometry::Cylinder { half_height: 0.006 * s, radius: 0.03 * s }, LocalPose::at(Vec3::Y * 0.03 * s));
        let at = Vec3::Y * 0.024 * s;
        let pin = match self.tip {
            Tip::Round => of(Geometry::Capsule { half_height: 0.02 * s, radius: 0.004 * s }, LocalPose::at(at)),
            Tip::Sharp => {
                let rotation = Quat::from_rotation_z(std::f32::consts::PI);
                of(Geometry::Cone { half_height: 0.024 * s, radius: 0.006 * s }, LocalPose { position: at, rotation })
            }
        };
        let rotation = DQuat::from_rotation_z(-TILT);
        let cap = if self.tip == Tip::Round { f64::from(0.004 * s) } else { 0.0 };
        let pose = Pose { position: DVec3::Y * cap - rotation * (DVec3::Y * cap), rotation: rotation.as_quat() };
        let angular_velocity = (rotation * DVec3::Y * self.spin).as_vec3();
        let def = BodyDef { angular_velocity, ..BodyDef::dynamic(pose).with_shape(disc).with_shape(pin) };
        let top = world.create_body(&def).expect("a valid top");
        (world, top)
    }

    /// At the start, and after each step of so many seconds.
    fn run(&self, seconds: f32) -> Vec<State> {
        let (mut world, top) = self.make();
        let mut states = vec![State::of(&world, top)];
        for _ in 0..(seconds * self.rate) as usize {
            world.step(1.0 / self.rate).expect("a valid step");
            states.push(State::of(&world, top));
        }
        states
    }
}

impl State {
    fn of(world: &World, top: BodyId) -> Self {
        let mass = world.mass_properties(top).expect("it stays").expect("it is dynamic");
        let (pose, center) = (world.pose(top).expect("it stays"), world.center_of_mass(top).expect("it stays"));
        let (linear, angular) = (world.linear_velocity(top).expect("it stays"), world.angular_velocity(top).expect("it stays"));
        let axes = (pose.rotation * mass.inertia_frame).as_dquat().normalize();
        let own = axes.conjugate() * angular.as_dvec3();
        let moving = f64::from(mass.mass) * (0.5 * linear.as_dvec3().length_squared() + GRAVITY * center.y);
        let axis = pose.rotation.as_dquat() * DVec3::Y;
        Self {
            tilt: axis.y.clamp(-1.0, 1.0).acos(),
            spin: axis.dot(angular.as_dvec3()),
            energy: moving + 0.5 * own.dot(mass.principal_inertia.as_dvec3() * own),
        }
    }
}

const RATES: &[f32] = &[60.0, 120.0, 240.0];

/// Rate at which runs have converged (Hz), and for how long tops are run there (s): they nod 20 times.
const FINE: f32 = 1920.0;
const NODS: f32 = 1.0;

/// Tops of 3 mm, 3 cm and 30 cm of this friction on round and on sharp tips, by two solvers, each with the greatest tilt that it comes to (rad).
fn tops(friction: f32) -> impl Iterator<Item = (Top, f64)> {
    let sizes = [(0.1, 200.0, &RATES[2..]), (1.0, 100.0, RATES), (10.0, 100.0, RATES)];
    let of_size = move |(size, spin, rates): (f32, f64, &'static [f32])| {
        let kinds = [Tip::Round, Tip::Sharp].map(|tip| [Solver::Auto, Solver::GaussSeidel].map(|solver| (tip, solver)));
        kinds.into_iter().flatten().flat_map(move |(tip, solver)| {
            let top = Top { size, tip, friction, spin, rate: FINE, solver };
            let greatest = top.run(NODS).iter().map(|state| state.tilt).fold(0.0, f64::max);
            rates.iter().map(move |&rate| (Top { rate, ..top }, greatest))
        })
    };
    sizes.into_iter().flat_map(of_size)
}

/// Without friction nothing turns a top about its axis or takes energy from it, and it nods between two tilts for ever.
#[test]
fn tops_without_friction_keep_their_tilt_spin_and_energy() {
    for (top, greatest) in tops(0.0) {
        let states = top.run(4.0);
        let start = states[0];
        for state in &states {
            assert!((state.energy / start.energy - 1.0).abs() < 0.01, "{top:?}: {state:?}, from {start:?}");
            assert!((state.spin / start.spin - 1.0).abs() < 2.0e-3, "{top:?}: {state:?}, from {start:?}");
            let is_between = (TILT - 0.02..greatest + 0.02).contains(&state.tilt);
            assert!(is_between, "{top:?}: {state:?}, from {TILT} to {greatest} rad at {FINE} Hz");
        }
    }
}

/// With friction a top comes to roll on its tip, or rises by what it loses as it slides, and gains nothing.
#[test]
fn tops_with_friction_gain_no_energy_and_stand() {
    for (top, greatest) in tops(0.3) {
        let mut least = f64::INFINITY;
        // The least of them nods further in seconds.
        let may_rise = if top.size < 1.0 { 0.25 } else { 0.02 };
        for state in top.run(4.0) {
            least = least.min(state.energy);
            assert!(state.energy < 1.01 * least, "{top:?}: {state:?}, after {least} J");
            assert!(state.tilt < greatest + may_rise, "{top:?}: {state:?}, up to {greatest} rad at {FINE} Hz");
        }
    }
}

/// A rod that lies on a floor without friction and spins about its length goes on, also where it turns about the vertical.
#[test]
fn rods_keep_their_spin_on_a_floor_without_friction() {
    for geometry in
        [Geometry::Capsule { half_height: 0.0875, radius: 0.0035 }, Geometry::Cylinder { half_height: 0.0875, radius: 0.0035 }]
    {
        for (solver, rate) in [(Solver::Auto, 60.0), (Solver::GaussSeidel, 60.0), (Solver::Auto, 240.0)] {
            let mut world = world(solver);
            world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor(0.0))).expect("a valid floor");
            let rotation = Quat::from_rotation_y(0.7) * Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
            let pose = Pose { position: DVec3::Y * 0.0035, rotation };
            let angular_velocity = rotation * Vec3::Y * 100.0 + Vec3::Y * 0.5;
            let rod = shape(geometry.clone(), LocalPose::IDENTITY, 0.0);
            let def = BodyDef { angular_velocity, ..BodyDef::dynamic(pose).with_shape(rod) };
            let rod = world.create_body(&def).expect("a valid rod");
            for _ in 0..(4.0 * rate) as usize {
                world.step(1.0 / rate).expect("a valid step");
            }
            let spin = State::of(&world, rod).spin;
            assert!((spin - 100.0).abs() < 3.0, "{geometry:?} {solver:?} at {rate} Hz: {spin} of 100 rad/s");
        }
    }
}
