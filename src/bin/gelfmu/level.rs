//! Choice of a level of `scene.fidelity`, by name or by the wanted accuracy.

use crate::failure::CommandError;
use crate::job;
use crate::options::LevelOptions;
use crate::rounding::rounded;
use crate::source::{self, SceneSource};
use ballistic_gel::scene::{FidelityKind, FidelityLevel, FidelityLevels, Override, Scene, describe_instant};

/// Scene at a level.
pub struct LeveledScene {
    /// Scene with the overrides of the level.
    pub source: SceneSource,
    /// Expected error and cost, if the user chose a level.
    pub expectation: Option<String>,
    /// Name of the folder of a run: that of the scene, and the level if it is not the own level of the scene.
    pub folder_name: String,
}

/// Loads a scene at the level in the options.
pub fn load_at_level(name: &str, set: &[Override], options: &LevelOptions) -> Result<LeveledScene, CommandError> {
    let source = source::load(name, set)?;
    let own_level = own_level(name, set, &source.scene);
    let fidelity = match (options.fidelity, options.accuracy) {
        (None, None) => {
            let folder_name = folder_name(&source.scene, own_level);
            return Ok(LeveledScene { source, expectation: None, folder_name });
        }
        (Some(fidelity), _) => fidelity,
        (None, Some(accuracy)) => cheapest_level(name, &source.scene, accuracy)?,
    };
    let source = source::load(name, &set.iter().cloned().chain([level_override(fidelity)]).collect::<Vec<_>>())?;
    let expected = match source.scene.reduced_class() {
        Some(class) => describe_instant(class),
        None => source.scene.fidelity.get(fidelity).map_or("nothing was measured".to_owned(), describe_expectation),
    };
    let expectation = Some(format!("fidelity {}: {expected}", fidelity.as_str()));
    let folder_name = folder_name(&source.scene, own_level);
    Ok(LeveledScene { source, expectation, folder_name })
}

/// Returns the level of a scene without the override of its level; `None` for a scene that needs this override.
fn own_level(name: &str, set: &[Override], scene: &Scene) -> Option<FidelityKind> {
    let others: Vec<Override> = set.iter().filter(|change| change.key != LEVEL).cloned().collect();
    if others.len() == set.len() {
        Some(scene.scene.fidelity)
    } else {
        source::load(name, &others).ok().map(|source| source.scene.scene.fidelity)
    }
}

/// Returns the name of the folder of a run: two levels of a scene do not refuse each other.
fn folder_name(scene: &Scene, own_level: Option<FidelityKind>) -> String {
    let header = &scene.scene;
    if own_level == Some(header.fidelity) {
        header.name.clone()
    } else {
        format!("{}-{}", header.name, header.fidelity.as_str())
    }
}

/// Key of the level of a scene.
const LEVEL: &str = "scene.fidelity";

/// Doubts about levels that `gelfmu run` refuses, for their mesh or the memory that it needs, without a mesh being
/// built. `at_level` loads the scene at a level.
pub fn refused_levels(
    levels: &FidelityLevels,
    at_level: impl Fn(FidelityKind) -> Result<Scene, CommandError>,
) -> Vec<String> {
    let refusal = |fidelity| match at_level(fidelity) {
        Ok(scene) => job::reserve_for_building(&scene).err().map(|error| error.to_string()),
        Err(error) => Some(error.to_string()),
    };
    let doubt = |(fidelity, _): (FidelityKind, _)| {
        let (level, why) = (fidelity.as_str(), refusal(fidelity)?);
        Some(format!("fidelity.{level}: `gelfmu run --fidelity {level}` will refuse the scene: {why}"))
    };
    levels.known().filter_map(doubt).collect()
}

/// Returns the override that chooses a level.
pub fn level_override(fidelity: FidelityKind) -> Override {
    Override { key: LEVEL.to_owned(), value: fidelity.as_str().to_owned() }
}

/// Level with a known error and cost.
struct KnownLevel {
    fidelity: FidelityKind,
    /// Relative error.
    error: f64,
    /// Element updates.
    updates: f64,
}

/// Returns the cheapest level whose known error does not exceed `accuracy`, a fraction.
fn cheapest_level(name: &str, scene: &Scene, accuracy: f64) -> Result<FidelityKind, CommandError> {
    let refuse = |found: &str, expected: &str| {
        let asked = format!("--accuracy {}%", 100.0 * accuracy);
        Err(CommandError::BadInput(format!("{asked}: found {found}, expected {expected}")))
    };
    let known = scene
        .fidelity
        .known()
        .filter_map(|(fidelity, level)| Some(KnownLevel { fidelity, error: level.error?, updates: level.updates? }));
    let instant =
        scene.instant_error().map(|error| KnownLevel { fidelity: FidelityKind::Instant, error, updates: 0.0 });
    let known: Vec<KnownLevel> = known.chain(instant).collect();
    let Some(best) = known.iter().map(|level| level.error).reduce(f64::min) else {
        let found = format!("scene {name} without a curve that was measured with these values");
        let expected = format!(
            "one with fidelity tables: `python -m ballistic_gel trade {name}` measures them and prints the lines"
        );
        return refuse(&found, &expected);
    };
    let fit = known.iter().filter(|level| level.error <= accuracy).min_by(|a, b| a.updates.total_cmp(&b.updates));
    let least =
        || format!("at least {}%, the best of its curve, or a finer one (trade --finer)", rounded(100.0 * best));
    fit.map_or_else(|| refuse("nothing so accurate", &least()), |level| Ok(level.fidelity))
}

/// Describes the expected error and cost of a level.
pub fn describe_expectation(level: &FidelityLevel) -> String {
    let error = level.error.map(|error| format!("an error of {} %", rounded(100.0 * error)));
    let updates = level.updates.map(|updates| format!("{:.3} million element updates", 1e-6 * updates));
    let seconds = level.cpu_seconds.map(|seconds| format!("{seconds} CPU seconds where it was measured"));
    let all: Vec<String> = error.into_iter().chain(updates).chain(seconds).collect();
    if all.is_empty() {
        "nothing was measured with these values, or for this kind of shot".to_owned()
    } else {
        format!("expect {}", all.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::RunError;
    use ballistic_gel::scene;

    #[test]
    fn a_level_that_a_run_refuses_is_told_with_the_reason() {
        let plain = scene::builtin("sphere-block").unwrap().split("\n[fidelity").next().unwrap();
        let level = |name: &str, size: f64| format!("[fidelity.{name}]\nset = [\"mesh.size={size:?}\"]\n");
        // The ball has a radius of 10 mm, the block a side of 100 mm.
        let levels = [level("draft", 20e-3), level("coarse", 7e-3), level("fine", 3e-3), level("reference", 0.1e-3)];
        let text = format!("{plain}\n{}", levels.concat());
        let at_level = |fidelity| {
            let text = scene::resolve(&text, &[level_override(fidelity)]);
            Ok(text.and_then(|text| scene::read(&text)).map_err(RunError::from)?)
        };
        let refused = refused_levels(&scene::read(&text).unwrap().fidelity, at_level);
        let [draft, reference] = &refused[..] else { panic!("{refused:?}") };
        assert!(draft.starts_with("fidelity.draft: `gelfmu run --fidelity draft` will refuse the scene: "), "{draft}");
        assert!(draft.contains("it would slip through the mesh"), "{draft}");
        assert!(reference.contains("mesh.size: the mesh would have about"), "{reference}");
    }
}
