//! Bodies hung from one another by ball joints, in minimal coordinates.
//!
//! The state is the rotation and the angular velocity of every body; places follow from the top down, so joints cannot open. Body i
//! hangs by its top from a point of its parent, or from a fixed point. About its centre of mass, with t the way to its top, c that to
//! the top of child c, f the force on it at its top and f_c that on the child at the child's top,
//!
//!   m a = m g + f − Σ f_c,    I α + ω × I ω = t × f − Σ c × f_c,
//!   a = a_top − α × t − ω × (ω × t),    a_c = a_top + α × (c − t) + ω × (ω × (c − t)).
//!
//! If every f_c is K_c a_c + b_c, then f too is K a_top + b: the second equation gives α for any a_top, and the first f. So one sweep
//! from the ends up finds all K and b, and one down, from the fixed point that does not accelerate, all α: Featherstone's
//! articulated bodies (1983) for ball joints. Classic Runge–Kutta of fourth order steps it.
//!
//! The same two sweeps, with velocities for accelerations, m v* for m g, I ω* for −ω × I ω, and no ω × ω × r, find the impulses that
//! take velocities v*, ω* at which joints part to the nearest at which they do not.

use longspan::glam::{DMat3, DQuat, DVec3};

/// A body of the tree.
#[derive(Debug, Clone, Copy)]
pub struct HungBody {
    /// What it hangs from: an earlier body, or the fixed point of the tree.
    pub parent: Option<usize>,
    /// Where, in the frame of the parent about its centre of mass, or in the world for the fixed point (m).
    pub on_parent: DVec3,
    /// Its top in its own frame about its centre of mass (m).
    pub top: DVec3,
    /// Mass (kg).
    pub mass: f64,
    /// Inertia about the centre of mass, in its own frame (kg·m²).
    pub inertia: DMat3,
}

/// The tree and its motion.
#[derive(Debug, Clone)]
pub struct BallTree {
    bodies: Vec<HungBody>,
    gravity: DVec3,
    state: Vec<Turning>,
}

/// Rotation (a unit quaternion) and angular velocity in world axes (rad/s), or the rates of both.
#[derive(Debug, Clone, Copy)]
struct Turning {
    rotation: DQuat,
    spin: DVec3,
}

/// What drives the sweeps: for every body the right sides m g (or m v*) and −ω × I ω (or I ω*).
struct Drive {
    push: DVec3,
    moment: DVec3,
}

/// A body in world axes during the sweeps.
struct Joined {
    top: DVec3,
    /// α = turn · a_top + turn_at_rest.
    turn: DMat3,
    turn_at_rest: DVec3,
}

fn cross_matrix(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}

impl BallTree {
    /// Bodies in an order in which parents come first, each with its rotation and the velocities of its centre of mass (m/s) and
    /// about it (rad/s), which are made to agree with the joints.
    pub fn new(bodies: Vec<HungBody>, gravity: DVec3, start: &[(DQuat, DVec3, DVec3)]) -> Self {
        let state = start.iter().map(|&(rotation, _, spin)| Turning { rotation: rotation.normalize(), spin }).collect();
        let mut tree = Self { bodies, gravity, state };
        let drives: Vec<Drive> = (0..tree.bodies.len())
            .map(|index| {
                let (_, velocity, spin) = start[index];
                let inertia = tree.world_inertia(index, &tree.state);
                Drive { push: tree.bodies[index].mass * velocity, moment: inertia * spin }
            })
            .collect();
        let agreed = tree.sweep(&tree.state, &drives, false);
        for (turning, spin) in tree.state.iter_mut().zip(agreed) {
            turning.spin = spin;
        }
        tree
    }

    /// Advances by `dt` (s) in `substeps` steps.
    pub fn advance(&mut self, dt: f64, substeps: u32) {
        let h = dt / f64::from(substeps);
        let moved = |state: &[Turning], rates: &[Turning], by: f64| -> Vec<Turning> {
            let step =
                |(s, r): (&Turning, &Turning)| Turning { rotation: s.rotation + r.rotation * by, spin: s.spin + by * r.spin };
            state.iter().zip(rates).map(step).collect()
        };
        for _ in 0..substeps {
            let k1 = self.rates(&self.state);
            let k2 = self.rates(&moved(&self.state, &k1, 0.5 * h));
            let k3 = self.rates(&moved(&self.state, &k2, 0.5 * h));
            let k4 = self.rates(&moved(&self.state, &k3, h));
            for (index, turning) in self.state.iter_mut().enumerate() {
                let stages = [k1[index], k2[index], k3[index], k4[index]];
                for (stage, weight) in stages.into_iter().zip([1.0, 2.0, 2.0, 1.0]) {
                    turning.rotation += stage.rotation * (weight * h / 6.0);
                    turning.spin += weight * h / 6.0 * stage.spin;
                }
                turning.rotation = turning.rotation.normalize();
            }
        }
    }

