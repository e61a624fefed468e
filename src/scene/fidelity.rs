//! Fidelity levels: overrides that trade accuracy for speed, and the measured error and cost of each level.

use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Accuracy level of a run, and with it the cost. `standard` is the scene without overrides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum FidelityKind {
    /// Cheapest level.
    Draft,
    /// Level between `draft` and `standard`.
    Coarse,
    /// Scene without overrides.
    #[default]
    Standard,
    /// Level between `standard` and `reference`.
    Fine,
    /// Most accurate level that was measured.
    Reference,
    /// Reduced model, which answers in milliseconds, of the shots for which it is identified.
    Instant,
}

/// Overrides and figures of the levels of `scene.fidelity`; `python -m ballistic_gel trade` measures the figures and
/// prints this table.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct FidelityLevels {
    /// Level 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub draft: Option<FidelityLevel>,
    /// Level 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coarse: Option<FidelityLevel>,
    /// Level 2, which sets nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard: Option<FidelityLevel>,
    /// Level 3.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fine: Option<FidelityLevel>,
    /// Level 4.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<FidelityLevel>,
}

/// Fidelity level: overrides, expected error and expected cost. The figures hold for the unmodified scene. An
/// override of the scene removes the figures, and the level's own setting of the same key.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct FidelityLevel {
    /// Overrides that the level writes over the scene, such as "mesh.size=2e-3".
    pub set: Vec<String>,
    /// Greatest relative error of the projectile's motion, from the limit of refinement or a finer level.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Element updates of a run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub updates: Option<f64>,
    /// CPU time of a run on one thread of the machine that measured it, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cpu_seconds: Option<f64>,
}

impl FidelityKind {
    /// All levels of the mesh, from the cheapest to the most accurate.
    pub const ALL: [Self; 5] = [Self::Draft, Self::Coarse, Self::Standard, Self::Fine, Self::Reference];

    /// All levels, with the reduced model as the last: their places are the numbers of the levels.
    pub const WITH_INSTANT: [Self; 6] =
        [Self::Draft, Self::Coarse, Self::Standard, Self::Fine, Self::Reference, Self::Instant];

    /// Name of the level in a scene file.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Coarse => "coarse",
            Self::Standard => "standard",
            Self::Fine => "fine",
            Self::Reference => "reference",
            Self::Instant => "instant",
        }
    }
}

impl FromStr for FidelityKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::WITH_INSTANT.into_iter().enumerate();
        let found = known.into_iter().find(|(number, level)| level.as_str() == text || number.to_string() == text);
        let expected =
            || "expected draft, coarse, standard, fine, reference or instant, or their numbers, 0 to 5".to_owned();
        found.map(|(_, level)| level).ok_or_else(expected)
    }
}

impl FidelityLevels {
    /// Overrides and figures of a level, if the scene has them.
    #[must_use]
    pub fn get(&self, fidelity: FidelityKind) -> Option<&FidelityLevel> {
        match fidelity {
            FidelityKind::Draft => self.draft.as_ref(),
            FidelityKind::Coarse => self.coarse.as_ref(),
            FidelityKind::Standard => self.standard.as_ref(),
            FidelityKind::Fine => self.fine.as_ref(),
            FidelityKind::Reference => self.reference.as_ref(),
            FidelityKind::Instant => None,
        }
    }

