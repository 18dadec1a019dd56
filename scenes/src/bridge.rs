//! A rope bridge (Müller et al. 2017, Fig. 15): planks on two foot ropes, two rails, and hangers between them.
//!
//! n planks of 10 kg (half-extents 0.1 × 0.025 × 0.85 m) at a horizontal pitch of 0.3 m on the parabola y = −4·sag·u(1 − u),
//! u = x/span, span = 0.3·(n + 1) m, tilted along it. On each side one foot-rope piece at z = ±0.8 m from edge to edge of
//! neighbouring planks and from the ends to the fixed anchors; one hanger, 1 m up from the middle of each plank's side; rail
//! pieces between the tops of neighbouring hangers, those at the four ends split in two. Every piece has 0.2 kg. Where
//! two rail pieces meet, each has a ball joint to the hanger. That makes 7·n + 8 bodies beside the anchors and 10·n + 12 ball joints:
//! 792 and 1132 for 112 planks. What the planks weigh is spread evenly along x, so a parabola is close to its rest state.
//!
//! No part of the bridge touches another; with `walk=on` a box of 100 kg is pushed over it at 2 m/s and touches the planks; it
//! may tumble along the bridge, not off it.

use longspan::glam::{DVec3, Vec3};
use longspan::{BodyDef, CollisionFilter, LockedAxes, Pose};

use crate::assemble::{INTANGIBLE, filtered, rod, solid, x_to};
use crate::metrics::{JointGap, Reading, Stretch};
use crate::params::{Params, SceneError};
use crate::scene::{Action, Scene, cuboid, start, with_friction};

const PITCH: f64 = 0.3;
const PLANK_HALF: Vec3 = Vec3::new(0.1, 0.025, 0.85);
const PLANK_MASS: f32 = 10.0;
const FOOT_ROPE_Z: f64 = 0.8;
const HANGER: f64 = 1.0;
const PIECE_MASS: f32 = 0.2;
const PIECE_RADIUS: f32 = 0.02;
/// Errors count over the last two seconds.
const LAST: u32 = 120;

const PLANK: CollisionFilter = CollisionFilter { member_of: 2, collides_with: 4 };
const WALKER: CollisionFilter = CollisionFilter { member_of: 4, collides_with: 2 };
const WALKER_HALF: f32 = 0.3;
const WALKER_MASS: f32 = 100.0;
const WALKER_SPEED: f32 = 2.0;
/// Greatest push (N): enough against friction and the steepest part.
const WALKER_PUSH: f32 = 1000.0;

/// A series of joints and its length at rest (m).
type Path = (Vec<usize>, f64);

/// The curve that the planks lie on.
#[derive(Clone, Copy)]
struct Curve {
    span: f64,
    sag: f64,
}

impl Curve {
    fn at(self, x: f64) -> DVec3 {
        let u = x / self.span;
        DVec3::new(x, -4.0 * self.sag * u * (1.0 - u), 0.0)
    }

    fn along(self, x: f64) -> DVec3 {
        DVec3::new(1.0, -4.0 * self.sag / self.span * (1.0 - 2.0 * x / self.span), 0.0).normalize()
    }
}

pub(crate) fn rope_bridge(params: &mut Params) -> Result<Scene, SceneError> {
    let count = params.count("planks", 112, 2..=5000)?;
    let sag = params.number("sag", 2.0, 0.01..=1000.0)?;
    let walk = params.switch("walk", false)?;
    let curve = Curve { span: PITCH * (count + 1) as f64, sag };
    // Up to the last planks: beyond them is nothing to walk on.
    let across = (curve.span - 3.0).max(0.5) / f64::from(WALKER_SPEED);
    let mut scene = start(params, if walk { across } else { 8.0 })?;

    let anchor = cuboid(0.1, 0.1, 1.0)?;
    let ends = [0.0, curve.span].map(|x| {
        let beyond = if x > 0.0 { 0.1 } else { -0.1 };
        scene.body(filtered(BodyDef::fixed(Pose::at_xyz(x + beyond, 0.0, 0.0)).with_shape(anchor.clone()), INTANGIBLE))
    });
    let wood = with_friction(cuboid(PLANK_HALF.x, PLANK_HALF.y, PLANK_HALF.z)?, 0.3);
    let planks: Vec<usize> = (1..=count)
        .map(|index| {
            let x = PITCH * index as f64;
            let pose = Pose::at(curve.at(x)).rotated(x_to(curve.along(x)));
            scene.body(filtered(solid(pose, wood.clone(), PLANK_MASS), PLANK))
        })
        .collect();
    let mut ropes = Vec::new();
    for side in [-1.0, 1.0] {
        ropes.push(foot_rope(&mut scene, curve, ends, &planks, side * FOOT_ROPE_Z)?);
        add_rail(&mut scene, curve, ends, &planks, side * f64::from(PLANK_HALF.z))?;
    }

    let last = if walk { scene.steps } else { LAST };
    scene.judge(Stretch::worst_of(ropes, last));
    scene.judge(JointGap::over_last(last));
    let middle = [planks[(count - 1) / 2], planks[count / 2]];
    scene.judge(Reading::mean_of_last(last, "mid_sag_m", move |view| {
        -middle.map(|plank| view.center(plank).y).iter().sum::<f64>() / 2.0
    }));
    if walk {
        add_walker(&mut scene, curve)?;
    }
    Ok(scene)
}

