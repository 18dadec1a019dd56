//! Contacts act where surfaces meet, and nowhere else: what passes by is left alone, and what slides or rolls over one surface made of
//! many pieces moves as over one.

use longspan::glam::{DVec3, Quat, Vec3};
use longspan::{BodyDef, Geometry, Pose, Shape, ShapeDef, World, WorldDef};

/// A floor of `2 * cells * cells` triangles with diagonals both ways, as a mesh or a height field.
fn grid(cells: usize, cell: f32, height: impl Fn(f32, f32) -> f32, is_field: bool) -> Shape {
    let side = cells + 1;
    let size = cells as f32 * cell;
    let coordinate = |i: usize| i as f32 * cell - 0.5 * size;
    if is_field {
        let heights = (0..side * side).map(|i| height(coordinate(i % side), coordinate(i / side))).collect();
        return Shape::new(Geometry::HeightField { rows: side, columns: side, heights, size_x: size, size_z: size }).unwrap();
    }
    let vertex = |i: usize| {
        let (x, z) = (coordinate(i / side), coordinate(i % side));
        Vec3::new(x, height(x, z), z)
    };
    let vertices = (0..side * side).map(vertex).collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
        let (a, b) = ((i * side + j) as u32, (i * side + j + 1) as u32);
        let (c, d) = (a + side as u32, b + side as u32);
        triangles.extend(if (i + j) % 2 == 1 { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] });
    }
    Shape::new(Geometry::TriangleMesh { vertices, triangles }).unwrap()
}

#[test]
fn what_lies_on_a_fine_mesh_does_not_roll_by_itself() {
    for (size, cell) in [(0.002, 0.5), (0.01, 0.5), (0.01, 2.0), (0.05, 0.5), (0.5, 0.5)] {
        for is_field in [false, true] {
            for is_cylinder in [false, true] {
                let mut world = World::new(&WorldDef { hold: false, ..WorldDef::default() }).unwrap();
                let floor = ShapeDef::new(grid(24, cell * size, |_, _| 0.0, is_field));
                world.create_body(&BodyDef::fixed(Pose::IDENTITY).with_shape(floor)).unwrap();
                let (half_height, radius) = (size, 0.6 * size);
                let round = if is_cylinder {
                    Geometry::Cylinder { half_height, radius }
                } else {
                    Geometry::Capsule { half_height, radius }
                };
                let lying = Quat::from_rotation_y(0.7) * Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
                let at = DVec3::new(0.31, 0.6, 0.17) * f64::from(size);
                let pose = Pose { position: at, rotation: lying };
                let def = BodyDef { can_sleep: false, ..BodyDef::dynamic(pose) };
                let body = world.create_body(&def.with_shape(ShapeDef::new(Shape::new(round).unwrap()))).unwrap();
                for _ in 0..300 {
                    world.step(1.0 / 60.0).unwrap();
                }
                let drift = (world.pose(body).unwrap().position - at).length() / f64::from(size);
                let what = (if is_cylinder { "cylinder" } else { "capsule" }, if is_field { "field" } else { "mesh" });
                println!("{what:?}, size {size} m, cells of {cell} sizes: drift {drift:.4} sizes");
                // What rolled by itself went several sizes in this time.
                assert!(drift < 0.1, "{what:?}, size {size} m, cells of {cell} sizes: drift {drift} sizes in 5 s");
            }
        }
    }
}
