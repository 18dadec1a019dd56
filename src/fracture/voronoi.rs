//! Cutting a convex solid into the Voronoi cells of some points, held together at the faces that they share.
//!
//! The cell of a seed is what lies closer to it than to any other: the solid, clipped by the plane halfway to every other seed
//! that can reach it, nearest first, until the next is more than twice as far as the cell's farthest corner. Clipping is done in
//! `f64` on polygons that remember which seed cut them, so that the face between two cells has one area, one centre and one
//! normal. The faces of a convex hull are its triangles.

use glam::{DVec3, Vec3};

use super::polyhedron::Polyhedron;
use super::{Damage, Strength};
use crate::body::BodyDef;
use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::id::BodyId;
use crate::joint::{JointDef, JointKind};
use crate::pose::Pose;
use crate::shape::{Geometry, Shape, ShapeDef};

/// Most cells of one solid.
pub const MAX_CELLS: usize = 65_536;

/// Area of a face that bonds two cells at least, over the square of the solid's extent: less is an edge.
const MIN_AREA: f64 = 1.0e-9;

/// Points that a random seed is looked for among, for each that is wanted.
const TRIES: usize = 10_000;

/// What bonds cells: stresses that it bears (Pa), and how loads are judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Greatest tensile stress (Pa).
    pub tension: f32,
    /// Greatest compressive stress (Pa).
    pub compression: f32,
    /// Greatest shear stress (Pa).
    pub shear: f32,
    /// Time over which loads are averaged (s).
    pub window: f32,
    /// How loads below the limits wear bonds out.
    pub damage: Option<Damage>,
}

impl Material {
    /// Bears this stress (Pa) in tension and shear, ten times as much in compression, as stone does.
    pub const fn brittle(stress: f32) -> Self {
        Self { tension: stress, compression: 10.0 * stress, shear: stress, window: Strength::UNBREAKABLE.window, damage: None }
    }

    /// What a bond of this area (m²) bears.
    pub fn strength(&self, area: f32) -> Strength {
        let Self { tension, compression, shear, window, damage } = *self;
        Strength { window, damage, ..Strength::of_bond(area, tension, compression, shear) }
    }
}

/// A cell: a convex solid about its own centre of mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Number of its seed among those given.
    pub seed: usize,
    /// Its centre of mass, in the frame of the solid (m).
    pub center: Vec3,
    /// Its volume (m³).
    pub volume: f32,
    /// Its corners, from its centre (m).
    pub points: Vec<Vec3>,
}

/// The face between two cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bond {
    /// The two cells, the lower number first.
    pub cells: [usize; 2],
    /// Its centre, in the frame of the solid (m).
    pub center: Vec3,
    /// Unit normal from the first cell to the second.
    pub normal: Vec3,
    /// Its area (m²).
    pub area: f32,
}

/// A solid in pieces.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cells {
    /// The pieces, by seed.
    pub cells: Vec<Cell>,
    /// The faces between them, by cells.
    pub bonds: Vec<Bond>,
}

impl Cells {
    /// Cuts a box or a convex hull into the cells of these seeds, in its frame (m). Seeds whose cell lies outside have none.
    ///
    /// # Errors
    /// The form is neither box nor hull, or refused as by [`Shape::new`]; there is no seed, or too many; two seeds are the same; a
    /// cell is too thin to be a solid.
    pub fn cut(geometry: &Geometry, seeds: &[Vec3]) -> Result<Self> {
        let solid = Polyhedron::of(geometry)?;
        if seeds.is_empty() || seeds.len() > MAX_CELLS {
            return Err(Error::new(ErrorKind::OutOfRange, "seeds", "is empty or has more than 65536 points"));
        }
        for &seed in seeds {
            check::finite_vec("seeds", seed)?;
        }
        let seeds: Vec<DVec3> = seeds.iter().map(|seed| seed.as_dvec3()).collect();
        let mut cells = Vec::new();
        let mut faces = Vec::new();
        for number in 0..seeds.len() {
            let Some(cell) = solid.cell(number, &seeds)? else { continue };
            let (volume, center) = cell.volume_and_center();
            let origin = center.as_vec3();
            let points: Vec<Vec3> = cell.corners().iter().map(|&point| (point - origin.as_dvec3()).as_vec3()).collect();
            Shape::new(Geometry::ConvexHull { points: points.clone() }).map_err(|_| {
                Error::new(ErrorKind::Degenerate, "seeds", "a cell is too thin to be a solid: seeds lie too close together")
            })?;
            faces.push((number, cell));
            cells.push(Cell { seed: number, center: origin, volume: volume as f32, points });
        }
        let mut bonds = Vec::new();
        for (first, (number, cell)) in faces.iter().enumerate() {
            for face in &cell.faces {
                let Some(other) = face.other.filter(|other| other > number) else { continue };
                let (area, center) = face.area_and_center();
                let second = faces.binary_search_by_key(&other, |(number, _)| *number);
                if let Ok(second) = second
                    && area > MIN_AREA * solid.size * solid.size
                {
                    let normal = (seeds[other] - seeds[*number]).normalize().as_vec3();
                    bonds.push(Bond { cells: [first, second], center: center.as_vec3(), normal, area: area as f32 });
                }
            }
        }
        bonds.sort_by_key(|bond| bond.cells);
        Ok(Self { cells, bonds })
    }

