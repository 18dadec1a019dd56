//! A panic inside the library becomes a result, and its world is out of use.

use std::ffi::CStr;

use super::{DT, create_ball, create_world};
use crate::access::{edit_hosted, read};
use crate::body_def::LS_BODY_DYNAMIC;
use crate::boundary::call;
use crate::handle::LsWorld;
use crate::last_error::ls_last_error_message_get;
use crate::result::*;
use crate::world::{ls_world_destroy, ls_world_step_count_get};
use crate::world_events::ls_world_step;

#[derive(Clone, Copy)]
#[repr(C)]
enum During {
    Read,
    Edit,
}

/// An export like any other, whose work fails.
extern "C" fn ls_test_fail(world: LsWorld, during: During) -> LsResult {
    call("ls_test_fail", || match during {
        During::Read => read(world, |_| panic!("index out of bounds")),
        During::Edit => edit_hosted(world, |_| panic!("index out of bounds")),
    })
}

fn last_message() -> String {
    // SAFETY: the message is never null and ends with a NUL.
    unsafe { CStr::from_ptr(ls_last_error_message_get()) }.to_string_lossy().into_owned()
}

#[test]
fn a_panic_poisons_its_world_and_no_other() {
    for during in [During::Read, During::Edit] {
        let (world, other) = (create_world(), create_world());
        create_ball(world, LS_BODY_DYNAMIC, 0.0);
        assert_eq!(ls_test_fail(world, during), LS_ERROR_PANIC);
        let message = last_message();
        assert!(message.contains("ls_test_fail") && message.contains("index out of bounds"), "{message}");

        assert_eq!(ls_world_step(world, DT), LS_ERROR_WORLD_POISONED);
        let mut steps = 7;
        // SAFETY: the pointer is valid.
        assert_eq!(unsafe { ls_world_step_count_get(world, &mut steps) }, LS_ERROR_WORLD_POISONED);
        assert_eq!(steps, 7, "a refused call writes nothing");
        assert_eq!(ls_world_step(other, DT), LS_OK);

        assert_eq!(ls_world_destroy(world), LS_OK);
        assert_eq!(ls_world_destroy(world), LS_ERROR_ALREADY_DESTROYED);
        assert_eq!(ls_world_destroy(other), LS_OK);
    }
}

#[test]
fn every_kind_of_refusal_has_a_code_of_its_own() {
    use ls_core::ErrorKind::*;
    let kinds = [
        NullHandle,
        InvalidHandle,
        StaleHandle,
        AlreadyDestroyed,
        ForeignHandle,
        NotFinite,
        OutOfRange,
        NotUnit,
        Degenerate,
        IndexOutOfRange,
        NotApplicable,
        Unsupported,
        CapacityExceeded,
        InvalidSnapshot,
    ];
    let mut codes: Vec<LsResult> = kinds.iter().map(|&kind| Failure::from(ls_core::Error::new(kind, "x", "y")).code()).collect();
    codes.sort_unstable();
    codes.dedup();
    assert_eq!(codes.len(), kinds.len(), "{codes:?}");
    assert!(!codes.contains(&LS_ERROR_OTHER) && !codes.contains(&LS_OK), "{codes:?}");
}
