//! Contact manifolds at the poses in which two shapes will press, not at those in which the step begins.
//!
//! The solver has one normal and one lever for each point and step. Those of the step's start are of a pose in which a moving pair will
//! never touch: what passes by a corner is pushed off by a face, and what rolls through a bowl is pushed by the slope that it leaves. So a
//! pair that moves is collided in the pose that it will have after a time t, and what is found is put back to the start: levers and normals
//! keep the directions that they have then, and separations are those from which the bodies' velocities lead to what was found,
//!
//! ```text
//! s₀ = s − t n·(v_B + ω_B×r_B − v_A − ω_A×r_A).
//! ```
//!
//! At constant velocity a row then acts only where its features overlap at t. Bodies in joints are taken as they stand: blows on swept joints
//! come out otherwise there. But what is round, and goes far over them before it touches, is followed: from where it was its normal would be that
//! of an edge. Nor is a pair followed that the planes found at the start keep apart through the step.
//!
//! Flat faces that press are taken as they lie: their normal is the same all along, and stacks stand on points that stay. Those that do not
//! press are followed to see whether they meet at all, and along which normal: a block that flies past an edge does not, and one that
//! slides onto the next tile meets its top, not its side.
//!
//! * A pair that is not pressed is followed until it overlaps, or else to the end of the step.
//! * A pair that carries load presses all through the step. With n substeps the constraint acts on positions after h, 2h, … nh, in the
//!   mean after (n+1)/(2n) dt, and the normal that does no work on the mean of a step is that of (n−1)/(2n) dt: energy in a bowl of radius
//!   R grows at a rate g/R dt (1 − (n+1)/(2n) − φ) if the normal is that of φ dt.

use glam::{Quat, Vec3};
use parry3d::math::Pose3;

use super::collider_state::{ColliderState, Follow};
use super::found_contacts::{FoundContacts, nearest_of};
use super::motion_ahead::{applied, turned};
use super::narrow::Manifold;
use super::persistent_manifold::Manifolds;
use super::round_features::swung;
use crate::shape::{Geometry, Shape};

/// Way ahead below which the pose at the step's start is as good, over the lesser least extent of the two: less than manifolds are kept for.
const NO_MOTION: f32 = 5.0e-4;

/// The same of what presses and is round: what is pushed where it has been rolls on by itself as fast as this.
const NO_ROLL: f32 = 1.0e-5;

/// Cosine between two normals of flat faces below which they are not those of one face.
const ANOTHER_NORMAL: f32 = 0.9;

/// How far surfaces may lie apart and still be flush, over the lesser least extent of what moves and what it moves over: eight times the
/// overlap at which bodies rest, and a step that nobody sees.
pub(crate) const FLUSH: f32 = 2.0e-3;

/// Stride at which a pair that may meet is looked at, over the lesser least extent: whatever overlaps does so for at least two strides,
/// and the axis of least overlap is still that of the surface that was met.
pub(super) const STRIDE: f32 = 0.25;

/// Way in a step from which on what joints hold is followed to where something round without joints meets it, over the lesser least extent: from less far
/// off the normal is that of what is met, but for what passes an edge.
const SWIFT: f32 = STRIDE;

/// Strides up to which all are taken; a longer way is walked by the distances found.
const FEW_STRIDES: f32 = 2.0;

/// Least way walked on at once, and so the deepest overlap that a pair is stopped in, over the lesser least extent.
const MIN_STRIDE: f32 = 0.05;

/// Overlap at which two round shapes are taken to touch first, over the lesser least extent, and looks for that: two balls that hit each other half way
/// off centre are pushed along a line 0.1 degrees beside that of their centres then.
const TOUCH: f32 = 1.0e-3;
const MAX_TOUCH_LOOKS: u32 = 4;

/// Looks at a pair in a step after which it is taken as it is.
const MAX_LOOKS: u32 = 64;

/// How far ahead a pair that carries load is looked at without more ado, over the lesser least extent.
const PRESSED_STRIDE: f32 = 0.05;

