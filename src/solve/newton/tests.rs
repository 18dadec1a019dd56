//! The solver on plain arrays: what closed forms say of small problems.

use glam::{DMat3, DVec3};

use super::factor::Vector;
use super::outline::{JointOutline, Outline};
use super::problem::{BodyMass, JointBlock, Problem};
use super::term::{FIXED, Law, Term};

/// Length of a substep (s), and free fall in it (m/s).
const H: f64 = 1.0 / 240.0;
const FALL: f64 = 9.81 * H;

const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A cube of 0.5 m with this mass and velocity, on which `free` acts.
fn add_cube(problem: &mut Problem, mass: f64, before: Vector, free: Vector) {
    let moment = mass / 24.0;
    let angular = AXES.map(|axis| axis.map(|value| value * moment));
    problem.masses.push(BodyMass { linear: [mass; 3], angular, ..BodyMass::default() });
    problem.before.push(before);
    problem.free.push(free);
}

/// Corners of its lower face, from its centre.
fn corners() -> [[f64; 3]; 4] {
    [[0.25, -0.25, 0.25], [0.25, -0.25, -0.25], [-0.25, -0.25, 0.25], [-0.25, -0.25, -0.25]]
}

fn row(axis: [f64; 3], lever: [f64; 3], sign: f64) -> Vector {
    let [a, r] = [axis, lever];
    let turn = [r[1] * a[2] - r[2] * a[1], r[2] * a[0] - r[0] * a[2], r[0] * a[1] - r[1] * a[0]];
    [a[0], a[1], a[2], turn[0], turn[1], turn[2]].map(|value| sign * value)
}

/// Puts `above` on `below` with its four lower corners, and friction at their middle.
fn stand(problem: &mut Problem, below: u32, above: u32, friction: f64, pressed: [f64; 4]) {
    let first = problem.terms.len() as u32;
    let other = |lever: [f64; 3]| [lever[0], 0.25, lever[2]];
    for (corner, pressed) in corners().into_iter().zip(pressed) {
        let mut term = Term::new([below, above], 1, Law::Between(0.0, f64::INFINITY));
        term.jacobian[0][0] = row(AXES[1], other(corner), -1.0);
        term.jacobian[1][0] = row(AXES[1], corner, 1.0);
        term.expected[0] = pressed;
        problem.terms.push(term);
    }
    let mut term = Term::new([below, above], 2, Law::Leaning { first, count: 4, share: friction });
    for (number, axis) in [AXES[0], AXES[2]].into_iter().enumerate() {
        term.jacobian[0][number] = row(axis, [0.0, 0.25, 0.0], -1.0);
        term.jacobian[1][number] = row(axis, [0.0, -0.25, 0.0], 1.0);
    }
    problem.terms.push(term);
}

fn find_structure(problem: &mut Problem) {
    let mut outline = Outline::default();
    outline.begin(problem.masses.len(), u64::MAX);
    for link in &problem.links {
        outline.add_joint(JointOutline { bodies: link.bodies, rows: link.rows as u8, acts_between: false });
    }
    problem.terms.iter().for_each(|term| outline.add_pair(term.bodies));
    outline.find(&mut problem.structure);
}

fn solve(problem: &mut Problem) -> u32 {
    find_structure(problem);
    problem.invert_masses();
    problem.begin();
    let effort = problem.solve(12);
    assert!(!effort.is_capped, "{effort:?}");
    effort.factors
}

fn normals(problem: &Problem, first: usize) -> f64 {
    problem.terms[first..first + 4].iter().map(|term| term.impulse[0]).sum()
}

#[test]
fn ten_tonnes_stand_on_a_kilogram_by_one_factorisation() {
    let fall = [0.0, -FALL, 0.0, 0.0, 0.0, 0.0];
    let weights = [1.0, 10_000.0].map(|mass| mass * FALL);
    let mut problem = Problem::default();
    for (is_warm, most) in [(false, 6), (true, 1)] {
        problem.clear();
        add_cube(&mut problem, 1.0, [0.0; 6], fall);
        add_cube(&mut problem, 10_000.0, [0.0; 6], fall);
        let share = if is_warm { 0.25 } else { 0.0 };
        stand(&mut problem, FIXED, 0, 0.5, [share * (weights[0] + weights[1]); 4]);
        stand(&mut problem, 0, 1, 0.5, [share * weights[1]; 4]);
        let factors = solve(&mut problem);
        assert!(factors <= most, "{factors} factorisations, warm: {is_warm}");
        let fastest = problem.velocity.iter().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
        // A bristle of a thousandth of a metre a second bears the whole load the first time.
        let slowest = if is_warm { 1.0e-9 } else { 2.0e-3 };
        assert!(fastest < slowest, "{fastest} m/s, warm: {is_warm}");
        // What is left to the next substep is a thousandth of a metre a second of what a substep falls by.
        let (found, most) = (normals(&problem, 5), if is_warm { 1.0e-6 } else { 1.0e-3 / FALL });
        assert!((found / weights[1] - 1.0).abs() < most, "{found} N s bear {}, warm: {is_warm}", weights[1]);
    }
}

