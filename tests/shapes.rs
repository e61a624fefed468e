//! Capsules and bullets in whole scenes: they are what they look like, they turn as they should, and they do not leak.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use ballistic_gel::algebra::Vector3;
use ballistic_gel::geometry::SignedDistance as _;
use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Frame, Simulation};
use nalgebra::{Quaternion, UnitQuaternion};

/// A spinning bullet of 20 mm calibre, point first, slow.
const OGIVE: &str = r#"
[scene]
name = "ogive"
dimension = "spatial"
end_time = 4e-3
communication_step = 1e-4
[gel]
shape.block.size = [0.1, 0.1, 0.05]
material = "neo-hookean"
density = 1030.0
shear_modulus = 69e3
bulk_modulus = 667e3
supports.z_min = "fixed"
[projectile]
shape.bullet.radius = 0.010
shape.bullet.length = 0.060
shape.bullet.nose.ogive = { length = 0.030, meplat_radius = 2e-3 }
shape.bullet.tail = { length = 0.010, radius = 8e-3 }
shape.bullet.edge_radius = 1e-3
mass = 0.12
position = [0.0, 0.0, 0.036]
velocity = [0.0, 0.0, -8.0]
angular_velocity = [0.0, 0.0, -800.0]
[mesh]
size = 5e-3
"#;

fn with(base: &str, changes: &[&str]) -> Scene {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    scene::read(&scene::resolve(base, &changes).unwrap()).unwrap_or_else(|error| panic!("{error}"))
}

fn run(scene: &Scene, slices: u32) -> Simulation {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, 1).unwrap();
    for slice in 1..=slices {
        let inputs = simulation.inputs();
        simulation.step(&inputs, scene.scene.end_time * f64::from(slice) / f64::from(slices)).unwrap();
    }
    simulation
}

/// Depth of the deepest point of the gel's surface inside the projectile, m: of nodes, and of points all over the facets.
fn deepest(frame: &Frame, scene: &Scene) -> (f64, f64) {
    const N: u32 = 12;
    let shape = scene.projectile_shape();
    let [w, x, y, z] = frame.projectile.orientation;
    let turn = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    let depth = |p: &Vector3| -shape.gap(&turn.inverse_transform_vector(&(p - frame.projectile.position))).distance;
    let nodes = frame.cells.facets.iter().flatten().map(|node| depth(&frame.points[*node as usize]));
    let spread = |facet: &[u32; 3]| {
        let [a, b, c] = facet.map(|node| frame.points[node as usize]);
        let point = move |i: u32, j: u32| a + ((b - a) * f64::from(i) + (c - a) * f64::from(j)) / f64::from(N);
        (0..=N).flat_map(move |i| (0..=N - i).map(move |j| point(i, j)))
    };
    let all = frame.cells.facets.iter().flat_map(spread).map(|p| depth(&p));
    (nodes.fold(0.0, f64::max), all.fold(0.0, f64::max))
}

#[test]
fn probe() {
    for (meplat, edge) in [("2e-3", "1e-3"), ("0.0", "0.0"), ("0.5e-3", "0.0")] {
        for size in ["8e-3", "5e-3", "4e-3", "3e-3"] {
            for x in ["0.0", "1e-3"] {
                let scene = with(
                    OGIVE,
                    &[
                        &format!("projectile.shape.bullet.nose.ogive.meplat_radius={meplat}"),
                        &format!("projectile.shape.bullet.edge_radius={edge}"),
                        &format!("projectile.position=[{x}, 0, 0.041]"),
                        &format!("mesh.size={size}"),
                    ],
                );
                let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
                let mut most = (0.0, 0.0);
                let mut failed = None;
                for slice in 1..=40 {
                    let inputs = simulation.inputs();
                    if let Err(e) = simulation.step(&inputs, scene.scene.end_time * f64::from(slice) / 40.0) {
                        failed = Some(e);
                        break;
                    }
                    let (n, f) = deepest(&simulation.frame(), &scene);
                    most = (f64::max(most.0, n), f64::max(most.1, f));
                }
                let h = scene.mesh.size;
                let o = simulation.observe();
                println!(
                    "meplat {meplat} h {size} x {x}: nodes {:.3} facets {:.3} h, {:.3} mm, impulse {:.4}, depth {:.5} defect {:.1e} v {:?} {:?}",
                    most.0 / h,
                    most.1 / h,
                    most.1 * 1e3,
                    o.contact.total_impulse.norm(),
                    o.contact.peak_depth.0,
                    o.energy.energy_defect,
                    o.projectile.velocity.z,
                    failed
                );
            }
        }
    }
}
