//! A shape on a body as collision sees it.

use glam::{DVec3, Quat, Vec3};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose3;

use crate::body::Body;
use crate::material::{Material, PairMaterial};
use crate::shape::{CollisionFilter, LocalPose, Shape, ShapeDef};

/// Margin of the box that the broad phase keeps around a shape, as a share of the shape's extent, and its bounds (m).
const FAT_MARGIN_SHARE: f32 = 0.05;
const FAT_MARGIN_RANGE: (f32, f32) = (1.0e-3, 0.1);

/// Greatest reach that is used (m); a half-space has no end.
const MAX_REACH: f32 = 1.0e7;

/// Speculative margin beside relative motion: a share of the smaller shape's least extent, and its greatest value (m).
const CONTACT_MARGIN_SHARE: f32 = 0.05;
const MAX_CONTACT_MARGIN: f32 = 0.01;

/// The world's record of a shape.
#[derive(Debug, Clone)]
pub(crate) struct Collider {
    pub body: u32,
    pub shape: Shape,
    pub local_pose: LocalPose,
    pub material: Material,
    pub density: f32,
    pub filter: CollisionFilter,
    pub user_word: u64,
    pub sensor: bool,
    /// Distance from the body's centre of mass to the farthest point of the shape (m).
    pub reach: f32,
    /// Least extent of the shape's own box (m).
    pub least_extent: f32,
    /// Where the shape is: world position of its origin (m), and its rotation.
    pub place: (DVec3, Quat),
    /// Box that the shape cannot leave in this step (m, rounded outwards); that of the last step in which its body moved.
    pub tight_box: Aabb,
    /// Box kept by the broad phase (m, rounded outwards); none before the first update.
    pub fat_box: Option<Aabb>,
}

impl Collider {
    pub(crate) fn new(body: u32, def: &ShapeDef, local_center: Vec3) -> Self {
        let own_box = def.shape.parry().compute_local_aabb();
        let mut collider = Self {
            body,
            shape: def.shape.clone(),
            local_pose: def.local_pose,
            material: def.material,
            density: def.density,
            filter: def.filter,
            user_word: def.user_word,
            sensor: def.sensor,
            reach: 0.0,
            least_extent: own_box.extents().min_element(),
            place: (DVec3::ZERO, Quat::IDENTITY),
            tight_box: Aabb::new_invalid(),
            fat_box: None,
        };
        collider.center_moved(local_center);
        collider
    }

    /// The definition that the shape has now.
    pub(crate) fn def(&self) -> ShapeDef {
        ShapeDef {
            shape: self.shape.clone(),
            local_pose: self.local_pose,
            material: self.material,
            density: self.density,
            filter: self.filter,
            user_word: self.user_word,
            sensor: self.sensor,
        }
    }

    /// Gives the shape another definition; its boxes are no longer right.
    pub(crate) fn redefine(&mut self, def: &ShapeDef, local_center: Vec3) {
        *self = Self::new(self.body, def, local_center);
    }

    /// Tells the shape where its body's centre of mass is now.
    pub(crate) fn center_moved(&mut self, local_center: Vec3) {
        let sphere = self.shape.parry().compute_local_bounding_sphere();
        let center = self.local_pose.position + self.local_pose.rotation * sphere.center - local_center;
        self.reach = (center.length() + sphere.radius).min(MAX_REACH);
    }

    /// Takes note of where the body is now.
    pub(crate) fn follow(&mut self, body: &Body) {
        self.place = self.world_pose(body);
    }

    /// The two surfaces combined. It is asked of what touches alone; kept with every pair near enough to touch it would cost more.
    pub(crate) fn surface_with(&self, other: &Self) -> PairMaterial {
        PairMaterial::combine(&self.material, &other.material)
    }

    /// Pose of another shape in this one's frame.
    pub(crate) fn relative(&self, other: &Self) -> Pose3 {
        relative(self.place, other.place)
    }

