//! Room in lists that every step refills: grows them without doubling.
//!
//! A vector that grows by doubling keeps up to twice what it needs, and holds old and new at once while it moves. Contacts of a pile
//! are most of its memory, and grow by a few hundredths a step while it falls together.

/// Part of what is needed that is taken beside it.
const SPARE: usize = 8;

/// Elements for which room is made at least.
const MIN_MORE: usize = 16;

/// Makes room for `count` elements in an empty list; what it had is given back first.
pub(crate) fn make_room<T>(list: &mut Vec<T>, count: usize) {
    debug_assert!(list.is_empty(), "what is in a list would be lost");
    if list.capacity() < count {
        *list = Vec::new();
        list.reserve_exact(count + count / SPARE);
    }
}

/// Gives a list so many elements, those that it has as they are: what it had is given back before it takes more memory.
pub(crate) fn resize<T: Clone>(list: &mut Vec<T>, count: usize, more: T) {
    if list.capacity() < count {
        list.clear();
        make_room(list, count);
    }
    list.resize(count, more);
}

/// Makes room for `more` elements behind those that a list has.
pub(crate) fn make_room_behind<T>(list: &mut Vec<T>, more: usize) {
    let needed = list.len() + more;
    if list.capacity() < needed {
        list.reserve_exact(more + needed / SPARE);
    }
}

/// Extends a list by elements that nobody has counted, without room for twice as many as it has.
pub(crate) fn extend_tightly<T>(list: &mut Vec<T>, more: impl Iterator<Item = T>) {
    for element in more {
        if list.len() == list.capacity() {
            make_room_behind(list, MIN_MORE);
        }
        list.push(element);
    }
}

/// Elements for which a list keeps its room, however few it has now, and share of the room that it must need beyond that.
const KEPT: usize = 16_384;
const MIN_USED: usize = 8;

/// Gives back the room of a list that has needed much more than it does now.
pub(crate) fn give_back_room<T>(list: &mut Vec<T>) {
    if list.capacity() > KEPT && list.len() < list.capacity() / MIN_USED {
        list.shrink_to(KEPT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_eighth_is_kept_in_reserve_and_no_more() {
        let mut list: Vec<u64> = Vec::new();
        make_room(&mut list, 800);
        assert_eq!(list.capacity(), 900);
        make_room(&mut list, 900);
        assert_eq!(list.capacity(), 900);
        resize(&mut list, 900, 1);
        make_room_behind(&mut list, 1);
        assert_eq!((list.capacity(), list.iter().sum()), (1013, 900));
        list[0] = 7;
        resize(&mut list, 3, 2);
        resize(&mut list, 5, 2);
        assert_eq!(list, [7, 1, 1, 2, 2]);
    }

    #[test]
    fn what_is_not_counted_takes_an_eighth_more_than_it_needs() {
        let mut list = Vec::new();
        extend_tightly(&mut list, 0..5);
        assert_eq!(list.capacity(), 18);
        extend_tightly(&mut list, 5..10_000);
        assert!(list.iter().copied().eq(0..10_000) && list.capacity() < 11_300, "{}", list.capacity());
    }

    #[test]
    fn a_list_keeps_room_for_what_it_needs_now_and_then() {
        let mut list: Vec<u64> = Vec::with_capacity(8 * KEPT);
        list.resize(KEPT, 1);
        give_back_room(&mut list);
        assert_eq!(list.capacity(), 8 * KEPT);
        list.truncate(KEPT - 1);
        give_back_room(&mut list);
        assert_eq!(list.capacity(), KEPT);
        list.clear();
        give_back_room(&mut list);
        assert_eq!(list.capacity(), KEPT);
    }
}
