//! Chooses how many of the world's substeps an island takes at once.
//!
//! Where joints are swept with contacts, or as a sheet, or solved as one with contacts, a substep costs the same whether anything happens
//! in it or not. Multipliers that are carried are exact where forces stay what they were, and only what has changed along the substep has to be
//! found. So an island takes two substeps at once once it has been *smooth* for [`SMOOTH_TIME`]:
//!
//! * all its joints are those of articulations that are swept as blocks with their contacts, or all of it is one sheet or one problem;
//! * no velocity has changed in a step by more than [`SMOOTH_SHARE`] of what gravity adds in it, at the centre or by turning at the
//!   reach of the body's shapes: what has been struck, falls or slips is not smooth;
//! * no body has turned by more than [`SMOOTH_TURN`], so that rows of joints last for the step;
//! * nothing overlaps by more than [`SMOOTH_OVERLAP`]: overlaps are mended by substeps.
//!
//! The first step in which one of these does not hold is followed by steps of all substeps. Multipliers in records are those of the world's
//! substep, whatever the island has taken. Not where the world has few substeps as it is, nor where an error target is set. A sheet takes
//! several substeps for each of a world that has fewer than four, or fewer than two while it is smooth (*solve/joint_mesh.rs*).

use glam::Vec3;

use super::{Collision, Islands, LastStep, World};
use crate::body::Body;
use crate::tuning::stride::{SMOOTH_OVERLAP, SMOOTH_SHARE, SMOOTH_TIME, SMOOTH_TURN};

/// Substeps that a smooth island takes at once, and the least that a world must have for that.
const STRIDE: u32 = 2;
const MIN_SUBSTEPS: u32 = 4;

/// What a smooth body may do in a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Smoothness {
    /// Change of velocity (m/s), and spin (rad/s).
    change: f32,
    spin: f32,
}

impl Smoothness {
    /// Counts a step of `dt` (s) in which a body of this reach (m) had these velocities before, and now has those of its record; whether it has
    /// been smooth for long enough.
    pub(super) fn count(&self, body: &mut Body, [linear, angular]: [Vec3; 2], reach: f32, dt: f32) -> bool {
        let change = (body.linear_velocity - linear).length() + (body.angular_velocity - angular).length() * reach;
        let keeps_on = change < self.change && body.angular_velocity.length() < self.spin;
        body.times.smooth_for.count(keeps_on, dt);
        is_smooth(body)
    }
}

/// Whether a body has been smooth for long enough.
pub(super) fn is_smooth(body: &Body) -> bool {
    body.times.smooth_for.reaches(SMOOTH_TIME)
}

impl World {
    /// What bodies may do in a step of this length (s) to be smooth.
    pub(super) fn smoothness(&self, dt: f32) -> Smoothness {
        Smoothness { change: SMOOTH_SHARE * self.def.gravity.length() * dt, spin: SMOOTH_TURN / dt }
    }

