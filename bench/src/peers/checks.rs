//! What no peer adapter translates, refused here by name, once for all of them; and how what they do translate is read.

use longspan::{CombineRule, JointDef, JointKind, Limits, Material, Motor, Softness, SphericalMotor};

use super::unsupported;

/// Refuses surfaces that only longspan has.
pub fn material(engine: &str, material: &Material) {
    if material.friction_rule != CombineRule::GeometricMean || material.restitution_rule != CombineRule::Maximum {
        unsupported(engine, "a combine rule other than geometric mean of friction and maximum of restitution");
    }
    if material.rolling_friction != 0.0 || material.spinning_friction != 0.0 {
        unsupported(engine, "rolling or spinning friction");
    }
}

/// Refuses joints that give, pull towards a position or break: no two engines mean the same by them.
pub fn joint(engine: &str, def: &JointDef) {
    if [def.linear, def.angular, def.limit].iter().any(|softness| *softness != Softness::RIGID) {
        unsupported(engine, "a joint with compliance");
    }
    if def.break_force.is_finite() || def.break_torque.is_finite() {
        unsupported(engine, "a joint that reports an overload");
    }
    if def.friction > 0.0 || def.axis_friction.iter().any(|&friction| friction > 0.0) {
        unsupported(engine, "friction of a joint");
    }
    match def.kind {
        JointKind::Prismatic { motor, .. } | JointKind::Distance { motor, .. } if motor != Motor::Off => {
            unsupported(engine, "a motor of a joint other than a hinge")
        }
        JointKind::Hinge { motor: Motor::Position { .. }, .. } => unsupported(engine, "a position motor"),
        JointKind::Distance { spring_length: Some(_), .. } => unsupported(engine, "a distance joint with a spring"),
        JointKind::Spherical { twist_limits, motor, .. } => {
            if motor != SphericalMotor::Off {
                unsupported(engine, "a motor of a joint other than a hinge");
            }
            if twist_limits != Limits::NONE {
                unsupported(engine, "a spherical joint with a twist limit");
            }
        }
        JointKind::Generic { .. } => unsupported(engine, "a generic joint"),
        _ => {}
    }
}

/// Limits with both bounds finite, those that were open moved to `±reach`; `None` if both were open.
pub fn finite_limits(limits: Limits, reach: f32) -> Option<[f32; 2]> {
    (limits != Limits::NONE).then(|| [limits.min.max(-reach), limits.max.min(reach)])
}

/// Speed (rad/s) and greatest torque (N·m, finite) of a motor, if there is one.
pub fn speed_motor(motor: Motor) -> Option<[f32; 2]> {
    match motor {
        Motor::Velocity { target, max_force } => Some([target, max_force.min(f32::MAX)]),
        _ => None,
    }
}

/// The greatest swing (rad), if there is one.
pub fn swing(limit: f32) -> Option<f32> {
    (limit < std::f32::consts::PI).then_some(limit)
}
