//! A scene as forms to draw: bodies in their colours, and what holds them.

use longspan::glam::{DVec3, Mat3, Quat, Vec3};
use longspan::{Geometry, Pose};
use longspan_scenes::picture::{Drawn, color_of};
use longspan_stream::Scene;
use longspan_stream::schema::{
    LS_STREAM_BODY_ASLEEP, LS_STREAM_BODY_SUPPORT_KNOWN, LS_STREAM_BODY_SUPPORTED, LsStreamBody, LsStreamBound, LsStreamShape,
};

/// What is shown beside the bodies.
#[derive(Debug, Clone, Copy)]
pub struct Layers {
    /// Red for what nothing holds up.
    pub support: bool,
    /// One colour for each rigid union.
    pub unions: bool,
    /// Long-range bounds.
    pub bounds: bool,
    /// Joints, by the share of their limit that they carry.
    pub joints: bool,
    /// Points of contact.
    pub contacts: bool,
    /// Planes of hinge chains.
    pub planes: bool,
}

impl Layers {
    /// All of them.
    pub const ALL: Self = Self { support: true, unions: true, bounds: true, joints: true, contacts: true, planes: true };
}

const FIXED: Vec3 = Vec3::new(0.30, 0.31, 0.33);
const UNSUPPORTED: Vec3 = Vec3::new(0.85, 0.10, 0.08);
const BROKEN: Vec3 = Vec3::new(1.0, 0.45, 0.0);

/// Radius of a line over the size of the scene.
const THIN: f32 = 0.0012;

/// From green over yellow to red.
fn heat(share: f32) -> Vec3 {
    let share = share.clamp(0.0, 1.0);
    Vec3::new((2.0 * share).min(1.0), (2.0 - 2.0 * share).min(1.0), 0.1) * 0.8
}

/// Colour of a body.
fn color(body: &LsStreamBody, layers: Layers) -> Vec3 {
    let known = body.flags & LS_STREAM_BODY_SUPPORT_KNOWN != 0;
    if body.kind != 2 {
        return FIXED;
    }
    if layers.support && known && body.flags & LS_STREAM_BODY_SUPPORTED == 0 {
        return UNSUPPORTED;
    }
    let number = if layers.unions && body.union_id != 0 { body.union_id } else { body.body } & 0x0FFF_FFFF;
    let asleep = if body.flags & LS_STREAM_BODY_ASLEEP != 0 { 0.6 } else { 1.0 };
    color_of(number as usize) * asleep
}

fn geometry(scene: &Scene, shape: &LsStreamShape) -> Option<Geometry> {
    let [a, b, _] = shape.size;
    Some(match shape.kind {
        0 => Geometry::Ball { radius: a },
        1 => Geometry::Box { half_extents: Vec3::from_array(shape.size) },
        2 => Geometry::Capsule { half_height: a, radius: b },
        3 => Geometry::Cylinder { half_height: a, radius: b },
        4 => Geometry::Cone { half_height: a, radius: b },
        5..=7 => {
            let mesh = scene.mesh(shape.shape, shape.part)?;
            let vertices = mesh.vertices.iter().map(|&vertex| Vec3::from_array(vertex)).collect();
            Geometry::TriangleMesh { vertices, triangles: mesh.triangles.clone() }
        }
        8 => Geometry::HalfSpace { normal: Vec3::from_array(shape.size) },
        _ => return None,
    })
}

/// Frame of a body in the world.
pub fn pose_of(body: &LsStreamBody) -> Pose {
    Pose { position: DVec3::from_array(body.position), rotation: Quat::from_array(body.rotation).normalize() }
}

/// Where a shape is in the world, and half of the box about it whose sides are along the axes (m).
pub fn place(body: &LsStreamBody, shape: &LsStreamShape) -> (DVec3, Vec3) {
    let pose = pose_of(body).transform(&local_pose(shape));
    let turned = Mat3::from_quat(pose.rotation);
    let turned = Mat3::from_cols(turned.x_axis.abs(), turned.y_axis.abs(), turned.z_axis.abs());
    let [a, b, _] = shape.size;
    let half = match shape.kind {
        0 => Vec3::splat(a),
        1 => turned * Vec3::from_array(shape.size),
        2 => turned.y_axis * a + Vec3::splat(b),
        3 | 4 => turned * Vec3::new(b, a, b),
        // What is made of triangles says how far it goes, not where.
        _ => Vec3::splat(Vec3::from_array(shape.size).length()),
    };
    (pose.position, half)
}

fn local_pose(shape: &LsStreamShape) -> Pose {
    Pose { position: Vec3::from_array(shape.position).as_dvec3(), rotation: Quat::from_array(shape.rotation) }
}

