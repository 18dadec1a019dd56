//! Triangles of forms that have no simple description, made once for each form.

use std::collections::BTreeMap;

use longspan::glam::Vec3;
use longspan::{Geometry, Shape};

/// The surface of a form.
#[derive(Debug)]
pub(super) struct Surface {
    pub vertices: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

/// Surfaces by where their geometry lies in memory. Holding on to the shape keeps that place from meaning another one.
#[derive(Debug, Default)]
pub(super) struct Meshes {
    known: BTreeMap<usize, (Shape, Surface, u64)>,
}

impl Meshes {
    /// The surface of `geometry`, which belongs to `shape`; `None` for one that a few numbers describe.
    pub(super) fn surface(&mut self, shape: &Shape, geometry: &Geometry, cycle: u64) -> Option<&Surface> {
        let simple =
            !matches!(geometry, Geometry::ConvexHull { .. } | Geometry::TriangleMesh { .. } | Geometry::HeightField { .. });
        if simple {
            return None;
        }
        let entry = self.known.entry(std::ptr::from_ref(geometry) as usize).or_insert_with(|| {
            let (vertices, triangles) = geometry.triangles().unwrap_or_default();
            (shape.clone(), Surface { vertices, triangles }, cycle)
        });
        entry.2 = cycle;
        Some(&entry.1)
    }

    /// Forgets what was not asked for since `cycle` began.
    pub(super) fn forget_before(&mut self, cycle: u64) {
        self.known.retain(|_, (_, _, used)| *used >= cycle);
    }
}
