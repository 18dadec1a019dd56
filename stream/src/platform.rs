//! All that differs by platform in streams, which is Linux: files under /proc and /dev/shm, whose owners and modes are looked at.

#[cfg(not(target_os = "linux"))]
compile_error!("streams need Linux; build longspan-capi, which has their functions, returning LS_ERROR_UNSUPPORTED elsewhere");

pub(crate) use std::os::unix::fs::{DirBuilderExt, FileExt, MetadataExt, PermissionsExt};
