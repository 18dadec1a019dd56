//! How the bodies of an island fall.
//!
//! A substep moves bodies by the velocities at its end, which have gained the whole substep's acceleration a h: a body that nothing presses
//! is put back by ½ a h², onto its parabola, and one that is pressed is not. No row sees the difference, for it is not one of
//! velocities. So a body that comes to touch a pressed one, but for that way, goes on as that does. And where nothing that presses or holds
//! stands, all are put back by the same way: the island falls as a single body would.

use glam::DVec3;

use super::patch::Patch;
use super::problem::{Problem, speed};
use super::term::FIXED;
use crate::solve::direct::body::DirectBody;

/// Bodies of an island, their numbers in the problem, and the ends of its joints.
pub(super) struct IslandBodies<'a> {
    pub bodies: &'a [DirectBody],
    pub moved: &'a [u32],
    pub joint_ends: &'a [[usize; 2]],
}

impl IslandBodies<'_> {
    /// Finds the bodies, by their numbers in the problem, that are pressed in a substep of length `h` (s) or go along with one that
    /// is. The acceleration (m/s²) of an island that falls as a whole.
    pub(super) fn find_pressed(&self, problem: &Problem, patches: &[Patch], h: f64, pressed: &mut Vec<bool>) -> Option<DVec3> {
        let Self { bodies, moved, joint_ends } = *self;
        pressed.clear();
        pressed.resize(problem.masses.len(), false);
        let pressing = patches.iter().filter(|patch| patch.presses()).map(|patch| patch.bodies);
        let mut first = None;
        let mut stands = false;
        for body in joint_ends.iter().copied().chain(pressing).flatten() {
            match moved[body] {
                FIXED => stands = true,
                number => {
                    pressed[number as usize] = true;
                    first = first.or(Some(&bodies[body]));
                }
            }
        }
        let first = first?;
        if !stands && self.fall_as(first) {
            return Some(first.acceleration);
        }
        let fall = first.acceleration;
        let difference = 0.5 * fall.length() * h;
        let meets = |[a, b]: [u32; 2], pressed: &[bool]| a != FIXED && b != FIXED && pressed[a as usize] != pressed[b as usize];
        while let Some(term) = problem.terms.iter().find(|term| {
            meets(term.bodies, pressed) && term.is_one_sided() && speed(term, &problem.velocity)[0] + term.bias[0] <= difference
        }) {
            term.bodies.iter().for_each(|&body| pressed[body as usize] = true);
        }
        None
    }

    /// Whether it falls as a single body would where nothing presses.
    pub(super) fn fall_as_one(&self) -> bool {
        let mut led = self.joint_ends.iter().flatten().copied().peekable();
        let Some(&first) = led.peek() else { return true };
        led.all(|body| self.moved[body] != FIXED) && self.fall_as(&self.bodies[first])
    }

    fn fall_as(&self, first: &DirectBody) -> bool {
        let falls_alike =
            |body: &DirectBody| body.acceleration == first.acceleration && body.linear_damping == first.linear_damping;
        self.bodies.iter().all(|body| !body.is_dynamic() || (body.free_axes() == [1.0; 6] && falls_alike(body)))
    }
}
