//! Trust in the figures: doubts in plain words, limits of the model, and the origin of the run.

use super::format::{bullet_list, escape, percent};
use crate::output::scene_digest::scene_digest;
use crate::output::summary::{DriverInterface, RunSummary};
use crate::scene::{self, MaterialModel, Preset, Scene};

/// Sentence of a doubt in plain words, and a part of the doubt by which it is known.
struct PlainDoubt {
    part: &'static str,
    sentence: &'static str,
}

/// Doubts of scenes and runs in plain words.
const PLAIN_DOUBTS: [PlainDoubt; 15] = [
    plain(
        "scene.fidelity is instant",
        "A reduced model gave these figures, which are less accurate than those of finite elements.",
    ),
    plain("cannot yaw in this scene", "The bullet is held straight; a real one turns over and goes less deep."),
    plain(
        "no class of shots whose model error",
        "No measured shot is like this one: how wrong the gel is here is not known.",
    ),
    plain(
        "no model error of shots through layers",
        "No shot through layers was compared with a measurement; their strength is assumed.",
    ),
    plain("any material has", "The projectile is denser than any material."),
    plain("less than the gel has", "The projectile is lighter than gel."),
    plain("points away from the gel", "The projectile flies away from the gel."),
    plain("the temporary cavity of", "The block may be too small for this cavity: its sides may give way."),
    plain("part of the body passes the gel", "Part of the projectile passes beside the gel."),
    plain(
        "waves are reflected where these gels meet",
        "Layer and gel differ in stiffness under pressure, which reflects waves.",
    ),
    plain("acts as a dashpot without its spring", "The gel relaxes faster than a time step can follow."),
    plain("of the library:", "The projectile has values of an older library."),
    plain("supported back face", "The projectile came close to a supported back face, which acts as a wall."),
    plain(
        "not those of an elastic gel",
        "Remeshing has made the elastic gel flow: depth, time and rebound are uncertain.",
    ),
    plain(
        "the numerical method has changed the energy",
        "The numerical method has changed the energy by more than a twentieth.",
    ),
];

const fn plain(part: &'static str, sentence: &'static str) -> PlainDoubt {
    PlainDoubt { part, sentence }
}

/// Returns a doubt as one sentence in plain words; a doubt that is not known stays as it is.
fn plain_sentence(doubt: &str) -> String {
    // A simplified body: the library tells what it leaves out.
    if let Some((_, omitted)) = doubt.split_once("is rigid and homogeneous. ") {
        return format!("The projectile is rigid: {}.", first_sentence(omitted));
    }
    if let Some((_, omitted)) = doubt.split_once("is homogeneous and opens by a law. ") {
        return format!("The projectile opens by a law: {}.", first_sentence(omitted));
    }
    let known = PLAIN_DOUBTS.iter().find(|known| doubt.contains(known.part));
    known.map_or_else(|| format!("{}.", doubt.trim_end_matches('.')), |known| known.sentence.to_owned())
}

/// Returns the first sentence of a text, without its full stop and with a small first letter.
fn first_sentence(text: &str) -> String {
    let sentence = text.split(". ").next().unwrap_or(text).trim_end_matches('.');
    let mut letters = sentence.chars();
    letters.next().map_or(String::new(), |first| first.to_lowercase().chain(letters).collect())
}

/// Returns the doubts about a run in plain words.
pub(super) fn plain_doubts(summary: &RunSummary) -> Vec<String> {
    summary.doubts.iter().map(|doubt| plain_sentence(doubt)).collect()
}

/// Returns the section of trust: doubts, limits, and the folded details.
pub(super) fn trust(scene: &Scene, summary: &RunSummary) -> String {
    let doubts = match &plain_doubts(summary)[..] {
        [] => "<p>No reason to doubt the figures was found.</p>\n".to_owned(),
        sentences => format!("<div class=\"doubts\">{}</div>\n", bullet_list(sentences)),
    };
    format!(
        "<section class=\"trust\"><h2>How far to trust these figures</h2>\n{doubts}<p>{}</p>\n<p>{}</p>\n{}{}</section>\n",
        limits(scene),
        expected_error(summary),
        validity(scene, summary),
        origin(scene, summary)
    )
}

/// Returns the sentences on what the model is validated for, and on what it is not.
pub(super) fn limits(scene: &Scene) -> String {
    let compared = match (scene::shot_class(scene, 0), scene.gel.preset) {
        (Some(class), _) => {
            let class = escape(&class.to_string());
            format!("Model error of the gel, root mean square over shots of this class: {class}.")
        }
        (None, Some(_)) => "The model error of this shot is not known.".to_owned(),
        (None, None) => "The gel is not a preset: nothing is known of its validity.".to_owned(),
    };
    let mut missing = vec![];
    missing.push(match scene.layer.len() {
        0 => "layers, skin or clothing",
        1 => "the layer of this scene, skin or clothing",
        _ => "the layers of this scene, skin or clothing",
    });
    missing.push(match scene.projectile.expansion {
        Some(_) => "petals that break off, and bullets that fragment",
        None => "bullets that deform or fragment",
    });
    missing.push(match (scene.gel.preset, scene.gel.material) {
        (Some(Preset::Gelatin10), MaterialModel::TwoNetwork) => "gels other than 10 % gelatin at 4 °C",
        (Some(Preset::Gelatin10), _) => "penetration with this elastic law, gels other than 10 % gelatin at 4 °C",
        (Some(_), _) => "this gel beyond the data told below",
        (None, _) => "this gel",
    });
    format!("{compared} The model is <strong>not validated for</strong> {}, or animals and people.", missing.join("; "))
}

