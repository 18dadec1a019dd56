//! Bounds wrapped around what their chain is pressed against: a cable over a drum.
//!
//! A chain that lies over something fixed is bounded by no straight line from end to end, but by the way around. With w₁ … wₖ the
//! joints that its pull presses into what it lies on, as they stand at the start of the step, S the length of the line through them,
//! and D that of the chain between its ends a and p,
//!
//! ```text
//! C = D − |a − w₁| − S − |p − wₖ| ≥ 0,    J = [−n_a, −r_a×n_a, −n_p, −r_p×n_p],    n_a = (a − w₁)/|a − w₁|, n_p likewise;
//! w = J M⁻¹ Jᵀ    (1/kg), λ ≥ 0 (N·s), carried from substep to substep.
//! ```
//!
//! What one end yields the other takes, as in Atwood's machine, and what is fixed bears the rest: Σ λ (uⱼ − uⱼ₋₁) over the waypoints,
//! u being the directions of the pieces from a to p. A row asks for no more than J v + max(C, 0)/h ≥ 0 and only pulls, so it gives no
//! energy; waypoints stand still within a step. Where they would not be pressed in, they are none ([`Waypoint`]).

use glam::Vec3;

use super::contact::LANES;
use super::contact_block::ContactBlocks;
use super::state::{BodyMotion, BodyVelocity, MotionKind};

/// Share of an error that is taken out of positions in a substep: some of it is the waypoints', which move on with the chain.
const RECOVERY_SHARE: f32 = 0.2;

/// Cosine of the greatest angle between the pull of a chain on a waypoint and the way into what it lies on. A slack chain on a floor
/// bends too, but pulls along the floor.
const PRESSED: f32 = 0.5;

/// Bend (rad) below which a joint is no waypoint: the way is as long without it.
const STRAIGHT: f32 = 1.0e-3;

/// A joint that a chain may be pressed against something at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Waypoint {
    /// Its place in the world's list of joints on paths.
    pub inner: u32,
    /// From the near body's origin (m).
    pub point: Vec3,
    /// Out of what it lies on; not of unit length.
    pub out: Vec3,
}

/// Where the pull along a chain turns: direction behind a waypoint less that before it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bend {
    pub inner: u32,
    pub turn: Vec3,
}

/// A wrapped bound as its batch holds it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WrapEntry {
    /// The world's number for the bound.
    pub bound: u32,
    pub near: u32,
    pub far: u32,
    /// From the near body's origin to the far one's at the start of the step (m).
    pub offset: Vec3,
    /// Joint points from the origins, in the bodies' frames (m).
    pub local_lever: [Vec3; 2],
    /// Length of the chain (m).
    pub upper: f32,
    /// λ (N·s).
    pub impulse: f32,
    /// First and last waypoint, from the near body's origin, and the way between them (m).
    pub ways: [Vec3; 2],
    pub between: f32,
    /// Its waypoints, as a range of [`BatchWraps::bends`].
    pub bends: (u32, u32),
    /// Sums over the substeps of λ, and of the impulses on the far body (N·s).
    pub sum: f32,
    pub far_sum: Vec3,
    row: WrappedRow,
}

/// The row of a substep: directions from the waypoints to the ends, levers of the ends (m), 1/w (kg), and C/h (m/s).
#[derive(Debug, Clone, Copy, Default)]
struct WrappedRow {
    along: [Vec3; 2],
    arm: [Vec3; 2],
    mass: f32,
    allowed: f32,
}

impl WrapEntry {
    /// A bound without waypoints yet.
    pub(crate) fn new(bound: u32, slots: [u32; 2], offset: Vec3, local_lever: [Vec3; 2], upper: f32, impulse: f32) -> Self {
        let [near, far] = slots;
        let (ways, sum, far_sum, row) = ([Vec3::ZERO; 2], 0.0, Vec3::ZERO, WrappedRow::default());
        Self { bound, near, far, offset, local_lever, upper, impulse, ways, between: 0.0, bends: (0, 0), sum, far_sum, row }
    }

    /// Its two ends, from the near body's origin, and their levers (m).
    fn ends(&self, motions: &[BodyMotion]) -> ([Vec3; 2], [Vec3; 2]) {
        let (near, far) = (&motions[self.near as usize], &motions[self.far as usize]);
        let arm = [near.rotation * self.local_lever[0], far.rotation * self.local_lever[1]];
        ([near.displacement + arm[0], self.offset + far.displacement + arm[1]], arm)
    }

