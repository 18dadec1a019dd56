//! Keeps hinge chains in their plane (Müller et al. 2017, §3.4): velocities first, then positions.
//!
//! **Plane.** Where an end is fixed, it gives the plane. Otherwise the plane is the one that the members reach with the least work: with
//! x_i the centre of mass moved back along its own axis a_i by its height, r_i = x_i − x̄ (weighed by mass) and I_i the mean inertia
//! across the axis, its normal n minimises
//!
//! ```text
//! Σ m_i (r_i·n)² + I_i (1 − (a_i·n)²) = nᵀ A n + const,      A = Σ m_i r_i r_iᵀ − I_i a_i a_iᵀ,
//! ```
//!
//! the eigenvector of the smallest eigenvalue. The second term is what tells the plane of a straight chain, where all r_i are in one
//! line. At the minimum moving all members into the plane turns the whole by nothing, to first order.
//!
//! **Velocities** before bodies move in the last substep of a step: a motion within the plane, and one rigid motion of all. Each
//! member keeps what it does within the plane, v_i − n (n·v_i) and n (n·ω_i); the rest is replaced by the rigid motion that
//! restores both momenta,
//!
//! ```text
//! v_i' = v_i − n (n·v_i) + n V + Ω × r_i,    ω_i' = n (n·ω_i) + Ω,    V = Σ m_i n·v_i / M,    Ω = J⁻¹ (L − L'),
//! ```
//!
//! J being the inertia of all as one body, L' the angular momentum without Ω. With a fixed plane the rigid motion is that of its anchor.
//!
//! **Positions** after they have moved: members turn until a_i = n, and shift along n. Velocities do not hear of it, but for the
//! rigid motion that keeps the angular momentum.

use glam::{DMat3, DQuat, DVec3, Vec3};

use super::momentum::{Inertia, Moments, Whole, times};
use super::state::{BodyMotion, BodyVelocity};
use super::wide_bodies::WideBodies;
use crate::linalg::eigen::symmetric_eigen;
use crate::linalg::rotation32;

/// Distance from the plane below which nothing is done, over the chain's mean lever.
const FLAT: f64 = 3.0e-4;

/// Angle from the normal below which nothing is done (rad).
const ALIGNED: f64 = 3.0e-4;

/// Share of either by which fitted velocities must move a member otherwise in a substep for it to get them.
const NOTICED_SHARE: f64 = 0.1;

/// Most that a member turns at once (rad).
const MAX_TURN: f64 = 0.5;

/// Sine up to which three terms of asin s / s leave nothing but rounding of `f32`, 5/112 s⁶ < 5e-14.
const SMALL_SINE: f64 = 1.0e-2;

/// A member of a chain in its batch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlaneMember {
    pub slot: u32,
    /// Normal in the body's axes.
    pub axis: Vec3,
    pub height: f32,
    /// Where displacements count from, from there for the first member (m).
    pub origin: DVec3,
    /// Mass (kg), and mean inertia about directions across the axis (kg·m²).
    pub mass: f64,
    pub across: f64,
}

impl PlaneMember {
    /// Mass, and mean inertia across `axis`, of a body.
    pub(crate) fn weigh(velocity: &BodyVelocity, motion: &BodyMotion, axis: Vec3) -> (f64, f64) {
        let mass = 1.0 / f64::from(velocity.inverse_mass.max_element());
        let along = (motion.inertia_frame.conjugate() * axis).as_dvec3();
        let inertia = motion.inertia.as_dvec3();
        (mass, 0.5 * (inertia.element_sum() - inertia.dot(along * along)))
    }

    /// The member's axis, and its centre of mass moved back by its height.
    fn stand(&self, motion: &BodyMotion) -> MemberPose {
        let axis = (motion.rotation * self.axis).as_dvec3();
        MemberPose { axis, foot: self.origin + motion.displacement.as_dvec3() - axis * f64::from(self.height) }
    }
}

/// Where a member is.
#[derive(Debug, Clone, Copy)]
struct MemberPose {
    axis: DVec3,
    foot: DVec3,
}

