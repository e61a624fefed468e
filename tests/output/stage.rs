//! A scene, and what an observer might see of it: a dent that grows and shrinks under a ball.

use ballistic_gel::math::Vector3;
use ballistic_gel::scene::{Dimension, Scene};
use ballistic_gel::simulation::{
    BlockMotion, BodyKinematics, BodyPose, BodyReport, ContactReport, CostReport, EnergyReport, FrameCells,
    ImpulseExchange, MeshFrame, Observation,
};
use std::f64::consts::PI;

/// Cells along an edge of the block.
const CELLS: u32 = 12;
const DEPTH: f64 = 0.014;
const SPEED: f64 = 5.0;

/// A ball of 10 mm above a gel of 0.1 m edge and 0.05 m height.
#[allow(dead_code, reason = "not every test that uses this file needs it")]
pub fn scene(dimension: &str) -> Scene {
    scene_of_ball(dimension, 0.01)
}

/// A ball of this radius, m, above the gel.
pub fn scene_of_ball(dimension: &str, radius: f64) -> Scene {
    let shape = match dimension {
        "axisymmetric" => "cylinder = { radius = 0.05, height = 0.05 }",
        "planar" => "block = { size = [0.1, 0.05] }",
        _ => "block = { size = [0.1, 0.1, 0.05] }",
    };
    let text = format!(
        "[scene]\nname = \"dent\"\ntitle = \"A ball < dents > a gel & leaves\"\ndimension = \"{dimension}\"\n\
         end_time = 0.01\ncommunication_step = 0.0002\n\
         [gel]\nmaterial = \"neo-hookean\"\ndensity = 1030.0\nshear_modulus = 69e3\nbulk_modulus = 667e3\n\
         [gel.shape]\n{shape}\n\
         [projectile]\nmass = 0.033\nposition = [0, 0, {radius}]\nvelocity = [0, 0, -5]\nshape = {{ sphere = {{ radius = {radius} }} }}\n\
         [mesh]\nsize = 0.008\n[output]\nframes = 11\n"
    );
    toml::from_str(&text).unwrap()
}

fn depth(scene: &Scene, time: f64) -> f64 {
    DEPTH * (PI * time / scene.scene.end_time).sin()
}

fn ball(scene: &Scene, time: f64) -> BodyKinematics {
    let rate = PI / scene.scene.end_time;
    BodyKinematics {
        position: Vector3::new(0.0, 0.0, 0.01 - depth(scene, time)),
        velocity: Vector3::new(0.0, 0.0, -DEPTH * rate * (rate * time).cos()),
        orientation: [1.0, 0.0, 0.0, 0.0],
        angular_velocity: Vector3::zeros(),
    }
}

/// What an observer sees at `time`, s.
pub fn observation(scene: &Scene, time: f64) -> Observation {
    let projectile = ball(scene, time);
    let impulse = 0.033 * (projectile.velocity - ball(scene, 0.0).velocity);
    let duration = scene.scene.communication_step;
    let body = BodyReport {
        kinematics: projectile,
        active: true,
        shape_motion: None,
        depth: depth(scene, time),
        exchange: ImpulseExchange { duration, impulse: 0.02 * impulse, ..ImpulseExchange::default() },
        contact: contact(scene, time, impulse),
        exit: None,
        energy_deposited: 0.5 * 0.033 * (SPEED * SPEED - projectile.velocity.norm_squared()),
    };
    Observation {
        time,
        bodies: vec![body],
        sensors: vec![],
        energy: energy(&projectile),
        momentum_imbalance: Vector3::new(1e-18, 0.0, -2e-18),
        angular_momentum_imbalance: Vector3::zeros(),
        momentum_error: 1e-15 * (1.0 + time),
        angular_momentum_error: 0.0,
        cost: cost(time),
        block: BlockMotion::default(),
        is_over: false,
    }
}

fn contact(scene: &Scene, time: f64, total_impulse: Vector3) -> ContactReport {
    ContactReport {
        total_impulse,
        active: time > 0.0,
        area: 1e-4,
        penetration: 1e-6,
        first: Some(1e-4),
        last: Some(time.min(0.8 * scene.scene.end_time)),
        peak_force: 45.5,
        peak_depth: (depth(scene, time.min(0.005)), time.min(0.005)),
        ..ContactReport::default()
    }
}

fn energy(ball: &BodyKinematics) -> EnergyReport {
    let (initial, projectile) = (0.5 * 0.033 * SPEED * SPEED, 0.5 * 0.033 * ball.velocity.norm_squared());
    let elastic = 0.9 * (initial - projectile);
    EnergyReport {
        kinetic: initial - elastic,
        projectile,
        elastic,
        contact: -0.001,
        initial,
        imbalance: 1e-16,
        energy_error: 1e-16,
        energy_defect: 2e-4,
        ..EnergyReport::default()
    }
}

