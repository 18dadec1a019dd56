//! The kinds of joints that a motor may drive, for tests that go through all of them.

use longspan::glam::Quat;
use longspan::{Axis, JointKind, Limits, Motor};

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    Hinge,
    Slider,
    Distance,
    Slide,
    Turn,
}

pub const KINDS: [Kind; 5] = [Kind::Hinge, Kind::Slider, Kind::Distance, Kind::Slide, Kind::Turn];

impl Kind {
    /// Whether its coordinate is an angle.
    pub fn turns(self) -> bool {
        matches!(self, Self::Hinge | Self::Turn)
    }

    /// Number of the axis that the motor drives.
    pub fn axis(self) -> u32 {
        [0, 0, 0, 1, 5][self as usize]
    }

    /// The joint, and the rotation of its frames that has it drive along y or about z.
    pub fn joint(self, motor: Motor, limits: Limits) -> (JointKind, Quat) {
        let (free, held) = (Axis { limits, motor }, Axis::LOCKED);
        let about_z = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
        match self {
            Self::Hinge => (JointKind::Hinge { limits, motor }, about_z),
            Self::Slider => (JointKind::Prismatic { limits, motor }, Quat::from_rotation_z(std::f32::consts::FRAC_PI_2)),
            Self::Distance => (JointKind::Distance { limits, spring_length: None, motor }, Quat::IDENTITY),
            Self::Slide => (JointKind::Generic { linear: [held, free, held], angular: [held; 3] }, Quat::IDENTITY),
            Self::Turn => (JointKind::Generic { linear: [held; 3], angular: [held, held, free] }, Quat::IDENTITY),
        }
    }
}