/// A piece of rope between two points.
fn piece(scene: &mut Scene, from: DVec3, to: DVec3) -> Result<usize, SceneError> {
    let radius = PIECE_RADIUS.min(0.4 * from.distance(to) as f32);
    Ok(scene.body(filtered(rod(from, to, radius, PIECE_MASS)?, INTANGIBLE)))
}

/// From anchor to anchor by way of every plank, at this z.
fn foot_rope(scene: &mut Scene, curve: Curve, ends: [usize; 2], planks: &[usize], z: f64) -> Result<Path, SceneError> {
    let edge = |x: f64, side: f64| curve.at(x) + side * f64::from(PLANK_HALF.x) * curve.along(x) + DVec3::Z * z;
    let mut joints = Vec::new();
    let mut length = 0.0;
    let mut held = (ends[0], curve.at(0.0) + DVec3::Z * z);
    for index in 0..=planks.len() {
        let x = PITCH * (index + 1) as f64;
        let next = planks.get(index).copied();
        let to = if next.is_some() { edge(x, -1.0) } else { curve.at(curve.span) + DVec3::Z * z };
        let rope = piece(scene, held.1, to)?;
        joints.push(scene.tie(held.0, rope, held.1));
        joints.push(scene.tie(rope, next.unwrap_or(ends[1]), to));
        length += held.1.distance(to) + if next.is_some() { 2.0 * f64::from(PLANK_HALF.x) } else { 0.0 };
        held = (next.unwrap_or(ends[1]), edge(x, 1.0));
    }
    Ok((joints, length))
}

/// A rail from anchor to anchor over the tops of the hangers that stand on every plank's side at this z.
fn add_rail(scene: &mut Scene, curve: Curve, ends: [usize; 2], planks: &[usize], z: f64) -> Result<(), SceneError> {
    let over = |x: f64| curve.at(x) + DVec3::new(0.0, HANGER, z);
    let mut nodes: Vec<DVec3> = (0..=planks.len() + 1).map(|index| over(PITCH * index as f64)).collect();
    let last = nodes.len() - 1;
    let split = [0.5 * (nodes[0] + nodes[1]), 0.5 * (nodes[last - 1] + nodes[last])];
    nodes.insert(last, split[1]);
    nodes.insert(1, split[0]);

    let pieces: Vec<usize> = nodes.windows(2).map(|pair| piece(scene, pair[0], pair[1])).collect::<Result<_, _>>()?;
    let count = pieces.len();
    scene.tie(ends[0], pieces[0], nodes[0]);
    scene.tie(pieces[0], pieces[1], nodes[1]);
    for (index, &plank) in planks.iter().enumerate() {
        // The first two nodes are the anchor and the middle of the split piece.
        let top = nodes[index + 2];
        let foot = top - DVec3::Y * HANGER;
        let hanger = piece(scene, top, foot)?;
        scene.tie(plank, hanger, foot);
        scene.tie(hanger, pieces[index + 1], top);
        scene.tie(hanger, pieces[index + 2], top);
    }
    scene.tie(pieces[count - 2], pieces[count - 1], nodes[count - 1]);
    scene.tie(pieces[count - 1], ends[1], nodes[count]);
    Ok(())
}

/// A box that starts on the first planks and is pushed along x at a walk, with what force that takes up to a bound.
fn add_walker(scene: &mut Scene, curve: Curve) -> Result<(), SceneError> {
    let shape = with_friction(cuboid(WALKER_HALF, WALKER_HALF, WALKER_HALF)?, 0.3);
    let x = 2.5 * PITCH;
    let up = DVec3::new(-curve.along(x).y, curve.along(x).x, 0.0);
    let pose = Pose::at(curve.at(x) + up * f64::from(PLANK_HALF.y + WALKER_HALF + 0.01)).rotated(x_to(curve.along(x)));
    // It tumbles over the gaps between planks, but not off them: nothing on a side would hold it.
    let locked = LockedAxes { translation: [false, false, true], rotation: [true, true, false] };
    let walker = scene.body(BodyDef { locked_axes: locked, ..filtered(solid(pose, shape, WALKER_MASS), WALKER) });
    let steps = scene.steps;
    scene.judge(Reading::after(steps, "walked_m", move |view| view.center(walker).x - x));
    // From where the bridge hangs unloaded: what falls off it is far away.
    scene.judge(Reading::after(steps, "off_m", move |view| {
        let center = view.center(walker);
        (center - curve.at(center.x)).length()
    }));
    for step in 0..steps {
        let push = Action::PushTo { body: walker, along: Vec3::X, speed: WALKER_SPEED, most: WALKER_PUSH };
        scene.at(step, push);
    }
    Ok(())
}
