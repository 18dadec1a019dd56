//! Where a moving convex part first meets another (conservative advancement: Mirtich 1996, van den Bergen 2004).
//!
//! Along a direction in which two parts are apart by g, they cannot meet before that gap has closed. So the motion advances to
//! where it would, the distance is found again, and so on until it is small: then the plane of the surface gives the rest.
//! Along a straight path the gap closes at a constant rate. Where the part turns as well, the same plane is followed by steps
//! that bound how fast any point can move, and only then is the distance found again.

use glam::{DQuat, DVec3};

use super::gap::{self, Gap};
use super::part::ConvexPart;

/// Gap at which the plane of the surface gives the rest of the way: over the finest measure of the two parts, and over the
/// greatest (rounding). How far the surface may leave its plane until then is far below what a host can tell.
const NEAR: (f64, f64) = (1.0e-7, 1.0e-11);

/// Greatest way aside that the plane is trusted for, over the way at which a surface as round as the finest measure has left
/// it by the gap: paths that graze a surface need a smaller gap.
const TRUSTED: f64 = 0.1;

/// Times that the distance is found. Flat parts take two to four, round ones some ten. Paths that graze a surface, or turn many times
/// very close to it, take more: 2 of 84,000 random ones take them all, and report the surface early.
const MAX_SEARCHES: usize = 1024;

/// Steps along one plane of a part that turns.
const MAX_STEPS: usize = 32;

/// Gap at which parts that graze each other until all searches are used up are taken to meet, over the finest measure.
const GRAZING: f64 = 1.0e-3;

/// A straight path, with a turn about a point that moves along: both evenly, from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct CastMotion {
    /// Whole path (m).
    pub path: DVec3,
    /// Whole turn: unit axis times angle (rad).
    pub turn: DVec3,
    /// Where the centre of the turn begins (m).
    pub center: DVec3,
}

/// Where a moving part first meets another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    /// Share of the motion, 0 to 1.
    pub share: f64,
    /// The gap there; at 0 it may be an overlap.
    pub gap: Gap,
    /// Whether they overlap or touch from the start.
    pub from_start: bool,
}

impl CastMotion {
    fn at<'a>(&self, part: &ConvexPart<'a>, share: f64) -> ConvexPart<'a> {
        let angle = self.turn.length();
        let turn = if angle > 0.0 { DQuat::from_axis_angle(self.turn / angle, angle * share) } else { DQuat::IDENTITY };
        part.moved(self.path * share, turn, self.center)
    }
}

/// Where `moving` first meets `fixed`, not later than `limit`, a share of the motion.
pub(super) fn first_meeting(fixed: &ConvexPart, moving: &ConvexPart, motion: &CastMotion, limit: f64) -> Option<Meeting> {
    let start = gap::gap(fixed, moving)?;
    let touch = gap::touch(fixed, moving);
    if start.distance <= touch {
        return Some(Meeting { share: 0.0, gap: start, from_start: true });
    }
    let finest = fixed.finest().min(moving.finest());
    let near = NEAR.0 * finest + NEAR.1 * gap::greatest(fixed, moving);
    // Greatest distance of a point of the part from the centre of the turn, its rounding left out: that does not turn.
    let lever = (moving.place.origin - motion.center).length() + moving.reach() - moving.rounding;
    let turning = motion.turn.length() * lever;
    let (mut share, mut gap) = (0.0, start);
    for _ in 0..MAX_SEARCHES {
        let closing = -gap.normal.dot(motion.path);
        if turning == 0.0 && closing <= 0.0 {
            return None;
        }
        if gap.distance <= near
            && let Some(meeting) = last_stretch((fixed, moving), motion, (share, gap), turning)
        {
            let aside = (meeting.share - share) * (motion.path.length() + turning);
            if aside <= TRUSTED * (gap.distance * finest).sqrt() || gap.distance <= touch {
                return (meeting.share <= limit).then_some(meeting);
            }
        }
        // Half of what is near is left, so that the next direction is not noise.
        let goal = (0.5 * near).min(0.5 * gap.distance);
        share = if turning == 0.0 {
            // No more than the parts are apart for certain.
            let apart = gap::along(fixed, &motion.at(moving, share), gap.normal);
            share + (apart.min(gap.distance) - goal).max(0.0) / closing
        } else {
            follow((fixed, moving), motion, (share, gap.normal), (goal, lever), limit)
        };
        if share > limit {
            return None;
        }
        let here = motion.at(moving, share);
        let next = gap::gap(fixed, &here)?;
        if next.distance <= touch {
            // The search ended a little early, or rounding took the rest: they meet here. An overlap that is none has no normal.
            let met = Gap { distance: 0.0, normal: gap.normal, ..next };
            return Some(Meeting { share, gap: met, from_start: false });
        }
        gap = next;
    }
    // It is safe up to here, and too near to be passed for sure.
    (gap.distance <= GRAZING * finest).then_some(Meeting { share, gap, from_start: false })
}