    /// Levels that the scene has, from the cheapest to the most accurate.
    pub fn known(&self) -> impl Iterator<Item = (FidelityKind, &FidelityLevel)> {
        FidelityKind::ALL.into_iter().filter_map(|fidelity| Some((fidelity, self.get(fidelity)?)))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.known().next().is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::FidelityKind;
    use crate::scene::{Override, Scene, SceneError, builtin, builtins, read, rebase_scene, resolve};

    /// Scatter of the rest depth of `fbi-bb`, 0.5 of 85 mm (docs/studies.md): no level promises less.
    const SCATTER: f64 = 0.0059;
    const LEVELS: &str =
        "\n[fidelity.draft]\nset = [\"mesh.size=10e-3\", \"integrator.cfl=1.0\"]\nerror = 0.05\nupdates = 1e6\n";

    fn text() -> String {
        let plain = builtin("sphere-block").unwrap();
        plain.split("\n[fidelity").next().unwrap().to_owned() + LEVELS
    }

    fn with(set: &[&str]) -> Result<Scene, SceneError> {
        let overrides: Vec<Override> = set.iter().map(|set| set.parse().unwrap()).collect();
        read(&resolve(&text(), &overrides)?)
    }

    #[test]
    fn a_level_is_written_over_the_scene_and_an_override_over_both() {
        let size_and_cfl = |set: &[&str]| with(set).map(|scene| (scene.mesh.size, scene.integrator.cfl())).unwrap();
        assert_eq!(size_and_cfl(&[]), (5e-3, 0.8));
        assert_eq!(size_and_cfl(&["scene.fidelity=draft"]), (10e-3, 1.0));
        for set in [["scene.fidelity=draft", "mesh.size=4e-3"], ["mesh.size=4e-3", "scene.fidelity=draft"]] {
            assert_eq!(size_and_cfl(&set), (4e-3, 1.0));
        }
    }

    #[test]
    fn a_level_of_which_overrides_left_nothing_is_refused_in_words() {
        let emptied = ["scene.fidelity=draft", "mesh.size=4e-3", "integrator.cfl=0.5"];
        let refused = with(&emptied).unwrap_err();
        assert!(refused.to_string().contains("\"draft\", which sets nothing"), "{refused}");
        assert!(with(&emptied[1..]).is_ok() && with(&emptied[..2]).is_ok());
    }

    #[test]
    fn a_level_of_a_rebased_scene_sets_what_it_did_and_promises_nothing() {
        let rebased = |set: &[&str], then: &[&str]| {
            let parsed = |set: &[&str]| set.iter().map(|set| set.parse().unwrap()).collect::<Vec<Override>>();
            let text = rebase_scene(&text(), &parsed(set)).and_then(|text| resolve(&text, &parsed(then)));
            text.and_then(|text| read(&text)).unwrap()
        };
        let size = |set: &[&str], then: &[&str]| rebased(set, then).mesh.size;
        let set = ["mesh.size=4e-3"];
        assert_eq!([size(&set, &[]), size(&set, &["scene.fidelity=draft"])], [4e-3, 10e-3]);
        assert_eq!(rebased(&set, &[]).fidelity.draft.unwrap().error, None);
        assert_eq!(rebased(&["output.frames=1"], &[]).fidelity.draft.unwrap().error, Some(0.05));
        assert_eq!(size(&["scene.fidelity=draft", "mesh.size=4e-3"], &[]), 4e-3, "the override is the stronger");
        let of_draft = text().replace("[scene]", "[scene]\nfidelity = \"draft\"");
        let text = rebase_scene(&of_draft, &["mesh.size=4e-3".parse().unwrap()]).unwrap();
        assert_eq!(read(&text).unwrap().mesh.size, 4e-3);
    }

    #[test]
    fn measured_figures_hold_for_the_unmodified_scene_only() {
        let error = |set: &[&str]| with(set).unwrap().fidelity.draft.unwrap().error;
        assert_eq!(error(&["scene.fidelity=draft", "output.frames=1", "scene.communication_step=1e-5"]), Some(0.05));
        assert_eq!(error(&["projectile.velocity=[0, 0, -4]"]), None);
    }

    #[test]
    fn a_level_that_is_not_there_or_does_not_fit_is_refused_with_its_key() {
        let refused = |set: &[&str]| with(set).unwrap_err();
        let unknown = refused(&["scene.fidelity=fine"]);
        assert!(unknown.line.is_some() && unknown.to_string().contains("python -m ballistic_gel trade"), "{unknown}");
        assert_eq!(unknown.key, "scene.fidelity");
        for set in ["mesh.size=-1", "mesh", "mesh.siez=1"] {
            let misfit = refused(&["scene.fidelity=draft", &format!("fidelity.draft.set=[{set:?}]")]);
            assert_eq!(misfit.key, "fidelity.draft.set");
            assert!(misfit.to_string().contains(set), "{misfit}");
        }
        let standard = refused(&["fidelity.standard.set=[\"mesh.size=1e-3\"]"]);
        assert_eq!(standard.key, "fidelity.standard.set");
    }

    #[test]
    fn a_level_whose_cells_a_layer_does_not_hold_is_refused_with_its_size() {
        let layer = "layer=[{thickness=6e-3, density=900.0}]";
        assert!(with(&[layer]).is_ok());
        let refused = with(&[layer, "scene.fidelity=draft"]).unwrap_err();
        assert_eq!(refused.key, "fidelity.draft.set");
        let told = "(layer[1].thickness: found 0.006, expected at least mesh.size, 0.01 m: ";
        assert!(refused.to_string().contains(told), "{refused}");
    }

    #[test]
    fn the_levels_of_builtin_scenes_are_scenes_that_cost_more_and_miss_by_less_down_to_the_scatter() {
        for (name, text) in builtins() {
            let levels = read(text).unwrap().fidelity;
            let known: Vec<_> =
                levels.known().map(|(_, level)| (level.updates.unwrap(), level.error.unwrap())).collect();
            let is_better = |pair: &[(f64, f64)]| pair[0].1 > pair[1].1 || pair[0].1 == SCATTER;
            assert!(known.windows(2).all(|pair| pair[0].0 < pair[1].0 && is_better(pair)), "{name}: {known:?}");
            for (fidelity, _) in levels.known() {
                let choice: Override = format!("scene.fidelity={}", fidelity.as_str()).parse().unwrap();
                let read = resolve(text, &[choice]).and_then(|text| read(&text));
                assert_eq!(read.map(|scene| scene.scene.fidelity), Ok(fidelity), "{name}");
            }
        }
    }

    #[test]
    fn a_level_has_a_name_and_a_number() {
        for (number, level) in FidelityKind::WITH_INSTANT.into_iter().enumerate() {
            assert_eq!([level.as_str().parse(), number.to_string().parse()], [Ok(level), Ok(level)]);
        }
        assert!("6".parse::<FidelityKind>().is_err());
    }
}
