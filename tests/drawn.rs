//! Random scenes, in short; all of them are run by `cargo run --release --example drawn`.
#![allow(clippy::unwrap_used)] // a test that cannot go on fails

#[path = "hostile/random.rs"]
#[allow(dead_code, reason = "hostile use draws more")]
mod random;
#[path = "drawn/ranges.rs"]
mod ranges;
#[path = "drawn/ride.rs"]
mod ride;

use ballistic_gel::scene::{self, Dimension};

#[test]
fn every_seed_is_a_scene_of_its_class_within_the_ranges() {
    for seed in ranges::SEEDS {
        let text = ranges::text(seed);
        let scene = scene::read(&text).unwrap_or_else(|error| panic!("seed {seed}: {error}\n{text}"));
        let speed = scene.projectile.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        assert!((0.999..50.001).contains(&speed), "seed {seed}: {speed} m/s");
        let dimension = match ranges::Class::of(seed) {
            ranges::Class::Planar => Dimension::Planar,
            ranges::Class::Axisymmetric => Dimension::Axisymmetric,
            ranges::Class::Spatial => Dimension::Spatial,
        };
        assert_eq!(scene.scene.dimension, dimension, "seed {seed}");
        assert!(scene.remesh.is_some(), "seed {seed}");
    }
}
