//! Who is there: compared with who was there before.

use longspan::Handle;

/// The objects of one kind, by place.
#[derive(Debug, Default)]
pub(super) struct Census {
    /// Bits of the handle at each place; 0 where there is none.
    now: Vec<u64>,
    before: Vec<u64>,
    pub count: usize,
}

impl Census {
    /// Takes the objects that there are now; `gone` is told what is there no more, then `came` what is new, both in order of places.
    pub(super) fn update<H: Handle>(&mut self, objects: impl Iterator<Item = H>, mut gone: impl FnMut(u64), came: impl FnMut(H)) {
        std::mem::swap(&mut self.now, &mut self.before);
        self.now.clear();
        self.now.resize(self.before.len(), 0);
        self.count = 0;
        for object in objects {
            if object.place() >= self.now.len() {
                self.now.resize(object.place() + 1, 0);
            }
            self.now[object.place()] = object.to_bits();
            self.count += 1;
        }
        for (&before, &now) in self.before.iter().zip(&self.now) {
            if before != 0 && before != now {
                gone(before);
            }
        }
        self.each_new(came);
    }

    /// Tells once more what the last update found to be new.
    pub(super) fn each_new<H: Handle>(&self, mut came: impl FnMut(H)) {
        for (place, &now) in self.now.iter().enumerate() {
            if now != 0 && self.before.get(place) != Some(&now) {
                came(H::from_bits(now));
            }
        }
    }

    /// The object at this place.
    pub(super) fn at<H: Handle>(&self, place: usize) -> Option<H> {
        self.now.get(place).filter(|&&bits| bits != 0).map(|&bits| H::from_bits(bits))
    }

    /// The first object at `place` or behind it, and its place.
    pub(super) fn at_or_after<H: Handle>(&self, place: usize) -> Option<(usize, H)> {
        let found = self.now.get(place..)?.iter().position(|&bits| bits != 0)?;
        Some((place + found, H::from_bits(self.now[place + found])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use longspan::{BodyDef, BodyId, Pose, World, WorldDef};

    #[test]
    fn what_comes_and_goes_is_told_also_at_the_same_place() {
        let mut world = World::new(&WorldDef::default()).unwrap();
        let mut census = Census::default();
        let mut look = |world: &World| {
            let (mut gone, mut came) = (Vec::new(), Vec::new());
            census.update(world.bodies(), |bits| gone.push(BodyId::from_bits(bits)), |body: BodyId| came.push(body));
            (gone, came)
        };
        let mut body = || world.create_body(&BodyDef::fixed(Pose::IDENTITY)).unwrap();
        let (a, b) = (body(), body());
        assert_eq!(look(&world), (vec![], vec![a, b]));
        assert_eq!(look(&world), (vec![], vec![]));
        world.destroy_body(a).unwrap();
        let c = world.create_body(&BodyDef::fixed(Pose::IDENTITY)).unwrap();
        assert_eq!(c.place(), a.place(), "a place is used again");
        assert_eq!(look(&world), (vec![a], vec![c]));
    }
}