/// The share up to which the parts are apart by `goal` along a plane across `normal`, or one beyond the limit.
///
/// The plane stays with the larger part, so that all points of the smaller, p, move alike. With c the centre of the turn and
/// ω the turn, either way p closes in at v = (ω×n)·(p − c) − n·path, and no such speed rises by more than a. Over a step h the
/// gap of p is at least g − v h − a h²/2. The least of g − v h over all points is one point of support; as a function of h it is
/// concave, so that up to a step it is above the line from its beginning to its end.
fn follow(
    (fixed, moving): (&ConvexPart, &ConvexPart),
    motion: &CastMotion,
    (start, normal): (f64, DVec3),
    (goal, lever): (f64, f64),
    limit: f64,
) -> f64 {
    let rides = fixed.reach() < moving.reach();
    let (turn, path) = (motion.turn.length(), motion.path.length());
    let steepness = motion.turn.cross(normal).length();
    let acceleration = if rides {
        let arm = (fixed.place.origin - motion.center).length() + fixed.reach() + path;
        steepness * (turn * arm + 2.0 * path)
    } else {
        steepness * turn * lever
    };
    let mut share = start;
    for _ in 0..MAX_STEPS {
        let here = motion.at(moving, share);
        // Across the axis of the turn a plane that rides on the moving part has turned since.
        let normal = if rides { DQuat::from_scaled_axis(motion.turn * (share - start)) * normal } else { normal };
        let gap = gap::along(fixed, &here, normal);
        let left = gap - goal;
        if left <= 0.01 * goal {
            break;
        }
        // No step is longer than the acceleration alone allows, nor than what is asked for.
        let longest = (2.0 * left / acceleration).sqrt().min(limit - share + 2.0 * f64::EPSILON);
        let across = motion.turn.cross(normal);
        let tilted = if rides { normal + across * longest } else { across * longest - normal };
        let point = if rides { fixed.support(tilted) } else { here.support(tilted) };
        let other = if rides { here.support(-normal) } else { fixed.support(normal) };
        let apart = normal.dot(point - other) * if rides { -1.0 } else { 1.0 } - fixed.rounding - moving.rounding;
        let speed = (point - motion.center - motion.path * share).dot(across) - normal.dot(motion.path);
        // How fast the line from beginning to end falls.
        let fall = (gap - (apart - speed * longest)) / longest;
        // The positive root of f h + a h²/2 = left, without cancellation.
        share += if fall > 0.0 { 2.0 * left / (fall + (fall * fall + 2.0 * acceleration * left).sqrt()) } else { longest };
        if share.is_nan() || share > limit {
            return f64::INFINITY;
        }
    }
    share
}

/// From a small gap on: the way along the plane of the surface. None if it opens again.
fn last_stretch(
    (fixed, moving): (&ConvexPart, &ConvexPart),
    motion: &CastMotion,
    (share, gap): (f64, Gap),
    turning: f64,
) -> Option<Meeting> {
    let closing = -gap.normal.dot(motion.path);
    if turning == 0.0 {
        let rest = gap.distance / closing;
        let (on_a, on_b) = (gap.on_a, gap.on_b + motion.path * rest);
        let aside = on_b - on_a;
        return Some(Meeting {
            share: share + rest,
            gap: Gap { distance: 0.0, on_a: on_a + aside - gap.normal * aside.dot(gap.normal), on_b, ..gap },
            from_start: false,
        });
    }
    // How fast the gap closes, by a look ahead of as much as it could close by.
    let fastest = closing.max(0.0) + turning;
    let ahead = gap.distance / fastest;
    let left = gap::along(fixed, &motion.at(moving, share + ahead), gap.normal);
    let rate = (gap.distance - left) / ahead;
    if rate <= 1.0e-3 * fastest {
        return None;
    }
    let rest = gap.distance / rate;
    Some(Meeting { share: share + rest, gap: Gap { distance: 0.0, ..gap }, from_start: false })
}

