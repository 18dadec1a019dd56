//! A recording as a glTF 2.0 animation: one node a body, one mesh a shape, translation and rotation of each frame.
//!
//! Two files: NAME.gltf, and NAME.bin with the numbers beside it. Bodies that never move have no animation.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use gltf_json as json;
use json::validation::Checked::Valid;
use json::validation::USize64;
use longspan::glam::{DVec3, Vec3};
use longspan_scenes::picture::points_and_triangles;
use longspan_stream::{Poll, Reader};

use crate::Outcome;
use crate::parts::{Layers, of_scene};

const SEGMENTS: u32 = 16;

/// What is written, as it grows.
struct Document {
    root: json::Root,
    bytes: Vec<u8>,
}

/// The frames of one part.
#[derive(Default)]
struct Track {
    times: Vec<f32>,
    places: Vec<[f32; 3]>,
    turns: Vec<[f32; 4]>,
}

/// Writes all frames of a recording.
pub fn write(mut reader: Reader, to: &Path) -> Outcome<()> {
    let bodies = Layers { support: false, unions: true, bounds: false, joints: false, contacts: false, planes: false };
    let mut document = Document { root: json::Root::default(), bytes: Vec::new() };
    let mut tracks: BTreeMap<usize, Track> = BTreeMap::new();
    let mut nodes: BTreeMap<(u64, usize), usize> = BTreeMap::new();
    let mut origin: Option<DVec3> = None;
    let mut frames = 0;
    loop {
        match reader.poll_next() {
            Ok(Poll::Frame { .. }) => frames += 1,
            Ok(_) => break,
            Err(problem) => {
                eprintln!("{problem}");
                continue;
            }
        }
        let time = reader.scene().frame().time as f32;
        let mut of_body: BTreeMap<u64, usize> = BTreeMap::new();
        for (body, part) in of_scene(reader.scene(), bodies) {
            let number = of_body.entry(body).or_insert(0);
            let key = (body, *number);
            *number += 1;
            // A half-space has no end that a mesh could have.
            let (points, triangles) = points_and_triangles(&part.geometry, SEGMENTS);
            if triangles.is_empty() {
                continue;
            }
            let node = *nodes.entry(key).or_insert_with(|| document.add_part(&points, &triangles, part.color, body));
            // glTF has floats only: the middle of the first frame becomes the origin.
            let origin = *origin.get_or_insert(part.pose.position.round());
            let track = tracks.entry(node).or_default();
            track.times.push(time);
            track.places.push((part.pose.position - origin).as_vec3().to_array());
            track.turns.push(part.pose.rotation.to_array());
        }
    }
    document.animate(&tracks);
    let numbers = to.with_extension("bin");
    let name = numbers.file_name().ok_or("the file has no name")?.to_string_lossy().into_owned();
    document.finish(&name);
    fs::write(&numbers, &document.bytes)?;
    fs::write(to, document.root.to_string_pretty()?)?;
    println!("{frames} frames, {} parts: {} and {name}", tracks.len(), to.display());
    Ok(())
}

impl Document {
    /// Appends numbers, and an accessor to them.
    fn add(
        &mut self,
        values: &[f32],
        per_element: usize,
        kind: json::accessor::Type,
        bounds: bool,
    ) -> json::Index<json::Accessor> {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let extreme = |pick: fn(f32, f32) -> f32| {
            let of = |axis: usize| values.iter().skip(axis).step_by(per_element).copied().reduce(pick).unwrap_or(0.0);
            json::Value::from((0..per_element).map(of).collect::<Vec<f32>>())
        };
        let (min, max) = if bounds { (Some(extreme(f32::min)), Some(extreme(f32::max))) } else { (None, None) };
        self.add_bytes(&bytes, values.len() / per_element, json::accessor::ComponentType::F32, kind, (min, max), None)
    }

    fn add_bytes(
        &mut self,
        bytes: &[u8],
        count: usize,
        component: json::accessor::ComponentType,
        kind: json::accessor::Type,
        (min, max): (Option<json::Value>, Option<json::Value>),
        target: Option<json::buffer::Target>,
    ) -> json::Index<json::Accessor> {
        let view = self.root.push(json::buffer::View {
            buffer: json::Index::new(0),
            byte_length: USize64::from(bytes.len()),
            byte_offset: Some(USize64::from(self.bytes.len())),
            byte_stride: None,
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: json::Extras::default(),
        });
        self.bytes.extend_from_slice(bytes);
        self.root.push(json::Accessor {
            buffer_view: Some(view),
            byte_offset: Some(USize64(0)),
            count: USize64::from(count),
            component_type: Valid(json::accessor::GenericComponentType(component)),
            type_: Valid(kind),
            min,
            max,
            name: None,
            normalized: false,
            sparse: None,
            extensions: None,
            extras: json::Extras::default(),
        })
    }