/// How far the surface that a loaded pair will press may lie beside the one that it presses now, over the lesser least extent. Where a body
/// goes over a ball or an edge, that is how deep it can sink in: without a bound 8 mm on a ball of 0.5 m at 10 m/s.
const SAGITTA: f32 = 2.0e-3;

/// Two shapes in a step.
#[derive(Clone, Copy)]
pub(super) struct PairApproach<'a> {
    pub(super) a: &'a ColliderState,
    pub(super) b: &'a ColliderState,
    /// Angular velocities of their bodies in the frames of the shapes (rad/s).
    spins: [Vec3; 2],
    /// Angular velocities of their bodies (rad/s, world axes), and whether the host turns them.
    angular: [Vec3; 2],
    is_turned: [bool; 2],
    pub(super) step: Step,
}

/// How far apart two shapes are looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach<'a> {
    /// How far they can move against each other in the step (m).
    pub motion: f32,
    /// Separation up to which points are wanted (m).
    pub margin: f32,
    /// Whether the pair carries load.
    pub is_pressed: bool,
    /// Manifolds of the last step.
    pub before: &'a Manifolds,
}

impl Reach<'_> {
    /// Whether the pair carries no load, one side is free of joints, and the two may go far: where they come to lie is not seen from the start then.
    fn is_swift(&self, [of_a, of_b]: [&Follow; 2], extent: f32) -> bool {
        let is_held = self.is_pressed || of_a.is_jointed && of_b.is_jointed;
        !is_held && self.motion > SWIFT * extent
    }

    /// Whether the pair carries load along a normal: where a face has just come over an edge, the least overlap may be that of its side.
    fn is_pressed_along(&self, normal: Option<Vec3>) -> bool {
        let is_known = |normal: Vec3| self.before.iter().any(|manifold| manifold.normal.dot(normal) >= ANOTHER_NORMAL);
        self.is_pressed && normal.is_none_or(is_known)
    }
}

/// What the manifolds of all pairs in a step have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub dt: f32,
    pub substeps: u32,
    /// Acceleration of free fall (m/s²).
    pub gravity: Vec3,
}

/// Whether either shape has no flat face: which face of two meets is seen where they overlap, and not where they only touch.
fn touches_at_points(shapes: [&Shape; 2]) -> bool {
    shapes.iter().any(|shape| matches!(shape.geometry(), Geometry::Ball { .. } | Geometry::Capsule { .. }))
}

/// Makes the manifolds of two shapes; `start` is the pose of B in A's frame now.
pub(super) fn collide(
    (a, b): (&ColliderState, &ColliderState),
    [of_a, of_b]: &[Follow; 2],
    step: Step,
    start: Pose3,
    mut reach: Reach,
    found: &mut FoundContacts,
) {
    let shapes = [of_a.shape, of_b.shape];
    let is_jointed = of_a.is_jointed || of_b.is_jointed;
    let is_round = a.is_round || b.is_round;
    // What cannot be pushed does not tip over on what is round, which touches it at one point then.
    let turn = |of: &Follow, other: &Follow| if other.is_free { of.angular.length() * step.dt } else { f32::INFINITY };
    found.scratch.turns = [turn(of_a, of_b), turn(of_b, of_a)];
    let is_held = is_jointed && !(is_round && reach.is_swift([of_a, of_b], a.least_extent.min(b.least_extent)));
    if is_jointed || !is_round || !reach.is_pressed {
        found.collide(shapes, start, reach.margin);
        let nearest = found.nearest();
        // What cannot meet in this step has no row, but the rim of a surface says nothing of what is not over it yet.
        let is_open = is_round && found.manifolds.is_empty() && shapes.iter().any(|shape| !shape.geometry().is_solid());
        // Flat faces that press are taken as they lie.
        let is_settled = !is_round && reach.is_pressed_along(found.nearest_normal());
        if is_held && !reach.is_pressed && nearest > 0.0 && [of_a, of_b].iter().any(|of| of.is_free_and_turns(step.dt)) {
            let spins = [a.rotation.conjugate() * of_a.angular, b.rotation.conjugate() * of_b.angular];
            let approach = PairApproach { a, b, spins, angular: [of_a.angular, of_b.angular], is_turned: [false; 2], step };
            approach.leave_what_passes_by(shapes, nearest, reach.margin, found);
        }
        if is_held || is_settled || (nearest > reach.motion && !is_open) {
            return;
        }
    }
    // Of what presses, flat faces come here only where they meet anew.
    reach.is_pressed &= is_round;
    let is_turned = [of_a, of_b].map(|of| of.is_driven && of.angular != Vec3::ZERO);
    let is_swung = if reach.is_pressed { swung((a, b), &[*of_a, *of_b], step.gravity, step.dt) } else { [false; 2] };
    let spin_of = |(state, of): (&ColliderState, &Follow), other: &Shape, is_swung: bool| {
        let stays = is_swung || state.turns_in_itself(of.shape, other);
        if stays { Vec3::ZERO } else { state.rotation.conjugate() * of.angular }
    };
    let spins = [spin_of((a, of_a), of_b.shape, is_swung[0]), spin_of((b, of_b), of_a.shape, is_swung[1])];
    let approach = PairApproach { a, b, spins, angular: [of_a.angular, of_b.angular], is_turned, step };
    let is_followed = match is_round {
        true => reach.is_pressed || found.manifolds.is_empty() || approach.may_meet(found),
        false => approach.would_press(found),
    };
    if is_followed {
        approach.collide(shapes, start, reach, found);
    }
}

