//! Wide draws: gels of every law up to the speeds of bullets, pressures on the face that is hit, and fragments.
//!
//! Ranges were written down before the first of them was run.

use super::{BODY, Class, Frame, GEL, SHEAR, VOLUME, between, either_way, gel_shape, rounded, supports, unit, viscous};
use crate::random::Random;
use std::fmt::Write;

/// First seed of a wide draw.
pub const FIRST: u64 = 1001;
/// Speed at a gel that flows, m/s; at an elastic one it is that of the narrow draws.
const FAST: [f64; 2] = [20.0, 400.0];
/// Presets, with the speed by which the time of a run is limited, m/s; that of their shear waves is 4.3 to 4.8 m/s.
const PRESETS: [(&str, f64); 3] = [("gelatin-10", 4.4), ("gelatin-20", 6.0), ("synthetic-clear", 4.4)];
/// C₂/C₁ of Mooney and Rivlin, and exponents of Ogden.
const SECOND: [f64; 2] = [0.01, 0.3];
const EXPONENT: [f64; 2] = [2.0, 6.0];
/// Radius of a fragment, in that of the greatest ball inside the body, and its place, in halves of the width of the
/// gel.
const FRAGMENT: [f64; 2] = [0.85, 1.2];
const ASIDE: f64 = 0.6;
/// Greatest pressure or pull on a face, in shear moduli of a soft gel.
const PRESSURE: f64 = 0.2;

/// Gel of a wide draw: its table, the speed that limits the time of a run and that of the body, m/s.
pub struct WideGel {
    pub text: String,
    pub shear_speed: f64,
    pub speed: f64,
}

/// Draws a gel of any law.
pub fn gel(random: &mut Random, frame: &Frame) -> WideGel {
    let (shear, density, volume) = (between(random, SHEAR), between(random, GEL), between(random, VOLUME));
    let bulk = rounded(shear * volume);
    let shape = gel_shape(random, frame);
    let mut text = format!("[gel]\nshape.{shape}\n{}", supports(random, &shape));
    if frame.quarter {
        text += "symmetry = \"quarter\"\n";
    }
    let (law, shear_speed) = (random.below(6), (shear / density).sqrt());
    if law >= 3 {
        let (preset, shear_speed) = *random.pick(&PRESETS);
        let _ = writeln!(text, "preset = \"{preset}\"");
        if random.once_in(2) {
            text += "cavity = { inflow = { discharge = 0.61 } }\n";
        }
        return WideGel { text, shear_speed, speed: between(random, FAST) };
    }
    let _ = writeln!(text, "density = {density:e}\nbulk_modulus = {bulk:e}");
    let law = match law {
        0 => {
            let second = between(random, SECOND);
            let first = 0.5 * shear / (1.0 + second);
            format!("material = \"mooney-rivlin\"\nconstants = {{ c1 = {first:e}, c2 = {:e} }}\n", first * second)
        }
        1 => {
            let exponent = between(random, EXPONENT);
            let modulus = 2.0 * shear / exponent;
            format!("material = \"ogden\"\nterms = [{{ modulus = {modulus:e}, exponent = {exponent:e} }}]\n")
        }
        _ => format!("shear_modulus = {shear:e}\n{}", viscous(random, shear)),
    };
    text += &law;
    WideGel { text, shear_speed, speed: frame.speed }
}

/// Draws a pressure on the face that is hit, reached in a quarter of the run, in a third of the scenes of whole gels.
pub fn load(random: &mut Random, frame: &Frame, end: f64) -> String {
    if frame.quarter || !random.once_in(3) {
        return String::new();
    }
    let pressure = PRESSURE * SHEAR[0] * either_way(random);
    format!("\n[[load]]\non = \"z_max\"\npressure = {pressure:e}\nramp = {:e}\n", 0.25 * end)
}

/// Draws a ball beside the body, as fast as it, in half of the scenes without an axis or planes of symmetry.
pub fn fragment(random: &mut Random, frame: &Frame, inner: f64) -> String {
    if frame.class == Class::Axisymmetric || frame.quarter || random.once_in(2) {
        return String::new();
    }
    let (radius, density) = (inner * between(random, FRAGMENT), between(random, BODY));
    let x = ASIDE * frame.half * if unit(random) < 0.5 { -1.0 } else { 1.0 };
    format!(
        "\n[[fragment]]\nshape.sphere.radius = {radius:e}\ndensity = {density:e}\n\
         position = [{x:e}, 0.0, {radius:e}]\nvelocity = [0.0, 0.0, {:e}]\n",
        -frame.speed
    )
}
