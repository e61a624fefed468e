//! The first touch in the engine: two bodies, an impulse, and a loss that is known before.

use super::shot::{Space, shot};
use super::whole::Whole;
use ballistic_gel::math::Vector3;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, MeshFrame, Simulation};

/// Restitution.
const RESTITUTION: [f64; 3] = [0.0, 0.5, 1.0];
/// So long before the tick of the touch, s; far less than a tick.
const JUST: f64 = 1e-10;

/// Single hits, then flat punches on many nodes.
pub fn study() {
    println!("| single hit | e | u⁺/u⁻ + e | P | L | loss, J | predicted, J |");
    println!("|---|---|---|---|---|---|---|");
    for e in RESTITUTION {
        for body in ["sphere", "cylinder on its rim, rounded", "capsule, tilted", "ogive, meplat"] {
            single(body, e);
        }
    }
    println!(
        "\n| flat punch, nodes | mass/contact mass | e | greatest |u⁺/u⁻ + e| | loss at first touch, mJ | predicted, mJ | loss at the end |"
    );
    println!("|---|---|---|---|---|---|---|");
    for ratio in [0.01, 0.1, 1.0, 10.0, 100.0, 1e4] {
        for e in RESTITUTION {
            punch(ratio, e);
        }
    }
}

/// Gel and body just before and just after the first impulse.
pub struct Touch {
    pub whole: Whole,
    pub before: MeshFrame,
    pub after: MeshFrame,
    /// Energy that the account of the contact lost, J.
    pub loss: f64,
    pub simulation: Simulation,
}

