//! Hinge chains: bodies that hinges with parallel axes connect stay in one plane (Müller et al. 2017, §3.4).
//!
//! Found on the graph of hinges: from each body, hinges whose axes there are parallel within [`PARALLEL`] lead on, so runs, loops and
//! branches are found alike, and a body whose hinges point two ways belongs to two chains. Each member has an axis, the direction of
//! the plane's normal in its own frame, and a *height*, its centre of mass along that axis over the plane (the offsets h of the
//! paper's Fig. 9): at a hinge both sides have the same height,
//!
//! ```text
//! h_B + u_B·p_B = h_A + u_A·p_A,
//! ```
//!
//! p being the joint point from the centre of mass. A hinge that closes a loop at another height, or with its axis the other way
//! round, contradicts the rest: its chain is left to its joints.
//!
//! Paths end at what is fixed. One such end gives the plane; without any, the plane is free.

use crate::tuning::planes::{LEVEL, MIN_HINGES, PARALLEL};
use glam::Vec3;

/// One side of a hinge: its body, and axis and point there, from the centre of mass and in the body's axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HingeEnd {
    /// `None` where nothing can move it.
    pub body: Option<u32>,
    pub axis: Vec3,
    pub point: Vec3,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Hinge {
    pub joint: u32,
    pub ends: [HingeEnd; 2],
}

/// A body in a chain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Member {
    pub body: u32,
    /// Normal of the plane in the body's axes.
    pub axis: Vec3,
    /// Centre of mass over the plane (m).
    pub height: f32,
    /// Joint and side by which the chain came to it.
    pub end: (u32, u8),
}

/// Where a chain's plane is fixed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlaneAnchor {
    /// Joint, and its side that nothing moves.
    pub end: (u32, u8),
    /// Normal along the joint's axis there, or against it.
    pub sign: f32,
    /// The joint's point over the plane (m).
    pub height: f32,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Chain {
    pub members: Vec<Member>,
    pub anchor: Option<PlaneAnchor>,
    /// Its hinges, sorted.
    pub joints: Vec<u32>,
    /// Mean distance from centres of mass to joint points (m).
    pub size: f32,
}

fn parallel(a: Vec3, b: Vec3) -> bool {
    a.cross(b).length_squared() <= PARALLEL * PARALLEL
}

/// All chains of these hinges, which are sorted by joint.
pub(crate) fn find_chains(hinges: &[Hinge]) -> Vec<Chain> {
    let bodies = hinges.iter().flat_map(|hinge| hinge.ends).filter_map(|end| end.body).max().map_or(0, |most| most as usize + 1);
    let mut of_body: Vec<Vec<(usize, usize)>> = vec![Vec::new(); bodies];
    for (number, hinge) in hinges.iter().enumerate() {
        for (side, end) in hinge.ends.iter().enumerate() {
            if let Some(body) = end.body {
                of_body[body as usize].push((number, side));
            }
        }
    }
    let mut used = vec![false; hinges.len()];
    // Place of each body in the chain that is being found.
    let mut place: Vec<Option<usize>> = vec![None; bodies];
    let mut chains = Vec::new();
    for first in 0..hinges.len() {
        let Some(side) = hinges[first].ends.iter().position(|end| end.body.is_some()).filter(|_| !used[first]) else { continue };
        let found = follow(hinges, &of_body, (first, side), &mut used, &mut place);
        chains.extend(found);
    }
    chains
}

