//! The problem of one substep on plain arrays: bodies, joint rows, terms.
//!
//! ```text
//! min_v ½ vᵀ M̂ v − vᵀ(M v* + ½ K (v₀ + v̄)) + Σ ψ(J_c v)    subject to    J_j v + ε (λ − λ̄) = −b,      M̂ = M + K
//! ```
//!
//! M is the mass of the bodies with their damping, and K the positive part of their geometric stiffness times the square of the
//! substep's length ([`stiffness`](super::stiffness)). v₀ is the velocity at the start of the substep, v* the one that forces make of
//! it, and v̄ the velocity of bodies that go steadily round a drum, zero for others. J_j are the rows of joints that always hold, with
//! multipliers λ; J_c are those of the terms, which have bounds, and ψ is their energy ([`term`](super::term)). ε of a rigid row is a
//! billionth of its J M⁻¹ Jᵀ, so that redundant rows share their load.

use super::elimination::Elimination;
use super::factor::{Factor, Vector, dot};
use super::term::{FIXED, Law, Term};

/// ε over J M⁻¹ Jᵀ. From 1e-7 to 1e-9 nothing changes; at 1e-5 a scissor lift sinks by 50 mm, at 1e-11 redundant rows make
/// noise of metres a second.
pub(super) const PROXIMITY: f64 = 1.0e-9;

/// Share of K v₀ on the right-hand side. 0 is backward Euler; at 1 hardly any energy is lost and fast oscillations ring on. The rest of
/// K acts on the steady velocity of bodies that go round a drum, so that what damps the swinging of a rope's links does not hold back a
/// rope that runs. Of the stiffness with which a contact resists rolling, the rest acts on angular velocities alone.
const RIGHT_SHARE: f64 = 0.5;

/// Mass of one body with its damping, and the stiffness of its rotation.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct BodyMass {
    pub linear: [f64; 3],
    /// By columns, symmetric.
    pub angular: [[f64; 3]; 3],
    pub stiffness: [[f64; 3]; 3],
    /// Angular velocity where the body goes steadily round what it presses on (rad/s).
    pub steady: [f64; 3],
}

/// Rows of one joint that always hold.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointBlock {
    pub bodies: [u32; 2],
    pub rows: usize,
    /// Bit mask of the rows of motors whose force has no bound.
    pub boundless: u8,
    /// By side and row.
    pub jacobian: [[Vector; 6]; 2],
    pub bias: Vector,
    /// Compliance of each row, zero where it is rigid.
    pub give: Vector,
    pub impulse: Vector,
    /// Error of each rigid row (m or rad).
    pub error: Vector,
    /// ε.
    pub proximity: Vector,
}

impl JointBlock {
    pub(crate) fn new(bodies: [u32; 2]) -> Self {
        Self {
            bodies,
            rows: 0,
            boundless: 0,
            jacobian: [[[0.0; 6]; 6]; 2],
            bias: [0.0; 6],
            give: [0.0; 6],
            impulse: [0.0; 6],
            error: [0.0; 6],
            proximity: [0.0; 6],
        }
    }
}

/// A stiffness between two bodies: gain × (J v)².
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stiff {
    pub bodies: [u32; 2],
    pub jacobian: [Vector; 2],
    pub gain: f64,
    /// J v of a body that goes steadily round another, for the stiffness with which a contact resists rolling; `None` for any other.
    pub steady: Option<f64>,
}

/// Buffers of a solve.
#[derive(Debug, Default)]
pub(super) struct Room {
    pub(super) gradient: Vec<Vector>,
    pub(super) product: Vec<Vector>,
    /// A sum over the lines, or the joints, of each body.
    pub(super) sums: Vec<f64>,
    /// The inertia that joints which hold points add to each body.
    pub(super) pivots: Vec<glam::DMat3>,
    /// 1 along and about the free axes of each body, 0 along and about locked ones.
    pub(super) axes: Vec<[f64; 6]>,
    pub(super) step_speeds: Vec<[f64; 2]>,
    pub(super) saved_velocity: Vec<Vector>,
    pub(super) saved_terms: Vec<Term>,
    pub(super) saved_impulses: Vec<Vector>,
    pub(super) warm_terms: Vec<Term>,
    pub(super) warm_impulses: Vec<Vector>,
    pub(super) first_terms: Vec<Term>,
    pub(super) first_impulses: Vec<Vector>,
    pub(super) carried: Vec<Vector>,
    /// Of each term that leans on others, the bound of the last pass, and what has been found to press with it.
    pub(super) bounds: Vec<[f64; 2]>,
    pub(super) targets: Vec<[f64; 2]>,
    pub(super) asked: Vec<Vector>,
    pub(super) residual: Vec<Vector>,
    /// Speed that the bend of a joint's way asks of each of its terms (m/s), by the numbers of these.
    pub(super) bent: Vec<(u32, f64)>,
    /// λ of each link in an impact (N·s, N·m·s).
    pub(super) blows: Vec<Vector>,
}