impl PairApproach<'_> {
    /// Collides the two as they will stand; of a pair that carries no load, what there is at the start has been found.
    fn collide(&self, shapes: [&Shape; 2], start: Pose3, reach: Reach, found: &mut FoundContacts) {
        let Reach { margin, mut is_pressed, .. } = reach;
        // A surface has no thickness that could be passed.
        let thickness = |shape: &Shape, collider_state: &ColliderState| {
            if shape.geometry().is_solid() { collider_state.least_extent } else { f32::INFINITY }
        };
        let extent = thickness(shapes[0], self.a).min(thickness(shapes[1], self.b));
        let path = self.path();
        let n = self.step.substeps as f32;
        let ahead = if is_pressed { 0.5 * (n - 1.0) / n } else { 1.0 };
        // Written so that what has no extent or no end is taken as it is.
        let moves = ahead * path > extent * if is_pressed { NO_ROLL } else { NO_MOTION };
        if !moves {
            if is_pressed {
                found.collide(shapes, start, margin);
            }
            return;
        }
        let put_back = |found: &mut FoundContacts, share: f32, turns: [Quat; 2]| {
            found.manifolds.iter_mut().for_each(|manifold| self.put_back(manifold, share * self.step.dt, turns));
        };
        let is_far = ahead * path > PRESSED_STRIDE * extent;
        if is_pressed && is_far {
            found.collide(shapes, start, margin);
            // What has rebounded from a surface carries no load any more, and passes the triangles around: it is to meet what comes next anew. What
            // falls back within the step is loaded soon.
            let is_surface = shapes.iter().any(|shape| !shape.geometry().is_solid());
            let fall = 0.5 * self.step.dt * self.b.falls_against(self.a, self.step.gravity, self.step.dt).length();
            is_pressed = !is_surface || found.nearest() <= FLUSH * extent + fall;
        }
        if is_pressed {
            let (share, turns) = self.look_ahead(shapes, (ahead, extent / path), margin, found);
            let apart = found.apart_by(NO_MOTION * extent);
            put_back(found, share, turns);
            self.follow_parts(shapes, (extent / path, apart), 0.0, &reach, found);
        } else if self.a.is_round || self.b.is_round {
            let began = found.nearest();
            let began_apart = began > 0.0;
            let (share, turns) = self.follow(shapes, extent, (path, 1.0), margin, found);
            let (share, turns) = match touches_at_points(shapes) && self.a.is_round && self.b.is_round {
                true => self.first_touch(shapes, (began, extent), (share, turns), margin, found),
                false => (share, turns),
            };
            let met = if found.nearest() < 0.0 { found.nearest_normal() } else { None };
            let (mut apart, mut kept) = (0_u128, 0);
            found.manifolds.retain_mut(|manifold| {
                let nearest = nearest_of(manifold);
                self.put_back(manifold, share * self.step.dt, turns);
                // What is apart at both ends of its way, beside or behind the other at last, has passed no such plane: it began on the far side
                // of it. What rebounds from something else would be kept there.
                let stays = !(began_apart && nearest >= 0.0 && nearest_of(manifold) < -FLUSH * extent);
                if stays && kept < u128::BITS {
                    apart |= u128::from(nearest > NO_MOTION * extent) << kept;
                    kept += 1;
                }
                stays
            });
            if let Some(met) = met {
                let normal = self.a.rotation * applied(turns[0], met);
                self.follow_other_parts(shapes, (extent / path, apart), (share, normal), &reach, found);
            }
        } else {
            let now = found.nearest_normal();
            std::mem::swap(found.manifolds, found.spare);
            let (share, turns) = self.follow_faces(shapes, extent, path, margin, found);
            let (then, is_met) = (found.nearest_normal(), found.nearest() < 0.0);
            put_back(found, share, turns);
            // Faces that meet are taken as they stand, with the points that they have in the steps to come, unless that is along another
            // normal, along which they are flush: then they slide onto each other.
            let slides = found.nearest() >= -FLUSH * extent
                && now.zip(then).is_some_and(|(now, then)| now.dot(turns[0] * then) < ANOTHER_NORMAL);
            if is_met && !slides {
                std::mem::swap(found.manifolds, found.spare);
            }
        }
    }

    /// Whether the planes that keep apart what has been found at the start may be passed in the step.
    fn may_meet(&self, found: &FoundContacts) -> bool {
        let turning = self.turning();
        let before = self.a.velocity - self.b.velocity;
        let after = before - self.b.falls_against(self.a, self.step.gravity, self.step.dt);
        found.manifolds.iter().any(|manifold| {
            let normal = self.a.rotation * manifold.normal;
            let speed = normal.dot(before).max(normal.dot(after)) + turning;
            nearest_of(manifold) < speed * self.step.dt
        })
    }

    /// Whether a point that has been found at the start would overlap by the end of the step, or nearly.
    fn would_press(&self, found: &FoundContacts) -> bool {
        let nearly = NO_MOTION * self.a.least_extent.min(self.b.least_extent);
        found.manifolds.iter().any(|manifold| {
            let mut then = *manifold;
            self.put_back(&mut then, -self.step.dt, [Quat::IDENTITY; 2]);
            nearest_of(&then) < nearly
        })
    }

    /// How far the two move against each other at most (m), forces of the step left out.
    pub(super) fn path(&self) -> f32 {
        let turning = self.turning();
        ((self.b.velocity - self.a.velocity).length() + turning) * self.step.dt
    }

    /// Speed at which their surfaces go where they were not, by turning (m/s).
    fn turning(&self) -> f32 {
        let speed =
            |collider_state: &ColliderState, spin: Vec3| if spin == Vec3::ZERO { 0.0 } else { collider_state.sweep_speed(spin) };
        speed(self.a, self.spins[0]) + speed(self.b, self.spins[1])
    }

    /// Looks at a loaded pair so far ahead, or less far if its surfaces bend; `short` is the share of the step in which it moves by the
    /// lesser least extent. Of what goes far, the manifolds at the start have been found. Share of the step, and how both are turned then.
    fn look_ahead(
        &self,
        shapes: [&Shape; 2],
        (ahead, short): (f32, f32),
        margin: f32,
        found: &mut FoundContacts,
    ) -> (f32, [Quat; 2]) {
        let near = ahead.min(PRESSED_STRIDE * short);
        let far = ahead.min(STRIDE * short);
        if far > near {
            let now = found.nearest_normal().map(|normal| self.a.rotation * normal);
            let turns = self.look(shapes, far, margin, found);
            let then = found.nearest_normal().map(|normal| self.a.rotation * applied(turns[0], normal));
            if let (Some(now), Some(then)) = (now, then)
                && 0.5 * (then - now).length() * far <= SAGITTA * short
            {
                return (far, turns);
            }
        }
        (near, self.look(shapes, near, margin, found))
    }

    /// Collides the two after a share of the step; how both are turned then, in their own frames.
    pub(super) fn look(&self, shapes: [&Shape; 2], share: f32, margin: f32, found: &mut FoundContacts) -> [Quat; 2] {
        let t = share * self.step.dt;
        let turns = self.spins.map(|spin| turned(spin, t));
        let ((shift_a, turn_a), (shift_b, turn_b)) = (self.a.after(turns[0], t), self.b.after(turns[1], t));
        let inverse = turn_a.conjugate();
        let between = (self.b.position - self.a.position).as_vec3() + (shift_b - shift_a);
        let pose = Pose3::from_parts(inverse * between, inverse * turn_b);
        found.collide(shapes, pose, margin);
        turns
    }

    /// Share of the step after which two flat shapes overlap so far that it can be seen along which normal, or all of it where they do not.
    fn follow_faces(
        &self,
        shapes: [&Shape; 2],
        extent: f32,
        path: f32,
        margin: f32,
        found: &mut FoundContacts,
    ) -> (f32, [Quat; 2]) {
        // What only just meets at the end of the step is followed on, too.
        let end = 1.0 + NO_MOTION * extent / path;
        let (share, turns) = self.follow(shapes, extent, (path, end), margin, found);
        if found.nearest() >= 0.0 {
            return (share, turns);
        }
        let share = share + MIN_STRIDE * extent / path;
        (share, self.look(shapes, share, margin, found))
    }

    /// Share of the step after which the two overlap, or all of it, up to `end` where their way is short, and how both are turned then;
    /// leaves the manifolds of that pose.
    fn follow(
        &self,
        shapes: [&Shape; 2],
        extent: f32,
        (path, end): (f32, f32),
        margin: f32,
        found: &mut FoundContacts,
    ) -> (f32, [Quat; 2]) {
        if path <= FEW_STRIDES * STRIDE * extent {
            let strides = (path / (STRIDE * extent)).ceil().max(1.0);
            let mut stride = 1.0;
            loop {
                let share = end * stride / strides;
                let turns = self.look(shapes, share, margin, found);
                if stride >= strides || found.nearest() < 0.0 {
                    return (share, turns);
                }
                stride += 1.0;
            }
        }
        let least = MIN_STRIDE * extent / path;
        let mut gone = 0.0;
        for _ in 0..MAX_LOOKS {
            self.look(shapes, gone, path * (1.0 - gone), found);
            if gone >= 1.0 || found.nearest() < 0.0 {
                break;
            }
            // All that can be met is among what was found, each behind the plane of its normal.
            gone = found
                .manifolds
                .iter()
                .fold(1.0, |next: f32, manifold| next.min(gone + self.clear_for(manifold, gone).max(least)));
        }
        (gone, self.look(shapes, gone, margin, found))
    }

    /// Share of the step after which two that are `began` apart at its start (m) and overlap after this share touch first, and how both are turned then:
    /// round shapes that hit each other off centre turn the normal on their way into each other.
    fn first_touch(
        &self,
        shapes: [&Shape; 2],
        (began, extent): (f32, f32),
        (share, turns): (f32, [Quat; 2]),
        margin: f32,
        found: &mut FoundContacts,
    ) -> (f32, [Quat; 2]) {
        let (mut apart, mut met, mut is_met) = ((0.0, began), (share, found.nearest(), turns), true);
        if (-TOUCH * extent..=0.0).contains(&began) {
            return (0.0, self.look(shapes, 0.0, margin, found));
        }
        if !(0.0..f32::INFINITY).contains(&began) {
            return (share, turns);
        }
        for _ in 0..MAX_TOUCH_LOOKS {
            if met.1 >= -TOUCH * extent {
                break;
            }
            let share = apart.0 + (met.0 - apart.0) * apart.1 / (apart.1 - met.1);
            let turns = self.look(shapes, share, margin, found);
            let nearest = found.nearest();
            is_met = nearest < 0.0;
            match is_met {
                true => met = (share, nearest, turns),
                false => apart = (share, nearest),
            }
        }
        if !is_met {
            self.look(shapes, met.0, margin, found);
        }
        (met.0, met.2)
    }

    /// Share of the step for which points of a manifold found after a share of it stay apart.
    fn clear_for(&self, manifold: &Manifold, gone: f32) -> f32 {
        let normal = self.a.rotation * applied(turned(self.spins[0], gone * self.step.dt), manifold.normal);
        let turning = self.turning();
        let speed = normal.dot(self.a.velocity - self.b.velocity) + turning;
        let nearest = nearest_of(manifold);
        if speed > 0.0 { nearest / (speed * self.step.dt) } else { f32::INFINITY }
    }

    /// Puts a manifold of the pose after `t` (s), in which both are turned like this in their own frames, back to the start.
    pub(super) fn put_back(&self, manifold: &mut Manifold, t: f32, turns: [Quat; 2]) {
        let normal_a = applied(turns[0], manifold.normal);
        let normal = self.a.rotation * normal_a;
        let closing = normal.dot(self.b.velocity - self.a.velocity);
        let in_frame = |collider_state: &ColliderState, vector: Vec3| collider_state.rotation.conjugate() * vector;
        // Of the axis that a shape turns about, at which turning moves its surface along the normal.
        let [spin_a, spin_b] = self.spins;
        let swing_a = if spin_a == Vec3::ZERO { Vec3::ZERO } else { normal_a.cross(spin_a) };
        let swing_b = if spin_b == Vec3::ZERO { Vec3::ZERO } else { in_frame(self.b, normal).cross(spin_b) };
        let swing = [swing_a, swing_b];
        let offsets = [self.a, self.b].map(|collider_state| {
            if collider_state.offset == Vec3::ZERO { Vec3::ZERO } else { in_frame(collider_state, collider_state.offset) }
        });
        manifold.normal = normal_a;
        let count = usize::from(manifold.count);
        for point in &mut manifold.points[..count] {
            let lever_a = applied(turns[0], offsets[0] + point.on_a);
            let lever_b = applied(turns[1], offsets[1] + point.on_b);
            (point.on_a, point.on_b) = (lever_a - offsets[0], lever_b - offsets[1]);
            point.separation -= t * (closing + swing[1].dot(lever_b) - swing[0].dot(lever_a));
        }
        if self.is_turned != [false; 2] {
            self.carry_back(manifold, t);
        }
    }

    /// Puts the points on a side that the host turns where the contact is at the start, and those on what goes with it too: rows of friction take them
    /// for that, see `contact_kernels/warm_start.rs`. What lies on it at several points goes with its own points there, else as if it did not roll.
    fn carry_back(&self, manifold: &mut Manifold, t: f32) {
        let normal = self.a.rotation * manifold.normal;
        let is_face = manifold.count > 1;
        let count = usize::from(manifold.count);
        let [turn_a, turn_b] = self.angular.map(|angular| angular.project_onto_normalized(normal));
        for point in &mut manifold.points[..count] {
            let lever = |side: &ColliderState, on: Vec3| side.offset + side.rotation * on;
            let own = |side: &ColliderState, angular: Vec3, on: Vec3| {
                let turning = if is_face { angular } else { angular.project_onto_normalized(normal) };
                side.velocity + turning.cross(lever(side, on))
            };
            let back =
                |side: &ColliderState, velocity: Vec3| side.rotation.conjugate() * velocity.reject_from_normalized(normal) * t;
            let contacts = [own(self.b, self.angular[1], point.on_b), own(self.a, self.angular[0], point.on_a)];
            let carried = [turn_b.cross(lever(self.a, point.on_a)), turn_a.cross(lever(self.b, point.on_b))];
            let of = |side: usize| match self.is_turned {
                turned if turned[side] => contacts[side] - [self.a, self.b][side].velocity,
                _ => carried[side],
            };
            point.on_a -= back(self.a, of(0));
            point.on_b -= back(self.b, of(1));
        }
    }
}
