//! Random scenes of which none may stop: what is drawn, within which ranges, and by which seeds.
//!
//! Written down before the first of them was run.

#[path = "wide.rs"]
pub mod wide;

use super::random::Random;
use ballistic_gel::geometry::SignedDistance;
use ballistic_gel::math::Vector3;
use ballistic_gel::scene;
use std::fmt::Write;

/// The seeds; each is a scene. Those from [`wide::FIRST`] on are drawn more widely.
pub const SEEDS: std::ops::RangeInclusive<u64> = 1..=200;
/// Of twenty seeds in a row the first twelve are in the plane, the next five about an axis, the last three in space.
const CLASSES: [(Class, u64); 3] = [(Class::Planar, 12), (Class::Axisymmetric, 5), (Class::Spatial, 3)];

/// Speed of the body, m/s.
const SPEED: [f64; 2] = [1.0, 50.0];
/// Half of its greatest width, m.
const RADIUS: [f64; 2] = [3e-3, 15e-3];
/// Its density, kg/m³.
const BODY: [f64; 2] = [900.0, 11_000.0];
/// Shear modulus of the gel, Pa.
const SHEAR: [f64; 2] = [10e3, 200e3];
/// 1/(1 − 2ν) of the gel: ν from 0.45 to 0.4999.
const VOLUME: [f64; 2] = [10.0, 5000.0];
/// Its density, kg/m³.
const GEL: [f64; 2] = [950.0, 1100.0];
/// Stress that the branch of a viscous gel bears at a rate of `BORNE_AT`, in shear moduli.
const BORNE: [f64; 2] = [0.1, 2.0];
/// 1/s: a slow ball over its radius.
const BORNE_AT: f64 = 1e3;
/// Lengths in radii of the body: height of the gel, half of its width; in space it is less wide.
const HEIGHT: [f64; 2] = [6.0, 12.0];
const HALF_WIDTH: [f64; 2] = [5.0, 8.0];
const IN_SPACE: f64 = 0.75;
/// Cells per radius of the greatest ball inside the body.
const FINENESS: [f64; 2] = [2.0, 5.0];
const FINENESS_IN_SPACE: [f64; 2] = [1.25, 2.0];
/// How far the body would go in a run if nothing held it back, in heights of the gel: it does not come to stand on what holds the gel.
const WAY: [f64; 2] = [0.2, 0.7];
/// A run is over at the latest when a shear wave has crossed the height of the gel so often.
const WAVES: f64 = 2.0;
/// Degrees: of the flight from the vertical, of the axis of a body from it.
const FLIGHT: f64 = 20.0;
const TILT: f64 = 45.0;

/// The space of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// In the plane.
    Planar,
    /// About an axis.
    Axisymmetric,
    /// In space.
    Spatial,
}

impl Class {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Planar, Self::Axisymmetric, Self::Spatial];

    /// That of a seed.
    pub fn of(seed: u64) -> Self {
        let mut place = (seed + 19) % 20;
        for (class, share) in CLASSES {
            if place < share {
                return class;
            }
            place -= share;
        }
        unreachable!("the shares are twenty")
    }

    /// As a scene says it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Planar => "planar",
            Self::Axisymmetric => "axisymmetric",
            Self::Spatial => "spatial",
        }
    }
}

/// What is drawn first and what other lengths are measured in.
pub struct Frame {
    class: Class,
    radius: f64,
    /// Half of the width and the height of the gel, m.
    half: f64,
    height: f64,
    speed: f64,
    /// A quarter of a block in space: bodies move along the axis then.
    quarter: bool,
}

/// The body as a scene has it, and the radius of a ball that fits into it, m.
struct Solid {
    text: String,
    inner: f64,
}

