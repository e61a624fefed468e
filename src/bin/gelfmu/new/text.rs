//! Scene text of a shot.

use super::arrival_text;
use super::block::MeshedPart;
use super::layer::network_value;
use super::level_errors::LevelErrors;
use super::shot::{Shot, USUAL_YAW};
use super::sizes::{LevelSizes, STANDARD};
use crate::failure::CommandError;
use crate::rounding::rounded;
use ballistic_gel::geometry::SignedDistance;
use ballistic_gel::math::Vector3;
use ballistic_gel::output::scene_file_reader;
use ballistic_gel::scene::{self, LIBRARY_VERSION, Preset, ProjectileKind, Scene, SceneError};
use nalgebra::{Quaternion, UnitQuaternion};
use std::fmt::Write;
use std::path::Path;

/// Least speed of the wave of a reduced bulk modulus, m/s: that of `fbi-bb`, with which the gel stays nearly
/// incompressible beside its shear moduli.
const LEAST_WAVE: f64 = 800.0;
/// Ratio of wave speed to impact speed from which compressibility changes the stagnation pressure by 2 % at most: that
/// of `fbi-bb`.
const WAVE_RATIO: f64 = 4.45;
/// Time after the estimated stop in which the gel pushes the projectile back and the cavity closes, s.
const RELAXATION: f64 = 6e-3;
/// Relaxation about an axis, s, where it costs little: the calibration shot still moves by 0.2 mm in a millisecond after 6 ms.
const RELAXATION_ABOUT_AXIS: f64 = 12e-3;
/// Time after the longest path for a projectile that yaws, s: it stops much earlier.
const MARGIN: f64 = 3e-3;

/// Complete, commented scene of a shot.
pub fn scene_text(shot: &Shot) -> Result<String, CommandError> {
    // The body is put above the gel first, then down onto it by the reach of its foremost point.
    let far = 10.0 * (shot.radius() + shot.block.length);
    let provisional = text_at(shot, far);
    let bad_scene = |error| CommandError::BadInput(format!("the shot makes no scene: {error}"));
    let scene = read_scene(&provisional).map_err(bad_scene)?;
    let [w, x, y, z] = shot.orientation();
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let reach = scene.shape(0).reach(&turn.inverse_transform_vector(&-Vector3::z()));
    let text = text_at(shot, reach) + &model_error(&scene);
    read_scene(&text).map_err(bad_scene)?;
    Ok(text)
}

/// Reads the scene of a shot; the file of a body is named from any folder.
pub fn read_scene(text: &str) -> Result<Scene, SceneError> {
    scene::read_with_files(text, &scene_file_reader(Path::new("")))
}

/// Comment on the model error of the gel for shots like this one.
fn model_error(scene: &Scene) -> String {
    let class = scene::shot_class(scene, 0);
    let told = class.map_or("not known for this kind of shot".to_owned(), |class| {
        format!("root mean square over shots of this class: {class}")
    });
    format!("\n# Model error of the gel, beside the errors of the levels: {told}.\n")
}

/// Scene text with the centre of mass at this height above the gel, m.
fn text_at(shot: &Shot, height: f64) -> String {
    let sizes = LevelSizes::of(shot);
    [
        header(shot),
        gel(shot) + &layers(shot),
        projectile(shot, height),
        mesh(shot, &sizes[STANDARD]),
        output(shot),
        levels(shot, &sizes),
    ]
    .join("\n")
}

fn header(shot: &Shot) -> String {
    let Shot { projectile, speed, block, .. } = shot;
    let dimension = if shot.meshed_part() == MeshedPart::Meridian { "axisymmetric" } else { "spatial" };
    let yaw = if shot.yaw == 0.0 { String::new() } else { format!(" with {}° of yaw", shot.shown_yaw()) };
    let behind = shot.arrival.as_ref().map_or_else(String::new, |arrival| format!(", out of {}", arrival.scene));
    let origin = shot.arrival.as_ref().map_or_else(String::new, arrival_text::origin);
    let title = format!(
        "{}: {} m/s{yaw} into {}{}{behind}",
        projectile.title,
        rounded(*speed),
        layers_told(shot),
        gel_name(shot.gel)
    );
    let path = format!("{:.0} mm", 1e3 * shot.longest_path());
    let fate = if shot.longest_path() > block.length { "may leave the block" } else { "should stay in the block" };
    let not_modelled =
        projectile.not_modelled.as_ref().map(|text| format!("# Not modelled: {text}\n")).unwrap_or_default();
    let EndTime { reason, time: end_time } = end_time(shot);
    format!(
        "# Written by `gelfmu new`. Numbers are SI (m, kg, s, Pa), angles in degrees; \"9.02 mm\" and \"124 gr\" are read, too.\n\
         # By Poncelet's law a sphere of this calibre and mass comes to rest after {path} of 10 % gelatin: it {fate}.\n\
         # A bullet that turns over stops earlier.\n{origin}{not_modelled}\
         \n[scene]\nname = \"{}\"\ntitle = \"{title}\"\ndimension = \"{dimension}\"\n\
         # {reason} After an exit the run ends earlier.\n\
         end_time = {end_time:?}\n\
         # The run ends when projectile and cavity stand still; without this line it goes on to the end time.\n\
         stop_at_rest = true\n\
         # The projectile flies about its radius in it.\n\
         communication_step = {:?}\n\
         # fidelity = \"draft\" # or coarse, standard, fine; or `gelfmu run FILE --fidelity draft`\n",
        name(shot),
        communication_step(shot.radius() / speed)
    )
}

