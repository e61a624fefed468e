//! Arrival of the bodies of a finished run at the next block, after free flight from the exit out of their gel.

use super::block::MeshedPart;
use super::flight::{arrival_time, state_in_flight};
use ballistic_gel::contact::BodyState;
use ballistic_gel::math::Vector3;
use ballistic_gel::output::{ExitedBody, ExitedRun};
use ballistic_gel::scene::{BodyShape, Dimension, ExpansionSpec, GelSymmetry, ProjectileSpec, Scene, body_name};
use ballistic_gel::simulation::{BodyKinematics, ShapeMotion};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Mass density of air, kg/m³, at 15 °C.
const AIR_DENSITY: f64 = 1.225;
/// Drag coefficients of a nose and of a side.
const AIR_DRAG: [f64; 2] = [0.3, 1.0];
/// Acceleration of free fall, m/s².
const FREE_FALL: f64 = 9.81;
/// Greatest time by which a fragment touches the block after the projectile, s.
const LATEST: f64 = 10e-3;
/// Opening from which on the nose of a bullet is no longer slender.
const BLUNT: f64 = 0.5;

/// Arrival of projectile and fragments of a run at another block.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrival {
    /// Folder of the run.
    pub folder: PathBuf,
    /// Name of its scene.
    pub scene: String,
    /// Part of the next block that has to be meshed.
    pub part: MeshedPart,
    /// Projectile, then the fragments that have left the gel.
    pub bodies: Vec<ArrivingBody>,
    /// Names of the fragments that have not left the gel through its back face, or do not fly with the projectile.
    pub left_out: Vec<String>,
    /// Flight between the blocks.
    pub flight: AirFlight,
    /// Greatest radius of the projectile, m.
    pub radius: f64,
    /// Greatest radius of the projectile in the gel, m.
    pub radius_in_gel: f64,
}

/// Body at the instant at which the foremost one touches the next block.
#[derive(Debug, Clone, PartialEq)]
pub struct ArrivingBody {
    /// Name in the scene of the run: `projectile` or `fragment[i]`.
    pub name: String,
    /// Body with its state in the axes of the next block.
    pub spec: ProjectileSpec,
    /// Time until the body touches the block itself, s.
    pub delay: f64,
}

/// Flight of the projectile between two blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct AirFlight {
    /// Distance from the back face of the first block to the entry surface of the next one, m.
    pub gap: f64,
    /// Time of the exit of the projectile, s.
    pub exit_time: f64,
    /// Speed of the projectile in the row of the history at which the flight begins, m/s.
    pub row_speed: f64,
    /// Time of the row of the history at which the flight begins, s.
    pub start_time: f64,
    /// Duration, s.
    pub duration: f64,
    /// Place of the projectile at the end, across the line of fire, in the axes of the first block: x and y, m.
    pub drift: [f64; 2],
    /// Loss of speed by the drag that is left out, relative: nose first, and side on.
    pub speed_loss: [f64; 2],
    /// Drop by the gravity that is left out, m.
    pub drop: f64,
}

/// Bodies in free flight at one instant.
struct FlyingBodies<'a> {
    bodies: Vec<FlyingBody<'a>>,
    /// Height of the lowest point of all, m.
    lowest: f64,
}

/// Body in free flight with its index in the scene.
struct FlyingBody<'a> {
    index: usize,
    exited: &'a ExitedBody,
    state: BodyState,
}

impl Arrival {
    /// Arrival of the bodies of a run in a folder, of this scene, at a block behind a gap, m; `None` if the projectile does not
    /// fly away from the back face.
    pub fn of(folder: &Path, scene: &Scene, run: &ExitedRun, gap: f64) -> Option<Self> {
        let flying = FlyingBodies::at_block(scene, run, gap)?;
        let FlyingBody { exited, state, .. } = flying.bodies.first()?;
        let origin = Vector3::new(state.position.x, state.position.y, flying.lowest);
        let bodies: Vec<ArrivingBody> =
            flying.bodies.iter().map(|body| body.arriving(scene, folder, &origin)).collect();
        let is_missing = |body: &usize| flying.bodies.iter().all(|flying| flying.index != *body);
        let left_out = (0..run.bodies.len()).filter(is_missing).map(body_name).collect();
        let radius = [Vector3::x(), Vector3::y()].map(|axis| reach(exited, &axis)).into_iter().fold(0.0, f64::max);
        let opened = scene.projectile.expansion.filter(|_| will_open(scene, state)).map(|spec| spec.opened.radius);
        Some(Self {
            folder: folder.to_path_buf(),
            scene: scene.scene.name.clone(),
            part: meshed_part(scene, &bodies),
            bodies,
            left_out,
            flight: AirFlight::of(run, gap, exited, state),
            radius,
            radius_in_gel: opened.map_or(radius, |opened| radius.max(opened)),
        })
    }

