//! Whether a chain of parallel hinges stays in its plane.

use longspan::glam::{DMat3, DVec3, Vec3};

use super::{Errors, Metric, View, Worst};

/// A body of a chain of parallel hinges.
pub struct PlaneMember {
    /// The body.
    pub body: usize,
    /// Direction of the hinges in its frame.
    pub axis: Vec3,
    /// How far its centre lies from the plane of the chain along that direction (m).
    pub offset: f64,
}

/// `plane_rms_m` and `axis_rms_deg`: root mean square of the distances of all centres, each moved back along its own axis by its
/// offset, from the plane that fits them best; and of the angles between all axes and their mean. Both at the end.
pub struct HingePlane {
    members: Vec<PlaneMember>,
    distance: Worst,
    angle: Worst,
}

impl HingePlane {
    /// Of these bodies.
    pub fn new(members: Vec<PlaneMember>) -> Self {
        Self { members, distance: Worst::ZERO, angle: Worst::ZERO }
    }
}

impl Metric for HingePlane {
    fn observe(&mut self, view: &View) {
        if !view.at_end() {
            return;
        }
        let axis_of = |member: &PlaneMember| {
            view.engine.pose(member.body).rotation.as_dquat().normalize() * member.axis.as_dvec3().normalize()
        };
        let axes: Vec<DVec3> = self.members.iter().map(axis_of).collect();
        let points: Vec<DVec3> =
            self.members.iter().zip(&axes).map(|(member, axis)| view.center(member.body) - member.offset * *axis).collect();
        let count = points.len() as f64;
        let rms = |squares: f64| (squares / count).sqrt();

        let mean = points.iter().sum::<DVec3>() / count;
        let normal = smallest_axis(points.iter().map(|&point| point - mean));
        self.distance.note(rms(points.iter().map(|&point| (point - mean).dot(normal).powi(2)).sum()));
        let mean_axis = axes.iter().sum::<DVec3>().normalize();
        // By the chord, which keeps its digits where the cosine is close to one.
        let angle = |axis: &DVec3| 2.0 * (0.5 * axis.distance(mean_axis)).min(1.0).asin();
        self.angle.note(rms(axes.iter().map(|axis| angle(axis).powi(2)).sum()).to_degrees());
    }

    fn report(&self, errors: &mut Errors) {
        errors.extend([("plane_rms_m", self.distance.value()), ("axis_rms_deg", self.angle.value())]);
    }
}

/// The direction in which vectors from their mean spread least: the eigenvector of Σ v·vᵀ of the smallest eigenvalue, by cyclic
/// Jacobi rotations.
pub fn smallest_axis(vectors: impl Iterator<Item = DVec3>) -> DVec3 {
    let mut matrix = vectors.fold(DMat3::ZERO, |sum, v| sum + DMat3::from_cols(v * v.x, v * v.y, v * v.z));
    let mut axes = DMat3::IDENTITY;
    for _ in 0..30 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = matrix.col(q)[p];
            if off == 0.0 {
                continue;
            }
            // The rotation in the plane of p and q that makes their entry zero.
            let angle = 0.5 * (2.0 * off).atan2(matrix.col(q)[q] - matrix.col(p)[p]);
            let (sin, cos) = angle.sin_cos();
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = cos;
            turn.col_mut(q)[q] = cos;
            turn.col_mut(q)[p] = sin;
            turn.col_mut(p)[q] = -sin;
            matrix = turn.transpose() * matrix * turn;
            axes *= turn;
        }
    }
    let least = (0..3).min_by(|&a, &b| matrix.col(a)[a].total_cmp(&matrix.col(b)[b])).unwrap_or(0);
    axes.col(least)
}

#[cfg(test)]
mod tests {
    use longspan::glam::DQuat;

    use super::*;

    #[test]
    fn the_smallest_axis_is_the_normal_of_a_tilted_plane() {
        let turn = DQuat::from_euler(longspan::glam::EulerRot::XYZ, 0.7, -0.4, 1.1);
        let points = (0..50).map(|index| {
            let angle = f64::from(index) * 0.7;
            turn * DVec3::new(3.0 * angle.cos(), 2.0 * angle.sin(), 1e-6 * (3.0 * angle).cos())
        });
        let normal = smallest_axis(points);
        let off = 1.0 - normal.dot(turn * DVec3::Z).abs();
        assert!(off < 1e-10, "the normal is off by a cosine of {off:e}, bound 1e-10");
    }
}