    /// Points spread evenly at random through a box or a convex hull (m); the same for the same `seed` on every machine.
    ///
    /// # Errors
    /// The form is neither box nor hull, or refused as by [`Shape::new`]; `count` is zero or too large.
    pub fn random_seeds(geometry: &Geometry, count: usize, seed: u64) -> Result<Vec<Vec3>> {
        let solid = Polyhedron::of(geometry)?;
        if count == 0 || count > MAX_CELLS {
            return Err(Error::new(ErrorKind::OutOfRange, "count", "is zero or more than 65536"));
        }
        let corners = solid.corners();
        let (low, high) = (corners.iter().copied().reduce(DVec3::min), corners.iter().copied().reduce(DVec3::max));
        let (low, high) = (low.unwrap_or_default(), high.unwrap_or_default());
        let mut random = SplitMix(seed);
        let mut seeds = Vec::with_capacity(count);
        for _ in 0..count * TRIES {
            let point = low + (high - low) * DVec3::new(random.unit(), random.unit(), random.unit());
            if solid.contains(point) {
                seeds.push(point.as_vec3());
                if seeds.len() == count {
                    return Ok(seeds);
                }
            }
        }
        Err(Error::new(ErrorKind::Degenerate, "geometry", "is too thin to find seeds inside"))
    }

    /// A body for each cell: `body` with the hull of the cell, which in all else is `shape`; `body.pose` and its velocities are those of
    /// the solid, and the cells have its momentum.
    ///
    /// # Errors
    /// A cell that was changed after the cut is no solid.
    pub fn bodies(&self, body: &BodyDef, shape: &ShapeDef) -> Result<Vec<BodyDef>> {
        let solid_center = self.center();
        let piece = |cell: &Cell| {
            let hull = ShapeDef { shape: Shape::new(Geometry::ConvexHull { points: cell.points.clone() })?, ..shape.clone() };
            let pose = body.pose.transform(&Pose::at(cell.center.as_dvec3()));
            // The linear velocity of a body is that of its centre of mass.
            let lever = body.pose.rotation * (cell.center.as_dvec3() - solid_center).as_vec3();
            let linear_velocity = body.linear_velocity + body.angular_velocity.cross(lever);
            Ok(BodyDef { pose, linear_velocity, shapes: vec![hull], ..body.clone() })
        };
        self.cells.iter().map(piece).collect()
    }

    /// Centre of mass of all cells, in the frame of the solid (m).
    fn center(&self) -> DVec3 {
        let (volume, moment) = self.cells.iter().fold((0.0, DVec3::ZERO), |(volume, moment), cell| {
            let own = f64::from(cell.volume);
            (volume + own, moment + cell.center.as_dvec3() * own)
        });
        if volume > 0.0 { moment / volume } else { DVec3::ZERO }
    }

