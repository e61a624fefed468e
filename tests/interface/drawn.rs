//! Random scenes, in short; all of them are run by `cargo run --release --manifest-path studies/Cargo.toml --bin drawn`.

#[path = "../drawn/ranges.rs"]
#[allow(dead_code, reason = "the command goes by class")]
mod ranges;
#[path = "../drawn/ride.rs"]
#[allow(dead_code, reason = "the command goes on where a run panics")]
mod ride;

use crate::random;
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

#[test]
fn every_wide_seed_is_a_scene_of_any_law_with_loads_and_fragments() {
    let read = |seed| {
        let text = ranges::text(seed);
        scene::read(&text).unwrap_or_else(|error| panic!("seed {seed}: {error}\n{text}"))
    };
    let scenes: Vec<_> = (ranges::wide::FIRST..ranges::wide::FIRST + 300).map(read).collect();
    let count = |is: fn(&scene::Scene) -> bool| scenes.iter().filter(|scene| is(scene)).count();
    assert!(count(|scene| !scene.fragment.is_empty()) > 10 && count(|scene| !scene.load.is_empty()) > 10);
    for material in ["MooneyRivlin", "Ogden", "TwoNetwork"] {
        let n = scenes.iter().filter(|scene| format!("{:?}", scene.gel.material) == material).count();
        assert!(n > 5, "{n} of {material}");
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

/// Event that a run must show for its claim to be about it: seeds drift where the solver changes.
#[derive(Debug, Clone, Copy)]
enum RunEvent {
    /// More than one remeshing.
    Remeshings,
    /// An inverted element.
    Inversion,
    /// Gel that no mesh can follow is removed.
    Erosion,
    /// A mesh is made as a whole, because local operations do not suffice.
    WholeMesh,
}

impl RunEvent {
    fn is_in(self, ride: &ride::Ride) -> bool {
        match self {
            Self::Remeshings => ride.remeshings > 1,
            Self::Inversion => ride.least < 0.0,
            Self::Erosion => ride.eroded > 0.0,
            Self::WholeMesh => ride.whole > 0,
        }
    }
}

/// Runs a seed to its end, on which the event comes about.
#[track_caller]
fn goes_on_after(event: RunEvent, seed: u64) -> ride::Ride {
    let ride = goes_to_its_end(seed);
    assert!(event.is_in(&ride), "seed {seed} shows no {event:?} any more, choose another: {ride:?}");
    ride
}

/// Each has stopped a former version, but for the first seven: a wall that crossed itself (55, 87), a needle (49), a
/// fold of the axis (133), a wall pinched to nothing (190). What stopped them may no longer come about.
#[test]
fn some_of_all_classes_and_seeds_that_once_stopped_reach_their_ends() {
    for seed in [66, 130, 132, 54, 157, 56, 80] {
        goes_to_its_end(seed);
    }
    for seed in [55, 87, 49, 133, 190] {
        goes_on_after(RunEvent::Remeshings, seed);
    }
}

#[test]
fn an_inverted_element_does_not_stop_a_run() {
    for seed in [132, 157, 181] {
        goes_on_after(RunEvent::Inversion, seed);
    }
}

/// Shots that reach their end only by erosion where no mesh can follow.
#[test]
fn gel_that_no_mesh_can_follow_does_not_stop_a_run() {
    for seed in [65, 81, 178, 181] {
        goes_on_after(RunEvent::Erosion, seed);
    }
}

#[test]
fn where_operations_do_not_suffice_a_whole_mesh_is_made() {
    for seed in [56, 81] {
        goes_on_after(RunEvent::WholeMesh, seed);
    }
}

/// Errors of masses after a remeshing, and gel cut off a wall, were once compressed against the bulk modulus: 142, 48
/// and 19 % of the energy. 191 and 194 were stopped by it. Of 111 an element that filled a gap was drawn together: 141
/// %.
#[test]
fn a_remeshing_stores_little_in_a_stiff_volume() {
    for (seed, most) in [(69, 0.1), (71, 0.05), (34, 0.12), (194, 0.1), (191, 0.3), (111, 0.05)] {
        let defect = goes_on_after(RunEvent::Remeshings, seed).defect;
        assert!(defect.abs() < most, "seed {seed}: {defect}");
    }
}

/// A patch of a compressed and an inverted element, of which an erosion takes the latter, once compressed the rest against the bulk
/// modulus: 172 % of the energy.
#[test]
fn an_erosion_stores_nothing_in_what_remains_of_a_patch() {
    let defect = goes_on_after(RunEvent::Erosion, 140).defect;
    assert!(defect.abs() < 0.03, "{defect}");
}

/// One patch had three times all of the energy (210), where the mean of F of what is turned against each other was all
/// but flat: the run had gained 114 % in the end. Operations give it 1.3 % at most. Nothing asks for a remeshing of
/// 403, which had gained 67 %.
#[test]
fn remeshings_do_not_feed_a_run() {
    let ride = goes_on_after(RunEvent::Remeshings, 210);
    assert!(ride.remesh <= 0.02 && ride.defect.abs() < 0.2, "{ride:?}");
    let ride = goes_to_its_end(403);
    assert!(ride.remesh <= 0.0 && ride.defect.abs() < 0.05, "{ride:?}");
}

/// Five of 11 speeds from 35.5 to 36.1 m/s once stopped (580), that of the seed among them, and 35.0 m/s of five below;
/// 17 of 18 where the gel folded at the line between two planes of symmetry (178).
#[test]
fn speeds_beside_that_of_a_seed_do_not_stop_a_run() {
    goes_to_its_end(580);
    let beside = [
        (580, "-3.58e1", ["-3.5e1", "-3.55e1", "-3.579e1"], RunEvent::Remeshings),
        (178, "-4.34e1", ["-4.338e1", "-4.35e1", "-4.38e1"], RunEvent::Erosion),
    ];
    for (seed, own, speeds, event) in beside {
        let text = ranges::text(seed);
        for speed in speeds {
            let other = text.replace(own, speed);
            assert_ne!(other, text);
            let ride = ride::ride(&other);
            assert_eq!(ride.stop, None, "{speed} m/s: {ride:?}");
            assert!(ride.closure[0] < 1e-10 && ride.mass < 1e-11 && event.is_in(&ride), "{speed} m/s: {ride:?}");
        }
    }
}
