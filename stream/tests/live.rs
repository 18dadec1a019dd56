//! A stream from a publisher to readers, in one process: what is published is what is read.

mod common;

use std::os::unix::fs::PermissionsExt;
use std::time::Duration;

use common::{Room, body_matches, falling_boxes};
use longspan::{BodyDef, Handle, JointDef, JointKind, Pose, Shape, ShapeDef, glam::Vec3};
use longspan_stream::{Domain, Poll, Publisher, PublisherDef, Reader};

const DT: f32 = 1.0 / 60.0;

#[test]
fn a_reader_sees_every_body_where_the_world_has_it() {
    let room = Room::new("a_reader_sees");
    let mut world = falling_boxes(50);
    let mut publisher = Publisher::open(&world, &room.def("falling")).unwrap();
    let mut reader = common::attach(&room, "falling", std::slice::from_mut(&mut publisher));
    for step in 0..200 {
        world.step(DT).unwrap();
        publisher.publish(&world);
        let poll = reader.wait(Duration::from_secs(5)).unwrap();
        assert!(matches!(poll, Poll::Frame { lost_frames: 0, lost_records: 0, .. }), "step {step}: {poll:?}");
        assert_eq!(reader.scene().frame().step, world.step_count());
        assert_eq!(reader.scene().frame().state_hash, world.state_hash());
        for body in world.bodies() {
            let found = reader.scene().body(body.to_bits()).expect("every body is told of when the stream is opened");
            body_matches(&world, body, found);
        }
    }
    assert!(reader.scene().is_complete());
    assert_eq!(reader.scene().shapes().count(), world.shape_count());
    assert_eq!(publisher.stats().dropped, 0);
}

#[test]
fn one_that_joins_late_knows_everything_at_once() {
    let room = Room::new("joins_late");
    let mut world = falling_boxes(300);
    let mut publisher = Publisher::open(&world, &room.def("late")).unwrap();
    for _ in 0..500 {
        world.step(DT).unwrap();
        publisher.publish(&world);
    }
    let mut reader = Reader::attach(&room.domain, "").unwrap();
    assert_eq!(reader.poll().unwrap(), Poll::Nothing, "attached, but the publisher has not noticed");
    publisher.serve();
    let poll = reader.wait(Duration::from_secs(5)).unwrap();
    assert!(matches!(poll, Poll::Frame { is_first: true, .. }), "{poll:?}");
    assert!(reader.scene().is_complete(), "the history of the cold channel holds a whole cycle of so small a world");
    for body in world.bodies() {
        let found = reader.scene().body(body.to_bits()).expect("complete");
        body_matches(&world, body, found);
    }
}

#[test]
fn what_comes_and_goes_is_told_in_order() {
    let room = Room::new("comes_and_goes");
    let mut world = falling_boxes(3);
    let mut publisher = Publisher::open(&world, &room.def("changes")).unwrap();
    let mut reader = common::attach(&room, "changes", std::slice::from_mut(&mut publisher));

    let form =
        Shape::new(longspan::Geometry::ConvexHull { points: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::splat(0.5)] });
    let def = BodyDef::dynamic(Pose::at_xyz(0.0, 9.0, 0.0)).with_shape(ShapeDef::new(form.unwrap()));
    let rock = world.create_body(&def).unwrap();
    let other = world.bodies().nth(1).unwrap();
    let joint = world.create_joint(&JointDef::new(JointKind::SPHERICAL, rock, other)).unwrap();
    let mut next = |world: &mut longspan::World, reader: &mut Reader| {
        world.step(DT).unwrap();
        publisher.publish(world);
        assert!(matches!(reader.wait(Duration::from_secs(5)).unwrap(), Poll::Frame { .. }));
    };
    next(&mut world, &mut reader);
    let scene = reader.scene();
    let shape = scene.shapes().find(|shape| shape.body == rock.to_bits()).expect("its shape is told of");
    let hull = shape.shape;
    let mesh = scene.mesh(shape.shape, shape.part).expect("a hull comes with triangles");
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (5, 6), "five corners of a hull, six triangles");
    let told = scene.joint(joint.to_bits()).expect("the joint is told of");
    assert_eq!((told.body_a, told.body_b, told.kind), (rock.to_bits(), other.to_bits(), 2));

    world.destroy_body(rock).unwrap();
    next(&mut world, &mut reader);
    let scene = reader.scene();
    assert!(scene.body(rock.to_bits()).is_none() && scene.joint(joint.to_bits()).is_none());
    assert_eq!(scene.shapes().count(), world.shape_count());
    assert!(scene.mesh(hull, 0).is_none(), "its triangles are gone with it");
}

