//! Surface properties of a shape, and how those of two touching shapes combine.

use crate::check;
use crate::error::Result;

/// How a property of two touching shapes becomes one; where the two differ, the rule listed later wins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum CombineRule {
    /// Square root of the product.
    #[default]
    GeometricMean,
    /// Arithmetic mean.
    Average,
    /// The smaller value.
    Minimum,
    /// The product.
    Multiply,
    /// The greater value.
    Maximum,
}

impl CombineRule {
    pub(crate) fn combine(rule_a: Self, rule_b: Self, a: f32, b: f32) -> f32 {
        match rule_a.max(rule_b) {
            Self::GeometricMean => (a * b).sqrt(),
            Self::Average => 0.5 * (a + b),
            Self::Minimum => a.min(b),
            Self::Multiply => a * b,
            Self::Maximum => a.max(b),
        }
    }
}

/// Surface of a shape. Coefficients of rolling and spinning friction are lengths: torque limit per normal force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Coulomb friction coefficient, ≥ 0.
    pub friction: f32,
    /// Rebound speed over approach speed, 0 to 1; used above the world's restitution threshold.
    pub restitution: f32,
    /// Rolling friction: torque limit about tangent axes per normal force (m), ≥ 0.
    pub rolling_friction: f32,
    /// Spinning friction: torque limit about the normal per normal force (m), ≥ 0, beside that of the contact's own extent.
    pub spinning_friction: f32,
    /// How friction (all three kinds) combines; default geometric mean.
    pub friction_rule: CombineRule,
    /// How restitution combines; default maximum.
    pub restitution_rule: CombineRule,
}

impl Default for Material {
    fn default() -> Self {
        Self::PLAIN
    }
}

impl Material {
    pub(crate) const PLAIN: Self = Self {
        friction: 0.5,
        restitution: 0.0,
        rolling_friction: 0.0,
        spinning_friction: 0.0,
        friction_rule: CombineRule::GeometricMean,
        restitution_rule: CombineRule::Maximum,
    };

    pub(crate) fn check(&self) -> Result<()> {
        check::not_negative("friction", self.friction)?;
        check::not_negative("rolling_friction", self.rolling_friction)?;
        check::not_negative("spinning_friction", self.spinning_friction)?;
        if check::not_negative("restitution", self.restitution)? > 1.0 {
            return Err(crate::error::Error::new(crate::error::ErrorKind::OutOfRange, "restitution", "is greater than 1"));
        }
        Ok(())
    }
}

/// The combined surface of a pair of shapes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct PairMaterial {
    pub friction: f32,
    pub restitution: f32,
    pub rolling: f32,
    pub spinning: f32,
}

impl PairMaterial {
    /// Whether contacts of it neither rebound nor resist rolling or spinning by themselves.
    pub(crate) fn is_plain(&self) -> bool {
        self.restitution == 0.0 && self.rolling == 0.0 && self.spinning == 0.0
    }

    /// Whether contacts of it may turn a ball.
    pub(crate) fn may_turn(&self) -> bool {
        self.friction > 0.0 || self.rolling > 0.0 || self.spinning > 0.0
    }

    pub(crate) fn combine(a: &Material, b: &Material) -> Self {
        let friction = |x, y| CombineRule::combine(a.friction_rule, b.friction_rule, x, y);
        Self {
            friction: friction(a.friction, b.friction),
            restitution: CombineRule::combine(a.restitution_rule, b.restitution_rule, a.restitution, b.restitution),
            // A surface that resists rolling does so on whatever touches it.
            rolling: a.rolling_friction.max(b.rolling_friction),
            spinning: a.spinning_friction.max(b.spinning_friction),
        }
    }
}
