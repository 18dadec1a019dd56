//! Creates the cells of a solid.

use super::World;
use crate::body::BodyDef;
use crate::error::Result;
use crate::fracture::voronoi::{Cells, Material};
use crate::id::{BodyId, JointId};
use crate::joint::JointDef;
use crate::shape::ShapeDef;

impl World {
    /// Makes the cells of a solid as bodies, held together by fixed joints that break as `material` says. `body` and `shape` are
    /// those of the solid: its pose, velocities, density and surface; `body.shapes` and `body.mass` are not used.
    ///
    /// # Errors
    /// As [`create_body`](Self::create_body) and [`create_joint`](Self::create_joint); nothing has been made then.
    pub fn create_cells(
        &mut self,
        cells: &Cells,
        body: &BodyDef,
        shape: &ShapeDef,
        material: &Material,
    ) -> Result<(Vec<BodyId>, Vec<JointId>)> {
        make(self, (cells, body, shape, material), Self::create_body, Self::create_joint, Self::destroy_body)
    }
}

/// Makes the bodies and joints of cells in a world of either kind.
pub(crate) fn make<W>(
    world: &mut W,
    (cells, body, shape, material): (&Cells, &BodyDef, &ShapeDef, &Material),
    create_body: fn(&mut W, &BodyDef) -> Result<BodyId>,
    create_joint: fn(&mut W, &JointDef) -> Result<JointId>,
    destroy_body: fn(&mut W, BodyId) -> Result<()>,
) -> Result<(Vec<BodyId>, Vec<JointId>)> {
    let mut bodies = Vec::with_capacity(cells.cells.len());
    let mut joints = Vec::with_capacity(cells.bonds.len());
    let body = BodyDef { mass: crate::mass::Mass::FromShapes, ..body.clone() };
    let made = (|| {
        for def in cells.bodies(&body, shape)? {
            bodies.push(create_body(world, &def)?);
        }
        for ([a, b], def) in cells.joints(material) {
            joints.push(create_joint(world, &JointDef { body_a: bodies[a], body_b: bodies[b], ..def })?);
        }
        Ok(())
    })();
    if let Err(error) = made {
        for body in bodies {
            // It was made a moment ago.
            let _ = destroy_body(world, body);
        }
        return Err(error);
    }
    Ok((bodies, joints))
}