    /// C (m) and the row at the poses of now.
    fn look(&self, velocities: &[BodyVelocity], motions: &[BodyMotion]) -> (f32, WrappedRow) {
        let (ends, arm) = self.ends(motions);
        let gaps = [ends[0] - self.ways[0], ends[1] - self.ways[1]];
        let along = gaps.map(Vec3::normalize_or_zero);
        let response = |end: usize, slot: u32| {
            let (body, moment) = (&velocities[slot as usize], arm[end].cross(along[end]));
            along[end].dot(body.inverse_mass * along[end]) + moment.dot(body.inverse_inertia.mul(moment))
        };
        let w = response(0, self.near) + response(1, self.far);
        let mass = if w > 0.0 { 1.0 / w } else { 0.0 };
        (self.upper - gaps[0].length() - self.between - gaps[1].length(), WrappedRow { along, arm, mass, allowed: 0.0 })
    }

    /// How fast its way grows longer (m/s).
    fn rate(&self, velocities: &[BodyVelocity]) -> f32 {
        let of = |end: usize, slot: u32| {
            let body = &velocities[slot as usize];
            self.row.along[end].dot(body.linear + body.angular.cross(self.row.arm[end]))
        };
        of(0, self.near) + of(1, self.far)
    }

    fn pull(&self, row: &WrappedRow, impulse: f32, mut apply: impl FnMut(u32, Vec3, Vec3)) {
        for (end, slot) in [self.near, self.far].into_iter().enumerate() {
            let on_end = row.along[end] * -impulse;
            apply(slot, on_end, row.arm[end].cross(on_end));
        }
    }
}

/// All wrapped bounds of a batch.
#[derive(Debug, Default)]
pub(crate) struct BatchWraps {
    pub entries: Vec<WrapEntry>,
    pub bends: Vec<Bend>,
    /// Joints of the bound that is looked at, from its near end to its far one.
    pub waypoints: Vec<Waypoint>,
    /// Out of what is fixed and touches each slot; zero where nothing does. Empty where nothing fixed touches anything.
    touches: Vec<Vec3>,
}

