//! Chooses the solver of each island, and gives the reason.

use glam::Vec3;

use super::StepSettings;
use super::contact::ContactInput;
use super::direct::stiffness::IMPLICIT_RANGE;
use super::direct::{FRICTION_ROWS, MAX_MANIFOLDS, MAX_RIDERS, are_few};
use super::forest::{count_groups, join};
use super::joint::JointLink;
use super::meetings::{may_meet, rebounds, weighs_down};
use super::stances::{Stances, Standing, is_slow, rests_sparsely};
use super::state::{BodyMotion, BodyVelocity, WORLD_SLOT};
use crate::report::IslandPlan;
use crate::settings::Solver;
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
fn most_work(settings: &StepSettings, is_pressed: bool) -> u64 {
    let factors = settings.substeps * if is_pressed { 1 } else { FREE_FACTORS };
    (f64::from(settings.articulations.halving_budget) * 1.0e6 / f64::from(factors)) as u64
}

/// What is known of the contacts of an island, and of its bodies that no joint holds.
#[derive(Debug, Clone, Copy, Default)]
struct BorneTraits {
    /// Those bodies.
    bodies: u32,
    /// Contacts between two bodies that move.
    meetings: u32,
    /// Contacts of the island, and rows of them all.
    contacts: u32,
    rows: u64,
    /// Whether anything else touches something, or they anything that does not move.
    is_more: bool,
    /// Whether something presses that is [`HEAVY`] times what joints hold against it.
    is_heavy: bool,
    /// Whether a joint has a motor that does not give, which may close any gap that contacts were looked for in.
    is_driven: bool,
    /// Whether a motor of a joint holds a place, so that loads go through it.
    by_motors: bool,
    /// Whether a joint does more than give as a spring does.
    is_held: bool,
    /// Whether a joint has springs; whether what joints hold may touch nothing unless they throw it; and by how much they may (√J).
    is_sprung: bool,
    is_in_reach: bool,
    swing: f64,
}

/// What is known of bodies without joints that touch one another.
#[derive(Debug, Clone, Copy, Default)]
struct LooseTraits {
    /// What they stand on and lean against, where that is asked for.
    standing: Standing,
    /// Whether any touches something that the host moves, and something that it turns.
    is_carried: bool,
    is_turned: bool,
    /// Whether any contact has pressed.
    is_pressed: bool,
    /// Whether all were put where they are and are at rest against one another, with few contacts.
    rests: bool,
}

/// What is known of an island.
#[derive(Debug, Clone, Copy, Default)]
struct IslandTraits {
    /// Its first slot.
    first: u32,
    bodies: u32,
    joints: u32,
    /// Groups of two bodies and more that joints connect, of what may be a heap.
    articulations: u32,
    loose: LooseTraits,
    is_swept: bool,
    /// Whether joints close a loop, through what does not move or without it.
    is_looped: bool,
    /// Whether any of its joints is known to bear anything, and whether the force of one turns a body faster than a substep of second
    /// order resolves.
    is_loaded: bool,
    is_stiff: bool,
    /// What gravity and the host pull its bodies with, all together (N), of a loop that bears nothing yet, and the most that any joint is stiff by for each newton (1/N).
    pull: f64,
    stiffness: f64,
    /// Whether a joint has stops on angles.
    is_limbed: bool,
    /// Whether a joint is with something that rows do not move.
    is_anchored: bool,
    /// Whether all joints hold points together and do nothing else.
    is_plain: bool,
    /// Least and greatest inverse mass of what moves (1/kg).
    inverse_masses: [f32; 2],
    touches: bool,
    borne: BorneTraits,
    /// Whether what joints hold touches anything that is fixed or moved.
    stands: bool,
    rebounds: bool,
    /// Most multiplications that a factorisation may take: more where something presses that is [`HEAVY`] times what joints hold against it.
    most_work: u64,
}