/// What fixes a plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlaneHold {
    pub slot: u32,
    /// As for members.
    pub origin: DVec3,
    /// Joint point from there, and normal, in the body's axes.
    pub lever: Vec3,
    pub axis: Vec3,
    /// The joint point over the plane (m).
    pub height: f32,
}

/// A chain in its batch; its members are a range of all.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlaneEntry {
    pub members: (u32, u32),
    pub hold: Option<PlaneHold>,
    pub size: f32,
}

/// All chains of a batch.
#[derive(Debug, Default)]
pub(crate) struct Planes {
    /// Hinge chains, by number in the world's list.
    pub chains: Vec<u32>,
    pub entries: Vec<PlaneEntry>,
    pub members: Vec<PlaneMember>,
    /// Whether the position part and the axis part act.
    pub parts: (bool, bool),
    /// Chains that were put back into their plane in this step.
    pub corrected: u32,
    stands: Vec<MemberPose>,
    states: Vec<MemberState>,
    /// Velocities before they are fitted.
    old: Vec<(DVec3, DVec3)>,
}

/// A member as it is, in `f64`.
#[derive(Debug, Clone, Copy)]
struct MemberState {
    mass: f64,
    /// xx, yy, zz, xy, xz, yz (kg·m²).
    inertia: [f64; 6],
    center: DVec3,
    axis: DVec3,
    linear: DVec3,
    angular: DVec3,
    height: f64,
}

impl MemberState {
    fn of(member: &PlaneMember, velocity: &BodyVelocity, motion: &BodyMotion, poses: &WideBodies) -> Self {
        Self {
            mass: member.mass,
            inertia: poses.inertia_of(member.slot, motion),
            center: member.origin + motion.displacement.as_dvec3(),
            axis: (motion.rotation * member.axis).as_dvec3(),
            linear: velocity.linear.as_dvec3(),
            angular: velocity.angular.as_dvec3(),
            height: f64::from(member.height),
        }
    }

    fn stand(&self) -> MemberPose {
        MemberPose { axis: self.axis, foot: self.center - self.axis * self.height }
    }
}

/// Upper half of x xᵀ: xx, yy, zz, xy, xz, yz.
fn squares(x: DVec3) -> [f64; 6] {
    [x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.x * x.z, x.y * x.z]
}

/// Sums over the members of a chain that say how it lies.
#[derive(Debug, Default)]
struct Lay {
    mass: f64,
    /// Σ m x of the feet, and Σ m x xᵀ − I a aᵀ with their axes.
    feet: DVec3,
    spread: [f64; 6],
    /// Σ m a.
    axes: DVec3,
}

impl Lay {
    fn add(&mut self, member: &PlaneMember, stand: &MemberPose) {
        let &PlaneMember { mass, across, .. } = member;
        self.mass += mass;
        self.feet += stand.foot * mass;
        self.axes += stand.axis * mass;
        for (sum, (foot, axis)) in self.spread.iter_mut().zip(squares(stand.foot).into_iter().zip(squares(stand.axis))) {
            *sum += foot * mass - axis * across;
        }
    }

    /// The plane that is reached with the least work.
    fn plane(&self) -> Option<MotionPlane> {
        let point = self.feet / self.mass;
        let shift = squares(point);
        let [xx, yy, zz, xy, xz, yz] = std::array::from_fn(|i| self.spread[i] - self.mass * shift[i]);
        let (values, vectors) = symmetric_eigen(DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]));
        let normal = if values.x <= values.y && values.x <= values.z {
            vectors.x_axis
        } else if values.y <= values.z {
            vectors.y_axis
        } else {
            vectors.z_axis
        };
        let sign = self.axes.dot(normal);
        (normal.is_finite() && sign != 0.0).then(|| MotionPlane { point, normal: normal * sign.signum(), driven: None })
    }
}

/// Sums over the members of a chain that say how it moves.
#[derive(Debug, Default)]
struct Sums {
    whole: Whole,
    moments: Moments,
}

impl Sums {
    fn of(states: &[MemberState]) -> Self {
        let mut sums = Self::default();
        for state in states {
            sums.whole.add(state.mass, state.center, state.linear, times(&state.inertia, state.angular));
            sums.moments.add(state.mass, state.center, &state.inertia);
        }
        sums
    }

