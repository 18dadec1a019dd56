//! What a stream says of unions, fracture and planes is what the world says.

mod common;

use std::time::Duration;

use common::{Room, scene};
use longspan::{Handle, World};
use longspan_scenes::DT;
use longspan_stream::schema::*;
use longspan_stream::{Poll, Publisher, PublisherDef, Reader, Scene};

/// A vase that breaks when it lands, close above the ground.
const VASE: (&str, &[(&str, &str)]) = ("vase", &[("break", "1e5"), ("pieces", "40")]);

fn publish(world: &mut World, publisher: &mut Publisher) {
    world.step(DT).unwrap();
    publisher.publish(world);
}

fn unions_match(world: &World, seen: &Scene) {
    for body in world.bodies() {
        let lead = world.union_of(body).unwrap().map_or(0, |union| union.lead.to_bits());
        let told = seen.body(body.to_bits()).expect("every body is told of").union_id;
        assert_eq!(told, lead, "union of {body:?} after step {}", world.step_count());
    }
}

/// A joint that broke: step, joint, where.
type Broken = (u64, u64, [f64; 3]);
/// A piece: step, union that it is of, its first body, where.
type Piece = (u64, u64, u64, [f64; 3]);
type Fracture = (Vec<Broken>, Vec<Piece>);

/// What a world's lists of the last step say.
fn breaks_and_pieces(world: &World) -> Fracture {
    let broken = world.broken().iter().map(|b| (b.step, b.joint.to_bits(), b.point.to_array()));
    let pieces = world.splits().iter().flat_map(|split| {
        let pieces = &world.pieces()[split.pieces.0 as usize..split.pieces.1 as usize];
        pieces.iter().map(|p| (split.step, split.first_body.to_bits(), p.first_body.to_bits(), p.center.to_array()))
    });
    (broken.collect(), pieces.collect())
}

fn told_of_fracture(scene: &Scene) -> Fracture {
    let broken: Vec<_> = scene.breaks().iter().map(|b| (b.step, b.joint, b.point)).collect();
    let pieces: Vec<_> = scene.pieces().iter().map(|p| (p.step, p.of_body, p.first_body, p.center)).collect();
    let events = |kind: u32| scene.events().iter().filter(move |event| event.kind == kind);
    let of_breaks = events(LS_STREAM_EVENT_BROKEN).map(|event| (event.step, event.a));
    assert!(of_breaks.eq(broken.iter().map(|b| (b.0, b.1))), "each break is an event too");
    let of_pieces = events(LS_STREAM_EVENT_SPLIT).map(|event| (event.step, event.a, event.b));
    assert!(of_pieces.eq(pieces.iter().map(|p| (p.0, p.1, p.2))), "each piece is an event too");
    (broken, pieces)
}

#[test]
fn every_break_and_every_piece_is_told_and_unions_are_those_of_the_world() {
    let room = Room::new("breaks");
    let mut engine = scene(VASE.0, VASE.1);
    let world = engine.world_mut();
    let def = PublisherDef { layers: LS_STREAM_LAYER_ALL, ..room.def("vase") };
    let mut publisher = Publisher::open(world, &def).unwrap();
    let mut reader = common::attach(&room, "vase", std::slice::from_mut(&mut publisher));
    let (mut breaks, mut pieces) = (0, 0);
    for _ in 0..150 {
        reader.forget_events();
        publish(world, &mut publisher);
        assert!(matches!(reader.wait(Duration::from_secs(5)).unwrap(), Poll::Frame { lost_frames: 0, lost_records: 0, .. }));
        let seen = reader.scene();
        assert_eq!(told_of_fracture(seen), breaks_and_pieces(world), "step {}", world.step_count());
        breaks += world.broken().len();
        pieces += world.pieces().len();
        unions_match(world, seen);
        assert_eq!(seen.joints().len(), world.joint_count(), "a joint that broke is gone");
        assert!(seen.joints().all(|joint| joint.flags & LS_STREAM_JOINT_BREAKABLE != 0));
        for piece in world.piece_bodies() {
            let flags = seen.body(piece.to_bits()).unwrap().flags;
            assert_ne!(flags & LS_STREAM_BODY_BROKEN, 0, "{piece:?} is of a piece");
        }
        for load in seen.joint_loads() {
            let joint = world.joints().find(|joint| joint.to_bits() == load.joint).expect("a joint of the world");
            let stress = world.joint_stress(joint).unwrap();
            assert_eq!(load.share, stress.share, "{joint:?}");
        }
    }
    assert!(breaks > 20 && pieces > 5, "the vase breaks: {breaks} joints, {pieces} pieces");
}

#[test]
fn readers_that_come_and_go_while_things_break_lose_no_record_and_end_up_knowing_the_same() {
    let room = Room::new("rejoin");
    let mut engine = scene(VASE.0, VASE.1);
    let world = engine.world_mut();
    let mut publisher = Publisher::open(world, &room.def("vase")).unwrap();
    let mut witness = common::attach(&room, "vase", std::slice::from_mut(&mut publisher));
    let mut expected = (Vec::new(), Vec::new());
    for life in 0..12 {
        let mut guest = Reader::attach(&room.domain, "vase").unwrap();
        assert_eq!(guest.poll().unwrap(), Poll::Nothing, "there, but not let in yet");
        publisher.serve();
        let mut known = (Vec::new(), Vec::new());
        for _ in 0..12 {
            publish(world, &mut publisher);
            let (breaks, pieces) = breaks_and_pieces(world);
            expected.0.extend(breaks);
            expected.1.extend(pieces);
            for (name, reader) in [("witness", &mut witness), ("guest", &mut guest)] {
                let poll = reader.wait(Duration::from_secs(5)).unwrap();
                assert!(matches!(poll, Poll::Frame { lost_records: 0, .. }), "{name} of life {life}: {poll:?}");
            }
            assert!(guest.scene().is_complete(), "its history holds the whole of so small a world");
            unions_match(world, guest.scene());
            assert_eq!(guest.scene().hash(), witness.scene().hash(), "life {life}, step {}", world.step_count());
            known = told_of_fracture(guest.scene());
        }
        assert_eq!(told_of_fracture(witness.scene()), expected, "life {life}: the witness was told all");
        let is_end = expected.0.ends_with(&known.0) && expected.1.ends_with(&known.1);
        assert!(is_end, "life {life}: the guest was told the last of it, in order and without a gap");
        assert!(known == expected || life > 2, "life {life}: and all of it while the history reaches back so far");
    }
    assert!(expected.0.len() > 20, "something broke meanwhile: {}", expected.0.len());
    assert_eq!(publisher.stats().dropped, 0);
}

#[test]
fn planes_of_hinge_chains_are_in_the_frames() {
    let room = Room::new("planes");
    let mut engine = scene("hinge_loop", &[]);
    let world = engine.world_mut();
    let def = PublisherDef { layers: LS_STREAM_LAYER_PLANES, ..room.def("loop") };
    let mut publisher = Publisher::open(world, &def).unwrap();
    let mut reader = common::attach(&room, "loop", std::slice::from_mut(&mut publisher));
    for _ in 0..20 {
        publish(world, &mut publisher);
        reader.wait(Duration::from_secs(5)).unwrap();
        let told: Vec<_> = reader.scene().planes().iter().map(|p| (p.chain, p.point, p.normal, p.radius)).collect();
        let real: Vec<_> =
            world.planes().map(|p| (p.joint.to_bits(), p.point.to_array(), p.normal.to_array(), p.radius)).collect();
        assert_eq!(told, real, "step {}", world.step_count());
        assert_eq!(told.len(), 1, "one loop");
    }
}
