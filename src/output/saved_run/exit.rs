//! Bodies of a finished run as they left the gel through its back face, in the frame in which that gel was at rest.

use super::table::CsvTable;
use super::{SavedRun, SavedRunError};
use crate::contact::{BodyMotion, BodyState, ExpansionMotion, RigidBody, ShapeMotion};
use crate::math::Vector3;
use crate::output::HISTORY;
use crate::scene::{GelBox, Scene};
use crate::simulation::free_body;
use nalgebra::{Quaternion, UnitQuaternion};
use std::path::Path;

/// Column of the time.
const TIME: &str = "time_s";
/// Remedy of a run whose projectile stays in the gel.
const PERFORATED: &str = "a run whose projectile leaves through the back face: a shorter block, or a later end time";
/// Remedy of a history without the exit.
const WHOLE_HISTORY: &str = "the history as gelfmu run writes it; run the scene again";

/// Finished run whose projectile has perforated the gel.
#[derive(Debug, Clone, PartialEq)]
pub struct ExitedRun {
    /// Time of the exit of the projectile, s.
    pub exit_time: f64,
    /// Speed of the projectile in the row of its state, m/s: gel that is drawn out may have slowed it since the exit.
    pub row_speed: f64,
    /// Projectile, then the fragments; `None` for a fragment that has not left through the back face.
    pub bodies: Vec<Option<ExitedBody>>,
}

/// Body that has left the gel, at the first row of the history from which on it is outside. The velocity of the projectile is
/// that of its exit, with which figures of the run close.
#[derive(Debug, Clone, PartialEq)]
pub struct ExitedBody {
    /// Shape, mass and inertia.
    pub rigid: RigidBody,
    /// State at the time of the row.
    pub state: BodyState,
}

/// Rows of the history of one body.
struct BodyRows<'a> {
    table: &'a CsvTable,
    /// Beginning of the names of its columns.
    prefix: String,
    rigid: RigidBody,
    initial: BodyState,
    /// Velocity of the gel at the start, m/s.
    gel_velocity: Vector3,
}

/// Reads the bodies that have left the gel of a run of this scene.
///
/// # Errors
/// [`SavedRunError`] for a folder without a finished run, and for a run whose projectile has not left the gel.
pub fn exited_run(folder: &Path, scene: &Scene) -> Result<ExitedRun, SavedRunError> {
    let summary = SavedRun::open(folder, scene)?.summary()?;
    let content = |file: &str, found, expected| SavedRunError::Content { path: folder.join(file), found, expected };
    let (exit, gel) = (summary.exit.exit_time.zip(summary.exit.exit_velocity), scene.gel.shape.bounding_box());
    let (Some((exit_time, exit_velocity)), Some(gel)) = (exit, gel) else {
        let (depth, end) = (1e3 * summary.final_depth, 1e3 * summary.end_time);
        let found = format!("a projectile that has not left the gel: {depth:.1} mm deep at the end, after {end:.3} ms");
        return Err(content("summary.json", found, PERFORATED));
    };
    let table = CsvTable::read(&folder.join(HISTORY))?;
    let rows = |body| BodyRows::of(&table, scene, body);
    let mut projectile = rows(0).at_exit(exit_time).ok_or_else(|| {
        let found = format!("no whole row at or after the exit of the projectile, {:.6} ms", 1e3 * exit_time);
        content(HISTORY, found, WHOLE_HISTORY)
    })?;
    let fragments = (1..scene.n_bodies()).map(|body| rows(body).outside(&gel));
    let row_speed = projectile.state.velocity.norm();
    projectile.state.velocity = exit_velocity.into();
    Ok(ExitedRun { exit_time, row_speed, bodies: std::iter::once(Some(projectile)).chain(fragments).collect() })
}

impl<'a> BodyRows<'a> {
    fn of(table: &'a CsvTable, scene: &Scene, body: usize) -> Self {
        let prefix = if body == 0 { String::new() } else { format!("fragment{body}_") };
        let (rigid, initial) = free_body(scene, body);
        Self { table, prefix, rigid, initial, gel_velocity: scene.gel.velocity.into() }
    }

    /// Returns the body at the first row at or after a time, s.
    fn at_exit(self, time: f64) -> Option<ExitedBody> {
        let row = self.table.rows().iter().find(|row| self.table.value(row, TIME).is_some_and(|at| at >= time))?;
        let state = self.state(row)?;
        Some(ExitedBody { rigid: self.rigid, state })
    }

    /// Returns the body at the first row from which on it is behind the gel until the end.
    fn outside(self, gel: &GelBox) -> Option<ExitedBody> {
        let rows = self.table.rows().iter().rev();
        let behind = rows.map_while(|row| self.state(row).filter(|state| self.is_behind(row, state, gel)));
        let state = behind.last().filter(|state| is_within(state, gel))?;
        Some(ExitedBody { rigid: self.rigid, state })
    }

    /// Returns true if a body moves away from the back face of the block, and no part of it is above that.
    fn is_behind(&self, row: &[f64], state: &BodyState, gel: &GelBox) -> bool {
        let moved = self.vector(row, "block_displacement_", "_m") - self.gel_velocity * state.time;
        let seen = BodyState { position: state.position - moved, ..*state };
        let takes_part = self.rigid.motion != BodyMotion::Fixed && self.own(row, "active") > 0.0;
        takes_part && state.velocity.z < 0.0 && self.rigid.rear(&seen) <= gel.lower.z
    }

    /// Returns the state in a row; `None` if one of its cells is no number.
    fn state(&self, row: &[f64]) -> Option<BodyState> {
        let time = self.table.value(row, TIME)?;
        let vector = |before: &str, after: &str| self.vector(row, &format!("{}{before}", self.prefix), after);
        let [w, x, y, z] = ["w", "x", "y", "z"].map(|part| self.own(row, &format!("orientation_{part}")));
        let opening = self.own(row, "expansion");
        let opened = |at: ExpansionMotion| ShapeMotion::Expansion(ExpansionMotion::at_rest(opening, at.travel));
        let expansion = self.initial.shape_motion.as_ref().and_then(ShapeMotion::expansion).copied();
        let mut state = BodyState {
            time,
            position: vector("position_", "_m") - self.gel_velocity * time,
            velocity: vector("velocity_", "_m_per_s") - self.gel_velocity,
            orientation: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
            shape_motion: expansion.map_or(self.initial.shape_motion, |at| Some(opened(at))),
            active: true,
            ..self.initial
        };
        state.angular_momentum = self.rigid.angular_momentum(&state, &vector("angular_velocity_", "_rad_per_s"));
        Some(state).filter(BodyState::is_valid)
    }

    fn own(&self, row: &[f64], name: &str) -> f64 {
        self.table.value(row, &format!("{}{name}", self.prefix)).unwrap_or(f64::NAN)
    }

    fn vector(&self, row: &[f64], before: &str, after: &str) -> Vector3 {
        let column = |axis: &str| self.table.value(row, &format!("{before}{axis}{after}")).unwrap_or(f64::NAN);
        ["x", "y", "z"].map(column).into()
    }
}

/// Returns true if a body is within the cross-section of the gel at rest.
fn is_within(state: &BodyState, gel: &GelBox) -> bool {
    state.position.x.abs() <= gel.upper.x && state.position.y.abs() <= gel.upper.y
}
