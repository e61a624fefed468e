//! Scene text of a shot.

use super::shot::{MeshedPart, Shot};
use super::sizes::{LevelSizes, rounded};
use crate::failure::CommandError;
use ballistic_gel::geometry::SignedDistance;
use ballistic_gel::math::Vector3;
use ballistic_gel::scene::{self, Preset, ProjectileKind};
use nalgebra::{Quaternion, UnitQuaternion};

/// Ratio of wave speed to impact speed from which compressibility changes the stagnation pressure by 2 % at most: that
/// of `fbi-bb`.
const WAVE_RATIO: f64 = 4.45;
/// Time after the estimated stop in which the gel pushes the projectile back and the cavity closes, s.
const RELAXATION: f64 = 6e-3;
/// Time after the longest path for a projectile that yaws, s: it stops much earlier.
const MARGIN: f64 = 3e-3;

/// Complete, commented scene of a shot.
pub fn scene_text(shot: &Shot) -> Result<String, CommandError> {
    // The body is put above the gel first, then down onto it by the reach of its foremost point.
    let far = 10.0 * (shot.radius() + shot.block.length);
    let provisional = text_at(shot, far);
    let bad_scene = |error| CommandError::BadInput(format!("the shot makes no scene: {error}"));
    let scene = scene::read(&provisional).map_err(bad_scene)?;
    let [w, x, y, z] = shot.orientation();
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let reach = scene.shape(0).reach(&turn.inverse_transform_vector(&-Vector3::z()));
    let text = text_at(shot, reach);
    scene::read(&text).map_err(bad_scene)?;
    Ok(text)
}

/// Scene text with the centre of mass at this height above the gel, m.
fn text_at(shot: &Shot, height: f64) -> String {
    let sizes = LevelSizes::of(shot);
    [header(shot), gel(shot), projectile(shot, height), mesh(shot, &sizes[2]), levels(&sizes)].join("\n")
}

fn header(shot: &Shot) -> String {
    let Shot { projectile, speed, yaw, block, .. } = shot;
    let dimension = if shot.meshed_part() == MeshedPart::Meridian { "axisymmetric" } else { "spatial" };
    let yaw = if *yaw == 0.0 { String::new() } else { format!(" with {yaw}° of yaw") };
    let title = format!("{}: {} m/s{yaw} into {}", projectile.title, rounded(*speed), gel_name(shot.gel));
    let limit = if projectile.kind == ProjectileKind::Service && shot.yaw != 0.0 { "at most " } else { "" };
    let path = format!("{limit}{:.0} mm", 1e3 * shot.longest_path());
    let fate = if shot.longest_path() > block.length { "may leave the block" } else { "should stay in the block" };
    let not_modelled =
        projectile.not_modelled.iter().map(|text| format!("# Not modelled: {text}\n")).collect::<String>();
    let (about_end, end_time) = end_time(shot);
    format!(
        "# Written by `gelfmu new`. All numbers are SI (m, kg, s, Pa); \"9.02 mm\", \"124 gr\" and the like are read, too.\n\
         # By Poncelet's law a sphere of this calibre and mass would come to rest after {path}: it {fate}.\n{not_modelled}\
         \n[scene]\nname = \"{}-{:.0}\"\ntitle = \"{title}\"\ndimension = \"{dimension}\"\n\
         # {about_end} After an exit the run ends earlier.\n\
         end_time = {end_time:?}\n\
         # The projectile flies about its radius in it.\n\
         communication_step = {:?}\n\
         # fidelity = \"draft\" # or coarse, standard, fine; or `gelfmu run FILE --fidelity draft`\n",
        projectile.name.replace('.', "_"),
        speed,
        communication_step(shot.radius() / speed)
    )
}

/// End of the run with its reason, s.
fn end_time(shot: &Shot) -> (String, f64) {
    if shot.yaw == 0.0 {
        let about =
            format!("One and a half times the time of that path, and {:.0} ms to come to rest.", 1e3 * RELAXATION);
        (about, rounded(1.5 * shot.longest_time() + RELAXATION))
    } else {
        let about = format!("The time of that path, and {:.0} ms: a projectile that yaws stops earlier.", 1e3 * MARGIN);
        (about, rounded(shot.longest_time() + MARGIN))
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
         # No supports: the back face is free, and the projectile may leave there.\n",
        shot.gel.name(),
        bulk_modulus(shot)
    )
}

