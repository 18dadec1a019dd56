//! Queries of height fields and meshes against their triangles, one by one.
//!
//! `tests/common/oracle.rs` has the variables by which many cases are run by hand.

use crate::common::oracle::{Dice, add, all, cases, dice, scales};
use longspan::glam::DVec3;
use longspan::{Cast, Geometry, Pose, Shape, World, WorldDef};

/// A bumpy ground as a height field and as a mesh of the same triangles, and those triangles.
fn grounds(dice: &mut Dice, scale: f64) -> ([Geometry; 2], Vec<[DVec3; 3]>) {
    let (rows, columns) = (4, 5);
    let heights: Vec<f32> = (0..rows * columns).map(|_| (dice.between(-0.3, 0.3) * scale) as f32).collect();
    let field = Geometry::HeightField { rows, columns, heights, size_x: 4.0 * scale as f32, size_z: 3.0 * scale as f32 };
    let (vertices, triangles) = field.triangles().expect("a height field has triangles");
    let corners = triangles.iter().map(|triangle| triangle.map(|index| vertices[index as usize].as_dvec3())).collect();
    ([field, Geometry::TriangleMesh { vertices, triangles }], corners)
}

/// Where a ray meets a triangle (Möller and Trumbore 1997), and how far inside its edges, as a share.
fn meets([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let scale = 1.0 / ab.dot(p);
    let from = origin - a;
    let (u, q) = (from.dot(p) * scale, from.cross(ab));
    let (v, t) = (direction.dot(q) * scale, ac.dot(q) * scale);
    (t >= 0.0).then_some((t, u.min(v).min(1.0 - u - v)))
}

#[test]
fn grounds_answer_as_their_triangles_do_one_by_one() {
    let mut wrong = Vec::new();
    for (number, scale) in scales() {
        let mut dice = dice(1000 + number);
        for round in 0..4 * cases() {
            let (forms, triangles) = grounds(&mut dice, scale);
            let pose = dice.pose(DVec3::ZERO);
            let turn = pose.rotation.as_dquat().normalize();
            let triangles: Vec<[DVec3; 3]> = triangles.iter().map(|corners| corners.map(|corner| turn * corner)).collect();
            let mut single = World::new(&WorldDef::default()).unwrap();
            for corners in &triangles {
                let vertices = corners.map(|corner| corner.as_vec3()).to_vec();
                add(&mut single, Geometry::TriangleMesh { vertices, triangles: vec![[0, 1, 2]] }, Pose::IDENTITY);
            }
            let origin = turn * (DVec3::new(dice.between(-2.0, 2.0), dice.between(-1.0, 1.0), dice.between(-1.5, 1.5)) * scale);
            let direction = dice.direction();
            let probe = dice.form(round % 6, 0.3 * scale);
            let (shape, place) = (Shape::new(probe).unwrap(), dice.pose(origin));
            let path = direction * scale * dice.between(0.1, 6.0);
            for (form, name) in forms.into_iter().zip(["field", "mesh"]) {
                let scene = {
                    let mut world = World::new(&WorldDef::default()).unwrap();
                    add(&mut world, form, pose);
                    world
                };
                let mut note =
                    |what: &str, found: String| wrong.push(format!("{name} of {scale} m, case {round}, {what}: {found}"));
                // The two differ by how single precision rounds turned corners.
                let allowed = 2.0e-6 * scale;
                let hit = scene.cast(&Cast::ray(origin, path), &all()).unwrap();
                let met = triangles.iter().zip(0_u32..).filter_map(|(&corners, i)| Some((meets(corners, origin, direction)?, i)));
                let met: Vec<_> = met.filter(|((t, _), _)| *t <= path.length()).collect();
                let sure =
                    met.iter().filter(|((_, inside), _)| *inside > 1.0e-6).map(|((t, _), _)| *t).fold(f64::INFINITY, f64::min);
                let any =
                    met.iter().filter(|((_, inside), _)| *inside > -1.0e-6).map(|((t, _), _)| *t).fold(f64::INFINITY, f64::min);
                let at = hit.map_or(f64::INFINITY, |hit| hit.distance);
                // Along a ray that grazes, a surface that is off by so much is met sooner or later by more.
                let along = allowed / hit.map_or(1.0, |hit| hit.normal.as_dvec3().dot(direction).abs().max(1.0e-3));
                if at > sure + along || at < any - along {
                    note("ray", format!("{at} m, by triangles {sure} m"));
                }
                if let Some(hit) = hit
                    && !met.iter().any(|((t, inside), i)| Some(*i) == hit.triangle && *inside > -1.0e-6 && (t - at).abs() < along)
                {
                    note("triangle", format!("{hit:?}"));
                }
                let distance =
                    |world: &World| world.nearest_shape(&shape, place, 1.0e7, &all()).unwrap().map(|near| near.distance.distance);
                let (here, there) = (distance(&scene), distance(&single));
                if (here.unwrap_or(1.0e30) - there.unwrap_or(1.0e30)).abs() > allowed {
                    note("distance", format!("{here:?} m, by triangles {there:?} m"));
                }
                let mut overlaps = Vec::new();
                scene.overlap_shape(&shape, place, &all(), &mut overlaps).unwrap();
                if there.is_some_and(|there| there.abs() > allowed && (there < 0.0) == overlaps.is_empty()) {
                    note("overlap", format!("{} with {there:?} m", overlaps.len()));
                }
                let cast = |world: &World| world.cast(&Cast::new(&shape, place, path), &all()).unwrap();
                let (here, there) = (cast(&scene), cast(&single));
                let [a, b] = [here, there].map(|hit| hit.map_or(f64::INFINITY, |hit| hit.distance));
                // One that grazes an edge may be decided by rounding: then the other is nearly touched there.
                if (a - b).abs() > 1.0e-4 * scale
                    && a.min(b).is_finite()
                    && !grazes(&scene, &shape, place, path, a.min(b), allowed)
                {
                    note("cast", format!("{a} m, by triangles {b} m"));
                }
            }
        }
    }
    wrong.truncate(60);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Whether a solid barely touches anything at this distance along a path (m), and so may as well pass.
fn grazes(world: &World, shape: &Shape, place: Pose, path: DVec3, distance: f64, allowed: f64) -> bool {
    let pose = Pose { position: place.position + path.normalize() * (distance + 1.0e-3 * path.length()), ..place };
    world.nearest_shape(shape, pose, 1.0e7, &all()).unwrap().is_none_or(|near| near.distance.distance > -10.0 * allowed)
}

#[test]
fn rays_along_grid_lines_and_through_posts_hit() {
    for n in [8_usize, 41] {
        let half = (n - 1) as f64 / 2.0;
        let heights = vec![0.0; n * n];
        let field = Geometry::HeightField { rows: n, columns: n, heights, size_x: (n - 1) as f32, size_z: (n - 1) as f32 };
        let (vertices, triangles) = field.triangles().unwrap();
        for form in [field, Geometry::TriangleMesh { vertices, triangles }] {
            let mut world = World::new(&WorldDef::default()).unwrap();
            add(&mut world, form, Pose::IDENTITY);
            let (mut missed, mut count) = (0, 0);
            for i in 0..n {
                for j in 0..n {
                    for (dx, dz) in [(0.0, 0.0), (0.375, 0.0), (0.0, 0.375), (0.5, 0.5)] {
                        let at = DVec3::new(i as f64 + dx - half, 0.0, j as f64 + dz - half);
                        if at.x.abs() > half || at.z.abs() > half {
                            continue;
                        }
                        for lean in
                            [DVec3::ZERO, DVec3::new(0.0, 0.0, 2.5), DVec3::new(-2.5, 0.0, 0.0), DVec3::new(2.0, 0.0, 2.0)]
                        {
                            let up = DVec3::Y * 5.0 + lean;
                            let hit = world.cast(&Cast::ray(at + up, up * -2.0), &all()).unwrap();
                            count += 1;
                            missed += u32::from(hit.is_none_or(|hit| (hit.point - at).length() > 1.0e-9));
                        }
                    }
                }
            }
            assert_eq!(missed, 0, "{missed} of {count} rays missed a field of {n} × {n}");
        }
    }
}
