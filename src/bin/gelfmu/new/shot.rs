//! Shot: a projectile, its speed and attitude, and a block of gel.

use super::arrival::Arrival;
use super::block::{BlockSize, MeshedPart};
use super::layer::ShotLayer;
use super::options::NewOptions;
use crate::failure::CommandError;
use crate::rounding::rounded;
use ballistic_gel::scene::{
    self, BodyShape, BulletNose, CAVITY_DRAG, GEL_RESISTANCE, LibraryProjectile, Preset, ProjectileKind,
};

/// Yaw of a service bullet at the gel where none is given, degrees.
pub const USUAL_YAW: f64 = 2.0;
/// Density of gelatin, kg/m³.
const DENSITY: f64 = 1030.0;

/// Shot into a block.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// Projectile.
    pub projectile: LibraryProjectile,
    /// Speed, m/s.
    pub speed: f64,
    /// Angle between axis and path, degrees.
    pub yaw: f64,
    /// Angle of the plane of the yaw about the path, degrees.
    pub roll: f64,
    /// Block.
    pub block: BlockSize,
    /// Gel.
    pub gel: Preset,
    /// Layers in front of the gel, from the entry surface on.
    pub layers: Vec<ShotLayer>,
    /// State of a projectile that comes out of another gel; `None` for one as it was fired.
    pub arrival: Option<Arrival>,
}

/// Terms of Poncelet's law, m dv/dt = −drag v² − force.
struct PonceletTerms {
    /// Half of drag coefficient, density and cross-section, kg/m.
    drag: f64,
    /// Resisting pressure times cross-section, N.
    force: f64,
}

impl Shot {
    /// Shot of the options of `gelfmu new` with a projectile of the library.
    pub fn of_library(options: &NewOptions, name: &str) -> Result<Self, CommandError> {
        let projectile = named_projectile(name)?;
        let roll = options.roll.unwrap_or(0.0);
        let usual_yaw = if projectile.kind == ProjectileKind::Service { USUAL_YAW } else { 0.0 };
        let yaw = options.yaw.unwrap_or(usual_yaw);
        if yaw != 0.0 && matches!(projectile.shape, BodyShape::Sphere { .. }) {
            return Err(CommandError::BadInput(format!(
                "--yaw {yaw}: a sphere has no axis that could yaw; leave it out"
            )));
        }
        if roll != 0.0 && yaw == 0.0 && !matches!(projectile.shape, BodyShape::Chisel(_)) {
            return Err(CommandError::BadInput(format!(
                "--roll {roll}: a body of revolution without yaw looks the same from all sides; leave it out, or give --yaw"
            )));
        }
        let speed = options.speed.unwrap_or(projectile.speed);
        check_speed(speed)?;
        check_block(options.block, radius_of(&projectile.shape))?;
        let (block, gel, layers) = (options.block, options.gel, options.layer.clone());
        Ok(Self { projectile, speed, yaw, roll, block, gel, layers, arrival: None })
    }

    /// Part of the gel that has to be meshed.
    pub fn meshed_part(&self) -> MeshedPart {
        if let Some(arrival) = &self.arrival {
            return arrival.part;
        }
        let is_round = matches!(self.projectile.shape, BodyShape::Sphere { .. });
        match (self.yaw == 0.0, self.projectile.kind) {
            (true, ProjectileKind::Recovered | ProjectileKind::Expanding) => MeshedPart::Meridian,
            (true, _) if is_round => MeshedPart::Meridian,
            (true, _) if self.is_square_on() => MeshedPart::Quarter,
            (false, _) if self.is_square_on() => MeshedPart::Half,
            _ => MeshedPart::Whole,
        }
    }

    /// Shortest way from the path or the entry surface to a face of the meshed block, m.
    pub fn way_to_face(&self) -> f64 {
        let BlockSize { width, height, length } = self.block;
        let side = match self.meshed_part() {
            MeshedPart::Meridian => rounded(self.block.equivalent_radius()),
            MeshedPart::Quarter | MeshedPart::Half | MeshedPart::Whole => 0.5 * width.min(height),
        };
        side.min(length)
    }

    /// Number of cells of this edge, m, that fill the meshed part of the block.
    pub fn n_cells(&self, edge: f64) -> f64 {
        let BlockSize { width, height, length } = self.block;
        let part = match self.meshed_part() {
            MeshedPart::Meridian => return self.block.equivalent_radius() * length / (edge * edge),
            MeshedPart::Quarter => 0.25,
            MeshedPart::Half => 0.5,
            MeshedPart::Whole => 1.0,
        };
        part * width * height * length / edge.powi(3)
    }

