//! Ports: the variables that an FMU of a scene has, without those that the scene cannot use.

use super::scalar::ScalarVariable;
use super::table::{Causality, EnergyAccount, Input, Observed, OutputSet, Source, VARIABLES, Variable};
use crate::scene::{
    BodyShape, ContactLaw, Dimension, MOST_FRAGMENTS, MOST_SENSORS, MaterialModel, ProjectileSpec, Scene,
};

/// Bodies, sensors and gel of a scene, as far as its variables depend on them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VariablePorts {
    /// Dimension of the motion.
    dimension: Dimension,
    /// Bodies with variables, the projectile first.
    bodies: Vec<BodyPorts>,
    /// Number of sensors with variables.
    sensors: usize,
    /// True for a gel with a preset.
    has_preset: bool,
    /// True for a gel of two networks.
    has_networks: bool,
    /// True for a contact law with friction.
    has_friction: bool,
}

/// Properties of a body that decide on its variables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct BodyPorts {
    is_dome: bool,
    expansion: ExpansionOwner,
    is_fixed: bool,
}

/// Owner of the opening of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ExpansionOwner {
    /// The body does not expand.
    None,
    /// The law of the scene.
    Law,
    /// The importer, by inputs.
    Importer,
}

impl ExpansionOwner {
    fn of(body: &ProjectileSpec) -> Self {
        match &body.expansion {
            None => Self::None,
            Some(expansion) if expansion.is_prescribed() => Self::Importer,
            Some(_) => Self::Law,
        }
    }
}

impl BodyPorts {
    /// Ports of a body with every variable.
    const ALL: Self = Self { is_dome: true, expansion: ExpansionOwner::Importer, is_fixed: false };
}

impl VariablePorts {
    /// Returns the ports of all fragments and sensors of a scene.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let bodies = (0..scene.n_bodies()).map(|body| scene.body(body));
        let bodies = bodies.map(|body| BodyPorts {
            is_dome: matches!(body.shape, BodyShape::Dome { .. }),
            expansion: ExpansionOwner::of(body),
            is_fixed: body.fixed,
        });
        Self {
            dimension: scene.freedom(),
            bodies: bodies.collect(),
            sensors: scene.sensor.len(),
            has_preset: scene.gel.preset.is_some(),
            has_networks: scene.gel.material == MaterialModel::TwoNetwork,
            has_friction: scene.contact.law == ContactLaw::Moreau,
        }
    }

    /// Returns the ports of any scene: every variable, for as many fragments and sensors as a scene can have.
    #[must_use]
    pub fn all() -> Self {
        Self {
            dimension: Dimension::Spatial,
            bodies: vec![BodyPorts::ALL; 1 + MOST_FRAGMENTS],
            sensors: MOST_SENSORS,
            has_preset: true,
            has_networks: true,
            has_friction: true,
        }
    }

    /// Returns the ports of the first fragments and sensors alone.
    #[must_use]
    pub fn limited_to(mut self, fragments: usize, sensors: usize) -> Self {
        self.bodies.truncate(1 + fragments);
        self.sensors = self.sensors.min(sensors);
        self
    }

    /// Returns the number of fragments.
    #[must_use]
    pub fn fragments(&self) -> usize {
        self.bodies.len() - 1
    }

    /// Returns the number of sensors.
    #[must_use]
    pub fn sensors(&self) -> usize {
        self.sensors
    }

    /// Returns true if the scene can use a variable of a body or sensor.
    #[must_use]
    pub fn include(&self, scalar: &ScalarVariable) -> bool {
        let ScalarVariable { variable, component, body } = *scalar;
        if variable.is_of_sensors() {
            return body < self.sensors;
        }
        let Some(ports) = self.bodies.get(body).filter(|_| body == 0 || variable.each) else { return false };
        match variable.source {
            Source::Input(input) => match input_group(input) {
                InputGroup::Motion | InputGroup::Wrench => !ports.is_fixed && self.is_free(input, component),
                InputGroup::Activity => true,
                InputGroup::Shape if is_expansion(input) => ports.expansion == ExpansionOwner::Importer,
                InputGroup::Shape => ports.is_dome,
            },
            Source::Observed(Observed::ContactBulgeHeightImpulse | Observed::ContactBulgeRadiusImpulse) => {
                ports.is_dome
            }
            Source::Observed(Observed::ProjectileExpansion | Observed::ContactExpansionImpulse) => {
                ports.expansion != ExpansionOwner::None
            }
            Source::Observed(Observed::Energy(EnergyAccount::Expansion)) => {
                self.bodies.iter().any(|body| body.expansion != ExpansionOwner::None)
            }
            Source::Scene if variable.name.starts_with("projectile.expansion_") => {
                ports.expansion != ExpansionOwner::None
            }
            Source::Scene => self.include_parameter(variable),
            Source::Setting(_) | Source::Observed(_) => true,
        }
    }

    /// Returns true if the dimension of the motion leaves a component of a motion, force or torque free.
    fn is_free(&self, input: Input, component: usize) -> bool {
        // What remains of a quaternion about the axis is 1.
        let is_one = self.dimension == Dimension::Axisymmetric && input == Input::ProjectileOrientation;
        !is_one && !excluded_components(input, self.dimension).contains(&component)
    }

    /// Returns the causality of a scalar in an FMU with a set of outputs. In [`OutputSet::Integrated`] a predicted
    /// component that the dimension of the motion keeps at its start is a local.
    #[must_use]
    pub fn causality(&self, scalar: &ScalarVariable, set: OutputSet) -> Causality {
        let is_kept = set == OutputSet::Integrated
            && predicted_motion(scalar.variable).is_some_and(|motion| !self.is_free(motion, scalar.component));
        match scalar.variable.causality_in(set) {
            Causality::Output if is_kept => Causality::Local,
            causality => causality,
        }
    }

    /// Returns true if the scene can use a parameter.
    fn include_parameter(&self, parameter: &Variable) -> bool {
        match parameter.name {
            "gel.preset" => self.has_preset,
            "gel.strength_scale" => self.has_networks,
            "contact.friction" => self.has_friction,
            _ => true,
        }
    }

    /// Returns every scalar of an FMU with these ports, by ascending value reference.
    pub fn scalars(&self) -> impl Iterator<Item = ScalarVariable> + '_ {
        let block = |body: usize| VARIABLES.iter().flat_map(move |variable| ScalarVariable::of(variable, body));
        let blocks = self.bodies.len().max(self.sensors);
        (0..blocks).flat_map(block).filter(|scalar| self.include(scalar))
    }

    /// Returns the first input of another scene that these ports lack.
    pub(super) fn missing_input(&self, other: &Self) -> Option<ScalarVariable> {
        let is_input = |scalar: &ScalarVariable| scalar.variable.causality == Causality::Input;
        other.scalars().filter(is_input).find(|scalar| !self.include(scalar))
    }
}

