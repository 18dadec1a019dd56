//! Articulations whose joints all hold points together and do nothing else: chains, nets, rope bridges.
//!
//! Their system is that of [`super::system`], but its rows need not be written down. Of joint k between bodies a and b, with levers
//! r from centres of mass to the point at which it pushes them, J = [−1, r_a×, 1, −r_b×], so that
//!
//! ```text
//! J v           = v_b + ω_b × r_b − v_a − ω_a × r_a,
//! M̃⁻¹ Jᵀ p      = ±(p/m, Ĩ⁻¹ (r × p)),
//! J_k M̃⁻¹ J_lᵀ = ±(1/m + [r_k]ᵀ Ĩ⁻¹ [r_l])   over each body that both hold, + where it is on the same side of both.
//! ```
//!
//! Nothing has a bound, so that one pass of one factor solves it.

use glam::{DMat3, DVec3};

use super::block::{Block3, Lanes, ZERO, add_scaled, block3, block3_mut};
use super::body::DirectBody;
use super::factor::{BlockFactor, POINT};
use super::redundancy::Redundancy;
use super::refine::{Equations, refine};
use super::row::MAX_IMPULSE;
use super::self_stress::SelfStresses;
use super::topology::Topology;
use crate::platform::dispatched;
use crate::solve::joint::JointEntry;
use crate::solve::joint::LocalPose;
use crate::solve::joint::rows::Rate;
use crate::tuning::stress::CONTRADICTION;

/// Rows that repeat others up to which loads are shared. Each costs a solve: a platform on sixteen ropes has thirteen; a flat sheet of joints
/// has hundreds, until it sags.
const MOST_SHARED: usize = 16;

/// Where a joint is: levers from the centres of mass to the points that it holds together, and from A's point to B's (m).
#[derive(Debug, Clone, Copy)]
pub(super) struct PointJoint {
    pub levers: [DVec3; 2],
    pub gap: DVec3,
}

impl PointJoint {
    pub(super) fn of(entry: &JointEntry, a: &LocalPose, b: &LocalPose) -> Self {
        let levers = [a.1 * entry.local_lever[0], b.1 * entry.local_lever[1]];
        Self { levers, gap: entry.offset + (b.0 - a.0) + (levers[1] - levers[0]) }
    }

    /// Levers to the point where the bodies are pushed. Mostly that is halfway between the two: a gap costs no angular momentum then. If it
    /// is `own`, each is pushed at its own point, which is the gradient of the gap.
    pub(super) fn pushed(&self, own: bool) -> [DVec3; 2] {
        let share = if own { 0.0 } else { 0.5 };
        [self.levers[0] + share * self.gap, self.levers[1] - share * self.gap]
    }
}

/// A joint in one solve.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointSolve {
    pub bodies: [u32; 2],
    pub levers: [DVec3; 2],
    /// What J v must make up for (m/s, or m in a projection).
    pub bias: DVec3,
    /// Multiplier (N·s).
    pub impulse: DVec3,
}

/// Ĩ⁻¹ (r × e) for the three axes e, side by side by component.
pub(super) type Response = [Lanes; 3];

/// The joints of an articulation that hold points, and room to solve them.
#[derive(Debug, Clone, Default)]
pub(super) struct BallJointSystem {
    /// Where the joints are at the present poses, if that is known.
    pub spots: Vec<PointJoint>,
    pub is_known: bool,
    /// Where they would be at the end of the substep without any joint.
    pub ends: Vec<PointJoint>,
    pub joints: Vec<PointSolve>,
    responses: Vec<[Response; 2]>,
    factor: BlockFactor,
    /// Rows of each joint.
    counts: Vec<u32>,
    unknowns: Vec<Lanes>,
    increments: Vec<Lanes>,
    has_pushed: bool,
    stresses: SelfStresses,
    /// Joint and row of each pivot that is nothing.
    dropped: Vec<(usize, usize)>,
    /// Pivot up to which a row repeats others, whatever its own size: one that the greatest load moves by no more than they contradict each
    /// other.
    idle: f64,
    /// Whether multipliers are loads, which joints that repeat one another share.
    shares: bool,
    is_factored: bool,
}

impl BallJointSystem {
    /// Forgets the joints of the last solve, which are to be listed again.
    pub(super) fn begin(&mut self) {
        self.joints.clear();
        (self.is_factored, self.has_pushed) = (false, false);
    }

    /// Says what counts as a row that repeats others in a substep of length `h` (s) whose joints have been listed, `None` where positions are
    /// solved for; and that loads are shared.
    pub(super) fn judge_rows(&mut self, topology: &Topology, h: Option<f64>) {
        self.shares = h.is_some() && topology.loops > 1;
        self.idle = 0.0;
        if let Some(h) = h.filter(|_| self.shares) {
            let most = greatest_load(&self.joints);
            self.idle = if most > 0.0 { CONTRADICTION * h / most } else { 0.0 };
        }
    }