    /// A node with a mesh of its own; its number.
    fn add_part(&mut self, points: &[Vec3], triangles: &[[u32; 3]], color: Vec3, body: u64) -> usize {
        let flat: Vec<f32> = points.iter().flat_map(|point| point.to_array()).collect();
        let positions = self.add(&flat, 3, json::accessor::Type::Vec3, true);
        if let Some(view) = self.root.buffer_views.last_mut() {
            view.target = Some(Valid(json::buffer::Target::ArrayBuffer));
        }
        let corners: Vec<u8> = triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes()).collect();
        let indices = self.add_bytes(
            &corners,
            3 * triangles.len(),
            json::accessor::ComponentType::U32,
            json::accessor::Type::Scalar,
            (None, None),
            Some(json::buffer::Target::ElementArrayBuffer),
        );
        let material = self.root.push(json::Material {
            pbr_metallic_roughness: json::material::PbrMetallicRoughness {
                base_color_factor: json::material::PbrBaseColorFactor([color.x, color.y, color.z, 1.0]),
                metallic_factor: json::material::StrengthFactor(0.0),
                ..Default::default()
            },
            ..Default::default()
        });
        let mesh = self.root.push(json::Mesh {
            primitives: vec![json::mesh::Primitive {
                attributes: [(Valid(json::mesh::Semantic::Positions), positions)].into(),
                indices: Some(indices),
                material: Some(material),
                mode: Valid(json::mesh::Mode::Triangles),
                targets: None,
                extensions: None,
                extras: json::Extras::default(),
            }],
            weights: None,
            name: None,
            extensions: None,
            extras: json::Extras::default(),
        });
        let node = json::Node { mesh: Some(mesh), name: Some(format!("body {body:x}")), ..Default::default() };
        self.root.push(node).value()
    }

    fn animate(&mut self, tracks: &BTreeMap<usize, Track>) {
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for (&node, track) in tracks {
            if let (Some(place), Some(turn)) = (track.places.first(), track.turns.first()) {
                self.root.nodes[node].translation = Some(*place);
                self.root.nodes[node].rotation = Some(json::scene::UnitQuaternion(*turn));
            }
            let moves = track.places.windows(2).any(|two| two[0] != two[1]) || track.turns.windows(2).any(|two| two[0] != two[1]);
            if !moves {
                continue;
            }
            let times = self.add(&track.times, 1, json::accessor::Type::Scalar, true);
            let places = self.add(track.places.as_flattened(), 3, json::accessor::Type::Vec3, false);
            let turns = self.add(track.turns.as_flattened(), 4, json::accessor::Type::Vec4, false);
            for (output, path) in [(places, json::animation::Property::Translation), (turns, json::animation::Property::Rotation)]
            {
                let sampler = samplers.len() as u32;
                samplers.push(json::animation::Sampler {
                    input: times,
                    interpolation: Valid(json::animation::Interpolation::Linear),
                    output,
                    extensions: None,
                    extras: json::Extras::default(),
                });
                channels.push(json::animation::Channel {
                    sampler: json::Index::new(sampler),
                    target: json::animation::Target {
                        node: json::Index::new(node as u32),
                        path: Valid(path),
                        extensions: None,
                        extras: json::Extras::default(),
                    },
                    extensions: None,
                    extras: json::Extras::default(),
                });
            }
        }
        if !channels.is_empty() {
            self.root.push(json::Animation {
                channels,
                samplers,
                name: Some("recording".to_owned()),
                extensions: None,
                extras: json::Extras::default(),
            });
        }
    }

    fn finish(&mut self, name: &str) {
        self.root.push(json::Buffer {
            byte_length: USize64::from(self.bytes.len()),
            uri: Some(name.to_owned()),
            name: None,
            extensions: None,
            extras: json::Extras::default(),
        });
        let nodes = (0..self.root.nodes.len() as u32).map(json::Index::new).collect();
        let scene = json::Scene { nodes, name: None, extensions: None, extras: json::Extras::default() };
        self.root.scene = Some(self.root.push(scene));
    }
}

