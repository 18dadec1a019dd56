//! Where the two frames of a joint are: at the start of the substep, predicted for its end, and where its Jacobian is taken.

use glam::{DMat3, DQuat, DVec3};

/// A joint frame in world axes, relative to its body's centre of mass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WorldFrame {
    /// From the centre of mass to the joint point (m).
    pub lever: DVec3,
    /// Rotation of the joint frame.
    pub frame: DQuat,
}

/// Both sides at one moment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placement {
    pub a: WorldFrame,
    pub b: WorldFrame,
    /// From A's joint point to B's (m).
    pub gap: DVec3,
}

impl Placement {
    /// Rotation of B's frame in A's, with the shorter way round.
    pub(crate) fn relative_rotation(&self) -> DQuat {
        let q = self.a.frame.conjugate() * self.b.frame;
        if q.w < 0.0 { -q } else { q }
    }

    /// Gap in A's joint frame (m).
    pub(crate) fn local_gap(&self) -> DVec3 {
        self.a.frame.conjugate() * self.gap
    }

    /// Axes of A's joint frame, world coordinates.
    pub(crate) fn axes_a(&self) -> DMat3 {
        DMat3::from_quat(self.a.frame)
    }

    /// Rotation of B about A's joint axis, in [−π, π] (rad).
    pub(crate) fn twist(&self) -> f64 {
        let q = self.relative_rotation();
        2.0 * libm::atan2(q.x, q.w)
    }

    /// Rotation vector from A's frame to B's, in A's frame (rad).
    pub(crate) fn rotation_vector(&self) -> DVec3 {
        let q = self.relative_rotation();
        let axis = DVec3::new(q.x, q.y, q.z);
        let sine = axis.length();
        if sine < 1.0e-4 {
            return axis * 2.0;
        }
        axis * (2.0 * libm::atan2(sine, q.w) / sine)
    }

    /// Error of B's joint axis against A's as a rotation vector in A's frame: its y and z components (rad).
    pub(crate) fn axis_error(&self) -> DVec3 {
        let b = self.relative_rotation() * DVec3::X;
        let sine = (b.y * b.y + b.z * b.z).sqrt();
        let angle_over_sine = if sine < 1.0e-4 && b.x > 0.0 { 1.0 } else { libm::atan2(sine, b.x) / sine.max(1.0e-6) };
        DVec3::new(0.0, -b.z, b.y) * angle_over_sine
    }
}

/// The three placements that rows are built from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointGeometry<'a> {
    pub start: &'a Placement,
    pub predicted: &'a Placement,
    /// Where the Jacobian is taken (see [`super`]).
    pub gradient: &'a Placement,
    /// Whether start and prediction are one.
    pub is_still: bool,
}

impl<'a> JointGeometry<'a> {
    /// Everything at one moment.
    pub(crate) fn at(placement: &'a Placement) -> Self {
        Self { start: placement, predicted: placement, gradient: placement, is_still: true }
    }

    /// What is read off the start and off the prediction.
    pub(crate) fn read<T: Copy>(&self, value: impl Fn(&Placement) -> T) -> (T, T) {
        let start = value(self.start);
        (start, if self.is_still { start } else { value(self.predicted) })
    }
}
