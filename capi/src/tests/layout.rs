//! What C sees is what Rust sees: sizes and offsets of every struct, as the compiler of C says, and as version 1 promises.

use std::fmt::Write as _;
use std::mem::offset_of;
use std::path::Path;
use std::process::Command;

use longspan_stream_schema::*;

use crate::body_def::*;
use crate::callbacks::*;
use crate::cast::*;
use crate::chain::*;
use crate::distance::*;
use crate::draw::*;
use crate::events::*;
use crate::fracture::*;
use crate::handle::*;
use crate::joint::*;
use crate::joint_def::*;
use crate::long_range::*;
use crate::math::*;
use crate::memory::*;
use crate::motor_def::*;
use crate::query_def::*;
use crate::record::*;
use crate::report::*;
use crate::shape_def::*;
use crate::stream_def::*;
use crate::strength::*;
use crate::support::*;
use crate::union::*;
use crate::version::*;
use crate::world_def::*;

/// Size, alignment and offsets of one struct; does not compile if a field is left out.
struct Layout {
    name: &'static str,
    size: usize,
    align: usize,
    fields: Vec<(&'static str, usize, usize)>,
}

macro_rules! layouts {
    ($($name:ident { $($field:ident),* })*) => {
        vec![$({
            fn size_of_field<T>(_: impl FnOnce(&$name) -> &T) -> usize {
                size_of::<T>()
            }
            let _complete = |value: $name| {
                let $name { $($field: _),* } = value;
            };
            Layout {
                name: stringify!($name),
                size: size_of::<$name>(),
                align: align_of::<$name>(),
                fields: vec![$((
                    stringify!($field),
                    offset_of!($name, $field),
                    size_of_field(|value| &value.$field),
                )),*],
            }
        }),*]
    };
}

fn layouts() -> Vec<Layout> {
    [of_definitions(), of_worlds(), of_streams()].into_iter().flatten().collect()
}

/// What bodies and joints are made of.
fn of_definitions() -> Vec<Layout> {
    layouts! {
        LsVersion { major, minor, patch, abi }
        LsWorld { id }
        LsBody { id }
        LsShape { id }
        LsJoint { id }
        LsPose { position, rotation }
        LsUnion {
            lead, members, joints, center, linear_velocity, angular_velocity, mass, anchored, distance_residual, angle_residual
        }
        LsSupport { verdict, margin }
        LsSupportChange { body, user_word, supported, reserved }
        LsMaterial { friction, restitution, rolling_friction, spinning_friction, friction_rule, restitution_rule }
        LsCollisionFilter { member_of, collides_with }
        LsShapeDef {
            struct_size, kind, half_extents, half_height, radius, normal, points, point_count, triangles, triangle_count,
            heights, height_count, rows, columns, size_x, size_z, parts, part_count, local_position, local_rotation, density,
            material, filter, user_word, sensor, reserved
        }
        LsMassProperties { mass, center_of_mass, principal_inertia, inertia_frame }
        LsMass { kind, properties }
        LsBodyDef {
            struct_size, kind, pose, linear_velocity, angular_velocity, mass, linear_damping, angular_damping, gravity_scale,
            locked_axes, can_sleep, fast, user_word, shapes, shape_count
        }
        LsSoftness { compliance, damping }
        LsLimits { min, max }
        LsMotor { mode, target, softness, max_force }
        LsSphericalMotor { mode, target_velocity, target_rotation, softness, max_torque }
        LsAxis { limits, motor }
        LsJointDef {
            struct_size, kind, body_a, body_b, frame_a, frame_b, linear, angular, limit, limits, swing_limit, spring_length,
            has_spring, break_force, break_torque, collide_connected, user_word, motor, spherical_motor, linear_axes,
            angular_axes, strength, long_range, reserved, solver, reserved_too, friction, axis_friction, restitution,
            motor_drive, axis_drives
        }
    }
}

/// What a world is made of, and what it tells.
fn of_worlds() -> Vec<Layout> {
    layouts! {
        LsStrength {
            tension, compression, shear, bending, torsion, window, wears, damage_from, damage_time, damage_half_life
        }
        LsBondMaterial { tension, compression, shear, window, wears, damage_from, damage_time, damage_half_life }
        LsFractureSettings { by_load, most }
        LsJointBreak {
            joint, user_word, body_a, body_b, point, step, force, torque, share, limit, cause, reserved
        }
        LsSplit {
            first_body, center, step, body_count, mass, linear_velocity, anchored, first_piece, piece_count
        }
        LsPiece {
            first_body, center, first_member, body_count, mass, linear_velocity, angular_velocity, anchored, cut_loose,
            reserved
        }
        LsJointStress { force, torque, share, limit, damage }
        LsJointState { position, velocity, force, torque, gap, effort }
        LsJointAxisState { position, velocity, effort, motor }
        LsDrive { target_velocity, max_speed, side, reserved }
        LsBoundKindDef { enabled, upper, lower }
        LsLongRangeDef { struct_size, enabled, attachment, hierarchy, levels, reserved, soft, unions, plane_position, plane_axis }
        LsSoftBound { share, softness }
        LsChainState { link_count, rest_length, length, stretch, greatest_tension }
        LsChainLink { body, joints, length, tension }
        LsBound { near_joint, far_joint, points, kind, level, distance, upper, lower, tension, active, reserved }
        LsSleepSettings { enabled, linear_speed, angular_speed, time }
        LsWorldDef {
            struct_size, gravity, substeps, iterations, solver, threads, sleep, restitution_threshold, body_capacity,
            joint_capacity, reserved, hold, support, hit_threshold, fracture, support_by_thrust
        }
        LsStepReport {
            step, time, bodies_awake, bodies_asleep, islands, pairs, pairs_updated, pairs_reused, manifolds, contact_points,
            joints, batches, colors, moved, joint_gap, penetration, broad_phase_time, narrow_phase_time, island_time,
            solve_time, finish_time, total_time, unions, union_members, joint_angle, bounds_wrapped, bounds_derived, bounds,
            bounds_active, bounds_skipped, planes, long_range_time
        }
        LsMoved { body, user_word, pose, linear_velocity, angular_velocity, fell_asleep, woke }
        LsContactPair { shape_a, shape_b, body_a, body_b }
        LsContactPoint { position, separation, normal_force }
        LsContact { pair, normal, friction_force, point_count, reserved, points }
        LsJointOverload { joint, user_word, force, torque }
        LsIsland { body, bodies, joints, plan, given_up }
        LsHit { pair, point, normal, approach_speed, impulse, reserved }
        LsJointStop { joint, user_word, axis, upper }
        LsCallbacks {
            struct_size, reserved, user, contact_began, contact_ended, hits, sensor_began, sensor_ended, joint_stops, moved
        }
        LsDraw {
            struct_size, layers, line, triangle, text, user, force_scale, velocity_scale, mark_size, only_near, center, radius
        }
        LsReplay {
            calls, refused, steps, diverged, cut_short, call, step, recorded, found, in_state, reserved, method
        }
        LsAllocator { allocate, release, user }
        LsMemory { bytes, peak_bytes, blocks, allocations }
        LsQueryFilter { struct_size, member_of, collides_with, kinds, ignored, ignored_count, accept, user }
        LsRay { origin, direction, length }
        LsRayHit { shape, body, point, normal, distance }
        LsNearestPoint { shape, body, point, distance, reserved }
        LsCastDef { struct_size, ignore_overlapped, shape, pose, path, turn, reserved }
        LsCastHit { shape, body, point, normal, part, distance, fraction, depth, triangle, reserved }
        LsShapeDistance {
            shape_a, shape_b, point_a, point_b, distance, normal, part_a, part_b, triangle_a, triangle_b, reserved
        }
    }
}

/// What streams are made of, and what they carry.
fn of_streams() -> Vec<Layout> {
    layouts! {
        LsStream { id }
        LsStreamReader { id }
        LsStreamDef { struct_size, every, name, domain, layers, readers, body_capacity, state_hash }
        LsStreamStats { frames, records, dropped, bytes, seconds }
        LsStreamReaderDef { struct_size, reserved, name, domain, recording }
        LsStreamPoll { status, is_first, is_complete, reserved, lost_frames, lost_records, frame }
        LsStreamSource { name, process, number, schema, reserved }
        LsStreamRecording { first_step, last_step, frames, offset, end, reserved }
        LsStreamHeader {
            magic, schema, header_size, layout_hash, length, session, sequence, step, time, state_hash, content_hash, dropped,
            channel, section_count, body_count, shape_count, joint_count, flags, cycle, clock
        }
        LsStreamSection { kind, stride, count, flags, length, reserved }
        LsStreamMotion {
            body, user_word, union_id, position, rotation, linear_velocity, angular_velocity, flags, reserved
        }
        LsStreamContactPoint { position, separation, normal_force }
        LsStreamContact { body_a, body_b, normal, point_count, friction_force, reserved, points }
        LsStreamJointLoad { joint, force, torque, share, gap }
        LsStreamBound {
            near_joint, far_joint, near_point, far_point, distance, upper, lower, tension, kind, level, active, reserved
        }
        LsStreamPlane { chain, point, normal, radius }
        LsStreamBody {
            body, user_word, union_id, step, position, rotation, linear_velocity, angular_velocity, flags, kind, mass, support,
            support_margin, support_load
        }
        LsStreamShape {
            shape, body, user_word, kind, part, part_count, reserved, position, rotation, size, friction, restitution
        }
        LsStreamJoint {
            joint, user_word, body_a, body_b, position_a, position_b, rotation_a, rotation_b, kind, flags, break_force,
            break_torque
        }
        LsStreamGone { id, step }
        LsStreamGeometry {
            shape, part, vertex_total, triangle_total, first_vertex, vertex_count, first_triangle, triangle_count, reserved
        }
        LsStreamWorld { name, process, gravity, substeps, iterations, support, layers, every }
        LsStreamEvent { step, a, b, user_word, kind, reserved, values }
    }
}

#[test]
fn no_struct_has_hidden_padding() {
    for Layout { name, size, fields, .. } in layouts() {
        let mut end = 0;
        for (field, offset, field_size) in fields {
            assert_eq!(offset, end, "{name} has {} bytes of padding before {field}", offset - end);
            end = offset + field_size;
        }
        assert_eq!(size, end, "{name} has {} bytes of padding at its end", size - end);
    }
}

#[test]
fn structs_have_the_sizes_that_version_1_promises() {
    let promised = [
        ("LsWorld", 8),
        ("LsPose", 40),
        ("LsMaterial", 24),
        ("LsMass", 48),
        ("LsShapeDef", 200),
        ("LsBodyDef", 168),
        ("LsMotor", 20),
        ("LsSphericalMotor", 44),
        ("LsAxis", 28),
        ("LsJointDef", 600),
        ("LsStrength", 40),
        ("LsBondMaterial", 32),
        ("LsFractureSettings", 8),
        ("LsJointBreak", 104),
        ("LsSplit", 72),
        ("LsPiece", 80),
        ("LsJointStress", 36),
        ("LsJointState", 40),
        ("LsJointAxisState", 16),
        ("LsDrive", 16),
        ("LsBoundKindDef", 20),
        ("LsLongRangeDef", 72),
        ("LsBound", 96),
        ("LsSoftBound", 12),
        ("LsWorldDef", 88),
        ("LsStepReport", 136),
        ("LsChainState", 20),
        ("LsChainLink", 32),
        ("LsMoved", 88),
        ("LsContactPair", 32),
        ("LsContact", 192),
        ("LsJointOverload", 24),
        ("LsIsland", 24),
        ("LsHit", 80),
        ("LsJointStop", 24),
        ("LsCallbacks", 72),
        ("LsDraw", 88),
        ("LsReplay", 112),
        ("LsAllocator", 24),
        ("LsMemory", 32),
        ("LsSupport", 8),
        ("LsSupportChange", 24),
        ("LsQueryFilter", 48),
        ("LsRay", 40),
        ("LsRayHit", 56),
        ("LsNearestPoint", 48),
        ("LsCastDef", 96),
        ("LsCastHit", 88),
        ("LsShapeDistance", 104),
        ("LsStreamHeader", 128),
        ("LsStreamSection", 32),
        ("LsStreamMotion", 96),
        ("LsStreamBody", 120),
        ("LsStreamShape", 88),
        ("LsStreamJoint", 128),
        ("LsStreamEvent", 56),
        ("LsStreamDef", 40),
        ("LsStreamPoll", 160),
    ];
    for (name, size) in promised {
        let layout = layouts().into_iter().find(|layout| layout.name == name).expect("the list of layouts is complete");
        assert_eq!(layout.size, size, "size of {name} in bytes");
    }
}

#[test]
fn the_compiler_of_c_agrees_on_every_offset() {
    let mut source = String::from("#include <stddef.h>\n#include \"longspan/longspan.h\"\n");
    let mut checks = 0;
    let mut check = |expression: String, value: usize| {
        checks += 1;
        let _ = writeln!(source, "typedef char check_{checks}[({expression}) == {value} ? 1 : -1];");
    };
    for Layout { name, size, align, fields } in layouts() {
        check(format!("sizeof({name})"), size);
        check(format!("offsetof(struct {{ char c; {name} s; }}, s)"), align);
        for (field, offset, field_size) in fields {
            check(format!("offsetof({name}, {field})"), offset);
            check(format!("sizeof((({name} *)0)->{field})"), field_size);
        }
    }
    let folder = std::env::temp_dir().join(format!("longspan-layout-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder can be made");
    let file = folder.join("layout.c");
    std::fs::write(&file, source).expect("a temporary file can be written");
    let include = Path::new(env!("CARGO_MANIFEST_DIR")).join("../include");
    let output = Command::new("cc").args(["-std=c99", "-fsyntax-only", "-I"]).arg(include).arg(&file).output();
    let output = output.expect("a C compiler is there");
    std::fs::remove_dir_all(&folder).expect("the temporary folder can be removed");
    assert!(checks > 300, "only {checks} checks");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
