//! State of a breakable joint: its load over the last window, and its damage.
//!
//! The window is kept as [`SPANS`] stretches of time with the impulse each has brought. Each but the newest is at least an eighth of
//! the window long, so that they cover it; short steps share one. Of the oldest stretch the part inside the window counts.

use glam::Vec3;

use super::{BreakLimit, JointLoad, Strength};

/// Stretches of time that a window is kept in.
const SPANS: usize = 9;

/// What steps that should add up to an eighth of the window may fall short of it.
const ROUNDING: f32 = 1.0e-4;

/// Halvings by which the part of a step is found after which a joint breaks: to a millionth.
const HALVINGS: u32 = 20;

/// Impulse of a stretch of time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ImpulseSpan {
    /// Its length (s).
    pub time: f32,
    /// Of the force (N·s).
    pub linear: Vec3,
    /// Of the torque (N·m·s).
    pub angular: Vec3,
}

/// What a joint that can break remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Strain {
    /// The last stretches of time, newest first.
    pub spans: [ImpulseSpan; SPANS],
    /// How worn it is, 0 to 1.
    pub damage: f32,
    /// Whether it has passed a limit and is to break in the next step.
    pub condemned: bool,
}

/// What a step's load means to a joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judgement {
    /// Mean over the window.
    pub load: JointLoad,
    pub share: f32,
    pub limit: BreakLimit,
    /// Damage at the end of the step.
    pub damage: f32,
}

impl Judgement {
    pub(crate) fn breaks(&self) -> bool {
        self.share > 1.0 || self.damage >= 1.0
    }
}

impl Strain {
    /// Mean over the window that ends now.
    pub(crate) fn present(&self, strength: &Strength) -> JointLoad {
        self.mean(strength.window, 0.0, &JointLoad::default())
    }

    /// Whether its present load wears it out or is past a limit.
    pub(crate) fn is_at_work(&self, strength: &Strength) -> bool {
        let (share, _) = strength.share(&self.present(strength));
        share > strength.damage.map_or(1.0, |damage| damage.from)
    }

    /// What this load over the next `dt` (s) will make of the joint.
    pub(crate) fn judge(&self, strength: &Strength, load: &JointLoad, dt: f32) -> Judgement {
        let load = self.mean(strength.window, dt, load);
        let (share, limit) = strength.share(&load);
        Judgement { load, share, limit, damage: self.damage_after(strength, share, dt) }
    }

    /// Notes the load of a step.
    pub(crate) fn note(&mut self, strength: &Strength, load: &JointLoad, dt: f32) {
        self.damage = self.judge(strength, load, dt).damage;
        let step = ImpulseSpan { time: dt, linear: load.force * dt, angular: load.torque * dt };
        let newest = &mut self.spans[0];
        if newest.time * (SPANS - 1) as f32 <= strength.window * (1.0 - ROUNDING) {
            newest.time += dt;
            newest.linear += step.linear;
            newest.angular += step.angular;
        } else {
            self.spans.rotate_right(1);
            self.spans[0] = step;
        }
    }

