//! Classifies bodies by how they load the joint graph: long-range bounds are derived where weight stretches a structure.

use super::graph::JointGraph;
use crate::tuning::bounds::{HEAVY_SHARE, STRAIGHTENING_SHARE};

/// Connected bodies, by how they are held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LoadClass {
    /// Held by one attachment: its bounds are for every body, and nothing else is needed.
    SingleAttachment,
    /// Held by one attachment, in a chain that nothing heavy keeps straight. While it swings it hangs in a bend, where no straight
    /// line from the attachment is taut, so its bodies get bounds between them too.
    SaggingChain,
    /// Free or held in more than one place, and of at least a tenth of the greatest mass around, or with something on it that is lighter than a
    /// tenth of it: at the end of a rope.
    Heavy,
    /// Lighter than that.
    Light,
}

/// Says for each body what it counts as.
pub(crate) fn weigh(graph: &JointGraph) -> Vec<LoadClass> {
    let mut weights = vec![LoadClass::Light; graph.masses.len()];
    let mut seen = vec![false; graph.masses.len()];
    let mut members = Vec::new();
    for start in 0..graph.masses.len() as u32 {
        if seen[start as usize] || !graph.masses[start as usize].is_finite() || graph.ends_on(start).is_empty() {
            continue;
        }
        members.clear();
        members.push(start);
        seen[start as usize] = true;
        let (mut attachments, mut greatest, mut total, mut next) = (0, 0.0_f32, 0.0, 0);
        let mut is_chain = true;
        while let Some(&body) = members.get(next) {
            next += 1;
            greatest = greatest.max(graph.masses[body as usize]);
            total += graph.masses[body as usize];
            is_chain &= graph.ends_on(body).iter().filter(|end| graph.dynamic_body(end.other()).is_some()).count() <= 2;
            for end in graph.ends_on(body) {
                match graph.dynamic_body(end.other()) {
                    None => attachments += 1,
                    Some(other) if !seen[other as usize] => {
                        seen[other as usize] = true;
                        members.push(other);
                    }
                    Some(_) => {}
                }
            }
        }
        for &body in &members {
            weights[body as usize] = if attachments == 1 && is_chain && greatest < STRAIGHTENING_SHARE * total {
                LoadClass::SaggingChain
            } else if attachments == 1 {
                LoadClass::SingleAttachment
            } else if graph.masses[body as usize] >= HEAVY_SHARE * greatest
                || graph.ends_on(body).iter().any(|&end| graph.holds_like_fixed(end))
            {
                LoadClass::Heavy
            } else {
                LoadClass::Light
            };
        }
    }
    weights
}
