//! Turns the joints of an island into *links*, rows that hold without bounds, and *terms*, rows whose impulse has bounds: stops, motors and
//! friction. The rows are the same as those of all other solvers, see [`rows`](crate::solve::joint::rows).

use glam::DVec3;

use super::patch::{row, turning_row};
use super::problem::JointBlock;
use super::term::{Law, Term};
use crate::joint_record::{Joint, JointImpulses};
use crate::solve::joint::body_response::{BodyResponse, CoordinateAnswer, MotorAnswers};
use crate::solve::joint::driven::{self, DrivenParts};
use crate::solve::joint::geometry::{JointGeometry, Placement};
use crate::solve::joint::kinds;
use crate::solve::joint::locks::{self, Freedom};
use crate::solve::joint::row_sink::RowSink;
use crate::solve::joint::rows::{self, HeldDirections, MAX_RECOVERY_SPEED, Phase, Rate, RowRates};
use crate::solve::joint::{JointEntry, LocalPose, friction};

/// What a stop that presses makes of the speed of what it stops, at least (m/s, rad/s): a solve ends within as much.
const PRESSES: f64 = 1.0e-3;

/// Compliance of a row that is let go, over its ε: a thousand times what answers to it.
const FREE: f64 = 1.0e12;

/// Where the multiplier of a row goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum MultiplierSlot {
    Point,
    Direction,
    Scalar(u8),
}

/// Where a row's multiplier goes, and what it does to B.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source {
    pub place: MultiplierSlot,
    pub linear: DVec3,
    pub angular: DVec3,
}

impl Source {
    pub(super) const NONE: Self = Self { place: MultiplierSlot::Direction, linear: DVec3::ZERO, angular: DVec3::ZERO };
}

/// A joint in this substep: what its link's rows are, and its terms with what those are.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointAssembly {
    pub sources: [Source; 6],
    pub terms: (u32, u32),
    /// Whether it holds its points together in all directions.
    pub holds_points: bool,
    /// Whether a servo of it is on its way.
    pub is_under_way: bool,
    pub levers: [DVec3; 2],
    pub gap: DVec3,
}

/// Lists in which the rows of joints are put.
pub(super) struct Sink<'a> {
    pub links: &'a mut Vec<JointBlock>,
    pub terms: &'a mut Vec<Term>,
    /// What each of the first terms is.
    pub sources: &'a mut Vec<Source>,
    pub asked: &'a mut Vec<rows::ScalarRow>,
}

/// A joint that asks for its rows in a substep.
#[derive(Clone, Copy)]
pub(super) struct Asking<'a> {
    pub joint: &'a Joint,
    /// Where its bodies are, how fast, and how they answer.
    pub local_poses: [LocalPose; 2],
    pub rates: [Rate; 2],
    pub answers: [BodyResponse; 2],
    /// Along and about what they move, where both have locked axes.
    pub locks: Option<[Freedom; 2]>,
    /// How all that joints hold answers, where its servos are to know.
    pub in_loop: Option<CoordinateAnswer<'a>>,
    /// Numbers by which rows know them.
    pub moved: [u32; 2],
    /// Length of the substep, and how far its start and its end are from the end of the step (s).
    pub h: f64,
    pub left: [f64; 2],
}

impl Asking<'_> {
    fn placement(&self, entry: &JointEntry) -> Placement {
        let [a, b] = &self.local_poses;
        driven::before(entry.placement(*a, *b), self.joint.drive(), [a, b], self.left[0])
    }

    /// Blocks of the joint's rows in one phase; its scalar rows are put in `scalars`.
    fn blocks(
        &self,
        entry: &mut JointEntry,
        placement: &Placement,
        phase: Phase,
        scalars: &mut Vec<rows::ScalarRow>,
    ) -> ([Option<rows::BlockRow>; 2], bool) {
        let Self { joint, local_poses: [a, b], rates, answers, left, .. } = self;
        let in_place = matches!(phase, Phase::Position { .. });
        let driven =
            joint.drive().map(|drive| DrivenParts::new(drive, [a, b], placement, if in_place { [left[0]; 2] } else { *left }));
        let rates = RowRates { bodies: *rates, frames: driven.filter(|_| !in_place).map(|driven| driven.rates) };
        let mut sink = RowSink {
            driven,
            impulses: if in_place { &JointImpulses::ZERO } else { &entry.impulses },
            answers: MotorAnswers { bodies: &|side| answers[side], in_loop: self.in_loop },
            left: left[1],
            ..RowSink::new(JointGeometry::at(placement), &joint.def, (phase, rates), entry.angles, scalars)
        };
        kinds::add_rows(&mut sink);
        locks::take_out(&mut sink, self.locks);
        let (blocks, arrives, is_under_way) = ([sink.point, sink.direction], sink.arrives, sink.is_under_way);
        entry.pressed |= if in_place { 0 } else { arrives };
        (blocks, is_under_way)
    }

    /// Finds the errors of its rows where its bodies have moved to, along the axes that the rows have. A stop that is overrun and does not press, as
    /// where a joint was made beyond it, is to be reached whatever its motor and its friction say: whether there is one.
    pub(super) fn find_errors(
        &self,
        entry: &mut JointEntry,
        rows: &JointAssembly,
        (link, terms): (&mut JointBlock, &mut [Term]),
        (sources, scalars): (&[Source], &mut Vec<rows::ScalarRow>),
    ) -> bool {
        let placement = self.placement(entry);
        let (blocks, _) = self.blocks(entry, &placement, Phase::Position { most: MAX_RECOVERY_SPEED * self.h }, scalars);
        // A free axis has turned with its body, and how far B is along it is no error.
        let [point, direction] =
            blocks.map(|block| block.filter(|block| block.acts).map_or(DVec3::ZERO, |block| block.held.project(block.bias)));
        let of = |source: &Source, give: f64| match source.place {
            MultiplierSlot::Point => point.dot(source.linear),
            MultiplierSlot::Direction => direction.dot(source.angular),
            MultiplierSlot::Scalar(id) => {
                let found = scalars.iter().find(|scalar| scalar.id == id && scalar.acts && give == 0.0);
                found.map_or(0.0, |scalar| scalar.bias)
            }
        };
        for row in 0..link.rows {
            link.error[row] = of(&rows.sources[row], link.give[row]);
        }
        let mut is_overrun = false;
        for (term, source) in terms.iter_mut().zip(sources).filter(|(term, _)| matches!(term.law, Law::Between(0.0, _))) {
            term.push = (-of(source, term.give)).max(0.0);
            is_overrun |= term.push > 0.0 && term.impulse[0] * term.ease < PRESSES;
        }
        if is_overrun {
            terms.iter_mut().for_each(|term| term.gain = [f64::from(term.push > 0.0), 0.0]);
            for row in (0..link.rows).filter(|row| link.boundless & 1 << row != 0) {
                link.give[row] = FREE * link.proximity[row];
            }
        }
        is_overrun
    }
}

