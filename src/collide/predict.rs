//! Manifolds of two shapes as they will stand when they press, not as they stand when the step begins.
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
//! At constant velocity a row then acts only where its features overlap at t. Pairs of flat faces, and of bodies in joints, are taken as they
//! stand: towers of loose blocks, and blows on swept joints, come out otherwise there, and it is not known which is right.
//!
//! * A pair that is not pressed is followed until it overlaps, or else to the end of the step.
//! * A pair that carries load presses all through the step. With n substeps the constraint acts on positions after h, 2h, … nh, in the
//!   mean after (n+1)/(2n) dt, and the normal that does no work on the mean of a step is that of (n−1)/(2n) dt: energy in a bowl of radius
//!   R grows at a rate g/R dt (1 − (n+1)/(2n) − φ) if the normal is that of φ dt.

use glam::{Quat, Vec3};
use parry3d::math::Pose3;

use super::narrow::{self, Manifold, Scratch};
use super::stance::Stance;
use crate::shape::Shape;
use crate::solve::integrate::rotated_far;

/// Way ahead below which the pose at the step's start is as good, over the lesser least extent of the two: less than manifolds are kept for.
const NO_MOTION: f32 = 5.0e-4;

/// Square of half a turn (rad²) below which sine and cosine are the first terms of their series, right to rounding.
const SMALL_TURN: f32 = 1.0e-4;

/// Stride at which a pair that may meet is looked at, over the lesser least extent: whatever overlaps does so for at least two strides,
/// and the axis of least overlap is still that of the surface that was met.
const STRIDE: f32 = 0.25;

/// Strides up to which all are taken; a longer way is walked by the distances found.
const FEW_STRIDES: f32 = 2.0;

/// Least way walked on at once, and so the deepest overlap that a pair is stopped in, over the lesser least extent.
const LEAST_STRIDE: f32 = 0.05;

/// Looks at a pair in a step after which it is taken as it is.
const MAX_LOOKS: u32 = 64;

/// How far ahead a pair that carries load is looked at without more ado, over the lesser least extent.
const PRESSED_STRIDE: f32 = 0.05;

/// How far the surface that a loaded pair will press may lie beside the one that it presses now, over the lesser least extent. Where a body
/// goes over a ball or an edge, that is how deep it can sink in: without a bound 8 mm on a ball of 0.5 m at 10 m/s.
const SAGITTA: f32 = 2.0e-3;

/// Turn of a body that is followed (rad): about as far as four substeps turn anything.
const MAX_TURN: f32 = 6.0;

/// Two shapes in a step.
pub(super) struct Approach<'a> {
    a: &'a Stance,
    b: &'a Stance,
    /// Angular velocities of their bodies in the frames of the shapes (rad/s).
    spins: [Vec3; 2],
    /// Whether joints hold either body: these do not go on as they move, and articulations follow bent surfaces by themselves.
    is_jointed: bool,
    step: Step,
}

/// What is asked of a shape whose manifolds are made anew.
#[derive(Clone, Copy)]
pub(crate) struct Follow<'a> {
    pub shape: &'a Shape,
    /// Angular velocity of its body (rad/s).
    pub angular: Vec3,
    /// Whether joints hold the body.
    pub is_jointed: bool,
}

/// What the manifolds of all pairs in a step have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub dt: f32,
    pub substeps: u32,
}

/// Buffers and results of the narrow phase.
pub(super) struct Found<'a> {
    pub scratch: &'a mut Scratch,
    pub manifolds: &'a mut Vec<Manifold>,
}

impl Found<'_> {
    /// Normal of the nearest point, in A's frame.
    fn nearest_normal(&self) -> Option<Vec3> {
        let points = self
            .manifolds
            .iter()
            .flat_map(|manifold| manifold.contacts().iter().map(|point| (point.separation, manifold.normal)));
        points.reduce(|least, more| if more.0 < least.0 { more } else { least }).map(|(_, normal)| normal)
    }

    fn nearest(&self) -> f32 {
        let points = self.manifolds.iter().flat_map(|manifold| manifold.contacts());
        points.fold(f32::INFINITY, |least, point| least.min(point.separation))
    }
}