    /// Says how many substeps each island takes at once.
    pub(super) fn choose_strides(&mut self) {
        let Self {
            islands: Islands { groups, summaries, hold, .. },
            collision: Collision { touches, pairs, index, .. },
            unions,
            def,
            last: LastStep { has_smooth_bodies, .. },
            ..
        } = self;
        let mut strides = std::mem::take(&mut groups.strides);
        strides.clear();
        let may_stride = def.substeps >= MIN_SUBSTEPS && def.substeps % STRIDE == 0 && def.articulations.error_target == 0.0;
        if may_stride && *has_smooth_bodies {
            strides.extend(groups.islands().map(|members| {
                let is_smooth = |&index: &u32| summaries.of(index).is_smooth() && unions.moving(index).is_none();
                let is_jointed = |&index: &u32| summaries.of(index).is_jointed();
                let is_still = |index: &u32| hold.units.members.has(*index);
                if members.iter().all(|index| is_still(index) || is_smooth(index)) && members.iter().any(is_jointed) {
                    STRIDE
                } else {
                    1
                }
            }));
        }
        if strides.iter().any(|&stride| stride > 1) {
            for touch in touches.touching() {
                let Some(body) = touch.bodies.into_iter().find(|&body| index.free.has(body)) else { continue };
                let stride = &mut strides[groups.island[body as usize] as usize];
                let overlaps = || {
                    let mut manifolds = pairs.get(touch.slot).manifolds.iter();
                    manifolds.any(|manifold| manifold.points.iter().any(|point| point.separation < -SMOOTH_OVERLAP))
                };
                if *stride > 1 && overlaps() {
                    *stride = 1;
                }
            }
        }
        groups.strides = strides;
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use crate::{BodyDef, BodyId, JointDef, JointKind, Pose, Shape, ShapeDef, SleepSettings, Solver, World, WorldDef};

    /// Balls of a square sheet on a side.
    const SIDE: usize = 22;

    /// Whether each batch of the next step is a sheet, and how many substeps it takes at once.
    fn strides(world: &mut World) -> Vec<(bool, f32)> {
        world.step(1.0 / 60.0).unwrap();
        world.batches.list[..world.batches.count]
            .iter()
            .zip(&world.batches.stages)
            .map(|(batch, stages)| (stages.joint_mesh.is_one(), batch.stride))
            .collect()
    }

    /// A sheet under a row of balls that are fixed, and its last ball.
    fn mesh(substeps: u32) -> (World, BodyId) {
        let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
        let mut world = World::new(&WorldDef { solver: Solver::GaussSeidel, sleep, substeps, ..WorldDef::default() }).unwrap();
        let mut balls = Vec::new();
        for (column, row) in (0..SIDE * SIDE).map(|ball| (ball / SIDE, ball % SIDE)) {
            let pose = Pose::at_xyz(column as f64, -(row as f64), 0.0);
            let def = if row == 0 { BodyDef::fixed(pose) } else { BodyDef::dynamic(pose) };
            balls.push(world.create_body(&def.with_shape(ShapeDef::new(Shape::ball(0.1).unwrap()))).unwrap());
            let neighbours = [(row > 0, 1, Vec3::NEG_Y), (row > 0 && column > 0, SIDE, Vec3::X)];
            for (_, back, way) in neighbours.into_iter().filter(|&(is_there, ..)| is_there) {
                let (ball, other) = (balls[balls.len() - 1], balls[balls.len() - 1 - back]);
                world.create_joint(&JointDef::new(JointKind::SPHERICAL, other, ball).at(way * 0.5, way * -0.5)).unwrap();
            }
        }
        (world, balls[SIDE * SIDE - 1])
    }

    #[test]
    fn a_sheet_that_hangs_takes_two_substeps_at_once_until_it_is_struck() {
        let (mut world, ball) = mesh(4);
        assert_eq!(strides(&mut world), [(true, 1.0)], "as it is let go");
        for _ in 0..90 {
            world.step(1.0 / 60.0).unwrap();
        }
        assert_eq!(strides(&mut world), [(true, 2.0)], "as it hangs");
        world.add_impulse(ball, Vec3::Z).unwrap();
        assert_eq!(strides(&mut world), [(true, 1.0)], "as it is struck");
    }

    #[test]
    fn a_sheet_takes_four_substeps_of_a_world_that_has_fewer_and_its_joints_bear_what_hangs_on_them() {
        for substeps in 1..4 {
            let (mut world, _) = mesh(substeps);
            assert_eq!(strides(&mut world), [(true, substeps as f32 / 4.0)], "as it is let go, {substeps} substeps");
            for _ in 0..120 {
                world.step(1.0 / 60.0).unwrap();
            }
            let taken = (substeps as f32 / 2.0).min(1.0);
            assert_eq!(strides(&mut world), [(true, taken)], "as it hangs, {substeps} substeps");
            let gap = world.report().residuals.joint_gap;
            assert!(gap < 1.0e-3, "{substeps} substeps: {gap} m");
            let borne: f32 = world
                .joints
                .iter()
                .filter(|(_, joint)| joint.bodies[0].is_some_and(|body| !world.bodies[body].is_free()))
                .map(|(_, joint)| joint.force.y.abs())
                .sum();
            let weight = 9.81
                * world
                    .bodies
                    .iter()
                    .filter(|(_, body)| body.is_free())
                    .filter_map(|(_, body)| body.mass.as_ref())
                    .map(|mass| mass.mass)
                    .sum::<f32>();
            assert!((borne / weight - 1.0).abs() < 0.02, "{substeps} substeps: {borne} N of {weight} N");
        }
    }
}
