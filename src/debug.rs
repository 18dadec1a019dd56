//! Debug drawing: lines, triangles and short texts, in layers.
//!
//! [`World::draw`](crate::World::draw) walks through the layers that were asked for and hands each primitive to a [`DebugDraw`];
//! nothing is kept, nothing is changed. Positions are in world coordinates (m).

use glam::DVec3;

pub(crate) mod form;

/// A colour: red, green and blue, 8 bits each, as 0xRRGGBB.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Color(pub u32);

impl Color {
    pub(crate) const GREY: Self = Self(0x00_8c_8c_8c);
    pub(crate) const DIM: Self = Self(0x00_5a_64_78);
    pub(crate) const WHITE: Self = Self(0x00_f0_f0_f0);
    pub(crate) const RED: Self = Self(0x00_e0_3c_31);
    pub(crate) const ORANGE: Self = Self(0x00_f0_9a_2a);
    pub(crate) const YELLOW: Self = Self(0x00_e8_d4_4d);
    pub(crate) const GREEN: Self = Self(0x00_4c_b0_50);
    pub(crate) const CYAN: Self = Self(0x00_3c_c8_d8);
    pub(crate) const BLUE: Self = Self(0x00_4a_7d_e0);
    pub(crate) const MAGENTA: Self = Self(0x00_c8_50_c8);

    /// From green at 0 over yellow to red at 1, for shares of a limit.
    pub(crate) fn of_share(share: f32) -> Self {
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 };
        let (red, green) = ((share * 2.0).min(1.0), ((1.0 - share) * 2.0).min(1.0));
        Self(((red * 224.0) as u32) << 16 | ((green * 192.0) as u32) << 8 | 0x30)
    }

    /// One of many that are told apart, by number: hues a golden angle apart.
    pub(crate) fn of_number(number: u32) -> Self {
        const GOLDEN: u32 = 0x9e37_79b9;
        let hue = (number.wrapping_mul(GOLDEN) >> 8) as f32 / (1 << 24) as f32 * 6.0;
        let channel = |offset: f32| {
            let distance = ((hue + offset).rem_euclid(6.0) - 3.0).abs();
            (70.0 + 165.0 * (distance - 1.0).clamp(0.0, 1.0)) as u32
        };
        Self(channel(0.0) << 16 | channel(4.0) << 8 | channel(2.0))
    }
}

/// A set of layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DrawLayers(u32);

macro_rules! layers {
    ($($(#[$doc:meta])* $name:ident = $bit:literal;)*) => {
        impl DrawLayers {
            $($(#[$doc])* pub const $name: Self = Self(1 << $bit);)*
            /// Every layer.
            pub const ALL: Self = Self($(1 << $bit)|*);
        }
    };
}

layers! {
    /// Outlines of shapes: static grey, kinematic blue, awake orange, held where they are yellow, asleep dim, sensors green,
    /// quarantined red.
    SHAPES = 0;
    /// The same as triangles.
    SURFACES = 1;
    /// Contact points, with their normal from A to B: white where they press, grey where they do not.
    CONTACTS = 2;
    /// Forces of contacts on B, along the normal and of friction.
    CONTACT_FORCES = 3;
    /// Joints: lines from both centres of mass to the joint points, and both joint frames.
    JOINTS = 4;
    /// Limits of joints, and where the joint is between them.
    JOINT_LIMITS = 5;
    /// Force of each joint as a line on B and as a text (N), coloured by its share of the break force.
    JOINT_LOADS = 6;
    /// A box around each island awake, in a colour of its own, and around each asleep, dim; of those with joints how they are solved.
    ISLANDS = 7;
    /// Long-range bounds: taut ones with their tension (N), slack ones with what is left (m).
    BOUNDS = 8;
    /// Supporting contacts, the hull they span and the centre of mass above it, coloured by verdict; if the analysis is on.
    SUPPORT = 9;
    /// Centres of mass with principal axes.
    MASS = 10;
    /// Velocities of centres of mass.
    VELOCITIES = 11;
    /// Boxes that the broad phase keeps.
    BOXES = 12;
    /// Planes of hinge chains: a square through them with its normal, and how far each body's centre of mass is off it, which the
    /// chain keeps.
    PLANES = 13;
    /// Unions: a line from the centre of mass of each to every body of it, and their number.
    UNIONS = 14;
}

impl DrawLayers {
    /// The layers of these bits; `None` if one is not known.
    pub const fn from_bits(bits: u32) -> Option<Self> {
        if bits & !Self::ALL.0 == 0 { Some(Self(bits)) } else { None }
    }

    /// The bits of the layers.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Whether all of `layers` are among these.
    pub const fn contains(self, layers: Self) -> bool {
        self.0 & layers.0 == layers.0
    }

    /// Whether any of `layers` is among these.
    pub const fn intersects(self, layers: Self) -> bool {
        self.0 & layers.0 != 0
    }
}

impl std::ops::BitOr for DrawLayers {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// What is drawn, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawOptions {
    /// Layers to draw.
    pub layers: DrawLayers,
    /// Length of a force's line (m/N), ≥ 0; 0 for none.
    pub force_scale: f32,
    /// Length of a velocity's line (s), ≥ 0.
    pub velocity_scale: f32,
    /// Length of the axes of a joint frame and size of a contact point's cross (m), > 0.
    pub mark_size: f32,
    /// Only what lies within this distance (m) of this point is drawn.
    pub within: Option<(DVec3, f64)>,
}

impl Default for DrawOptions {
    fn default() -> Self {
        Self {
            layers: DrawLayers::SHAPES | DrawLayers::JOINTS,
            force_scale: 1.0e-3,
            velocity_scale: 0.1,
            mark_size: 0.1,
            within: None,
        }
    }
}

impl DrawOptions {
    pub(crate) fn check(&self) -> crate::Result<()> {
        crate::check::not_negative("force_scale", self.force_scale)?;
        crate::check::not_negative("velocity_scale", self.velocity_scale)?;
        crate::check::positive("mark_size", self.mark_size)?;
        if let Some((center, radius)) = self.within {
            crate::check::position("within", center)?;
            if !radius.is_finite() || radius < 0.0 {
                return Err(crate::Error::new(crate::ErrorKind::OutOfRange, "within", "must be a finite distance, at least 0"));
            }
        }
        Ok(())
    }
}

/// Takes what is drawn.
pub trait DebugDraw {
    /// A line.
    fn line(&mut self, from: DVec3, to: DVec3, color: Color);
    /// A triangle, counter-clockwise seen from outside where it has an outside.
    fn triangle(&mut self, corners: [DVec3; 3], color: Color);
    /// A short text at a point.
    fn text(&mut self, at: DVec3, text: &str, color: Color);
}
