//! Behaviour thresholds: numbers that decide what the library does, not how exactly it computes.
//!
//! Each says what it is and in which unit, why it has this value, on which scenes it was tried and which test holds it; `tests/house.rs`
//! checks that none of these lines is missing. What is a tolerance of an algorithm, a size of a buffer or a number of pieces of work
//! stands beside the code that uses it.

pub(crate) mod blows;
pub(crate) mod crowds;
pub(crate) mod overruled;
pub(crate) mod plan;
pub(crate) mod stress;
pub(crate) mod uneven;

/// Bodies that are swept along the way that a step has taken them: see `world/fast/astray.rs`.
pub(crate) mod fast {
    /// Turn in a step from which on what a body is made of comes where contacts have not been looked for (rad).
    /// Why: a lever goes along its arc by then, 3 % shorter; of 200 rad/s at 60 Hz, more than half a turn, hulls of 1 cm rolled through meshes.
    /// Scenes: balls, boxes, capsules, cylinders, cones, hulls of 1 to 10 cm on floors of five kinds, 30 to 120 Hz.
    /// Test: tests/fast_bodies.rs
    pub(crate) const FAR_TURN: f32 = 0.5;
    /// How far a body may reach from its centre of mass and be swept that is not flagged fast, over its least extent.
    /// Why: what is more slender leaves the way of its middle by more than it is thick in every hit, and heaps of rods of 1:20 and needles that
    /// are put back each time gain energy. Planks of 1:8 fell through floors.
    /// Scenes: rods of 1 m by 2 mm and 2 cm by 1 mm, sheets, needles, planks.
    /// Test: tests/slender.rs
    pub(crate) const SLENDER: f32 = 5.0;
}

/// Islands that stand still and are not solved: see `world/hold.rs`.
pub(crate) mod hold {
    /// Time for which all bodies of an island must be calm, where every one of them is supported (s).
    /// Why: as long as an island must be quiet to sleep.
    /// Scenes: tower, tower loose=on, column, heavy_on_light.
    /// Test: tests/hold.rs
    pub(crate) const CALM_TIME: f32 = 0.5;
    /// Time after which it is enough that every contact below the bodies holds: stones of an arch, a ball in a dent (s).
    /// Why: what is out of balance has left by then; a box on its edge doubles its lean every tenth of a second.
    /// Scenes: arch, card_house, pile.
    /// Test: tests/hold.rs
    pub(crate) const STILL_TIME: f32 = 2.5;
    /// Speed below which a body is calm: share of what gravity adds in a step.
    /// Why: a falling body has a hundred times as much after one step.
    /// Scenes: tower, arch, card_house.
    /// Test: tests/hold.rs
    pub(crate) const CALM_SHARE: f32 = 1.0e-2;
    /// Distance of a centre of mass inside its support hull: share of the hull's reach.
    /// Why: ten times the share from which a body counts as supported, so that rounding does not engage the hold.
    /// Scenes: tower, support_gallery.
    /// Test: tests/hold.rs
    pub(crate) const MARGIN_SHARE: f32 = 1.0e-2;
    /// Overlap of two shapes with which neither is held: share of the smaller one's least extent.
    /// Why: a held body is never recovered from an overlap.
    /// Scenes: half_sunk, pile.
    /// Test: tests/hold.rs
    pub(crate) const OVERLAP_SHARE: f32 = 1.0e-3;
}

/// Where the joints of an articulation are taken: see `solve/direct/substep.rs`.
pub(crate) mod prediction {
    /// Most by which a torque of the host turns a body further in a substep, as its joints see it beforehand (rad).
    /// Why: what a joint holds is not turned. Seen three radians on, it was solved for a turn more, and told of 10,000 rad/s at rest.
    /// Scenes: boxes, rods and plates of 1 cm to 1 m on hinges, sliders, ball and six-axis joints, torques of 0.3 to 10 rad in a substep.
    /// Test: tests/held_torques.rs
    pub(crate) const MAX_KICK: f64 = 0.5;
}

