//! Every scene by name.

use longspan::glam::DVec3;

use crate::params::{Params, SceneError};
use crate::scene::Scene;
use crate::units::Units;
use crate::{
    arm, branching, bridge, bridge_car, cable_car, cantilever, chain, closed_form, crossbow, crowd, drums, footbridge, fracture,
    free, friction, gallery, hinge_loop, hoists, idle, impact, machines, masonry, net, pile, ragdoll, stack, stress, tensegrity,
    track, vase, violent,
};

/// A scene that can be built.
pub struct Entry {
    /// Its name.
    pub name: &'static str,
    /// What it is, in one line.
    pub summary: &'static str,
    build: fn(&mut Params) -> Result<Scene, SceneError>,
}

/// Every scene.
pub const CATALOGUE: &[Entry] = &[
    entry("hanging_chain", "a heavy box at the end of a chain of light links", chain::hanging_chain),
    entry("swinging_weight", "the same chain let go horizontally, against its exact motion", chain::swinging_weight),
    entry("lifted_chain", "a chain of light links picked up at one of its joints", chain::lifted_chain),
    entry("rope_bridge", "a bridge of planks on ropes, with rails, at rest or walked over", bridge::rope_bridge),
    entry("footbridge", "planks hinged straight between piers, and a load set down on them", footbridge::footbridge),
    entry("cable_car", "a cable over two drums with two or three cars", cable_car::cable_car),
    entry("hinge_loop", "a free closed loop of parallel hinges, struck sideways", hinge_loop::hinge_loop),
    entry("mobile", "bars on bars with heavy boxes at every end", branching::mobile),
    entry("branched_tree", "a random tree of rods with heavy boxes at its ends, let fall", branching::branched_tree),
    entry("loop_graph", "a random tree of rods closed to loops, with heavy boxes, let fall", branching::loop_graph),
    entry("cantilever", "a chain with limited swing and a heavy box, let go from the level", cantilever::cantilever),
    entry("arm", "an arm of seven servo hinges with a payload", arm::arm),
    entry("crane", "a slewing jib with a load on a rope", machines::crane),
    entry("excavator", "an arm of servo hinges that lifts a stack on a fork", machines::excavator),
    entry("elevator", "a platform on a motor with a loose crate on it", hoists::elevator),
    entry("gripper", "two fingers that hold a cube by friction as it is shaken", hoists::gripper),
    entry("scissor_lift", "a scissor lift of light arms under a crate", hoists::scissor_lift),
    entry("bollard", "a tied rope over a fixed bollard, with a load", drums::bollard),
    entry("capstan", "a rope over a fixed post with unequal loads, held by friction", drums::capstan),
    entry("winch", "a drum that winds up a rope with a load", drums::winch),
    entry("pulley", "a rope over a drum on a hinge, with unequal loads", drums::pulley),
    entry("bridge_car", "a car that drives over a bridge of tied planks", bridge_car::bridge_car),
    entry("tensegrity", "a tower of struts that cables hold apart, under a load", tensegrity::tensegrity),
    entry("net", "a net of ropes that hangs by its corners, and boxes dropped into it", net::net),
    entry("ragdoll_pile", "ragdolls dropped into a pit", ragdoll::ragdoll_pile),
    entry("track", "a track of 132 links driven over a step by its sprockets", track::track),
    entry("crossbow", "a bow of limited hinges, modelled bent, with its arrow", crossbow::crossbow),
    entry("vase", "a vase of welded pieces dropped on its edge", vase::vase),
    entry("brick_wall", "a wall of Voronoi bricks hit by a ball", fracture::brick_wall),
    entry("breaking_beam", "a cantilever of fixed joints under growing gravity", fracture::breaking_beam),
    entry("heavy_on_light", "nine boxes of 100 kg carry a tenth that is far heavier", stack::heavy_on_light),
    entry("tower", "a ring-shaped tower of stone blocks stands, then is hit", stack::tower),
    entry("column", "equal boxes on one another for a minute", stack::column),
    entry("pile", "boxes and balls dropped into a pit", pile::pile),
    entry("joint_grid", "a sheet of balls in joints with their neighbours, held at its top", crowd::joint_grid),
    entry("large_pyramid", "one flat pyramid of boxes", crowd::large_pyramid),
    entry("many_pyramids", "small pyramids side by side", crowd::many_pyramids),
    entry("ragdoll_rain", "ragdolls that fall onto open ground", crowd::ragdoll_rain),
    entry("arch", "a semicircular arch of wedges without mortar", masonry::arch),
    entry("lamp_arch", "an arch of wedges with a lamp on a chain at its keystone", masonry::lamp_arch),
    entry("support_gallery", "the stacks of the paper's figures, and whether each stone is supported", gallery::support_gallery),
    entry("wedge", "a wedge hung between two blocks", masonry::wedge),
    entry("card_house", "a house of cards", masonry::card_house),
    entry("free_gyro", "a free body spinning about its middle axis", free::free_gyro),
    entry("free_cluster", "eight bodies in joints of every kind, tumbling freely", free::free_cluster),
    entry("damping", "a thrown and spun ball under damping alone", free::damping),
    entry("box_on_plane", "a box at rest and the force that carries it", closed_form::box_on_plane),
    entry("slope", "a box on a slope that rests or slides", closed_form::slope),
    entry("bounce", "a ball and the height of its first rebound", closed_form::bounce),
    entry("pendulum", "a pendulum and its period", closed_form::pendulum),
    entry("projectile", "a ball in free flight", closed_form::projectile),
    entry("spring", "a weight on a spring and damper", closed_form::spring),
    entry("hinge_motor", "a wheel driven by a motor of bounded torque", closed_form::hinge_motor),
    entry("hinge_servo", "a bar held at an angle by a position motor", closed_form::hinge_servo),
    entry("stiff_hinge", "a flywheel and a pendulum in hinges that rub", closed_form::stiff_hinge),
    entry("hinge_limit", "a bar that falls onto the stop of its hinge", closed_form::hinge_limit),
    entry("platform", "a box carried along by a platform", friction::platform),
    entry("rolling", "a ball brought to rest by rolling friction", friction::rolling),
    entry("spinning", "a ball spinning on the spot, stopped by spinning friction", friction::spinning),
    entry("locked_axes", "a box with locked axes, struck off centre", impact::locked_axes),
    entry("bullet", "a small fast ball against a thin wall", impact::bullet),
    entry("half_sunk", "a box created half inside the floor", impact::half_sunk),
    entry("resting", "boxes, balls and capsules that lie still, and a hung weight", idle::resting),
    entry("far_origin", "another scene, far from the origin", far_origin),
    entry("idle", "bodies asleep, scenes without joints, scenes without anything static", idle::idle),
    entry("violent", "thrown chains, mobiles, trees and joint graphs, violated limits, deep overlap", violent::violent),
    entry("stress", "one kind of abuse and what is promised for it", stress::stress),
];

