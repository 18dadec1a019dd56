//! Scenes as snapshots, for hosts that build none themselves.

use crate::engine::Effort;
use crate::longspan_engine::LongspanEngine;
use crate::run::{RunError, run};
use crate::scene::Scene;

/// Runs a scene to its end on our engine, on one thread, and returns the world as it is then; [`longspan::World::restore`] and
/// `ls_world_restore` read it.
///
/// # Errors
/// If the engine refuses the scene.
pub fn snapshot(scene: Scene) -> Result<Vec<u8>, RunError> {
    let refused = |problem: longspan::Error| RunError::Refused { engine: "longspan", problem: problem.to_string() };
    let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1).map_err(refused)?;
    run(scene, &mut engine, Effort::Default, 1)?;
    let mut bytes = Vec::new();
    engine.world().save(&mut bytes);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use longspan::{World, WorldDef};

    use super::*;
    use crate::DT;
    use crate::catalogue::build;

    #[test]
    fn a_scene_goes_on_in_another_world_to_the_last_bit() {
        // The script of this one adds a ball after 0.1 s, which hits the tower 0.2 s later.
        let keys = |seconds: &str| {
            let given = [("bodies", "120"), ("stand", "0.1"), ("seconds", seconds)];
            given.map(|(key, value)| (key.to_owned(), value.to_owned()))
        };
        let early = snapshot(build("tower", &keys("0.2")).unwrap()).unwrap();
        let late = snapshot(build("tower", &keys("0.5")).unwrap()).unwrap();
        let [mut going_on, mut there] = [(); 2].map(|()| World::new(&WorldDef::default()).unwrap());
        going_on.restore(&early).unwrap();
        for _ in 0..18 {
            going_on.step(DT).unwrap();
        }
        there.restore(&late).unwrap();
        assert_eq!(going_on.state_hash(), there.state_hash());
    }
}