/// What an articulation carries: see `solve/direct/carried_bodies.rs`.
pub(crate) mod carried {
    /// Turn of a body in a substep from which on it is not carried where it does not press (rad).
    /// Why: levers of contacts, and what its momentum did in the last substep, say nothing of the next by then: a bar at 200 rad/s that flew past
    /// a hinged one, 1.2 m aside, came to 26,000 times its energy. By itself it turns exactly; what it meets takes the step by sweeps.
    /// Scenes: capsules, boxes, cylinders of 0.3 to 3 m beside bars on joints, 6 to 400 rad/s, 30 to 240 Hz.
    /// Test: tests/struck_joints.rs
    pub(crate) const FAST_TURN: f32 = 0.1;
}

/// Stops that give, and what swings on springs: see `solve/direct/soft_stops.rs`.
pub(crate) mod soft_stops {
    /// Phase of a spring, ω h, by which a part of a substep in which a soft stop is met goes on (rad).
    /// Why: a second-order substep is off by 5/24 (ω h)² of the period, here 0.8 %.
    /// Scenes: bodies of 0.1 to 10 m on stops of 1 to 80 Hz at 30 to 240 Hz.
    /// Test: tests/soft_stops.rs
    pub(crate) const PART_PHASE: f64 = 0.2;
    /// Phase of a spring in a substep, from which on substeps on a stop are of first order (rad).
    /// Why: of second order, one that does not resolve the spring goes on with up to all of the speed that the last has taken.
    /// Scenes: bodies on stops of 100 to 5000 Hz at 30 to 240 Hz.
    /// Test: tests/soft_stops.rs
    pub(crate) const HARD_PHASE: f64 = 1.0;
    /// Speed of what is on a soft stop, over ω and its depth, below which it rests there.
    /// Why: a hundredth of its depth is what it may swing by unresolved, and what lies on a stop is to cost no more than on a rigid one.
    /// Scenes: bodies of 0.1 to 10 m that fall on stops of 1 to 80 Hz.
    /// Test: tests/soft_stops.rs
    pub(crate) const AT_REST: f64 = 0.01;
}

/// Springs of joints that are solved as one with contacts: see `solve/joint/rows.rs`.
pub(crate) mod springs {
    /// Phase of a spring in a substep, ω h, beyond which it does not keep its energy (rad).
    /// Why: at it the trapezoidal rule swings by 0.93 rad for 1, and what it does not resolve it would have tremble for ever.
    /// Scenes: springs of 1 to 8 Hz that throw balls, at 30 to 240 Hz; soft joints under loads.
    /// Test: tests/springs.rs
    pub(crate) const HARD_PHASE: f64 = 1.0;
}

