//! Escapes singular positions: links pressed together along their own line, where no small displacement closes the error.
//!
//! A row of links between two points that are closer than the links are long, or the part of a hanging chain above a hook that rises
//! along it, has errors C that no displacement takes out to first order: along the line Jᵀ y = 0, so that J δ = −C has no solution, and
//! Newton's steps end where they began. To second order there is one. With a displacement a v across the line, J v = 0,
//!
//! ```text
//! y·C(x + a v) = y·C(x) + ½ a² vᵀ (Σ y ∇²C) v
//! ```
//!
//! and Σ y ∇²C is the geometric stiffness of the multipliers y, as though they were forces ([`stiffness`](super::stiffness)): negative
//! where they press. So the bodies leave as a column does that buckles: along v, by as much as makes the row shorter by its gaps. With Ĝ
//! the stiffness of a thrust of one along each joint's multiplier, ω·(−Ĝ)ω is twice what a turn ω takes off the length of a body,
//!
//! ```text
//! (J M̃⁻¹ Jᵀ + ε) μ = −C,   y = μ/|μ|,   ½ a² Σ ω·(−Ĝ)ω = Σ |C|.
//! ```
//!
//! The solve is damped by ε, so that μ is what presses and does not turn into a displacement without end where the line is all but straight.
//! v begins as what the forces on the bodies would do, so that what may sag sags; where they do nothing across the line, as what no
//! real row of links is without, a slight crookedness of each. Of that the turns of what is pressed are kept, M̃⁻¹ (−Ĝ) v, and held to what
//! the joints allow. It is a displacement of positions: no velocity comes of it, and it is kept only if the worst error falls. It goes all of
//! the way at once: a greatest speed would have rows of large links sag late, and at each rate of steps at another time.
//!
//! Velocities have no solution there either: what a moving hook asks of a straight row, its rows cannot give to first order, and their
//! multipliers rise without bound ([`Articulation::is_jammed`]). Such a substep is taken again from a row that is bent by as much as the
//! substep will make it shorter.

use glam::{DMat3, DVec3};

use super::articulation::{Articulation, TOLERANCE};
use super::body::DirectBody;
use super::project::Errors;
use super::row::{Origin, RowState};
use super::stiffness;
use super::system::PROJECTION_PASSES;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::solve::joint::rows::{Phase, Rate};
use crate::solve::rotation;

/// What is added to the diagonal, over itself. A row of 16 links that sags by 0.1 of its length is as stiff as this along its line, and
/// Newton's steps find their own way from there.
const DAMPING: f64 = 1.0e-3;

/// Share of the greatest multiplier from which on one presses or pulls.
const NOTICEABLE: f64 = 1.0e-3;

/// Multiple of the momentum of all bodies, at the greatest speed of any and what a substep adds to it, by which no joint presses unless
/// what is pressed cannot yield to first order. In struts it is a few times that; a row of links that is pressed from both ends has what
/// damping leaves it, 1e3 to 1e8.
const JAMMED: f64 = 100.0;

/// Rounds in which the mode is drawn towards what is pressed.
const ROUNDS: usize = 2;

/// Acceleration (m/s²), and turn for each metre, that stand for the crookedness of a row that is made straight: nothing beside gravity.
const CROOKED: f64 = 1.0e-6;

/// Solves that it costs.
pub(super) const SOLVES: u32 = 4;

impl Articulation {
    /// Takes errors out of the positions, in a way that leads over a bend where none leads straight on; returns what is left.
    pub(super) fn close(&mut self, joints: &Pool<Joint, JointId>, errors: Errors) -> Errors {
        let left = self.step_towards(joints, errors);
        if left.worst <= TOLERANCE * self.size || !left.worst.is_finite() || !self.pay(SOLVES) {
            return left;
        }
        let straight = self.local_poses.clone();
        if let Some(bent) = self.buckle(joints) {
            let bent = self.step_towards(joints, bent);
            if bent.worst < left.worst {
                return bent;
            }
        }
        self.local_poses.clone_from(&straight);
        self.points.is_known = false;
        left
    }