/// The text of the scene of a seed.
pub fn text(seed: u64) -> String {
    let mut random = Random(seed);
    let class = Class::of(seed);
    let radius = between(&mut random, RADIUS);
    let wide = if class == Class::Spatial { IN_SPACE } else { 1.0 };
    let half = rounded(radius * wide * between(&mut random, HALF_WIDTH));
    let height = rounded(radius * wide * between(&mut random, HEIGHT));
    let speed = between(&mut random, SPEED);
    let quarter = class == Class::Spatial && random.once_in(4);
    let mut frame = Frame { class, radius, half, height, speed, quarter };
    let solid = solid(&mut random, &frame);
    let is_wide = seed >= wide::FIRST;
    let (gel, shear_speed) = if is_wide {
        let gel = wide::gel(&mut random, &frame);
        frame.speed = gel.speed;
        (gel.text, gel.shear_speed)
    } else {
        gel(&mut random, &frame)
    };
    let way = between(&mut random, WAY) * height;
    let end = rounded((way / frame.speed).min(WAVES * height / shear_speed));
    let header = format!(
        "[scene]\nname = \"drawn-{seed}\"\ndimension = \"{}\"\nend_time = {end:e}\ncommunication_step = {:e}\n",
        class.name(),
        end / 100.0
    );
    let motion = motion(&mut random, &frame);
    let mesh = mesh(&mut random, &frame, solid.inner);
    let mut others = String::new();
    if is_wide {
        others = wide::load(&mut random, &frame, end) + &wide::fragment(&mut random, &frame, solid.inner);
    }
    let at = |height: f64| {
        let place = motion.replace("HEIGHT", &format!("{height:e}"));
        format!("{header}\n{gel}\n[projectile]\n{}{place}\n{mesh}\n[remesh]\n{others}", solid.text)
    };
    at(touching(&at(1.0)))
}

/// How high above the gel the body of a scene just touches it, m.
fn touching(text: &str) -> f64 {
    let scene = scene::read(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let [w, x, y, z] = scene.projectile.orientation;
    let turned = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    scene.shape(0).reach(&turned.inverse_transform_vector(&-Vector3::z()))
}

/// Between two bounds, evenly in the logarithm, to three digits.
fn between(random: &mut Random, [low, high]: [f64; 2]) -> f64 {
    rounded(low * (high / low).powf(unit(random)))
}

/// From -1 to 1, evenly.
fn either_way(random: &mut Random) -> f64 {
    2.0 * unit(random) - 1.0
}

/// From 0 to 1, evenly.
fn unit(random: &mut Random) -> f64 {
    (random.bits() >> 11) as f64 / (1_u64 << 53) as f64
}

/// To three digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().expect("a number that was printed")
}

fn solid(random: &mut Random, frame: &Frame) -> Solid {
    let r = frame.radius;
    let length = rounded(2.0 * r * between(random, [0.5, 2.0]));
    let edge = if random.once_in(3) { 0.0 } else { 0.5 * unit(random) };
    let density = between(random, BODY);
    let flat = frame.class != Class::Axisymmetric;
    let (shape, inner) = match random.below(if flat { 5 } else { 4 }) {
        0 => (format!("sphere.radius = {r:e}"), r),
        1 => {
            let inner = r.min(0.5 * length);
            (format!("cylinder = {{ radius = {r:e}, length = {length:e}, edge_radius = {:e} }}", edge * inner), inner)
        }
        2 => (format!("capsule = {{ radius = {r:e}, length = {:e} }}", 2.0 * r + length), r),
        3 => (bullet(random, (r, length)), 0.7 * r.min(length)),
        _ => {
            let inner = r.min(0.5 * length);
            let size = format!("[{:e}, {:e}, {length:e}]", 2.0 * r, 2.0 * r);
            (format!("plate = {{ size = {size}, edge_radius = {:e} }}", edge * inner), inner)
        }
    };
    Solid { text: format!("shape.{shape}\ndensity = {density:e}\n"), inner }
}

/// A nose and a mantle of this length.
fn bullet(random: &mut Random, (r, mantle): (f64, f64)) -> String {
    let length = r * between(random, [1.0, 3.0]);
    let meplat = if random.once_in(3) { 0.0 } else { 0.5 * unit(random) * r };
    let (nose, length) = match random.below(4) {
        0 => (format!("{{ cone = {{ length = {length:e}, meplat_radius = {meplat:e} }} }}"), length),
        1 => (format!("{{ ogive = {{ length = {length:e}, meplat_radius = {meplat:e} }} }}"), length),
        2 => ("\"round\"".to_owned(), r),
        _ => ("\"flat\"".to_owned(), 0.0),
    };
    format!("bullet = {{ radius = {r:e}, length = {:e}, nose = {nose} }}", 1.001 * (length + mantle))
}