    /// Centre of mass of every body (m).
    pub fn centers(&self) -> Vec<DVec3> {
        self.motions().into_iter().map(|(center, _)| center).collect()
    }

    /// Kinetic and potential energy (J), heights taken from the world's origin.
    pub fn energy(&self) -> f64 {
        let of_body = |(index, (center, velocity)): (usize, (DVec3, DVec3))| {
            let (mass, spin) = (self.bodies[index].mass, self.state[index].spin);
            let turning = spin.dot(self.world_inertia(index, &self.state) * spin);
            0.5 * (mass * velocity.length_squared() + turning) - mass * self.gravity.dot(center)
        };
        self.motions().into_iter().enumerate().map(of_body).sum()
    }

    /// Position and velocity of every centre of mass.
    fn motions(&self) -> Vec<(DVec3, DVec3)> {
        let mut motions: Vec<(DVec3, DVec3)> = Vec::with_capacity(self.bodies.len());
        for (body, turning) in self.bodies.iter().zip(&self.state) {
            let (top, velocity) = match body.parent {
                None => (body.on_parent, DVec3::ZERO),
                Some(parent) => {
                    let arm = self.state[parent].rotation * body.on_parent;
                    let (center, velocity) = motions[parent];
                    (center + arm, velocity + self.state[parent].spin.cross(arm))
                }
            };
            let arm = turning.rotation * body.top;
            motions.push((top - arm, velocity - turning.spin.cross(arm)));
        }
        motions
    }

    fn world_inertia(&self, index: usize, state: &[Turning]) -> DMat3 {
        let axes = DMat3::from_quat(state[index].rotation.normalize());
        axes * self.bodies[index].inertia * axes.transpose()
    }

    fn rates(&self, state: &[Turning]) -> Vec<Turning> {
        let drives: Vec<Drive> = (0..self.bodies.len())
            .map(|index| {
                let spin = state[index].spin;
                let moment = -spin.cross(self.world_inertia(index, state) * spin);
                Drive { push: self.bodies[index].mass * self.gravity, moment }
            })
            .collect();
        let accelerations = self.sweep(state, &drives, true);
        let rate = |(turning, spin): (&Turning, DVec3)| {
            let w = turning.spin;
            Turning { rotation: DQuat::from_xyzw(w.x, w.y, w.z, 0.0) * turning.rotation * 0.5, spin }
        };
        state.iter().zip(accelerations).map(rate).collect()
    }

    /// Angular acceleration of every body, or its angular velocity after the impulses; `is_moving` puts in ω × ω × r.
    fn sweep(&self, state: &[Turning], drives: &[Drive], is_moving: bool) -> Vec<DVec3> {
        let count = self.bodies.len();
        let inward = |spin: DVec3, arm: DVec3| if is_moving { spin.cross(spin.cross(arm)) } else { DVec3::ZERO };
        // Sums over the children of each body: force and moment as functions of its a_top and α.
        let mut loads = vec![Load::NONE; count];
        let mut joined: Vec<Joined> = Vec::with_capacity(count);
        for index in (0..count).rev() {
            let (body, turning) = (&self.bodies[index], &state[index]);
            let rotation = turning.rotation.normalize();
            let top = rotation * body.top;
            let arm = cross_matrix(top);
            let load = loads[index];
            // Force at the top, and balance of moments about the centre, by a_top and α.
            let by_top = body.mass * DMat3::IDENTITY + load.force_by_top;
            let by_turn = body.mass * arm + load.force_by_turn;
            let at_rest = -body.mass * inward(turning.spin, top) - drives[index].push + load.force_at_rest;
            let moment_by_top = load.moment_by_top - arm * by_top;
            let moment_by_turn = self.world_inertia(index, state) + load.moment_by_turn - arm * by_turn;
            let moment_at_rest = load.moment_at_rest - drives[index].moment - arm * at_rest;

            let inverse = moment_by_turn.inverse();
            let (turn, turn_at_rest) = (-(inverse * moment_by_top), -(inverse * moment_at_rest));
            if let Some(parent) = body.parent {
                let (stiffness, pull) = (by_top + by_turn * turn, at_rest + by_turn * turn_at_rest);
                let (parent_spin, parent_rotation) = (state[parent].spin, state[parent].rotation.normalize());
                let at = parent_rotation * body.on_parent;
                let from_top = at - parent_rotation * self.bodies[parent].top;
                loads[parent].add(at, from_top, stiffness, pull + stiffness * inward(parent_spin, from_top));
            }
            joined.push(Joined { top, turn, turn_at_rest });
        }
        joined.reverse();

        let mut tops: Vec<DVec3> = Vec::with_capacity(count);
        let mut turns: Vec<DVec3> = Vec::with_capacity(count);
        for (index, body) in self.bodies.iter().enumerate() {
            let top = match body.parent {
                None => DVec3::ZERO,
                Some(parent) => {
                    let from_top = state[parent].rotation.normalize() * body.on_parent - joined[parent].top;
                    tops[parent] + turns[parent].cross(from_top) + inward(state[parent].spin, from_top)
                }
            };
            tops.push(top);
            turns.push(joined[index].turn * top + joined[index].turn_at_rest);
        }
        turns
    }
}

