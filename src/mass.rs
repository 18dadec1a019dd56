//! Mass, centre of mass and inertia of a body.

use glam::{DMat3, DVec3, Quat, Vec3};

use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::hull::weight::{SolidIntegrals, principal_axes};
use crate::shape::geometry::LocalPose;

/// Least and greatest mass of a dynamic body (kg).
pub const MASS_RANGE: (f32, f32) = (1.0e-9, 1.0e12);

/// Mass properties of a rigid body, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Mass (kg), > 0.
    pub mass: f32,
    /// Centre of mass (m).
    pub center_of_mass: Vec3,
    /// Principal moments of inertia about the centre of mass (kg·m²), each > 0.
    pub principal_inertia: Vec3,
    /// Rotation of the principal axes, unit quaternion.
    pub inertia_frame: Quat,
}

/// Where a dynamic body's mass comes from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Mass {
    /// Volume times density of its shapes.
    #[default]
    FromShapes,
    /// This mass (kg), distributed as the shapes say.
    Total(f32),
    /// These properties, whatever the shapes are.
    Properties(MassProperties),
}

impl MassProperties {
    /// A body with its centre of mass at its origin and its principal axes along its own.
    pub const fn new(mass: f32, principal_inertia: Vec3) -> Self {
        Self { mass, center_of_mass: Vec3::ZERO, principal_inertia, inertia_frame: Quat::IDENTITY }
    }

    pub(crate) fn from_parry(properties: &parry3d::mass_properties::MassProperties) -> Self {
        Self {
            mass: properties.mass(),
            center_of_mass: properties.local_com,
            principal_inertia: properties.principal_inertia(),
            inertia_frame: properties.principal_inertia_local_frame,
        }
    }

    /// Those of a solid of density 1.
    pub(crate) fn from_weight(weight: &SolidIntegrals) -> Self {
        Self::from_tensor(weight.volume, weight.center, weight.inertia)
    }

    /// From a mass (kg), its centre (m) and the inertia about it (kg·m²).
    fn from_tensor(mass: f64, center: DVec3, inertia: DMat3) -> Self {
        let (moments, axes) = principal_axes(inertia);
        Self {
            mass: mass as f32,
            center_of_mass: center.as_vec3(),
            principal_inertia: moments.as_vec3(),
            inertia_frame: glam::DQuat::from_mat3(&axes).normalize().as_quat(),
        }
    }

    pub(crate) fn scaled(self, factor: f32) -> Self {
        Self { mass: self.mass * factor, principal_inertia: self.principal_inertia * factor, ..self }
    }

    pub(crate) fn checked(self) -> Result<Self> {
        let mass = checked_mass("mass", self.mass)?;
        check::lever("center_of_mass", self.center_of_mass)?;
        check::positive("principal_inertia.x", self.principal_inertia.x)?;
        check::positive("principal_inertia.y", self.principal_inertia.y)?;
        check::positive("principal_inertia.z", self.principal_inertia.z)?;
        if (1.0 / self.principal_inertia).is_finite() {
            Ok(Self { mass, inertia_frame: check::rotation("inertia_frame", self.inertia_frame)?, ..self })
        } else {
            Err(Error::new(ErrorKind::OutOfRange, "principal_inertia", "is too small to be inverted"))
        }
    }

    pub(crate) fn placed(self, pose: LocalPose) -> Self {
        Self {
            center_of_mass: pose.position + pose.rotation * self.center_of_mass,
            inertia_frame: pose.rotation * self.inertia_frame,
            ..self
        }
    }
}

pub(crate) fn checked_mass(argument: &'static str, mass: f32) -> Result<f32> {
    let mass = check::positive(argument, mass)?;
    if mass < MASS_RANGE.0 || mass > MASS_RANGE.1 {
        return Err(Error::new(ErrorKind::OutOfRange, argument, "must be between 1e-9 and 1e12 kg"));
    }
    Ok(mass)
}

/// Sum of the mass properties of some parts of a body (parallel axis theorem), diagonalised; none without mass.
pub(crate) fn combined(parts: &[MassProperties]) -> Option<MassProperties> {
    if let [single] = *parts {
        return Some(single);
    }
    let mass: f64 = parts.iter().map(|part| f64::from(part.mass)).sum();
    if mass <= 0.0 {
        return None;
    }
    let moment = |part: &MassProperties| f64::from(part.mass) * part.center_of_mass.as_dvec3();
    let center = parts.iter().map(moment).sum::<DVec3>() / mass;
    let tensor = parts.iter().map(|part| {
        let offset = part.center_of_mass.as_dvec3() - center;
        let steiner = DMat3::from_diagonal(DVec3::splat(offset.length_squared()))
            - DMat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z);
        let axes = DMat3::from_quat(part.inertia_frame.as_dquat().normalize());
        axes * DMat3::from_diagonal(part.principal_inertia.as_dvec3()) * axes.transpose() + steiner * f64::from(part.mass)
    });
    Some(MassProperties::from_tensor(mass, center, tensor.fold(DMat3::ZERO, |sum, part| sum + part)))
}
