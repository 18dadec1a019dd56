//! Pictures of bodies: a small software renderer, so that a picture needs neither a window nor a graphics driver.
//!
//! Bodies become triangles (`mesh`), triangles become pixels in a depth buffer, once as the light sees them and once as the
//! camera does (`raster`); this file frames the scene, draws the ground and writes the file.

mod mesh;
mod raster;

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use longspan::glam::{DVec3, Mat3, Quat, Vec2, Vec3};
use longspan::{BodyDef, BodyKind, Geometry, LocalPose, Pose};

use crate::engine::Engine;
pub use mesh::points_and_triangles;
use mesh::{Triangle, add_triangles};
use raster::{DepthMap, Projection, rasterize};

/// One form to draw.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// Its form.
    pub geometry: Geometry,
    /// Its frame.
    pub pose: Pose,
    /// Red, green and blue, 0 to 1, linear.
    pub color: Vec3,
}

/// Rows of pixels from the top, three bytes a pixel.
#[derive(Debug, Clone)]
pub struct Image {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `3 · width · height` bytes, sRGB.
    pub rgb: Vec<u8>,
}

/// Each pixel is the mean of this many by this many samples.
const SUPERSAMPLING: usize = 2;
/// Tangent of half the vertical field of view.
const VIEW_TANGENT: f32 = 0.3;
/// From the scene towards the camera and towards the light.
const TO_CAMERA: Vec3 = Vec3::new(0.45, 0.38, 1.0);
const TO_LIGHT: Vec3 = Vec3::new(-0.35, 1.0, 0.55);
const SHADOW_MAP: usize = 2048;
const AMBIENT: f32 = 0.35;
const SKY: Vec3 = Vec3::new(0.78, 0.85, 0.93);
const GROUND: Vec3 = Vec3::new(0.52, 0.53, 0.52);
const GRID: Vec3 = Vec3::new(0.40, 0.41, 0.41);
const FIXED: Vec3 = Vec3::new(0.30, 0.31, 0.33);
const SUPPORTED: Vec3 = Vec3::new(0.72, 0.16, 0.12);
const UNSUPPORTED: Vec3 = Vec3::new(0.66, 0.66, 0.62);

/// A colour for the `index`th body, told apart from its neighbours.
pub fn color_of(index: usize) -> Vec3 {
    let hue = (index as f32 * 0.618_034).fract() * std::f32::consts::TAU;
    let wave = |shift: f32| 0.42 + 0.28 * (hue + shift * std::f32::consts::TAU).cos();
    Vec3::new(wave(0.0), wave(2.0 / 3.0), wave(1.0 / 3.0))
}

/// Everything of a running scene that is to be seen. Where the engine judges support, what is supported is red.
pub fn of_engine(engine: &dyn Engine, bodies: &[(usize, &BodyDef)]) -> Vec<Drawn> {
    let mut drawn = Vec::new();
    for &(body, def) in bodies {
        let color = match engine.is_supported(body) {
            _ if def.kind != BodyKind::Dynamic => FIXED,
            Some(true) => SUPPORTED,
            Some(false) => UNSUPPORTED,
            None => color_of(body),
        };
        for shape in &def.shapes {
            let LocalPose { position, rotation } = shape.local_pose;
            let pose = engine.pose(body).transform(&Pose { position: position.as_dvec3(), rotation });
            drawn.push(Drawn { geometry: shape.shape.geometry().clone(), pose, color });
        }
    }
    drawn
}

/// Reads bodies from text, one a line: a form and its sizes, position, rotation as x, y, z, w.
///
/// `box hx hy hz`, `ball radius`, `capsule half_height radius` and `cylinder half_height radius` are known; empty lines and
/// those that begin with `#` are skipped.
///
/// # Errors
/// What the file system says; `InvalidData` with the number of the line that is none of these.
pub fn read_bodies(path: impl AsRef<Path>) -> io::Result<Vec<Drawn>> {
    let text = std::fs::read_to_string(path)?;
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let numbered = lines.enumerate().map(|(index, (number, line))| {
        let refuse = || io::Error::new(io::ErrorKind::InvalidData, format!("line {}: not a body: {line}", number + 1));
        parse_body(line).map(|(geometry, pose)| Drawn { geometry, pose, color: color_of(index) }).ok_or_else(refuse)
    });
    numbered.collect()
}

