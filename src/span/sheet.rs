//! Which graphs are left without derived bounds: sheets and lattices, of which every body hangs on many paths.
//!
//! A bound says what the shortest of a body's paths allows. On a chain or a bridge that is what carries the load; in a sheet load
//! spreads over all paths, and bounds between its bodies come by the dozen for each. In a sheet of 100 × 100 balls they took 14
//! times the time of the sweeps they were to help (482 ms against 34 ms a step) and left gaps of 53 mm after a second, where sweeps
//! alone with 64 substeps leave 16 mm in 189 ms. So what a sheet lacks is better bought as substeps.

use super::graph::Graph;

/// Joints for each moving body from which on a graph is a sheet: 1 in a chain or loop, 1.33 in a ladder, 1.43 in a rope bridge of 112
/// planks, 1.5 in a truss of bars in triangles, 2 in a square net.
const SHEET: f32 = 1.75;

/// Bodies below which a sheet is like any other graph: its bounds are few.
const LEAST_BODIES: u32 = 64;

/// Takes the joints of sheets out of a graph, but for those in which the host asked for bounds of its own.
pub(crate) fn leave_out(graph: &mut Graph, is_asked_for: impl Fn(u32) -> bool) {
    let mut group: Vec<u32> = (0..graph.masses.len() as u32).collect();
    let masses = &graph.masses;
    let moves = |body: &u32| masses.get(*body as usize).is_some_and(|mass| mass.is_finite());
    for link in &graph.links {
        if let [Some(a), Some(b)] = link.bodies.map(|body| body.filter(moves)) {
            let (a, b) = (root(&mut group, a), root(&mut group, b));
            group[a.max(b) as usize] = a.min(b);
        }
    }
    let (mut joints, mut bodies) = (vec![0_u32; group.len()], vec![0_u32; group.len()]);
    let mut asked = vec![false; group.len()];
    let mut seen: Vec<bool> = vec![false; group.len()];
    let own =
        |group: &mut [u32], ends: [Option<u32>; 2]| ends.into_iter().flatten().find(moves).map(|body| root(group, body) as usize);
    for link in &graph.links {
        let Some(own) = own(&mut group, link.bodies) else { continue };
        joints[own] += 1;
        asked[own] |= is_asked_for(link.joint);
        for body in link.bodies.into_iter().flatten().filter(moves) {
            bodies[own] += u32::from(!std::mem::replace(&mut seen[body as usize], true));
        }
    }
    let is_sheet = |own: usize| !asked[own] && bodies[own] >= LEAST_BODIES && joints[own] as f32 >= SHEET * bodies[own] as f32;
    graph.links.retain(|link| own(&mut group, link.bodies).is_none_or(|own| !is_sheet(own)));
}

fn root(group: &mut [u32], mut body: u32) -> u32 {
    while group[body as usize] != body {
        group[body as usize] = group[group[body as usize] as usize];
        body = group[body as usize];
    }
    body
}
