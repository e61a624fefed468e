//! A rigid bullet in gel by the yaw with which it comes: yaw against depth, the length of the neck, and the law of the hyperbolic cosine.

use super::cpu::seconds;
use super::run::{scene, tell_refusals};
use ballistic_gel::geometry::SignedDistance as _;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::f64::consts::PI;
use std::io::Write as _;

/// Yaw at the start, degrees, and cells around the bullet, mm: at its tip and where sheets are thin they are finer in proportion.
const RUNS: [(f64, f64); 4] = [(8.0, 1.3), (4.0, 1.3), (2.0, 1.3), (8.0, 1.0)];
/// Between two looks, s.
const LOOK: f64 = 1e-6;
/// Ways of the bullet in gel at which yaws are compared, mm.
const WAYS: [f64; 8] = [20.0, 40.0, 60.0, 80.0, 100.0, 120.0, 140.0, 160.0];
/// Where the neck ends, degrees of yaw; the law is of small angles.
const NECK: f64 = 30.0;
/// A run need not go on when the bullet is turned by so much, degrees.
const OVER: f64 = 60.0;
/// The law is fitted between this many times the yaw of the start and this yaw, degrees.
const FITTED: (f64, f64) = (1.2, 15.0);

/// The bullet at a look.
struct Seen {
    /// Way of the centre of mass since the tip touched the gel, m.
    way: f64,
    /// Between axis and velocity, rad.
    yaw: f64,
    /// Across, m.
    aside: f64,
    /// Along −z, m/s.
    speed: f64,
}

/// Yaws by way; then the necks and the laws.
pub fn study() {
    let ways: Vec<String> = WAYS.iter().map(|way| format!(" {way} mm |")).collect();
    println!(
        "| yaw, ° | h, mm |{} neck to {NECK}°, mm | L, mm | x₀, mm | C_Mα | law, mm | aside, mm | m/s | meshes | refused | elements | M updates | bias, % of E₀ | remesh | closure | end | CPU s |",
        ways.concat()
    );
    println!("|---|---|{}---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|", "---|".repeat(WAYS.len()));
    RUNS.into_iter().for_each(row);
}

/// `bullet-yaw` with another yaw and another mesh.
fn shot(degrees: f64, size: f64) -> Scene {
    let half = 0.5 * degrees.to_radians();
    let length = |part: f64| format!("{:e}", 1e-3 * size * part);
    let keys = [
        ("projectile.orientation", format!("[{:?}, 0.0, {:?}, 0.0]", half.cos(), half.sin())),
        ("scene.end_time", "0.24e-3".to_owned()),
        ("mesh.size", length(1.0)),
        ("remesh.smallest", length(0.4)),
        ("remesh.tip", length(0.3)),
        ("remesh.thinnest", length(0.2)),
    ];
    scene("bullet-yaw", &keys)
}

fn row((degrees, size): (f64, f64)) {
    let scene = shot(degrees, size);
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let begun = seconds();
    let (seen, end) = fly(&scene, &mut simulation);
    let cpu = seconds() - begun;
    tell_refusals(&format!("{degrees}°"), &simulation);
    let observation = simulation.observe();
    let (cost, energy) = (&observation.cost, &observation.energy);
    println!(
        "| {degrees} | {size} |{} {} | {} | {} | {:.1} | {:+.2} | {:+.2} | {:.0e} | {end} | {cpu:.0} |",
        curve(&seen),
        law(&scene, degrees, &seen),
        cost.remeshes,
        simulation.refusals().len(),
        format_args!("{} | {:.0}", cost.elements, 1e-6 * cost.element_updates),
        100.0 * energy.contact_bias / energy.initial,
        100.0 * energy.remesh / energy.initial,
        energy.energy_error,
    );
    std::io::stdout().flush().expect("a terminal");
}

