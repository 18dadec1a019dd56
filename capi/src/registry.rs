//! The worlds that C has created, found by handle.
//!
//! A world handle is `check (10) | 0 (2) | generation (24) | index + 1 (28)`: laid out like the handles of bodies, shapes and
//! joints, whose two kind bits are never zero, so that none of them passes for a world.

use std::sync::{Arc, PoisonError, RwLock};

use ls_core::World;

use crate::access::WorldCell;
use crate::handle::LsWorld;
use crate::result::{
    Failure, LS_ERROR_ALREADY_DESTROYED, LS_ERROR_CAPACITY_EXCEEDED, LS_ERROR_INVALID_HANDLE, LS_ERROR_NULL_HANDLE,
    LS_ERROR_STALE_HANDLE, LsResult, Outcome,
};

const INDEX_BITS: u32 = 28;
const GENERATION_BITS: u32 = 24;
const CHECK_SHIFT: u32 = 54;
/// Keeps small invented numbers from naming a world.
const CHECK: u64 = 0x2B5;

/// No world has this generation, so that counting up to it retires a slot.
const LAST_GENERATION: u32 = (1 << GENERATION_BITS) - 1;

struct Slot {
    generation: u32,
    cell: Option<Arc<WorldCell>>,
}

static WORLDS: RwLock<Vec<Slot>> = RwLock::new(Vec::new());

fn handle(index: usize, generation: u32) -> LsWorld {
    LsWorld { id: (CHECK << CHECK_SHIFT) | (u64::from(generation) << INDEX_BITS) | (index as u64 + 1) }
}

/// Index and generation of a handle that has the form of a world's.
fn decode(world: LsWorld) -> Outcome<(usize, u32)> {
    if world.id == 0 {
        return Err(refuse(LS_ERROR_NULL_HANDLE, "handle is null"));
    }
    let index = world.id & ((1 << INDEX_BITS) - 1);
    if world.id >> (INDEX_BITS + GENERATION_BITS) != CHECK << 2 || index == 0 {
        return Err(refuse(LS_ERROR_INVALID_HANDLE, "handle was never given out for a world"));
    }
    Ok((index as usize - 1, (world.id >> INDEX_BITS) as u32 & LAST_GENERATION))
}

fn refuse(code: LsResult, problem: &'static str) -> Failure {
    Failure::Refused(code, "world", problem)
}

/// What a handle of a world that is no more gets.
pub(crate) fn stale() -> Failure {
    refuse(LS_ERROR_STALE_HANDLE, "world was destroyed")
}

/// What the destruction of a world that is no more gets.
pub(crate) fn already_destroyed() -> Failure {
    refuse(LS_ERROR_ALREADY_DESTROYED, "world was destroyed before")
}

pub(crate) fn insert(world: World) -> Outcome<LsWorld> {
    let mut slots = WORLDS.write().unwrap_or_else(PoisonError::into_inner);
    let free = slots.iter().position(|slot| slot.cell.is_none() && slot.generation < LAST_GENERATION);
    let index = free.unwrap_or(slots.len());
    if index == slots.len() {
        if index as u64 + 1 >= 1 << INDEX_BITS {
            return Err(refuse(LS_ERROR_CAPACITY_EXCEEDED, "all handles of worlds are used up"));
        }
        slots.push(Slot { generation: 0, cell: None });
    }
    let slot = &mut slots[index];
    slot.cell = Some(Arc::new(WorldCell::new(world)));
    Ok(handle(index, slot.generation))
}

pub(crate) fn find(world: LsWorld) -> Outcome<Arc<WorldCell>> {
    let (index, generation) = decode(world)?;
    let slots = WORLDS.read().unwrap_or_else(PoisonError::into_inner);
    match slots.get(index) {
        Some(Slot { generation: current, cell: Some(cell) }) if *current == generation => Ok(Arc::clone(cell)),
        Some(slot) if generation < slot.generation => Err(stale()),
        _ => Err(refuse(LS_ERROR_INVALID_HANDLE, "handle was never given out")),
    }
}

/// As [`find`], for a call that destroys: a dead world is an error of its own.
pub(crate) fn find_to_destroy(world: LsWorld) -> Outcome<Arc<WorldCell>> {
    find(world).map_err(|failure| match failure.code() {
        LS_ERROR_STALE_HANDLE => already_destroyed(),
        _ => failure,
    })
}

/// Ends the life of a handle that `find` has found.
pub(crate) fn remove(world: LsWorld) -> Outcome<()> {
    let (index, generation) = decode(world)?;
    let mut slots = WORLDS.write().unwrap_or_else(PoisonError::into_inner);
    if let Some(slot) = slots.get_mut(index).filter(|slot| slot.generation == generation) {
        slot.cell = None;
        slot.generation += 1;
    }
    Ok(())
}