fn parse_body(line: &str) -> Option<(Geometry, Pose)> {
    let mut words = line.split_whitespace();
    let form = words.next()?;
    let numbers = words.map(|word| word.parse::<f64>().ok().filter(|value| value.is_finite())).collect::<Option<Vec<f64>>>()?;
    let size = |index: usize| numbers[index] as f32;
    let sizes = match form {
        "box" => 3,
        "capsule" | "cylinder" => 2,
        "ball" => 1,
        _ => return None,
    };
    if numbers.len() != sizes + 7 {
        return None;
    }
    let geometry = match form {
        "box" => Geometry::Box { half_extents: Vec3::new(size(0), size(1), size(2)) },
        "capsule" => Geometry::Capsule { half_height: size(0), radius: size(1) },
        "cylinder" => Geometry::Cylinder { half_height: size(0), radius: size(1) },
        _ => Geometry::Ball { radius: size(0) },
    };
    let place = &numbers[sizes..];
    let rotation = Quat::from_xyzw(place[3] as f32, place[4] as f32, place[5] as f32, place[6] as f32);
    let is_rotation = (rotation.length() - 1.0).abs() < 0.01;
    is_rotation.then(|| (geometry, Pose { position: DVec3::new(place[0], place[1], place[2]), rotation: rotation.normalize() }))
}

/// Draws all that is finite, framed so that it fills the picture; what is far larger than the rest becomes the ground.
pub fn draw(bodies: &[Drawn], width: usize, height: usize) -> Image {
    let finite: Vec<&Drawn> = bodies.iter().filter(|b| b.pose.position.is_finite() && b.pose.rotation.is_finite()).collect();
    let framed = framed(&finite);
    let center = framed.iter().map(|b| b.pose.position).sum::<DVec3>() / framed.len().max(1) as f64;
    let mut scene = Vec::new();
    for body in &framed {
        add_triangles(body, center, &mut scene);
    }
    let frame = scene.len();
    let mut ground: Option<f32> = None;
    for body in finite.iter().filter(|body| !framed.iter().any(|framed| std::ptr::eq(*framed, **body))) {
        match ground_level(body, center) {
            Some(level) => ground = Some(ground.unwrap_or(f32::NEG_INFINITY).max((level - center.y) as f32)),
            None => add_triangles(body, center, &mut scene),
        }
    }
    let lowest = scene[..frame].iter().flat_map(|t| t.points).map(|p| p.y).fold(f32::INFINITY, f32::min);
    let ground = ground.unwrap_or(if lowest.is_finite() { lowest } else { 0.0 });
    render(&scene, frame, ground, width, height)
}

/// All bodies but those that are larger than everything smaller together.
fn framed<'a>(bodies: &[&'a Drawn]) -> Vec<&'a Drawn> {
    let mut by_size: Vec<(f64, &Drawn)> = bodies.iter().map(|&body| (mesh::reach(&body.geometry), body)).collect();
    by_size.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut count = 0;
    for (reach, body) in &by_size {
        if count > 0 && *reach > 1.2 * (max - min).length() {
            break;
        }
        min = min.min(body.pose.position - *reach);
        max = max.max(body.pose.position + *reach);
        count += 1;
    }
    by_size[..count].iter().map(|&(_, body)| body).collect()
}

/// Height of the top face of a box or half-space that lies level, and below or above this point (m).
fn ground_level(body: &Drawn, center: DVec3) -> Option<f64> {
    let up = body.pose.rotation.conjugate() * Vec3::Y;
    let level = |face: Vec3| face.dot(up) > 0.9999;
    let aside = (body.pose.rotation.conjugate() * (center - body.pose.position).as_vec3()).abs();
    match &body.geometry {
        Geometry::Box { half_extents } if level(Vec3::Y) && aside.x < half_extents.x && aside.z < half_extents.z => {
            Some(body.pose.position.y + f64::from(half_extents.y))
        }
        Geometry::HalfSpace { normal } if level(*normal) => Some(body.pose.position.y),
        _ => None,
    }
}

/// Where the camera stands and what its pixels look at.
struct Camera {
    eye: Vec3,
    /// Right, up and backwards as columns.
    axes: Mat3,
    /// Tangents of half the horizontal and vertical field of view.
    tangents: Vec2,
}

impl Camera {
    /// Stands as near as all points of the frame allow.
    fn framing(points: impl Iterator<Item = Vec3> + Clone, aspect: f32) -> Self {
        let back = TO_CAMERA.normalize();
        let right = Vec3::Y.cross(back).normalize();
        let axes = Mat3::from_cols(right, back.cross(right), back);
        let tangents = Vec2::new(VIEW_TANGENT * aspect, VIEW_TANGENT);
        let local = points.map(|point| axes.transpose() * point);
        let (min, max) = local.clone().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
        let middle = if min.is_finite() { 0.5 * (min + max) } else { Vec3::ZERO };
        let needed = |p: Vec3| p.z - middle.z + ((p - middle).truncate().abs() / tangents).max_element();
        let distance = local.map(needed).fold(0.1, f32::max);
        Self { eye: axes * (middle + Vec3::Z * 1.08 * distance), axes, tangents }
    }