    /// A fixed joint for each bond, its axis the face's normal from the first cell to the second; the bodies are still to be named.
    pub fn joints<'a>(&'a self, material: &'a Material) -> impl Iterator<Item = ([usize; 2], JointDef)> + 'a {
        self.bonds.iter().map(|bond| {
            let rotation = glam::Quat::from_rotation_arc(Vec3::X, bond.normal);
            let mut def = JointDef::new(JointKind::Fixed, BodyId::NULL, BodyId::NULL);
            let frame = |cell: usize| Pose::at((bond.center - self.cells[cell].center).as_dvec3()).rotated(rotation);
            [def.frame_a, def.frame_b] = bond.cells.map(frame);
            def.strength = material.strength(bond.area);
            (bond.cells, def)
        })
    }
}

/// Random numbers that are the same everywhere (Steele, Lea and Flood 2014).
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to below 1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn cuboid() -> Geometry {
        Geometry::Box { half_extents: Vec3::new(1.0, 0.5, 0.25) }
    }

    /// Volume of all cells, and for each cell whether every bond is seen from both sides as the same.
    fn check(geometry: &Geometry, volume: f32, count: usize, seed: u64) {
        let seeds = Cells::random_seeds(geometry, count, seed).unwrap();
        let cut = Cells::cut(geometry, &seeds).unwrap();
        assert_eq!(cut.cells.len(), count, "every seed inside has a cell");
        let total: f32 = cut.cells.iter().map(|cell| cell.volume).sum();
        assert!((total - volume).abs() < 1e-5 * volume, "{count} cells hold {total} m³ of {volume} m³");
        for bond in &cut.bonds {
            let [a, b] = bond.cells.map(|cell| &cut.cells[cell]);
            assert!((a.center - bond.center).dot(bond.normal) < 0.0 && (b.center - bond.center).dot(bond.normal) > 0.0);
        }
        let reached: BTreeSet<usize> = cut.bonds.iter().flat_map(|bond| bond.cells).collect();
        assert!(count == 1 || reached.len() == count, "every cell is bonded to another");
    }

    #[test]
    fn cells_fill_a_box_and_share_their_faces() {
        for (count, seed) in [(1, 1), (2, 2), (3, 3), (20, 4), (200, 5)] {
            check(&cuboid(), 1.0, count, seed);
        }
    }

    #[test]
    fn cells_fill_a_hull() {
        // An octahedron of edge √2.
        let points = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]).collect();
        for (count, seed) in [(1, 1), (10, 2), (100, 3)] {
            check(&Geometry::ConvexHull { points: Clone::clone(&points) }, 4.0 / 3.0, count, seed);
        }
    }

    #[test]
    fn a_box_halved_has_one_bond_of_its_cross_section() {
        let cut = Cells::cut(&cuboid(), &[Vec3::X * -0.5, Vec3::X * 0.5]).unwrap();
        let [bond] = cut.bonds[..] else { panic!("{} bonds", cut.bonds.len()) };
        assert!((bond.area - 0.5).abs() < 1e-6 && bond.normal == Vec3::X && bond.center.length() < 1e-6, "{bond:?}");
        assert_eq!(cut.cells.iter().map(|cell| cell.points.len()).collect::<Vec<_>>(), [8, 8]);
    }

    #[test]
    fn a_regular_grid_bonds_over_faces_alone() {
        let seeds: Vec<Vec3> =
            (0..64).map(|i| Vec3::new((i % 4) as f32 - 1.5, (i / 4 % 4) as f32 - 1.5, (i / 16) as f32 - 1.5) * 0.25).collect();
        let cut = Cells::cut(&Geometry::Box { half_extents: Vec3::splat(0.5) }, &seeds).unwrap();
        assert_eq!((cut.cells.len(), cut.bonds.len()), (64, 3 * 48));
        assert!(cut.bonds.iter().all(|bond| (bond.area - 0.0625).abs() < 1e-6));
    }

    #[test]
    fn what_cannot_be_cut_is_refused_by_name() {
        let refused = |geometry: &Geometry, seeds: &[Vec3]| Cells::cut(geometry, seeds).unwrap_err();
        assert_eq!(refused(&Geometry::Ball { radius: 1.0 }, &[Vec3::ZERO]).argument, "geometry");
        assert_eq!(refused(&cuboid(), &[]).argument, "seeds");
        assert_eq!(refused(&cuboid(), &[Vec3::ZERO, Vec3::ZERO]).kind, ErrorKind::Degenerate);
        assert_eq!(refused(&cuboid(), &[Vec3::NAN]).kind, ErrorKind::NotFinite);
    }
}
