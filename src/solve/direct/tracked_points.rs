//! Follows the points of one manifold through a step, for solvers that hold contacts by rows of their own.

use glam::{DMat3, DQuat, DVec3};

use super::curved_contacts::{Curved, CurvedPoint, change};
use super::multistep::rotation_vector;
use super::round_on_block::RoundOnBlock;
use crate::solve::contact::{ContactInput, POINTS};
use crate::solve::joint::LocalPose;
use crate::solve::joint::rows::Rate;

/// Points that settle nearer to each other than this fraction of the body's reach are one, as are those nearer than [`MISSED`] of the way
/// that one of them has settled by.
const ONE_SPOT: f64 = 1.0e-3;

/// How far a point may settle beside where surfaces are tangent, over its way there: to second order in the lean of the normals, which is
/// below half a radian, it misses by less than 0.05 of it.
const MISSED: f64 = 0.1;

/// How far points may lie aside of each other for surfaces to be followed from there, over the lesser reach of the two: to second order in the turn of
/// a normal, which is about that.
const FOLLOWED: f64 = 0.1;

/// Where the points of a manifold were at the start of the step, as one of its bodies sees them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TrackedPoints {
    began: [CurvedPoint; POINTS],
    pub count: usize,
    /// How the surfaces curve, where that is known and they are not flat on each other.
    curved: Option<Curved>,
    /// How far the body's points lie from the other's across the normal at the start of the step (m): those of two that meet later in it are of where
    /// they will.
    aside: DVec3,
    /// The two where one is round and the other a block.
    on_block: Option<RoundOnBlock>,
}

impl TrackedPoints {
    /// As B sees them, or else A.
    pub(crate) fn of(input: &ContactInput, as_b: bool) -> Self {
        let sign = if as_b { 1.0 } else { -1.0 };
        let (own, others) = if as_b { (&input.lever_b, &input.lever_a) } else { (&input.lever_a, &input.lever_b) };
        let began = std::array::from_fn(|i| CurvedPoint {
            normal: input.normal.as_dvec3() * sign,
            lever: own[i].as_dvec3(),
            other_lever: others[i].as_dvec3(),
            separation: if i < input.count { f64::from(input.separation[i]) } else { f64::INFINITY },
        });
        Self { began, count: input.count, curved: None, aside: DVec3::ZERO, on_block: None }
    }

    /// Takes note of how far the body's points lie from the other's at the start of the step (m).
    pub(crate) fn lie(&mut self, offset: DVec3) {
        self.aside = offset.reject_from_normalized(self.normal());
    }

    /// Lets them follow what is round on a block.
    pub(crate) fn go_over_block(&mut self, on_block: RoundOnBlock) {
        self.on_block = Some(on_block);
    }

    pub(crate) fn are_on_block(&self) -> bool {
        self.on_block.is_some()
    }

    /// Lets them follow surfaces with these shape operators in world axes, of the body and of the other (1/m); `reach` is how far they
    /// may wander (m).
    pub(crate) fn curve(&mut self, operators: [DMat3; 2], reach: f64) {
        // What has been found where the two meet is of there: from far off it is not followed, but taken as it is.
        let is_near = self.aside.length_squared() <= (FOLLOWED * reach).powi(2);
        self.curved = if is_near { Curved::new(operators, self.normal(), reach) } else { None };
    }

    /// Brings points that are older than the poses to where the surfaces are tangent now, as B sees them: outward normals of A and of B at
    /// each, and the way from A's point to B's (m). Corners of a face on something round are tangent where the face is, and become one
    /// with its point; `merged` is told which of the points becomes one with which before it, both by their places then.
    pub(crate) fn settle(&mut self, at: &[(DVec3, DVec3, DVec3); POINTS], mut merged: impl FnMut(usize, Option<usize>)) {
        let Some(curved) = self.curved else { return };
        let points = std::mem::take(&mut self.count);
        for (i, &(of_a, of_b, offset)) in at.iter().enumerate().take(points) {
            let before = self.began[i];
            let spot = curved.settle(&before, [of_b, of_a], offset).unwrap_or(before);
            let near = (ONE_SPOT * curved.reach()).max(MISSED * spot.lever.distance(before.lever));
            let known = self.began[..self.count].iter().position(|known| known.lever.distance_squared(spot.lever) < near * near);
            merged(i, known);
            if known.is_none() {
                self.began[self.count] = spot;
                self.count += 1;
            }
        }
    }

    /// The manifold's normal at the start of the step, towards the body.
    pub(crate) fn normal(&self) -> DVec3 {
        self.began[0].normal
    }

    pub(crate) fn curved(&self) -> Option<&Curved> {
        self.curved.as_ref()
    }

    /// How far the body's points lay from the other's across the normal at the start of the step (m).
    pub(crate) fn aside(&self) -> DVec3 {
        self.aside
    }

