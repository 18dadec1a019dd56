//! Integers from C that stand for a choice: checked before they become one.

use ls_core::{BodyKind, CombineRule, LockedAxes, Solver};

use crate::body_def::*;
use crate::log::{LS_LOG_ERROR, LS_LOG_OFF, LS_LOG_WARNING};
use crate::result::{Failure, LS_ERROR_INVALID_ENUM, Outcome};
use crate::shape_def::*;
use crate::world_def::*;

pub(crate) fn unknown(argument: &'static str) -> Failure {
    Failure::Refused(LS_ERROR_INVALID_ENUM, argument, "is not one of the values that this version knows")
}

pub(crate) fn log_level(level: i32) -> Outcome<i32> {
    matches!(level, LS_LOG_OFF | LS_LOG_ERROR | LS_LOG_WARNING).then_some(level).ok_or_else(|| unknown("level"))
}

pub(crate) fn solver(solver: i32) -> Outcome<Solver> {
    match solver {
        LS_SOLVER_AUTO => Ok(Solver::Auto),
        LS_SOLVER_GAUSS_SEIDEL => Ok(Solver::GaussSeidel),
        LS_SOLVER_DIRECT => Ok(Solver::Direct),
        _ => Err(unknown("solver")),
    }
}

pub(crate) fn from_solver(solver: Solver) -> i32 {
    match solver {
        Solver::Auto => LS_SOLVER_AUTO,
        Solver::GaussSeidel => LS_SOLVER_GAUSS_SEIDEL,
        Solver::Direct => LS_SOLVER_DIRECT,
    }
}

pub(crate) fn body_kind(kind: i32) -> Outcome<BodyKind> {
    match kind {
        LS_BODY_STATIC => Ok(BodyKind::Static),
        LS_BODY_KINEMATIC => Ok(BodyKind::Kinematic),
        LS_BODY_DYNAMIC => Ok(BodyKind::Dynamic),
        _ => Err(unknown("kind")),
    }
}

pub(crate) fn from_body_kind(kind: BodyKind) -> i32 {
    match kind {
        BodyKind::Static => LS_BODY_STATIC,
        BodyKind::Kinematic => LS_BODY_KINEMATIC,
        BodyKind::Dynamic => LS_BODY_DYNAMIC,
    }
}

pub(crate) fn locked_axes(bits: u32) -> Outcome<LockedAxes> {
    let all = LS_LOCK_TRANSLATION_X
        | LS_LOCK_TRANSLATION_Y
        | LS_LOCK_TRANSLATION_Z
        | LS_LOCK_ROTATION_X
        | LS_LOCK_ROTATION_Y
        | LS_LOCK_ROTATION_Z;
    if bits & !all != 0 {
        return Err(unknown("locked_axes"));
    }
    Ok(LockedAxes {
        translation: [LS_LOCK_TRANSLATION_X, LS_LOCK_TRANSLATION_Y, LS_LOCK_TRANSLATION_Z].map(|bit| bits & bit != 0),
        rotation: [LS_LOCK_ROTATION_X, LS_LOCK_ROTATION_Y, LS_LOCK_ROTATION_Z].map(|bit| bits & bit != 0),
    })
}

pub(crate) fn from_locked_axes(axes: LockedAxes) -> u32 {
    let bits = |first: u32, locked: [bool; 3]| (0..3).filter(|&axis| locked[axis]).map(|axis| first << axis).sum::<u32>();
    bits(LS_LOCK_TRANSLATION_X, axes.translation) | bits(LS_LOCK_ROTATION_X, axes.rotation)
}

pub(crate) fn combine_rule(rule: i32, argument: &'static str) -> Outcome<CombineRule> {
    match rule {
        LS_COMBINE_GEOMETRIC_MEAN => Ok(CombineRule::GeometricMean),
        LS_COMBINE_AVERAGE => Ok(CombineRule::Average),
        LS_COMBINE_MINIMUM => Ok(CombineRule::Minimum),
        LS_COMBINE_MULTIPLY => Ok(CombineRule::Multiply),
        LS_COMBINE_MAXIMUM => Ok(CombineRule::Maximum),
        _ => Err(unknown(argument)),
    }
}

pub(crate) fn from_combine_rule(rule: CombineRule) -> i32 {
    match rule {
        CombineRule::GeometricMean => LS_COMBINE_GEOMETRIC_MEAN,
        CombineRule::Average => LS_COMBINE_AVERAGE,
        CombineRule::Minimum => LS_COMBINE_MINIMUM,
        CombineRule::Multiply => LS_COMBINE_MULTIPLY,
        CombineRule::Maximum => LS_COMBINE_MAXIMUM,
    }
}