/// One substep's problem, and the buffers to solve it.
#[derive(Debug, Default)]
pub(crate) struct Problem {
    pub masses: Vec<BodyMass>,
    /// v₀, v* and the solution v.
    pub before: Vec<Vector>,
    pub free: Vec<Vector>,
    pub velocity: Vec<Vector>,
    pub links: Vec<JointBlock>,
    pub terms: Vec<Term>,
    pub stiff: Vec<Stiff>,
    pub structure: Elimination,
    pub factor: Factor,
    /// M v* + ½ K (v₀ + v̄).
    pub(super) drive: Vec<Vector>,
    pub(super) unknowns: Vec<Vector>,
    pub(super) room: Room,
    /// Whether the terms or the matrix have changed since the factorisation.
    pub(super) is_stale: bool,
    /// Whether masses, links or what is stiff have changed since the part of the matrix that they make was kept.
    pub(super) is_base_stale: bool,
    /// Inverse inertia of each body, with its damping.
    pub(super) inverses: Vec<glam::DMat3>,
    /// Forces on the bodies, for servos that ask (N, N·m).
    pub(super) forces: Vec<Vector>,
}

impl Problem {
    /// Empties the problem, for the next substep to fill.
    pub(crate) fn clear(&mut self) {
        self.masses.clear();
        self.before.clear();
        self.free.clear();
        self.velocity.clear();
        self.links.clear();
        self.terms.clear();
        self.stiff.clear();
    }

    /// Takes the inverse of each body's inertia, once all masses are known.
    pub(crate) fn invert_masses(&mut self) {
        self.inverses.clear();
        self.inverses.extend(self.masses.iter().map(|mass| glam::DMat3::from_cols_array_2d(&mass.angular).inverse()));
    }

    /// Prepares the first solve: J M⁻¹ Jᵀ of each row, from which ε follows, and the right-hand side.
    pub(crate) fn begin(&mut self) {
        let Self { links, terms, masses, inverses, .. } = self;
        let inverses = Inverses { masses, angular: inverses };
        for link in links.iter_mut() {
            for row in 0..link.rows {
                let ease: f64 = (0..2).map(|side| inverses.ease(link.bodies[side], &link.jacobian[side][row])).sum();
                link.proximity[row] = PROXIMITY * ease.max(f64::MIN_POSITIVE);
            }
        }
        for term in terms.iter_mut() {
            let rows = term.rows;
            let own = |side: usize| (0..rows).map(|row| inverses.ease(term.bodies[side], &term.jacobian[side][row])).sum::<f64>();
            term.ease = (own(0) + own(1)) / rows as f64;
            if term.ease < f64::MIN_POSITIVE {
                // Locked axes leave it nothing to move, as friction against spin between bodies that never turn.
                (term.rows, term.law, term.ease) = (1, Law::Between(0.0, 0.0), 1.0);
            }
        }
        self.find_drive();
    }

    /// Takes the locked axes out of what is stiff: `free` is 1 along and about those of each body that are free, and 0 else, and `torques` is its
    /// stiffness against rotation.
    pub(crate) fn hold_axes(&mut self, free: impl Iterator<Item = [f64; 6]>, torques: &mut [glam::DMat3]) {
        let axes = &mut self.room.axes;
        axes.clear();
        axes.extend(free);
        if axes.iter().all(|free| *free == [1.0; 6]) {
            return;
        }
        for (torque, free) in torques.iter_mut().zip(&*axes) {
            let about = glam::DMat3::from_diagonal(glam::DVec3::new(free[3], free[4], free[5]));
            *torque = about * *torque * about;
        }
        for stiff in &mut self.stiff {
            for side in (0..2).filter(|&side| stiff.bodies[side] != FIXED) {
                let free = &axes[stiff.bodies[side] as usize];
                stiff.jacobian[side].iter_mut().zip(free).for_each(|(entry, free)| *entry *= free);
            }
        }
    }