    /// Whether a substep of length `h` (s) has joints press on each other by far more than all its bodies could push.
    pub(super) fn is_jammed(&self, h: f64) -> bool {
        let mass: f64 = self.bodies.iter().filter_map(|body| body.mass()).sum();
        // What goes less far than rows are crooked presses nothing together.
        let speed = |(body, rate): (&DirectBody, &Rate)| {
            rate.linear.length() + body.acceleration.length() * h + CROOKED * body.gyration() / h
        };
        let most = JAMMED * mass * self.bodies.iter().zip(&self.began.rates).map(speed).fold(0.0, f64::max);
        self.entries.iter().zip(&self.links).any(|(entry, link)| {
            let impulse = entry.impulses.point.as_dvec3();
            [(0, -1.0), (1, 1.0)].into_iter().any(|(side, sign)| {
                let body = link.bodies[side] as usize;
                let lever = self.local_poses[body].1 * entry.local_lever[side];
                // A joint in the middle of a body presses along no line of it, whichever way it is off by a rounding.
                let is_beside = lever.length() > CROOKED * self.bodies[body].gyration();
                is_beside && -sign * impulse.dot(lever) > most * lever.length()
            })
        })
    }

    /// Bends what the way of a substep of length `h` (s) would press together, from where the bodies stand.
    pub(super) fn bend_ahead(&mut self, joints: &Pool<Joint, JointId>, h: f64) {
        for (stance, rate) in self.local_poses.iter_mut().zip(&self.rates) {
            *stance = (stance.0 + rate.linear * h, rotation::rotated(stance.1, rate.angular * h));
        }
        let way = self.find_mode(joints);
        self.local_poses.clone_from(&self.began.local_poses);
        self.bend(way.unwrap_or_default());
    }

    /// Bends what is pressed together; returns the errors then.
    fn buckle(&mut self, joints: &Pool<Joint, JointId>) -> Option<Errors> {
        let way = self.find_mode(joints)?;
        self.bend(way);
        Some(self.find_errors(joints))
    }

    fn bend(&mut self, way: f64) {
        for ((body, stance), change) in self.bodies.iter().zip(&mut self.local_poses).zip(&self.changes) {
            body.displace(stance, change, way);
        }
        self.points.is_known = false;
    }

    /// Finds how the bodies give way to what presses them together at the poses of now, and by how much.
    fn find_mode(&mut self, joints: &Pool<Joint, JointId>) -> Option<f64> {
        let gaps = self.find_thrust(joints);
        self.begin_mode();
        for _ in 0..ROUNDS {
            self.soften_mode();
            self.hold_mode();
        }
        let shortening: f64 =
            self.stiffness.iter().zip(&self.changes).map(|(g, change)| -change.angular.dot(*g * change.angular)).sum();
        let way = (2.0 * gaps / shortening).sqrt();
        // Written so that what is no number is refused.
        (shortening > 0.0 && way > 0.0 && way.is_finite()).then_some(way)
    }