    /// Projectile as it arrives.
    pub fn projectile(&self) -> &ProjectileSpec {
        &self.bodies[0].spec
    }

    /// Speed of the projectile, m/s.
    pub fn speed(&self) -> f64 {
        Vector3::from(self.projectile().velocity).norm()
    }

    /// Angle between the axis of the projectile and its path, degrees; 0 of a sphere.
    pub fn yaw(&self) -> f64 {
        let spec = self.projectile();
        if matches!(spec.shape, BodyShape::Sphere { .. }) {
            return 0.0;
        }
        let kinematics = BodyKinematics {
            position: spec.position.into(),
            velocity: spec.velocity.into(),
            orientation: spec.orientation,
            angular_velocity: spec.angular_velocity.into(),
        };
        kinematics.yaw_from(&Vector3::zeros()).to_degrees()
    }

    /// Returns true if the nose of the projectile is no longer that of a bullet as it was fired.
    pub fn is_blunt(&self) -> bool {
        self.projectile().expansion.is_some_and(|expansion| expansion.opening >= BLUNT)
    }

    /// Returns true if the projectile is as it was fired, and alone.
    pub fn is_like_fired(&self) -> bool {
        let is_open = self.projectile().expansion.is_some_and(|expansion| expansion.opening > 0.0);
        self.bodies.len() == 1 && !is_open && self.yaw() == 0.0
    }

    /// Origin of the shot for the JSON of the command.
    pub fn told(&self) -> Value {
        let AirFlight { gap, exit_time, row_speed, start_time, duration, drift, speed_loss, drop } = &self.flight;
        let names: Vec<&str> = self.bodies[1..].iter().map(|body| body.name.as_str()).collect();
        json!({
            "folder": self.folder, "scene": self.scene, "gap": gap, "exit_time": exit_time, "row_speed": row_speed, "start_time": start_time,
            "flight_time": duration, "drift": drift, "speed_loss": speed_loss, "drop": drop,
            "opening": self.projectile().expansion.map(|expansion| expansion.opening),
            "fragments": names, "left_out": self.left_out,
        })
    }
}

impl AirFlight {
    fn of(run: &ExitedRun, gap: f64, exited: &ExitedBody, state: &BodyState) -> Self {
        let start = &exited.state;
        let duration = state.time - start.time;
        let path = state.velocity.norm() * duration;
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| reach(exited, &axis));
        let across = 2.0 * x.max(y);
        let sections = [std::f64::consts::FRAC_PI_4 * across * across, across * across.max(2.0 * z)];
        let loss = |i: usize| 0.5 * AIR_DENSITY * AIR_DRAG[i] * sections[i] * path / exited.rigid.mass;
        Self {
            gap,
            exit_time: run.exit_time,
            row_speed: run.row_speed,
            start_time: start.time,
            duration,
            drift: [state.position.x, state.position.y],
            speed_loss: [0, 1].map(loss),
            drop: 0.5 * FREE_FALL * duration * duration,
        }
    }

    /// Doubt about a flight on which drag or gravity count.
    pub fn doubt(&self) -> Option<String> {
        let is_long = self.speed_loss[0] > 0.02 || self.drop > 0.01;
        is_long.then(|| {
            format!("--gap {} m: the flight through air has no drag and no gravity: {}", self.gap, self.left_out())
        })
    }

    /// Size of drag and gravity, which are left out.
    pub fn left_out(&self) -> String {
        let [nose, side] = self.speed_loss.map(|loss| 100.0 * loss);
        format!(
            "about {nose:.1} (nose first, C_d {:?}) to {side:.1} % (side on, C_d {:?}) of its speed, and {:.1} mm of drop",
            AIR_DRAG[0],
            AIR_DRAG[1],
            1e3 * self.drop
        )
    }
}

impl<'a> FlyingBodies<'a> {
    /// Bodies at the instant at which the first of them touches the block behind a gap, m: the projectile, and the fragments
    /// that are between the two blocks then and arrive no later than [`LATEST`] after it. A body counts as arrived when
    /// it leaves a gel that is nearer to the block than the body is long.
    fn at_block(scene: &Scene, run: &'a ExitedRun, gap: f64) -> Option<Self> {
        let plane = scene.gel.shape.bounding_box()?.lower.z - gap;
        let projectile = run.bodies.first()?.as_ref()?;
        let (start, arrival) = (projectile.state.time, arrival_time(projectile, plane)?);
        let exited = run.bodies.iter().enumerate().filter_map(|(i, body)| Some((i, body.as_ref()?)));
        let arriving = exited.filter_map(|(i, body)| Some((i, body, arrival_time(body, plane)?)));
        let along: Vec<(usize, &ExitedBody, f64)> =
            arriving.filter(|(_, _, at)| (start..=arrival + LATEST).contains(at)).collect();
        let has_left = |body: &ExitedBody, time: f64| body.state.time <= time;
        let first = along.iter().filter(|(_, body, _)| has_left(body, arrival)).map(|(_, _, at)| *at);
        let time = first.fold(arrival, f64::min);
        let there = along.into_iter().filter(|(_, body, _)| has_left(body, time));
        let flying = |(index, exited, _)| FlyingBody { index, exited, state: state_in_flight(exited, time) };
        let bodies: Vec<FlyingBody<'a>> = there.map(flying).collect();
        let lowest = bodies.iter().map(FlyingBody::lowest).fold(f64::INFINITY, f64::min);
        Some(Self { bodies, lowest })
    }
}