#[test]
fn a_block_slides_down_a_slope_as_coulomb_says_and_stays_on_one_less_steep() {
    for tangent in [0.3, 0.49, 0.6, 1.0_f64] {
        let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
        let (down, into) = (FALL * tangent * cosine, FALL * cosine);
        let (mut speed, mut problem) = (0.0, Problem::default());
        let (mut pressed, mut rubbed, mut substeps) = ([0.0; 4], [0.0; 2], 0);
        for _ in 0..240 {
            problem.clear();
            add_cube(&mut problem, 10.0, [speed, 0.0, 0.0, 0.0, 0.0, 0.0], [speed + down, -into, 0.0, 0.0, 0.0, 0.0]);
            stand(&mut problem, FIXED, 0, 0.5, pressed);
            problem.terms[4].expected = rubbed;
            solve(&mut problem);
            pressed = std::array::from_fn(|i| problem.terms[i].impulse[0]);
            rubbed = problem.terms[4].impulse;
            speed = problem.velocity[0][0];
            substeps += 1;
        }
        let expected = f64::max(0.0, down - 0.5 * into) * f64::from(substeps);
        assert!((speed - expected).abs() < 2.0e-3 + 1.0e-3 * expected, "tan {tangent}: {speed} m/s, expected {expected}");
    }
}

#[test]
fn a_motor_pushes_no_harder_than_it_may_and_holds_its_speed_where_it_can() {
    for (most, expected) in [(0.01, 0.001), (1.0e3, 2.0)] {
        let mut problem = Problem::default();
        add_cube(&mut problem, 10.0, [0.0; 6], [0.0; 6]);
        let mut motor = Term::new([FIXED, 0], 1, Law::Between(-most, most));
        motor.jacobian[1][0] = row(AXES[0], [0.0; 3], 1.0);
        motor.bias[0] = -2.0;
        problem.terms.push(motor);
        solve(&mut problem);
        let found = problem.velocity[0][0];
        assert!((found - expected).abs() < 1.0e-3 * expected, "{found} m/s with {most} N s, expected {expected}");
    }
}

/// A cube that lands at any speed while a spring draws it by a corner. A step was cut short wherever it loaded the spring, whose energy was not
/// counted: of such cubes some took forty factorisations and more.
#[test]
fn a_spring_that_draws_on_what_lands_takes_no_more_factorisations() {
    for number in 0..200_u32 {
        // Speeds of up to a metre a second and a radian a second, and of the spring of up to four, that no two cubes have alike.
        let speed = |axis: u32| f64::from((number * 7 + axis * 5 + number * axis) % 17) / 8.0 - 1.0;
        let before: Vector = std::array::from_fn(|axis| speed(axis as u32));
        let mut problem = Problem::default();
        add_cube(&mut problem, 10.0, before, [before[0], before[1] - FALL, before[2], before[3], before[4], before[5]]);
        stand(&mut problem, FIXED, 0, 0.5, [2.5 * FALL; 4]);
        let mut spring = JointBlock::new([FIXED, 0]);
        spring.rows = 3;
        for (axis, unit) in AXES.into_iter().enumerate() {
            spring.jacobian[1][axis] = row(unit, [0.25; 3], 1.0);
            (spring.bias[axis], spring.give[axis]) = (4.0 * speed(6 + axis as u32), 0.05);
        }
        problem.links.push(spring);
        find_structure(&mut problem);
        problem.invert_masses();
        problem.begin();
        let effort = problem.solve(20);
        assert!(!effort.is_capped, "cube {number} takes {effort:?}, 12 at most as measured");
    }
}