#[cfg(test)]
mod tests {
    use super::super::part::{PartForm, tests::part};
    use super::*;

    /// Random casts whose search came so near to the surface that the way to the other part seemed to lead back.
    #[test]
    fn a_path_into_the_middle_of_a_solid_meets_it_however_near_the_search_comes() {
        let cases = [
            (
                part(
                    PartForm::Cylinder { half_height: 0.011333135887980461, radius: 0.008471437729895115 },
                    DVec3::new(2.6141176345625468, 3.9519000118049235, 1.0117878500643087),
                    [
                        DVec3::new(-0.7915142352713536, 0.450186000331744, 0.4133252719930288),
                        DVec3::new(-0.5129354329784478, -0.8570391969933713, -0.048796069638542355),
                        DVec3::new(0.3322686517834875, -0.2506319610948775, 0.9092750756067821),
                    ],
                ),
                part(
                    PartForm::Box { half_extents: DVec3::new(1.7675644159317017, 1.7421441078186035, 2.3441669940948486) },
                    DVec3::new(0.0, 0.0, 0.0),
                    [
                        DVec3::new(0.864851984945071, 0.06987028965679959, 0.4971410129529103),
                        DVec3::new(-0.2962831164435333, 0.8704569486186572, 0.39309161211097354),
                        DVec3::new(-0.40527442436832667, -0.48726054962901655, 0.7735178069884043),
                    ],
                ),
                DVec3::new(1.4279382684884525, 2.2409711584541108, 0.7432908803005737),
            ),
            (
                part(
                    PartForm::Cylinder { half_height: 5829.232421875, radius: 5555.45361328125 },
                    DVec3::new(-7029.94572487151, -618.1195444851408, 3931.1011144870836),
                    [
                        DVec3::new(-0.8211062751032916, -0.18798268247486558, -0.5389313463471492),
                        DVec3::new(0.2992173022111236, 0.6623003945226096, -0.6868967851669512),
                        DVec3::new(0.486059143565363, -0.7252728441798642, -0.4875713388333607),
                    ],
                ),
                part(
                    PartForm::Cylinder { half_height: 91.57299041748047, radius: 37.335968017578125 },
                    DVec3::new(0.0, 0.0, 0.0),
                    [
                        DVec3::new(3.4085956299056974e-5, -0.9294735899659757, -0.36888866124334685),
                        DVec3::new(0.09566271811637084, -0.36719383555334595, 0.9252120467731761),
                        DVec3::new(-0.9954138050081158, -0.035320428754241295, 0.08890345388049459),
                    ],
                ),
                DVec3::new(-29338.269824248087, 7219.446743040142, 3326.3256349953444),
            ),
        ];
        for (fixed, moving, path) in cases {
            let motion = CastMotion { path, turn: DVec3::ZERO, center: DVec3::ZERO };
            let deepest = (1..100).map(|i| gap::gap(&fixed, &motion.at(&moving, f64::from(i) / 100.0)).unwrap().distance);
            let deepest = deepest.fold(f64::INFINITY, f64::min);
            assert!(deepest < -0.3 * fixed.reach().min(moving.reach()), "the path leads through: {deepest} m");
            let met = first_meeting(&fixed, &moving, &motion, 1.0).expect("it meets");
            let left = gap::gap(&fixed, &motion.at(&moving, met.share)).unwrap().distance;
            let finest = fixed.reach().min(moving.reach());
            assert!(left.abs() < 1.0e-7 * finest, "{left} m are left of parts of {finest} m");
        }
    }
}