impl BatchWraps {
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
        self.bends.clear();
        self.touches.clear();
    }

    /// Notes what touches something fixed: presses on it, or is no farther from it than `reach` (m).
    pub(crate) fn find_touches(&mut self, contacts: &ContactBlocks, motions: &[BodyMotion], reach: f32) {
        let is_fixed = |slot: u32| motions[slot as usize].kind == MotionKind::Fixed;
        for (number, block) in contacts.blocks.iter().enumerate() {
            for l in 0..LANES {
                let (a, b) = (block.a[l], block.b[l]);
                let touches = |i: usize| {
                    let rows = contacts.rows(number, i);
                    rows.inverse_diagonal[l] > 0.0 && (rows.lambda[l] > 0.0 || rows.separation[l] <= reach)
                };
                if is_fixed(a) == is_fixed(b) || !(0..contacts.room_of(number)).any(touches) {
                    continue;
                }
                self.touches.resize(motions.len(), Vec3::ZERO);
                let normal = Vec3::from_array(block.normal.map(|lane| lane[l]));
                if is_fixed(a) {
                    self.touches[b as usize] += normal;
                } else {
                    self.touches[a as usize] -= normal;
                }
            }
        }
    }

    /// Out of what is fixed and touches any of these slots, if anything does.
    pub(crate) fn touched(&self, slots: [u32; 2]) -> Option<Vec3> {
        let of = |slot: u32| self.touches.get(slot as usize).copied().unwrap_or_default();
        let out = of(slots[0]) + of(slots[1]);
        (out != Vec3::ZERO).then_some(out)
    }

    /// Whether anything fixed touches anything.
    pub(crate) fn has_touches(&self) -> bool {
        !self.touches.is_empty()
    }

    /// Adds a bound around those of the waypoints that its pull presses in; says whether there are any.
    pub(crate) fn add(&mut self, mut entry: WrapEntry, motions: &[BodyMotion]) -> bool {
        let (ends, _) = entry.ends(motions);
        let Self { entries, bends, waypoints, .. } = self;
        // Without one waypoint the way turns elsewhere at its neighbours.
        loop {
            let before = waypoints.len();
            let mut last = ends[0];
            let mut place = 0;
            while let Some(&Waypoint { point, out, .. }) = waypoints.get(place) {
                let next = waypoints.get(place + 1).map_or(ends[1], |next| next.point);
                let turn = (next - point).normalize_or_zero() - (point - last).normalize_or_zero();
                let size = turn.length();
                if size > STRAIGHT && -turn.dot(out) >= PRESSED * size * out.length() {
                    last = point;
                    place += 1;
                } else {
                    waypoints.remove(place);
                }
            }
            if waypoints.len() == before {
                break;
            }
        }
        let (Some(first), Some(last)) = (waypoints.first(), waypoints.last()) else { return false };
        entry.ways = [first.point, last.point];
        entry.between = waypoints.windows(2).map(|pair| pair[0].point.distance(pair[1].point)).sum();
        entry.bends.0 = bends.len() as u32;
        for (place, waypoint) in waypoints.iter().enumerate() {
            let before = place.checked_sub(1).map_or(ends[0], |before| waypoints[before].point);
            let next = waypoints.get(place + 1).map_or(ends[1], |next| next.point);
            let turn = (next - waypoint.point).normalize_or_zero() - (waypoint.point - before).normalize_or_zero();
            bends.push(Bend { inner: waypoint.inner, turn });
        }
        entry.bends.1 = bends.len() as u32;
        entries.push(entry);
        true
    }

    /// Builds the rows of a substep of length `h` and applies the carried multipliers.
    pub(crate) fn begin_substep(&mut self, velocities: &mut [BodyVelocity], motions: &[BodyMotion], h: f32) {
        for entry in &mut self.entries {
            let (slack, row) = entry.look(velocities, motions);
            entry.row = WrappedRow { allowed: slack.max(0.0) / h, ..row };
            entry.pull(&entry.row, entry.impulse, |slot, linear, angular| velocities[slot as usize].apply(linear, angular));
        }
    }

    /// One sweep over all rows.
    pub(crate) fn sweep(&mut self, velocities: &mut [BodyVelocity], backwards: bool) {
        let visit = |entry: &mut WrapEntry| {
            let new = (entry.impulse + entry.row.mass * (entry.rate(velocities) - entry.row.allowed)).max(0.0);
            let change = new - entry.impulse;
            entry.pull(&entry.row, change, |slot, linear, angular| velocities[slot as usize].apply(linear, angular));
            entry.impulse = new;
        };
        if backwards {
            self.entries.iter_mut().rev().for_each(visit);
        } else {
            self.entries.iter_mut().for_each(visit);
        }
    }

    /// Sets the multipliers of bounds on these slots to nothing.
    pub(crate) fn give_up(&mut self, slots: &[bool]) {
        let torn = self.entries.iter_mut().filter(|entry| slots[entry.near as usize] || slots[entry.far as usize]);
        torn.for_each(|entry| entry.impulse = 0.0);
    }

    /// Adds the substep's multipliers to the loads.
    pub(crate) fn add_loads(&mut self) {
        for entry in &mut self.entries {
            entry.sum += entry.impulse;
            entry.far_sum -= entry.row.along[1] * entry.impulse;
        }
    }

    /// One sweep of position rows at the poses of now.
    pub(crate) fn project(&self, velocities: &[BodyVelocity], motions: &mut [BodyMotion]) {
        for entry in &self.entries {
            let (slack, row) = entry.look(velocities, motions);
            let impulse = RECOVERY_SHARE * row.mass * (-slack).max(0.0);
            entry.pull(&row, impulse, |slot, linear, angular| {
                let mut push = velocities[slot as usize].at_rest();
                push.apply(linear, angular);
                motions[slot as usize].displace(push.linear, push.angular);
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a chain of 3 m between two points 2 m apart along x is wrapped at a joint half a metre beside their middle.
    fn is_wrapped(out: Vec3) -> bool {
        let levers = [Vec3::ZERO, Vec3::X * 2.0];
        let mut wraps = BatchWraps::default();
        wraps.waypoints.push(Waypoint { inner: 0, point: Vec3::new(1.0, 0.0, 0.5), out });
        let entry = WrapEntry::new(0, [0, 0], Vec3::ZERO, levers, 3.0, 0.0);
        let added = wraps.add(entry, &[BodyMotion::FIXED]);
        assert_eq!(added, wraps.entries.len() == 1 && wraps.bends.len() == 1);
        added
    }

    #[test]
    fn a_bound_is_wrapped_only_where_its_pull_presses_the_chain_in() {
        assert!(is_wrapped(Vec3::Z), "over a drum");
        assert!(!is_wrapped(Vec3::Y), "bent on a floor");
        assert!(!is_wrapped(Vec3::NEG_Z), "away from a wall");
    }
}