impl<'a> Approach<'a> {
    pub fn new(a: &'a Stance, b: &'a Stance, [of_a, of_b]: &[Follow; 2], step: Step) -> Self {
        let spins = [a.rotation.conjugate() * of_a.angular, b.rotation.conjugate() * of_b.angular];
        Self { a, b, spins, is_jointed: of_a.is_jointed || of_b.is_jointed, step }
    }

    /// Makes the manifolds of points nearer than `margin`; `start` is the pose of B in A's frame now.
    pub fn collide(&self, shapes: [&Shape; 2], start: Pose3, margin: f32, is_pressed: bool, found: &mut Found) {
        let [shape_a, shape_b] = shapes;
        // A surface has no thickness that could be passed.
        let thickness =
            |shape: &Shape, stance: &Stance| if shape.geometry().is_solid() { stance.least_extent } else { f32::INFINITY };
        let extent = thickness(shape_a, self.a).min(thickness(shape_b, self.b));
        let path = self.path();
        let n = self.step.substeps as f32;
        let ahead = if is_pressed { 0.5 * (n - 1.0) / n } else { 1.0 };
        // Written so that what has no extent or no end is taken as it is.
        let is_followed = !self.is_jointed && (shape_a.is_round() || shape_b.is_round());
        let moves = is_followed && ahead * path > NO_MOTION * extent;
        if !moves {
            return narrow::collide(shape_a, shape_b, start, margin, found.scratch, found.manifolds);
        }
        let (share, turns) = if is_pressed {
            self.look_ahead(shapes, ahead, extent / path, margin, found)
        } else {
            self.follow(shapes, extent, path, margin, found)
        };
        found.manifolds.iter_mut().for_each(|manifold| self.put_back(manifold, share * self.step.dt, turns));
    }

    /// How far the two move against each other at most (m), forces of the step left out.
    fn path(&self) -> f32 {
        let turning = self.a.sweep_speed(self.spins[0]) + self.b.sweep_speed(self.spins[1]);
        ((self.b.velocity - self.a.velocity).length() + turning) * self.step.dt
    }

    /// Looks at a loaded pair so far ahead, or less far if its surfaces bend; `short` is the share of the step in which it moves by the
    /// lesser least extent. Share of the step, and how both are turned then.
    fn look_ahead(&self, shapes: [&Shape; 2], ahead: f32, short: f32, margin: f32, found: &mut Found) -> (f32, [Quat; 2]) {
        let near = ahead.min(PRESSED_STRIDE * short);
        let far = ahead.min(STRIDE * short);
        if far > near {
            let normals = [0.0, far].map(|share| {
                let turns = self.look(shapes, share, margin, found);
                (turns, found.nearest_normal().map(|normal| self.a.rotation * (turns[0] * normal)))
            });
            if let [(_, Some(now)), (turns, Some(then))] = normals
                && 0.5 * (then - now).length() * far <= SAGITTA * short
            {
                return (far, turns);
            }
        }
        (near, self.look(shapes, near, margin, found))
    }

    /// Collides the two after a share of the step; how both are turned then, in their own frames.
    fn look(&self, [shape_a, shape_b]: [&Shape; 2], share: f32, margin: f32, found: &mut Found) -> [Quat; 2] {
        let t = share * self.step.dt;
        let turns = self.spins.map(|spin| turned(spin, t));
        let ((shift_a, turn_a), (shift_b, turn_b)) = (self.a.after(turns[0], t), self.b.after(turns[1], t));
        let inverse = turn_a.conjugate();
        let between = (self.b.position - self.a.position).as_vec3() + (shift_b - shift_a);
        let pose = Pose3::from_parts(inverse * between, inverse * turn_b);
        narrow::collide(shape_a, shape_b, pose, margin, found.scratch, found.manifolds);
        turns
    }