impl Sink<'_> {
    /// Adds the rows of a joint.
    pub(super) fn add(&mut self, entry: &mut JointEntry, asking: &Asking<'_>) -> JointAssembly {
        let placement = asking.placement(entry);
        let (moved, h) = (asking.moved, asking.h);
        let first = self.terms.len() as u32;
        let mut rows = JointAssembly {
            sources: [Source::NONE; 6],
            terms: (first, first),
            holds_points: false,
            is_under_way: false,
            levers: [placement.a.lever, placement.b.lever],
            gap: placement.gap,
        };
        let ([point, direction], is_under_way) = asking.blocks(entry, &placement, Phase::Leap { h }, self.asked);
        rows.is_under_way = is_under_way;
        let mut link = JointBlock::new(moved);
        if let Some(block) = point {
            rows.holds_points = matches!(block.held, HeldDirections::All);
            let (axes, count) = block.held.axes();
            for axis in &axes[..count] {
                let jacobian = [0, 1].map(|side| row(side, *axis, block.levers[side]));
                let source = Source { place: MultiplierSlot::Point, linear: *axis, angular: block.levers[1].cross(*axis) };
                add_row(&mut link, &mut rows, source, jacobian, &block, *axis);
            }
        }
        if let Some(block) = direction {
            let (axes, count) = block.held.axes();
            for axis in &axes[..count] {
                let jacobian = [0, 1].map(|side| turning_row(side, *axis));
                let source = Source { place: MultiplierSlot::Direction, linear: DVec3::ZERO, angular: *axis };
                add_row(&mut link, &mut rows, source, jacobian, &block, *axis);
            }
        }
        for scalar in self.asked.iter().filter(|scalar| scalar.acts) {
            let at = &scalar.jacobian;
            let jacobian = [[-at.linear, -at.angular_a], [at.linear, at.angular_b]].map(|[v, w]| [v.x, v.y, v.z, w.x, w.y, w.z]);
            let place =
                if scalar.id == friction::ABOUT_POINT { MultiplierSlot::Direction } else { MultiplierSlot::Scalar(scalar.id) };
            let source = Source { place, linear: at.linear, angular: at.angular_b };
            let is_boundless = scalar.drives && !scalar.is_bounded() && scalar.gamma == 0.0;
            let always = scalar.min == f64::NEG_INFINITY && scalar.max == f64::INFINITY;
            if always && link.rows < 6 {
                rows.sources[link.rows] = source;
                link.boundless |= u8::from(is_boundless) << link.rows;
                push_row(&mut link, jacobian, scalar.bias, scalar.gamma, f64::from(scalar.impulse));
                continue;
            }
            let most = if is_boundless { scalar.max.min(f64::MAX) } else { scalar.max };
            let mut term = Term::new(moved, 1, Law::Between(scalar.min, most));
            term.jacobian = jacobian.map(|row| [row, [0.0; 6]]);
            term.bias[0] = scalar.bias;
            term.give = scalar.gamma;
            term.expected[0] = f64::from(scalar.impulse);
            if scalar.is_stop() && scalar.gamma == 0.0 && asking.joint.drive().is_none() {
                (term.restitution, term.ahead) = (f64::from(asking.joint.def.restitution), scalar.bias.max(0.0));
            }
            self.terms.push(term);
            self.sources.push(source);
        }
        rows.terms.1 = self.terms.len() as u32;
        self.links.push(link);
        rows
    }
}

fn add_row(
    link: &mut JointBlock,
    rows: &mut JointAssembly,
    source: Source,
    jacobian: [[f64; 6]; 2],
    block: &rows::BlockRow,
    axis: DVec3,
) {
    if block.acts && link.rows < 6 {
        rows.sources[link.rows] = source;
        push_row(link, jacobian, block.bias.dot(axis), block.gamma, block.impulse.as_dvec3().dot(axis));
    }
}

fn push_row(link: &mut JointBlock, jacobian: [[f64; 6]; 2], bias: f64, give: f64, impulse: f64) {
    let number = link.rows;
    (link.jacobian[0][number], link.jacobian[1][number]) = (jacobian[0], jacobian[1]);
    (link.bias[number], link.give[number]) = (bias, give);
    link.impulse[number] = impulse;
    link.rows += 1;
}
