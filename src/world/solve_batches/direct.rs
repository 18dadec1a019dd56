//! Chooses the articulations of a batch that are solved directly, and gathers their records.

use glam::{DMat3, DVec3, Mat3, Vec3};

use super::BatchInput;
use crate::body::BodyKind;
use crate::collide::curvature::{
    block_size, edge_of, is_block, normal_at, radius_over, shape_operator, shape_operator_with_rims,
};
use crate::settings::Solver;
use crate::shape::Shape;
use crate::solve::StepSettings;
use crate::solve::batch::{Batch, BatchManifolds};
use crate::solve::body_flags::BodyFlags;
use crate::solve::direct::BatchRecords;
use crate::solve::direct::round_on_block::RoundOnBlock;
use crate::solve::joint::{JointEntry, JointLink};
use crate::solve::newton::{Contents, IslandRecords, Surfaces, Tangency};
use crate::solve::state::WORLD_SLOT;
use crate::step_history::History;
use crate::workers::Workers;
use crate::world::islands::NO_BODY;
use crate::world::substep_multiplier::is_smooth;

/// How far an edge goes on of a block that something lies along (m).
const FAR: f64 = 1.0e9;

/// The records of what one batch has.
struct Within<'a> {
    world: &'a BatchInput<'a>,
    /// Body of each slot.
    bodies: &'a [u32],
    manifolds: &'a [(u32, u32)],
    body_flags: &'a [BodyFlags],
    /// By what carried multipliers grow, and how many substeps are taken at once.
    scale: f32,
    stride: f32,
}

impl BatchRecords for Within<'_> {
    fn body(&self, slot: u32) -> (DVec3, (History, bool)) {
        let index = self.bodies[slot as usize];
        let body = &self.world.bodies[index];
        let (center, velocities) = match self.world.unions.moving(index) {
            Some(union) => (union.motion.center, [union.motion.linear, union.motion.angular]),
            None => (body.center, [body.linear_velocity, body.angular_velocity]),
        };
        let (mut history, is_kicked) = (body.history.get(), self.body_flags[slot as usize].is_kicked());
        if is_kicked && [history.linear, history.angular] != velocities {
            history.strike();
        }
        (center, (history, is_kicked))
    }

    fn joint(&self, link: &JointLink) -> JointEntry {
        self.world.joint_entry(link, self.scale, self.stride)
    }

    fn curvature(&self, contact: u32, of_b: bool) -> Option<([DMat3; 2], f64)> {
        let (operators, reaches) = self.surfaces(contact, shape_operator)?;
        Some((operators, reaches[usize::from(of_b)]))
    }

    fn offset(&self, contact: u32) -> DVec3 {
        Within::offset(self, contact)
    }
}

impl IslandRecords for Within<'_> {
    fn joint(&self, link: &JointLink) -> JointEntry {
        self.world.joint_entry(link, self.scale, self.stride)
    }

    fn is_anchor(&self, link: &JointLink) -> bool {
        let is_fixed = |&body: &u32| body == NO_BODY || self.world.bodies[body].kind != BodyKind::Dynamic;
        self.world.groups.joint_heads[link.joint as usize].bodies.iter().any(is_fixed)
    }

    fn surfaces(&self, contact: u32) -> Option<Surfaces> {
        Within::surfaces(self, contact, shape_operator_with_rims)
    }

    fn offset(&self, contact: u32) -> DVec3 {
        Within::offset(self, contact)
    }

    fn on_block(&self, contact: u32) -> Option<RoundOnBlock> {
        let (slot, manifold) = self.manifolds[contact as usize];
        let pair = self.world.pairs.get(slot);
        let (a, b) = pair.key.shapes();
        let [a, b] = [a, b].map(|shape| &self.world.colliders[shape]);
        let round_is_b = is_block(&a.shape);
        if !round_is_b && !is_block(&b.shape) {
            return None;
        }
        let manifold = pair.manifolds.get(manifold as usize);
        let [to_a, to_b] = [a, b].map(|collider| collider.place.1);
        let (along, seen_from_b) = (manifold.normal, to_b.conjugate() * (to_a * -manifold.normal));
        let ((block, of_block), (round, of_round)) =
            if round_is_b { ((a, along), (b, seen_from_b)) } else { ((b, seen_from_b), (a, along)) };
        let edge = edge_of(&block.shape, of_block);
        let across = edge.map(|edge| round.place.1.conjugate() * (block.place.1 * edge));
        let on = |i: usize| manifold.points.get(i).map(|point| if round_is_b { point.on_b } else { point.on_a });
        let radius = radius_over(&round.shape, on(0)?, of_round, across)?;
        let centers = [round, block].map(|collider| self.world.center(collider.body));
        let turned = round.place.1.as_dquat().normalize();
        let middle = |at: Vec3| (at - of_round * radius.radius).as_dvec3();
        let middles = std::array::from_fn(|i| match on(i) {
            Some(at) if !radius.is_ball => round.place.0 - centers[0] + turned * middle(at),
            _ => round.place.0 - centers[0],
        });
        let (half, bend) = block_size(&block.shape);
        let endless = edge.filter(|_| !radius.is_ball).map_or(Vec3::ZERO, |edge| edge.abs());
        Some(RoundOnBlock {
            round_is_b,
            radii: [f64::from(radius.radius), f64::from(bend)],
            middles,
            place: block.place.0 - centers[1],
            rotation: block.place.1.as_dquat().normalize(),
            half: half.as_dvec3() + endless.as_dvec3() * FAR,
            apart: centers[0] - centers[1],
        })
    }

    fn tangency(&self, contact: u32) -> Tangency {
        let (slot, manifold) = self.manifolds[contact as usize];
        let pair = self.world.pairs.get(slot);
        let manifold = pair.manifolds.get(manifold as usize);
        let (a, b) = pair.key.shapes();
        let [a, b] = [a, b].map(|shape| &self.world.colliders[shape]);
        let [to_a, to_b] = [a, b].map(|collider| collider.place.1.as_dquat().normalize());
        let along = to_a * manifold.normal.as_dvec3();
        let seen_from_b = (to_b.conjugate() * -along).as_vec3();
        std::array::from_fn(|i| {
            let Some(point) = manifold.points.get(i) else { return (along, -along, DVec3::ZERO) };
            let of_a = to_a * normal_at(&a.shape, point.on_a, manifold.normal).as_dvec3();
            let of_b = to_b * normal_at(&b.shape, point.on_b, seen_from_b).as_dvec3();
            let offset = b.place.0 - a.place.0 + to_b * point.on_b.as_dvec3() - to_a * point.on_a.as_dvec3();
            (of_a, of_b, offset)
        })
    }
}

