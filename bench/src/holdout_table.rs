//! What scenes keep of their promises at numbers that nothing was tuned for, as a table.

use longspan_scenes::promises::{AT, CONTACTS, HOLDOUTS, Holdout, JOINTS, Kept, Promise, has_key, judge};

use crate::line::short;

type Problem = Box<dyn std::error::Error>;

/// Prints one line for each scene and value of a key as soon as it has run, of those scenes whose name contains `of`: by rate and size the
/// greatest share that an error is of its bound, then which error that is.
pub fn print(of: &str) -> Result<(), Problem> {
    let rates: Vec<&str> = AT.iter().map(|(name, _)| *name).collect();
    println!("| scene | {} | worst |", rates.join(" | "));
    println!("|---|{}---|", "---|".repeat(rates.len()));
    for &(scene, key, values) in HOLDOUTS.iter().filter(|(scene, ..)| scene.contains(of)) {
        print_scene((scene, key, values))?;
    }
    Ok(())
}

fn print_scene((scene, key, values): Holdout) -> Result<(), Problem> {
    let promise = promise_of(scene)?;
    let has_rate = has_key(scene, "rate")?;
    for value in values {
        let mut cells = Vec::new();
        let mut worst: Option<Kept> = None;
        for (_, keys) in AT {
            if keys.iter().any(|(key, _)| *key == "rate") && !has_rate {
                cells.push("–".to_owned());
                continue;
            }
            let with: Vec<_> = keys.iter().copied().chain([(key, *value)]).collect();
            let kept = judge(promise, &with)?;
            cells.push(share(kept.share));
            worst = worst.filter(|worst| worst.share >= kept.share).or(Some(kept));
        }
        let told = worst.map(|worst| format!("{} {}", worst.error, short(worst.found))).unwrap_or_default();
        println!("| `{scene} {key}={value}` | {} | {told} |", cells.join(" | "));
    }
    Ok(())
}

fn promise_of(scene: &str) -> Result<Promise, Problem> {
    let found = JOINTS.iter().chain(CONTACTS).find(|(name, _)| *name == scene);
    found.copied().ok_or_else(|| format!("{scene} promises nothing").into())
}

/// A share of a bound, in bold where it is more than all of it.
fn share(share: f64) -> String {
    if share > 1.0 { format!("**{share:.1}**") } else { format!("{share:.2}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_holdout_has_a_promise_and_its_key() {
        for &(scene, key, values) in HOLDOUTS {
            assert!(promise_of(scene).is_ok() && has_key(scene, key).unwrap() && !values.is_empty(), "{scene} {key}");
        }
    }

    #[test]
    fn what_is_more_than_its_bound_is_bold() {
        assert_eq!((share(0.25), share(1.5)), ("0.25".to_owned(), "**1.5**".to_owned()));
    }
}