    /// Takes the push of the last solve out of the rates.
    pub(super) fn withdraw(&mut self, bodies: &[DirectBody], rates: &mut [Rate]) {
        if std::mem::replace(&mut self.has_pushed, true) {
            for joint in &self.joints {
                push(joint, -joint.impulse, bodies, rates);
            }
        }
    }

    /// Adds the push of the carried multipliers to the rates.
    pub(super) fn warm_start(&mut self, bodies: &[DirectBody], rates: &mut [Rate]) {
        self.has_pushed = true;
        for joint in &self.joints {
            push(joint, joint.impulse, bodies, rates);
        }
    }

    /// As [`super::system::System::drop_senseless`].
    pub(super) fn drop_senseless(&mut self) {
        // Written so that one which is no number counts.
        if !self.joints.iter().all(|joint| joint.impulse.abs().cmple(DVec3::splat(MAX_IMPULSE)).all()) {
            self.drop_impulses();
        }
    }

    /// Forgets all multipliers.
    pub(super) fn drop_impulses(&mut self) {
        self.joints.iter_mut().for_each(|joint| joint.impulse = DVec3::ZERO);
    }

    /// Solves for the multipliers of all joints and adds their push to the rates.
    pub(super) fn solve(&mut self, topology: &Topology, bodies: &[DirectBody], rates: &mut [Rate]) {
        let Self { joints, responses, factor, counts, unknowns, increments, idle, .. } = self;
        if !std::mem::replace(&mut self.is_factored, true) {
            counts.clear();
            counts.resize(joints.len(), POINT as u32);
            factor.start(&topology.plan, counts);
            responses.resize(joints.len(), [[ZERO; 3]; 2]);
            assemble(factor, responses, joints, (topology, *idle), bodies);
            super::factor::factorize(factor, &topology.plan);
        }
        joints.iter_mut().for_each(|joint| joint.impulse = DVec3::ZERO);
        refine(&mut Gaps { joints, bodies, rates }, factor, &topology.plan, [0; 2], unknowns, increments, &mut false);
        if self.shares {
            self.share_loads(topology, bodies, rates);
        }
    }

    /// Shares loads among joints that repeat one another, as real ones would.
    fn share_loads(&mut self, topology: &Topology, bodies: &[DirectBody], rates: &mut [Rate]) {
        let Self { joints, factor, unknowns, increments, stresses, dropped, .. } = self;
        dropped.clear();
        for node in 0..joints.len() {
            let root = block3(factor.block(topology.plan.diagonal(node)));
            dropped.extend((0..POINT).filter(|&row| root[row][row] == 0.0).map(|row| (node, row)));
        }
        let most = greatest_load(joints);
        if dropped.is_empty() || dropped.len() > MOST_SHARED || most == 0.0 {
            return;
        }
        stresses.start(joints.iter().map(|joint| softness(joint, bodies)));
        let mut gaps = Gaps { joints, bodies, rates };
        for &(node, row) in &*dropped {
            stresses.note(impulses_of(gaps.joints));
            increments.fill(ZERO);
            increments[node][row] = most;
            gaps.add_impulses(factor, increments, 1.0);
            gaps.find_residuals(factor, unknowns);
            gaps.solve(factor, &topology.plan, unknowns);
            gaps.add_impulses(factor, unknowns, 1.0);
            stresses.add(impulses_of(gaps.joints));
        }
        stresses.relax(impulses_of(gaps.joints), increments);
        gaps.add_impulses(factor, increments, 1.0);
    }
}

fn impulses_of(joints: &[PointSolve]) -> impl Iterator<Item = DVec3> + Clone {
    joints.iter().map(|joint| joint.impulse)
}

/// How soft the bodies of a joint are where it pulls at them, of one material: Σ r²/m.
fn softness(joint: &PointSolve, bodies: &[DirectBody]) -> f64 {
    let of = |side: usize| bodies[joint.bodies[side] as usize].inverse_mass.max_element() * joint.levers[side].length_squared();
    of(0) + of(1)
}

/// Greatest component of a multiplier (N·s).
fn greatest_load(joints: &[PointSolve]) -> f64 {
    joints.iter().fold(0.0, |most, joint| most.max(joint.impulse.abs().max_element()))
}

/// The equations of the joints, at rates that change as they are solved.
struct Gaps<'a> {
    joints: &'a mut [PointSolve],
    bodies: &'a [DirectBody],
    rates: &'a mut [Rate],
}

