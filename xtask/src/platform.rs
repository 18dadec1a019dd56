//! All that differs by platform in the project's own commands.

use std::path::Path;

use crate::Outcome;

/// Makes a link to a file beside it, or a copy where links need rights.
pub fn link(target: &str, at: &Path) -> Outcome<()> {
    if at.symlink_metadata().is_ok() {
        std::fs::remove_file(at)?;
    }
    #[cfg(unix)]
    std::os::unix::fs::symlink(target, at)?;
    #[cfg(not(unix))]
    std::fs::copy(at.with_file_name(target), at)?;
    Ok(())
}

/// Whether the processor has the registers in which steps are counted.
pub fn has_avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    return false;
}
