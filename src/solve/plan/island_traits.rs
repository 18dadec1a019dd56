//! What decides an island's solver, and the decision.

use glam::Vec3;

use crate::report::IslandPlan;
use crate::settings::Solver;
use crate::solve::StepSettings;
use crate::solve::contact::ContactInput;
use crate::solve::direct::stiffness::IMPLICIT_RANGE;
use crate::solve::direct::{FRICTION_ROWS, MAX_MANIFOLDS, MAX_RIDERS, are_few};
use crate::solve::joint::JointLink;
use crate::solve::meetings::{may_meet, rebounds, weighs_down};
use crate::solve::stances::Standing;
use crate::solve::state::{BodyMotion, BodyVelocity};
use crate::tuning::plan::{ALIKE, LEANING, TALL};

/// Multiplications that a factorisation takes for each body at least: those of a link at the end of a chain, held at one point.
const LEAST_WORK: u64 = 567;

/// Multiplications that a factor of points takes for each of them at least, where the rows of the joints alone are in it: those of three rows
/// with the three of the next joint, and what three more fill in.
const WORK_OF_POINT: u64 = 189;

/// Factorisations that a substep may always take: with three all scenes tried stay bounded.
pub(crate) const FREE_FACTORS: u32 = 3;

/// Multiplications that a factorisation may take: so many that the factorisations which every substep may take are within the world's budget
/// of a step, or, where sweeps do not bear the load, the one that each needs at rest.
pub(super) fn most_work(settings: &StepSettings, is_pressed: bool) -> u64 {
    let factors = settings.substeps * if is_pressed { 1 } else { FREE_FACTORS };
    (f64::from(settings.articulations.halving_budget) * 1.0e6 / f64::from(factors)) as u64
}

/// What is known of the contacts of an island, and of its bodies that no joint holds.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BorneTraits {
    /// Those bodies.
    pub(super) bodies: u32,
    /// Contacts between two bodies that move.
    pub(super) meetings: u32,
    /// Contacts of the island, and rows of them all.
    pub(super) contacts: u32,
    pub(super) rows: u64,
    /// Whether anything else touches something, or they anything that does not move.
    pub(super) is_more: bool,
    /// Whether something presses that is [`HEAVY`](crate::tuning::plan::HEAVY) times what joints hold against it.
    pub(super) is_heavy: bool,
    /// Whether a joint has a motor that does not give, which may close any gap that contacts were looked for in.
    pub(super) is_driven: bool,
    /// Whether a motor of a joint holds a place, so that loads go through it.
    pub(super) by_motors: bool,
    /// Whether a joint does more than give as a spring does.
    pub(super) is_held: bool,
    /// Whether a joint has springs; whether what joints hold may touch nothing unless they throw it; and by how much they may (√J).
    pub(super) is_sprung: bool,
    pub(super) is_in_reach: bool,
    pub(super) swing: f64,
    /// Whether the bodies of a loop that stands do not move against one another.
    pub(super) is_still: bool,
}

/// What is known of bodies without joints that touch one another.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LooseTraits {
    /// What they stand on and lean against, where that is asked for.
    pub(super) standing: Standing,
    /// Whether any touches something that the host moves, and something that it turns.
    pub(super) is_carried: bool,
    pub(super) is_turned: bool,
    /// Whether any is pushed by something round, or a block, which the host turns by more than [`BATTED`](crate::tuning::plan::BATTED) across the contact.
    pub(super) is_batted: bool,
    /// Whether any contact has pressed.
    pub(super) is_pressed: bool,
    /// Whether all were put where they are and are at rest against one another, with few contacts.
    pub(super) rests: bool,
}

/// What is known of an island.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct IslandTraits {
    /// Its first slot.
    pub(super) first: u32,
    pub(super) bodies: u32,
    pub(super) joints: u32,
    /// Groups of two bodies and more that joints connect, of what may be a heap.
    pub(super) articulations: u32,
    pub(super) loose: LooseTraits,
    pub(super) is_swept: bool,
    /// Whether joints close a loop, through what does not move or without it.
    pub(super) is_looped: bool,
    /// Whether any of its joints is known to bear anything, and whether the force of one turns a body faster than a substep of second
    /// order resolves.
    pub(super) is_loaded: bool,
    pub(super) is_stiff: bool,
    /// What gravity and the host pull its bodies with, all together (N), of a loop that bears nothing yet, and the most that any joint is stiff by for each newton (1/N).
    pub(super) pull: f64,
    pub(super) stiffness: f64,
    /// Whether a joint has stops on angles.
    pub(super) is_limbed: bool,
    /// Whether a joint is with something that rows do not move.
    pub(super) is_anchored: bool,
    /// Whether all joints hold points together and do nothing else.
    pub(super) is_plain: bool,
    /// Least and greatest inverse mass of what moves (1/kg).
    pub(super) inverse_masses: [f32; 2],
    pub(super) touches: bool,
    pub(super) borne: BorneTraits,
    /// Whether what joints hold touches anything that is fixed or moved.
    pub(super) stands: bool,
    pub(super) rebounds: bool,
    /// Most multiplications that a factorisation may take: more where something presses that is [`HEAVY`](crate::tuning::plan::HEAVY) times what joints hold against it.
    pub(super) most_work: u64,
}