/// Bodies in joints that lie still among others that do not: see `world/hold/units.rs`.
pub(crate) mod units {
    /// Speed below which a body with joints is calm: share of what gravity adds in a step.
    /// Why: 5 mm/s at 60 Hz, a tenth of the speed at which an island may sleep.
    /// Scenes: ragdoll_pile, ragdoll_rain (3, 5 and 8 mm/s were tried: docs/lab/support.md).
    /// Test: tests/held_units.rs
    pub(crate) const UNIT_CALM_SHARE: f32 = 3.0e-2;
    /// Time for which bodies must be calm before a unit is first held (s).
    /// Why: with half a second a third fewer bodies of a heap were held.
    /// Scenes: ragdoll_rain.
    /// Test: tests/held_units.rs
    pub(crate) const CALM_TIME: f32 = 1.0 / 6.0;
    /// Time for which bodies must be calm where another load has ended a hold (s).
    /// Why: the unit is known to lie still; only its load is new.
    /// Scenes: ragdoll_rain.
    /// Test: tests/held_units.rs
    pub(crate) const AGAIN_TIME: f32 = 0.05;
    /// Time between two looks at a body that is calm and not held (s).
    /// Why: each costs a walk through its unit; what stops a unit from being held, a spinning end or a blow, lasts for tenths of a second.
    /// Scenes: ragdoll_rain, ragdoll_pile.
    /// Test: tests/held_units.rs
    pub(crate) const LOOK_TIME: f32 = 1.0 / 15.0;
    /// Change of the load of a body that ends a hold: share of what it bears and weighs.
    /// Why: with 2 and 5 % of the unit's weight less than half as many bodies of a heap were held.
    /// Scenes: ragdoll_rain.
    /// Test: tests/held_units.rs
    pub(crate) const LOAD_SHARE: f32 = 0.15;
    /// Momentum of a body beside a unit that ends a hold: share of what gravity gives the unit in a step.
    /// Why: found together with the share of load, so that a pushed box moves a ragdoll as soon as one that is not held, to a newton.
    /// Scenes: ragdoll_rain, a box of 20 kg pulled over a ragdoll.
    /// Test: tests/held_units.rs
    pub(crate) const BLOW_SHARE: f32 = 0.2;
    /// Overlap of two shapes with which neither unit is held: share of the smaller one's least extent.
    /// Why: limbs in a heap keep overlaps that their joints do not let go.
    /// Scenes: ragdoll_rain (1 and 2 % were tried).
    /// Test: tests/held_units.rs
    pub(crate) const OVERLAP_SHARE: f32 = 0.01;
}

/// Substeps that a smooth island takes at once: see `world/substep_multiplier.rs`.
pub(crate) mod stride {
    /// Time for which an island must have been smooth (s).
    /// Why: carried multipliers are exact only where forces have stayed what they were.
    /// Scenes: excavator, joint_grid.
    /// Test: tests/strides.rs
    pub(crate) const SMOOTH_TIME: f32 = 0.16;
    /// Change of velocity in a step: share of what gravity adds.
    /// Why: the load of the next step is known to a twentieth.
    /// Scenes: excavator, joint_grid.
    /// Test: tests/strides.rs
    pub(crate) const SMOOTH_SHARE: f32 = 0.05;
    /// Rotation in a step (rad).
    /// Why: gradients turn by as much; errors go with its square.
    /// Scenes: excavator.
    /// Test: tests/strides.rs
    pub(crate) const SMOOTH_TURN: f32 = 0.02;
    /// Overlap (m).
    /// Why: what overlaps by more is still being pushed out.
    /// Scenes: excavator. It is a length, so small scenes never stride less and large ones less often.
    /// Test: tests/strides.rs
    pub(crate) const SMOOTH_OVERLAP: f32 = 2.0e-4;
}