/// Layers in front of the gel, in a title.
fn layers_told(shot: &Shot) -> String {
    match shot.layers.len() {
        0 => String::new(),
        1 => "a layer and ".to_owned(),
        n => format!("{n} layers and "),
    }
}

/// Name of the scene: projectile and speed, and yaw, roll, gel and layers where they are not the usual ones; or the run
/// whose gel the projectile has left.
fn name(shot: &Shot) -> String {
    if let Some(arrival) = &shot.arrival {
        return format!("{}-exit", arrival.scene);
    }
    let mut name = format!("{}-{:.0}", shot.projectile.name, shot.speed);
    let usual = if shot.projectile.kind == ProjectileKind::Service { USUAL_YAW } else { 0.0 };
    let parts = [("yaw", shot.yaw, usual), ("roll", shot.roll, 0.0)];
    for (part, value, _) in parts.iter().filter(|(_, value, usual)| value != usual) {
        write!(name, "-{part}{value}").expect("a string grows");
    }
    if shot.gel != Preset::Gelatin10 {
        write!(name, "-{}", shot.gel.name()).expect("a string grows");
    }
    if !shot.layers.is_empty() {
        name.push_str("-layered");
    }
    name.replace('.', "_")
}

/// End of a run.
struct EndTime {
    /// Sentence with the reason.
    reason: String,
    /// Time, s.
    time: f64,
}

/// End of the run of a shot.
fn end_time(shot: &Shot) -> EndTime {
    let bodies = shot.arrival.iter().flat_map(|arrival| &arrival.bodies);
    let delay = bodies.map(|body| body.delay).fold(0.0, f64::max);
    if shot.yaw == 0.0 {
        let is_axial = shot.meshed_part() == MeshedPart::Meridian;
        let relaxation = if is_axial { RELAXATION_ABOUT_AXIS } else { RELAXATION };
        let reason =
            format!("One and a half times the time of that path, and {:.0} ms to come to rest.", 1e3 * relaxation);
        EndTime { reason, time: rounded(delay + 1.5 * shot.longest_time() + relaxation) }
    } else {
        let reason =
            format!("The time of that path, and {:.0} ms: a projectile that yaws stops earlier.", 1e3 * MARGIN);
        EndTime { reason, time: rounded(delay + shot.longest_time() + MARGIN) }
    }
}

/// Greatest of 1, 2 and 5 times a power of ten that is not above a time, s.
fn communication_step(time: f64) -> f64 {
    let decade = 10_f64.powf(time.log10().floor());
    let digit = [5.0, 2.0, 1.0].into_iter().find(|digit| digit * decade <= time).unwrap_or(1.0);
    rounded(digit * decade)
}

fn gel_name(gel: Preset) -> &'static str {
    match gel {
        Preset::Gelatin10 => "10 % gelatin",
        Preset::Gelatin20 => "20 % gelatin",
        Preset::SyntheticClear => "clear synthetic gel",
    }
}

fn gel(shot: &Shot) -> String {
    let length = shot.block.length;
    let shape = match shot.meshed_part() {
        MeshedPart::Meridian => format!(
            "# The cylinder with the cross-section of the block.\nshape.cylinder = {{ radius = {:?}, height = {length:?} }}\n",
            rounded(shot.block.equivalent_radius())
        ),
        part => {
            let symmetry = match part {
                MeshedPart::Quarter => {
                    "# A quarter of the block, between two planes of symmetry.\nsymmetry = \"quarter\"\n"
                }
                MeshedPart::Half => {
                    "# Half of the block: the plane of the yaw is a plane of symmetry.\nsymmetry = \"half\"\n"
                }
                MeshedPart::Meridian | MeshedPart::Whole => "",
            };
            format!("shape.block.size = {:?}\n{symmetry}", shot.block_in_scene())
        }
    };
    format!(
        "[gel]\n{shape}# Its values and their sources: `gelfmu check FILE`.\npreset = \"{}\"\n{}\
         # Air flows into the cavity through its openings; without this line it is vented at once.\n\
         cavity = {{ inflow = {{ discharge = 0.61 }} }}\n\
         # No supports: the back face is free, and the projectile may leave there.\n",
        shot.gel.name(),
        bulk_modulus(shot)
    )
}