/// Finds the plan of each island of a batch.
#[derive(Debug, Default)]
pub(crate) struct Planner {
    looks: Vec<IslandTraits>,
    plans: Vec<IslandPlan>,
    /// Lowest slot that joints connect to each, as a forest: what does not move is slot 0.
    tied: Vec<u32>,
    /// The same where joints with what does not move count for nothing, and how many bodies each has.
    grouped: Vec<u32>,
    sizes: Vec<u32>,
    stances: Stances,
}

impl Planner {
    /// Plans of islands that begin with these slots and end before `end`; `is_anchor` says whether an end of a joint is fixed or
    /// moved by the host, and `stiffness` how stiffly a force of 1 N in it turns its bodies in a substep (1/N), and what force it bore last
    /// (N); and `swing` how much its springs may set going (√J).
    pub(crate) fn plan(
        &mut self,
        firsts: &[u32],
        end: u32,
        links: &[JointLink],
        (velocities, motions, contacts): (&[BodyVelocity], &[BodyMotion], &[ContactInput]),
        (is_anchor, stiffness, swing): (
            impl Fn(&JointLink) -> bool,
            impl Fn(&JointLink) -> [f64; 2],
            impl FnMut(&JointLink) -> f64,
        ),
        settings: &StepSettings,
    ) {
        let Self { looks, plans, tied, grouped, sizes, stances } = self;
        looks.clear();
        looks.extend(firsts.iter().enumerate().map(|(number, &first)| {
            let last = firsts.get(number + 1).copied().unwrap_or(end);
            let masses =
                (first..last).map(|slot| velocities[slot as usize].inverse_mass.max_element()).filter(|&mass| mass > 0.0);
            let inverse_masses = masses.fold([f32::INFINITY, 0.0_f32], |[least, most], mass| [least.min(mass), most.max(mass)]);
            IslandTraits {
                first,
                bodies: last - first,
                is_plain: true,
                borne: BorneTraits::of(&motions[first as usize..last as usize]),
                inverse_masses,
                most_work: most_work(settings, false),
                ..IslandTraits::default()
            }
        }));
        tied.clear();
        tied.extend(0..motions.len() as u32);
        let island_of = |slots: [u32; 2]| {
            let slot = slots.into_iter().find(|&slot| motions[slot as usize].is_dynamic())?;
            firsts.partition_point(|&first| first <= slot).checked_sub(1)
        };
        for link in links {
            let slots = [link.a, link.b];
            let Some(look) = island_of(slots).map(|number| &mut looks[number]) else { continue };
            look.joints += 1;
            look.is_swept |= link.is_withheld || link.traits.solver == Solver::GaussSeidel;
            look.is_plain &= link.traits.is_plain;
            look.borne.is_held |= !link.traits.gives;
            look.is_limbed |= link.traits.limits_angles;
            look.borne.by_motors |= link.traits.holds_by_motor;
            look.borne.is_driven |= link.traits.has_rigid_motor;
            look.borne.is_sprung |= link.traits.has_springs;
            let ends = slots.map(|slot| if motions[slot as usize].is_dynamic() { slot } else { 0 });
            look.is_anchored |= ends.contains(&0) && is_anchor(link);
            look.is_looped |= !join(tied, ends);
        }
        // Only of loops that may be solved as one is it asked for: it takes a joint's whole record.
        for link in links {
            let Some(number) = island_of([link.a, link.b]) else { continue };
            let look = &mut looks[number];
            if look.is_looped && !look.is_stiff && !look.is_large() {
                let [stiffness, force] = stiffness(link);
                (look.is_loaded, look.is_stiff) = (look.is_loaded | (force > 0.0), stiffness * force > IMPLICIT_RANGE.0);
                look.stiffness = look.stiffness.max(stiffness);
            }
        }
        for look in looks.iter_mut().filter(|look| look.is_looped && !look.is_loaded) {
            let slots = (look.first..look.first + look.bodies).map(|slot| slot as usize);
            look.pull = slots.map(|slot| motions[slot].pull(&velocities[slot])).sum();
        }
        for contact in contacts {
            if let Some(number) = island_of([contact.a, contact.b]) {
                looks[number].add_contact(contact, velocities, motions, settings);
            }
        }
        find_swings(looks, (links, contacts), (velocities, motions), (island_of, swing), settings);
        count_articulations(looks, links, motions, island_of, (grouped, sizes));
        find_standing(looks, (velocities, motions, contacts), settings, island_of, stances);
        plans.clear();
        plans.extend(looks.iter().map(IslandTraits::plan));
    }

