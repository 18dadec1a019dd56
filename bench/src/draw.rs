//! Pictures of scenes and of bodies that another program wrote down.

use std::path::Path;

use longspan::BodyDef;
use longspan_scenes::picture::{self, Drawn};
use longspan_scenes::{Effort, LongspanEngine, build, run_watched};

use crate::args::Picture;

type Problem = Box<dyn std::error::Error>;

/// Runs a scene on our engine and draws its end.
pub fn picture(options: &Picture) -> Result<(), Problem> {
    let scene = build(&options.chosen.scene, &options.chosen.keys())?;
    let unseen = scene.unseen.clone();
    let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1)?;
    let mut drawn = Vec::new();
    run_watched(scene, &mut engine, Effort::Default, 1, &mut |view| {
        if view.at_end() {
            let present = view.bodies.iter().enumerate().filter(|(body, _)| view.alive[*body] && !unseen.contains(body));
            let bodies: Vec<(usize, &BodyDef)> = present.collect();
            drawn = picture::of_engine(view.engine, &bodies);
        }
    })?;
    save(&drawn, &options.out, options.size)
}

/// Draws the bodies of a text file.
pub fn draw_file(file: &Path, out: &Path, size: (usize, usize)) -> Result<(), Problem> {
    save(&picture::read_bodies(file)?, out, size)
}

fn save(drawn: &[Drawn], out: &Path, (width, height): (usize, usize)) -> Result<(), Problem> {
    Ok(picture::write_png(out, &picture::draw(drawn, width, height))?)
}
