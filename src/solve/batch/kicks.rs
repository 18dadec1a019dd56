//! What the host's forces do to islands that may take them at once, at the start of a step.
//!
//! The host works a force out of where bodies are as the step begins, and it acts for the whole step. Spread over that, it comes half a step
//! late: with x' = x + v h + ½ a h², v' = v + a h and a = −ω² x the determinant is 1 + ½ (ω h)², so what swings or orbits gains amplitude at
//! the rate ¼ ω² h, as if damped by less than nothing, and substeps change nothing in that. An impulse a h where the body stands then,
//! v' = v + a h, x' = x + v' h, has the determinant 1 (symplectic Euler): with velocities as before, of which each step changes by exactly
//! F h, energy neither grows nor is lost, and forces in pairs keep the angular momentum about any point.
//!
//! In a step in which the host pushes a body gravity is such an impulse too: else what a force holds up against it, with no speed
//! at the end of each step, would rise by ½ g h².
//!
//! What something else holds bears loads in substeps: friction, motors and stops bear a substep's share of a step's impulse and would give way to
//! all of it, and light links under a heavy weight would be thrown across, as the stiffness that their tension gives them is not in an impulse. So an
//! impulse goes
//!
//! - to each body that touches nothing and has no joints;
//! - as one motion to all bodies of an island that touches nothing else and hangs on nothing: its forces are as good as F = M A and T = I α of a
//!   rigid body, and A h + α h × r loads neither contacts nor joints. What is left, F − m (A + α × r), is spread over the step, in the direction
//!   that it has at the mean of its substeps if it turns with the island: two magnets that roll round each other keep their angular momentum.
//!
//! Elsewhere forces are spread over the step.

use glam::{DMat3, DQuat, DVec3, Vec3};

use super::super::StepSettings;
use super::super::body_flags::BodyFlags;
use super::super::state::{BodyMotion, BodyVelocity};
use super::Batch;
use crate::settings::Solver;
use crate::speed_limits::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED};

/// What is known of an island.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct IslandNote {
    /// Whether any of it touches what does not move by itself, and whether any touches anything.
    pub is_held: bool,
    touches: bool,
    /// Whether the host pushes any of it.
    is_pushed: bool,
    /// Whether it has joints, and any that are left to sweeps, which carry velocities from one step to the next in their own way.
    has_joints: bool,
    is_swept: bool,
}

impl Batch {
    /// Notes of each island what it touches.
    pub(super) fn note_contacts(&mut self) {
        let Self { islands, notes, manifolds, body_flags, .. } = self;
        notes.clear();
        notes.resize(islands.len(), IslandNote::default());
        for ends in &manifolds.ends {
            let [a, b] = [ends.a, ends.b].map(|slot| body_flags[slot as usize].moves());
            if a || b {
                let slot = if a { ends.a } else { ends.b };
                let note = &mut notes[islands.partition_point(|&first| first <= slot) - 1];
                note.touches = true;
                note.is_held |= a != b;
            }
        }
    }

    /// Gives islands that the host pushes the impulses of their forces, where they may take them at once; `center` is the place of a body (m), and
    /// `is_swept` says whose joints are left to sweeps.
    pub(crate) fn kick_what_is_pushed(
        &mut self,
        settings: &StepSettings,
        solver: Solver,
        center: impl Fn(u32) -> DVec3,
        is_swept: impl Fn(u32) -> bool,
    ) {
        let end = self.moving() + 1;
        if !self.body_flags[1..end].iter().any(|flags| flags.is_pushed()) {
            return;
        }
        self.note_contacts();
        let Self { bodies, islands, notes, velocities, motions, body_flags, joints, .. } = self;
        let island_of = |slot: u32| islands.partition_point(|&first| first <= slot) - 1;
        for link in &joints.links {
            let moves = [link.a, link.b].map(|slot| body_flags[slot as usize].moves());
            let is_world = solver == Solver::GaussSeidel && link.traits.solver != Solver::Direct;
            for (slot, _) in [link.a, link.b].into_iter().zip(moves).filter(|&(_, moves)| moves) {
                let note = &mut notes[island_of(slot)];
                note.is_held |= moves != [true; 2];
                note.has_joints = true;
                note.is_swept |= is_world || is_swept(bodies[slot as usize]);
            }
        }
        for (slot, flags) in body_flags[..end].iter().enumerate().skip(1).filter(|(_, flags)| flags.is_pushed()) {
            debug_assert!(flags.moves());
            notes[island_of(slot as u32)].is_pushed = true;
        }
        for (number, note) in notes.iter().enumerate().filter(|(_, note)| note.is_pushed) {
            let next = islands.get(number + 1).map_or(end, |&next| next as usize);
            let slots = islands[number] as usize..next;
            let (velocities, motions) = (&mut velocities[slots.clone()], &mut motions[slots.clone()]);
            if !note.touches && !note.has_joints {
                velocities.iter_mut().zip(motions).for_each(|(velocity, motion)| kick(velocity, motion, settings));
            } else if !note.is_held && !note.is_swept && body_flags[slots.clone()].iter().all(|flags| flags.is_unlocked()) {
                kick_together(velocities, motions, |place| center(bodies[slots.start + place]), settings);
                body_flags[slots].iter_mut().for_each(BodyFlags::kick);
            }
        }
    }
}