/// Every form of a scene, with the number of its body; 0 for what is none.
pub fn of_scene(scene: &Scene, layers: Layers) -> Vec<(u64, Drawn)> {
    let mut drawn = Vec::new();
    for shape in scene.shapes() {
        let (Some(body), Some(geometry)) = (scene.body(shape.body), geometry(scene, shape)) else { continue };
        let pose = pose_of(body).transform(&local_pose(shape));
        drawn.push((body.body, Drawn { geometry, pose, color: color(body, layers) }));
    }
    let size = reach(&drawn);
    add_spans(scene, layers, size, &mut drawn);
    drawn
}

/// A length in proportion to the scene (m): the middle of the distances of its bodies from each other.
pub fn reach(drawn: &[(u64, Drawn)]) -> f32 {
    let finite = drawn.iter().map(|(_, part)| part.pose.position).filter(|position| position.length() < 1e5);
    let (min, max) = finite.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), at| (min.min(at), max.max(at)));
    if min.is_finite() { ((max - min).length() as f32).max(0.1) } else { 1.0 }
}

/// From 0 for a bound with a tenth of its length to spare, to 1 for one that has reached it.
fn tightness(bound: &LsStreamBound) -> f32 {
    let above = bound.upper - bound.distance;
    let slack = if bound.lower > 0.0 { above.min(bound.distance - bound.lower) } else { above };
    1.0 - 10.0 * slack / bound.upper.max(1e-6)
}

/// A place where a joint broke a moment ago.
pub fn broken_at(at: [f64; 3], size: f32) -> Drawn {
    Drawn { geometry: Geometry::Ball { radius: 0.006 * size }, pose: Pose::at(DVec3::from_array(at)), color: BROKEN }
}

fn greatest_tension(scene: &Scene) -> f32 {
    scene.bounds().iter().map(|bound| bound.tension.abs()).fold(0.0, f32::max)
}

/// A bound as a line: the redder the tighter, the thicker the more it carries of what the one does that carries `most` (N).
fn span(bound: &LsStreamBound, most: f32, thin: f32) -> Drawn {
    let [near, far] = [bound.near_point, bound.far_point].map(DVec3::from_array);
    let along = (far - near).as_vec3();
    let load = if most > 0.0 { bound.tension.abs() / most } else { 0.0 };
    Drawn {
        geometry: Geometry::Capsule { half_height: 0.5 * along.length(), radius: thin * (0.6 + 1.4 * load) },
        pose: Pose {
            position: 0.5 * (near + far),
            rotation: Quat::from_rotation_arc(Vec3::Y, along.try_normalize().unwrap_or(Vec3::Y)),
        },
        color: heat(tightness(bound)),
    }
}

/// The bounds that carry at least a tenth of what one carries at most, those that carry most last. A chain that is taut hides them.
pub fn loaded_bounds(scene: &Scene, layers: Layers, size: f32) -> Vec<(u64, Drawn)> {
    let most = greatest_tension(scene);
    let mut loaded: Vec<&LsStreamBound> = scene.bounds().iter().filter(|bound| bound.tension.abs() > 0.1 * most).collect();
    loaded.retain(|_| layers.bounds);
    loaded.sort_by(|a, b| a.tension.abs().total_cmp(&b.tension.abs()));
    loaded.into_iter().map(|bound| (0, span(bound, most, THIN * size))).collect()
}

/// Bounds, joints, contacts and planes.
fn add_spans(scene: &Scene, layers: Layers, size: f32, drawn: &mut Vec<(u64, Drawn)>) {
    let thin = THIN * size;
    let mut dot = |at: DVec3, radius: f32, color: Vec3| {
        drawn.push((0, Drawn { geometry: Geometry::Ball { radius }, pose: Pose::at(at), color }));
    };
    if layers.contacts {
        for contact in scene.contacts() {
            for point in &contact.points[..contact.point_count.min(4) as usize] {
                dot(DVec3::from_array(point.position), 2.0 * thin, Vec3::new(1.0, 0.85, 0.1));
            }
        }
    }
    if layers.joints {
        for load in scene.joint_loads() {
            let Some(joint) = scene.joint(load.joint) else { continue };
            let local = DVec3::from_array(joint.position_a).as_vec3();
            let at =
                scene.body(joint.body_a).map_or(DVec3::from_array(joint.position_a), |body| pose_of(body).transform_point(local));
            dot(at, 2.5 * thin, heat(load.share));
        }
    }
    if layers.bounds {
        let most = greatest_tension(scene);
        drawn.extend(scene.bounds().iter().map(|bound| (0, span(bound, most, thin))));
    }
    if layers.planes {
        for plane in scene.planes() {
            let normal = Vec3::from_array(plane.normal).try_normalize().unwrap_or(Vec3::Y);
            drawn.push((
                0,
                Drawn {
                    geometry: Geometry::Cylinder { half_height: 0.5 * thin, radius: plane.radius },
                    pose: Pose { position: DVec3::from_array(plane.point), rotation: Quat::from_rotation_arc(Vec3::Y, normal) },
                    color: Vec3::new(0.3, 0.5, 0.9),
                },
            ));
        }
    }
}