impl BorneTraits {
    pub(super) fn of(motions: &[BodyMotion]) -> Self {
        Self { bodies: motions.iter().filter(|motion| is_loose(motion)).count() as u32, ..Self::default() }
    }
}

impl IslandTraits {
    /// Notes what a joint of the island says of it.
    pub(super) fn add_joint(&mut self, link: &JointLink) {
        self.joints += 1;
        self.is_swept |= link.is_withheld || link.traits.solver == Solver::GaussSeidel;
        self.is_plain &= link.traits.is_plain;
        self.is_limbed |= link.traits.limits_angles;
        self.borne.is_held |= !link.traits.gives;
        self.borne.by_motors |= link.traits.holds_by_motor;
        self.borne.is_driven |= link.traits.has_rigid_motor;
        self.borne.is_sprung |= link.traits.has_springs;
    }

    /// Notes what a contact of the island says of it.
    pub(super) fn add_contact(
        &mut self,
        contact: &ContactInput,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        settings: &StepSettings,
    ) {
        let ends = [contact.a, contact.b].map(|slot| &motions[slot as usize]);
        self.borne.contacts += 1;
        self.borne.meetings += u32::from(ends.iter().all(|motion| motion.is_dynamic()));
        self.borne.rows += contact.count as u64 + u64::from(FRICTION_ROWS);
        self.borne.is_more |= !ends.iter().any(|motion| is_loose(motion)) || !ends.iter().all(|motion| motion.is_dynamic());
        for slot in [contact.a, contact.b].map(|slot| slot as usize).into_iter().filter(|&slot| !motions[slot].is_dynamic()) {
            self.loose.is_carried |= velocities[slot].linear != Vec3::ZERO;
            self.loose.is_turned |= velocities[slot].angular != Vec3::ZERO;
        }
        self.loose.is_pressed |= contact.presses();
        let is_driven = self.borne.is_driven || ends.iter().any(|motion| motion.driven);
        let may_meet = || contact.presses() || is_driven || may_meet(contact, (velocities, motions), settings.dt, 0.0);
        if self.joints > 0 && may_meet() {
            self.count_contact(contact, velocities, motions, settings);
        } else {
            self.borne.is_in_reach |= self.borne.is_sprung && ends.iter().any(|motion| motion.jointed);
        }
    }

    /// Notes a contact that may close within the step.
    pub(super) fn count_contact(
        &mut self,
        contact: &ContactInput,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        settings: &StepSettings,
    ) {
        let ends = [contact.a, contact.b].map(|slot| &motions[slot as usize]);
        if ends.iter().any(|motion| motion.jointed) {
            (self.touches, self.stands) = (true, self.stands | ends.iter().any(|motion| !motion.is_dynamic()));
        }
        let is_heavy = weighs_down(contact, velocities, motions);
        self.borne.is_heavy |= is_heavy;
        self.most_work = self.most_work.max(most_work(settings, is_heavy));
        self.rebounds |= rebounds(contact, velocities, settings);
    }

    /// Whether joints close a loop and bear more than a substep resolves. In the first step nobody knows what they bear: it is taken for
    /// all that the bodies are pulled with.
    pub(super) fn is_stiff_loop(&self) -> bool {
        let is_stiff = if self.is_loaded { self.is_stiff } else { self.stiffness * self.pull > IMPLICIT_RANGE.0 };
        self.is_looped && is_stiff
    }

    /// Whether its factor takes more work than the world's budget allows, whatever touches what in it.
    pub(super) fn is_large(&self) -> bool {
        u64::from(self.bodies) * LEAST_WORK > self.most_work
    }

    /// Whether its bodies touch one another in a row, between two that are fixed or moved at most.
    pub(super) fn is_row(&self) -> bool {
        self.joints == 0 && is_row(self.bodies, self.borne.contacts)
    }

    /// Whether what its bodies stand on, or lean against, is asked for.
    pub(super) fn asks_for_stances(&self) -> bool {
        self.joints == 0 && (self.loose.rests || self.is_row())
    }

    /// Whether it is at rest and leans, so that sweeps let it slide and sink. Like rows, not on what turns.
    pub(super) fn leans_at_rest(&self) -> bool {
        self.joints == 0 && self.loose.rests && !self.loose.is_turned && self.loose.standing.leaning >= LEANING
    }

