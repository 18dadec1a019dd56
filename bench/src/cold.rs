//! Other work between two steps, as a game does it, so that a step finds its code and data in no cache.

use std::hint::black_box;
use std::time::{Duration, Instant};

/// Data gone through (bytes): more than the last-level cache that one core of a desktop or server processor has to itself.
const DATA: usize = 64 << 20;

/// Bytes of a cache line.
const LINE: usize = 64;

/// Work that takes the caches from whoever runs next on this thread. Caches of other cores keep what they have.
pub struct OtherWork {
    data: Vec<u64>,
    functions: Vec<fn(u64) -> u64>,
}

impl OtherWork {
    pub fn new() -> Self {
        Self { data: vec![1; DATA / size_of::<u64>()], functions: functions() }
    }

    /// Runs other code and writes to other data for this long, but at least once over all of both.
    pub fn run(&mut self, length: Duration) {
        let start = Instant::now();
        let mut value = 1;
        loop {
            // Data first: code run last is what the instruction cache is left with.
            for line in self.data.chunks_mut(LINE / size_of::<u64>()) {
                line[0] = line[0].wrapping_add(value);
                value ^= line[0];
            }
            for function in &self.functions {
                value = function(value);
            }
            black_box(value);
            if start.elapsed() >= length {
                break;
            }
        }
    }
}

macro_rules! four_times {
    ($($line:tt)*) => { $($line)* $($line)* $($line)* $($line)* };
}

/// One of many functions that differ in a constant, some two kilobytes of machine code each.
#[inline(never)]
fn other<const A: u64, const B: u64>(mut x: u64) -> u64 {
    let constant = (0x9E37_79B9_7F4A_7C15 ^ (A << 32)) + 2 * B;
    four_times! { four_times! { four_times! {
        x = (x ^ (x >> 29)).wrapping_mul(constant).rotate_left(A as u32).wrapping_add(B | 1);
    } } }
    x
}

fn row<const A: u64>() -> [fn(u64) -> u64; 16] {
    [
        other::<A, 0>,
        other::<A, 1>,
        other::<A, 2>,
        other::<A, 3>,
        other::<A, 4>,
        other::<A, 5>,
        other::<A, 6>,
        other::<A, 7>,
        other::<A, 8>,
        other::<A, 9>,
        other::<A, 10>,
        other::<A, 11>,
        other::<A, 12>,
        other::<A, 13>,
        other::<A, 14>,
        other::<A, 15>,
    ]
}

/// Half a megabyte of code in all, more than a second-level cache keeps beside the data.
fn functions() -> Vec<fn(u64) -> u64> {
    [
        row::<0>(),
        row::<1>(),
        row::<2>(),
        row::<3>(),
        row::<4>(),
        row::<5>(),
        row::<6>(),
        row::<7>(),
        row::<8>(),
        row::<9>(),
        row::<10>(),
        row::<11>(),
        row::<12>(),
        row::<13>(),
        row::<14>(),
        row::<15>(),
    ]
    .concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_takes_as_long_as_asked_and_no_two_functions_are_one() {
        let mut work = OtherWork::new();
        let start = Instant::now();
        work.run(Duration::from_millis(20));
        assert!(start.elapsed() >= Duration::from_millis(20));
        let mut places: Vec<usize> = work.functions.iter().map(|function| *function as usize).collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), 256, "functions merged into one are in the cache already");
    }
}