    /// Makes the impulses just found the expected ones λ̄ of the next solve; a term that gives has none.
    pub(crate) fn note_impulses(&mut self) {
        for term in &mut self.terms {
            term.expected = if term.give > 0.0 { [0.0; 2] } else { term.impulse };
        }
    }

    /// Forms M v* + ½ K (v₀ + v̄).
    pub(crate) fn find_drive(&mut self) {
        self.is_base_stale = true;
        let Self { drive, masses, free, before, stiff, .. } = self;
        drive.clear();
        drive.extend(masses.iter().zip(free.iter().zip(before.iter())).map(|(mass, (free, before))| {
            let (own, kept) = (mass.times(free, 0.0), mass.times(before, 1.0));
            let plain = mass.times(before, 0.0);
            let mut drive: Vector = std::array::from_fn(|i| own[i] + RIGHT_SHARE * (kept[i] - plain[i]));
            for (entry, row) in drive[3..].iter_mut().zip(&mass.stiffness) {
                *entry += (1.0 - RIGHT_SHARE) * (0..3).map(|i| row[i] * mass.steady[i]).sum::<f64>();
            }
            drive
        }));
        for stiff in stiff.iter() {
            let jacobian = [&stiff.jacobian[0], &stiff.jacobian[1]];
            let had = rate(stiff.bodies, jacobian, before);
            let Some(steady) = stiff.steady else {
                push_along(stiff.bodies, jacobian, stiff.gain * RIGHT_SHARE * had, drive);
                continue;
            };
            // A torque damps what differs from turning steadily. A force would also hold back a body that goes round nothing, such as
            // the deck under a wheel.
            push_along(stiff.bodies, jacobian, stiff.gain * had, drive);
            let about = stiff.jacobian.map(|row| [0.0, 0.0, 0.0, row[3], row[4], row[5]]);
            push_along(stiff.bodies, [&about[0], &about[1]], stiff.gain * (1.0 - RIGHT_SHARE) * (steady - had), drive);
        }
    }

    /// M̂ v.
    pub(super) fn times(&self, v: &[Vector], result: &mut Vec<Vector>) {
        result.clear();
        result.extend(self.masses.iter().zip(v).map(|(mass, v)| mass.times(v, 1.0)));
        for stiff in &self.stiff {
            let jacobian = [&stiff.jacobian[0], &stiff.jacobian[1]];
            push_along(stiff.bodies, jacobian, stiff.gain * rate(stiff.bodies, jacobian, v), result);
        }
    }

    /// Finds u of each term at a velocity.
    pub(super) fn find_speeds(&mut self) {
        let Self { terms, velocity, .. } = self;
        for term in terms.iter_mut() {
            let speed = speed(term, velocity);
            term.speed = [speed[0] + term.bias[0], speed[1] + term.bias[1]];
        }
    }

    /// Appends −b − J v + ε λ̄ of each joint, the right-hand side of its rows, to that of the bodies in `unknowns`.
    pub(super) fn ask_links(links: &[JointBlock], velocity: Option<&[Vector]>, unknowns: &mut Vec<Vector>) {
        unknowns.extend(links.iter().map(|link| {
            let mut asked = [0.0; 6];
            for row in 0..link.rows {
                let rate = velocity.map_or(0.0, |v| rate(link.bodies, [&link.jacobian[0][row], &link.jacobian[1][row]], v));
                asked[row] = link.proximity[row] * link.impulse[row] - link.bias[row] - rate;
            }
            asked
        }));
    }

    /// Gives each joint row at least this compliance, over its own J M⁻¹ Jᵀ.
    pub(super) fn give_way(&mut self, give: f64) {
        self.is_base_stale = true;
        for link in &mut self.links {
            for row in 0..link.rows {
                link.give[row] = link.give[row].max(give / PROXIMITY * link.proximity[row]);
            }
        }
    }