impl Touch {
    /// Runs a scene until gel and body touch, and again to just before.
    pub fn of(scene: &Scene) -> Self {
        let begin = || Simulation::new(scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
        let to = |simulation: &mut Simulation, time: f64| {
            let inputs = simulation.inputs();
            simulation.step(&inputs, time).expect("a gel that is hardly touched");
        };
        let mut scout = begin();
        while scout.observe().projectile().contact.first.is_none() {
            assert!(scout.time() < scene.scene.end_time, "the body does not touch the gel");
            let next = scout.time() + scene.scene.communication_step;
            to(&mut scout, next);
        }
        let first = scout.observe().projectile().contact.first.expect("they touch");
        let mut simulation = begin();
        let whole = Whole::of(&simulation, scene.gel.density);
        to(&mut simulation, first - JUST);
        let before = simulation.frame();
        to(&mut simulation, first);
        let (after, loss) = (simulation.frame(), -simulation.observe().energy.contact);
        Self { whole, before, after, loss, simulation }
    }

    /// The nodes that were struck; forces at rest are zero to rounding only, and move the others by that.
    pub fn struck(&self) -> Vec<usize> {
        let fastest = self.before.bodies[0].kinematics.velocity.norm();
        let moved =
            |node: &usize| (self.after.velocities[*node] - self.before.velocities[*node]).norm() > 1e-9 * fastest;
        (0..self.after.velocities.len()).filter(moved).collect()
    }

    /// Relative velocity of a node and the body's point there along `normal`, before and after, m/s.
    pub fn relative(&self, node: usize, normal: &Vector3) -> [f64; 2] {
        [&self.before, &self.after].map(|frame| {
            let body = &frame.bodies[0].kinematics;
            let arm = self.after.points[node] - self.after.bodies[0].kinematics.position;
            normal.dot(&(frame.velocities[node] - body.velocity - body.angular_velocity.cross(&arm)))
        })
    }
}

fn keys(e: f64) -> Vec<(&'static str, String)> {
    let keys = [("gel.supports.z_min", "free".to_owned()), ("contact.restitution", e.to_string())];
    // The removal of penetration would add its velocity to what the law leaves.
    keys.into_iter().chain([("contact.bias", "0".to_owned())]).collect()
}

/// One node, hit off the body's centre by one that moves and spins.
pub fn single_scene(body: &str, e: f64) -> Scene {
    let mut keys = keys(e);
    keys.push(("projectile.velocity", "[0.5, 0.2, -5.0]".to_owned()));
    keys.push(("projectile.angular_velocity", "[5.0, -8.0, 60.0]".to_owned()));
    shot((Space::Spatial, body), [0.0, 0.0], &keys)
}

fn single(body: &str, e: f64) {
    let touch = Touch::of(&single_scene(body, e));
    let struck = touch.struck();
    assert_eq!(struck.len(), 1, "{body} hits one node first");
    let [was, now] = touch.relative(struck[0], &normal(&touch, struck[0]));
    let drift = touch.whole.momenta(&touch.after).drift(&touch.whole.momenta(&touch.before));
    let lost = touch.whole.kinetic_energy(&touch.before) - touch.whole.kinetic_energy(&touch.after);
    println!(
        "| {body} | {e} | {:.0e} | {:.0e} | {:.0e} | {lost:.10} | {:.10} |",
        (now / was + e).abs(),
        drift.0,
        drift.1,
        predicted(&touch, struck[0], e),
    );
}

/// Direction in which the node was pushed.
pub fn normal(touch: &Touch, node: usize) -> Vector3 {
    (touch.after.velocities[node] - touch.before.velocities[node]).normalize()
}

/// (1 − e²)/2 u²/K.
pub fn predicted(touch: &Touch, node: usize, e: f64) -> f64 {
    let normal = normal(touch, node);
    let approach = touch.relative(node, &normal)[0];
    let arm = touch.after.points[node] - touch.after.bodies[0].kinematics.position;
    let compliance = 1.0 / touch.whole.nodes[node] + touch.whole.compliance(&touch.after, &arm, &normal);
    (1.0 - e * e) / 2.0 * approach * approach / compliance
}

/// A flat punch on many nodes at once.
pub struct Punch {
    pub nodes: usize,
    /// Greatest |u⁺/u⁻ + e| of the nodes.
    pub restitution: f64,
    /// Energy lost at the first touch, measured and (1 − e²)/2 m M/(m + M) v², J.
    pub loss: f64,
    pub predicted: f64,
    simulation: Simulation,
}

impl Punch {
    /// A cylinder so many times heavier than the nodes that it meets.
    pub fn of(ratio: f64, e: f64) -> Self {
        let punch = |mass: &str| {
            let keys = keys(e).into_iter().chain([("projectile.mass", mass.to_owned())]);
            shot((Space::Spatial, "cylinder"), [0.0, 0.0], &keys.collect::<Vec<_>>())
        };
        let probe = Touch::of(&punch("1.0"));
        let nodes = probe.struck();
        let contact: f64 = nodes.iter().map(|node| probe.whole.nodes[*node]).sum();
        let scene = punch(&format!("{:e}", ratio * contact));
        let touch = Touch::of(&scene);
        let defect = |node: &usize| {
            let [was, now] = touch.relative(*node, &-Vector3::z());
            (now / was + e).abs()
        };
        let reduced = contact * ratio / (1.0 + ratio);
        Self {
            nodes: nodes.len(),
            restitution: nodes.iter().map(defect).fold(0.0, f64::max),
            loss: touch.loss,
            predicted: 0.5 * (1.0 - e * e) * reduced * scene.projectile.velocity[2].powi(2),
            simulation: touch.simulation,
        }
    }
}

fn punch(ratio: f64, e: f64) {
    let Punch { nodes, restitution, loss, predicted, mut simulation } = Punch::of(ratio, e);
    let inputs = simulation.inputs();
    let end = match simulation.step(&inputs, 5e-3) {
        Ok(()) => format!("{:.4}", -1e3 * simulation.observe().energy.contact),
        Err(error) => error.to_string(),
    };
    println!("| {nodes} | {ratio} | {e} | {restitution:.0e} | {:.6} | {:.6} | {end} |", 1e3 * loss, 1e3 * predicted);
}
