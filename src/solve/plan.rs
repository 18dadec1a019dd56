//! Chooses the solver of each island, and gives the reason.

mod find;
mod island_traits;

use self::find::{count_articulations, find_standing, find_still, find_swings};
pub(crate) use self::island_traits::FREE_FACTORS;
use self::island_traits::{BorneTraits, IslandTraits, is_row, most_work};
use super::StepSettings;
use super::contact::ContactInput;
use super::direct::stiffness::IMPLICIT_RANGE;
use super::forest::join;
use super::joint::JointLink;
use super::meetings::is_batted;
use super::stances::{Stances, rests_sparsely};
use super::state::{BodyMotion, BodyVelocity, WORLD_SLOT};
use crate::report::IslandPlan;

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
    /// (N); `swing` how much its springs may set going (√J), and `is_on_block` whether one side of the contact of this number is round and the other a block.
    pub(crate) fn plan(
        &mut self,
        firsts: &[u32],
        end: u32,
        links: &[JointLink],
        (velocities, motions, contacts): (&[BodyVelocity], &[BodyMotion], &[ContactInput]),
        (is_anchor, stiffness, swing, is_on_block): (
            impl Fn(&JointLink) -> bool,
            impl Fn(&JointLink) -> [f64; 2],
            impl FnMut(&JointLink) -> f64,
            impl Fn(u32) -> bool,
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
            look.add_joint(link);
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
        for (place, contact) in (0..).zip(contacts) {
            if let Some(number) = island_of([contact.a, contact.b]) {
                looks[number].add_contact(contact, velocities, motions, settings);
                let look = &mut looks[number];
                if look.joints == 0 && !look.loose.is_batted && is_batted(contact, velocities, settings.dt) {
                    look.loose.is_batted = is_on_block(place);
                }
            }
        }
        find_still(looks, (velocities, motions), settings.dt);
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