impl Within<'_> {
    /// How far the first point of a contact on B is from that on A (m, world axes).
    fn offset(&self, contact: u32) -> DVec3 {
        let (slot, manifold) = self.manifolds[contact as usize];
        let pair = self.world.pairs.get(slot);
        let manifold = pair.manifolds.get(manifold as usize);
        let (a, b) = pair.key.shapes();
        let [a, b] = [a, b].map(|shape| &self.world.colliders[shape]);
        let [to_a, to_b] = [a, b].map(|collider| collider.place.1.as_dquat());
        let point = &manifold.points[0];
        b.place.0 - a.place.0 + to_b * point.on_b.as_dvec3() - to_a * point.on_a.as_dvec3()
    }

    /// Surfaces of a contact, of which `operator` says how they bend.
    fn surfaces(&self, contact: u32, operator: impl Fn(&Shape, Vec3, Vec3) -> Option<Mat3>) -> Option<Surfaces> {
        let (slot, manifold) = self.manifolds[contact as usize];
        let pair = self.world.pairs.get(slot);
        let manifold = pair.manifolds.get(manifold as usize);
        let (a, b) = pair.key.shapes();
        let [a, b] = [a, b].map(|shape| &self.world.colliders[shape]);
        let [to_a, to_b] = [a, b].map(|collider| Mat3::from_quat(collider.place.1));
        let (point, along) = (&manifold.points[0], to_a * manifold.normal);
        let of_a = operator(&a.shape, point.on_a, manifold.normal)?;
        let other = operator(&b.shape, point.on_b, to_b.transpose() * -along)?;
        let in_world = |to_world: Mat3, operator: Mat3| {
            // In `f64`: what an edge bends by is a million times what other surfaces do.
            let to_world = to_world.as_dmat3();
            to_world * operator.as_dmat3() * to_world.transpose()
        };
        Some(([in_world(to_a, of_a), in_world(to_b, other)], [a.reach, b.reach].map(f64::from)))
    }
}

impl BatchInput<'_> {
    /// Moves what the direct solver can move by itself, and lays out rows for the rest.
    pub(super) fn lay_out(&self, batch: &mut Batch, settings: &StepSettings, threads: &Workers) {
        let mut h = settings.dt / settings.substeps as f32;
        let (scale, stride) = (self.scale_for(batch), batch.stride);
        let first_replica = batch.moving() as u32 + 1;
        let Batch { joints, direct, newton, islands, bodies, velocities, motions, body_flags, manifolds, .. } = batch;
        let BatchManifolds { list: manifolds, inputs, .. } = &*manifolds;
        let asks = |link: &JointLink| link.traits.solver == Solver::Direct;
        let is_direct = self.solver != Solver::GaussSeidel || joints.links.iter().any(asks);
        let grouped = if is_direct || self.some_are_fast { &joints.links[..] } else { &[] };
        direct.group_slots(grouped, body_flags);
        direct.solver = self.solver;
        if !is_direct {
            direct.clear();
            newton.clear();
        } else {
            let is_swept = |slot: u32| {
                let body = bodies[slot as usize];
                slot != WORLD_SLOT && self.swept.get(body as usize).is_some_and(|&swept| swept)
            };
            if !self.swept.is_empty() {
                joints.links.iter_mut().for_each(|link| link.is_withheld = is_swept(link.a) || is_swept(link.b));
            }
            let records = Within { world: self, bodies, manifolds, body_flags, scale, stride };
            let contents = Contents { islands, end: first_replica, velocities, motions, contacts: inputs };
            newton.step(&mut joints.links, contents, &records, (self.joints, settings, threads));
            direct.find_touching(inputs, (&*velocities, &*motions), h);
            direct.take(&mut joints.links, (velocities, motions), inputs, &records, threads);
            direct.step(self.joints, velocities, motions, inputs, settings, threads);
            let (direct, context) = batch.direct_and_context(threads);
            direct.get_ready(context, h);
        }
        self.write_entries(batch, threads);
        let may_be_smooth = settings.articulations.error_target == 0.0;
        let is_smooth = |&body: &u32| is_smooth(&self.bodies[body]);
        let substeps = batch.refine_sheet(settings.substeps, |batch| may_be_smooth && batch.bodies[1..].iter().all(is_smooth));
        h = settings.dt / substeps as f32;
        batch.color_contacts();
        let (scale, stride) = (self.scale_for(batch), batch.stride);
        batch.set_contacts(threads, self.reach * (stride * stride), |coming, ends| self.contact_input(coming, ends, scale));
        let Batch { joints, direct, layout, velocities, motions, body_flags, .. } = batch;
        joints.lay_out(
            (self.joints, direct.left_over()),
            threads,
            &mut layout.coloring,
            (velocities, motions, body_flags),
            h,
            substeps,
        );
    }
}