#[cfg(test)]
mod tests {
    use ::gltf::animation::util::ReadOutputs;
    use longspan::glam::Quat;
    use longspan_scenes::{DT, LongspanEngine, build};
    use longspan_stream::{Domain, Publisher, PublisherDef};

    use super::*;

    /// A recording of a chain that swings; it and the pose of one link in each of its frames.
    fn recorded(folder: &Path) -> Vec<(f32, DVec3, [f32; 4])> {
        let domain = Domain::named(&format!("gltf{}", std::process::id())).unwrap();
        let scene = build("swinging_weight", &[("n".to_owned(), "6".to_owned())]).unwrap();
        let mut engine = LongspanEngine::start(&scene).unwrap();
        let last = engine.body_id(scene.bodies.len() - 1);
        let world = engine.world_mut();
        let def = PublisherDef { domain: domain.clone(), name: "gltf".into(), ..PublisherDef::default() };
        let mut publisher = Publisher::open(world, &def).unwrap();
        let mut reader = Reader::attach(&domain, "gltf").unwrap();
        while reader.poll().unwrap() != Poll::Nothing {}
        reader.record(Some(&folder.join("chain.lsr"))).unwrap();
        let mut poses = Vec::new();
        for _ in 0..40 {
            world.step(DT).unwrap();
            publisher.publish(world);
            reader.wait(std::time::Duration::from_secs(5)).unwrap();
            let pose = world.pose(last).unwrap();
            poses.push((world.time() as f32, pose.position, pose.rotation.to_array()));
        }
        reader.record(None).unwrap();
        poses
    }

    #[test]
    fn another_reader_of_gltf_finds_every_frame() {
        let folder = std::env::temp_dir().join(format!("longspan-gltf-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let poses = recorded(&folder);
        write(Reader::open(&folder.join("chain.lsr")).unwrap(), &folder.join("chain.gltf")).unwrap();
        // Checks the document against the format's rules, and every accessor against the buffer.
        let (document, buffers, _) = ::gltf::import(folder.join("chain.gltf")).unwrap();
        fs::remove_dir_all(&folder).unwrap();
        let data = |buffer: ::gltf::Buffer<'_>| Some(&*buffers[buffer.index()].0);

        let animation = document.animations().next().expect("one animation");
        let mut tracks: BTreeMap<usize, Track> = BTreeMap::new();
        for channel in animation.channels() {
            let reader = channel.reader(data);
            let track = tracks.entry(channel.target().node().index()).or_default();
            track.times = reader.read_inputs().expect("times").collect();
            match reader.read_outputs().expect("values") {
                ReadOutputs::Translations(places) => track.places = places.collect(),
                ReadOutputs::Rotations(turns) => track.turns = turns.into_f32().collect(),
                _ => panic!("neither places nor turns"),
            }
        }
        // What is recorded begins with the frame that was there when the reader came.
        let last = tracks.values().last().expect("the weight was made last, and moves");
        let skipped = last.times.len() - poses.len();
        assert!(skipped <= 1, "{} frames of {}", last.times.len(), poses.len());
        let place = |frame: usize| Vec3::from_array(last.places[frame]).as_dvec3();
        let origin = poses[0].1 - place(skipped);
        assert!(origin.distance(origin.round()) < 1e-5, "the origin is a whole number of metres: {origin}");
        for (frame, (time, position, turn)) in poses.iter().enumerate() {
            let at = frame + skipped;
            assert_eq!(last.times[at], *time, "frame {frame}");
            // It was made of length one once more.
            let turned = Quat::from_array(last.turns[at]).abs_diff_eq(Quat::from_array(*turn), 2.0 * f32::EPSILON);
            assert!(turned, "frame {frame}: {:?} for {turn:?}", last.turns[at]);
            let off = (place(at) + origin.round()).distance(*position);
            assert!(off < 1e-5, "frame {frame}: {off} m off");
        }
        for mesh in document.meshes() {
            let primitive = mesh.primitives().next().expect("triangles");
            let reader = primitive.reader(data);
            let points = reader.read_positions().expect("points").count();
            let corners: Vec<u32> = reader.read_indices().expect("triangles").into_u32().collect();
            assert!(points > 3 && corners.len().is_multiple_of(3) && corners.iter().all(|&corner| (corner as usize) < points));
        }
    }
}