/// What keeps a quiet island awake because it goes somewhere: see `world/drift.rs`.
pub(crate) mod drift {
    /// Time over which a drift is averaged (s).
    /// Why: some steps at 30 Hz, and a fifth of the time for which bodies must be quiet, after which a motion that has ended has left no
    /// trace in it.
    /// Scenes: resting, slow motors, heaps at 30, 60 and 240 Hz.
    /// Test: tests/sleeping.rs
    pub(crate) const DRIFT_TIME: f32 = 0.1;
    /// Drift of a body that goes somewhere: share of the speed below which it is quiet.
    /// Why: one that hangs freely turns back at most 4 mrad askew; gravity would take it past this drift within an eighth of a second.
    /// Scenes: pendulums, slow motors, resting.
    /// Test: tests/sleeping.rs
    pub(crate) const CREEP_SHARE: f32 = 0.1;
    /// The same of a body that touches something.
    /// Why: friction holds it where it lies. All but one of the heaps sleep as soon with a fifth; that one slips on for 5 s more at a
    /// fifth, and 0.7 s at this, of the 5 s that it takes by speeds alone.
    /// Scenes: heaps of boxes at 30, 60 and 240 Hz.
    /// Test: tests/sleeping.rs
    pub(crate) const TOUCHING_CREEP_SHARE: f32 = 0.5;
    /// Time of the mean that a drift is compared with (s).
    /// Why: the part of the quiet time in which nothing may creep, and longer than what a drift is averaged over.
    /// Scenes: planks beyond an edge, turning points, heaps at 30, 60 and 240 Hz.
    /// Test: tests/tipping.rs
    pub(crate) const GROWTH_TIME: f32 = 0.25;
    /// Time within which a change of the drift must not lead past the speed below which a body is quiet (s).
    /// Why: 5 cm/s in 5 s is a thousandth of g, which is what may be out of balance. Of 1680 planks, rods and poles beyond an edge 666 slept
    /// without it, 338 with 1 s, 56 with 5 s (poles on the edge of their foot). What rolls up a slope of 2 % turns back at 0.14 m/s², a wheel
    /// whose centre is 1 mm off its axis at 0.04 rad/s². What hangs or sways changes its velocity by as much, but not where it is fastest,
    /// and sleeps there: with the change over [`GROWTH_TIME`] alone, heaps slept 13 % later and up to 40, with both that agree 2 %.
    /// Scenes: planks, rods and poles beyond an edge, turning points, heaps at 30, 60 and 240 Hz, ragdoll_pile.
    /// Test: tests/tipping.rs
    pub(crate) const GROWTH_AHEAD: f32 = 5.0;
    /// Share of the quiet time that counts where something creeps or a joint is at work.
    /// Why: the rest of it has to pass without either.
    /// Scenes: slow motors, resting.
    /// Test: tests/sleeping.rs
    pub(crate) const WATCHED_AGAIN: f32 = 0.5;
    /// Rate of a joint that follows its velocity motor: share of its target.
    /// Why: a blocked motor has next to none.
    /// Scenes: motors blocked and free.
    /// Test: tests/sleeping.rs
    pub(crate) const FOLLOWED_SHARE: f32 = 0.1;
    /// What may be left between a joint and the balance of its motor or spring (m, rad).
    /// Why: a tenth of a millimetre and a milliradian are not seen.
    /// Scenes: servos and springs on their way.
    /// Test: tests/sleeping.rs
    pub(crate) const ARRIVED: [f32; 2] = [1.0e-4, 1.0e-3];
    /// Time that a rigid position motor may take for what is left at its present rate (s).
    /// Why: it has no time constant of its own.
    /// Scenes: servos on their way.
    /// Test: tests/sleeping.rs
    pub(crate) const RIGID_TIME: f32 = 1.0;
    /// Longest time that is reckoned with (s).
    /// Why: beyond it the rate is lost in rounding.
    /// Scenes: slow motors.
    /// Test: tests/sleeping.rs
    pub(crate) const MAX_TIME: f32 = 30.0;
    /// Longest time for which a spring is watched (s).
    /// Why: softer ones bear so little that whatever they touch holds them.
    /// Scenes: soft springs.
    /// Test: tests/sleeping.rs
    pub(crate) const MAX_WATCHED: f32 = 10.0;
}