/// Flies on until the bullet is turned over, the time is over, or the run stops; how it was on the way, and why it ended.
fn fly(scene: &Scene, simulation: &mut Simulation) -> (Vec<Seen>, String) {
    let inputs = simulation.inputs();
    let touch = scene.projectile.position[2] + simulation.depth(0);
    let mut seen = vec![];
    for look in 1..=(scene.scene.end_time / LOOK).round() as u32 {
        let end = simulation.step(&inputs, LOOK * f64::from(look));
        let now = simulation.kinematics(0);
        let (way, aside, speed) = (touch - now.position.z, now.position.x, -now.velocity.z);
        seen.push(Seen { way, yaw: now.yaw(), aside, speed });
        if let Err(why) = end {
            eprintln!("{why}");
            return (seen, format!("stops at {:.1} mm", 1e3 * way));
        }
        if now.yaw().to_degrees() > OVER {
            return (seen, format!("{OVER}° at {:.1} mm", 1e3 * way));
        }
    }
    let last = seen.last().map_or(0.0, |last| last.way);
    (seen, format!("at {:.1} mm", 1e3 * last))
}

/// Yaw at the ways of the table, degrees.
fn curve(seen: &[Seen]) -> String {
    let yaw = |way: &f64| match between(seen, |seen| seen.way - 1e-3 * way) {
        Some((a, b, share)) => format!(" {:.2} |", (a.yaw + share * (b.yaw - a.yaw)).to_degrees()),
        None => " – |".to_owned(),
    };
    WAYS.iter().map(yaw).collect()
}

/// The looks between which something rises through zero, and where.
fn between(seen: &[Seen], height: impl Fn(&Seen) -> f64) -> Option<(&Seen, &Seen, f64)> {
    let pair = seen.windows(2).find(|pair| height(&pair[0]) < 0.0 && height(&pair[1]) >= 0.0)?;
    let (below, above) = (height(&pair[0]), height(&pair[1]));
    Some((&pair[0], &pair[1], below / (below - above)))
}

/// Neck, the law's length L and way x₀ at which it begins, C_Mα, the neck by that law, and how the bullet is at the end of its neck.
fn law(scene: &Scene, degrees: f64, seen: &[Seen]) -> String {
    let start = degrees.to_radians();
    let (length, begin) = fitted(start, seen);
    let neck = between(seen, |seen| seen.yaw - NECK.to_radians());
    let by_law = begin + length * (NECK / degrees).acosh();
    let at_neck = neck.map_or("– | –".to_owned(), |(a, ..)| format!("{:.2} | {:.0}", 1e3 * a.aside, a.speed));
    let neck = neck.map_or("–".to_owned(), |(a, b, share)| format!("{:.1}", 1e3 * (a.way + share * (b.way - a.way))));
    format!(
        "{neck} | {:.1} | {:.1} | {:.2} | {:.1} | {at_neck}",
        1e3 * length,
        1e3 * begin,
        coefficient(scene, length),
        1e3 * by_law
    )
}

/// L and x₀ of θ = θ₀ cosh((x − x₀)/L): the straight line through arcosh(θ/θ₀) against x.
fn fitted(start: f64, seen: &[Seen]) -> (f64, f64) {
    let range = FITTED.0 * start..FITTED.1.to_radians();
    let points: Vec<(f64, f64)> = seen
        .iter()
        .filter(|seen| range.contains(&seen.yaw))
        .map(|seen| (seen.way, (seen.yaw / start).acosh()))
        .collect();
    let n = points.len() as f64;
    let [x, y] = [points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n];
    let (over, under) =
        points.iter().fold((0.0, 0.0), |(xy, xx), p| (xy + (p.0 - x) * (p.1 - y), xx + (p.0 - x) * (p.0 - x)));
    let slope = over / under;
    (1.0 / slope, x - y / slope)
}

/// C_Mα = 2 I/(ρ A d L²), A = πd²/4.
fn coefficient(scene: &Scene, length: f64) -> f64 {
    let projectile = &scene.projectile;
    let ballistic_gel::scene::BodyShape::Bullet(bullet) = &projectile.shape else { panic!("a bullet") };
    let inertia = projectile.mass.expect("a mass") * scene.shape(0).specific_inertia().expect("a solid")[(0, 0)];
    let d = 2.0 * bullet.radius;
    2.0 * inertia / (scene.gel.density * 0.25 * PI * d * d * d * length * length)
}