    /// Forgets the islands of the last step.
    pub(crate) fn clear(&mut self) {
        self.looks.clear();
        self.plans.clear();
    }

    /// Whether any island may be one that is not swept, though it has no joints; `contacts` are the slots of each contact's bodies.
    pub(crate) fn may_hold_rows(
        &mut self,
        firsts: &[u32],
        (velocities, motions): (&[BodyVelocity], &[BodyMotion]),
        contacts: impl Iterator<Item = [u32; 2]>,
    ) -> bool {
        let end = velocities.len() as u32;
        let Self { sizes, .. } = self;
        sizes.clear();
        sizes.resize(firsts.len(), 0);
        for [a, b] in contacts {
            // Of the two, what does not move has the first slot of all or one after the last island.
            let slot = if a == WORLD_SLOT || a >= end { b } else { a };
            if let Some(number) = firsts.partition_point(|&first| first <= slot).checked_sub(1) {
                sizes[number] += 1;
            }
        }
        let ends = firsts.iter().skip(1).copied().chain([end]);
        firsts.iter().zip(ends).zip(sizes).any(|((&first, end), &mut contacts)| {
            let slots = first as usize..end as usize;
            is_row(end - first, contacts) || rests_sparsely(&velocities[slots.clone()], &motions[slots], contacts)
        })
    }

    /// First slot, bodies, joints and plan of each island that has joints, or is solved as one without.
    pub(crate) fn told(&self) -> impl Iterator<Item = (u32, u32, u32, IslandPlan)> {
        let islands = self.looks.iter().zip(&self.plans);
        islands
            .filter(|(look, plan)| look.joints > 0 || **plan == IslandPlan::Coupled)
            .map(|(look, &plan)| (look.first, look.bodies, look.joints, plan))
    }

    /// Notes that the factor of the island that begins with this slot takes more work than the budget allows.
    pub(crate) fn enlarge(&mut self, first: u32) {
        let number = self.looks.partition_point(|look| look.first < first);
        self.plans[number] = IslandPlan::Large;
    }

    /// The islands that are to be solved as one problem, by number, whether joints of each close a loop, and the most multiplications that a
    /// factorisation may take.
    pub(crate) fn coupled(&self) -> impl Iterator<Item = (usize, (bool, u64))> {
        let islands = self.plans.iter().zip(&self.looks).enumerate();
        islands
            .filter(|(_, (plan, _))| **plan == IslandPlan::Coupled)
            .map(|(number, (_, look))| (number, (look.is_looped, look.most_work)))
    }
}

impl BorneTraits {
    fn of(motions: &[BodyMotion]) -> Self {
        Self { bodies: motions.iter().filter(|motion| is_loose(motion)).count() as u32, ..Self::default() }
    }
}

