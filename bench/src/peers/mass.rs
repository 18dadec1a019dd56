//! The mass that every engine is handed, and the check that it arrived.

use glam::{DMat3, DVec3, Mat3, Quat, Vec3};
use longspan::{BodyDef, LockedAxes, Mass, MassProperties, ShapeDef};

/// Largest relative difference between the mass handed over and the mass read back.
const TOLERANCE: f64 = 1.0e-3;

/// Mass (kg), centre of mass (m) and inertia tensor about it (kg·m²), in the axes of the body.
#[derive(Debug, Clone, Copy)]
pub struct RigidMass {
    pub mass: f32,
    pub center: Vec3,
    pub inertia: Mat3,
}

impl RigidMass {
    /// What longspan would give a dynamic body made from `def`.
    pub fn of(def: &BodyDef) -> Self {
        match def.mass {
            Mass::Properties(properties) => Self::from_properties(&properties),
            Mass::FromShapes => Self::of_shapes(&def.shapes),
            Mass::Total(total) => {
                let shaped = Self::of_shapes(&def.shapes);
                Self { mass: total, inertia: shaped.inertia * (total / shaped.mass), ..shaped }
            }
        }
    }

    /// The tensor of `principal` moments (kg·m²) about the axes of `frame`.
    fn tensor(principal: Vec3, frame: Quat) -> Mat3 {
        let axes = Mat3::from_quat(frame);
        axes * Mat3::from_diagonal(principal) * axes.transpose()
    }

    fn from_properties(properties: &MassProperties) -> Self {
        Self {
            mass: properties.mass,
            center: properties.center_of_mass,
            inertia: Self::tensor(properties.principal_inertia, properties.inertia_frame),
        }
    }

    /// Sum over the shapes by the parallel axis theorem.
    fn of_shapes(shapes: &[ShapeDef]) -> Self {
        let parts: Vec<Self> = shapes.iter().filter(|shape| shape.density > 0.0).filter_map(Self::of_shape).collect();
        let mass: f32 = parts.iter().map(|part| part.mass).sum();
        assert!(mass > 0.0, "a dynamic body needs a shape with density, or mass and inertia of its own");
        let center = parts.iter().map(|part| part.mass * part.center).sum::<Vec3>() / mass;
        let mut inertia = Mat3::ZERO;
        for part in &parts {
            let offset = part.center - center;
            let outer = Mat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z);
            inertia += part.inertia + part.mass * (Mat3::from_diagonal(Vec3::splat(offset.length_squared())) - outer);
        }
        Self { mass, center, inertia }
    }

    fn of_shape(shape: &ShapeDef) -> Option<Self> {
        let own = Self::from_properties(&shape.shape.mass_properties(shape.density)?);
        let axes = Mat3::from_quat(shape.local_pose.rotation);
        Some(Self {
            mass: own.mass,
            center: shape.local_pose.position + axes * own.center,
            inertia: axes * own.inertia * axes.transpose(),
        })
    }

    /// The mass whose inverses an engine solves with, in the axes of the body.
    #[cfg(feature = "peer-box3d")]
    pub fn from_inverses(inverse_mass: f32, center: Vec3, inverse_inertia: Mat3) -> Self {
        Self { mass: 1.0 / inverse_mass, center, inertia: inverse_inertia.as_dmat3().inverse().as_mat3() }
    }

    /// Panics unless `engine` solves its body number `body` with this mass.
    pub fn assert_arrived(&self, engine: &str, body: usize, read_back: &Self) {
        let scale = greatest_entry(self.inertia.as_dmat3());
        let inertia_error = greatest_entry(self.inertia.as_dmat3() - read_back.inertia.as_dmat3()) / scale;
        let mass_error = f64::from((self.mass - read_back.mass) / self.mass).abs();
        // A centre of mass that is off matters as far as it moves the inertia: measure it against the radius of gyration.
        let gyration = (scale / f64::from(self.mass)).sqrt();
        let center_error = DVec3::from(self.center - read_back.center).length() / gyration;
        let worst = inertia_error.max(mass_error).max(center_error);
        assert!(
            worst <= TOLERANCE,
            "{engine} solves body {body} with {read_back:?} instead of {self:?}: {:.3} % off, at most {:.1} %",
            100.0 * worst,
            100.0 * TOLERANCE
        );
    }
}

fn greatest_entry(matrix: DMat3) -> f64 {
    matrix.to_cols_array().into_iter().fold(0.0, |most: f64, entry| most.max(entry.abs()))
}

/// Dynamic bodies whose mass has not been read back yet: `(scene index, mass handed over)`.
#[derive(Default)]
pub struct Unverified(Vec<(usize, RigidMass)>);

impl Unverified {
    /// The mass to hand over for a dynamic body, which is read back later.
    pub fn resolve(&mut self, body: usize, def: &BodyDef) -> RigidMass {
        let mass = RigidMass::of(def);
        // Locked axes are infinite masses in some engines, and then not those that were handed over.
        if def.locked_axes == LockedAxes::default() {
            self.0.push((body, mass));
        }
        mass
    }

    pub fn forget(&mut self, body: usize) {
        self.0.retain(|(unverified, _)| *unverified != body);
    }

    /// Checks the mass of every body added since the last call.
    pub fn verify(&mut self, engine: &str, read_back: impl Fn(usize) -> RigidMass) {
        for (body, mass) in self.0.drain(..) {
            mass.assert_arrived(engine, body, &read_back(body));
        }
    }
}