/// Links of 1 kg under a tonne, straight down from a fixed point: every joint bears what hangs on it.
#[test]
fn joints_bear_what_hangs_on_them() {
    let mut problem = Problem::default();
    let masses = [1.0, 1.0, 1.0, 1.0, 1000.0];
    for (number, mass) in masses.into_iter().enumerate() {
        add_cube(&mut problem, mass, [0.0; 6], [0.0, -FALL, 0.0, 0.0, 0.0, 0.0]);
        let above = if number == 0 { FIXED } else { number as u32 - 1 };
        let mut link = JointBlock::new([above, number as u32]);
        link.rows = 3;
        for (axis, unit) in AXES.into_iter().enumerate() {
            link.jacobian[0][axis] = row(unit, [0.0, -0.25, 0.0], -1.0);
            link.jacobian[1][axis] = row(unit, [0.0, 0.25, 0.0], 1.0);
        }
        problem.links.push(link);
    }
    let factors = solve(&mut problem);
    assert_eq!(factors, 1, "without terms one factorisation is enough");
    for (number, link) in problem.links.iter().enumerate() {
        let expected = masses[number..].iter().sum::<f64>() * FALL;
        let found = link.impulse[1];
        // ε of a row is a billionth of what answers of it with its own two bodies; of the row it is 1e3 times that, here five times over.
        assert!((found / expected - 1.0).abs() < 2.0e-5, "joint {number} bears {found} N s of {expected}");
    }
}

/// A square of four bodies whose joints close a loop, with more rows than they need: the matrix has no inverse but for ε.
#[test]
fn rows_that_repeat_one_another_share_their_load() {
    let mut problem = Problem::default();
    add_cube(&mut problem, 10.0, [0.0; 6], [0.0, -FALL, 0.0, 0.0, 0.0, 0.0]);
    for _ in 0..3 {
        let mut link = JointBlock::new([FIXED, 0]);
        link.rows = 6;
        for (axis, unit) in AXES.into_iter().enumerate() {
            link.jacobian[1][axis] = row(unit, [0.0; 3], 1.0);
            link.jacobian[1][3 + axis] = [0.0, 0.0, 0.0, unit[0], unit[1], unit[2]];
        }
        problem.links.push(link);
    }
    solve(&mut problem);
    let (weight, speed) = (10.0 * FALL, problem.velocity[0][1]);
    assert!(speed.abs() < 1.0e-8, "it falls at {speed} m/s");
    for link in &problem.links {
        assert!((link.impulse[1] / weight - 1.0 / 3.0).abs() < 1.0e-3, "{} N s of {weight}", link.impulse[1]);
    }
}

/// Pressed between two walls by more than they can both give way: no solution, and nothing flies off.
#[test]
fn out_of_budget_the_state_stays_bounded() {
    for budget in [1, 2, 3] {
        let mut problem = Problem::default();
        let fall = [3.0, -FALL, 0.0, 0.0, 0.0, 0.0];
        for mass in [1.0, 1000.0, 0.1, 10_000.0] {
            add_cube(&mut problem, mass, fall, fall);
        }
        for (below, above) in [(FIXED, 0), (0, 1), (1, 2), (2, 3)] {
            stand(&mut problem, below, above, 0.5, [0.0; 4]);
        }
        find_structure(&mut problem);
        problem.invert_masses();
        problem.begin();
        problem.solve(budget);
        let energy = |v: &[Vector]| -> f64 {
            v.iter().zip([1.0, 1000.0, 0.1, 10_000.0]).map(|(v, m)| 0.5 * m * (v[0] * v[0] + v[1] * v[1])).sum()
        };
        let (before, after) = (energy(&problem.before), energy(&problem.velocity));
        assert!(after < 1.2 * before, "{after} J of {before} J with {budget} factorisations");
    }
}