impl IslandTraits {
    /// Notes what a contact of the island says of it.
    fn add_contact(
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
    fn count_contact(
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
    fn is_stiff_loop(&self) -> bool {
        let is_stiff = if self.is_loaded { self.is_stiff } else { self.stiffness * self.pull > IMPLICIT_RANGE.0 };
        self.is_looped && is_stiff
    }

    /// Whether its factor takes more work than the world's budget allows, whatever touches what in it.
    fn is_large(&self) -> bool {
        u64::from(self.bodies) * LEAST_WORK > self.most_work
    }

    /// Whether its bodies touch one another in a row, between two that are fixed or moved at most.
    fn is_row(&self) -> bool {
        self.joints == 0 && is_row(self.bodies, self.borne.contacts)
    }

    /// Whether what its bodies stand on, or lean against, is asked for.
    fn asks_for_stances(&self) -> bool {
        self.joints == 0 && (self.loose.rests || self.is_row())
    }

    /// Whether it is at rest and leans, so that sweeps let it slide and sink. Like rows, not on what turns.
    fn leans_at_rest(&self) -> bool {
        self.joints == 0 && self.loose.rests && !self.loose.is_turned && self.loose.standing.leaning >= LEANING
    }

    /// Whether it is a row that sweeps do not hold up: it leans, what it bears would turn it over, or may so at any time, as its ground moves. On
    /// what turns sweeps follow the ground's turn within a step, as one problem does not.
    fn is_row_to_solve(&self) -> bool {
        let may_tip = (TALL[0]..=TALL[1]).contains(&self.bodies) && !self.loose.is_turned;
        let would_tip = may_tip && (self.loose.is_carried || self.loose.standing.is_uneven);
        self.is_row() && (would_tip || self.loose.standing.sideways >= LEANING)
    }

    /// Whether the least and the greatest mass are within [`ALIKE`], and joints do more than hold points together.
    fn is_alike(&self) -> bool {
        let [least, most] = self.inverse_masses;
        !self.is_plain && most <= ALIKE * least
    }

    /// Whether it is one articulation of points, with freedom left, that carries bodies which touch nothing else: contacts beside its joints'
    /// factor are right then, and take less than Newton steps do where they are few for as many joints.
    fn is_carrier(&self) -> bool {
        let is_free = 3 * self.joints < 6 * (self.bodies - self.borne.bodies);
        self.may_carry() && is_free && self.articulations == 1
    }

    /// The same, as far as is known without counting articulations.
    fn may_carry(&self) -> bool {
        let BorneTraits { bodies, rows, is_more, is_heavy, .. } = self.borne;
        let is_borne = (1..=MAX_RIDERS).contains(&bodies) && self.borne.contacts <= MAX_MANIFOLDS && !is_more && !is_heavy;
        let is_held = self.touches && self.is_plain && self.is_anchored;
        is_borne && is_held && are_few(rows, u64::from(self.joints) * WORK_OF_POINT)
    }

    /// Whether articulations that touch one another are better swept: nothing that is fixed holds them, or there is more to press than to
    /// hold, as in a heap of ragdolls; or a heap out of which springs draw. Where something heavy presses, as a car on its jack, sweeps do not bear it.
    fn is_heap(&self) -> bool {
        let is_drawn_from = !self.borne.is_held && self.borne.meetings > self.bodies;
        (self.articulations >= 2 || is_drawn_from) && self.may_be_heap() && !self.borne.is_heavy
    }

    /// The same, as far as is known without counting articulations.
    fn may_be_heap(&self) -> bool {
        self.joints > 0 && (!self.is_anchored || self.borne.meetings > self.joints)
    }

    /// Whether its plan depends on what springs throw.
    fn asks_for_swing(&self) -> bool {
        self.borne.is_in_reach && !self.touches && !self.is_swept
    }

    /// Whether its plan depends on how many articulations it has.
    fn asks_for_groups(&self) -> bool {
        self.may_be_heap() || self.may_carry()
    }

    fn plan(&self) -> IslandPlan {
        match self {
            Self { joints: 0, .. } if !(self.is_row_to_solve() || self.leans_at_rest()) || self.is_large() => IslandPlan::Loose,
            Self { joints: 0, .. } => IslandPlan::Coupled,
            Self { is_swept: true, .. } => IslandPlan::Swept,
            Self { touches: false, .. } if !self.is_stiff_loop() => IslandPlan::Apart,
            _ if self.is_large() => IslandPlan::Large,
            // The blow goes through the joints, whatever else is better left to others.
            Self { rebounds: true, .. } => IslandPlan::Coupled,
            _ if self.is_carrier() => IslandPlan::Apart,
            Self { touches: false, .. } if self.is_alike() => IslandPlan::Alike,
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

/// Counts contacts that close if springs throw what joints hold, where else it touches nothing: a spring that is drawn, and at rest, has no speed
/// yet. `island_of` is the island of two slots.
fn find_swings(
    looks: &mut [IslandTraits],
    (links, contacts): (&[JointLink], &[ContactInput]),
    (velocities, motions): (&[BodyVelocity], &[BodyMotion]),
    (island_of, mut swing): (impl Fn([u32; 2]) -> Option<usize>, impl FnMut(&JointLink) -> f64),
    settings: &StepSettings,
) {
    if !looks.iter().any(IslandTraits::asks_for_swing) {
        return;
    }
    for link in links.iter().filter(|link| link.traits.has_springs) {
        if let Some(number) = island_of([link.a, link.b]).filter(|&number| looks[number].asks_for_swing()) {
            looks[number].borne.swing += swing(link);
        }
    }
    for contact in contacts {
        let Some(number) = island_of([contact.a, contact.b]) else { continue };
        let look = &mut looks[number];
        let swing = look.borne.swing as f32;
        if swing > 0.0 && may_meet(contact, (velocities, motions), settings.dt, swing) {
            look.count_contact(contact, velocities, motions, settings);
        }
    }
}

/// Counts the articulations of each island whose plan depends on it; `island_of` is the island of two slots.
fn count_articulations(
    looks: &mut [IslandTraits],
    links: &[JointLink],
    motions: &[BodyMotion],
    island_of: impl Fn([u32; 2]) -> Option<usize>,
    (grouped, sizes): (&mut Vec<u32>, &mut Vec<u32>),
) {
    if !looks.iter().any(IslandTraits::asks_for_groups) {
        return;
    }
    grouped.clear();
    grouped.extend(0..motions.len() as u32);
    for link in links {
        let slots = [link.a, link.b];
        let moves = slots.iter().all(|&slot| motions[slot as usize].is_dynamic());
        if moves && island_of(slots).is_some_and(|number| looks[number].asks_for_groups()) {
            join(grouped, slots);
        }
    }
    for look in looks.iter_mut().filter(|look| look.asks_for_groups()) {
        look.articulations = count_groups(grouped, look.first..look.first + look.bodies, sizes);
    }
}

/// Whether so many bodies and contacts without joints may be a row between two bodies that are fixed or moved, at most.
fn is_row(bodies: u32, contacts: u32) -> bool {
    bodies >= LEANING && (bodies - 1..bodies + 2).contains(&contacts)
}

/// Finds what bodies without joints stand on and lean against, where the plan depends on it; `island_of` is the island of two slots.
fn find_standing(
    looks: &mut [IslandTraits],
    (velocities, motions, contacts): (&[BodyVelocity], &[BodyMotion], &[ContactInput]),
    settings: &StepSettings,
    island_of: impl Fn([u32; 2]) -> Option<usize>,
    stances: &mut Stances,
) {
    for look in looks.iter_mut().filter(|look| look.joints == 0) {
        let slots = look.first as usize..(look.first + look.bodies) as usize;
        // What falls together rests against one another, too.
        let may_bear = look.loose.is_pressed || is_slow(&velocities[slots.start], Vec3::ZERO);
        look.loose.rests = may_bear && rests_sparsely(&velocities[slots.clone()], &motions[slots], look.borne.contacts);
    }
    if looks.iter().any(IslandTraits::asks_for_stances) {
        let asks =
            |contact: &&ContactInput| island_of([contact.a, contact.b]).is_some_and(|number| looks[number].asks_for_stances());
        let asks_for_loads = looks.iter().any(IslandTraits::is_row);
        stances.find(motions.len(), contacts.iter().filter(asks), settings.gravity, asks_for_loads);
        for look in looks.iter_mut().filter(|look| look.asks_for_stances()) {
            look.loose.standing = stances.of(look.first..look.first + look.bodies);
            look.most_work = most_work(settings, look.leans_at_rest());
        }
    }
}
