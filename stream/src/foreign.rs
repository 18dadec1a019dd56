//! Bytes out of memory that another process can change at any moment, or take away.
//!
//! A reference into such memory would be a promise that nobody keeps: the bytes change under it, and where the other process cuts
//! the file short, a read is a fatal signal. So nothing is read in place. The kernel copies, through /proc/self/mem, and says where
//! it could not; what is then looked at is our own copy.

use std::fs::File;

use crate::platform::FileExt;

/// The memory of this process, as the kernel sees it.
#[derive(Debug)]
pub(crate) struct OwnMemory(File);

impl OwnMemory {
    pub(crate) fn open() -> std::io::Result<Self> {
        File::open("/proc/self/mem").map(Self)
    }

    /// Copies from `address` on; false where there is no memory, or less than that.
    #[must_use]
    pub(crate) fn copy(&self, address: usize, into: &mut [u8]) -> bool {
        self.0.read_exact_at(into, address as u64).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_is_there_is_copied_and_other_addresses_are_refused() {
        let memory = OwnMemory::open().expect("/proc/self/mem is readable");
        let bytes: Vec<u8> = (0..100_000_u32).map(|i| i as u8).collect();
        let mut copy = vec![0; bytes.len()];
        assert!(memory.copy(bytes.as_ptr() as usize, &mut copy));
        assert_eq!(copy, bytes);
        for address in [0, 8, usize::MAX, usize::MAX / 2, 1 << 47] {
            assert!(!memory.copy(address, &mut copy[..16]), "address {address:#x}");
        }
    }
}