/// The table of the gel, and the speed of shear waves in it, m/s.
fn gel(random: &mut Random, frame: &Frame) -> (String, f64) {
    let (shear, density) = (between(random, SHEAR), between(random, GEL));
    let volume = between(random, VOLUME);
    let poisson = 0.5 * (1.0 - 1.0 / volume);
    let bulk = rounded(2.0 / 3.0 * shear * (1.0 + poisson) * volume);
    let shape = gel_shape(random, frame);
    let mut text = format!(
        "[gel]\nshape.{shape}\ndensity = {density:e}\nshear_modulus = {shear:e}\nbulk_modulus = {bulk:e}\n{}",
        supports(random, &shape)
    );
    if frame.quarter {
        text += "symmetry = \"quarter\"\n";
    }
    text += &if random.once_in(5) { viscous(random, shear) } else { "material = \"neo-hookean\"\n".to_owned() };
    (text, (shear / density).sqrt())
}

/// The shape of the gel.
fn gel_shape(random: &mut Random, frame: &Frame) -> String {
    let (half, height) = (frame.half, frame.height);
    match frame.class {
        Class::Planar => format!("block.size = [{:e}, {height:e}]", 2.0 * half),
        Class::Spatial if frame.quarter || random.once_in(2) => {
            format!("block.size = [{:e}, {:e}, {height:e}]", 2.0 * half, 2.0 * half)
        }
        Class::Axisymmetric | Class::Spatial => format!("cylinder = {{ radius = {half:e}, height = {height:e} }}"),
    }
}

fn supports(random: &mut Random, shape: &str) -> String {
    let bottom = *random.pick(&["fixed", "fixed", "roller", "free"]);
    let mut text = format!("supports.z_min = \"{bottom}\"\n");
    if shape.starts_with("block") {
        let side = *random.pick(&["free", "free", "free", "free", "roller", "fixed"]);
        let _ = writeln!(text, "supports.x_max = \"{side}\"");
    } else if random.once_in(4) {
        text += "supports.side = \"fixed\"\n";
    }
    text
}

/// Gel of two networks, its branch as stiff as the elastic network, with a power law from soft to beyond the elastic stress.
fn viscous(random: &mut Random, shear: f64) -> String {
    let at_rate = shear * between(random, BORNE);
    let exponent = 1.0 - 0.5 * unit(random);
    let stress = at_rate * BORNE_AT.powf(-exponent);
    format!(
        "material = \"two-network\"\n\
         branches = [{{ shear_modulus = {shear:e}, power_law = {{ stress = {stress:e}, exponent = {exponent:e} }} }}]\n\
         viscosity = {{ linear = 0.1, quadratic = {:e} }}\n",
        random.pick(&[0.0, 1.2])
    )
}

/// Place, velocity and orientation of the body.
fn motion(random: &mut Random, frame: &Frame) -> String {
    let (aside, flight, tilt) = (either_way(random), either_way(random), either_way(random));
    if frame.class == Class::Axisymmetric || frame.quarter {
        return format!("position = [0.0, 0.0, HEIGHT]\nvelocity = [0.0, 0.0, {:e}]\n", -frame.speed);
    }
    let (flight, tilt) = ((FLIGHT * flight).to_radians(), 0.5 * (TILT * tilt).to_radians());
    format!(
        "position = [{:e}, 0.0, HEIGHT]\nvelocity = [{:e}, 0.0, {:e}]\norientation = [{:e}, 0.0, {:e}, 0.0]\n",
        0.1 * frame.half * aside,
        frame.speed * flight.sin(),
        -frame.speed * flight.cos(),
        tilt.cos(),
        tilt.sin()
    )
}

fn mesh(random: &mut Random, frame: &Frame, inner: f64) -> String {
    let in_space = frame.class == Class::Spatial;
    let size = inner / between(random, if in_space { FINENESS_IN_SPACE } else { FINENESS });
    let element = random.pick(&["plain", "patch"]);
    let core = 2.0 * frame.radius;
    let grown = match random.below(6) {
        0 | 1 => format!("tree = {{ coarsest = 2, core = {core:e}, slope = {:e} }}\n", between(random, [0.25, 1.0])),
        2 => {
            let growth = between(random, [1.1, 1.5]);
            format!("grading = {{ core = {core:e}, growth = {growth:e}, largest = {:e} }}\n", 4.0 * size)
        }
        3 if !in_space => "lattice = \"kuhn\"\n".to_owned(),
        _ => String::new(),
    };
    format!("[mesh]\nsize = {size:e}\nelement = \"{element}\"\n{grown}")
}