    /// Returns true if the plane of the yaw is parallel to a side of the block.
    pub fn is_square_on(&self) -> bool {
        self.roll.rem_euclid(90.0) == 0.0
    }

    /// Block in the frame of a scene, whose x axis lies in the plane of the yaw if that is parallel to a side.
    pub fn block_in_scene(&self) -> [f64; 3] {
        let BlockSize { width, height, length } = self.block;
        let is_turned = self.is_square_on() && self.roll.rem_euclid(180.0) != 0.0;
        if is_turned { [height, width, length] } else { [width, height, length] }
    }

    /// Greatest radius of the projectile as it meets the gel, m.
    pub fn radius(&self) -> f64 {
        self.arrival.as_ref().map_or_else(|| radius_of(&self.projectile.shape), |arrival| arrival.radius)
    }

    /// Greatest radius of the projectile in the gel, m: that of the opened form of an expanding bullet.
    fn radius_in_gel(&self) -> f64 {
        if let Some(arrival) = &self.arrival {
            return arrival.radius_in_gel;
        }
        self.projectile.expansion.map_or_else(|| self.radius(), |expansion| expansion.opened.radius)
    }

    /// Radius of the tip of a slender nose, m; `None` for a blunt body.
    pub fn tip_radius(&self) -> Option<f64> {
        let is_blunt = self.arrival.as_ref().is_some_and(Arrival::is_blunt);
        let BodyShape::Bullet(bullet) = &self.projectile.shape else { return None };
        if is_blunt {
            return None;
        }
        match bullet.nose {
            BulletNose::Ogive { meplat_radius, .. } | BulletNose::Cone { meplat_radius, .. } => {
                Some(meplat_radius.max(bullet.edge_radius))
            }
            BulletNose::Round | BulletNose::Flat => None,
        }
    }

    /// Yaw as texts tell it, degrees: to three digits where a run has computed it.
    pub fn shown_yaw(&self) -> f64 {
        if self.arrival.is_some() { rounded(self.yaw) } else { self.yaw }
    }

    /// Angular position of the body: Hamilton quaternion of the yaw about y, then of the roll about z.
    pub fn orientation(&self) -> [f64; 4] {
        let half = |degrees: f64| (0.5 * degrees.to_radians()).sin_cos();
        let roll = if self.is_square_on() { 0.0 } else { self.roll };
        let ((sin, cos), (roll_sin, roll_cos)) = (half(self.yaw), half(roll));
        // Adding 0 turns a negative zero into a zero.
        [roll_cos * cos, 0.0 - roll_sin * sin, roll_cos * sin, roll_sin * cos]
    }

    /// Terms of Poncelet's law for a sphere of the calibre, or of the opened bullet, in 10 % gelatin.
    fn poncelet(&self) -> PonceletTerms {
        let area = std::f64::consts::PI * self.radius_in_gel().powi(2);
        PonceletTerms { drag: 0.5 * CAVITY_DRAG * DENSITY * area, force: GEL_RESISTANCE * area }
    }

    /// Depth at which a sphere of this radius and mass stops in 10 % gelatin by Poncelet's law, m; yaw
    /// shortens the path.
    pub fn longest_path(&self) -> f64 {
        let PonceletTerms { drag, force } = self.poncelet();
        self.projectile.mass / (2.0 * drag) * (drag * self.speed.powi(2) / force).ln_1p()
    }

    /// Time of that path, s.
    pub fn longest_time(&self) -> f64 {
        let PonceletTerms { drag, force } = self.poncelet();
        self.projectile.mass / (drag * force).sqrt() * (self.speed * (drag / force).sqrt()).atan()
    }
}

/// Greatest radius of a shape, m.
fn radius_of(shape: &BodyShape) -> f64 {
    match shape {
        BodyShape::Sphere { radius } | BodyShape::Cylinder { radius, .. } | BodyShape::Capsule { radius, .. } => {
            *radius
        }
        BodyShape::Bullet(bullet) => bullet.radius,
        BodyShape::Mushroom(mushroom) => mushroom.radius,
        BodyShape::Chisel(chisel) => chisel.radius,
        BodyShape::Plate { size, .. } => 0.5 * size[0].max(size[1]),
        BodyShape::Stl(_) | BodyShape::HalfSpace { .. } | BodyShape::Dome { .. } => {
            unreachable!("the library has bodies of finite size")
        }
    }
}

