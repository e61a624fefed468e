//! A rigid bullet in gel by the yaw with which it comes: yaw against depth, what turns it over, and the neck by the law of the
//! hyperbolic cosine.

use super::cpu::seconds;
use super::run::{scene, tell_refusals};
use ballistic_gel::geometry::SignedDistance as _;
use ballistic_gel::scene::{BodyShape, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::f64::consts::PI;
use std::io::Write as _;

/// Yaw at the start, degrees.
const YAWS: [f64; 3] = [8.0, 4.0, 2.0];
/// Between two looks, s.
const LOOK: f64 = 1e-6;
/// Ways of the bullet in gel at which yaws are compared, mm.
const WAYS: [f64; 7] = [15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0];
/// When a shot ends that has not stopped before, s: some 120 mm deep.
const END: &str = "150e-6";
/// Where the neck ends, degrees of yaw.
const NECK: f64 = 30.0;
/// Way from which on the ogive is in the gel and coefficients are taken, m.
const IMMERSED: f64 = 15e-3;
/// The law is fitted where the yaw is more than so many times that of the start.
const GROWN: f64 = 1.03;

/// The bullet at a look.
struct Seen {
    time: f64,
    /// Way of the centre of mass since the tip touched the gel, m.
    way: f64,
    /// Between axis and velocity, rad.
    yaw: f64,
    /// Between the line of fire and the velocity, rad.
    path: f64,
    /// m/s.
    speed: f64,
    /// rad/s.
    spin: f64,
}

/// Yaws by way, coefficients, and the law.
pub fn study() {
    let ways: Vec<String> = WAYS.iter().map(|way| format!(" {way} mm |")).collect();
    println!(
        "| yaw, ° |{} C_Mα | C_Lα | C_D | L of it, mm | L fitted, mm | x₀, mm | neck to 30° by the law, mm | meshes | refused | elements | M updates | bias, % of E₀ | remesh | closure | end, mm | CPU s |",
        ways.concat()
    );
    println!("|---|{}---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|", "---|".repeat(WAYS.len()));
    YAWS.into_iter().for_each(row);
}

/// `bullet-yaw` with this yaw.
fn row(degrees: f64) {
    let half = 0.5 * degrees.to_radians();
    let turned = format!("[{:?}, 0.0, {:?}, 0.0]", half.cos(), half.sin());
    let scene = scene("bullet-yaw", &[("projectile.orientation", turned), ("scene.end_time", END.to_owned())]);
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let begun = seconds();
    let seen = fly(&scene, &mut simulation);
    let cpu = seconds() - begun;
    tell_refusals(&format!("{degrees}°"), &simulation);
    let observation = simulation.observe();
    let (cost, energy) = (&observation.cost, &observation.energy);
    println!(
        "| {degrees} |{}{} {} | {} | {} | {:.1} | {:+.2} | {:+.2} | {:.0e} | {:.1} | {cpu:.0} |",
        curve(&seen),
        law(&scene, degrees, &seen),
        cost.remeshes,
        simulation.failed_remeshings().len(),
        cost.elements,
        1e-6 * cost.element_updates,
        100.0 * energy.contact_bias / energy.initial,
        100.0 * energy.remesh_net() / energy.initial,
        energy.energy_error,
        1e3 * seen.last().map_or(0.0, |last| last.way),
    );
    std::io::stdout().flush().expect("a terminal");
}

/// How the bullet was on its way.
fn fly(scene: &Scene, simulation: &mut Simulation) -> Vec<Seen> {
    let inputs = simulation.inputs();
    let touch = scene.projectile.position[2] + simulation.depth(0);
    let mut seen = vec![];
    for look in 1..=(scene.scene.end_time / LOOK).round() as u32 {
        if let Err(why) = simulation.step(&inputs, LOOK * f64::from(look)) {
            eprintln!("{why}");
            break;
        }
        let now = simulation.kinematics(0);
        seen.push(Seen {
            time: simulation.time(),
            way: touch - now.position.z,
            yaw: now.yaw_from(&simulation.block_motion().velocity),
            path: (-now.velocity.x).atan2(-now.velocity.z),
            speed: now.velocity.norm(),
            spin: now.angular_velocity.y,
        });
    }
    seen
}

/// Yaw at the ways of the table, degrees.
fn curve(seen: &[Seen]) -> String {
    let yaw = |way: &f64| {
        let way = 1e-3 * way;
        let pair = seen.windows(2).find(|pair| pair[0].way < way && pair[1].way >= way);
        pair.map_or(" – |".to_owned(), |pair| {
            let share = (way - pair[0].way) / (pair[1].way - pair[0].way);
            format!(" {:.3} |", (pair[0].yaw + share * (pair[1].yaw - pair[0].yaw)).to_degrees())
        })
    };
    WAYS.iter().map(yaw).collect()
}

/// Coefficients of what turns, deflects and slows the bullet once its nose is in the gel, L of the first, L and x₀ of the fit, and the
/// neck x₀ + L arcosh(30°/θ₀).
fn law(scene: &Scene, degrees: f64, seen: &[Seen]) -> String {
    let BodyShape::Bullet(bullet) = &scene.projectile.shape else { panic!("a bullet") };
    let mass = scene.projectile.mass.expect("a mass");
    let inertia = mass * scene.shape(0).specific_inertia().expect("a solid")[(0, 0)];
    let d = 2.0 * bullet.radius;
    let dense = scene.gel.density * 0.25 * PI * d * d;
    let first = seen.partition_point(|seen| seen.way < IMMERSED);
    let (Some(a), Some(b)) = (seen.get(first), seen.last()) else {
        return " – | – | – | – | – | – | – |".to_owned();
    };
    let sum = |f: &dyn Fn(&Seen, &Seen) -> f64| seen[first..].windows(2).map(|pair| f(&pair[0], &pair[1])).sum::<f64>();
    let turning = sum(&|p, q| 0.5 * (p.yaw * p.speed * p.speed + q.yaw * q.speed * q.speed) * (q.time - p.time));
    let moment = 2.0 * inertia * (b.spin - a.spin) / (dense * d * turning);
    let lift = 2.0 * mass * (b.path - a.path) / (dense * sum(&|p, q| 0.5 * (p.yaw + q.yaw) * (q.way - p.way)));
    let drag = 2.0 * mass * (a.speed / b.speed).ln() / (dense * (b.way - a.way));
    let (length, begin) = fitted(degrees.to_radians(), seen);
    format!(
        " {moment:.2} | {lift:.2} | {drag:.3} | {:.1} | {:.1} | {:.1} | {:.0} |",
        1e3 * (2.0 * inertia / (dense * d * moment)).sqrt(),
        1e3 * length,
        1e3 * begin,
        1e3 * (begin + length * (NECK / degrees).acosh())
    )
}

/// L and x₀ of θ = θ₀ cosh((x − x₀)/L): the straight line through arcosh(θ/θ₀) against x.
fn fitted(start: f64, seen: &[Seen]) -> (f64, f64) {
    let grown = seen.iter().filter(|seen| seen.yaw > GROWN * start);
    let points: Vec<(f64, f64)> = grown.map(|seen| (seen.way, (seen.yaw / start).acosh())).collect();
    let n = points.len() as f64;
    let [x, y] = [points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n];
    let (over, under) =
        points.iter().fold((0.0, 0.0), |(xy, xx), p| (xy + (p.0 - x) * (p.1 - y), xx + (p.0 - x) * (p.0 - x)));
    let slope = over / under;
    (1.0 / slope, x - y / slope)
}
