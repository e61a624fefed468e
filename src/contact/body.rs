use super::{BodyState, Wrench};
use crate::geometry::{Gap, Shape, SignedDistance};
use crate::math::{Tensor3, Vector, Vector3};

/// Who decides how the body moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// It stays where it is.
    Fixed,
    /// Given from outside: impulses do not change it.
    Prescribed,
    /// Newton and Euler, under impulses and an external wrench.
    Free,
}

/// World directions that the dimension of the scene leaves (numerics A1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Freedom {
    /// Translation along x, y, z.
    pub translation: [bool; 3],
    /// Rotation about x, y, z.
    pub rotation: [bool; 3],
}

impl Freedom {
    /// Plane strain in x–z: P_x, P_z, L_y.
    pub const PLANAR: Self = Self { translation: [true, false, true], rotation: [false, true, false] };
    /// Revolution about z: P_z.
    pub const AXISYMMETRIC: Self = Self { translation: [false, false, true], rotation: [false; 3] };
    /// Everything.
    pub const SPATIAL: Self = Self { translation: [true; 3], rotation: [true; 3] };

    /// S v, the part of a translation that is left.
    #[must_use]
    pub fn translation(&self, v: &Vector3) -> Vector3 {
        masked(v, self.translation)
    }

    /// An orientation (w, x, y, z) without what is round-off because the body turns about y alone.
    #[must_use]
    pub fn turns(&self, [w, x, y, z]: [f64; 4]) -> [f64; 4] {
        if *self == Self::PLANAR { [w, 0.0, y, 0.0] } else { [w, x, y, z] }
    }

    /// The part of a rotation that is left.
    #[must_use]
    pub fn rotation(&self, v: &Vector3) -> Vector3 {
        masked(v, self.rotation)
    }
}

fn isotropic(inertia: &Tensor3) -> bool {
    *inertia == Tensor3::identity() * inertia[(0, 0)]
}

fn masked(v: &Vector3, keep: [bool; 3]) -> Vector3 {
    Vector3::from_fn(|i, _| if keep[i] { v[i] } else { 0.0 })
}

/// A rigid body: what does not change while it moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Shape, in the frame of the body.
    pub shape: Shape,
    /// Who decides how it moves.
    pub motion: Motion,
    /// Directions it may move in.
    pub freedom: Freedom,
    /// M, kg; infinite if fixed.
    pub mass: f64,
    /// I_b, inertia about the centre of mass in the frame of the body, kg·m².
    pub inertia: Tensor3,
    /// I_b⁻¹; zero if fixed.
    pub inverse_inertia: Tensor3,
    /// 1/I of a body that resists rotation about every axis alike, 1/(kg·m²).
    isotropic: Option<f64>,
}

impl Body {
    /// A body that is free to move or prescribed.
    ///
    /// # Panics
    /// If mass or inertia are not positive definite.
    #[must_use]
    pub fn new(shape: Shape, motion: Motion, freedom: Freedom, (mass, inertia): (f64, Tensor3)) -> Self {
        assert!(mass > 0.0, "the mass of a moving body must be positive");
        let inverse_inertia = inertia.cholesky().expect("an inertia tensor is positive definite").inverse();
        let isotropic = isotropic(&inertia).then_some(inverse_inertia[(0, 0)]);
        Self { shape, motion, freedom, mass, inertia, inverse_inertia, isotropic }
    }

    /// A body that is held.
    #[must_use]
    pub fn fixed(shape: Shape, freedom: Freedom) -> Self {
        let (inertia, inverse_inertia) = (Tensor3::identity(), Tensor3::zeros());
        let (motion, mass, isotropic) = (Motion::Fixed, f64::INFINITY, Some(0.0));
        Self { shape, motion, freedom, mass, inertia, inverse_inertia, isotropic }
    }

    /// Whether a state can be one of this body: in its plane or on its axis, turned by a unit quaternion, and a dome only if the body
    /// is one.
    #[must_use]
    pub fn admits(&self, state: &BodyState) -> bool {
        /// Of the norm of a quaternion: rounding over a long run.
        const SLACK: f64 = 1e-6;
        let Wrench { force, torque, force_rate, torque_rate } = &state.wrench;
        let along = [&state.position, &state.velocity, force, force_rate];
        let about = [&self.angular_velocity(state), torque, torque_rate];
        let q = state.orientation.quaternion();
        let turned = [q.w, q.i, q.j, q.k];
        along.into_iter().all(|v| self.freedom.translation(v) == *v)
            && about.into_iter().all(|v| self.freedom.rotation(v) == *v)
            && self.freedom.turns(turned) == turned
            && (q.norm() - 1.0).abs() <= SLACK
            && state.bulge.is_some() == matches!(self.shape, Shape::Dome(_))
    }

    /// φ and n at a world point.
    #[must_use]
    #[inline]
    pub fn gap(&self, state: &BodyState, point: &Vector3) -> Gap {
        let away = point - state.position;
        if let Shape::Sphere(sphere) = &self.shape {
            return sphere.gap(&away);
        }
        let local = state.orientation.inverse_transform_vector(&away);
        let gap = match &state.bulge {
            Some(bulge) => bulge.dome().gap(&local),
            None => self.shape.gap(&local),
        };
        Gap { distance: gap.distance, normal: state.orientation.transform_vector(&gap.normal) }
    }