    /// Direction through a point of the picture, both coordinates from −1 to 1, up positive.
    fn ray(&self, at: Vec2) -> Vec3 {
        (self.axes * (at * self.tangents).extend(-1.0)).normalize()
    }
}

fn render(scene: &[Triangle], frame: usize, ground: f32, width: usize, height: usize) -> Image {
    let (columns, rows) = (width * SUPERSAMPLING, height * SUPERSAMPLING);
    let camera = Camera::framing(scene[..frame].iter().flat_map(|t| t.points), width as f32 / height as f32);
    let radius = scene[..frame].iter().flat_map(|t| t.points).map(Vec3::length).fold(1e-3, f32::max);
    let light = TO_LIGHT.normalize();
    let shadows = shadow_map(&scene[..frame], light, radius);
    let lit = |point: Vec3, normal: Vec3| {
        let offset = normal * (0.004 * radius);
        AMBIENT * (0.75 + 0.25 * normal.y) + (1.0 - AMBIENT) * normal.dot(light).max(0.0) * shadows.lit(point + offset)
    };

    let mut samples = vec![Vec3::ZERO; columns * rows];
    for (index, sample) in samples.iter_mut().enumerate() {
        let at =
            Vec2::new((index % columns) as f32 + 0.5, (index / columns) as f32 + 0.5) / Vec2::new(columns as f32, rows as f32);
        let ray = camera.ray(Vec2::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y));
        *sample = background(camera.eye, ray, ground, radius, &lit);
    }
    let view = camera.axes.transpose();
    let project = Projection { turn: view, origin: camera.eye, tangents: Some(camera.tangents), columns, rows };
    let mut depths = DepthMap::new(columns, rows);
    for triangle in scene {
        rasterize(triangle, &project, &mut depths, &mut |pixel, point, normal| {
            // The ground, seen from above, hides what is below it.
            if point.y < ground && camera.eye.y > ground {
                return;
            }
            let facing = if normal.dot(camera.eye - point) < 0.0 { -normal } else { normal };
            samples[pixel] = triangle.color * lit(point, facing);
        });
    }
    Image { width, height, rgb: downsample(&samples, columns, width, height) }
}

fn background(eye: Vec3, ray: Vec3, ground: f32, radius: f32, lit: &impl Fn(Vec3, Vec3) -> f32) -> Vec3 {
    let sky = SKY.lerp(Vec3::ONE, (0.5 - ray.y).clamp(0.0, 1.0));
    let distance = (ground - eye.y) / ray.y;
    if !(distance.is_finite() && distance > 0.0) {
        return sky;
    }
    let point = eye + ray * distance;
    // Grid lines on a round number of metres, about five across the scene.
    let spacing = 10.0_f32.powf((0.4 * radius).log10().round());
    let to_line = |x: f32| (x / spacing - (x / spacing).round()).abs() * spacing;
    let on_line = to_line(point.x).min(to_line(point.z)) < 0.0015 * distance;
    let color = if on_line { GRID } else { GROUND };
    (color * lit(point, Vec3::Y)).lerp(sky, (point.length() / (14.0 * radius)).clamp(0.0, 1.0))
}

/// The scene as the light sees it, over a disc of `radius` (m).
fn shadow_map(scene: &[Triangle], light: Vec3, radius: f32) -> Shadows {
    let right = Vec3::Z.cross(light).normalize();
    let turn = Mat3::from_cols(right, light.cross(right), light).transpose() * (1.0 / radius);
    let project = Projection { turn, origin: Vec3::ZERO, tangents: None, columns: SHADOW_MAP, rows: SHADOW_MAP };
    let mut depths = DepthMap::new(SHADOW_MAP, SHADOW_MAP);
    for triangle in scene {
        rasterize(triangle, &project, &mut depths, &mut |_, _, _| {});
    }
    Shadows { project, depths }
}

struct Shadows {
    project: Projection,
    depths: DepthMap,
}

impl Shadows {
    /// Share of the light that reaches a point, from nine samples around it.
    fn lit(&self, point: Vec3) -> f32 {
        let Some((at, depth)) = self.project.apply(point) else { return 1.0 };
        let mut reached = 0;
        for dy in -1..=1 {
            for dx in -1..=1 {
                let nearest = self.depths.at(at.x as i64 + dx, at.y as i64 + dy);
                reached += i32::from(depth <= nearest + 2e-3);
            }
        }
        reached as f32 / 9.0
    }
}