    /// Finds what presses on the bodies, as the stiffness of each by unit thrusts, none where they pull; returns the sum of the gaps (m).
    fn find_thrust(&mut self, joints: &Pool<Joint, JointId>) -> f64 {
        self.built.clear();
        self.build_rows(joints, Phase::Position { most: f64::INFINITY });
        self.system.begin_projection(f64::INFINITY, f64::INFINITY);
        for node in 0..self.system.nodes.len() {
            let node = self.system.nodes[node];
            for row in &mut self.system.rows[node.first as usize..node.last as usize] {
                row.gamma += DAMPING * row.response(node.bodies.map(|body| &self.bodies[body as usize]));
            }
        }
        self.system.begin(&self.bodies);
        self.still_changes();
        self.system.solve(&self.topology, &self.bodies, &mut self.changes, PROJECTION_PASSES);
        let (mut gaps, mut greatest) = (0.0, 0.0_f64);
        for number in 0..self.entries.len() {
            let [gap, thrust] = self.gap_and_thrust(number);
            gaps += gap.length();
            greatest = greatest.max(thrust.length());
        }
        self.stiffness.clear();
        self.stiffness.resize(self.bodies.len(), DMat3::ZERO);
        for number in 0..self.entries.len() {
            let [_, thrust] = self.gap_and_thrust(number);
            if thrust.length() <= NOTICEABLE * greatest {
                continue;
            }
            let (link, entry, thrust) = (&self.links[number], &self.entries[number], thrust.normalize());
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let body = link.bodies[side] as usize;
                self.stiffness[body] += stiffness::of_impulse(thrust * sign, self.local_poses[body].1 * entry.local_lever[side]);
            }
        }
        let trace = |g: &DMat3| g.x_axis.x + g.y_axis.y + g.z_axis.z;
        self.stiffness.iter_mut().filter(|g| trace(g) >= 0.0).for_each(|g| *g = DMat3::ZERO);
        self.system.rows.iter_mut().for_each(|row| row.bias = 0.0);
        gaps
    }

    /// How far a joint is open along the rows that hold it, and what their multipliers come to.
    fn gap_and_thrust(&self, number: usize) -> [DVec3; 2] {
        let node = &self.system.nodes[number];
        let rows = self.system.rows[node.first as usize..node.last as usize].iter();
        let rows = rows.filter(|row| row.state == RowState::Free && row.origin != Origin::Contact);
        rows.fold([DVec3::ZERO; 2], |[gap, thrust], row| [gap + row.linear[1] * row.bias, thrust + row.linear[1] * row.impulse])
    }

    fn still_changes(&mut self) {
        self.changes.clear();
        self.changes.resize(self.bodies.len(), Rate { linear: DVec3::ZERO, angular: DVec3::ZERO });
    }

    /// What the forces do to the bodies, and a slight crookedness.
    fn begin_mode(&mut self) {
        self.still_changes();
        for (number, (body, change)) in
            self.bodies.iter().zip(&mut self.changes).enumerate().filter(|(_, (body, _))| body.is_dynamic())
        {
            let crooked = crookedness(number as u64) * CROOKED;
            *change = Rate { linear: body.acceleration + crooked, angular: crooked / self.size };
        }
        self.hold_mode();
    }

    /// Keeps of the mode how bodies turn that are pressed, as they would turn further; over its size.
    fn soften_mode(&mut self) {
        for ((body, g), change) in self.bodies.iter().zip(&self.stiffness).zip(&mut self.changes) {
            *change = Rate { linear: DVec3::ZERO, angular: -(body.inverse_inertia * (*g * change.angular)) };
        }
        let over = 1.0 / self.greatest_path();
        if over.is_finite() {
            for change in &mut self.changes {
                change.angular *= over;
            }
        }
    }

    /// Takes out of the mode what the joints do not allow.
    fn hold_mode(&mut self) {
        self.system.solve_lasting(&self.topology, &self.bodies, &mut self.changes);
    }

    /// Greatest path of any joint point in the mode (m).
    fn greatest_path(&self) -> f64 {
        let mut greatest = 0.0_f64;
        for (link, entry) in self.links.iter().zip(&self.entries) {
            for side in 0..2 {
                let body = link.bodies[side] as usize;
                let (change, lever) = (&self.changes[body], self.local_poses[body].1 * entry.local_lever[side]);
                greatest = greatest.max((change.linear + change.angular.cross(lever)).length());
            }
        }
        greatest
    }
}

/// A direction that seems random and is the same for a number at any time.
fn crookedness(number: u64) -> DVec3 {
    let mut state = number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    DVec3::new(next(), next(), next())
}
