//! Pictures of the mesh with a slider through time.

use super::format::{format_tick, quantity};
use crate::output::picture::{ColourMap, MeshPicture, OpaquePicture, PictureField, SPEED, STEP};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

/// Fraction of the pixels covered by a colour scale: a few extreme pixels must not use up the colours.
const COLOURED_FRACTION: f64 = 0.998;

/// Script that shows one picture at a time, written without the reserved characters of XML.
const SLIDER: &str = "const shots = [...document.querySelectorAll('.shot')];
const slider = document.getElementById('moment');
const show = () => shots.forEach((shot, i) => shot.classList.toggle('shown', i === Number(slider.value)));
slider.addEventListener('input', show);
slider.parentElement.hidden = false;
slider.closest('.stills').classList.add('has-slider');
show();";

/// Colour scale common to all pictures.
struct ColourScale {
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl ColourScale {
    /// Returns the scale of speeds from zero to the greatest.
    fn of_speed(shots: &[MeshPicture]) -> Self {
        let speeds = sorted_values(shots, PictureField::Speed);
        Self { low: 0.0, high: quantile(&speeds, COLOURED_FRACTION).max(f64::MIN_POSITIVE), logarithmic: false }
    }

    /// Returns the scale of time steps from smallest to largest, at least a factor of two.
    fn of_step(shots: &[MeshPicture]) -> Self {
        let steps = sorted_values(shots, PictureField::Step);
        let (low, high) = (quantile(&steps, 1.0 - COLOURED_FRACTION), quantile(&steps, COLOURED_FRACTION));
        Self { low: low.min(0.5 * high).max(f64::MIN_POSITIVE), high, logarithmic: true }
    }

    fn place(&self, value: f64) -> f64 {
        let Self { low, high, logarithmic } = self;
        if *logarithmic { (value / low).ln() / (high / low).ln() } else { (value - low) / (high - low) }
    }

    fn value(&self, place: f64) -> f64 {
        let Self { low, high, logarithmic } = self;
        if *logarithmic { low * (high / low).powf(place) } else { low + place * (high - low) }
    }
}

/// Returns the pictures with their slider, open at the time `moment`, s; empty without pictures. Three are printed.
pub(super) fn film(moment: f64, shots: &[MeshPicture]) -> String {
    if shots.is_empty() {
        return String::new();
    }
    let (step, speed) = (ColourScale::of_step(shots), ColourScale::of_speed(shots));
    let step_legend = legend("Time step of each element", "s", &STEP, &step);
    let speed_legend = legend("Speed", "m/s", &SPEED, &speed);
    let mut frames = String::new();
    let first = nearest_picture(moment, shots);
    let printed = [first / 2, first, shots.len() - 1];
    for (number, shot) in shots.iter().enumerate() {
        let when = quantity(shot.time, "s");
        let steps = shot.png(PictureField::Step, &STEP, |x| step.place(x));
        let speeds = shot.png(PictureField::Speed, &SPEED, |x| speed.place(x));
        let left = picture(&steps, &format!("{when}, coloured by the time step of each element"), &step_legend);
        let right = picture(&speeds, &format!("{when}, coloured by speed"), &speed_legend);
        let class = if printed.contains(&number) { "shot printed" } else { "shot" };
        writeln!(frames, "<div class=\"{class}\"><h3>{when}</h3>\n<div class=\"pair\">{left}{right}</div></div>")
            .expect("a string grows");
    }
    format!(
        "<div class=\"stills\"><p class=\"slider\" hidden=\"hidden\"><label for=\"moment\">Time</label> \
         <input id=\"moment\" type=\"range\" min=\"0\" max=\"{}\" value=\"{first}\" step=\"1\"/></p>\n{frames}\
         <script>\n{SLIDER}\n</script></div>\n",
        shots.len() - 1
    )
}

/// Returns pictures coloured by speed on one scale, on a white background.
pub(in crate::output) fn speed_pictures(pictures: &[MeshPicture]) -> Vec<OpaquePicture> {
    let scale = ColourScale::of_speed(pictures);
    pictures.iter().map(|picture| picture.opaque(PictureField::Speed, &SPEED, |x| scale.place(x))).collect()
}

fn nearest_picture(moment: f64, shots: &[MeshPicture]) -> usize {
    let distance = |i: &usize| (shots[*i].time - moment).abs();
    (0..shots.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}

fn picture(png: &[u8], what: &str, legend: &str) -> String {
    let bytes = STANDARD.encode(png);
    format!(
        "<figure class=\"picture\"><img alt=\"The deformed gel at {what}\" src=\"data:image/png;base64,{bytes}\"/>\n\
         {legend}</figure>\n"
    )
}

fn legend(what: &str, unit: &str, map: &ColourMap, scale: &ColourScale) -> String {
    let ticks: String = [0.0, 0.25, 0.5, 0.75, 1.0]
        .map(|place| format!("<span>{}</span>", format_tick(scale.value(place), scale.high, unit)))
        .concat();
    format!(
        "<figcaption>{what}</figcaption>\n<div class=\"bar\" style=\"background: \
         linear-gradient(to right, {})\"></div>\n<div class=\"ticks\">{ticks}</div>",
        map.css()
    )
}

fn sorted_values(shots: &[MeshPicture], field: PictureField) -> Vec<f64> {
    let known = |x: &f64| x.is_finite() && (field == PictureField::Speed || *x > 0.0);
    let mut values: Vec<f64> = shots.iter().flat_map(|shot| shot.values(field)).filter(known).collect();
    values.sort_by(f64::total_cmp);
    values
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = (share * sorted.len().saturating_sub(1) as f64).round() as usize;
    sorted.get(place).copied().unwrap_or(1.0)
}