    /// The part of a step, 0 to 1, after which this load takes the joint to its limit; 1 if it does not.
    pub(crate) fn part_borne(&self, strength: &Strength, load: &JointLoad, dt: f32) -> f32 {
        let share = |part: f32| {
            let load = JointLoad { force: load.force * part, torque: load.torque * part };
            strength.share(&self.mean(strength.window, dt, &load)).0
        };
        if share(1.0) <= 1.0 {
            return 1.0;
        }
        let (mut borne, mut broken) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (borne + broken);
            if share(middle) <= 1.0 { borne = middle } else { broken = middle }
        }
        borne
    }

    /// Mean over the window that ends with `dt` (s) of this load. A step longer than the window is the window.
    fn mean(&self, window: f32, dt: f32, load: &JointLoad) -> JointLoad {
        let (mut linear, mut angular) = (load.force * dt, load.torque * dt);
        let mut left = window - dt;
        for span in &self.spans {
            if left <= 0.0 || span.time <= 0.0 {
                break;
            }
            let part = (left / span.time).min(1.0);
            linear += span.linear * part;
            angular += span.angular * part;
            left -= span.time;
        }
        let time = window.max(dt);
        JointLoad { force: linear / time, torque: angular / time }
    }

    fn damage_after(&self, strength: &Strength, share: f32, dt: f32) -> f32 {
        let Some(damage) = &strength.damage else { return 0.0 };
        let kept = self.damage * libm::exp2f(-dt / damage.half_life);
        let grown = (share - damage.from).max(0.0) / (1.0 - damage.from) * dt / damage.time;
        (kept + grown).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Damage;
    use super::*;

    const WINDOW: f32 = 0.1;

    fn strength(tension: f32) -> Strength {
        Strength { tension, window: WINDOW, ..Strength::UNBREAKABLE }
    }

    fn pull(force: f32) -> JointLoad {
        JointLoad { force: Vec3::new(-force, 0.0, 0.0), torque: Vec3::ZERO }
    }

    /// The greatest share over a second in which the force is `force(time)`, in `steps` steps.
    fn greatest_share(steps: u32, impulse: impl Fn(f32, f32) -> f32) -> f32 {
        let (dt, strength) = (1.0 / steps as f32, strength(1.0));
        let mut strain = Strain::default();
        let mut greatest = 0.0_f32;
        for step in 0..steps {
            let load = pull(impulse(step as f32 * dt, (step + 1) as f32 * dt) / dt);
            greatest = greatest.max(strain.judge(&strength, &load, dt).share);
            strain.note(&strength, &load, dt);
        }
        greatest
    }

    #[test]
    fn a_steady_load_counts_as_itself_and_a_blow_as_its_impulse_over_the_window_at_any_step() {
        for steps in [10, 20, 30, 60, 77, 120, 240, 1000] {
            let steady = greatest_share(steps, |from, to| 3.0 * (to - from));
            assert!((steady - 3.0).abs() < 1e-4, "a load of 3 N counts as {steady} at {steps} steps a second");
            let blow = greatest_share(steps, |from, to| if (from..to).contains(&0.5) { 0.2 } else { 0.0 });
            assert!((blow - 2.0).abs() < 1e-4, "0.2 N·s in 0.1 s counts as {blow} at {steps} steps a second");
        }
    }

    #[test]
    fn what_is_mended_within_the_window_counts_as_nothing() {
        let noise =
            greatest_share(240, |from, to| if ((from * 240.0).round() as u32).is_multiple_of(2) { to - from } else { from - to });
        assert!(noise <= 0.05, "an alternating load of 1 N counts as {noise}");
    }

    #[test]
    fn the_part_borne_takes_the_joint_to_its_limit() {
        let (strength, dt) = (strength(1.0), 0.025);
        let mut strain = Strain::default();
        for _ in 0..4 {
            strain.note(&strength, &pull(0.8), dt);
        }
        // Three quarters of the window at 0.8 N and the rest of 1 N over the whole: 0.4 N·s/0.1 s = 1 N − 0.6 N.
        let part = strain.part_borne(&strength, &pull(8.0), dt);
        assert!((part - 0.2).abs() < 1e-5, "{part}");
        assert_eq!(strain.part_borne(&strength, &pull(0.5), dt), 1.0);
    }

    #[test]
    fn a_joint_at_its_limit_is_worn_out_in_the_time_given_and_rests_in_its_half_life() {
        let damage = Damage { from: 0.5, time: 2.0, half_life: f32::INFINITY };
        let strength = Strength { damage: Some(damage), ..strength(1.0) };
        let run = |force: f32, seconds: f32| {
            let mut strain = Strain::default();
            for _ in 0..(seconds * 100.0) as u32 {
                strain.note(&strength, &pull(force), 0.01);
            }
            strain.damage
        };
        // Half, but for what the window lacks while it fills in the first tenth of a second: nothing counts up to half the limit,
        // and half of the rest from there on.
        let (full, part) = (0.5 - 0.075 / 2.0, 0.5 - (0.1 / 1.5 + 0.05 / 3.0) / 4.0);
        assert!((run(1.0, 1.0) - full).abs() < 0.005, "{} instead of {full}", run(1.0, 1.0));
        assert!((run(0.75, 2.0) - part).abs() < 0.005, "{} instead of {part}", run(0.75, 2.0));
        assert_eq!(run(0.5, 10.0), 0.0);
        let resting = Strength { damage: Some(Damage { half_life: 1.0, ..damage }), ..strength };
        let mut strain = Strain { damage: 0.8, ..Strain::default() };
        for _ in 0..100 {
            strain.note(&resting, &pull(0.0), 0.01);
        }
        assert!((strain.damage - 0.4).abs() < 1e-4, "{}", strain.damage);
    }
}
