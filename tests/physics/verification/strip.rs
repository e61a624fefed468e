//! The bar of triangles and tetrahedra: a slender block without Poisson effect, flung at a rigid wall at 10⁻⁴ wave speeds.

use super::row::{Row, order, series};
use ballistic_gel::scene::{self, Override};
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::sync::OnceLock;

/// Unit length, density and wave speed (λ = 0, μ = 1/2); the wall is met after a tenth of the time of contact.
const SCENE: &str = r#"
[scene]
name = "strip"
dimension = "planar"
end_time = 2.5
communication_step = 2.5
[gel]
shape.block.size = [0.1, 1.0]
material = "neo-hookean"
density = 1.0
shear_modulus = 0.5
bulk_modulus = 0.33333333333333337
velocity = [0.0, 0.0, -1e-4]
[projectile]
shape.half-space.normal = [0.0, 0.0, 1.0]
position = [0.0, 0.0, -1.00002]
fixed = true
[mesh]
size = 0.1
[integrator]
cfl = 0.5
[contact]
bias = 0.0
"#;

const SPEED: f64 = 1e-4;

/// What the wall received over 2 m v₀, minus 1; the work of the contact over the energy; duration of the contact, s.
struct Bounce {
    impulse: f64,
    loss: f64,
    lasted: f64,
}

fn bounce(strip: &Strip, size: f64) -> Bounce {
    let size = format!("mesh.size={size}");
    let changes = strip.dimension.iter().copied().chain([size.as_str()]);
    let changes: Vec<Override> = changes.map(|change| change.parse().expect("a change is key=value")).collect();
    let text = scene::resolve(SCENE, &changes).expect("the scene is TOML");
    let scene = scene::read(&text).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("the scene is small");
    let inputs = simulation.inputs();
    simulation.step(&inputs, scene.scene.end_time).expect("the impact is gentle");
    let seen = simulation.observe();
    assert!(seen.energy.energy_error < 1e-10, "the books close");
    Bounce {
        impulse: -seen.projectile().contact.total_impulse.z / (2.0 * strip.mass * SPEED) - 1.0,
        loss: seen.energy.contact / seen.energy.initial,
        lasted: seen.projectile().contact.last.unwrap_or(0.0) - seen.projectile().contact.first.unwrap_or(0.0),
    }
}

/// A slender block: what it is made of, what sets its dimension, its mass, and the share of a cell's mass that is at the
/// nodes of its lower face.
struct Strip {
    what: &'static str,
    dimension: &'static [&'static str],
    mass: f64,
    share: (f64, &'static str),
    sizes: [f64; 3],
}

const PLANAR: Strip = Strip {
    what: "crossed triangles, N = 20/40/80",
    dimension: &[],
    mass: 0.1,
    share: (1.0 / 3.0, "−h/3"),
    sizes: [0.05, 0.025, 0.0125],
};
const SPATIAL: Strip = Strip {
    what: "tetrahedra, N = 10/20/40",
    dimension: &["scene.dimension=spatial", "gel.shape.block.size=[0.1, 0.1, 1.0]"],
    mass: 0.01,
    share: (7.0 / 24.0, "−7h/24"),
    sizes: [0.1, 0.05, 0.025],
};

/// The impulse converges as in the bar of springs: with h^(2/3), the width of the front after a time. What the contact
/// takes is known beforehand: the energy of the nodes that stop.
fn rows_of(strip: &Strip) -> [Row; 2] {
    let runs = strip.sizes.map(|size| bounce(strip, size));
    let points: Vec<(f64, f64)> = strip.sizes.iter().zip(&runs).map(|(h, run)| (*h, run.impulse)).collect();
    let slope = order(&points);
    let met = (slope - 2.0 / 3.0).abs() < 0.2 && points.iter().all(|(_, error)| error.abs() < 0.03);
    let what = format!("slender block at 1e-4 c on a rigid wall, {}: error of the impulse, %", strip.what);
    let percent = points.iter().map(|(_, error)| 100.0 * error);
    let impulse = Row::new(("V5", &what), "below 3, slope 2/3 ± .2", series(percent, 2), met).with_order(slope);
    let scaled = strip.sizes.iter().zip(&runs).map(|(h, run)| run.loss / (-strip.share.0 * h));
    let met = scaled.clone().all(|s| (s - 1.0).abs() < 1e-6) && (runs[2].lasted - 2.0).abs() < 0.05;
    let what =
        format!("same: work of the contact over {} of the energy; duration of the contact, finest, L/c", strip.share.1);
    let obtained = format!("{}; {:.2}", series(scaled, 4), runs[2].lasted);
    [impulse, Row::new(("V5", &what), "1 ± 1e-6; 2.00 ± .05", obtained, met)]
}

/// The rows of this part, computed once.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| [PLANAR, SPATIAL].iter().flat_map(rows_of).collect())
}

#[test]
fn a_slender_block_bounces_like_a_bar() {
    Row::check(rows());
}
