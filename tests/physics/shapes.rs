//! Capsules and bullets in whole scenes: they are what they look like, they turn as they should, and they do not leak.

use crate::deepest;
use ballistic_gel::geometry::SignedDistance as _;
use ballistic_gel::math::Vector3;
use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};
use deepest::deepest;

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

/// Runs to the end in equal slices, and shows each to `look`.
fn run(scene: &Scene, slices: u32, mut look: impl FnMut(&Simulation)) -> Simulation {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, 1).unwrap();
    for slice in 1..=slices {
        let inputs = simulation.inputs();
        simulation.step(&inputs, scene.scene.end_time * f64::from(slice) / f64::from(slices)).unwrap();
        look(&simulation);
    }
    simulation
}

/// Without contact of facets with the end of the body, the pointed one is 1.7 cells deep in a facet and gets half of the impulse.
#[test]
fn a_pointed_bullet_does_not_slip_through_the_surface() {
    for tip in [["2e-3", "1e-3"], ["0.5e-3", "0.0"], ["0.0", "0.0"]] {
        for (size, x, impulse) in [(8e-3, 0.0, 0.146), (8e-3, 1e-3, 0.146), (5e-3, 0.0, 0.130), (5e-3, 1e-3, 0.130)] {
            let changes = [
                format!("projectile.shape.bullet.nose.ogive.meplat_radius={}", tip[0]),
                format!("projectile.shape.bullet.edge_radius={}", tip[1]),
                format!("projectile.position=[{x:e}, 0, 0.041]"),
                format!("mesh.size={size:e}"),
            ];
            let scene = with(OGIVE, &changes.each_ref().map(String::as_str));
            let mut most: f64 = 0.0;
            let last = run(&scene, 40, |now| most = most.max(deepest(&now.frame(), &scene, 12))).observe();
            assert!(most < 0.35 * size, "{changes:?}: {} cells deep", most / size);
            let received = last.projectile().contact.total_impulse.norm();
            assert!((received / impulse - 1.0).abs() < 0.04, "{changes:?}: {received} N s");
            assert!(last.energy.energy_error < 1e-10 && last.energy.energy_defect < 2e-3, "{:?}", last.energy);
        }
    }
}

#[test]
fn a_ball_described_as_a_bullet_meets_the_gel_like_a_sphere() {
    let ball = "projectile.shape={bullet={radius=0.01, length=0.02, nose='round', edge_radius=0.01}}";
    let capsule = "projectile.shape={capsule={radius=0.01, length=0.02}}";
    let place = ["projectile.position=[0, 0, 0.01]", "mesh.size=8e-3"];
    let end = |shape: &str| {
        let scene = with(OGIVE, &[&[shape], &place[..]].concat());
        let last = run(&scene, 1, |_| {}).observe();
        (last.projectile().contact.total_impulse.z, last.projectile().contact.peak_depth.0)
    };
    let sphere = end("projectile.shape={sphere={radius=0.01}}");
    for shape in [ball, capsule] {
        let (impulse, depth) = end(shape);
        assert!((impulse / sphere.0 - 1.0).abs() < 1e-6 && (depth / sphere.1 - 1.0).abs() < 1e-6, "{shape}");
    }
}

#[test]
fn a_tilted_spinning_bullet_has_the_same_bits_in_any_slices_and_keeps_the_books() {
    let tilted = ["projectile.orientation=[0.995, 0.0, 0.0998, 0.0]", "projectile.position=[0, 0, 0.039]"];
    let pointed = ["projectile.shape.bullet={edge_radius=0.0, radius=0.01, length=0.06, nose={ogive={length=0.03}}}"];
    let scene = with(OGIVE, &[&tilted[..], &pointed, &["mesh.size=8e-3"]].concat());
    let [one, many] = [1, 77].map(|slices| run(&scene, slices, |_| {}));
    assert_eq!(one.digest(), many.digest());
    let last = one.observe();
    assert!(last.projectile().contact.total_impulse.norm() > 0.05 && last.energy.energy_error < 1e-10);
    assert!(last.momentum_error < 1e-12 && last.angular_momentum_error < 1e-12);
}

#[test]
fn bullets_in_the_plane_and_on_the_axis_start_at_their_centre_of_mass_and_rebound() {
    let planar = ["scene.dimension=planar", "gel.shape.block.size=[0.1, 0.05]", "projectile.mass=12.0"];
    let axisymmetric = ["scene.dimension=axisymmetric", "gel.shape={cylinder={radius=0.05, height=0.05}}"];
    let cone = "projectile.shape={bullet={radius=0.02, length=0.06, nose={cone={length=0.06}}}}";
    // Of the length from the base: a third of a triangle, a quarter of a cone.
    for (changes, behind_tip) in [(&planar[..], 0.04), (&axisymmetric[..], 0.045)] {
        let still = ["projectile.angular_velocity=[0, 0, 0]", "mesh.size=5e-3", "projectile.position=[0, 0, 0.05]"];
        let scene = with(OGIVE, &[changes, &[cone], &still[..]].concat());
        let down = scene.shape(0).reach(&-Vector3::z());
        assert!((down - behind_tip).abs() < 1e-15, "{down}");
        let last = run(&scene, 1, |_| {}).observe();
        assert!(
            last.projectile().contact.total_impulse.z > 0.0 && last.energy.energy_error < 1e-10,
            "{:?}",
            last.projectile().contact
        );
    }
}