    /// Inertia of all as one.
    fn inertia(&self) -> Inertia {
        self.moments.about(&self.whole)
    }
}

/// A plane, and the rigid motion of what fixes it.
struct MotionPlane {
    point: DVec3,
    normal: DVec3,
    driven: Option<AnchorVelocity>,
}

/// Velocity of a point of the anchor, and its angular velocity.
struct AnchorVelocity {
    point: DVec3,
    linear: DVec3,
    angular: DVec3,
}

/// Gives the members an angular momentum again that they had, as one rotation of all.
fn restore_spin(states: &mut [MemberState], spin: DVec3, inertia: &Inertia) {
    let mut now = Whole::default();
    for state in states.iter() {
        now.add(state.mass, state.center, state.linear, times(&state.inertia, state.angular));
    }
    let (center, turn) = (now.center(), inertia.rate_of(spin - now.spin()));
    for state in states {
        state.linear += turn.cross(state.center - center);
        state.angular += turn;
    }
}

impl Planes {
    pub(crate) fn clear(&mut self) {
        self.chains.clear();
        self.entries.clear();
        self.members.clear();
        self.corrected = 0;
    }

    /// Makes velocities those of chains that stay flat; `poses` hold the inertia of now.
    pub(crate) fn fit_velocities(&mut self, velocities: &mut [BodyVelocity], motions: &[BodyMotion], poses: &WideBodies, h: f32) {
        let Self { entries, members, states, old, parts, .. } = self;
        for entry in entries.iter() {
            let members = members_of(members, entry);
            load(states, members, velocities, motions, poses);
            let mut lay = Lay::default();
            members.iter().zip(&*states).for_each(|(member, state)| lay.add(member, &state.stand()));
            let Some(plane) = plane_of(entry, &lay, velocities, motions) else { continue };
            let (normal, sums) = (plane.normal, Sums::of(states));
            let drift = normal.dot(sums.whole.linear()) / sums.whole.mass();
            old.clear();
            old.extend(states.iter().map(|state| (state.linear, state.angular)));
            for state in states.iter_mut() {
                if parts.0 {
                    state.linear += normal * (drift - normal.dot(state.linear));
                }
                if parts.1 {
                    state.angular = normal * normal.dot(state.angular);
                }
            }
            match &plane.driven {
                None => restore_spin(states, sums.whole.spin(), &sums.inertia()),
                Some(driven) => {
                    for state in states.iter_mut() {
                        let carried = driven.linear + driven.angular.cross(state.center - driven.point);
                        if parts.0 {
                            state.linear += normal * (normal.dot(carried) - drift);
                        }
                        if parts.1 {
                            state.angular += driven.angular - normal * normal.dot(driven.angular);
                        }
                    }
                }
            }
            let change = |(state, old): (&MemberState, &(DVec3, DVec3))| {
                let across = (state.angular - old.1) - normal * normal.dot(state.angular - old.1);
                (normal.dot(state.linear - old.0).abs() * f64::from(h) > NOTICED_SHARE * FLAT * f64::from(entry.size))
                    || across.length() * f64::from(h) > NOTICED_SHARE * ALIGNED
            };
            if states.iter().zip(&*old).any(change) {
                store_velocities(states, members, velocities);
            }
        }
    }

