//! Measured shots of the Python package, against the estimates of `gelfmu new`: its length of the path, and the widths
//! of cavities.

use super::{BlockSize, Shot, named_projectile, scene_text};
use ballistic_gel::scene::{self, CAVITY_MARGIN, Preset, ProjectileKind, cavity_estimate};
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// Measured shot.
#[derive(Debug, Clone, Deserialize)]
struct MeasuredShot {
    name: String,
    projectile: String,
    speed: f64,
    yaw: f64,
    block: String,
    measure: String,
    low: f64,
    high: f64,
    grade: String,
    fitted: bool,
    source: String,
}

/// Computed run of a measured shot.
#[derive(Debug, Deserialize)]
struct ComputedShot {
    shot: String,
    level: String,
    yaw: f64,
    greatest_cavity_diameter: Option<f64>,
}

/// End of the name of a shot of an expanding load: the same shot as that of its recovered shape, to which the gel is fitted.
const AS_FIRED: &str = "-fired";

fn rows<T: DeserializeOwned>(text: &str) -> Vec<T> {
    csv::Reader::from_reader(text.as_bytes()).into_deserialize().collect::<Result<_, _>>().unwrap()
}

fn measured_shots() -> Vec<MeasuredShot> {
    rows(include_str!("../../../../python/ballistic_gel/data/measured_shots.csv"))
}

impl MeasuredShot {
    fn shot(&self, yaw: f64) -> Shot {
        Shot {
            projectile: named_projectile(&self.projectile).unwrap(),
            speed: self.speed,
            yaw,
            roll: 0.0,
            block: BlockSize::parse(&self.block).unwrap(),
            gel: Preset::Gelatin10,
            layers: vec![],
            arrival: None,
        }
    }
}

/// Poncelet's law of `gelfmu new` has its resistance from the calibration shot; these shots had no part in it.
#[test]
fn the_law_of_the_estimate_stops_recovered_bullets_within_a_quarter_of_their_measured_depths() {
    let is_counted =
        |shot: &MeasuredShot| shot.grade == "B" && shot.measure == "depth" && shot.projectile.ends_with("-recovered");
    let shots = measured_shots().into_iter().filter(is_counted);
    let ratio = |shot: MeasuredShot| {
        let path = shot.shot(0.0).longest_path();
        path / path.clamp(shot.low, shot.high)
    };
    let ratios: Vec<f64> = shots.map(ratio).collect();
    assert!(ratios.len() == 8 && ratios.iter().all(|ratio| (0.75..1.25).contains(ratio)), "{ratios:?}");
    let mean = ratios.iter().sum::<f64>() / 8.0;
    assert!((mean - 0.9).abs() < 0.05, "{mean}");
}

#[test]
fn every_measured_shot_is_one_of_the_library_in_a_block_that_is_longer_than_its_depth() {
    let shots = measured_shots();
    assert!(shots.len() > 20);
    let fit = include_str!("../../../../python/ballistic_gel/data/gelatin-10.csv");
    for (i, measured) in shots.iter().enumerate() {
        let shot = measured.shot(measured.yaw);
        assert!(shot.block.length > 1.19 * measured.high && measured.low <= measured.high, "{}", measured.name);
        assert!(measured.low > 0.0 && !measured.source.is_empty());
        assert!(shots[..i].iter().all(|other| other.name != measured.name), "{} twice", measured.name);
        let is_service = shot.projectile.kind == ProjectileKind::Service;
        assert_eq!(is_service, measured.yaw != 0.0, "{}", measured.name);
        let is_in_fit = fit.contains(&format!("\n{0},{0},", measured.name.trim_end_matches(AS_FIRED)));
        assert_eq!(measured.fitted, is_in_fit || measured.name == "bb-fbi", "{}", measured.name);
    }
    assert_eq!(shots.iter().filter(|shot| shot.grade == "B" && !shot.fitted).count(), 7);
}

#[test]
fn the_estimate_of_a_cavity_meets_those_that_were_computed() {
    let computed: Vec<ComputedShot> = rows(include_str!("../../../../docs/shots.csv"));
    let (mut n_at_rest, mut n_near) = (0, 0);
    for run in &computed {
        let measured = measured_shots().into_iter().find(|shot| shot.name == run.shot).unwrap();
        let text = scene_text(&measured.shot(run.yaw)).unwrap();
        // The estimate knows the end of a run to a neck.
        let ends_early = measured.measure == "neck";
        let end = format!("scene.end_time={:?}", 2.0 * measured.high / measured.speed);
        let end = ends_early.then(|| end.parse().unwrap());
        let scene = scene::read(&scene::resolve(&text, end.as_slice()).unwrap()).unwrap();
        let ratio = cavity_estimate(&scene, 0).unwrap() / run.greatest_cavity_diameter.unwrap();
        n_at_rest += usize::from(!ends_early);
        n_near += usize::from(!ends_early && (ratio - 1.0).abs() < CAVITY_MARGIN);
        // The cavity of one run is up to 24 % wider or narrower than that of the next.
        let band = if ends_early { 1.0..2.5 } else { 0.74..1.26 };
        assert!(band.contains(&ratio), "{} {} {}: {ratio}", run.shot, run.level, run.yaw);
    }
    assert_eq!((computed.len(), n_at_rest, n_near), (54, 38, 36));
}