/// What stands on what: see `joint_graph/support/` and `world/support/`.
pub(crate) mod support {
    /// Least cosine between a contact's normal and the vertical for one body to stand on the other.
    /// Why: 72° of slope; friction of more than 3 would be needed beyond.
    /// Scenes: support_gallery, arch, wedge, tower.
    /// Test: tests/support.rs
    pub(crate) const MIN_RISE: f32 = 0.3;
    /// Share of its limit at which friction counts as exhausted.
    /// Why: one per cent for what sweeps leave of an error.
    /// Scenes: support_gallery, pile.
    /// Test: tests/support.rs
    pub(crate) const EXHAUSTED_SHARE: f32 = 0.99;
    /// Slip above which a contact at its limit slides (m/s).
    /// Why: what one per cent more than friction holds gives in one step of 1/60 s.
    /// Scenes: support_gallery, pile, arch.
    /// Test: tests/support.rs
    pub(crate) const SLIDING_SPEED: f32 = 5.0e-4;
    /// Slip below which a contact that slid holds again (m/s).
    /// Why: a fifth of the speed above, so that verdicts do not flicker.
    /// Scenes: pile, arch.
    /// Test: tests/support.rs
    pub(crate) const HOLDING_SPEED: f32 = 1.0e-4;
    /// Relative speed above which two bodies do not rest on each other, whatever friction does (m/s).
    /// Why: what a body has that has fallen for a hundredth of a second.
    /// Scenes: pile, tower.
    /// Test: tests/support.rs
    pub(crate) const LEAVING_SPEED: f32 = 0.1;
    /// Relative speed below which they may rest on each other again (m/s).
    /// Why: half of the speed above.
    /// Scenes: pile, tower.
    /// Test: tests/support.rs
    pub(crate) const RESTING_SPEED: f32 = 0.05;
    /// Distance of a centre of mass inside its hull from which a body is supported: share of the hull's reach.
    /// Why: a body balanced on an edge is not supported.
    /// Scenes: support_gallery.
    /// Test: tests/support.rs
    pub(crate) const EDGE_SHARE: f32 = 1.0e-3;
    /// Time for which a body must be supported before that is an event (s).
    /// Why: contacts come and go while something settles.
    /// Scenes: pile, tower.
    /// Test: tests/support.rs
    pub(crate) const GAIN_TIME: f32 = 0.1;
}

/// What stands by thrust: see `world/support/arch_stability.rs`.
pub(crate) mod thrust {
    /// Share of its weight that the pushes on a braced unit may leave unbalanced.
    /// Why: stones of a falling arch balance to as much; less calls those that settle loose.
    /// Scenes: 102 scenes of arch, card_house and wedge.
    /// Test: tests/thrust.rs
    pub(crate) const UNBALANCED_SHARE: f32 = 0.05;
    /// Time in which gravity would give a body the speed below which it is quiet (s).
    /// Why: what has just been put together still settles.
    /// Scenes: 102 scenes of arch, card_house and wedge.
    /// Test: tests/thrust.rs
    pub(crate) const QUIET_TIME: f32 = 0.01;
    /// Least spread of the points that push a unit across the line along which they spread most: share of its reach.
    /// Why: about a line it tips.
    /// Scenes: wedge, card_house.
    /// Test: tests/thrust.rs
    pub(crate) const SPREAD_SHARE: f32 = 1.0e-2;
}

/// Graphs in which every body hangs on many paths: see `joint_graph/mesh.rs`.
pub(crate) mod sheets {
    /// Joints for each moving body from which on a graph is a sheet.
    /// Why: 1 in a chain or loop, 1.33 in a ladder, 1.43 in a rope bridge of 112 planks, 1.5 in a truss of bars in triangles, 2 in a square
    /// net; but 2 as well in a narrow footbridge whose planks are tied to both pieces of each rope.
    /// Scenes: joint_grid, rope_bridge, footbridge.
    /// Test: tests/stability.rs
    pub(crate) const SHEET: f32 = 1.75;
    /// Bodies below which a sheet is like any other graph.
    /// Why: its bounds are few, and it may be a footbridge.
    /// Scenes: joint_grid, rope_bridge.
    /// Test: tests/stability.rs
    pub(crate) const MIN_BODIES: usize = 400;
}

