//! Creates the cells of a solid in a world that is recorded.

use super::RecordedWorld;
use crate::body::BodyDef;
use crate::error::Result;
use crate::fracture::voronoi::{Cells, Material};
use crate::id::{BodyId, JointId};
use crate::shape::ShapeDef;
use crate::world::cells::make;

impl RecordedWorld {
    /// As [`crate::World::create_cells`]; what is recorded is each body and joint.
    ///
    /// # Errors
    /// As there.
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