/// The chain that one side of a hinge belongs to; `place` is all `None` before and after.
fn follow(
    hinges: &[Hinge],
    of_body: &[Vec<(usize, usize)>],
    (first, side): (usize, usize),
    used: &mut [bool],
    place: &mut [Option<usize>],
) -> Option<Chain> {
    let start = hinges[first].ends[side];
    let body = start.body?;
    let mut chain = Chain::default();
    let (mut count, mut levers, mut farthest, mut level) = (0, 0.0, 0.0_f32, 0.0_f32);
    chain.members.push(Member { body, axis: start.axis, height: 0.0, end: (hinges[first].joint, side as u8) });
    place[body as usize] = Some(0);
    let mut next = 0;
    while next < chain.members.len() {
        let own = chain.members[next];
        next += 1;
        for &(number, side) in &of_body[own.body as usize] {
            let hinge = &hinges[number];
            let (near, far) = (&hinge.ends[side], &hinge.ends[1 - side]);
            if used[number] || !parallel(near.axis, own.axis) {
                continue;
            }
            used[number] = true;
            count += 1;
            chain.joints.push(hinge.joint);
            let sign = near.axis.dot(own.axis).signum();
            let height = own.height + own.axis.dot(near.point);
            farthest = farthest.max(near.point.length()).max(far.point.length());
            levers += near.point.length();
            let Some(other) = far.body else {
                chain.anchor.get_or_insert(PlaneAnchor { end: (hinge.joint, 1 - side as u8), sign, height });
                continue;
            };
            let axis = far.axis * sign;
            let over = height - axis.dot(far.point);
            match place[other as usize] {
                None => {
                    place[other as usize] = Some(chain.members.len());
                    chain.members.push(Member { body: other, axis, height: over, end: (hinge.joint, 1 - side as u8) });
                }
                Some(known) => {
                    let known = &chain.members[known];
                    let crooked = !parallel(known.axis, axis) || known.axis.dot(axis) < 0.0;
                    level = if crooked { f32::INFINITY } else { level.max((known.height - over).abs()) };
                }
            }
        }
    }
    for member in &chain.members {
        place[member.body as usize] = None;
    }
    chain.joints.sort_unstable();
    chain.size = levers / count.max(1) as f32;
    (count >= MIN_HINGES && chain.members.len() >= MIN_HINGES && level <= LEVEL * farthest).then_some(chain)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(body: Option<u32>, axis: Vec3, point: Vec3) -> HingeEnd {
        HingeEnd { body, axis, point }
    }

    /// Links of 0.2 m along x, hinges along z; link i sits `raise(i)` higher than its hinges' plane.
    fn run(count: u32, raise: impl Fn(u32) -> f32, first: Option<u32>) -> Vec<Hinge> {
        let at = |body: Option<u32>, x: f32| end(body, Vec3::Z, Vec3::new(x, 0.0, -body.map_or(0.0, &raise)));
        (0..count)
            .map(|i| Hinge { joint: i, ends: [if i == 0 { at(first, 0.1) } else { at(Some(i), 0.1) }, at(Some(i + 1), -0.1)] })
            .collect()
    }

    #[test]
    fn a_run_with_raised_links_is_one_chain_that_knows_their_heights() {
        let raise = |i: u32| if i == 2 { 0.3 } else { 0.0 };
        let chains = find_chains(&run(5, raise, Some(0)));
        assert_eq!(chains.len(), 1);
        assert_eq!((chains[0].members.len(), chains[0].anchor), (6, None));
        for member in &chains[0].members {
            assert!((member.height - raise(member.body)).abs() < 1e-6, "{member:?}");
        }
    }

    #[test]
    fn an_end_that_nothing_moves_fixes_the_plane() {
        let chains = find_chains(&run(4, |_| 0.0, None));
        assert_eq!(chains.len(), 1);
        let anchor = chains[0].anchor.expect("one end is fixed");
        assert_eq!((anchor.end, anchor.sign), ((0, 0), 1.0));
    }

    #[test]
    fn a_crooked_hinge_parts_chains_and_a_crooked_loop_is_none() {
        let mut hinges = run(8, |_| 0.0, Some(0));
        hinges[3].ends.iter_mut().for_each(|end| end.axis = Vec3::new(0.0, 0.01, 1.0).normalize());
        let chains = find_chains(&hinges);
        assert_eq!(chains.iter().map(|chain| chain.members.len()).collect::<Vec<_>>(), [4, 5]);
        let mut closed = run(5, |_| 0.0, Some(0));
        let last =
            Hinge { joint: 5, ends: [end(Some(5), Vec3::Z, Vec3::X * 0.1), end(Some(0), Vec3::Z, Vec3::new(-0.1, 0.0, 0.05))] };
        closed.push(last);
        assert!(find_chains(&closed).is_empty(), "it ends 5 cm above where it began");
    }
}