/// Which bounds are derived: see `joint_graph/hierarchy.rs`, `joint_graph/load_class.rs` and `world/solve_batches/wrap.rs`.
pub(crate) mod bounds {
    /// Mass from which on a body is heavy: share of the greatest mass of connected bodies. Below this share of what it is jointed to, a body
    /// hangs on that as on something fixed.
    /// Why: lighter ones stretch a structure little; pairs of joints would never meet heavy bodies where light pieces alternate.
    /// Scenes: rope_bridge, cable_car, hanging_chain, cranes.
    /// Test: tests/cranes.rs
    pub(crate) const HEAVY_SHARE: f32 = 0.1;
    /// Mass from which on one body keeps a chain straight that it hangs on, even where it swings: share of that of all.
    /// Why: 270 kg on 30 links of 1 kg hang straight.
    /// Scenes: swinging_weight at ratios of 1 to 10,000.
    /// Test: tests/long_range.rs
    pub(crate) const STRAIGHTENING_SHARE: f32 = 0.9;
    /// Joints that a bound must span in a long run or loop of heavy bodies alone.
    /// Why: over fewer joints sweeps do as much, and bounds that are nearly taut pull at a loop whose joints gape.
    /// Scenes: hinge_loop, track.
    /// Test: tests/long_range.rs
    pub(crate) const MIN_SPAN: u32 = 16;
    /// Bodies from which on such a run is long.
    /// Why: a random tree without short bounds gapes twice as far.
    /// Scenes: hinge_loop, branched_tree.
    /// Test: tests/long_range.rs
    pub(crate) const LONG_LINE: usize = 64;
    /// Joints that a bound must span in a chain that hangs bent.
    /// Why: below four nothing is gained, and from sixteen on it stretches by more than a hundredth of a per cent.
    /// Scenes: lifted_chain of 100 links.
    /// Test: tests/long_range.rs
    pub(crate) const MIN_SPAN_OF_BENT: u32 = 8;
    /// Joints on an edge past light bodies beyond which these get a hierarchy of their own.
    /// Why: what is strung over an obstacle is bounded by no straight line from end to end.
    /// Scenes: cable_car.
    /// Test: tests/long_range.rs
    pub(crate) const LONG_EDGE: u32 = 8;
    /// Joints on the path of a bound from which on it may be wrapped.
    /// Why: a chain takes several links to go around a drum.
    /// Scenes: cable_car with 2 and 3 cars, round and of 32 sides.
    /// Test: tests/long_range.rs
    pub(crate) const MIN_WRAPPED: u32 = 8;
    /// Share of its length from which on a bound is taken as straight.
    /// Why: rows along and across the line do more then.
    /// Scenes: cable_car, hanging_chain.
    /// Test: tests/long_range.rs
    pub(crate) const STRAIGHT_SHARE: f32 = 0.99;
}

/// Chains of parallel hinges: see `joint_graph/plane.rs`.
pub(crate) mod planes {
    /// Greatest angle between axes that count as parallel (rad).
    /// Why: 0.02°, far above the rounding of joint frames.
    /// Scenes: hinge_loop, track.
    /// Test: tests/hinge_planes.rs
    pub(crate) const PARALLEL: f32 = 3.5e-4;
    /// Greatest difference of heights around a loop: share of its longest lever.
    /// Why: far above the rounding of joint points.
    /// Scenes: hinge_loop with offsets, track.
    /// Test: tests/hinge_planes.rs
    pub(crate) const LEVEL: f32 = 1.0e-4;
    /// Fewest hinges of a chain.
    /// Why: sweeps bring fewer into line by themselves.
    /// Scenes: hinge_loop, arm.
    /// Test: tests/hinge_planes.rs
    pub(crate) const MIN_HINGES: usize = 3;
}