    /// Greatest |J v + b| left on a rigid row (m/s, rad/s); infinite where a velocity is not finite.
    pub(crate) fn strain(&self) -> f64 {
        if !self.velocity.iter().flatten().all(|value| value.is_finite()) {
            return f64::INFINITY;
        }
        let of_link = |link: &JointBlock| {
            let rates = (0..link.rows).filter(|&row| link.give[row] == 0.0).map(|row| {
                let jacobian = [&link.jacobian[0][row], &link.jacobian[1][row]];
                (rate(link.bodies, jacobian, &self.velocity) + link.bias[row]).abs()
            });
            rates.fold(0.0, f64::max)
        };
        self.links.iter().map(of_link).fold(0.0, f64::max)
    }

    /// Copies the multipliers of all joints to `saved`.
    pub(super) fn save_impulses(links: &[JointBlock], saved: &mut Vec<Vector>) {
        saved.clear();
        saved.extend(links.iter().map(|link| link.impulse));
    }

    /// Restores the multipliers that [`save_impulses`](Self::save_impulses) has copied.
    pub(super) fn restore_impulses(links: &mut [JointBlock], saved: &[Vector]) {
        links.iter_mut().zip(saved).for_each(|(link, saved)| link.impulse = *saved);
    }

    /// Takes the joints' multipliers from the solution.
    pub(super) fn keep_links(&mut self) {
        let bodies = self.masses.len();
        for (link, found) in self.links.iter_mut().zip(&self.unknowns[bodies..]) {
            link.impulse = found.map(|value| -value);
        }
    }
}

impl BodyMass {
    /// Trace of inertia plus stiffness of rotation.
    pub(crate) fn trace(&self) -> f64 {
        (0..3).map(|i| self.angular[i][i] + self.stiffness[i][i]).sum()
    }

    /// Product with a velocity, with this share of the stiffness.
    pub(super) fn times(&self, v: &Vector, share: f64) -> Vector {
        let mut result = [0.0; 6];
        for i in 0..3 {
            result[i] = self.linear[i] * v[i];
            result[3 + i] = (0..3).map(|j| (self.angular[i][j] + share * self.stiffness[i][j]) * v[3 + j]).sum();
        }
        result
    }
}

/// Inverse masses of the bodies.
#[derive(Clone, Copy)]
pub(super) struct Inverses<'a> {
    pub masses: &'a [BodyMass],
    /// Inverse of each one's inertia.
    pub angular: &'a [glam::DMat3],
}

impl Inverses<'_> {
    /// J M⁻¹ Jᵀ of one side of a row.
    pub(super) fn ease(&self, body: u32, row: &Vector) -> f64 {
        if body == FIXED {
            return 0.0;
        }
        let mass = &self.masses[body as usize];
        let along: f64 = (0..3).map(|i| row[i] * row[i] / mass.linear[i]).sum();
        let lever = glam::DVec3::new(row[3], row[4], row[5]);
        along + lever.dot(self.angular[body as usize] * lever)
    }
}

/// J v of one row.
pub(super) fn rate(bodies: [u32; 2], jacobian: [&Vector; 2], v: &[Vector]) -> f64 {
    let own = |side: usize| if bodies[side] == FIXED { 0.0 } else { dot(jacobian[side], &v[bodies[side] as usize]) };
    own(0) + own(1)
}

/// J v of a term.
pub(super) fn speed(term: &Term, v: &[Vector]) -> [f64; 2] {
    let own = |row: usize| rate(term.bodies, [&term.jacobian[0][row], &term.jacobian[1][row]], v);
    [own(0), if term.rows == 2 { own(1) } else { 0.0 }]
}

/// Adds Jᵀ × push.
pub(super) fn push_along(bodies: [u32; 2], jacobian: [&Vector; 2], push: f64, result: &mut [Vector]) {
    if push == 0.0 {
        return;
    }
    for side in (0..2).filter(|&side| bodies[side] != FIXED) {
        for (entry, row) in result[bodies[side] as usize].iter_mut().zip(jacobian[side]) {
            *entry += row * push;
        }
    }
}

/// Adds the push of a term with these impulses.
pub(super) fn push_term(term: &Term, impulse: [f64; 2], result: &mut [Vector]) {
    for row in 0..term.rows {
        push_along(term.bodies, [&term.jacobian[0][row], &term.jacobian[1][row]], impulse[row], result);
    }
}