/// Tables of the layers in front of the gel.
fn layers(shot: &Shot) -> String {
    let ratio = ReducedBulk::of(shot).map_or(1.0, |bulk| bulk.enough / bulk.own);
    let tables: String = shot.layers.iter().map(|layer| layer.table(ratio)).collect();
    let comment = "\n# Layers on the front of the gel, bonded: their thickness is a part of the length of the block.";
    if tables.is_empty() { tables } else { format!("{comment}{tables}") }
}

/// Bulk modulus of a slow shot, less than that of the preset: it saves steps.
struct ReducedBulk {
    /// Speed of its wave, m/s.
    wave: f64,
    /// Bulk modulus, Pa.
    enough: f64,
    /// Bulk modulus of the preset, Pa.
    own: f64,
}

impl ReducedBulk {
    /// Bulk modulus of a shot; `None` for a fast one.
    fn of(shot: &Shot) -> Option<Self> {
        let [own, density] = ["gel.bulk_modulus", "gel.density"].map(|key| network_value(shot.gel, key));
        let (own, density) = (own?, density?);
        let wave = (WAVE_RATIO * shot.speed).max(LEAST_WAVE);
        let enough = rounded(density * wave * wave);
        (enough < own).then_some(Self { wave, enough, own })
    }
}

/// Bulk modulus of a slow shot, less than that of the preset: it saves steps.
fn bulk_modulus(shot: &Shot) -> String {
    let Some(ReducedBulk { wave, enough, own }) = ReducedBulk::of(shot) else { return String::new() };
    format!(
        "# That of a wave of {wave:.0} m/s: the projectile is at Mach {:.2} with it (0.22 in `fbi-bb`), which saves steps.\n\
         # Without this line it is the {own:?} Pa of the preset.\nbulk_modulus = {enough:?}\n",
        shot.speed / wave
    )
}

fn projectile(shot: &Shot, height: f64) -> String {
    if let Some(arrival) = &shot.arrival {
        return arrival_text::bodies(arrival);
    }
    let values: String = shot.projectile.values().iter().map(arrival_text::commented).collect();
    let [w, x, y, z] = shot.orientation();
    let orientation = if [x, y, z] == [0.0; 3] {
        String::new()
    } else {
        let roll = if z == 0.0 { String::new() } else { format!(", turned by {}° about the path", shot.roll) };
        format!("# {}° of yaw{roll}.\norientation = [{w:?}, {x:?}, {y:?}, {z:?}]\n", shot.yaw)
    };
    format!(
        "[projectile] # {}\n# The library gives the body. Start, cells and times of the scene are chosen for it: for another one write another\n\
         # scene, with `gelfmu new`.\nlibrary = \"{}\"\nlibrary_version = {LIBRARY_VERSION}\n{values}# Touching the gel.\n\
         position = [0.0, 0.0, {height:?}]\nvelocity = [0.0, 0.0, {:?}]\n{orientation}",
        shot.projectile.title, shot.projectile.name, -shot.speed
    )
}

fn mesh(shot: &Shot, sizes: &LevelSizes) -> String {
    let core = rounded(1.37 * shot.radius());
    let LevelSizes { size, coarsest, slope, smallest, growth, tip_size, erosion_thickness, .. } = sizes;
    let (quality, volume) = if shot.meshed_part() == MeshedPart::Meridian { (0.3, 0.5) } else { (0.15, 0.4) };
    let tip = tip_size.map(|size| format!("# At the tip of the nose.\ntip_size = {size:?}\n")).unwrap_or_default();
    format!(
        "# Cells beneath the projectile, by its radius; they grow with the distance.\n[mesh]\nsize = {size:?}\n\
         element = \"patch\"\ntree = {{ coarsest = {coarsest}, core = {core:?}, slope = {slope:?} }}\n\n\
         # Elements are remade when they are distorted.\n[remesh]\nquality = {quality:?}\nmin_volume_ratio = {volume:?}\n\
         smallest = {smallest:?}\n{tip}curvature_angle = 180.0\ngrowth = {growth:?}\n\
         erosion_thickness = {erosion_thickness:?}\n"
    )
}

/// Window of the peak force: the time in which the projectile flies its calibre.
fn output(shot: &Shot) -> String {
    let window = rounded(2.0 * shot.radius() / shot.speed);
    format!(
        "# The peak force is a mean over the time in which the projectile flies its calibre.\n[output]\nforce_window = {window:?}\n"
    )
}

