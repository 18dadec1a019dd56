use glam::{DVec3, Quat, Vec3};

use super::weight::{principal_axes, weigh};
use super::{Hull, Triangulation, highest};

fn spiral(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |i| {
        let y = 1.0 - (2 * i + 1) as f64 / f64::from(count);
        let (sin, cos) = (2.399_963_229_728_653 * f64::from(i)).sin_cos();
        DVec3::new(cos * (1.0 - y * y).sqrt(), y, sin * (1.0 - y * y).sqrt())
    })
}

fn prism(sides: u32) -> Vec<Vec3> {
    let at = |i: u32, y: f64| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / f64::from(sides)).sin_cos();
        DVec3::new(cos, y, sin).as_vec3()
    };
    (0..sides).flat_map(|i| [at(i, -1.0), at(i, 1.0)]).collect()
}

/// Every edge once in either direction, every corner used, and no point above any plane (m, over the extent).
fn check(points: &[Vec3]) -> (Hull, f64) {
    let hull = Hull::new(points).expect("a solid");
    let mut edges: Vec<(u32, u32)> = hull.triangles().iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    edges.sort_unstable();
    assert!(edges.windows(2).all(|pair| pair[0] != pair[1]), "an edge is met twice");
    assert!(edges.iter().all(|&(a, b)| edges.binary_search(&(b, a)).is_ok()), "the surface is not closed");
    // Euler: V − E + F = 2.
    assert_eq!(hull.points().len() + hull.triangles().len(), edges.len() / 2 + 2);
    let extent = hull.surface().extent();
    let above = hull.planes().iter().flat_map(|(normal, offset)| points.iter().map(move |p| normal.dot(p.as_dvec3()) - offset));
    let above = above.fold(0.0, f64::max) / extent;
    (hull, above)
}

#[test]
fn a_hull_is_closed_and_holds_all_its_points_however_round_thin_or_far_away_it_is() {
    let mut worst: f64 = 0.0;
    for count in [4, 8, 60, 500, 4096] {
        for stretch in [DVec3::ONE, DVec3::new(1.0, 3.0e-4, 1.0), DVec3::new(3.0e-4, 1.0, 3.0e-4), DVec3::splat(1.0e-3)] {
            for shift in [DVec3::ZERO, DVec3::new(300.0, -20.0, 7.0)] {
                let turn = Quat::from_rotation_z(0.3).as_dquat();
                let points: Vec<Vec3> = spiral(count).map(|p| (turn * (p * stretch) + shift).as_vec3()).collect();
                // A body as thin as what single precision tells apart has no surface to speak of.
                if shift != DVec3::ZERO && stretch != DVec3::ONE {
                    continue;
                }
                worst = worst.max(check(&points).1);
            }
        }
    }
    for sides in [3, 64, 400, 2048] {
        worst = worst.max(check(&prism(sides)).1);
    }
    // Points on the faces of a cube, many in one plane and many on one line.
    let grid: Vec<Vec3> = (0..1000).map(|i| Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32) / 9.0).collect();
    let (cube, above) = check(&grid);
    assert_eq!((cube.points().len(), cube.faces().len()), (8, 6));
    println!("the highest point is {:.1e} of the extent above a plane", worst.max(above));
    assert!(worst.max(above) < 1.0e-9, "a point is {worst} of the extent above a plane");
}

#[test]
fn volume_centre_and_inertia_are_those_of_the_given_surface() {
    for sides in [3, 64, 224, 256, 400, 2048] {
        let weight = weigh(&Triangulation::of(&prism(sides)).unwrap());
        let n = f64::from(sides);
        let angle = std::f64::consts::TAU / n;
        let area = 0.5 * n * angle.sin();
        let volume = 2.0 * area;
        // Polar moment of a regular polygon of circumradius 1: A (2 + cos θ)/6.
        let spin = volume * (2.0 + angle.cos()) / 6.0;
        let (moments, _) = principal_axes(weight.inertia);
        assert!((weight.volume - volume).abs() < 1.0e-6 * volume, "{sides} sides: {} m³ of {volume} m³", weight.volume);
        assert!(weight.center.length() < 1.0e-6, "{sides} sides: centre {}", weight.center);
        assert!((weight.inertia.y_axis.y - spin).abs() < 1.0e-6 * spin, "{} m⁵ of {spin} m⁵", weight.inertia.y_axis.y);
        assert!(moments.min_element() > 0.0, "{moments}");
    }
}

#[test]
fn facets_stay_apart_and_flat_faces_are_one() {
    for sides in [64, 256, 400, 512] {
        let hull = Hull::new(&prism(sides)).unwrap();
        assert_eq!(hull.faces().len() as u32, sides + 2, "a prism of {sides} sides");
        assert_eq!(hull.corners(&hull.faces()[0]).len() as u32, sides, "its largest face is an end");
    }
    let hull = Hull::new(&spiral(4096).map(DVec3::as_vec3).collect::<Vec<_>>()).unwrap();
    assert!(hull.faces().len() > 8000, "{} faces of a sphere", hull.faces().len());
    for face in hull.faces() {
        let corners: Vec<DVec3> = hull.corners(face).iter().map(|&i| hull.points()[i as usize].as_dvec3()).collect();
        let around: DVec3 = corners[1..].windows(2).map(|edge| (edge[0] - corners[0]).cross(edge[1] - corners[0])).sum();
        assert!(around.dot(face.normal.as_dvec3()) > 0.0, "corners go round counter-clockwise");
    }
}

#[test]
fn the_farthest_corner_is_found_from_neighbour_to_neighbour() {
    for stretch in [DVec3::ONE, DVec3::new(1.0, 0.01, 1.0), DVec3::new(0.01, 1.0, 0.02)] {
        let hull = Hull::new(&spiral(2000).map(|p| (p * stretch).as_vec3()).collect::<Vec<_>>()).unwrap();
        for direction in spiral(501) {
            let height = |p: &Vec3| p.as_dvec3().dot(direction);
            let best = hull.points().iter().map(height).fold(f64::MIN, f64::max);
            let found = height(&hull.points()[hull.farthest(direction) as usize]);
            assert!(best - found < 1.0e-12, "{found} m of {best} m along {direction}");
        }
    }
}

#[test]
fn of_a_few_points_the_first_of_the_highest_is_found() {
    for count in 1..20 {
        // Whole numbers, so that several are as high.
        let points: Vec<Vec3> =
            (0..count).map(|i| Vec3::new((i * 7 % 5) as f32, (i * 3 % 4) as f32, (i * 5 % 3) as f32)).collect();
        for direction in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z, DVec3::ONE, DVec3::new(1.0, -1.0, 0.0), DVec3::ZERO] {
            let height = |i: usize| points[i].as_dvec3().dot(direction);
            let first = (0..count).fold(0, |best, i| if height(i) > height(best) { i } else { best });
            assert_eq!(highest(&points, direction), first as u32, "of {count} points along {direction}");
        }
    }
}

#[test]
fn moments_of_a_needle_are_exact_in_any_frame() {
    let turn = glam::DMat3::from_quat(glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0));
    let moments = DVec3::new(1.0, 1.0 + 1.0e-9, 1.0e-9);
    let (found, axes) = principal_axes(turn * glam::DMat3::from_diagonal(moments) * turn.transpose());
    let mut sorted = found.to_array();
    sorted.sort_by(f64::total_cmp);
    assert!((sorted[0] - 1.0e-9).abs() < 1.0e-15 && (sorted[2] - 1.0).abs() < 1.0e-8, "{sorted:?}");
    assert!((axes.determinant() - 1.0).abs() < 1.0e-12);
}
