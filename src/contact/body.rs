//! Rigid body: shape, mass and inertia, and the directions in which it moves.

use super::{BodyState, ExpansionLaw, ShapeMotion, Wrench};
use crate::geometry::{Gap, ShapeGeometry, SharpEnd, SignedDistance};
use crate::math::{Tensor3, Vector, Vector3};
use std::borrow::Cow;

/// Motion of a body: fixed, prescribed or free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyMotion {
    /// The body stays at its place.
    Fixed,
    /// The importer prescribes the motion; impulses do not change it.
    Prescribed,
    /// Newton–Euler equations under impulses and an external wrench.
    Free,
}

/// Free directions of motion in the world frame, by the dimension of the scene (method A1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FreeDirections {
    /// Translation along x, y, z.
    pub translation: [bool; 3],
    /// Rotation about x, y, z.
    pub rotation: [bool; 3],
}

impl FreeDirections {
    /// Plane strain in x–z: P_x, P_z, L_y.
    pub const PLANAR: Self = Self { translation: [true, false, true], rotation: [false, true, false] };
    /// Revolution about z: P_z.
    pub const AXISYMMETRIC: Self = Self { translation: [false, false, true], rotation: [false; 3] };
    /// Space: all directions.
    pub const SPATIAL: Self = Self { translation: [true; 3], rotation: [true; 3] };

    /// Returns S v, the part of a translation along free directions.
    #[must_use]
    pub fn translation(&self, v: &Vector3) -> Vector3 {
        mask_components(v, self.translation)
    }

    /// Removes the round-off from an orientation (w, x, y, z) of a body that turns about y alone.
    #[must_use]
    pub fn turns(&self, [w, x, y, z]: [f64; 4]) -> [f64; 4] {
        if *self == Self::PLANAR { [w, 0.0, y, 0.0] } else { [w, x, y, z] }
    }

    /// Returns the part of a rotation about free directions.
    #[must_use]
    pub fn rotation(&self, v: &Vector3) -> Vector3 {
        mask_components(v, self.rotation)
    }
}

/// Returns true if all principal moments of inertia are equal.
fn is_isotropic(inertia: &Tensor3) -> bool {
    *inertia == Tensor3::identity() * inertia[(0, 0)]
}

/// Returns D A D of a tensor and a diagonal.
fn scaled_by(tensor: &Tensor3, diagonal: &Vector3) -> Tensor3 {
    tensor.component_mul(&(diagonal * diagonal.transpose()))
}

/// Returns √ of the ratios of the principal inertias of a homogeneous expanding body, opened to unopened.
fn inertia_growth(shape: &ShapeGeometry) -> Option<Vector3> {
    let ShapeGeometry::Expanding(expanding) = shape else { return None };
    let [unopened, opened] = expanding.forms().map(|form| form.specific_inertia().map(|inertia| inertia.diagonal()));
    Some(opened?.component_div(&unopened?).map(f64::sqrt))
}

/// Sets the components that are not kept to zero.
fn mask_components(v: &Vector3, keep: [bool; 3]) -> Vector3 {
    Vector3::from_fn(|i, _| if keep[i] { v[i] } else { 0.0 })
}

/// Rigid body: its constants.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidBody {
    /// Shape, in the frame of the body.
    pub shape: ShapeGeometry,
    /// Motion of the body.
    pub motion: BodyMotion,
    /// Free directions of its motion.
    pub freedom: FreeDirections,
    /// M, kg; infinite if fixed.
    pub mass: f64,
    /// I_b, inertia about the centre of mass in the frame of the body, kg·m².
    pub inertia: Tensor3,
    /// I_b⁻¹; zero if fixed.
    pub inverse_inertia: Tensor3,
    /// 1/I of a body with an isotropic inertia tensor, 1/(kg·m²).
    isotropic: Option<f64>,
    /// Law by which an expanding body opens; absent if the importer prescribes its opening.
    pub expansion: Option<ExpansionLaw>,
    /// d of an expanding body, √ of the ratios of its principal inertias, opened to unopened: I(e) = D I_b D with
    /// D = 1 + e (diag d − 1), as lengths grow in proportion to the opening.
    inertia_growth: Option<Vector3>,
}

