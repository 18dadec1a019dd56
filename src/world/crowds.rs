//! Stage that leaves contacts out of a step in which they cannot close, where there are far more of them than a heap has.
//!
//! Contacts are looked for as far as bodies may come in a step. In a small cloud that flies apart fast that is all of it: each of 400 splinters
//! has a contact with each other, 80,000 in all, of which some hundreds close. Of two free bodies those are left out that would stay apart
//!
//! * as both move now and as what strikes them in this step may speed them up: they bear nothing, unless others that have been struck strike them;
//! * as both move now, where too many would be left. Who is struck may then overlap another, or pass it, by the end of the step; the next one
//!   finds it where it is, and what takes an overlap out adds no speed.

use glam::Vec3;

use super::body_shape_table::BodyShapeTable;
use super::touching_pairs::TouchingPair;
use super::{Collision, World};
use crate::body::Body;
use crate::collide::cache::PairCache;
use crate::collide::pairs::WorldManifold;
use crate::id::{BodyId, Pool};
use crate::tuning::crowds::CROWD;

/// Most that a blow changes a speed by, over how fast the two close and the body's share of their inverse masses.
const REBOUND: f32 = 2.0;

impl World {
    /// Leaves out what stays apart in a step of `dt` (s).
    pub(super) fn thin_out_crowds(&mut self, dt: f32) {
        let Self { collision: Collision { touches, pairs, index, .. }, movers, bodies, def, scratch, .. } = self;
        let most = CROWD * movers.slots.len();
        if touches.len() <= most {
            return;
        }
        let crowd = Crowd { bodies, pairs, index, gravity: def.gravity, dt };
        let blows = &mut scratch.blows;
        blows.clear();
        blows.resize(bodies.slot_count(), 0.0);
        for touch in touches.touching() {
            crowd.note_blow(touch, blows);
        }
        touches.retain(|touch| crowd.keeps(touch, |body| blows[body as usize]));
        if touches.len() > most {
            touches.retain(|touch| crowd.keeps(touch, |_| 0.0));
        }
    }
}

/// What is asked of pairs of a crowd.
struct Crowd<'a> {
    bodies: &'a Pool<Body, BodyId>,
    pairs: &'a PairCache,
    index: &'a BodyShapeTable,
    gravity: Vec3,
    /// Of the step (s).
    dt: f32,
}

impl Crowd<'_> {
    /// Notes how much faster a pair that closes may make each of its bodies.
    fn note_blow(&self, touch: &TouchingPair, blows: &mut [f32]) {
        let [a, b] = touch.bodies.map(|body| self.bodies[body].inverse_mass());
        let (gap, closing) = self.approach(touch);
        if closing <= 0.0 || gap > closing * self.dt || a + b <= 0.0 {
            return;
        }
        for (body, own) in touch.bodies.into_iter().zip([a, b]) {
            let blow = &mut blows[body as usize];
            *blow = blow.max(REBOUND * closing * own / (a + b));
        }
    }

    /// Whether a pair is one that may close where each body is faster by its blow (m/s), or that is not to be judged.
    fn keeps(&self, touch: &TouchingPair, blow: impl Fn(u32) -> f32) -> bool {
        let pair = self.pairs.get(touch.slot);
        if pair.pressed || pair.in_contact || !touch.bodies.iter().all(|&body| is_alone(&self.bodies[body])) {
            return true;
        }
        let (gap, closing) = self.approach(touch);
        let faster: f32 = touch.bodies.into_iter().map(blow).sum();
        gap <= (closing + faster).max(0.0) * self.dt
    }

    /// How far beyond touching a pair is (m), and how fast that closes (m/s), of the point that closes first if both bodies fly on as they do.
    fn approach(&self, touch: &TouchingPair) -> (f32, f32) {
        let pair = self.pairs.get(touch.slot);
        let (a, b) = pair.key.shapes();
        let [a, b] = [a, b].map(|shape| self.index.collider_state(shape));
        let [spin_a, spin_b] = touch.bodies.map(|body| self.bodies[body].angular_velocity);
        let fall = b.falls_against(a, self.gravity, self.dt);
        let margin = a.contact_margin(b);
        let mut first = (f32::INFINITY, 0.0);
        for manifold in pair.manifolds.iter() {
            let world = WorldManifold::of(&manifold, a.frame(), b.frame());
            for (i, point) in manifold.points.iter().enumerate() {
                let turning = spin_b.cross(world.lever_b[i]) - spin_a.cross(world.lever_a[i]);
                let opening = world.normal.dot(b.velocity - a.velocity + turning);
                let (gap, closing) = (point.separation - margin, -opening.min(opening + world.normal.dot(fall)));
                if gap - closing * self.dt < first.0 - first.1 * self.dt {
                    first = (gap, closing);
                }
            }
        }
        first
    }
}

/// Whether a body is moved by contacts and gravity alone.
fn is_alone(body: &Body) -> bool {
    body.is_solved() && body.joints.is_empty() && body.force == Vec3::ZERO && body.torque == Vec3::ZERO
}