fn downsample(samples: &[Vec3], columns: usize, width: usize, height: usize) -> Vec<u8> {
    let mut rgb = Vec::with_capacity(3 * width * height);
    for row in 0..height {
        for column in 0..width {
            let mut sum = Vec3::ZERO;
            for dy in 0..SUPERSAMPLING {
                for dx in 0..SUPERSAMPLING {
                    sum += samples[(row * SUPERSAMPLING + dy) * columns + column * SUPERSAMPLING + dx].min(Vec3::ONE);
                }
            }
            let mean = sum / (SUPERSAMPLING * SUPERSAMPLING) as f32;
            rgb.extend((mean.powf(1.0 / 2.2) * 255.0).round().to_array().map(|channel| channel as u8));
        }
    }
    rgb
}

/// Writes a picture as PNG.
///
/// # Errors
/// What the file system or the encoder says.
pub fn write_png(path: impl AsRef<Path>, image: &Image) -> io::Result<()> {
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, image.width as u32, image.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(&image.rgb).map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(image: &Image, column: usize, row: usize) -> Vec3 {
        let start = 3 * (row * image.width + column);
        Vec3::from_array([0, 1, 2].map(|channel| f32::from(image.rgb[start + channel]) / 255.0))
    }

    fn red_ball(x: f64) -> Drawn {
        Drawn { geometry: Geometry::Ball { radius: 0.5 }, pose: Pose::at_xyz(x, 0.0, 0.0), color: Vec3::X }
    }

    #[test]
    fn a_body_fills_the_middle_of_its_picture_wherever_it_is() {
        for x in [0.0, 1.0e6] {
            let image = draw(&[red_ball(x)], 64, 48);
            let (middle, corner) = (at(&image, 32, 24), at(&image, 1, 1));
            assert!(middle.x > 0.4 && middle.y < 0.1, "the middle is {middle}, expected red");
            assert!(corner.y > 0.5, "the corner is {corner}, expected the sky");
            let red = (0..64 * 48).filter(|i| at(&image, i % 64, i / 64).y < 0.1).count();
            assert!(red > 800, "{red} pixels of 3072 show the body, expected more than 800");
        }
    }

    #[test]
    fn what_is_nearer_hides_what_is_behind() {
        let toward = TO_CAMERA.normalize().as_dvec3();
        let behind = Drawn { color: Vec3::Z, pose: Pose::at(-3.0 * toward), ..red_ball(0.0) };
        for bodies in [[red_ball(0.0), behind.clone()], [behind.clone(), red_ball(0.0)]] {
            let middle = at(&draw(&bodies, 64, 64), 32, 32);
            assert!(middle.x > 0.3 && middle.z < 0.1, "the middle is {middle}, expected red before blue");
        }
    }

    #[test]
    fn a_floor_far_larger_than_the_rest_does_not_shrink_the_picture() {
        let half_extents = Vec3::new(500.0, 0.5, 500.0);
        let floor = Drawn { geometry: Geometry::Box { half_extents }, pose: Pose::at_xyz(0.0, -1.0, 0.0), color: Vec3::Y };
        let image = draw(&[floor, red_ball(0.0)], 64, 48);
        let middle = at(&image, 32, 24);
        assert!(middle.x > 0.4 && middle.y < 0.1, "the middle is {middle}, expected red");
    }

    #[test]
    fn bodies_are_read_line_by_line() {
        let path = std::env::temp_dir().join(format!("longspan-bodies-{}.txt", std::process::id()));
        std::fs::write(&path, "# a box\nbox 1 2 3  4 5 6  0 0 0 1\n\nball 0.5  0 1 0  0 0 0 1\ncapsule 0.3 0.1 0 0 0 1 0 0 0\n")
            .unwrap();
        let bodies = read_bodies(&path).unwrap();
        assert_eq!(bodies.len(), 3);
        assert_eq!(bodies[0].geometry, Geometry::Box { half_extents: Vec3::new(1.0, 2.0, 3.0) });
        assert_eq!(bodies[0].pose, Pose::at_xyz(4.0, 5.0, 6.0));
        std::fs::write(&path, "ball 0.5  0 1 0  0 0 0 1\nbox 1 2 3\n").unwrap();
        let problem = read_bodies(&path).unwrap_err().to_string();
        assert!(problem.contains("line 2"), "{problem}");
        std::fs::remove_file(path).unwrap();
    }
}