/// Refuses speeds that no shot has.
fn check_speed(speed: f64) -> Result<(), CommandError> {
    if !(1.0..=5000.0).contains(&speed) {
        return Err(CommandError::BadInput(format!("--speed {speed} m/s: expected a speed from 1 to 5000 m/s")));
    }
    Ok(())
}

/// Refuses blocks that are hardly larger than the projectile.
pub fn check_block(block: BlockSize, radius: f64) -> Result<(), CommandError> {
    let least = 4.0 * radius;
    if block.width.min(block.height).min(block.length) < least {
        return Err(CommandError::BadInput(format!(
            "--block {} x {} x {} m: expected lengths of at least two calibres of the projectile, {least:.4} m",
            block.width, block.height, block.length
        )));
    }
    Ok(())
}

/// Projectile of the library by its name.
pub fn named_projectile(name: &str) -> Result<LibraryProjectile, CommandError> {
    LibraryProjectile::named(name).ok_or_else(|| {
        let known = || scene::library().map(|(known, _)| known);
        let hint = scene::did_you_mean(name, scene::known_projectiles());
        CommandError::BadInput(format!(
            "projectile {name}: found no projectile of this name in the library{hint}, expected one of {}",
            known().collect::<Vec<_>>().join(", ")
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::{MeshedPart, PonceletTerms, Shot};
    use crate::new::block::BlockSize;
    use ballistic_gel::scene::{LibraryProjectile, Preset};

    pub fn shot(name: &str, yaw: f64, roll: f64) -> Shot {
        let projectile = LibraryProjectile::named(name).unwrap();
        let speed = projectile.speed;
        let block = BlockSize::parse("15x20x40cm").unwrap();
        Shot { projectile, speed, yaw, roll, block, gel: Preset::Gelatin10, layers: vec![], arrival: None }
    }

    /// The depth fits the resistance, and validates nothing: other shots do in `measured_shots`.
    #[test]
    fn the_resistance_of_the_estimate_is_the_one_that_stops_the_calibration_shot_at_85_mm() {
        let bb = shot("bb", 0.0, 0.0);
        assert!((bb.longest_path() / 85e-3 - 1.0).abs() < 0.003, "{}", bb.longest_path());
    }

    #[test]
    fn path_and_time_of_the_estimate_are_those_of_its_equation_of_motion() {
        for name in ["bb", "9mm-fmj"] {
            let shot = shot(name, 0.0, 0.0);
            let PonceletTerms { drag, force } = shot.poncelet();
            let slowing = |speed: f64| (drag * speed * speed + force) / shot.projectile.mass;
            let (mut speed, mut path, mut time, step) = (shot.speed, 0.0, 0.0, 1e-7);
            while speed > 0.0 {
                let middle = speed - 0.5 * step * slowing(speed);
                (speed, path, time) = (speed - step * slowing(middle), path + step * middle, time + step);
            }
            assert!((shot.longest_path() / path - 1.0).abs() < 1e-6, "{name}: {} m, not {path}", shot.longest_path());
            assert!((shot.longest_time() / time - 1.0).abs() < 1e-3, "{name}: {} s, not {time}", shot.longest_time());
        }
    }

    #[test]
    fn no_more_of_the_gel_is_meshed_than_the_shot_needs() {
        for (name, yaw, roll, part) in [
            ("bb", 0.0, 0.0, MeshedPart::Meridian),
            ("45acp-230-xtp-recovered", 0.0, 0.0, MeshedPart::Meridian),
            ("fsp-1.1g", 0.0, 0.0, MeshedPart::Quarter),
            ("9mm-fmj", 2.0, 90.0, MeshedPart::Half),
            ("9mm-fmj", 2.0, 45.0, MeshedPart::Whole),
        ] {
            assert_eq!(shot(name, yaw, roll).meshed_part(), part, "{name}");
        }
        assert_eq!(shot("9mm-fmj", 2.0, 90.0).block_in_scene(), [0.2, 0.15, 0.4]);
        let [w, x, y, z] = shot("9mm-fmj", 2.0, 45.0).orientation();
        assert!((w * w + x * x + y * y + z * z - 1.0).abs() < 1e-15 && x < 0.0 && z > 0.0);
    }
}