    /// Mean distance of the points from their middle (m).
    pub(crate) fn spread(&self) -> f64 {
        let (share, spots) = (1.0 / self.count as f64, &self.began[..self.count]);
        let center = spots.iter().map(|spot| spot.lever).sum::<DVec3>() * share;
        spots.iter().map(|spot| (spot.lever - center).length()).sum::<f64>() * share
    }

    /// The points with the body and the other at these stances, each now and at the start of the step.
    ///
    /// Separations follow displacements and rotation vectors linearly where curvature is not known, as the rows do: a point that
    /// turned with its body would leave the ground under a wheel that rolls and a link that spins.
    pub(crate) fn at(&self, own: [&LocalPose; 2], other: [&LocalPose; 2]) -> [CurvedPoint; POINTS] {
        let [own, other] = [own, other].map(|[now, began]| change(now, began));
        let turns = [own.1, other.1].map(rotation_vector);
        let mut spots = self.began;
        for (number, spot) in spots[..self.count].iter_mut().enumerate() {
            let passed = self.on_block.and_then(|on_block| on_block.follow(number, &own, &other));
            let curved = || self.curved.and_then(|curved| curved.follow(spot, &own, &other));
            *spot = passed.or_else(curved).unwrap_or_else(|| {
                let moved = own.0 + turns[0].cross(spot.lever) - other.0 - turns[1].cross(spot.other_lever);
                CurvedPoint { separation: spot.separation + spot.normal.dot(moved), ..*spot }
            });
        }
        spots
    }
}

/// How far a body has gone and turned since the start of the step.
pub(crate) fn way(now: &LocalPose, began: &LocalPose) -> [DVec3; 2] {
    let (way, turn) = change(now, began);
    [way, rotation_vector(turn)]
}

/// Moves levers from the start of the step to where the contact is after its body and the other have gone these ways and turned by these vectors.
///
/// It goes with the one whose middle it is nearer to, and turns with that about the normal. A link that lies across an edge and turns on it is
/// pressed on its own line still; beside that line, the push would spin it about itself. What rolls is not taken along by what it turns across the
/// normal. Levers of two that meet within the step are those of where they do: up to then they stay. Says whether it goes with the body.
pub(crate) fn carry(spots: &mut [CurvedPoint], apart: DVec3, [own, other]: [[DVec3; 2]; 2]) -> bool {
    let normal = spots[0].normal;
    let aside = |lever: DVec3| lever.reject_from_normalized(normal);
    let middles: [DVec3; 2] = [spots.iter().map(|spot| spot.lever).sum(), spots.iter().map(|spot| spot.other_lever).sum()];
    let leads = aside(middles[0]).length_squared() <= aside(middles[1]).length_squared();
    let [way, turn] = if leads { own } else { other };
    // To third order in the turn, without an angle's sine.
    let about = DQuat::from_vec4((normal * (0.5 * normal.dot(turn))).extend(1.0)).normalize();
    for spot in spots {
        let lever = if leads { spot.lever } else { spot.other_lever };
        let goes = way + about * lever - lever;
        let past = |moved: DVec3, began: DVec3| {
            let moved = aside(moved);
            let gone = moved + began;
            let comes = moved.dot(began) <= 0.0 && gone.dot(began) > 0.0;
            if comes { DVec3::ZERO } else { gone }
        };
        if leads {
            spot.lever += aside(goes - own[0]);
            spot.other_lever += past(goes - other[0], apart);
        } else {
            spot.lever += past(goes - own[0], -apart);
            spot.other_lever += aside(goes - other[0]);
        }
    }
    leads
}

/// Middles of the points, by the levers of the body and of the other.
pub(crate) fn middles(spots: &[CurvedPoint]) -> [DVec3; 2] {
    let share = 1.0 / spots.len() as f64;
    [spots.iter().map(|spot| spot.lever).sum::<DVec3>() * share, spots.iter().map(|spot| spot.other_lever).sum::<DVec3>() * share]
}

/// What the middle of the points slips by more, in the middle of a substep of length `h` (s) with these velocities, than at its start, as the body that
/// it does not go with turns under it (m/s).
///
/// What stands on a turntable is carried round meanwhile: at the levers of the start it would be pushed along the tangent, outwards by ½ ω² h of its
/// radius in a second. The levers are those of the start still, for which forces and poses keep angular momentum together. What the contact goes with
/// is left out: of a slender body that spins the term would answer to its own force.
pub(crate) fn slip_of_turn(spots: &mut [CurvedPoint], rates: [&Rate; 2], h: f64) -> DVec3 {
    let [own, other] = middles(spots);
    let leads = carry(spots, DVec3::ZERO, rates.map(|rate| [rate.linear * (0.5 * h), rate.angular * (0.5 * h)]));
    let [own_later, other_later] = middles(spots);
    if leads { -rates[1].angular.cross(other_later - other) } else { rates[0].angular.cross(own_later - own) }
}

/// Greatest overlap of these points, zero where there is none (m).
pub(crate) fn overlap(spots: &[CurvedPoint]) -> f64 {
    spots.iter().fold(0.0, |worst, spot| worst.max(-spot.separation))
}
