//! Who does the independent parts of a step: the calling thread, threads of the world's own, or the host's job system.
//!
//! Parts share nothing and are the same whoever does them, so the bits of a step do not depend on it.

use std::sync::{Arc, Mutex, PoisonError};

use crate::error::{Error, ErrorKind, Result};

/// A host's job system.
pub trait ParallelFor: Send + Sync {
    /// Calls `part` once for each number below `count`, on any threads and in any order, and returns when all calls have
    /// returned. What it leaves out is done afterwards on the calling thread; what it does twice is done once.
    fn run(&self, count: usize, part: &(dyn Fn(usize) + Sync));
}

/// The threads of a world.
#[derive(Default)]
pub(crate) struct Workers {
    own: Option<rayon::ThreadPool>,
    host: Option<Arc<dyn ParallelFor>>,
}

impl Workers {
    /// Threads of the world's own, the calling one among them.
    pub(crate) fn new(count: u32) -> Result<Self> {
        if count == 1 {
            return Ok(Self::default());
        }
        let builder = rayon::ThreadPoolBuilder::new().num_threads(count as usize).thread_name(|i| format!("longspan-{i}"));
        let refused = |_| Error::new(ErrorKind::CapacityExceeded, "threads", "the system gave no more threads");
        Ok(Self { own: Some(builder.build().map_err(refused)?), host: None })
    }

    /// Has the host's job system do the work, or no longer.
    pub(crate) fn set_host(&mut self, host: Option<Arc<dyn ParallelFor>>) {
        self.host = host;
    }

    /// The world's own threads, unless the host does the work.
    pub(crate) fn own(&self) -> Option<&rayon::ThreadPool> {
        self.own.as_ref().filter(|_| self.host.is_none())
    }

    /// The host's job system, if it does the work.
    pub(crate) fn host(&self) -> Option<&dyn ParallelFor> {
        self.host.as_deref()
    }
}

/// Has a job system work on `items`, `length` of them at a time.
pub(crate) fn for_each_chunk<T: Send>(host: &dyn ParallelFor, items: &mut [T], length: usize, work: impl Fn(&mut [T]) + Sync) {
    let chunks: Vec<Mutex<Option<&mut [T]>>> = items.chunks_mut(length).map(|chunk| Mutex::new(Some(chunk))).collect();
    let part = |number: usize| {
        let chunk = chunks.get(number).and_then(|chunk| chunk.lock().unwrap_or_else(PoisonError::into_inner).take());
        if let Some(chunk) = chunk {
            work(chunk);
        }
    };
    host.run(chunks.len(), &part);
    (0..chunks.len()).for_each(part);
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Careless;

    impl ParallelFor for Careless {
        fn run(&self, count: usize, part: &(dyn Fn(usize) + Sync)) {
            // Twice what is even, nothing of what is odd, and some that do not exist.
            (0..count + 5).step_by(2).chain((0..count).step_by(2)).for_each(part);
        }
    }

    #[test]
    fn everything_is_done_once_even_by_a_careless_host() {
        let mut items = vec![0_u32; 1003];
        for_each_chunk(&Careless, &mut items, 10, |chunk| chunk.iter_mut().for_each(|item| *item += 1));
        assert!(items.iter().all(|&item| item == 1));
    }
}
