//! Flat faces of a hull: triangles that lie in one plane become one polygon, for contacts.
//!
//! A face grows from the largest triangle that is left over the neighbours whose corners are all within [`FLATNESS`] of the
//! plane of that first triangle. The plane does not follow the surface, so a finely rounded hull is not flattened in chains.

use glam::{DVec3, Vec3};

use super::Triangulation;

/// Distance from the plane of the first triangle within which a corner belongs to a face, over the extent of the hull. A
/// prism of 512 sides keeps them all: the corners of one lie 7.5e-5 of the extent below the next.
const FLATNESS: f64 = 1.0e-5;

/// The same over the greatest coordinate: what single precision rounds away of points far from their origin.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// A flat, convex face.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    /// Outward unit normal.
    pub normal: Vec3,
    first: u32,
    count: u32,
}

/// The faces of a hull, largest triangle first.
#[derive(Debug, Clone, Default)]
pub(super) struct Faces {
    pub all: Vec<Face>,
    corners: Vec<u32>,
}

impl Faces {
    /// Merges the triangles of a hull into faces: a flood fill from the largest triangle that no face has yet.
    pub(super) fn of(hull: &Triangulation) -> Self {
        let corner = |index: u32| hull.points[index as usize].as_dvec3();
        let normal_of = |[a, b, c]: [u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a));
        let normals: Vec<DVec3> = hull.triangles.iter().map(|&triangle| normal_of(triangle)).collect();
        let mut seeds: Vec<u32> = (0..hull.triangles.len() as u32).collect();
        let area = |seed: u32| normals[seed as usize].length_squared();
        seeds.sort_by(|&a, &b| area(b).total_cmp(&area(a)).then(a.cmp(&b)));

        let across = hull.neighbours();
        let tolerance = hull.extent() * FLATNESS + hull.greatest_coordinate() * ROUNDING;
        let mut taken = vec![false; hull.triangles.len()];
        let (mut faces, mut stack, mut corners) = (Self::default(), Vec::new(), Vec::new());
        for seed in seeds {
            if std::mem::replace(&mut taken[seed as usize], true) {
                continue;
            }
            let normal = normals[seed as usize].normalize();
            let origin = corner(hull.triangles[seed as usize][0]);
            let is_flat = |triangle: u32| {
                hull.triangles[triangle as usize].iter().all(|&index| (corner(index) - origin).dot(normal).abs() <= tolerance)
            };
            corners.clear();
            stack.push(seed);
            while let Some(triangle) = stack.pop() {
                corners.extend(hull.triangles[triangle as usize]);
                for &beyond in &across[triangle as usize] {
                    if !taken[beyond as usize] && is_flat(beyond) {
                        taken[beyond as usize] = true;
                        stack.push(beyond);
                    }
                }
            }
            faces.push(normal, &mut corners, corner);
        }
        faces
    }

    pub(super) fn corners(&self, face: &Face) -> &[u32] {
        &self.corners[face.first as usize..][..face.count as usize]
    }

    /// Adds the convex polygon around these corners, seen along the normal (Andrew 1979).
    fn push(&mut self, normal: DVec3, corners: &mut Vec<u32>, at: impl Fn(u32) -> DVec3) {
        corners.sort_unstable();
        corners.dedup();
        let (u, v) = normal.any_orthonormal_pair();
        let v = if u.cross(v).dot(normal) > 0.0 { v } else { -v };
        let flat = |index: u32| (at(index).dot(u), at(index).dot(v));
        corners.sort_by(|&a, &b| {
            let (a, b) = (flat(a), flat(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        let first = self.corners.len();
        let turns_right = |polygon: &[u32], next: u32| {
            let [.., a, b] = polygon else { return false };
            let (a, b, c) = (flat(*a), flat(*b), flat(next));
            (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0) <= 0.0
        };
        for pass in 0..2 {
            let start = self.corners.len();
            for i in 0..corners.len() {
                let next = if pass == 0 { corners[i] } else { corners[corners.len() - 1 - i] };
                while turns_right(&self.corners[start..], next) {
                    self.corners.pop();
                }
                self.corners.push(next);
            }
            // The last point of either chain is the first of the other.
            self.corners.pop();
        }
        let count = (self.corners.len() - first) as u32;
        self.all.push(Face { normal: normal.as_vec3(), first: first as u32, count });
    }
}