    /// From the centre of mass of its body to the shape's origin (m, world axes).
    pub(crate) fn offset_on(&self, body: &Body) -> Vec3 {
        body.rotation * (self.local_pose.position - body.local_center)
    }

    /// World position of the shape's origin (m), and its rotation, on a body anywhere.
    pub(crate) fn world_pose(&self, body: &Body) -> (DVec3, Quat) {
        self.pose_with(body, body.center, body.rotation)
    }

    /// The same where the body's centre of mass is here (m) and the body is turned like this.
    pub(crate) fn pose_with(&self, body: &Body, center: DVec3, rotation: Quat) -> (DVec3, Quat) {
        let from_center = rotation * (self.local_pose.position - body.local_center);
        (center + from_center.as_dvec3(), rotation * self.local_pose.rotation)
    }

    /// World box of the shape where it is (m), rounded outwards, enlarged by `margin`.
    pub(crate) fn world_box(&self, margin: f32) -> Aabb {
        self.box_at(self.place, margin)
    }

    /// World box of the shape at a place (m), rounded outwards, enlarged by `margin`.
    pub(crate) fn box_at(&self, (position, rotation): (DVec3, Quat), margin: f32) -> Aabb {
        let local = self.shape.parry().compute_aabb(&Pose3::from_parts(Vec3::ZERO, rotation));
        let grown = Vec3::splat(margin);
        Aabb::new(
            rounded_down(position + (local.mins - grown).as_dvec3()),
            rounded_up(position + (local.maxs + grown).as_dvec3()),
        )
    }

    /// Margin of the kept box (m).
    pub(crate) fn fat_margin(&self) -> f32 {
        (self.least_extent * FAT_MARGIN_SHARE).clamp(FAT_MARGIN_RANGE.0, FAT_MARGIN_RANGE.1)
    }

    /// How far the shape may move in a step of `dt` seconds, gravity included (m).
    pub(crate) fn motion_bound(&self, body: &Body, gravity: f32, dt: f32) -> f32 {
        let falling = if body.is_dynamic() { gravity * body.settings.gravity_scale.abs() * dt } else { 0.0 };
        (body.linear_velocity.length() + body.angular_velocity.length() * self.reach + falling) * dt
    }
}

/// What a shape adds to a contact margin at most (m).
pub(crate) fn own_margin(shape: &Collider) -> f32 {
    margin_of(shape.least_extent)
}

/// The same of a shape with this least extent (m).
pub(super) fn margin_of(least_extent: f32) -> f32 {
    (least_extent.max(0.0) * CONTACT_MARGIN_SHARE).min(MAX_CONTACT_MARGIN)
}

/// Pose of one place in the frame of another.
pub(crate) fn relative((position, rotation): (DVec3, Quat), (other_position, other_rotation): (DVec3, Quat)) -> Pose3 {
    let inverse = rotation.conjugate();
    Pose3::from_parts(inverse * (other_position - position).as_vec3(), inverse * other_rotation)
}

fn rounded_down(v: DVec3) -> Vec3 {
    let nearest = v.as_vec3();
    nearest - rounding(nearest)
}

fn rounded_up(v: DVec3) -> Vec3 {
    let nearest = v.as_vec3();
    nearest + rounding(nearest)
}

/// At least what rounding to the nearest can have taken: branches on which way it went fail half of the time.
fn rounding(v: Vec3) -> Vec3 {
    v.abs() * f32::EPSILON + f32::MIN_POSITIVE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_rounded_outwards() {
        for x in [1.0e4 + 0.1, -1.0e4 - 0.1, 123_456.789, 0.0, 1.0e9, 1.0e-41, -1.0e-41, 1.0 + 3.0e-8, 2.0 - 3.0e-8] {
            let v = DVec3::splat(x);
            assert!(f64::from(rounded_down(v).x) <= x && f64::from(rounded_up(v).x) >= x, "{x} m");
        }
    }
}