fn levels(shot: &Shot, sizes: &[LevelSizes]) -> String {
    let errors = LevelErrors::of(shot);
    let levels = sizes.iter().map(|level| {
        let set: Vec<String> = level.overrides(&sizes[STANDARD]).iter().map(|line| format!("\"{line}\"")).collect();
        let set = if level.level == "standard" { String::new() } else { format!("set = [{}]\n", set.join(", ")) };
        let error = errors.error(level.level).map_or(String::new(), |error| format!("error = {error:?}\n"));
        format!("[fidelity.{}]\n{set}{error}", level.level)
    });
    format!("# Errors: {}.\n{}", errors.note(), levels.collect::<Vec<_>>().join("\n"))
}

#[cfg(test)]
mod tests {
    use super::super::shot::named_projectile;
    use super::*;
    use crate::new::block::BlockSize;
    use crate::new::layer::ShotLayer;

    fn text(name: &str, yaw: f64, roll: f64, gel: Preset) -> String {
        let projectile = named_projectile(name).unwrap();
        let (speed, block) = (projectile.speed, BlockSize::parse("15x15x40cm").unwrap());
        scene_text(&Shot { projectile, speed, yaw, roll, block, gel, layers: vec![], arrival: None }).unwrap()
    }

    #[test]
    fn every_projectile_of_the_library_makes_a_scene_that_touches_the_gel() {
        for (name, _) in scene::library() {
            let projectile = named_projectile(name).unwrap();
            let yaw = if projectile.kind == ProjectileKind::Service { 2.0 } else { 0.0 };
            for gel in Preset::ALL {
                let scene = scene::read(&text(name, yaw, 0.0, gel)).unwrap();
                assert_eq!(scene.projectile.mass, Some(projectile.mass), "{name}");
                assert_eq!(scene.projectile.shape, projectile.shape, "{name}");
                assert!(scene.projectile.position[2] > 0.0 && scene.gel.supports == scene::SupportSpec::default());
            }
        }
    }

    #[test]
    fn every_level_of_a_shot_is_a_scene_of_its_own() {
        for (name, yaw) in [("bb", 0.0), ("9mm-fmj", 2.0), ("fsp-1.1g", 0.0)] {
            let text = text(name, yaw, 0.0, Preset::Gelatin10);
            for level in ["draft", "coarse", "standard", "fine"] {
                let set = format!("scene.fidelity={level}").parse().unwrap();
                let scene = scene::read(&scene::resolve(&text, &[set]).unwrap()).unwrap();
                assert!(scene.mesh.size > 0.0, "{name} {level}");
            }
        }
    }

    #[test]
    fn a_shot_through_layers_is_a_scene_without_a_measured_error() {
        let projectile = named_projectile("bb").unwrap();
        let (speed, block) = (projectile.speed, BlockSize::parse("15x15x40cm").unwrap());
        let layers =
            ["2mm,name=skin,strength_scale=3", "5mm,preset=gelatin-20"].map(|text| ShotLayer::parse(text).unwrap());
        let layers = layers.to_vec();
        let shot =
            Shot { projectile, speed, yaw: 0.0, roll: 0.0, block, gel: Preset::Gelatin10, layers, arrival: None };
        let scene = scene::read(&scene_text(&shot).unwrap()).unwrap();
        assert_eq!((scene.scene.name.as_str(), scene.layer.len()), ("bb-180-layered", 2));
        assert_eq!((scene.layer[0].name.as_deref(), scene.layer[0].strength_scale), (Some("skin"), Some(3.0)));
        // Gels of presets keep the ratio of their bulk moduli where that of the gel is reduced.
        let ratio = scene.layer[1].bulk_modulus.unwrap() / scene.gel.bulk_modulus;
        assert!((ratio / (2.61e9 / 2.38e9) - 1.0).abs() < 1e-3, "{ratio}");
        assert!(scene.fidelity.known().all(|(_, level)| level.error.is_none()));
        assert!(scene.scene.title.contains("into 2 layers and 10 % gelatin"), "{}", scene.scene.title);
    }

    #[test]
    fn the_bulk_modulus_of_the_calibration_shot_is_that_of_its_scene() {
        let scene = scene::read(&text("bb", 0.0, 0.0, Preset::Gelatin10)).unwrap();
        let built_in = scene::read(scene::builtin("fbi-bb").unwrap()).unwrap();
        assert!((scene.gel.bulk_modulus / built_in.gel.bulk_modulus - 1.0).abs() < 0.01);
        assert!((scene.mesh.size / built_in.mesh.size - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_communication_step_is_a_round_number() {
        assert_eq!([12.9e-6, 4.1e-6, 9.9e-6, 1e-5].map(communication_step), [1e-5, 2e-6, 5e-6, 1e-5]);
    }
}