impl FlyingBody<'_> {
    /// Height of the lowest point, m.
    fn lowest(&self) -> f64 {
        -self.exited.rigid.depth(&self.state)
    }

    /// Body of a scene whose block has its entry surface, and the line of fire, at a point of the first one.
    fn arriving(&self, scene: &Scene, folder: &Path, origin: &Vector3) -> ArrivingBody {
        let Self { index, exited, state } = self;
        let q = state.orientation.quaternion();
        let above = self.lowest() - origin.z;
        let [x, y] = [state.position.x - origin.x, state.position.y - origin.y];
        let height = exited.rigid.reach(state, &-Vector3::z()) + above;
        let own = scene.body(*index);
        let opening = ShapeMotion::opening_of(state.shape_motion.as_ref());
        // Adding 0 turns a negative zero into a zero.
        let plain = |vector: Vector3| vector.map(|component| component + 0.0).into();
        let spec = ProjectileSpec {
            shape: with_path(&own.shape, folder),
            density: None,
            expansion: own.expansion.map(|spec| ExpansionSpec { opening, ..spec }),
            position: plain(Vector3::new(x, y, height)),
            velocity: plain(state.velocity),
            orientation: [q.w, q.i, q.j, q.k].map(|part| part + 0.0),
            angular_velocity: plain(exited.rigid.angular_velocity(state)),
            active: true,
            ..own.clone()
        };
        ArrivingBody { name: body_name(*index), spec, delay: above / -state.velocity.z }
    }
}

/// Half of the greatest extent of a body along an axis of its own frame, m, at its opening.
fn reach(exited: &ExitedBody, axis: &Vector3) -> f64 {
    let upright = BodyState { orientation: nalgebra::UnitQuaternion::identity(), ..exited.state };
    0.5 * (exited.rigid.reach(&upright, axis) + exited.rigid.reach(&upright, &-axis))
}

/// Returns true if the gel opens the projectile by half or more at this velocity.
fn will_open(scene: &Scene, state: &BodyState) -> bool {
    scene.expansion_law(0).is_some_and(|law| law.target(&state.velocity) >= BLUNT)
}

/// Shape whose file, if it has one, is named from any folder.
fn with_path(shape: &BodyShape, folder: &Path) -> BodyShape {
    let mut shape = shape.clone();
    if let BodyShape::Stl(stl) = &mut shape {
        let file = folder.join(&stl.file);
        stl.file = file.canonicalize().unwrap_or(file).to_string_lossy().into_owned();
    }
    shape
}

/// Part of the block that the motion of all bodies needs: no more than that of their run.
fn meshed_part(scene: &Scene, bodies: &[ArrivingBody]) -> MeshedPart {
    let all = |holds: fn(&ProjectileSpec) -> bool| bodies.iter().all(|body| holds(&body.spec));
    match (scene.scene.dimension, scene.gel.symmetry) {
        (Dimension::Axisymmetric, _) if all(is_on_axis) => MeshedPart::Meridian,
        (_, GelSymmetry::Quarter) if all(is_on_axis) => MeshedPart::Quarter,
        _ if all(is_in_plane) => MeshedPart::Half,
        _ => MeshedPart::Whole,
    }
}

/// Returns true if a body flies along the z axis without yaw and spin.
fn is_on_axis(body: &ProjectileSpec) -> bool {
    let [w, x, y, z] = body.orientation;
    let across = [body.position[0], body.position[1], body.velocity[0], body.velocity[1]];
    w != 0.0 && across.iter().chain(&[x, y, z]).chain(&body.angular_velocity).all(|component| *component == 0.0)
}

/// Returns true if a body moves in the plane y = 0.
fn is_in_plane(body: &ProjectileSpec) -> bool {
    let ([_, x, _, z], [spin_x, _, spin_z]) = (body.orientation, body.angular_velocity);
    [body.position[1], body.velocity[1], x, z, spin_x, spin_z].iter().all(|component| *component == 0.0)
}
