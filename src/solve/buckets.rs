//! Counting sort: numbers grouped by bucket, in the order in which they came.

use crate::tight_vec::make_room;

/// Lists of numbers, one for each bucket.
#[derive(Debug, Default)]
pub(crate) struct Buckets {
    /// First number of each bucket, and one past the last.
    starts: Vec<u32>,
    numbers: Vec<u32>,
}

impl Buckets {
    pub(crate) fn clear(&mut self) {
        self.starts.clear();
    }

    /// Sorts pairs of a bucket, below `count`, and a number in it.
    pub(crate) fn sort(&mut self, count: usize, pairs: impl ExactSizeIterator<Item = (u32, u32)> + Clone) {
        let Self { starts, numbers } = self;
        // Two places behind its own a bucket is counted, one behind it is filled.
        starts.clear();
        starts.resize(count + 2, 0);
        for (bucket, _) in pairs.clone() {
            starts[bucket as usize + 2] += 1;
        }
        for bucket in 2..starts.len() {
            starts[bucket] += starts[bucket - 1];
        }
        numbers.clear();
        make_room(numbers, pairs.len());
        numbers.resize(pairs.len(), 0);
        for (bucket, number) in pairs {
            let place = &mut starts[bucket as usize + 1];
            numbers[*place as usize] = number;
            *place += 1;
        }
    }

    /// Numbers of all buckets, one after another.
    pub(crate) fn all(&self) -> &[u32] {
        &self.numbers
    }

    /// Numbers of a bucket; none where it has not been sorted into.
    pub(crate) fn of(&self, bucket: u32) -> &[u32] {
        match self.starts.get(bucket as usize..bucket as usize + 2) {
            Some(&[start, end]) => &self.numbers[start as usize..end as usize],
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_is_in_its_bucket_in_the_order_it_came() {
        let mut buckets = Buckets::default();
        assert!(buckets.of(0).is_empty());
        for pairs in [&[(2, 5), (0, 1), (2, 3), (3, 9), (0, 0)][..], &[(1, 7)], &[]] {
            buckets.sort(4, pairs.iter().copied());
            for bucket in 0..4 {
                let expected: Vec<u32> = pairs.iter().filter(|pair| pair.0 == bucket).map(|pair| pair.1).collect();
                assert_eq!(buckets.of(bucket), expected);
            }
        }
        buckets.clear();
        assert!(buckets.of(1).is_empty());
    }
}