/// Returns the sentence on the expected error of the figures.
fn expected_error(summary: &RunSummary) -> String {
    let level = summary.fidelity.as_str();
    match summary.errors.expected_error {
        Some(error) => format!(
            "Expected error of the projectile's motion: <strong>{}</strong> at the level <code>{level}</code>, measured \
             against a finer level or the limit of refinement for this shot or one of its kind. It is an error of the \
             discretisation, not of the gel model.",
            percent(error)
        ),
        None => format!(
            "Expected error: not measured for this kind of shot at the level <code>{level}</code> \
             (<code>python -m ballistic_gel trade</code> measures it)."
        ),
    }
}

/// Returns the folded data behind the gel, and the doubts in full.
fn validity(scene: &Scene, summary: &RunSummary) -> String {
    let gel = scene.gel.preset.map_or(String::new(), |preset| {
        let shots = preset.shots();
        format!(
            "<p>The gel <code>{}</code> is fitted to {}. It is validated on {}. The tags stand in \
             <code>docs/materials.md</code>.</p>\n",
            preset.name(),
            escape(shots.fitted),
            escape(shots.validated)
        )
    });
    let doubts = match summary.doubts.len() {
        0 => String::new(),
        _ => format!("<p>The doubts with their keys and remedies:</p>\n{}\n", bullet_list(&summary.doubts)),
    };
    if gel.is_empty() && doubts.is_empty() {
        return String::new();
    }
    format!(
        "<details class=\"validity\"><summary>Data behind the gel, and doubts in full</summary>\n{gel}{doubts}</details>\n"
    )
}

/// Returns the folded origin of the run: version, digests, platform and the command that repeats it.
fn origin(scene: &Scene, summary: &RunSummary) -> String {
    let way = match summary.interface {
        DriverInterface::Fmi2 => "through its FMI 2.0 interface",
        DriverInterface::Direct => "as a library",
    };
    let (system, processor) = (std::env::consts::OS, std::env::consts::ARCH);
    let rows = [
        ("Version", format!("ballistic-gel {}, driven {way}", escape(&summary.version))),
        ("Scene", format!("<code>{}</code> (digest of <code>scene.toml</code>)", scene_digest(scene))),
        ("State at the end", format!("<code>{}</code> (digest)", escape(&summary.digest))),
        ("Platform of this page", format!("{system}, {processor}")),
        ("Files", "figures in <code>summary.json</code> and <code>history.csv</code>; <code>series.pvd</code> opens in ParaView".to_owned()),
    ];
    let rows = rows.map(|(name, text)| format!("<div><dt>{name}</dt><dd>{text}</dd></div>\n")).concat();
    format!(
        "<details class=\"origin\"><summary>Origin, and how to repeat this run</summary>\n<dl class=\"facts\">\n{rows}</dl>\n\
         <p>In the folder of the results,</p>\n<pre>gelfmu run scene.toml --out again</pre>\n<p>repeats this run with version {} \
         and gives the same bits, the digest of the state among them, with any number of threads and on any platform that \
         is supported. A run in which an importer moved or pushed the projectile is repeated by that importer alone.</p>\
         </details>\n",
        escape(&summary.version)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Override, builtin, doubts, read, resolve};

    fn scene_with(changes: &[&str]) -> Scene {
        let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
        read(&resolve(builtin("fbi-bb").unwrap(), &changes).unwrap()).unwrap()
    }

    #[test]
    fn doubts_of_scenes_are_one_plain_sentence_each() {
        let capsule = "projectile.shape={capsule={radius=2.185e-3,length=8e-3}}";
        for changes in [
            &["projectile.mass=0.343"][..],
            &["projectile.mass=4e-5"],
            &["projectile.velocity=[0, 0, 179.8]"],
            &["projectile.velocity=[0, 0, -1300]"],
            &[capsule, "projectile.position=[0, 0, 0.004]"],
            &["layer=[{thickness=2e-3, strength_scale=3.0}]"],
            &["layer=[{thickness=2e-3, preset='gelatin-20'}]"],
        ] {
            let found = doubts(&scene_with(changes));
            assert!(!found.is_empty(), "{changes:?}");
            for doubt in found {
                let sentence = plain_sentence(&doubt);
                assert!(sentence.len() < 100 && !sentence.contains("projectile."), "{sentence}");
            }
        }
    }

    #[test]
    fn a_simplified_body_is_told_by_its_first_omission_and_an_unknown_doubt_stays() {
        let told = "projectile is rigid and homogeneous. The core is not modelled. The jacket neither";
        assert_eq!(plain_sentence(told), "The projectile is rigid: the core is not modelled.");
        assert_eq!(plain_sentence("gel.density is odd"), "gel.density is odd.");
    }

    #[test]
    fn limits_name_what_the_scene_has() {
        let limits_with = |changes: &[&str]| limits(&scene_with(changes));
        let bare = limits_with(&[]);
        assert!(bare.contains("layers, skin or clothing") && bare.contains("animals and people"), "{bare}");
        assert!(bare.contains("steel balls"), "{bare}");
        let skin = limits_with(&["layer=[{thickness=2e-3, strength_scale=3.0}]"]);
        assert!(skin.contains("the layer of this scene") && skin.contains("not known"), "{skin}");
        assert!(limits_with(&["gel.preset=gelatin-20"]).contains("this gel beyond"));
    }
}