fn cost(time: f64) -> CostReport {
    CostReport {
        element_updates: 1e9 * time,
        synchronous_updates: 3e9 * time,
        smallest_step: 1e-6,
        largest_step: 8e-6,
        elements: 6 * 12 * 12 * 12,
        nodes: 13 * 13 * 13,
        min_jacobian: 0.6,
        crushed_elements: 0,
        unconverged_solves: 3,
        remeshes: 0,
        eroded_mass: 0.0,
        incompatible_fraction: 0.0,
    }
}

/// The dented mesh at `time`, s.
pub fn frame(scene: &Scene, time: f64) -> MeshFrame {
    let (rest, nodes, facets) = match scene.scene.dimension {
        Dimension::Spatial => block(),
        Dimension::Planar => sheet(-0.05, 0.1),
        Dimension::Axisymmetric => sheet(0.0, 0.05),
    };
    let dent = |p: &Vector3| (1.0 + p.z / 0.05) * (-(p.x * p.x + p.y * p.y) / 3e-4).exp();
    let displacements: Vec<Vector3> = rest.iter().map(|p| -depth(scene, time) * dent(p) * Vector3::z()).collect();
    let rate = ball(scene, time).velocity.z;
    let step =
        nodes.iter().map(|cell| 8e-6 * 0.5f64.powi((4.0 * dent(&rest[cell[0] as usize])).round() as i32)).collect();
    let cells = nodes.len();
    MeshFrame {
        time,
        dimension: if scene.scene.dimension == Dimension::Spatial { 3 } else { 2 },
        mass: 1.0,
        points: rest.iter().zip(&displacements).map(|(p, u)| p + u).collect(),
        velocities: rest.iter().map(|p| rate * dent(p) * Vector3::z()).collect(),
        displacements,
        cells: FrameCells {
            nodes,
            step,
            jacobian: vec![0.9; cells],
            energy_density: vec![12.5; cells],
            damage: vec![0.0; cells],
            facets,
        },
        fields: vec![],
        bodies: vec![BodyPose { kinematics: ball(scene, time), shape_motion: None, active: true }],
        block: BlockMotion::default(),
        gel_displacement: Vector3::zeros(),
    }
}

type Mesh = (Vec<Vector3>, Vec<[u32; 4]>, Vec<[u32; 3]>);

/// Two triangles in each cell, from x = `restricted_to` over `width`.
fn sheet(left: f64, width: f64) -> Mesh {
    let n = CELLS;
    let line = 0..=n;
    let points = line.clone().flat_map(|j| line.clone().map(move |i| (i, j))).map(|(i, j)| {
        Vector3::new(left + width * f64::from(i) / f64::from(n), 0.0, 0.05 * (f64::from(j) / f64::from(n) - 1.0))
    });
    let cells = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
    let triangles = cells.flat_map(|a| [[a, a + 1, a + n + 2, 0], [a, a + n + 2, a + n + 1, 0]]);
    (points.collect(), triangles.collect(), Vec::new())
}

/// Six Kuhn tetrahedra in each cell.
fn block() -> Mesh {
    let n = CELLS;
    let share = |i: u32| f64::from(i) / f64::from(n);
    let grid = |n: u32| (0..n * n * n).map(move |i| [i % n, i / n % n, i / (n * n)]);
    let index = |[i, j, k]: [u32; 3]| i + (n + 1) * (j + (n + 1) * k);
    let points = grid(n + 1)
        .map(|[i, j, k]| Vector3::new(0.1 * share(i) - 0.05, 0.1 * share(j) - 0.05, 0.05 * (share(k) - 1.0)));
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let tetrahedra: Vec<[u32; 4]> = grid(n)
        .flat_map(|cell| {
            orders.map(|order| {
                let mut corner = cell;
                let mut path = [index(cell); 4];
                for (axis, place) in order.iter().zip(1..) {
                    corner[*axis] += 1;
                    path[place] = index(corner);
                }
                path
            })
        })
        .collect();
    let facets = boundary(&tetrahedra);
    (points.collect(), tetrahedra, facets)
}

/// Facets that belong to one tetrahedron.
fn boundary(tetrahedra: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let mut facets: Vec<[u32; 3]> =
        tetrahedra.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, b, d], [a, c, d], [b, c, d]]).collect();
    for facet in &mut facets {
        facet.sort_unstable();
    }
    facets.sort_unstable();
    facets.chunk_by(|a, b| a == b).filter(|group| group.len() == 1).map(|group| group[0]).collect()
}