/// Stacks that are being put together: see `solve/momentum_pass.rs` and `solve/initial_impulses.rs`.
pub(crate) mod stacks {
    /// Least number of levels for which the pass is worth its time.
    /// Why: two sweeps carry load through two.
    /// Scenes: tower loose=on, large_pyramid.
    /// Test: tests/stacks.rs
    pub(crate) const MIN_LEVELS: u32 = 3;
    /// The same where masses are uneven.
    /// Why: two sweeps carry little of a load through a light body: 25 feet under a crate that falls by 1 mm end in the floor.
    /// Scenes: 9 to 49 feet under a crate of 10 to 2500 times the mass of each, 30 to 240 Hz.
    /// Test: tests/heavy_on_light.rs
    pub(crate) const MIN_UNEVEN_LEVELS: u32 = 2;
    /// Time in which gravity would give the sideways speed at which something passes what it touches, above which an island is left to the sweeps (s).
    /// Why: the pass would spread a blow through a tower that is hit: 138 to 917 blocks displaced instead of 65 to 74.
    /// Scenes: tower hit by a ball, 44 seeds; towers of planks that sway.
    /// Test: tests/stacks.rs
    pub(crate) const SIDEWAYS_TIME: f32 = 0.05;
    /// Time for which a body is being put where it is, once it was made or put there, if it stays below the sideways speed; and for which one
    /// that did not must stay below it (s).
    /// Why: a loosely built tower settles in 0.2 s; after four seconds nothing is being built any more, and a thrown body never qualifies.
    /// Scenes: tower loose=on, 20 seeds; tower hit by a ball, 44 seeds.
    /// Test: tests/stacks.rs
    pub(crate) const SETTLING_TIME: f32 = 4.0;
    /// Least energy that the pass must take out of an island: share of what gravity puts into it in a substep.
    /// Why: the sweeps do as well with less, and leave a stack that is loaded already as it is.
    /// Scenes: tower loose=on (a thousandth was tried: 2.1 s to settle instead of 0.17).
    /// Test: tests/stacks.rs
    pub(crate) const WORTHWHILE_SHARE: f64 = 1.0e-6;
    /// Relative normal speed above which a new contact is an impact, and gets no static load (m/s).
    /// Why: what a body has that has fallen for five milliseconds.
    /// Scenes: column, tower, pile.
    /// Test: tests/stacks.rs
    pub(crate) const MAX_REST_SPEED: f32 = 0.05;
}

/// Energy that sweeps may leave behind: see `solve/joint_energy.rs` and `solve/contact_energy/`.
pub(crate) mod energy {
    /// Kinetic energy after a substep's sweeps, over that before, beyond which their multipliers are worth nothing.
    /// Why: multipliers have grown from substep to substep then. Given up from 2 on, a mobile at a ratio of 1 stretches by 67 %; never given
    /// up, a thrown tree at a ratio of a million grows without end.
    /// Scenes: mobile, rope_bridge, violent at ratios up to a million.
    /// Test: tests/stability.rs
    pub(crate) const TORN: f64 = 1.0e3;
    /// Share of the motion of a joint's two sides, the greater of them, that its rows leave against each other, from which on it does not hold
    /// them.
    /// Why: sweeps that come near leave hundredths; what is flung against what hardly moves leaves all of it.
    /// Scenes: contradictory joints of all kinds, linkages at dead centre, ratios of 10 to 100,000, 30 to 240 Hz.
    /// Test: tests/overdetermined.rs
    pub(crate) const UNHELD: f32 = 0.5;
    /// The same as `TORN` where joints meet contacts, from which sweeps are done once more without what was carried.
    /// Why: from 2 on chains at 30 steps a second gape by 0.12 to 4.6 m instead of 0.03 to 0.13.
    /// Scenes: chains over posts and wound up by a driven box, ragdoll_pile.
    /// Test: tests/jammed.rs
    pub(crate) const AFRESH: f64 = 1.1;
}

