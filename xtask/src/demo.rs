//! The first thing that somebody new runs: a C program hangs a weight on a chain, and the chain is drawn.

use std::path::Path;
use std::process::Command;

use longspan::Geometry;
use longspan::glam::DVec3;
use longspan_scenes::picture::{Drawn, draw, read_bodies, write_png};

use crate::Outcome;
use crate::compiler::{Language, compile};
use crate::library::{Library, output_folder};
use crate::{printed, samples};

/// Mass of the weight in units of a link's, in each run; the first one is drawn.
const RATIOS: [u32; 2] = [10_000, 1];

/// Pixels.
const PICTURE: (usize, usize) = (480, 960);

/// A body smaller than this share of the scene would not be seen.
const MIN_SHARE: f64 = 1.0 / 60.0;

pub fn run() -> Outcome<()> {
    // Without one nothing here works; say so before minutes of building.
    Language::C99.compiler()?;
    let library = Library::build()?;
    let folder = output_folder("demo")?;
    println!("compiling the C samples");
    for source in samples::sources()? {
        compile(&source, &folder.join(samples::name_of(&source)), Language::C99, &library)?;
    }
    for ratio in RATIOS {
        println!("\n30 links of 1 kg, {ratio} kg below them, 10 s in steps of 1/60 s at default effort:");
        let bodies = folder.join(format!("chain-{ratio}.txt"));
        let mut chain = Command::new(folder.join("chain"));
        print!("{}", printed(chain.arg(ratio.to_string()).arg(bodies))?);
    }
    let picture = folder.join("chain.png");
    draw_chain(&folder.join(format!("chain-{}.txt", RATIOS[0])), &picture)?;
    println!("\npicture of the first one at its end: {}", picture.display());
    Ok(())
}

fn draw_chain(bodies: &Path, picture: &Path) -> Outcome<()> {
    let mut drawn = read_bodies(bodies)?;
    let magnification = visible_at(&drawn);
    if magnification > 1.0 {
        println!("\nthe chain is so long that its bodies are drawn {magnification:.0} times their size, where they are");
        drawn.iter_mut().for_each(|body| magnify(&mut body.geometry, magnification as f32));
    }
    Ok(write_png(picture, &draw(&drawn, PICTURE.0, PICTURE.1))?)
}

/// How much larger than they are the bodies must be drawn for the smallest to be seen.
fn visible_at(bodies: &[Drawn]) -> f64 {
    let finite = bodies.iter().filter(|body| body.pose.position.is_finite());
    let (min, max) = finite.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), body| {
        (min.min(body.pose.position), max.max(body.pose.position))
    });
    let smallest = bodies.iter().map(|body| length(&body.geometry)).fold(f64::INFINITY, f64::min);
    ((max - min).length() * MIN_SHARE / smallest).max(1.0)
}

fn length(geometry: &Geometry) -> f64 {
    f64::from(match geometry {
        Geometry::Box { half_extents } => 2.0 * half_extents.max_element(),
        Geometry::Capsule { half_height, radius } => 2.0 * (half_height + radius),
        _ => f32::INFINITY,
    })
}

fn magnify(geometry: &mut Geometry, factor: f32) {
    match geometry {
        Geometry::Box { half_extents } => *half_extents *= factor,
        Geometry::Capsule { half_height, radius } => {
            *half_height *= factor;
            *radius *= factor;
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use longspan::Pose;
    use longspan::glam::Vec3;

    fn link(y: f64) -> Drawn {
        Drawn {
            geometry: Geometry::Capsule { half_height: 0.08, radius: 0.02 },
            pose: Pose::at_xyz(0.0, y, 0.0),
            color: Vec3::ONE,
        }
    }

    #[test]
    fn a_chain_that_holds_is_drawn_as_it_is_and_one_that_does_not_so_that_it_is_seen() {
        let held: Vec<Drawn> = (0..30).map(|index| link(-0.2 * f64::from(index))).collect();
        assert_eq!(visible_at(&held), 1.0);
        let mut torn: Vec<Drawn> = (0..30).map(|index| link(-20.0 * f64::from(index))).collect();
        let factor = visible_at(&torn);
        torn.iter_mut().for_each(|body| magnify(&mut body.geometry, factor as f32));
        let share = length(&torn[0].geometry) / 580.0;
        assert!((share - MIN_SHARE).abs() < 1e-6, "a link takes {share} of the chain's length, expected {MIN_SHARE}");
    }
}