/// What the children of a body pull it with, as functions of the acceleration of its top and of its angular one.
#[derive(Debug, Clone, Copy)]
struct Load {
    force_by_top: DMat3,
    force_by_turn: DMat3,
    force_at_rest: DVec3,
    moment_by_top: DMat3,
    moment_by_turn: DMat3,
    moment_at_rest: DVec3,
}

impl Load {
    const NONE: Self = Self {
        force_by_top: DMat3::ZERO,
        force_by_turn: DMat3::ZERO,
        force_at_rest: DVec3::ZERO,
        moment_by_top: DMat3::ZERO,
        moment_by_turn: DMat3::ZERO,
        moment_at_rest: DVec3::ZERO,
    };

    /// Adds a child at `at` from the centre and `from_top` from the top, with f_c = K (a_top + α × from_top) + pull.
    fn add(&mut self, at: DVec3, from_top: DVec3, stiffness: DMat3, pull: DVec3) {
        let by_turn = stiffness * -cross_matrix(from_top);
        let arm = cross_matrix(at);
        self.force_by_top += stiffness;
        self.force_by_turn += by_turn;
        self.force_at_rest += pull;
        self.moment_by_top += arm * stiffness;
        self.moment_by_turn += arm * by_turn;
        self.moment_at_rest += arm * pull;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Link, PlanarChain};
    use super::*;

    fn rod_inertia(moment: f64) -> DMat3 {
        DMat3::from_diagonal(DVec3::new(moment, 0.02 * moment, moment))
    }

    /// A chain of `count` links and a weight along x, as the planar reference has it.
    fn level_chain(count: usize, weight: f64) -> (BallTree, PlanarChain) {
        let link = Link { mass: 1.0, inertia: 0.0033, to_center: 0.1, to_bottom: 0.1 };
        let end = Link { mass: weight, inertia: weight / 6.0, to_center: 0.5, to_bottom: 0.5 };
        let links = [vec![link; count], vec![end]].concat();
        let mut bodies: Vec<HungBody> = Vec::new();
        for (index, link) in links.iter().enumerate() {
            let parent = index.checked_sub(1);
            let on_parent = parent.map_or(DVec3::ZERO, |parent| DVec3::NEG_Y * links[parent].to_bottom);
            let inertia = rod_inertia(link.inertia);
            bodies.push(HungBody { parent, on_parent, top: DVec3::Y * link.to_center, mass: link.mass, inertia });
        }
        let level = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
        let start = vec![(level, DVec3::ZERO, DVec3::ZERO); links.len()];
        let tree = BallTree::new(bodies, DVec3::NEG_Y * 9.81, &start);
        (tree, PlanarChain::horizontal(links, 9.81))
    }

    #[test]
    fn a_chain_in_space_moves_as_the_chain_in_the_plane() {
        let (mut tree, mut chain) = level_chain(5, 100.0);
        tree.advance(1.0, 6000);
        chain.advance(1.0, 6000);
        let apart = tree.centers()[5].distance(chain.last_center().extend(0.0));
        assert!(apart < 1e-7, "after a second the two references lie {apart:e} m apart, bound 1e-7 m");
    }

    #[test]
    fn a_branched_tree_keeps_its_energy() {
        let body = |parent: Option<usize>, on_parent: DVec3, mass: f64| HungBody {
            parent,
            on_parent,
            top: DVec3::Y * 0.3,
            mass,
            inertia: DMat3::from_diagonal(DVec3::new(0.1, 0.04, 0.07)) * mass,
        };
        let bodies = vec![
            body(None, DVec3::ZERO, 2.0),
            body(Some(0), DVec3::new(0.4, -0.3, 0.1), 1.0),
            body(Some(0), DVec3::new(-0.5, -0.2, 0.2), 3.0),
            body(Some(2), DVec3::new(0.1, -0.4, 0.0), 0.5),
        ];
        let start = vec![(DQuat::IDENTITY, DVec3::Z, DVec3::new(0.0, 2.0, 0.5)); 4];
        let mut tree = BallTree::new(bodies, DVec3::NEG_Y * 9.81, &start);
        let before = tree.energy();
        tree.advance(2.0, 4000);
        let drift = (tree.energy() - before).abs();
        assert!(drift < 1e-6, "energy drifts by {drift:e} J of {before} J in two seconds, bound 1e-6 J");
    }
}
