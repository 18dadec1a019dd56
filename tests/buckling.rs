//! Links that are pressed together along their own line give way across it.

use longspan::glam::{Quat, Vec3};
use longspan::{
    BodyDef, BodyId, JointDef, JointId, JointKind, Mass, MassProperties, Pose, Shape, ShapeDef, SleepSettings, World, WorldDef,
};

const LINK: f32 = 0.3;

fn world() -> World {
    let sleep = SleepSettings { enabled: false, ..SleepSettings::default() };
    World::new(&WorldDef { gravity: Vec3::NEG_Y * 9.81, sleep, ..WorldDef::default() }).expect("a valid world")
}

/// A link of this mass (kg) whose length, along its own y axis, lies along x if it is level.
fn link(world: &mut World, at: Vec3, level: bool, mass: f32, damping: f32) -> BodyId {
    let turn = if level { Quat::from_rotation_z(std::f32::consts::FRAC_PI_2) } else { Quat::IDENTITY };
    let across = mass * LINK * LINK / 12.0;
    let properties = MassProperties::new(mass, Vec3::new(across, 0.05 * across, across));
    let mut def = BodyDef::dynamic(Pose::at(at.as_dvec3()).rotated(turn)).with_mass(Mass::Properties(properties));
    (def.linear_damping, def.angular_damping) = (damping, damping);
    world.create_body(&def).expect("a valid body")
}

fn hold(world: &mut World, [a, b]: [BodyId; 2], on_a: Vec3, on_b: Vec3) -> JointId {
    world.create_joint(&JointDef::new(JointKind::SPHERICAL, a, b).at(on_a, on_b)).expect("a valid joint")
}

/// How far a rope of this length sags between two points at the same height (m).
fn sag(length: f64, span: f64) -> f64 {
    let (mut low, mut high) = (1.0e-2, 1.0e3);
    for _ in 0..200 {
        let a = 0.5 * (low + high);
        if 2.0 * a * (0.5 * span / a).sinh() > length { low = a } else { high = a }
    }
    low * ((0.5 * span / low).cosh() - 1.0)
}

#[test]
fn a_straight_row_between_points_that_are_too_close_sags_into_its_catenary() {
    for (count, span, mass) in [(16, 4.0, 0.5), (16, 4.7, 0.5), (16, 4.0, 50.0), (40, 10.0, 0.5), (4, 1.0, 0.5), (2, 0.5, 5.0)] {
        for rate in [30.0, 60.0, 240.0] {
            if rate > 60.0 && count > 16 {
                continue;
            }
            let mut world = world();
            let (top, bottom) = (Vec3::Y * 0.5 * LINK, Vec3::Y * -0.5 * LINK);
            let (mut before, mut joints, mut links) = (BodyId::NULL, Vec::new(), Vec::new());
            for number in 0..count {
                let at = Vec3::X * (span / count as f32 * (number as f32 + 0.5));
                let own = link(&mut world, at, true, mass, 2.0);
                joints.push(hold(&mut world, [before, own], if number > 0 { bottom } else { Vec3::ZERO }, top));
                links.push(own);
                before = own;
            }
            joints.push(hold(&mut world, [before, BodyId::NULL], bottom, Vec3::X * span));
            for _ in 0..(6.0 * rate) as u32 {
                world.step(1.0 / rate).expect("a valid step");
            }
            let state = |&joint: &JointId| world.joint_state(joint).expect("it stays");
            let gap = joints.iter().map(|joint| state(joint).gap).fold(0.0, f32::max);
            let force = joints.iter().map(|joint| state(joint).force.length()).fold(0.0, f32::max);
            let height = |&body: &BodyId| world.pose(body).expect("it stays").position.y;
            let lowest = links.iter().map(height).fold(f64::INFINITY, f64::min);
            let what = format!("{count} links of {mass} kg over {span} m at {rate}/s");
            let expected = -sag(f64::from(LINK) * f64::from(count), f64::from(span));
            assert!(gap < 1.0e-3, "{what}: {gap} m open");
            assert!(force < 2.0 * count as f32 * mass * 9.81, "{what}: {force} N at rest");
            // The middles of a few long links hang higher than the rope that they stand for.
            let bound = if count < 16 { 0.5 } else { 0.05 };
            assert!((lowest - expected).abs() < bound * -expected, "{what}: hangs down to {lowest} m, as a rope {expected} m");
        }
    }
}

#[test]
fn a_row_of_large_links_sags_as_soon_at_any_rate() {
    const LINK: f32 = 5.0;
    const COUNT: usize = 20;
    let (span, mass, end) = (0.83 * LINK * COUNT as f32, 100.0, Vec3::X * (0.5 * LINK));
    for rate in [30.0, 60.0, 120.0, 240.0] {
        let mut world = world();
        let (mut before, mut links) = (BodyId::NULL, Vec::new());
        for number in 0..COUNT {
            let across = mass * LINK * LINK / 12.0;
            let properties = MassProperties::new(mass, Vec3::new(0.05 * across, across, across));
            let place = f64::from(span) / COUNT as f64 * (number as f64 + 0.5);
            let mut def = BodyDef::dynamic(Pose::at_xyz(place, 0.0, 0.0)).with_mass(Mass::Properties(properties));
            (def.linear_damping, def.angular_damping) = (0.5, 0.5);
            let own = world.create_body(&def).expect("a valid body");
            hold(&mut world, [before, own], if number > 0 { end } else { Vec3::ZERO }, -end);
            links.push(own);
            before = own;
        }
        hold(&mut world, [before, BodyId::NULL], end, Vec3::X * span);
        let length = LINK * COUNT as f32;
        let (bottom, unit) = (-sag(f64::from(length), f64::from(span)), (length / 9.81).sqrt());
        let lowest = |world: &World| links.iter().map(|&link| world.pose(link).expect("it stays").position.y).fold(0.0, f64::min);
        let mut steps = 0;
        while lowest(&world) > 0.8 * bottom && steps < (4.0 * unit * rate) as u32 {
            world.step(1.0 / rate).expect("a valid step");
            steps += 1;
        }
        // 1.00 at each of these rates.
        let time = steps as f32 / rate / unit;
        assert!((time - 1.0).abs() < 0.1, "{rate}/s: hangs after {time} √(l/g), bound 0.9 to 1.1");
    }
}