impl Equations for Gaps<'_> {
    fn find_residuals(&mut self, _: &BlockFactor, residuals: &mut [Lanes]) -> f64 {
        let mut worst = DVec3::ZERO;
        for (joint, residual) in self.joints.iter().zip(residuals) {
            let lack = joint.bias + approach(&joint.bodies, &joint.levers, self.rates);
            worst = worst.max(lack.abs());
            *residual = [-lack.x, -lack.y, -lack.z, 0.0];
        }
        worst.max_element()
    }

    fn find_added(&mut self, _: &BlockFactor, added: &mut [Lanes]) {
        // Rows that repeat others have no multiplier here: see [`BallJointSystem::judge_rows`].
        added.fill(ZERO);
    }

    fn add_impulses(&mut self, _: &BlockFactor, increments: &[Lanes], share: f64) {
        for (joint, &[x, y, z, _]) in self.joints.iter_mut().zip(increments) {
            let impulse = DVec3::new(x, y, z) * share;
            push(joint, impulse, self.bodies, self.rates);
            joint.impulse += impulse;
        }
    }
}

/// J v of a joint.
pub(super) fn approach(bodies: &[u32; 2], levers: &[DVec3; 2], rates: &[Rate]) -> DVec3 {
    let [a, b] = bodies.map(|body| &rates[body as usize]);
    (b.linear + b.angular.cross(levers[1])) - (a.linear + a.angular.cross(levers[0]))
}

fn push(joint: &PointSolve, impulse: DVec3, bodies: &[DirectBody], rates: &mut [Rate]) {
    for (side, impulse) in [-impulse, impulse].into_iter().enumerate() {
        let number = joint.bodies[side] as usize;
        let (body, rate) = (&bodies[number], &mut rates[number]);
        rate.linear += body.inverse_mass * impulse;
        rate.angular += body.inverse_inertia * joint.levers[side].cross(impulse);
    }
}

dispatched!(
    /// Forms J M̃⁻¹ Jᵀ, slightly regularised.
    assemble, assemble_body,
    (
        factor: &mut BlockFactor,
        responses: &mut [[Response; 2]],
        joints: &[PointSolve],
        rules: (&Topology, f64),
        bodies: &[DirectBody]
    )
);

#[inline(always)]
fn assemble_body(
    factor: &mut BlockFactor,
    responses: &mut [[Response; 2]],
    joints: &[PointSolve],
    (topology, idle): (&Topology, f64),
    bodies: &[DirectBody],
) {
    let guard = &topology.regularizations[Redundancy::Points as usize];
    for (number, (joint, responses)) in joints.iter().zip(responses.iter_mut()).enumerate() {
        let mut sum = [ZERO; 3];
        for side in 0..2 {
            let (lever, body) = (joint.levers[side], &bodies[joint.bodies[side] as usize]);
            responses[side] = response(&body.inverse_inertia, lever);
            add(&mut sum, 1.0, body.inverse_mass, lever, &responses[side]);
        }
        #[expect(clippy::needless_range_loop, reason = "the index is that of a row and of a column")]
        for i in 0..3 {
            sum[i][i] += guard.added * sum[i][i];
        }
        let least = |diagonal: f64| idle.max(guard.noise * diagonal);
        factor.least[number] = [sum[0][0], sum[1][1], sum[2][2], 0.0].map(least);
        *block3_mut(factor.block_mut(topology.plan.diagonal(number))) = sum;
    }
    for coupling in &topology.couplings {
        let (late, early) = (&joints[coupling.late as usize], &responses[coupling.early as usize]);
        let (late_side, early_side) = (coupling.late_side as usize, coupling.early_side as usize);
        let sign = if late_side == early_side { 1.0 } else { -1.0 };
        let mass = bodies[coupling.body as usize].inverse_mass;
        let block = block3_mut(factor.block_mut(coupling.start));
        let mut sum = *block;
        add(&mut sum, sign, mass, late.levers[late_side], &early[early_side]);
        *block = sum;
    }
}

/// Component i of Ĩ⁻¹ (r × e_j) is (row i of Ĩ⁻¹ × r)_j.
#[inline(always)]
fn response(inverse_inertia: &DMat3, lever: DVec3) -> Response {
    let row = |row: DVec3| {
        [row.y * lever.z - row.z * lever.y, row.z * lever.x - row.x * lever.z, row.x * lever.y - row.y * lever.x, 0.0]
    };
    [row(inverse_inertia.x_axis), row(inverse_inertia.y_axis), row(inverse_inertia.z_axis)]
}

/// Adds ±(1/m + [r]ᵀ Ĩ⁻¹ [r']), with the response of r'.
#[inline(always)]
fn add(sum: &mut Block3, sign: f64, mass: DVec3, lever: DVec3, response: &Response) {
    let (mass, lever) = (mass * sign, lever * sign);
    sum[0][0] += mass.x;
    sum[1][1] += mass.y;
    sum[2][2] += mass.z;
    add_scaled(&mut sum[0], lever.z, &response[1]);
    add_scaled(&mut sum[0], -lever.y, &response[2]);
    add_scaled(&mut sum[1], lever.x, &response[2]);
    add_scaled(&mut sum[1], -lever.z, &response[0]);
    add_scaled(&mut sum[2], lever.y, &response[0]);
    add_scaled(&mut sum[2], -lever.x, &response[1]);
}