/// Whether its forces can be told; what they tear to infinity is taken out after the step.
fn is_bounded(motion: &BodyMotion) -> bool {
    motion.acceleration.is_finite() && motion.torque.is_finite()
}

/// Gives a body at once what its forces and damping change of its velocities in all substeps of a step.
fn kick(velocity: &mut BodyVelocity, motion: &mut BodyMotion, settings: &StepSettings) {
    if !is_bounded(motion) {
        return;
    }
    let h = settings.dt / settings.substeps as f32;
    let free = velocity.inverse_mass.cmpgt(Vec3::ZERO);
    let push = Vec3::select(free, motion.acceleration * h, Vec3::ZERO);
    let turning = velocity.inverse_inertia.mul(motion.torque) * h;
    for _ in 0..settings.substeps {
        velocity.linear = (velocity.linear + push) / (1.0 + h * motion.linear_damping);
        velocity.angular = (velocity.angular + turning) / (1.0 + h * motion.angular_damping);
    }
    velocity.linear = velocity.linear.clamp_length_max(MAX_LINEAR_SPEED);
    velocity.angular = velocity.angular.clamp_length_max(MAX_ANGULAR_SPEED);
    (motion.acceleration, motion.torque) = (Vec3::ZERO, Vec3::ZERO);
    (motion.linear_damping, motion.angular_damping) = (0.0, 0.0);
}

/// Sums over the bodies of an island that moves as one.
struct Whole {
    mass: f64,
    /// Centre of mass from the first body (m), and momentum (N·s).
    center: DVec3,
    momentum: DVec3,
    force: DVec3,
    /// About the centre of mass: angular momentum, torque and inertia.
    spin: DVec3,
    torque: DVec3,
    inertia: DMat3,
}

impl Whole {
    const NONE: Self = Self {
        mass: 0.0,
        center: DVec3::ZERO,
        momentum: DVec3::ZERO,
        force: DVec3::ZERO,
        spin: DVec3::ZERO,
        torque: DVec3::ZERO,
        inertia: DMat3::ZERO,
    };
}

/// Gives an island at once what its forces would give it in a step were it rigid, and leaves the rest of them.
fn kick_together(
    velocities: &mut [BodyVelocity],
    motions: &mut [BodyMotion],
    center: impl Fn(usize) -> DVec3,
    settings: &StepSettings,
) {
    let is_damped = |motion: &BodyMotion| motion.linear_damping != 0.0 || motion.angular_damping != 0.0;
    if motions.iter().any(|motion| is_damped(motion) || !is_bounded(motion)) {
        return;
    }
    let origin = center(0);
    let place = |number: usize| center(number) - origin;
    let mut whole = Whole::NONE;
    for (number, (velocity, motion)) in velocities.iter().zip(&*motions).enumerate() {
        let mass = 1.0 / f64::from(velocity.inverse_mass.x);
        whole.mass += mass;
        whole.center += place(number) * mass;
        whole.momentum += velocity.linear.as_dvec3() * mass;
        whole.force += motion.acceleration.as_dvec3() * mass;
    }
    whole.center /= whole.mass;
    let (mean, pull) = (whole.momentum / whole.mass, whole.force / whole.mass);
    let inertia_of = |motion: &BodyMotion| {
        let axes = DMat3::from_quat((motion.rotation * motion.inertia_frame).as_dquat().normalize());
        axes * DMat3::from_diagonal(motion.inertia.as_dvec3()) * axes.transpose()
    };
    for (number, (velocity, motion)) in velocities.iter().zip(&*motions).enumerate() {
        let (mass, arm, own) = (1.0 / f64::from(velocity.inverse_mass.x), place(number) - whole.center, inertia_of(motion));
        whole.inertia += own + (DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer(arm)) * mass;
        whole.spin += own * velocity.angular.as_dvec3() + arm.cross(velocity.linear.as_dvec3() - mean) * mass;
        whole.torque += motion.torque.as_dvec3() + arm.cross(motion.acceleration.as_dvec3() - pull) * mass;
    }
    let ease = whole.inertia.inverse();
    let (turning, gained) = (ease * whole.spin, ease * whole.torque);
    if !turning.is_finite() || !gained.is_finite() {
        return;
    }
    let time = f64::from(settings.dt);
    // Contacts press at the places from which substeps set out.
    let mean = 0.5 * time * f64::from(settings.substeps - 1) / f64::from(settings.substeps);
    let half_way = DQuat::from_scaled_axis((turning + gained * time) * mean);
    for (number, (velocity, motion)) in velocities.iter_mut().zip(motions).enumerate() {
        let as_one = pull + gained.cross(place(number) - whole.center);
        let torque = motion.torque.as_dvec3() - inertia_of(motion) * gained;
        velocity.linear = (velocity.linear + (as_one * time).as_vec3()).clamp_length_max(MAX_LINEAR_SPEED);
        velocity.angular = (velocity.angular + (gained * time).as_vec3()).clamp_length_max(MAX_ANGULAR_SPEED);
        motion.acceleration = (half_way * (motion.acceleration.as_dvec3() - as_one)).as_vec3();
        motion.torque = (half_way * torque).as_vec3();
    }
}

/// v vᵀ.
fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}