impl RigidBody {
    /// Creates a body that is free to move or prescribed.
    ///
    /// # Panics
    /// If mass or inertia are not positive definite.
    #[must_use]
    pub fn new(shape: ShapeGeometry, motion: BodyMotion, freedom: FreeDirections, mass: f64, inertia: Tensor3) -> Self {
        assert!(mass > 0.0, "the mass of a moving body must be positive");
        let inverse_inertia = inertia.cholesky().expect("an inertia tensor is positive definite").inverse();
        let isotropic = is_isotropic(&inertia).then_some(inverse_inertia[(0, 0)]);
        let inertia_growth = inertia_growth(&shape);
        let isotropic = isotropic.filter(|_| inertia_growth.is_none());
        Self { shape, motion, freedom, mass, inertia, inverse_inertia, isotropic, expansion: None, inertia_growth }
    }

    /// Returns the body with a law of expansion.
    #[must_use]
    pub fn with_expansion(self, expansion: Option<ExpansionLaw>) -> Self {
        Self { expansion, ..self }
    }

    /// Creates a fixed body.
    #[must_use]
    pub fn fixed(shape: ShapeGeometry, freedom: FreeDirections) -> Self {
        let (inertia, inverse_inertia) = (Tensor3::identity(), Tensor3::zeros());
        let (motion, mass, isotropic) = (BodyMotion::Fixed, f64::INFINITY, Some(0.0));
        let (expansion, inertia_growth) = (None, None);
        Self { shape, motion, freedom, mass, inertia, inverse_inertia, isotropic, expansion, inertia_growth }
    }

    /// Returns true if a state is admissible for this body: in its plane or on its axis, with a unit quaternion, and
    /// with a changing shape only in a dome or an expanding body.
    #[must_use]
    pub fn is_admissible(&self, state: &BodyState) -> bool {
        /// Tolerance of the norm of a quaternion: rounding over a long run.
        const NORM_TOLERANCE: f64 = 1e-6;
        let Wrench { force, torque, force_rate, torque_rate } = &state.wrench;
        let along = [&state.position, &state.velocity, force, force_rate];
        let about = [&self.angular_velocity(state), torque, torque_rate];
        let q = state.orientation.quaternion();
        let turned = [q.w, q.i, q.j, q.k];
        along.into_iter().all(|v| self.freedom.translation(v) == *v)
            && about.into_iter().all(|v| self.freedom.rotation(v) == *v)
            && self.freedom.turns(turned) == turned
            && (q.norm() - 1.0).abs() <= NORM_TOLERANCE
            && match &self.shape {
                ShapeGeometry::Dome(_) => state.shape_motion.is_some_and(|shape| shape.bulge().is_some()),
                ShapeGeometry::Expanding(shape) => {
                    let motion = state.shape_motion.as_ref().and_then(ShapeMotion::expansion);
                    motion.is_some_and(|motion| motion.travel == shape.greatest_travel())
                }
                _ => state.shape_motion.is_none(),
            }
    }

    /// Returns φ and n at a world point.
    #[must_use]
    #[inline]
    pub fn gap(&self, state: &BodyState, point: &Vector3) -> Gap {
        let away = point - state.position;
        if let ShapeGeometry::Sphere(sphere) = &self.shape {
            return sphere.gap(&away);
        }
        let local = state.orientation.inverse_transform_vector(&away);
        let gap = match (&self.shape, &state.shape_motion) {
            (_, Some(ShapeMotion::Bulge(bulge))) => bulge.dome().gap(&local),
            (ShapeGeometry::Expanding(shape), Some(ShapeMotion::Expansion(at))) => shape.gap_at(at.opening, &local),
            _ => self.shape.gap(&local),
        };
        Gap { distance: gap.distance, normal: state.orientation.transform_vector(&gap.normal) }
    }