/// Bulk modulus of a slow shot, less than that of the preset: it saves steps.
fn bulk_modulus(shot: &Shot) -> String {
    let value = |key: &str| {
        let facts = shot.gel.facts();
        facts
            .iter()
            .find(|fact| fact.key == key && fact.of.includes("two-network"))
            .and_then(|fact| fact.value.parse::<f64>().ok())
    };
    let (Some(own), Some(density)) = (value("gel.bulk_modulus"), value("gel.density")) else { return String::new() };
    let wave = WAVE_RATIO * shot.speed;
    let enough = rounded(density * wave * wave);
    if enough >= own {
        return String::new();
    }
    format!(
        "# That of a wave of {wave:.0} m/s: the projectile is at Mach 0.22 with it, as in `fbi-bb`. It saves steps; without this line\n\
         # it is the {own:?} Pa of the preset.\nbulk_modulus = {enough:?}\n"
    )
}

fn projectile(shot: &Shot, height: f64) -> String {
    let lines = shot.projectile.table_lines().join("\n");
    let orientation = if shot.yaw == 0.0 {
        String::new()
    } else {
        let [w, x, y, z] = shot.orientation();
        let roll = if x == 0.0 { String::new() } else { format!(", the plane of the yaw turned by {}°", shot.roll) };
        format!("# {}° of yaw{roll}.\norientation = [{w:?}, {x:?}, {y:?}, {z:?}]\n", shot.yaw)
    };
    format!(
        "[projectile] # {}\nlibrary = \"{}\"\n{lines}\n# Touching the gel.\nposition = [0.0, 0.0, {height:?}]\n\
         velocity = [0.0, 0.0, {:?}]\n{orientation}",
        shot.projectile.title, shot.projectile.name, -shot.speed
    )
}

fn mesh(shot: &Shot, sizes: &LevelSizes) -> String {
    let core = rounded(1.37 * shot.radius());
    let LevelSizes { size, slope, smallest, growth, tip_size, erosion_thickness, .. } = sizes;
    let (quality, volume) = if shot.meshed_part() == MeshedPart::Meridian { (0.3, 0.5) } else { (0.15, 0.4) };
    let tip = tip_size.map(|size| format!("# At the tip of the nose.\ntip_size = {size:?}\n")).unwrap_or_default();
    format!(
        "# Cells beneath the projectile, by its radius; they grow with the distance.\n[mesh]\nsize = {size:?}\n\
         element = \"patch\"\ntree = {{ coarsest = 16, core = {core:?}, slope = {slope:?} }}\n\n\
         # Elements are remade when they are distorted.\n[remesh]\nquality = {quality:?}\nmin_volume_ratio = {volume:?}\n\
         smallest = {smallest:?}\n{tip}curvature_angle = 180.0\ngrowth = {growth:?}\n\
         erosion_thickness = {erosion_thickness:?}\n"
    )
}

fn levels(sizes: &[LevelSizes]) -> String {
    let others = sizes.iter().filter(|sizes| sizes.level != "standard").map(|sizes| {
        let set: Vec<String> = sizes.overrides().iter().map(|line| format!("\"{line}\"")).collect();
        format!("[fidelity.{}]\nset = [{}]\n", sizes.level, set.join(", "))
    });
    let note = "# Their errors for this shot: `gelfmu trade FILE`.\n";
    format!("{note}{}", others.collect::<Vec<_>>().join("\n"))
}

#[cfg(test)]
mod tests {
    use super::super::shot::named_projectile;
    use super::*;
    use crate::new::block::BlockSize;

    fn text(name: &str, yaw: f64, roll: f64, gel: Preset) -> String {
        let projectile = named_projectile(name).unwrap();
        let (speed, block) = (projectile.speed, BlockSize::parse("15x15x40cm").unwrap());
        scene_text(&Shot { projectile, speed, yaw, roll, block, gel }).unwrap()
    }

    #[test]
    fn every_projectile_of_the_library_makes_a_scene_that_touches_the_gel() {
        for (name, _) in scene::library() {
            let projectile = named_projectile(name).unwrap();
            let yaw = if projectile.kind == ProjectileKind::Service { 2.0 } else { 0.0 };
            for gel in Preset::ALL {
                let scene = scene::read(&text(name, yaw, 0.0, gel)).unwrap();
                assert_eq!(scene.projectile.mass, Some(projectile.mass), "{name}");
                assert!(projectile.sources_of(&scene.projectile).len() > 1, "{name}");
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