const fn entry(name: &'static str, summary: &'static str, build: fn(&mut Params) -> Result<Scene, SceneError>) -> Entry {
    Entry { name, summary, build }
}

/// Builds a scene from its name and the keys that the user set.
///
/// # Errors
/// An unknown name or key, with those that are valid; a value out of range; a feature that this version does not have.
pub fn build(name: &str, given: &[(String, String)]) -> Result<Scene, SceneError> {
    let entry = find(name)?;
    let mut params = Params::new(given);
    let mut scene = (entry.build)(&mut params)?;
    scene.units = Units::of(&mut params)?;
    params.check_all_used(entry.name)?;
    scene.name = entry.name;
    // What a host knows of its scene it tells.
    scene.world.body_capacity = scene.bodies.len() as u32;
    scene.world.joint_capacity = scene.joints.len() as u32;
    let facts = std::mem::take(&mut scene.params);
    scene.params = params.into_asked().into_iter().chain(facts).collect();
    Ok(scene)
}

fn find(name: &str) -> Result<&'static Entry, SceneError> {
    CATALOGUE.iter().find(|entry| entry.name == name).ok_or_else(|| {
        let valid = CATALOGUE.iter().map(|entry| entry.name).collect::<Vec<_>>().join(", ");
        SceneError::UnknownScene { name: name.into(), valid }
    })
}

fn far_origin(params: &mut Params) -> Result<Scene, SceneError> {
    let offset = params.number("offset_km", 10.0, 0.0..=1.0e5)?;
    let of = params.word("of", &["hanging_chain", "pile", "tower", "projectile"])?;
    let mut scene = (find(of)?.build)(params)?;
    // Along all axes, so that no coordinate is spared.
    scene.origin = DVec3::ONE.normalize() * offset * 1000.0;
    Ok(scene)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(key: &str, value: &str) -> Vec<(String, String)> {
        vec![(key.into(), value.into())]
    }

    fn problem(name: &str, given: &[(String, String)]) -> String {
        build(name, given).err().map(|error| error.to_string()).unwrap_or_default()
    }

    #[test]
    fn every_scene_builds_with_its_defaults() {
        for entry in CATALOGUE {
            let scene = build(entry.name, &[]).unwrap_or_else(|error| panic!("{}: {error}", entry.name));
            assert!(!scene.bodies.is_empty() && !scene.metrics.is_empty(), "{} is empty", entry.name);
        }
        for row in stress::ROWS {
            build("stress", &set("row", row.name)).unwrap_or_else(|error| panic!("{}: {error}", row.name));
        }
    }

    #[test]
    fn what_is_unknown_is_refused_with_what_is_valid() {
        let no_scene = problem("hanging_chian", &[]);
        assert!(no_scene.contains("hanging_chain") && no_scene.contains("stress"), "{no_scene}");
        let no_key = problem("hanging_chain", &set("lenght", "3"));
        assert!(no_key.contains("lenght") && no_key.contains("n, ratio") && no_key.contains("substeps"), "{no_key}");
        let bad_value = problem("hanging_chain", &set("n", "0"));
        assert!(bad_value.contains("n=0") && bad_value.contains("from 1"), "{bad_value}");
        let bad_word = problem("violent", &set("what", "peace"));
        assert!(bad_word.contains("graph"), "{bad_word}");
    }

    #[test]
    fn every_solver_and_kind_of_constraint_can_be_chosen() {
        assert_eq!(problem("pile", &set("union", "off")), "");
        assert_eq!(problem("pile", &set("solver", "direct")), "");
        assert_eq!(problem("pile", &set("long_range", "off")), "");
        assert_eq!(problem("pile", &set("solver", "gs")), "");
    }

    #[test]
    fn common_keys_reach_the_world() {
        let target = [set("error_target", "0.5"), set("most_substeps", "9")].concat();
        let given = [set("substeps", "7"), set("iterations", "3"), set("seconds", "1"), target].concat();
        let scene = build("pile", &given).unwrap();
        assert_eq!((scene.world.substeps, scene.world.iterations, scene.steps), (7, 3, 60));
        assert_eq!((scene.world.articulations.error_target, scene.world.articulations.most_substeps), (0.5, 9));
    }
}