    /// Returns the normal velocity of the surface at a world point per rate of each coordinate of the shape: height and
    /// base radius of a dome, m/s per m/s, or opening of an expanding body, m; zero for any other body.
    #[must_use]
    pub fn growth(&self, state: &BodyState, point: &Vector3) -> Vector<2> {
        let local = || state.orientation.inverse_transform_vector(&(point - state.position));
        match (&self.shape, &state.shape_motion) {
            (_, Some(ShapeMotion::Bulge(bulge))) => -Vector::<2>::from(bulge.dome().growth(&local())),
            (ShapeGeometry::Expanding(shape), Some(ShapeMotion::Expansion(at))) => {
                Vector::<2>::new(shape.growth(at.opening, &local()), 0.0)
            }
            _ => Vector::<2>::zeros(),
        }
    }

    /// Returns the ends of the body, in its frame, that may be sharper than the mesh.
    #[must_use]
    pub fn poles(&self, state: &BodyState) -> Cow<'_, [SharpEnd]> {
        match (&self.shape, &state.shape_motion) {
            (ShapeGeometry::Expanding(shape), Some(ShapeMotion::Expansion(at))) => {
                Cow::Owned(shape.poles(at.opening).to_vec())
            }
            _ => Cow::Borrowed(self.shape.poles()),
        }
    }

    /// Returns the depth of the foremost point below z = 0 of the frame of the state, m.
    #[must_use]
    pub fn depth(&self, state: &BodyState) -> f64 {
        self.reach(state, &-Vector3::z()) - state.position.z
    }

    /// Returns the height of the rearmost, the highest, point, m.
    #[must_use]
    pub fn rear(&self, state: &BodyState) -> f64 {
        state.position.z + self.reach(state, &Vector3::z())
    }

    /// Returns the extent from the centre of mass along a unit vector of the world frame, m; infinite for an
    /// unbounded body.
    #[must_use]
    pub fn reach(&self, state: &BodyState, direction: &Vector3) -> f64 {
        let local = state.orientation.inverse_transform_vector(direction);
        match (&self.shape, &state.shape_motion) {
            (_, Some(ShapeMotion::Bulge(bulge))) => bulge.dome().reach(&local),
            (ShapeGeometry::Expanding(shape), Some(ShapeMotion::Expansion(at))) => shape.reach_at(at.opening, &local),
            _ => self.shape.reach(&local),
        }
    }

    /// Returns the compliance 1/M + (r×n)·I⁻¹(r×n) in the free directions, 1/kg; 0 if impulses do not move the body
    /// (method 2.3, A1).
    #[must_use]
    pub fn compliance(&self, state: &BodyState, arm: &Vector3, normal: &Vector3) -> f64 {
        if self.motion != BodyMotion::Free {
            return 0.0;
        }
        let lever = self.freedom.rotation(&arm.cross(normal));
        self.freedom.translation(normal).norm_squared() / self.mass + lever.dot(&self.spin(state, &lever))
    }

    /// Returns I⁻¹ L in the world frame, rad/s.
    #[must_use]
    pub fn spin(&self, state: &BodyState, angular_momentum: &Vector3) -> Vector3 {
        if let Some(inverse) = self.isotropic {
            return angular_momentum * inverse;
        }
        let local = state.orientation.inverse_transform_vector(angular_momentum);
        let spin = match self.inertia_scale(state) {
            Some(scale) => (self.inverse_inertia * local.component_div(&scale)).component_div(&scale),
            None => self.inverse_inertia * local,
        };
        state.orientation.transform_vector(&spin)
    }

    /// Returns the diagonal of D, by which the opening scales the inertia; `None` for a body that does not expand.
    fn inertia_scale(&self, state: &BodyState) -> Option<Vector3> {
        let (growth, at) = self.inertia_growth.zip(state.shape_motion.as_ref().and_then(ShapeMotion::expansion))?;
        Some(growth.map(|d| 1.0 + at.opening * (d - 1.0)))
    }

    /// Returns true if the shape of the body can open.
    #[must_use]
    pub fn is_expanding(&self) -> bool {
        matches!(self.shape, ShapeGeometry::Expanding(_))
    }

    /// Returns the inertia about the centre of mass in the frame of the body, kg·m².
    #[must_use]
    pub fn inertia_at(&self, state: &BodyState) -> Tensor3 {
        self.inertia_scale(state).map_or(self.inertia, |scale| scaled_by(&self.inertia, &scale))
    }

    /// Returns an upper bound of the norm of I_b⁻¹ at any opening, 1/(kg·m²).
    #[must_use]
    pub fn greatest_inverse_inertia(&self) -> f64 {
        let least_scale = self.inertia_growth.map_or(1.0, |growth| growth.min().min(1.0));
        self.inverse_inertia.norm() / (least_scale * least_scale)
    }

    /// Returns I⁻¹ in the world frame, 1/(kg·m²).
    #[must_use]
    pub(super) fn inverse_inertia_in_world(&self, state: &BodyState) -> Tensor3 {
        if let Some(inverse) = self.isotropic {
            return Tensor3::identity() * inverse;
        }
        let turn = state.orientation.to_rotation_matrix();
        let inverse = match self.inertia_scale(state) {
            Some(scale) => scaled_by(&self.inverse_inertia, &scale.map(f64::recip)),
            None => self.inverse_inertia,
        };
        turn.matrix() * inverse * turn.matrix().transpose()
    }

    /// Returns I ω in the world frame, N·m·s.
    #[must_use]
    pub fn angular_momentum(&self, state: &BodyState, angular_velocity: &Vector3) -> Vector3 {
        let local = state.orientation.inverse_transform_vector(angular_velocity);
        state.orientation.transform_vector(&(self.inertia_at(state) * local))
    }

    /// Returns the angular velocity ω, rad/s.
    #[must_use]
    pub fn angular_velocity(&self, state: &BodyState) -> Vector3 {
        if self.motion == BodyMotion::Fixed { Vector3::zeros() } else { self.spin(state, &state.angular_momentum) }
    }

    /// Returns the velocity V + ω × r of the body at a world point, m/s.
    #[must_use]
    pub fn velocity_at(&self, state: &BodyState, point: &Vector3) -> Vector3 {
        state.velocity + self.angular_velocity(state).cross(&(point - state.position))
    }

    /// Applies an impulse at a world point in the free directions: V += J/M, L += r × J; nothing unless the body is
    /// free.
    pub fn strike(&self, state: &mut BodyState, point: &Vector3, impulse: &Vector3) {
        if self.motion == BodyMotion::Free {
            state.velocity += self.freedom.translation(impulse) / self.mass;
            state.angular_momentum += self.freedom.rotation(&(point - state.position).cross(impulse));
        }
    }

    /// Returns true if the ledger counts the energy and momentum of the body: neither a fixed nor an inactive body
    /// does.
    fn is_counted(&self, state: &BodyState) -> bool {
        self.motion != BodyMotion::Fixed && state.active
    }

    /// Returns the mass that the ledger counts, kg; 0 if the body does not count.
    #[must_use]
    pub fn counted_mass(&self, state: &BodyState) -> f64 {
        if self.is_counted(state) { self.mass } else { 0.0 }
    }

    /// Returns the kinetic energy ½MV² + ½ω·L, J; 0 if the body does not count.
    #[must_use]
    pub fn kinetic_energy(&self, state: &BodyState) -> f64 {
        if !self.is_counted(state) {
            return 0.0;
        }
        0.5 * (self.mass * state.velocity.norm_squared() + self.angular_velocity(state).dot(&state.angular_momentum))
    }

    /// Returns the momentum M V, N·s; 0 if the body does not count.
    #[must_use]
    pub fn momentum(&self, state: &BodyState) -> Vector3 {
        if self.is_counted(state) { state.velocity * self.mass } else { Vector3::zeros() }
    }

    /// Returns the angular momentum X × MV + L about the origin, N·m·s; 0 if the body does not count.
    #[must_use]
    pub fn total_angular_momentum(&self, state: &BodyState) -> Vector3 {
        if !self.is_counted(state) {
            return Vector3::zeros();
        }
        state.position.cross(&self.momentum(state)) + state.angular_momentum
    }

    /// Returns true if the orientation has to be stepped: the body turns, with anisotropic inertia or under a torque.
    #[must_use]
    pub fn needs_orientation_steps(&self, state: &BodyState) -> bool {
        let turned = state.wrench.torque != Vector3::zeros() || state.wrench.torque_rate != Vector3::zeros();
        self.motion == BodyMotion::Free
            && state.active
            && (turned || (self.isotropic.is_none() && state.angular_momentum != Vector3::zeros()))
    }
}