    /// Puts members back into their plane; what that does to the angular momentum is taken back.
    pub(crate) fn project(&mut self, velocities: &mut [BodyVelocity], motions: &mut [BodyMotion], poses: &mut WideBodies) {
        let Self { entries, members, stands, states, parts, corrected, .. } = self;
        for entry in entries.iter() {
            let members = members_of(members, entry);
            let mut lay = Lay::default();
            stands.clear();
            for member in members {
                let stand = member.stand(&motions[member.slot as usize]);
                lay.add(member, &stand);
                stands.push(stand);
            }
            let Some(plane) = plane_of(entry, &lay, velocities, motions) else { continue };
            let distance = |stand: &MemberPose| (stand.foot - plane.point).dot(plane.normal).abs();
            let angle = |stand: &MemberPose| stand.axis.cross(plane.normal).length();
            let off = parts.0 && stands.iter().any(|stand| distance(stand) > FLAT * f64::from(entry.size));
            let askew = parts.1 && stands.iter().any(|stand| angle(stand) > ALIGNED);
            if !off && !askew {
                continue;
            }
            poses.find_inertia(motions);
            load(states, members, velocities, motions, poses);
            let sums = Sums::of(states);
            *corrected += 1;
            // Where the plane is free, its height is where the feet are once all axes are aligned.
            let level = |state: &MemberState| {
                let axis = if parts.1 { plane.normal } else { state.axis };
                (state.center - axis * state.height - plane.point).dot(plane.normal)
            };
            let mean = states.iter().map(|state| level(state) * state.mass).sum::<f64>() / sums.whole.mass();
            let free_mean = if plane.driven.is_none() { mean } else { 0.0 };
            let mut moments = Moments::default();
            for (member, state) in members.iter().zip(states.iter_mut()) {
                let motion = &mut motions[member.slot as usize];
                let shift = if parts.0 { plane.normal * (free_mean - level(state)) } else { DVec3::ZERO };
                let turn = if parts.1 { turn_onto(state.axis, plane.normal) } else { DVec3::ZERO };
                motion.displacement += shift.as_vec3();
                motion.turn += turn.as_vec3();
                motion.rotation = rotation32::rotated(motion.rotation, turn.as_vec3());
                poses.refresh_inertia_of(member.slot, motion);
                state.center = member.origin + motion.displacement.as_dvec3();
                state.inertia = poses.inertia_of(member.slot, motion);
                moments.add(state.mass, state.center, &state.inertia);
            }
            if plane.driven.is_none() {
                // What moves into the plane leaves the common centre where it is.
                restore_spin(states, sums.whole.spin(), &moments.about(&sums.whole));
                store_velocities(states, members, velocities);
            }
        }
    }
}

fn members_of<'a>(members: &'a [PlaneMember], entry: &PlaneEntry) -> &'a [PlaneMember] {
    &members[entry.members.0 as usize..entry.members.1 as usize]
}

fn load(
    states: &mut Vec<MemberState>,
    members: &[PlaneMember],
    velocities: &[BodyVelocity],
    motions: &[BodyMotion],
    poses: &WideBodies,
) {
    let state =
        |member: &PlaneMember| MemberState::of(member, &velocities[member.slot as usize], &motions[member.slot as usize], poses);
    states.clear();
    states.extend(members.iter().map(state));
}

fn store_velocities(states: &[MemberState], members: &[PlaneMember], velocities: &mut [BodyVelocity]) {
    for (state, member) in states.iter().zip(members) {
        let velocity = &mut velocities[member.slot as usize];
        velocity.linear = state.linear.as_vec3();
        velocity.angular = state.angular.as_vec3();
    }
}

/// Rotation vector that takes one unit vector onto another.
fn turn_onto(from: DVec3, to: DVec3) -> DVec3 {
    let across = from.cross(to);
    let sine = across.length();
    if sine < 1.0e-12 {
        return DVec3::ZERO;
    }
    let cosine = from.dot(to);
    if sine < SMALL_SINE && cosine > 0.0 {
        let x = sine * sine;
        return across * (1.0 + x / 6.0 * (1.0 + x * 9.0 / 20.0));
    }
    across * (libm::atan2(sine, cosine).min(MAX_TURN) / sine)
}

fn plane_of(entry: &PlaneEntry, lay: &Lay, velocities: &[BodyVelocity], motions: &[BodyMotion]) -> Option<MotionPlane> {
    if let Some(hold) = &entry.hold {
        let (velocity, motion) = (&velocities[hold.slot as usize], &motions[hold.slot as usize]);
        let rotation: DQuat = motion.rotation.as_dquat().normalize();
        let (normal, arm) = (rotation * hold.axis.as_dvec3(), rotation * hold.lever.as_dvec3());
        let center = hold.origin + motion.displacement.as_dvec3();
        let driven = AnchorVelocity { point: center, linear: velocity.linear.as_dvec3(), angular: velocity.angular.as_dvec3() };
        return Some(MotionPlane { point: center + arm - normal * f64::from(hold.height), normal, driven: Some(driven) });
    }
    lay.plane()
}
