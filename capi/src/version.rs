//! Which version the library is, at compile time of the host and at run time.

use crate::boundary::call;
use crate::pointer::{Out, host};
use crate::result::LsResult;

/// Major version of this header.
pub const LS_VERSION_MAJOR: u32 = 0;
/// Minor version of this header.
pub const LS_VERSION_MINOR: u32 = 1;
/// Patch version of this header.
pub const LS_VERSION_PATCH: u32 = 0;
/// Number of the binary interface that this header describes; it is also the number in the SONAME. A library with the same
/// number runs every host compiled against an older or newer header with that number.
pub const LS_ABI_VERSION: u32 = 0;

/// Version of a library.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct LsVersion {
    /// Major version.
    pub major: u32,
    /// Minor version.
    pub minor: u32,
    /// Patch version.
    pub patch: u32,
    /// Number of the binary interface, to be compared with LS_ABI_VERSION.
    pub abi: u32,
}

/// Version of the library that the host runs with.
///
/// @param out  filled on LS_OK
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_version_get(out: *mut LsVersion) -> LsResult {
    call("ls_version_get", || {
        host!(Out::new, out).write(LsVersion {
            major: LS_VERSION_MAJOR,
            minor: LS_VERSION_MINOR,
            patch: LS_VERSION_PATCH,
            abi: LS_ABI_VERSION,
        })
    })
}

const _: () = {
    const fn number(text: &str) -> u32 {
        let (bytes, mut value, mut i) = (text.as_bytes(), 0, 0);
        while i < bytes.len() {
            value = 10 * value + (bytes[i] - b'0') as u32;
            i += 1;
        }
        value
    }
    assert!(number(env!("CARGO_PKG_VERSION_MAJOR")) == LS_VERSION_MAJOR, "the package and the header differ in version");
    assert!(number(env!("CARGO_PKG_VERSION_MINOR")) == LS_VERSION_MINOR, "the package and the header differ in version");
    assert!(number(env!("CARGO_PKG_VERSION_PATCH")) == LS_VERSION_PATCH, "the package and the header differ in version");
};