    /// How fast the surface at a world point moves along its normal as height and base radius of a dome grow, m/s per m/s;
    /// zero for any other body.
    #[must_use]
    pub fn growth(&self, state: &BodyState, point: &Vector3) -> Vector<2> {
        let local = || state.orientation.inverse_transform_vector(&(point - state.position));
        state.bulge.map_or_else(Vector::<2>::zeros, |bulge| -Vector::<2>::from(bulge.dome().growth(&local())))
    }

    /// Depth of the foremost point below z = 0, m.
    #[must_use]
    pub fn depth(&self, state: &BodyState) -> f64 {
        self.reach(state, &-Vector3::z()) - state.position.z
    }

    /// Height of the rearmost point, the highest, m.
    #[must_use]
    pub fn rear(&self, state: &BodyState) -> f64 {
        state.position.z + self.reach(state, &Vector3::z())
    }

    /// Extent from the centre of mass along a unit vector of the world, m; infinite of an unbounded body.
    #[must_use]
    pub fn reach(&self, state: &BodyState, direction: &Vector3) -> f64 {
        let local = state.orientation.inverse_transform_vector(direction);
        match &state.bulge {
            Some(bulge) => bulge.dome().reach(&local),
            None => self.shape.reach(&local),
        }
    }

    /// 1/M + (r×n)·I⁻¹(r×n) in the directions left, 1/kg; 0 if impulses do not move it (numerics 2.3, A1).
    #[must_use]
    pub fn compliance(&self, state: &BodyState, arm: &Vector3, normal: &Vector3) -> f64 {
        if self.motion != Motion::Free {
            return 0.0;
        }
        let lever = self.freedom.rotation(&arm.cross(normal));
        self.freedom.translation(normal).norm_squared() / self.mass + lever.dot(&self.spin(state, &lever))
    }

    /// I⁻¹ L in the world frame.
    #[must_use]
    pub fn spin(&self, state: &BodyState, angular_momentum: &Vector3) -> Vector3 {
        if let Some(inverse) = self.isotropic {
            return angular_momentum * inverse;
        }
        let local = state.orientation.inverse_transform_vector(angular_momentum);
        state.orientation.transform_vector(&(self.inverse_inertia * local))
    }

    /// I ω in the world frame.
    #[must_use]
    pub fn angular_momentum(&self, state: &BodyState, angular_velocity: &Vector3) -> Vector3 {
        let local = state.orientation.inverse_transform_vector(angular_velocity);
        state.orientation.transform_vector(&(self.inertia * local))
    }

    /// ω, rad/s.
    #[must_use]
    pub fn angular_velocity(&self, state: &BodyState) -> Vector3 {
        if self.motion == Motion::Fixed { Vector3::zeros() } else { self.spin(state, &state.angular_momentum) }
    }

    /// V + ω × r of the body's point at a world point, m/s.
    #[must_use]
    pub fn velocity_at(&self, state: &BodyState, point: &Vector3) -> Vector3 {
        state.velocity + self.angular_velocity(state).cross(&(point - state.position))
    }

    /// Applies an impulse at a world point: V += J/M, L += r × J, in the directions left; nothing if it is not free.
    pub fn strike(&self, state: &mut BodyState, point: &Vector3, impulse: &Vector3) {
        if self.motion == Motion::Free {
            state.velocity += self.freedom.translation(impulse) / self.mass;
            state.angular_momentum += self.freedom.rotation(&(point - state.position).cross(impulse));
        }
    }

    /// Whether it has energy and momentum that the books know: neither a fixed nor an inactive body does.
    fn counts(&self, state: &BodyState) -> bool {
        self.motion != Motion::Fixed && state.active
    }

    /// ½MV² + ½ω·L, J; 0 if it does not count.
    #[must_use]
    pub fn kinetic_energy(&self, state: &BodyState) -> f64 {
        if !self.counts(state) {
            return 0.0;
        }
        0.5 * (self.mass * state.velocity.norm_squared() + self.angular_velocity(state).dot(&state.angular_momentum))
    }

    /// M V, N·s; 0 if it does not count.
    #[must_use]
    pub fn momentum(&self, state: &BodyState) -> Vector3 {
        if self.counts(state) { state.velocity * self.mass } else { Vector3::zeros() }
    }

    /// X × MV + L about the origin, N·m·s; 0 if it does not count.
    #[must_use]
    pub fn total_angular_momentum(&self, state: &BodyState) -> Vector3 {
        if !self.counts(state) {
            return Vector3::zeros();
        }
        state.position.cross(&self.momentum(state)) + state.angular_momentum
    }

    /// Whether the orientation has to be stepped: it turns, under inertia that is not that of a sphere or a torque.
    #[must_use]
    pub fn tumbles(&self, state: &BodyState) -> bool {
        let turned = state.wrench.torque != Vector3::zeros() || state.wrench.torque_rate != Vector3::zeros();
        self.motion == Motion::Free
            && state.active
            && (turned || (self.isotropic.is_none() && state.angular_momentum != Vector3::zeros()))
    }
}