/// Group of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum InputGroup {
    /// Position and motion.
    Motion,
    /// External force and torque.
    Wrench,
    /// Activity.
    Activity,
    /// Shape of a dome or an expanding body, and its rates.
    Shape,
}

/// Returns true for the opening of an expanding body or its rate.
fn is_expansion(input: Input) -> bool {
    matches!(input, Input::ProjectilePrescribedExpansion | Input::ProjectilePrescribedExpansionRate)
}

/// Returns the group of an input.
pub(super) fn input_group(input: Input) -> InputGroup {
    match input {
        Input::ProjectilePosition
        | Input::ProjectileVelocity
        | Input::ProjectileOrientation
        | Input::ProjectileAngularVelocity => InputGroup::Motion,
        Input::ProjectileExternalForce | Input::ProjectileExternalTorque => InputGroup::Wrench,
        Input::ProjectileActive => InputGroup::Activity,
        Input::ProjectileBulgeHeight
        | Input::ProjectileBulgeRadius
        | Input::ProjectileBulgeHeightRate
        | Input::ProjectileBulgeRadiusRate
        | Input::ProjectilePrescribedExpansion
        | Input::ProjectilePrescribedExpansionRate => InputGroup::Shape,
    }
}

/// Returns the input of the motion that a variable predicts.
fn predicted_motion(variable: &Variable) -> Option<Input> {
    match variable.source {
        Source::Observed(Observed::ProjectilePredictedPosition) => Some(Input::ProjectilePosition),
        Source::Observed(Observed::ProjectilePredictedVelocity) => Some(Input::ProjectileVelocity),
        Source::Observed(Observed::ProjectilePredictedOrientation) => Some(Input::ProjectileOrientation),
        Source::Observed(Observed::ProjectilePredictedAngularVelocity) => Some(Input::ProjectileAngularVelocity),
        _ => None,
    }
}