    /// Whether it is a row that sweeps do not hold up: it leans, what it bears would turn it over, or may so at any time, as its ground moves. On
    /// what turns sweeps follow the ground's turn within a step, as one problem does not.
    pub(super) fn is_row_to_solve(&self) -> bool {
        let may_tip = (TALL[0]..=TALL[1]).contains(&self.bodies) && !self.loose.is_turned;
        let would_tip = may_tip && (self.loose.is_carried || self.loose.standing.is_uneven);
        self.is_row() && (would_tip || self.loose.standing.sideways >= LEANING)
    }

    /// Whether it is a few bodies that something batters.
    pub(super) fn is_batted(&self) -> bool {
        self.loose.is_batted && self.bodies <= MAX_RIDERS && self.borne.contacts <= MAX_MANIFOLDS
    }

    /// Whether the least and the greatest mass are within [`ALIKE`], and joints do more than hold points together.
    pub(super) fn is_alike(&self) -> bool {
        let [least, most] = self.inverse_masses;
        !self.is_plain && most <= ALIKE * least
    }

    /// Whether it is one articulation of points, with freedom left, that carries bodies which touch nothing else: contacts beside its joints'
    /// factor are right then, and take less than Newton steps do where they are few for as many joints.
    pub(super) fn is_carrier(&self) -> bool {
        let is_free = 3 * self.joints < 6 * (self.bodies - self.borne.bodies);
        self.may_carry() && is_free && self.articulations == 1
    }

    /// The same, as far as is known without counting articulations.
    pub(super) fn may_carry(&self) -> bool {
        let BorneTraits { bodies, rows, is_more, is_heavy, .. } = self.borne;
        let is_borne = (1..=MAX_RIDERS).contains(&bodies) && self.borne.contacts <= MAX_MANIFOLDS && !is_more && !is_heavy;
        let is_held = self.touches && self.is_plain && self.is_anchored;
        is_borne && is_held && are_few(rows, u64::from(self.joints) * WORK_OF_POINT)
    }

    /// Whether articulations that touch one another are better swept: nothing that is fixed holds them, or there is more to press than to
    /// hold, as in a heap of ragdolls; or a heap out of which springs draw. Where something heavy presses, as a car on its jack, sweeps do not bear it.
    pub(super) fn is_heap(&self) -> bool {
        let is_drawn_from = !self.borne.is_held && self.borne.meetings > self.bodies;
        (self.articulations >= 2 || is_drawn_from) && self.may_be_heap() && !self.borne.is_heavy
    }

    /// The same, as far as is known without counting articulations.
    pub(super) fn may_be_heap(&self) -> bool {
        self.joints > 0 && (!self.is_anchored || self.borne.meetings > self.joints)
    }

    /// Whether its plan depends on what springs throw.
    pub(super) fn asks_for_swing(&self) -> bool {
        self.borne.is_in_reach && !self.touches && !self.is_swept
    }

    /// Whether its plan depends on how many articulations it has.
    pub(super) fn asks_for_groups(&self) -> bool {
        self.may_be_heap() || self.may_carry()
    }

    pub(super) fn plan(&self) -> IslandPlan {
        match self {
            Self { joints: 0, .. }
                if !(self.is_row_to_solve() || self.leans_at_rest() || self.is_batted()) || self.is_large() =>
            {
                IslandPlan::Loose
            }
            Self { joints: 0, .. } => IslandPlan::Coupled,
            Self { is_swept: true, .. } => IslandPlan::Swept,
            Self { touches: false, .. } if !self.is_stiff_loop() => IslandPlan::Apart,
            _ if self.is_large() => IslandPlan::Large,
            // The blow goes through the joints, whatever else is better left to others.
            Self { rebounds: true, .. } => IslandPlan::Coupled,
            _ if self.is_carrier() => IslandPlan::Apart,
            Self { touches: false, .. } if self.is_alike() => IslandPlan::Alike,
            // Sweeps do not bear what is heavy on light links, and one factor a substep does while nothing moves.
            Self { is_looped: true, stands: true, borne: BorneTraits { is_still: true, .. }, .. } => IslandPlan::Coupled,
            _ if self.is_heap() => IslandPlan::Heaped,
            Self { is_anchored: true, .. } | Self { is_looped: true, stands: true, .. } => IslandPlan::Coupled,
            // A foot under limbs that motors hold bears them all, as one under what is rigid.
            Self { borne: BorneTraits { by_motors: true, .. }, .. } => IslandPlan::Coupled,
            Self { is_limbed: true, .. } => IslandPlan::Jointed,
            _ if self.is_alike() => IslandPlan::Alike,
            _ => IslandPlan::Coupled,
        }
    }
}

/// Whether a body moves and no joint holds it.
fn is_loose(motion: &BodyMotion) -> bool {
    motion.is_dynamic() && !motion.jointed
}

/// Whether so many bodies and contacts without joints may be a row between two bodies that are fixed or moved, at most.
pub(super) fn is_row(bodies: u32, contacts: u32) -> bool {
    bodies >= LEANING && (bodies - 1..bodies + 2).contains(&contacts)
}