#[test]
fn two_worlds_and_three_readers_do_not_mix() {
    let room = Room::new("do_not_mix");
    let (mut first, mut second) = (falling_boxes(5), falling_boxes(9));
    let mut publishers =
        [Publisher::open(&first, &room.def("first")).unwrap(), Publisher::open(&second, &room.def("second")).unwrap()];
    let mut readers = ["first", "second", "second"].map(|name| common::attach(&room, name, &mut publishers));
    for _ in 0..20 {
        first.step(DT).unwrap();
        second.step(DT).unwrap();
        publishers[0].publish(&first);
        publishers[1].publish(&second);
        let hashes = readers.each_mut().map(|reader| {
            reader.wait(Duration::from_secs(5)).unwrap();
            reader.scene().frame().state_hash
        });
        assert_eq!(hashes, [first.state_hash(), second.state_hash(), second.state_hash()]);
    }
    assert_eq!(room.domain.sources().unwrap().len(), 2);
}

#[test]
fn nobody_but_the_owner_can_open_what_a_stream_is_made_of() {
    let room = Room::new("owner");
    let mut publisher = Publisher::open(&falling_boxes(4), &room.def("host")).unwrap();
    let _reader = common::attach(&room, "host", std::slice::from_mut(&mut publisher));
    let files = room.files();
    assert!(files.iter().filter(|file| file.starts_with("/dev/shm")).count() >= 3, "{files:?}");
    for file in files {
        let mode = std::fs::metadata(&file).unwrap().permissions().mode();
        // What lies in the folder cannot be reached by others, whatever it says of itself.
        let reached = file.starts_with("/dev/shm") || file == room.domain.folder();
        assert!(!reached || mode & 0o077 == 0, "{}: {mode:o}", file.display());
    }
}

#[test]
fn a_domain_that_is_cleared_leaves_alone_one_whose_name_begins_alike() {
    let room = Room::new("alike");
    let longer = Room { domain: Domain::named(&format!("{}_more", common::domain_name(&room))).unwrap() };
    let mut world = falling_boxes(4);
    let mut publisher = Publisher::open(&world, &longer.def("host")).unwrap();
    drop(Publisher::open(&world, &room.def("host")).unwrap());
    let mut reader = common::attach(&longer, "host", std::slice::from_mut(&mut publisher));
    world.step(DT).unwrap();
    publisher.publish(&world);
    assert!(matches!(reader.wait(Duration::from_secs(5)).unwrap(), Poll::Frame { lost_frames: 0, .. }));
}

#[test]
fn a_reader_tells_nothing_new_from_gone_and_takes_up_again() {
    let room = Room::new("takes_up_again");
    let mut world = falling_boxes(4);
    let mut reader = Reader::attach(&room.domain, "host").unwrap();
    assert_eq!(reader.poll().unwrap(), Poll::Gone, "nobody is there yet");
    for life in 0..3 {
        let mut publisher = Publisher::open(&world, &room.def("host")).unwrap();
        common::until(&mut reader, Poll::Nothing);
        world.step(DT).unwrap();
        publisher.publish(&world);
        let poll = reader.wait(Duration::from_secs(5)).unwrap();
        assert!(matches!(poll, Poll::Frame { is_first: true, .. }), "life {life}: {poll:?}");
        assert_eq!(reader.poll().unwrap(), Poll::Nothing, "life {life}");
        drop(publisher);
        assert_eq!(common::until(&mut reader, Poll::Gone), Poll::Gone, "life {life}");
    }
    drop(reader);
    assert_eq!(room.leftovers(), Vec::<String>::new());
}

#[test]
fn a_slow_reader_loses_frames_and_is_told_how_many() {
    let room = Room::new("slow_reader");
    let mut world = falling_boxes(4);
    let mut publisher = Publisher::open(&world, &room.def("slow")).unwrap();
    let mut reader = common::attach(&room, "slow", std::slice::from_mut(&mut publisher));
    for _ in 0..100 {
        world.step(DT).unwrap();
        publisher.publish(&world);
    }
    let Poll::Frame { lost_frames, lost_records, .. } = reader.wait(Duration::from_secs(5)).unwrap() else { panic!("a frame") };
    assert_eq!((lost_frames, lost_records), (96, 0), "four frames wait for a reader, and 256 messages of records");
    assert_eq!(reader.scene().frame().step, 100);
    for _ in 0..600 {
        world.step(DT).unwrap();
        publisher.publish(&world);
    }
    let Poll::Frame { lost_records, .. } = reader.wait(Duration::from_secs(5)).unwrap() else { panic!("a frame") };
    assert!(lost_records > 0, "more than 256 messages were published");
    for body in world.bodies() {
        body_matches(&world, body, reader.scene().body(body.to_bits()).expect("healed within a cycle"));
    }
    assert!(reader.scene().is_complete());
}

#[test]
fn wrong_arguments_are_refused_by_name() {
    let room = Room::new("wrong_arguments");
    let world = falling_boxes(1);
    let refused = |def: PublisherDef| Publisher::open(&world, &def).unwrap_err().to_string();
    assert!(refused(PublisherDef { name: "a/b".into(), ..room.def("x") }).starts_with("name"));
    assert!(refused(PublisherDef { every: 0, ..room.def("x") }).starts_with("every"));
    assert!(refused(PublisherDef { layers: 1 << 20, ..room.def("x") }).starts_with("layers"));
    assert!(refused(PublisherDef { readers: 0, ..room.def("x") }).starts_with("readers"));
}