/// Returns the components out of the plane or off the axis.
pub(super) fn excluded_components(input: Input, dimension: Dimension) -> &'static [usize] {
    let is_translational =
        [Input::ProjectilePosition, Input::ProjectileVelocity, Input::ProjectileExternalForce].contains(&input);
    let is_rotational = [Input::ProjectileAngularVelocity, Input::ProjectileExternalTorque].contains(&input);
    match (dimension, input) {
        (Dimension::Planar, Input::ProjectileOrientation) => &[1, 3],
        (Dimension::Axisymmetric, Input::ProjectileOrientation) => &[1, 2, 3],
        (Dimension::Planar, _) if is_translational => &[1],
        (Dimension::Planar, _) if is_rotational => &[0, 2],
        (Dimension::Axisymmetric, _) if is_translational => &[0, 1],
        (Dimension::Axisymmetric, _) if is_rotational => &[0, 1, 2],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    #[test]
    fn every_reference_finds_its_own_scalar() {
        let mut last = 0;
        for scalar in VariablePorts::all().limited_to(3, 5).scalars() {
            assert_eq!(ScalarVariable::find(scalar.reference()), Some(scalar));
            assert!(scalar.reference() > last);
            last = scalar.reference();
        }
        assert_eq!([0, 9_999, 10_001].map(ScalarVariable::find), [None; 3]);
    }

    #[test]
    fn no_more_sensors_are_there_than_asked_for() {
        let count = |sensors| {
            let ports = VariablePorts::all().limited_to(0, sensors);
            ports.scalars().filter(|scalar| scalar.variable.is_of_sensors()).count()
        };
        assert_eq!([0, 1, 3].map(count), [0, 7, 21]);
    }

    fn inputs(scene: &str, set: &[&str]) -> Vec<String> {
        let text = scene::builtin(scene).unwrap();
        let set: Vec<scene::Override> = set.iter().map(|set| set.parse().unwrap()).collect();
        let ports = VariablePorts::of(&scene::read_with(text, &set, &|_| unreachable!()).unwrap().scene);
        let inputs = ports.scalars().filter(|scalar| matches!(scalar.variable.source, Source::Input(_)));
        inputs.map(|scalar| scalar.name()).collect()
    }

    #[test]
    fn inputs_that_a_scene_cannot_use_are_absent() {
        assert_eq!(inputs("sphere-block", &[]).len(), 3 + 3 + 4 + 3 + 3 + 3 + 1);
        let on_axis = ["position[3]", "velocity[3]", "external_force[3]", "active"];
        assert_eq!(inputs("fbi-bb", &[]), on_axis.map(|name| format!("projectile.{name}")));
    }

    #[test]
    fn a_planar_scene_moves_in_the_plane() {
        let in_plane = ["position[1]", "position[3]", "velocity[1]", "velocity[3]", "orientation[1]", "orientation[3]"];
        let rest = ["angular_velocity[2]", "external_force[1]", "external_force[3]", "external_torque[2]", "active"];
        let expected: Vec<String> = in_plane.iter().chain(&rest).map(|name| format!("projectile.{name}")).collect();
        assert_eq!(inputs("ball-square", &[]), expected);
    }

    #[test]
    fn a_dome_has_its_bulge_and_nothing_that_would_move_it() {
        let sphere = scene::read(scene::builtin("sphere-block").unwrap()).unwrap();
        let dome = BodyShape::Dome { height: 0.0, radius: 0.01 };
        let fragment = ProjectileSpec { shape: dome, fixed: true, ..sphere.projectile.clone() };
        let with_dome = VariablePorts::of(&Scene { fragment: vec![fragment], ..sphere.clone() });
        let own = with_dome.scalars().filter(|scalar| scalar.body == 1);
        let inputs = own.filter(|scalar| matches!(scalar.variable.source, Source::Input(_)));
        let names: Vec<String> = inputs.map(|scalar| scalar.name()).collect();
        let expected = ["active", "bulge_height", "bulge_radius", "bulge_height_rate", "bulge_radius_rate"];
        assert_eq!(names, expected.map(|name| format!("fragment[1].{name}")));
        let plain = VariablePorts::of(&sphere);
        assert_eq!(plain.missing_input(&plain), None);
        assert_eq!(with_dome.missing_input(&plain), None);
        let missing = plain.missing_input(&with_dome).map(|scalar| scalar.name());
        assert_eq!(missing.as_deref(), Some("fragment[1].active"));
    }

    /// Names of the outputs of a scene in a set.
    fn outputs(scene: &str, set: OutputSet) -> Vec<String> {
        let ports = VariablePorts::of(&scene::read(scene::builtin(scene).unwrap()).unwrap());
        let outputs = ports.scalars().filter(|scalar| ports.causality(scalar, set) == Causality::Output);
        outputs.map(|scalar| scalar.name()).collect()
    }

    #[test]
    fn the_sets_of_a_coupling_mode_offer_sixteen_outputs_of_a_sphere_at_most() {
        let count = |set| outputs("sphere-block", set).len();
        assert_eq!([OutputSet::Integrated, OutputSet::Corrected, OutputSet::Full].map(count), [16, 16, 46]);
    }

    #[test]
    fn a_mode_in_which_the_importer_owns_the_body_has_the_step_and_the_energy_of_the_coupling() {
        let corrected = outputs("sphere-block", OutputSet::Corrected);
        for name in ["coupling.step_advice", "coupling.energy_residual"] {
            assert!(corrected.contains(&name.to_owned()), "{name}");
        }
    }

    #[test]
    fn no_built_in_scene_has_more_outputs_by_default_than_importers_plot() {
        for (scene, _) in scene::builtins() {
            let outputs = outputs(scene, OutputSet::Integrated);
            assert!(outputs.len() <= 16, "{scene}: {outputs:?}");
        }
        let dent = outputs("backface-dent", OutputSet::Integrated);
        let on_axis = ["contact.active", "contact.bulge_height_impulse", "contact.bulge_radius_impulse"];
        let motion = ["predicted_position[3]", "predicted_velocity[3]", "depth", "perforated"];
        let motion = motion.map(|name| format!("projectile.{name}"));
        let sensors = [1, 2, 3].map(|sensor| format!("sensor[{sensor}].pressure"));
        for name in on_axis.map(str::to_owned).into_iter().chain(motion).chain(sensors) {
            assert!(dent.contains(&name), "{name}: {dent:?}");
        }
    }
}