#[test]
fn a_straight_chain_is_picked_up_along_its_own_line() {
    for (rate, load) in [(30.0, 100.0), (60.0, 1.0e4), (240.0, 100.0)] {
        let mut world = world();
        let (top, bottom) = (Vec3::Y * 0.5 * LINK, Vec3::Y * -0.5 * LINK);
        let mut before = BodyId::NULL;
        let mut links = Vec::new();
        for number in 0..20 {
            let at = Vec3::NEG_Y * LINK * (number as f32 + 0.5);
            let own = link(&mut world, at, false, 1.0, 0.5);
            hold(&mut world, [before, own], if number > 0 { bottom } else { Vec3::ZERO }, top);
            links.push(own);
            before = own;
        }
        let place = Vec3::NEG_Y * (20.0 * LINK + 0.5);
        let cube = ShapeDef::new(Shape::cuboid(Vec3::splat(0.5)).expect("a valid shape"));
        let def = BodyDef::dynamic(Pose::at(place.as_dvec3())).with_shape(cube).with_mass(Mass::Total(load));
        let weight = world.create_body(&def).expect("a valid body");
        hold(&mut world, [before, weight], bottom, Vec3::Y * 0.5);
        let middle = Vec3::NEG_Y * 10.0 * LINK;
        let hook = world.create_body(&BodyDef::kinematic(Pose::at(middle.as_dvec3()))).expect("a valid body");
        hold(&mut world, [hook, links[10]], Vec3::ZERO, top);
        for _ in 0..(2.0 * rate) as u32 {
            world.set_linear_velocity(hook, Vec3::Y * 0.5).expect("a kinematic body");
            world.step(1.0 / rate).expect("a valid step");
        }
        world.set_linear_velocity(hook, Vec3::ZERO).expect("a kinematic body");
        for _ in 0..(2.0 * rate) as u32 {
            world.step(1.0 / rate).expect("a valid step");
        }
        let risen = world.pose(weight).expect("it stays").position.y - f64::from(place.y);
        let gap = world.report().residuals.joint_gap;
        assert!((risen - 1.0).abs() < 0.02, "{load} kg at {rate}/s: risen by {risen} m with a hook that rose by 1 m");
        assert!(gap < 2.0e-3, "{load} kg at {rate}/s: joints {gap} m open");
    }
}

#[test]
fn a_hook_that_comes_down_on_its_straight_chain_leaves_the_load_standing() {
    for (count, load, rate, sideways) in [
        (20, 1000.0, 60.0, 0.05),
        (20, 1000.0, 60.0, 0.0),
        (10, 100.0, 30.0, 0.0),
        (10, 1000.0, 240.0, 0.05),
        (3, 50.0, 60.0, 0.2),
    ] {
        let mut world = world();
        let floor = ShapeDef::new(Shape::cuboid(Vec3::new(20.0, 0.5, 20.0)).expect("a valid shape"));
        world.create_body(&BodyDef::fixed(Pose::at_xyz(0.0, -0.5, 0.0)).with_shape(floor)).expect("a valid body");
        let (top, bottom) = (Vec3::Y * 0.5 * LINK, Vec3::Y * -0.5 * LINK);
        let cube = ShapeDef::new(Shape::cuboid(Vec3::splat(0.5)).expect("a valid shape"));
        let def = BodyDef::dynamic(Pose::at_xyz(0.0, 0.5, 0.0)).with_shape(cube).with_mass(Mass::Total(load));
        let load_body = world.create_body(&def).expect("a valid body");
        let mut before = load_body;
        for number in 0..count {
            let at = Vec3::Y * (1.0 + LINK * (number as f32 + 0.5));
            let own = link(&mut world, at, false, 1.0, 0.0);
            hold(&mut world, [before, own], if number > 0 { top } else { Vec3::Y * 0.5 }, bottom);
            before = own;
        }
        let place = Pose::at_xyz(0.0, 1.0 + f64::from(LINK) * f64::from(count), 0.0);
        let hook = world.create_body(&BodyDef::kinematic(place)).expect("a valid body");
        hold(&mut world, [before, hook], top, Vec3::ZERO);
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        for step in 0..(4.0 * rate) as u32 {
            let time = step as f32 / rate;
            let lowers = (0.5..1.5).contains(&time);
            let speed = if lowers { Vec3::new(sideways, -0.5, 0.0) } else { Vec3::ZERO };
            world.set_linear_velocity(hook, speed).expect("a kinematic body");
            world.step(1.0 / rate).expect("a valid step");
            let height = world.pose(load_body).expect("it stays").position.y;
            (lowest, highest) = (lowest.min(height), highest.max(height));
        }
        let what = format!("{load} kg under {count} links at {rate}/s, hook sideways at {sideways} m/s");
        assert!(lowest > 0.495 && highest < 0.505, "{what}: the load was between {lowest} and {highest} m, it stands at 0.5 m");
    }
}
