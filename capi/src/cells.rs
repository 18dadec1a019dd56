//! Solids in pieces: Voronoi cells held together by joints that break.

use ls_core::glam::Vec3;
use ls_core::{Cells, ShapeDef};

use crate::access::edit_hosted;
use crate::body_def::LsBodyDef;
use crate::boundary::call;
use crate::handle::{LsBody, LsJoint, LsWorld};
use crate::pointer::{self, Buffer, OutArray, host, slice};
use crate::result::{Failure, LS_ERROR_OUT_OF_RANGE, LsResult, Outcome};
use crate::shape_def::LsShapeDef;
use crate::sized;
use crate::strength::LsBondMaterial;

/// Points spread evenly at random through a box or a convex hull, to cut it by; the same for the same seed on every machine.
///
/// @param shape  a box or convex hull
/// @param count  number of points, 1 to 65536
/// @param seed   any value
/// @param out    room for 3 * count floats: x, y, z of each point, in the shape's frame (m); filled on LS_OK
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_APPLICABLE,
///         LS_ERROR_DEGENERATE, and what ls_shape_attach returns about a shape
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_cell_seeds_get(shape: *const LsShapeDef, count: usize, seed: u64, out: *mut f32) -> LsResult {
    call("ls_cell_seeds_get", || {
        let floats = count.checked_mul(3).ok_or_else(too_many)?;
        let out = host!(OutArray::new, out, floats);
        let shape = host!(sized::read, shape);
        // SAFETY: the header asks for a definition whose pointers are valid.
        let shape: ShapeDef = unsafe { shape.to_core() }?;
        let seeds = Cells::random_seeds(shape.shape.geometry(), count, seed)?;
        out.write(seeds.into_iter().flat_map(|point| point.to_array()));
        Ok(())
    })
}

/// Cuts a box or a convex hull into the Voronoi cells of seeds: a body with a convex hull for each cell, and a fixed joint at each
/// face that two cells share, its x axis the face's normal, its limits the face's area times the stresses of the material. The
/// same seeds give the same cells.
///
/// @param world           the world; any value is safe
/// @param body            pose and velocity of the solid, and what else its cells have in common; its shapes and mass are not used
/// @param shape           the solid; density, material and filter are those of its cells; local_position and local_rotation are not used
/// @param seeds           3 * seed_count floats: x, y, z of each seed, in the frame of the solid (m); none may be there twice
/// @param seed_count      1 to 65536
/// @param material        what the joints bear
/// @param bodies          room for body_capacity handles, filled on LS_OK in the order of the seeds whose cells are not empty
/// @param body_capacity   number of handles that fit; seed_count always suffices
/// @param body_count      number of cells, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @param joints          room for joint_capacity handles, filled on LS_OK; may be NULL if joint_capacity is 0
/// @param joint_capacity  number of handles that fit
/// @param joint_count     number of joints, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_FINITE,
///         LS_ERROR_NOT_APPLICABLE, LS_ERROR_DEGENERATE, LS_ERROR_BUFFER_TOO_SMALL, and what ls_body_create and ls_joint_create
///         return about definitions
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_cells_create(
    world: LsWorld,
    body: *const LsBodyDef,
    shape: *const LsShapeDef,
    seeds: *const f32,
    seed_count: usize,
    material: *const LsBondMaterial,
    bodies: *mut LsBody,
    body_capacity: usize,
    body_count: *mut usize,
    joints: *mut LsJoint,
    joint_capacity: usize,
    joint_count: *mut usize,
) -> LsResult {
    call("ls_world_cells_create", || {
        let bodies = host!(Buffer::new, bodies, body_capacity, body_count);
        let joints = host!(Buffer::new, joints, joint_capacity, joint_count);
        let floats = seed_count.checked_mul(3).ok_or_else(too_many)?;
        let seeds: Vec<Vec3> = host!(slice, seeds, floats).chunks_exact(3).map(Vec3::from_slice).collect();
        let material = host!(pointer::read, material).into();
        let (body, shape) = (LsBodyDef { shape_count: 0, ..host!(sized::read, body) }, host!(sized::read, shape));
        // SAFETY: the header asks for definitions whose pointers are valid.
        let (body, shape) = unsafe { (body.to_core()?, shape.to_core()?) };
        let cells = Cells::cut(shape.shape.geometry(), &seeds)?;
        let fit = [bodies.room_for(cells.cells.len()), joints.room_for(cells.bonds.len())];
        fit.into_iter().collect::<Outcome<()>>()?;
        edit_hosted(world, |hosted| {
            let (made, held) = hosted.world.create_cells(&cells, &body, &shape, &material)?;
            bodies.fill(|| made.iter().copied().map(LsBody::from))?;
            joints.fill(|| held.iter().copied().map(LsJoint::from))
        })
    })
}

fn too_many() -> Failure {
    Failure::Refused(LS_ERROR_OUT_OF_RANGE, "seed_count", "is more than memory holds")
}