/// A net of rods between knots, held at its corners: up to three rods are tied to a fourth at one point of it.
fn net(cells: usize) -> Problem {
    let mut problem = Problem::default();
    let knot = |[row, column]: [usize; 2]| {
        let [u, v] = [row, column].map(|index| 2.0 * index as f64 / cells as f64 - 1.0);
        DVec3::new(u, u * u * v * v, v) * (0.135 * cells as f64)
    };
    let mut held: Vec<Option<(u32, DVec3)>> = vec![None; (cells + 1) * (cells + 1)];
    let corner = |at: [usize; 2]| at.iter().all(|&index| index == 0 || index == cells);
    let ends = (0..=cells).flat_map(|row| (0..=cells).map(move |column| [row, column]));
    let rods = ends.flat_map(|[row, column]| [([row, column], [row + 1, column]), ([row, column], [row, column + 1])]);
    for (from, to) in rods.filter(|(_, to)| to.iter().all(|&index| index <= cells)) {
        let (middle, way) = (0.5 * (knot(from) + knot(to)), knot(to) - knot(from));
        let (along, rod) = (way.normalize(), problem.masses.len() as u32);
        let angular = DMat3::from_diagonal(DVec3::splat(1.5e-3)) - outer(along) * (1.5e-3 - 4.0e-5);
        problem.masses.push(BodyMass { linear: [0.2; 3], angular: angular.to_cols_array_2d(), ..BodyMass::default() });
        // Speeds of up to a metre a second, and turns of up to three radians, that no two rods have alike.
        let speed = |axis: u32| f64::from((rod * 7 + axis * 5) % 13) / 6.0 - 1.0;
        problem.before.push(std::array::from_fn(|axis| speed(axis as u32) * if axis < 3 { 1.0 } else { 3.0 }));
        problem.free.push(problem.before[rod as usize]);
        for (at, lever) in [(from, knot(from) - middle), (to, knot(to) - middle)] {
            let place = &mut held[at[0] * (cells + 1) + at[1]];
            let other = if corner(at) { Some((FIXED, DVec3::ZERO)) } else { *place };
            let Some((other, reach)) = other else {
                *place = Some((rod, lever));
                continue;
            };
            let mut link = JointBlock::new([other, rod]);
            for axis in AXES {
                link.jacobian[0][link.rows] = row(axis, reach.to_array(), -1.0);
                link.jacobian[1][link.rows] = row(axis, lever.to_array(), 1.0);
                link.rows += 1;
            }
            problem.links.push(link);
        }
    }
    problem
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// A pivot next to nothing left rows apart by half a metre a second, and gave velocities the energy of a bomb.
#[test]
fn a_net_whose_knots_hold_four_rods_is_stopped_by_its_joints_and_gains_nothing() {
    for cells in [2, 3, 6] {
        let mut problem = net(cells);
        find_structure(&mut problem);
        problem.invert_masses();
        problem.begin();
        let energy = |problem: &Problem, of: &[Vector]| {
            let mut product = Vec::new();
            problem.times(of, &mut product);
            product.iter().zip(of).map(|(a, b)| super::factor::dot(a, b)).sum::<f64>()
        };
        let before = energy(&problem, &problem.before);
        problem.solve(12);
        let (after, strain) = (energy(&problem, &problem.velocity), problem.strain());
        assert!(strain < 1.0e-6, "{cells} cells: rows part by {strain} m/s, bound 1e-6 m/s");
        assert!(after <= before, "{cells} cells: {after} J after the joints have stopped {before} J");
    }
}

/// A body slides on a point in front of its centre of mass, by which friction lifts it off: of what presses, p/(w + c μ) is left, w and c being how the
/// point answers to a normal impulse along the normal and along the way. Bounds taken from the pass before go to and fro there: from μ = 1.7 on
/// between all and nothing, and friction was twice as great as it may be.
#[test]
fn friction_that_lifts_what_presses_it_ends_where_both_agree() {
    for friction in [1.0, 1.5, 1.8, 3.0] {
        let (mut problem, speed) = (Problem::default(), [-5.0, -0.5, 0.0, 0.0, 0.0, 0.0]);
        add_cube(&mut problem, 1.0, speed, speed);
        let point = [0.25, -0.25, 0.0];
        let mut normal = Term::new([FIXED, 0], 1, Law::Between(0.0, f64::INFINITY));
        normal.jacobian[1][0] = row(AXES[1], point, 1.0);
        let mut across = Term::new([FIXED, 0], 2, Law::Leaning { first: 0, count: 1, share: friction });
        across.jacobian[1] = [AXES[0], AXES[2]].map(|axis| row(axis, point, 1.0));
        problem.terms.extend([normal, across]);
        solve(&mut problem);
        let lever = 0.25 * 0.25 * 24.0;
        let presses = 0.5 / (1.0 + lever + lever * friction);
        let found = [problem.terms[0].impulse[0], problem.terms[1].impulse[0] / friction];
        assert!(
            found.iter().all(|found| (found / presses - 1.0).abs() < 0.05),
            "friction {friction}: {found:?} for {presses} N·s"
        );
    }
}