/// Balls on smooth surfaces of triangles: see `world/surface_energy.rs`.
pub(crate) mod surface {
    /// Speed into a plane above which a ball hits it, over its whole speed.
    /// Why: 0.2 rad; at a sharper edge a ball without restitution loses more than 4 % of its energy, and nobody takes it for smooth.
    /// Scenes: bowls of 0.2 to 20 m, cells of an 80th to a 20th of that, 30 to 240 steps a second.
    /// Test: tests/bowls.rs
    pub(crate) const MAX_TURN: f32 = 0.2;
    /// The same of a ball that goes a quarter of it for every radius in a step, at most.
    /// Why: half a radian; in a small bowl a step turns as far, and what is beyond is a wall.
    /// Scenes: as above, marbles of 3 to 30 mm in a bowl of 0.2 m at 30 steps a second.
    /// Test: tests/bowls.rs
    pub(crate) const MAX_TURN_OF_FAST: f32 = 0.5;
    /// Speed of the surfaces across each other above which a ball rubs, over its speed.
    /// Why: an edge of 0.2 rad leaves a rolling ball half of that squared, 2 %; friction takes a few 1e-4 of the energy of such a slip.
    /// Scenes: as above, rolling and sliding.
    /// Test: tests/bowls.rs
    pub(crate) const MAX_SLIP: f32 = 0.02;
    /// Height by which rows and position recovery may lift or lower a ball in a step at its expense, over its radius.
    /// Why: where a swing turns there is no speed to take the share of, and the steps before have left it up to so much beside the surface.
    /// Scenes: as above; with 0 a ball of 3 cm in a bowl of 20 cm lost 25 to 50 % in 40 s.
    /// Test: tests/bowls.rs
    pub(crate) const MAX_SINK: f32 = 5.0e-3;
}

/// Needles that contacts push: see `solve/integrate.rs` and `solve/impact/gather.rs`.
pub(crate) mod needles {
    /// Inertia of a needle about its axis, over that across it (1): of 1 m by 3 cm.
    /// Why: a push at the rim of what is more slender spins it a thousand times as easily as it turns it over, and it may go round many times in
    /// a substep while its contacts are where they were: at a chance place they then push, and a heap of needles gains energy without end.
    /// Scenes: heaps of needles of 1 m by 2 mm.
    /// Test: tests/stress.rs
    pub(crate) const NEEDLE: f32 = 1.0e-3;
    /// Share of what an impact adds to velocities at which a body has turned too far since to be given it as it was found (1); its inverse, too.
    /// Why: at half of it a body hardly gets away from what it has hit. Below, the energy is that which the impact has left; above, at most that.
    /// Scenes: bars of 1:4 that turn by 0.2 rad in a substep need 0.9 to 1.1, sticks of 1:80 less than 0.1.
    /// Test: tests/elastic_bars.rs
    pub(crate) const FAR_SHARE: f64 = 0.5;
}

/// Positions of swept articulations without loops: see `solve/direct/block_constraint.rs`.
pub(crate) mod mending {
    /// Sum of the squares of the turns of substeps, of the body that turns most, up to which errors of positions wait for the end of the
    /// step (rad²).
    /// Why: rows that turn by θ leave gaps of θ²/2 of their levers, so that half a hundredth is left until then; three times as much saves no more.
    /// Scenes: ragdoll_rain, ragdoll_pile (0.003, 0.01 and 0.03 were tried: docs/lab/performance.md); track and hinge_loop have loops.
    /// Test: tests/ragdolls_at_rest.rs
    pub(crate) const MAX_TURNED: f64 = 0.01;
}

/// Loops of joints that have gaped: see `solve/newton/gaps.rs`.
pub(crate) mod gaping_loops {
    /// What is left of the sum of the squares of gaps, over what there was, below which bodies may turn further than rows are straight ways.
    /// Why: a loop of a random graph at 30 m/s has 106 of 300 steps left to others without, and 45 with it.
    /// Scenes: random graphs of joints with loops, thrown at 30 m/s.
    /// Test: tests/stress.rs
    pub(crate) const MENDED: f64 = 0.25;
    /// What is left of that sum, over what there was, above which a loop is not tried again.
    /// Why: joints that are all but in line, which only turning far would close, keep 0.95 and more of it.
    /// Scenes: random graphs of joints with loops, linkages at dead centre.
    /// Test: tests/stress.rs
    pub(crate) const STUCK: f64 = 0.8;
}
