//! Which solver an island gets: see `solve/plan.rs`.

/// How often the substeps are halved of a step that opens joints, or gains energy, where contacts press.
/// Why: links of 0.3 m under a box of 30 kg that falls by 0.7 m turn by half a radian in 1/120 s, which opens their joints by a tenth of their length;
/// in a quarter of that by less than a hundredth, which is closed.
/// Scenes: net at 30 to 240 Hz, a tenth and ten times as large.
/// Test: tests/catalogue.rs
pub(crate) const MAX_HALVINGS: u32 = 2;
/// Work budgets that all tries at a step share, and those beyond which no further try is begun.
/// Why: with a budget for each try, and a least number of factors, a truss that broke up took 20 budgets in a step; with 2 and 3, boxes fell through a
/// net at 30 Hz. A heavy load may take 3 at its first try.
/// Scenes: net at 30 to 240 Hz; trusses, rafts, tents, armour and slings that break up or are struck.
/// Test: tests/catalogue.rs
pub(crate) const SHARED_BUDGETS: f64 = 4.0;
/// Why: the same.
/// Scenes: the same.
/// Test: tests/catalogue.rs
pub(crate) const MOST_BUDGETS: f64 = 6.0;
/// Turn in a step of what the host moves, across a contact with a few bodies, from which on they are solved as one with it (rad).
/// Why: sweeps have one normal in a step. A ball that a flipper turned by 0.1 rad a step throws leaves at 0.89 of its speed by sweeps, by 0.03 rad at
/// 0.95. A turntable turns along the normal, and what is many times more lies in drums.
/// Scenes: balls of 1 to 50 cm on boxes and capsules that turn by 0.03 to 1.3 rad a step.
/// Test: tests/flippers.rs
pub(crate) const BATTED: f32 = 0.02;
/// Mass of what presses, over that of what a joint holds against it, from which on sweeps do not bear it.
/// Why: a net of rods of 0.2 kg and 316 knots bears boxes of 8 kg by sweeps, and lets all of 30 kg fall through; planks of 10 kg bear
/// walkers of 100 kg.
/// Scenes: nets of rods and ropes under boxes, rope bridges under walkers.
/// Test: tests/ropes.rs
pub(crate) const HEAVY: f32 = 50.0;
/// Greatest mass over the least up to which sweeps carry the loads of what nothing fixed holds, and direct solves those of a loop that
/// touches nothing.
/// Why: sweeps take a body that is pushed for as heavy as it is alone. What joints hold to the world is as heavy as the world in all
/// directions but those it may move in: fingers of a kilogram on a moved palm drop two kilograms by 25 mm at any ratio. What is free is
/// no heavier than all of it, and keeps its angular momentum in sweeps and direct solves, where geometric stiffness resists turns of the
/// whole: a free loop of six hinges that touches itself loses nearly all of it. A loop that stands on something fixed has none to keep: a
/// tower of struts and cables of like masses sinks by 3 to 5 cm where it is swept.
/// Scenes: ragdoll_rain, grippers, loops of hinges, towers of struts and cables.
/// Test: tests/spans.rs
pub(crate) const ALIKE: f32 = 5.0;
/// Least cosine between a contact's normal and the vertical for one body to stand on the other, rather than lean on its side.
/// Why: 41°, less than 45°, at which arches have joints whose stones are a multiple of four: at 0.7 one of eight stones was swept, and sank by
/// 0.9 mm in its first step for 1e-6 with seven or nine. From half-way up joints of arches are steeper, stones of stacks lie flat.
/// Scenes: arches of 7 to 31 stones, towers, columns.
/// Test: tests/arches.rs
pub(crate) const STANDS: f32 = 0.75;
/// Bodies of a row that lean on their sides alone from which on sweeps, which pass a load on by one contact at a time, do not bear it.
/// Why: of an arch of seven stones three do, and it sinks by 0.6 mm at 30 Hz where it is swept; of 17 seven, and it sinks by 17 mm; of 31
/// fifteen, and by 53.
/// Scenes: arches of 7 to 31 stones at 30 to 240 Hz.
/// Test: tests/arches.rs
pub(crate) const LEANING: u32 = 3;
/// How far aside of the middle of its points a contact of a row bears its load for the row to be solved as one, over the way to the farthest
/// point.
/// Why: sweeps pass a moment on by one contact at a time, and what bears all the moments of a stack tips in its own time. A platform that gains
/// speed at 0.38 m/s² has a stack of three cubes bear 0.08 aside, and its top leans by 0.08 % of a cube where it is swept; of five 0.14 and
/// 0.8 %, of seven 0.19 and 3 %, of ten 0.27 and 66 %, and they fall. Once it has stopped, 14 that still bear 0.07 aside and are swept
/// from there on lean by 5 % within a second at 30 steps a second, as sweeps keep what is carried. What stands straight bears in the middle to
/// rounding. Rows whose ground moves are solved as one without that: waited for 0.1, ten lean by 6 %.
/// Scenes: stacks of 4 to 20 cubes of 0.06 to 6 m on platforms that go to and fro and stop, at 30 to 240 Hz, and on the ground, pushed.
/// Test: tests/moved_bodies.rs
pub(crate) const ASIDE: f32 = 3.0e-3;
/// Bodies of a row from which on, and up to which, it is solved as one for its ground or its moments.
/// Why: a stack of n cubes tips at g/n. Of four that are swept at 60 steps a second the top leans by 0.3 % of a cube at 0.38 m/s², and they come
/// back; short ones are most of what a heap has. Of 64 they tip at 0.15 m/s², so that nothing carries more of them. Solved as one, each takes
/// twenty times as long as swept; towers of a thousand that a ball hits are swept.
/// Scenes: stacks of 3 to 20 cubes on platforms, towers of 200 to 1,000 blocks, piles.
/// Test: tests/moved_bodies.rs
pub(crate) const TALL: [u32; 2] = [5, 64];
/// Speed against one another (m/s) and spin (rad/s) up to which bodies are at rest, for what is solved as one because it leans.
/// Why: those below which bodies fall asleep unless the host sets others. What leans and is solved as one has speeds of micrometres a second, and what
/// falls passes both within a tenth of a second.
/// Scenes: card houses of 3 to 10 levels, arches of 3 to 7 stones, at 30 to 240 Hz, a tenth and ten times as large.
/// Test: tests/leaning.rs
pub(crate) const RESTING: [f32; 2] = [0.05, 0.1];
/// How far aside of what bears it a body's centre of mass is for it to lean, over how far that reaches.
/// Why: what stands has its centre of mass over what bears it, a card that leans by 20° has it 0.17 m aside of its foot; a block that stands on its
/// edge to rounding is neither.
/// Scenes: card houses, arches, towers.
/// Test: tests/leaning.rs
pub(crate) const BESIDE: f32 = 1.0e-3;
/// Contacts for each body up to which bodies that lean, were put where they are and are at rest are solved as one.
/// Why: rough bodies with two contacts each have as many unknown forces as equations. A load has one way to the ground then: what sweeps
/// leave of it moves the whole, and one factor holds it. With more there are other ways, sweeps find one of them, and to find out which
/// contacts slip takes many factors: a heap of 60 boxes that fell, with 144 contacts, takes steps of 14 ms for 0.3 where it is solved as one.
/// Scenes: card houses (1.8 for each body), arches (1.2), heaps of boxes (1.8 to 3).
/// Test: tests/leaning.rs
pub(crate) const SPARSE: u32 = 2;
