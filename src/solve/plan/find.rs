//! Finds what the plan of some islands depends on, once their joints and contacts have been counted.

use glam::Vec3;

use super::island_traits::{IslandTraits, most_work};
use crate::solve::StepSettings;
use crate::solve::contact::ContactInput;
use crate::solve::forest::{count_groups, join};
use crate::solve::joint::JointLink;
use crate::solve::meetings::may_meet;
use crate::solve::stances::{Stances, is_slow, rests_sparsely};
use crate::solve::state::{BodyMotion, BodyVelocity};

/// Finds whether what stands with loops moves as a whole at most: whether its bodies have no more energy of motion against the mean of all than
/// what pulls them gives them in a step of `dt` (s) from rest, Σ ½ m (a dt)². What lands has none yet, and of what stands the errors of a step are less;
/// a vehicle on tracks of a fifth of its mass has as much at twice the speed that gravity gives in a step.
pub(super) fn find_still(looks: &mut [IslandTraits], (velocities, motions): (&[BodyVelocity], &[BodyMotion]), dt: f32) {
    for look in looks.iter_mut().filter(|look| look.is_looped && look.stands) {
        let slots = look.first as usize..(look.first + look.bodies) as usize;
        let (mut mass, mut momentum, mut energy, mut pull) = (0.0, Vec3::ZERO, 0.0, 0.0);
        for (velocity, motion) in velocities[slots.clone()].iter().zip(&motions[slots]) {
            let ease = velocity.inverse_mass.max_element();
            let own = if ease > 0.0 { 1.0 / ease } else { 0.0 };
            (mass, momentum) = (mass + own, momentum + velocity.linear * own);
            energy += own * velocity.linear.length_squared();
            pull += own * (motion.acceleration * dt).length_squared();
        }
        look.borne.is_still = mass > 0.0 && energy - momentum.length_squared() / mass <= pull;
    }
}

/// Counts contacts that close if springs throw what joints hold, where else it touches nothing: a spring that is drawn, and at rest, has no speed
/// yet. `island_of` is the island of two slots.
pub(super) fn find_swings(
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
pub(super) fn count_articulations(
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

/// Finds what bodies without joints stand on and lean against, where the plan depends on it; `island_of` is the island of two slots.
pub(super) fn find_standing(
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
