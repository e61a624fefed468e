//! Random scenes, in short; all of them are run by `cargo run --release --manifest-path studies/Cargo.toml --bin drawn`.
#![allow(clippy::unwrap_used)] // a test that cannot go on fails

#[path = "hostile/random.rs"]
#[allow(dead_code, reason = "hostile use draws more")]
mod random;
#[path = "drawn/ranges.rs"]
#[allow(dead_code, reason = "the command goes by class")]
mod ranges;
#[path = "drawn/ride.rs"]
#[allow(dead_code, reason = "the command goes on where a run panics")]
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

/// Runs a seed to its end, with books that close.
#[track_caller]
fn goes_to_its_end(seed: u64) -> ride::Ride {
    let ride = ride::ride(&ranges::text(seed));
    assert_eq!(ride.stop, None, "seed {seed}: {ride:?}");
    let [energy, momentum, angular_momentum] = ride.closure;
    assert!(energy < 1e-10 && momentum < 1e-11 && angular_momentum < 1e-11, "seed {seed}: {ride:?}");
    assert!(ride.mass < 1e-11, "seed {seed}: mass {:e}", ride.mass);
    ride
}

#[test]
fn some_of_all_classes_reach_their_ends() {
    for seed in [66, 130, 132, 54, 157, 56, 80] {
        goes_to_its_end(seed);
    }
}

/// No mesh was taken, because cutting off its small loops changed the area by more than rounding.
#[test]
fn a_wall_that_crosses_itself_in_small_loops_does_not_stop_a_run() {
    for seed in [55, 65, 87] {
        assert!(goes_to_its_end(seed).remeshings > 5);
    }
}

/// The flat triangle in the tip was kept from mesh to mesh until it was turned inside out.
#[test]
fn a_splash_that_is_drawn_to_a_needle_does_not_stop_a_run() {
    assert!(goes_to_its_end(49).remeshings > 5);
}

/// The node of the entry surface on the axis was pushed past the one below it, and no triangulation has an axis that lies on itself.
#[test]
fn a_fold_of_the_axis_does_not_stop_a_run() {
    assert!(goes_to_its_end(133).remeshings > 5);
}

/// A node of the new mesh stood in a corner of an old element in which the density was below nothing, and got a negative mass.
#[test]
fn a_density_below_nothing_does_not_stop_a_run() {
    assert!(goes_to_its_end(81).remeshings > 5);
}

/// Errors of masses after a remeshing, and gel cut off a wall, were once compressed against the bulk modulus: 142, 48, 20 and 19 % of the
/// energy; 3.0, 3.6, 1.3 to 2.4 by its last digits, and 11.4 % since measures at rest go by volumes. 191 and 194 were stopped by it. Of 111 an element that filled a
/// gap was drawn together: 141 %.
#[test]
fn a_remeshing_stores_little_in_a_stiff_volume() {
    for (seed, most) in [(69, 0.1), (71, 0.05), (151, 0.03), (34, 0.12), (194, 0.1), (191, 0.3), (111, 0.05)] {
        let defect = goes_to_its_end(seed).defect;
        assert!(defect.abs() < most, "seed {seed}: {defect}");
    }
}

/// A patch of a compressed and an inverted element, of which an erosion takes the latter, once compressed the rest against the bulk
/// modulus: 172 % of the energy.
#[test]
fn an_erosion_stores_nothing_in_what_remains_of_a_patch() {
    let defect = goes_to_its_end(140).defect;
    assert!(defect.abs() < 0.03, "{defect}");
}

/// An element drawn out over nothing (403) gave 70 % of the energy in one remeshing, and one patch had three times all of it (210), where
/// the mean of F of what is turned against each other was all but flat: they had gained 67 and 114 % in the end.
#[test]
fn remeshings_do_not_feed_a_run() {
    // Nothing asks for a remeshing of 403; operations give 210 1.3 %.
    for (seed, fed, most) in [(403, 0.0, 0.05), (210, 0.02, 0.2)] {
        let ride = goes_to_its_end(seed);
        assert!(ride.remesh <= fed && ride.defect.abs() < most, "seed {seed}: {ride:?}");
    }
}

/// Of 11 speeds from 35.5 to 36.1 m/s five stopped, that of the seed among them. At 35.5 m/s elements that had flowed far were asked for their
/// first steps as if they had not, and no mesh was taken; at 35.79 m/s because of a tetrahedron of 8e-16 m³ that every mesh kept. Of five speeds
/// below, 35.0 m/s stopped: what collapsed in a young mesh broke off, but what it left had a step of 0.6 ticks.
#[test]
fn what_has_flowed_far_and_flat_does_not_stop_a_run() {
    goes_to_its_end(580);
    let text = ranges::text(580);
    for speed in ["-3.5e1", "-3.55e1", "-3.579e1"] {
        let other = text.replace("-3.58e1", speed);
        assert_ne!(other, text);
        let ride = ride::ride(&other);
        assert_eq!(ride.stop, None, "{speed} m/s: {ride:?}");
        assert!(ride.closure[0] < 1e-10 && ride.mass < 1e-11, "{speed} m/s: {ride:?}");
    }
}

/// A surface node stood on the wall across, 1e-10 m from it, and every new mesh had the element between.
#[test]
fn a_wall_that_is_pinched_to_nothing_does_not_stop_a_run() {
    assert!(goes_to_its_end(190).remeshings > 5);
}

/// Where it measured at rest what its J asked for, an element that lay over nothing was thrown about.
#[test]
fn an_element_that_lies_over_nothing_does_not_stop_a_run() {
    assert!(goes_to_its_end(178).remeshings > 5);
}

/// An element was inverted at two of its own ticks before the mesh was old enough to end.
#[test]
fn an_element_that_inverts_in_a_young_mesh_does_not_stop_a_run() {
    assert!(goes_to_its_end(181).remeshings > 5);
}

/// The node of the entry surface where two planes of symmetry meet was pushed past the one below it. The edge between them was not drawn
/// together, because a point beside it is on the surface as well: 17 of 18 speeds beside that of the seed stopped.
#[test]
fn a_fold_of_the_line_where_planes_of_symmetry_meet_does_not_stop_a_run() {
    let text = ranges::text(178);
    for speed in ["-4.338e1", "-4.35e1", "-4.38e1"] {
        let other = text.replace("-4.34e1", speed);
        assert_ne!(other, text);
        let ride = ride::ride(&other);
        assert_eq!(ride.stop, None, "{speed} m/s: {ride:?}");
        assert!(ride.closure[0] < 1e-10 && ride.mass < 1e-11 && ride.remeshings > 5, "{speed} m/s: {ride:?}");
    }
}