    /// Share of the step after which the two overlap, or all of it, and how both are turned then; leaves the manifolds of that pose.
    fn follow(&self, shapes: [&Shape; 2], extent: f32, path: f32, margin: f32, found: &mut Found) -> (f32, [Quat; 2]) {
        if path <= FEW_STRIDES * STRIDE * extent {
            let strides = (path / (STRIDE * extent)).ceil().max(1.0);
            let mut stride = 1.0;
            loop {
                let share = stride / strides;
                let turns = self.look(shapes, share, margin, found);
                if stride >= strides || found.nearest() < 0.0 {
                    return (share, turns);
                }
                stride += 1.0;
            }
        }
        let least = LEAST_STRIDE * extent / path;
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

    /// Share of the step for which points of a manifold found after a share of it stay apart.
    fn clear_for(&self, manifold: &Manifold, gone: f32) -> f32 {
        let normal = self.a.rotation * (turned(self.spins[0], gone * self.step.dt) * manifold.normal);
        let turning = self.a.sweep_speed(self.spins[0]) + self.b.sweep_speed(self.spins[1]);
        let speed = normal.dot(self.a.velocity - self.b.velocity) + turning;
        let nearest = manifold.contacts().iter().fold(f32::INFINITY, |least, point| least.min(point.separation));
        if speed > 0.0 { nearest / (speed * self.step.dt) } else { f32::INFINITY }
    }

    /// Puts a manifold of the pose after `t` (s), in which both are turned like this in their own frames, back to the start.
    fn put_back(&self, manifold: &mut Manifold, t: f32, turns: [Quat; 2]) {
        let [inverse_a, inverse_b] = [self.a, self.b].map(|stance| stance.rotation.conjugate());
        let normal_a = turns[0] * manifold.normal;
        let normal = self.a.rotation * normal_a;
        let normal_b = inverse_b * normal;
        let closing = normal.dot(self.b.velocity - self.a.velocity);
        let offsets = [inverse_a * self.a.offset, inverse_b * self.b.offset];
        manifold.normal = normal_a;
        let count = usize::from(manifold.count);
        for point in &mut manifold.points[..count] {
            let lever_a = turns[0] * (offsets[0] + point.on_a);
            let lever_b = turns[1] * (offsets[1] + point.on_b);
            let turning = normal_b.dot(self.spins[1].cross(lever_b)) - normal_a.dot(self.spins[0].cross(lever_a));
            (point.on_a, point.on_b) = (lever_a - offsets[0], lever_b - offsets[1]);
            point.separation -= t * (closing + turning);
        }
    }
}

/// How a body is turned after `t` (s).
fn turned(angular: Vec3, t: f32) -> Quat {
    if angular == Vec3::ZERO {
        return Quat::IDENTITY;
    }
    let half = angular * (0.5 * t);
    let x = half.length_squared();
    if x < SMALL_TURN {
        let axis = half * (1.0 - x / 6.0);
        return Quat::from_xyzw(axis.x, axis.y, axis.z, 1.0 - 0.5 * x);
    }
    rotated_far(Quat::IDENTITY, (angular * t).clamp_length_max(MAX_TURN))
}

impl Stance {
    /// Speed at which the surface goes where the shape was not, by turning (m/s). A shape that holds a ball of radius ρ about the centre and
    /// reaches as far as R has a support function whose slope is at most √(R² − ρ²): nothing of a ball.
    fn sweep_speed(&self, angular: Vec3) -> f32 {
        let held = 0.25 * self.least_extent * self.least_extent * angular.length_squared();
        (self.turning * self.turning - held).max(0.0).sqrt()
    }

    /// How far the shape's origin has moved after `t` (s, m), and how the shape is turned then, if it is turned by `turn` in its own frame.
    fn after(&self, turn: Quat, t: f32) -> (Vec3, Quat) {
        let rotation = self.rotation * turn;
        if self.offset == Vec3::ZERO {
            return (self.velocity * t, rotation);
        }
        let offset = rotation * (self.rotation.conjugate() * self.offset);
        (self.velocity * t + (offset - self.offset), rotation)
    }
}
