//! Enlarged boxes of all shapes: a list while they are few, parry3d's bounding volume hierarchy from then on.
//!
//! Some dozens of boxes are compared with one another in less time than it takes to bring a tree up to date and to descend into
//! it from each.

use glam::Vec3;
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::partitioning::{Bvh, BvhWorkspace, TraversalAction};

/// Boxes up to which they are a list. Of a hundred, all of which change in every step, a list costs about as much as a tree.
const MAX_LISTED: usize = 64;

/// One of so many boxes of a tree may have changed without it being made tight again. A box that changes alone goes up through a
/// dozen nodes, where all of them are gone through to make a tree tight; but what is above a box that has left stays too large.
const LOOSE_SHARE: usize = 16;

/// Boxes by the slots of their shapes.
#[derive(Default)]
pub(super) struct AabbSet {
    /// Sorted by slot; empty where there is a tree.
    listed: Vec<(u32, Aabb)>,
    tree: Bvh,
    workspace: BvhWorkspace,
    /// Boxes that have changed since the tree was last tight.
    loose: usize,
}

impl AabbSet {
    /// Keeps a box for a shape.
    pub(super) fn set(&mut self, shape: u32, kept: Aabb) {
        if !self.list(shape, kept) {
            self.tree.insert(kept, shape);
            self.loose += 1;
        }
    }

    /// Keeps boxes for as many shapes as `count` says, and a tree from going to seed.
    pub(super) fn set_all(&mut self, count: usize, all: impl Iterator<Item = (u32, Aabb)>) {
        if (self.loose + count) * LOOSE_SHARE <= self.tree.leaf_count() as usize {
            return all.for_each(|(shape, kept)| self.set(shape, kept));
        }
        for (shape, kept) in all {
            if !self.list(shape, kept) {
                self.tree.insert_or_update_partially(kept, shape, 0.0);
            }
        }
        if !self.tree.is_empty() {
            self.tree.refit(&mut self.workspace);
            self.tree.optimize_incremental(&mut self.workspace);
            self.loose = 0;
        }
    }

    /// Whether a box has gone into the list; one too many for it makes a tree of it.
    fn list(&mut self, shape: u32, kept: Aabb) -> bool {
        if !self.tree.is_empty() {
            return false;
        }
        match self.listed.binary_search_by_key(&shape, |&(shape, _)| shape) {
            Ok(place) => self.listed[place].1 = kept,
            Err(place) if self.listed.len() < MAX_LISTED => self.listed.insert(place, (shape, kept)),
            Err(_) => {
                for (shape, kept) in std::mem::take(&mut self.listed) {
                    self.tree.insert(kept, shape);
                }
                return false;
            }
        }
        true
    }

    pub(super) fn remove(&mut self, shape: u32) {
        if let Ok(place) = self.listed.binary_search_by_key(&shape, |&(shape, _)| shape) {
            self.listed.remove(place);
        }
        self.tree.remove(shape);
    }

    /// Shapes that have a box, in no particular order.
    pub(super) fn shapes(&self) -> impl Iterator<Item = u32> + '_ {
        self.listed.iter().map(|&(shape, _)| shape).chain(self.tree.leaves(|_| true))
    }

    /// Shapes whose box meets `region`, in no particular order.
    pub(super) fn overlapping<'a>(&'a self, region: &'a Aabb) -> impl Iterator<Item = u32> + 'a {
        let listed = self.listed.iter().filter(|(_, kept)| kept.intersects(region)).map(|&(shape, _)| shape);
        listed.chain(self.tree.intersect_aabb(region))
    }

    /// Appends the shapes whose box a path enters (`enters` says where, of the box's corners), in no particular order.
    pub(super) fn along(&self, enters: impl Fn(Vec3, Vec3) -> Option<f64>, found: &mut Vec<(f64, u32)>) {
        found.extend(self.listed.iter().filter_map(|&(shape, kept)| Some((enters(kept.mins, kept.maxs)?, shape))));
        self.tree.traverse(|node| match enters(node.mins(), node.maxs()) {
            None => TraversalAction::Prune,
            Some(entry) => {
                if let Some(shape) = node.leaf_data() {
                    found.push((entry, shape));
                }
                TraversalAction::Continue
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(at: f32) -> Aabb {
        Aabb::new(Vec3::splat(at), Vec3::splat(at + 0.9))
    }

    fn meeting(boxes: &AabbSet, region: &Aabb) -> Vec<u32> {
        let mut found: Vec<u32> = boxes.overlapping(region).collect();
        found.sort_unstable();
        found
    }

    #[test]
    fn a_list_and_the_tree_that_it_becomes_find_the_same() {
        let mut boxes = AabbSet::default();
        let most = MAX_LISTED as u32;
        // Against the order of their slots, so that the list has to sort them.
        for shape in (0..most).rev() {
            boxes.set(shape, cube(shape as f32));
        }
        boxes.set(7, cube(500.0));
        boxes.remove(9);
        let region = Aabb::new(Vec3::splat(5.5), Vec3::splat(10.5));
        assert_eq!((boxes.tree.is_empty(), meeting(&boxes, &region)), (true, vec![5, 6, 8, 10]));
        boxes.set(9, cube(9.0));
        boxes.set(most, cube(500.0));
        assert_eq!((boxes.listed.is_empty(), meeting(&boxes, &region)), (true, vec![5, 6, 8, 9, 10]));
        assert_eq!(meeting(&boxes, &cube(500.0)), [7, most]);
        boxes.remove(most);
        assert_eq!(boxes.shapes().count(), MAX_LISTED);
    }

    #[test]
    fn few_boxes_that_change_leave_a_tree_loose_and_many_make_it_tight() {
        let mut boxes = AabbSet::default();
        let all = 32 * LOOSE_SHARE as u32;
        boxes.set_all(all as usize, (0..all).map(|shape| (shape, cube(shape as f32))));
        assert_eq!(boxes.loose, 0, "loose when all are new");
        for (changed, loose) in [(1, 1), (31, 32), (1, 0)] {
            let moved = (0..changed).map(|shape| (shape, cube(shape as f32 + 1000.0)));
            boxes.set_all(changed as usize, moved);
            assert_eq!(boxes.loose, loose, "loose once {changed} more have changed");
            let near = |at: f32| meeting(&boxes, &Aabb::new(Vec3::splat(at), Vec3::splat(at + 0.5)));
            assert_eq!((near(0.0), near(1000.0), near(all as f32 - 1.0)), (vec![], vec![0], vec![all - 1]));
        }
    }

    #[test]
    fn a_path_enters_listed_boxes_too() {
        let mut boxes = AabbSet::default();
        boxes.set(3, cube(0.0));
        boxes.set(4, cube(2.0));
        let mut found = Vec::new();
        boxes.along(|mins, _| (mins.x > 1.0).then_some(f64::from(mins.x)), &mut found);
        assert_eq!(found, [(2.0, 4)]);
    }
}
