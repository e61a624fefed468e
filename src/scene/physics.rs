//! Lists the physics that a scene models, and the physics that it leaves out.

use super::instant::{OMITTED, describe_reduced};
use super::layer::{describe_layers, omitted_in_layers};
use super::{
    BodyShape, CellLattice, ContactLaw, Dimension, ElementKind, FaceSupport, GelFace, GelShape, GelSpec, GelSymmetry,
    MaterialModel, RemeshMethod, Scene, ScheduleKind, SupportSpec, body_name, numbered,
};
use crate::geometry::{ShapeGeometry, SignedDistance, TriangulatedBody};
use crate::integrator::fixed;
use crate::math::Vector3;

/// Returns one short sentence for each piece of physics that a scene computes.
#[must_use]
pub fn modelled_physics(scene: &Scene) -> Vec<String> {
    if let Some(class) = scene.reduced_class() {
        return describe_reduced(class).into_iter().chain(describe_body(scene, 0)).collect();
    }
    let general = [
        describe_space(scene.scene.dimension),
        describe_material(scene),
        describe_elements(scene),
        describe_volume(scene),
        describe_steps(scene),
        describe_contact(scene.contact.law),
    ];
    let remeshing = scene.remesh.as_ref().map(|remesh| match remesh.method {
        RemeshMethod::Local if scene.gel.material != MaterialModel::TwoNetwork => {
            "remeshing: elements that hinder the step remade by operations that keep the rest map"
        }
        RemeshMethod::Local if scene.scene.dimension == Dimension::Spatial => {
            "remeshing: distorted mesh replaced locally, old nodes retained where elements are good"
        }
        RemeshMethod::Local => {
            "remeshing: distorted elements remade by operations, edges near bodies kept to their target"
        }
        RemeshMethod::Immersed => {
            "remeshing: distorted mesh replaced by the triangulation of a quadtree, cut at the boundary of the gel"
        }
    });
    let general = general.into_iter().chain(remeshing).chain(describe_networks(scene).into_iter().flatten());
    let bodies = (0..scene.n_bodies()).flat_map(|body| describe_body(scene, body));
    let part = match scene.gel.symmetry {
        GelSymmetry::None => None,
        GelSymmetry::Half => Some("symmetry: the half at y >= 0 is computed and represents the whole gel"),
        GelSymmetry::Quarter => {
            Some("symmetry: the quarter at x >= 0, y >= 0 is computed and represents the whole gel")
        }
    };
    let general = general.chain(part);
    general
        .map(str::to_owned)
        .chain(describe_layers(&scene.layer, &scene.gel))
        .chain(describe_loads(scene))
        .chain(scene.gel.cavity.describe())
        .chain(describe_damping(scene))
        .chain(bodies)
        .chain(describe_sensors(scene))
        .collect()
}

/// Describes each pressure load.
fn describe_loads(scene: &Scene) -> impl Iterator<Item = String> + '_ {
    scene.load.iter().enumerate().map(|(i, load)| {
        let face = load.on.map_or("the surface", GelFace::name);
        let part = if load.within.is_some() { ", within a box" } else { "" };
        let depth = if load.depth > 0.0 {
            format!(", with its full value from {:?} m below z = 0 on", load.depth)
        } else {
            String::new()
        };
        let over = match (load.table.len(), load.ramp) {
            (0, 0.0) => "from the start".to_owned(),
            (0, ramp) => format!("with a linear ramp of {ramp:?} s"),
            (points, _) => format!("scaled by a table of {points} points"),
        };
        format!(
            "{}: a pressure of {:?} Pa on {face}{part}{depth}, {over}; a follower load",
            numbered("load", i),
            load.pressure
        )
    })
}

/// Describes each sensor.
fn describe_sensors(scene: &Scene) -> impl Iterator<Item = String> + '_ {
    scene.sensor.iter().enumerate().map(|(i, sensor)| {
        let name = numbered("sensor", i);
        format!(
            "{name}: pressure, displacement and velocity of the material point at {:?} m in the reference \
             configuration",
            sensor.position
        )
    })
}

fn describe_damping(scene: &Scene) -> Option<String> {
    let rate = scene.integrator.damping;
    (rate > 0.0).then(|| format!("damping: mass-proportional, velocities decay as exp(-t/{:.3e} s)", 1.0 / rate))
}

fn describe_body(scene: &Scene, i: usize) -> Vec<String> {
    let (name, body) = (body_name(i), scene.body(i));
    let motion = match scene.freedom() {
        _ if body.fixed => "rigid and fixed",
        Dimension::Planar => "rigid, translates and rotates in the plane",
        Dimension::Axisymmetric => "rigid, translates along the axis",
        Dimension::Spatial => "rigid, six degrees of freedom",
    };
    let grows = matches!(body.shape, BodyShape::Dome { .. }).then_some("a dome whose height and radius are inputs");
    let waits = (!body.active).then_some("inactive until it is activated");
    let lines = [
        Some(motion.to_owned()),
        grows.map(str::to_owned),
        waits.map(str::to_owned),
        describe_expansion(scene, i),
        describe_balance(scene, i),
    ];
    lines.into_iter().flatten().map(|line| format!("{name}: {line}")).collect()
}

/// Describes the expansion of a body.
fn describe_expansion(scene: &Scene, i: usize) -> Option<String> {
    let body = scene.body(i);
    let opened = body.expansion?.opened;
    let form = format!("{:.2} mm wide and {:.2} mm long", 2e3 * opened.radius, 1e3 * opened.length);
    let Some(law) = scene.expansion_law(i) else {
        return Some(format!("expands to a body {form} as the importer prescribes"));
    };
    let speed = |pressure: f64| (2.0 * pressure / law.density).sqrt();
    Some(format!(
        "expands to a body {form}, from {:.0} m/s ({:.3e} Pa of stagnation pressure) on in part, from {:.0} m/s ({:.3e} Pa) \
         on completely, along {:.1} mm of path; its surface moves as prescribed, and its work is energy.expansion",
        speed(law.opening_pressure),
        law.opening_pressure,
        speed(law.full_pressure),
        law.full_pressure,
        1e3 * law.path
    ))
}

/// Describes volume, mass and density of a bounded body; with a tip also the position of the centre of mass.
fn describe_balance(scene: &Scene, i: usize) -> Option<String> {
    let volume = scene.volume(i)?;
    let mass = scene.body(i).mass.map(|mass| format!(", mass {mass:.4e} kg, {} kg/m3", fixed(mass / volume, 0)));
    let tip = match scene.shape(i) {
        shape @ (ShapeGeometry::Profile(_) | ShapeGeometry::Expanding(_)) => {
            format!(", centre of mass {:.6} m behind the tip", shape.reach(&-Vector3::z()))
        }
        ShapeGeometry::Solid(solid) if matches!(scene.body(i).shape, BodyShape::Chisel(_)) => {
            format!(", centre of mass {:.6} m behind the front face", solid.reach(&-Vector3::z()))
        }
        ShapeGeometry::Solid(solid) => describe_surface(&solid),
        ShapeGeometry::Sphere(_) | ShapeGeometry::Plate(_) | ShapeGeometry::HalfSpace(_) | ShapeGeometry::Dome(_) => {
            String::new()
        }
    };
    Some(format!("volume {volume:.4e} m3{}{tip}", mass.unwrap_or_default()))
}

/// Describes a surface from a file by its size and orientation, so that the user can recognise it.
fn describe_surface(solid: &TriangulatedBody) -> String {
    let [x, y, z] = solid.centre().into();
    let size: Vector3 =
        [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| solid.reach(&axis) + solid.reach(&-axis)).into();
    let turned = if solid.was_turned() { " whose normals pointed inwards and were reversed" } else { "" };
    format!(
        ", a closed surface of {} triangles{turned}, {:.6} x {:.6} x {:.6} m, centre of mass at [{x:.6}, {y:.6}, {z:.6}] m of its file",
        solid.triangles().len(),
        size.x,
        size.y,
        size.z
    )
}

fn describe_space(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Planar => "gel: plane strain in the x-z plane, large deformation",
        Dimension::Axisymmetric => "gel: axisymmetric about z, large deformation",
        Dimension::Spatial => "gel: three dimensions, large deformation",
    }
}

fn describe_material(scene: &Scene) -> &'static str {
    match scene.gel.material {
        MaterialModel::NeoHookean => "material: compressible neo-Hookean, elastic shear and pressure waves",
        MaterialModel::MooneyRivlin => "material: compressible Mooney-Rivlin, elastic with two constants",
        MaterialModel::Ogden => "material: compressible Ogden, elastic in powers of the principal stretches",
        MaterialModel::TwoNetwork if is_fluid(&scene.gel) => "material: a fluid, pressure from an equation of state",
        MaterialModel::TwoNetwork => "material: two networks, elastic and viscous; pressure from an equation of state",
    }
}

/// Returns true for a two-network gel without an elastic network and without branches.
fn is_fluid(gel: &GelSpec) -> bool {
    gel.shear_modulus == 0.0 && gel.branches.is_empty()
}

/// Describes the networks, the equation of state, bulk viscosity and erosion of a two-network gel.
fn describe_networks(scene: &Scene) -> [Option<&'static str>; 9] {
    let (gel, remesh) = (&scene.gel, scene.remesh.as_ref());
    let has_networks = gel.material == MaterialModel::TwoNetwork;
    let shocks = gel.volume.is_some_and(|volume| volume.hugoniot_slope > 0.0);
    let voids = gel.volume.is_some_and(|volume| volume.tension_limit.is_some());
    [
        (has_networks && gel.shear_modulus > 0.0).then_some("elastic network: neo-Hookean, closes what a shot opens"),
        gel.damage.is_some().then_some("damage: of the elastic network, by stretch and with a delay"),
        (has_networks && !is_fluid(gel)).then_some(
            "well-posed: flow does not depend on pressure, damage has a delay, branches remain where the network fails",
        ),
        gel.branches.iter().any(|branch| branch.power_law.is_some()).then_some(
            "viscous branches: springs in series with power-law dashpots, without a yield stress and independent of pressure",
        ),
        gel.branches
            .iter()
            .any(|branch| branch.time.is_some())
            .then_some("viscous branches: springs in series with linear dashpots (Maxwell)"),
        shocks.then_some("pressure: shock Hugoniot, the shock speed rises with the particle velocity"),
        voids.then_some("tension: limited, voids open and close again"),
        gel.viscosity.is_some().then_some("bulk viscosity: shocks are spread over some elements"),
        remesh
            .is_some_and(|remesh| remesh.erosion_thickness.is_some())
            .then_some("erosion: thin sheets are removed with their mass and energy"),
    ]
}

fn describe_elements(scene: &Scene) -> &'static str {
    if scene.mesh.tree.is_some() {
        return match scene.scene.dimension {
            Dimension::Spatial => "elements: linear tetrahedra between the centres of octree cells",
            Dimension::Planar | Dimension::Axisymmetric => {
                "elements: linear triangles around the centres of quadtree cells"
            }
        };
    }
    match (scene.scene.dimension, scene.mesh.lattice) {
        (Dimension::Spatial, CellLattice::Centred) => "elements: linear tetrahedra of the body-centred cubic lattice",
        (Dimension::Spatial, CellLattice::Kuhn) => "elements: linear tetrahedra, six per cell",
        (Dimension::Planar | Dimension::Axisymmetric, CellLattice::Centred) => "elements: linear triangles, crossed",
        (Dimension::Planar | Dimension::Axisymmetric, CellLattice::Kuhn) => "elements: linear triangles, two per cell",
    }
}

fn describe_volume(scene: &Scene) -> &'static str {
    match (scene.mesh.element, scene.scene.dimension) {
        (ElementKind::Plain, _) => "volume: each element has its own volume change",
        (ElementKind::Patch, Dimension::Spatial) => {
            "volume: F-bar patches of up to four tetrahedra with a common volume change, free of locking"
        }
        (ElementKind::Patch, Dimension::Planar | Dimension::Axisymmetric) => {
            "volume: F-bar patches, pairs of triangles with a common volume change, free of locking"
        }
    }
}

fn describe_steps(scene: &Scene) -> &'static str {
    match scene.integrator.schedule {
        ScheduleKind::Bins => {
            "time: asynchronous variational integrator, element steps are powers of two of the tick (bins)"
        }
        ScheduleKind::Queue => "time: asynchronous variational integrator, element steps ordered by a priority queue",
        ScheduleKind::Global => "time: one global step, the stable step of the assembled system",
    }
}

fn describe_contact(law: ContactLaw) -> &'static str {
    match law {
        ContactLaw::Moreau => "contact: impulses at surface nodes (Moreau), no penalty",
        ContactLaw::Reversal => "contact: reversal of the normal momentum of approaching surface nodes, no penalty",
    }
}

/// Returns one short sentence for each piece of physics that a scene does not compute.
#[must_use]
pub fn switched_off(scene: &Scene) -> Vec<String> {
    if scene.reduced_class().is_some() {
        return OMITTED.map(str::to_owned).to_vec();
    }
    let mut off = vec![
        if scene.gel.damage.is_some() {
            "cracks: none, the elastic network is damaged but the gel does not tear"
        } else {
            "damage and failure: none, the gel does not tear"
        },
        "gravity: none",
        "heat: none",
        scene.gel.cavity.omitted(),
        omitted_in_layers(&scene.layer),
        if scene.bodies().any(|body| body.expansion.is_some()) {
            "deformation of the bodies: none but the prescribed expansion, which takes no energy of the body"
        } else {
            "deformation of the bodies: none, they are rigid"
        },
    ];
    off.extend(omitted_self_contact(scene));
    off.extend(omitted_viscosity(scene));
    off.extend(omitted_pressure_effects(scene).into_iter().flatten());
    off.extend(omitted_by_dimension(scene.scene.dimension));
    off.extend(omitted_by_tables(scene).into_iter().flatten());
    let fixed = scene.bodies().enumerate().filter(|(_, body)| body.fixed).map(|(i, _)| name_body(i));
    let still = fixed.map(|name| format!("motion of {name}: none, it is fixed"));
    off.into_iter().map(str::to_owned).chain(still).collect()
}

/// Names the missing contact of the gel with itself, or its limits.
fn omitted_self_contact(scene: &Scene) -> Option<&'static str> {
    if !scene.meets_itself() {
        return Some("self-contact of the gel: none, except at an axis or a plane of symmetry");
    }
    let is_spatial = scene.scene.dimension == Dimension::Spatial;
    is_spatial.then_some("self-contact of the gel: of nodes with facets, not of edges with edges")
}

/// Names the missing viscosity of a gel whose stress does not depend on the rate.
fn omitted_viscosity(scene: &Scene) -> Option<&'static str> {
    scene.gel.branches.is_empty().then_some("viscosity: none, the gel is elastic at all rates")
}

/// Names the missing effects of the pressure law, and missing erosion where the gel is remeshed.
fn omitted_pressure_effects(scene: &Scene) -> [Option<&'static str>; 4] {
    let (gel, remesh) = (&scene.gel, scene.remesh.as_ref());
    let shocks = gel.volume.is_some_and(|volume| volume.hugoniot_slope > 0.0);
    let voids = gel.volume.is_some_and(|volume| volume.tension_limit.is_some());
    let lacks_erosion = remesh.is_some_and(|remesh| remesh.erosion_thickness.is_none());
    [
        (!shocks).then_some("shock speed: that of sound, the Hugoniot slope is 0"),
        (!voids).then_some("voids: none, tension is unlimited"),
        gel.viscosity.is_none().then_some("bulk viscosity: none, shocks oscillate from element to element"),
        lacks_erosion.then_some("erosion: none by thickness, only where no mesh can follow"),
    ]
}

/// Names a body in a sentence.
fn name_body(body: usize) -> String {
    if body == 0 { "the projectile".to_owned() } else { body_name(body) }
}

fn omitted_by_dimension(dimension: Dimension) -> Option<&'static str> {
    match dimension {
        Dimension::Planar => Some("motion out of the plane: none"),
        Dimension::Axisymmetric => Some("motion off the axis, spin and torsion: none"),
        Dimension::Spatial => None,
    }
}

fn omitted_by_tables(scene: &Scene) -> [Option<&'static str>; 9] {
    let fixed =
        scene.remesh.is_none().then_some("remeshing: none, the run stops when the mesh cannot follow the deformation");
    let plain = scene.mesh.element == ElementKind::Plain;
    let locking = plain.then_some("locking-free elements: none, plain elements are too stiff near incompressibility");
    let apart = (scene.n_bodies() > 1).then_some("contact between bodies: none, only contact with the gel");
    let inelastic = scene.contact.law == ContactLaw::Moreau && scene.contact.restitution == 0.0;
    let restitution =
        inelastic.then_some("restitution of surface nodes: none, rebound comes from the elasticity of the gel");
    let smooth = (scene.contact.friction == 0.0).then_some("friction: none, the projectile slides freely");
    let unloaded = scene.load.is_empty().then_some("loads: none, only bodies and supports act on the gel");
    let undamped = (scene.integrator.damping == 0.0).then_some("damping: none, waves keep their energy");
    let free = has_no_supports(&scene.gel.supports) || matches!(scene.gel.shape, GelShape::LBeam { .. });
    let alone = scene.fragment.is_empty().then_some("fragments: none, the projectile is the only body");
    [
        alone,
        fixed,
        locking,
        smooth,
        apart,
        restitution,
        unloaded,
        undamped,
        free.then_some("supports: none, the gel is free"),
    ]
}

fn has_no_supports(supports: &SupportSpec) -> bool {
    let SupportSpec { x_min, x_max, y_min, y_max, z_min, z_max, side } = *supports;
    [x_min, x_max, y_min, y_max, z_min, z_max, side].iter().all(|&support| support == FaceSupport::Free)
}

#[cfg(test)]
mod tests {
    use super::{modelled_physics, switched_off};
    use crate::scene::{builtin, read};

    fn off(name: &str) -> Vec<String> {
        switched_off(&read(builtin(name).unwrap()).unwrap())
    }

    #[test]
    fn physics_without_a_key_is_listed_as_switched_off() {
        let off = off("sphere-block");
        for physics in ["friction", "viscosity", "damage and failure", "gravity", "remeshing", "locking-free"] {
            assert!(off.iter().any(|line| line.starts_with(physics)), "{physics} is not in {off:?}");
        }
    }

    #[test]
    fn modelled_physics_is_not_listed_as_switched_off() {
        let visco = off("bounce-visco");
        assert!(!visco.iter().any(|line| line.starts_with("viscosity")), "{visco:?}");
        let (shot, block) = (off("fbi-bb"), off("sphere-block"));
        for physics in ["voids", "bulk viscosity", "erosion"] {
            assert!(!shot.iter().any(|line| line.starts_with(physics)), "{physics}: {shot:?}");
        }
        for physics in ["voids", "bulk viscosity", "shock speed", "fragments", "air", "deformation of the bodies"] {
            assert!(block.iter().any(|line| line.starts_with(physics)), "{physics}: {block:?}");
        }
    }

    #[test]
    fn a_fixed_wall_and_a_free_beam_are_listed() {
        let off = off("l-beam");
        assert!(off.contains(&"motion of the projectile: none, it is fixed".to_owned()), "{off:?}");
        assert!(off.contains(&"supports: none, the gel is free".to_owned()), "{off:?}");
    }

    #[test]
    fn motion_out_of_the_plane_is_listed_in_two_dimensions_only() {
        assert!(off("ball-square").contains(&"motion out of the plane: none".to_owned()));
        assert!(off("ball-bounce").contains(&"motion off the axis, spin and torsion: none".to_owned()));
        assert!(!off("sphere-block").iter().any(|line| line.starts_with("motion")));
    }

    #[test]
    fn restitution_that_is_asked_for_is_not_switched_off() {
        let mut scene = read(builtin("sphere-block").unwrap()).unwrap();
        scene.contact.restitution = 0.5;
        assert!(!switched_off(&scene).iter().any(|line| line.starts_with("restitution")));
    }

    #[test]
    fn patches_that_are_asked_for_are_modelled_and_plain_elements_are_not_free_of_locking() {
        for (name, patch) in [("sphere-block", "four tetrahedra"), ("ball-square", "pairs of triangles")] {
            let free = |line: &String| line.contains(patch) && line.ends_with("free of locking");
            let locks = |line: &String| line.starts_with("locking-free elements: none");
            let mut scene = read(builtin(name).unwrap()).unwrap();
            assert!(!modelled_physics(&scene).iter().any(free) && switched_off(&scene).iter().any(locks));
            scene.mesh.element = crate::scene::ElementKind::Patch;
            assert!(modelled_physics(&scene).iter().any(free) && !switched_off(&scene).iter().any(locks));
        }
    }

    #[test]
    fn the_queue_is_named_where_it_is_chosen() {
        let mut scene = read(builtin("sphere-block").unwrap()).unwrap();
        scene.integrator.schedule = crate::scene::ScheduleKind::Queue;
        assert!(modelled_physics(&scene).iter().any(|line| line.contains("priority queue")));
    }

    #[test]
    fn a_bullet_says_where_its_centre_of_mass_is() {
        let cone = "projectile.shape={bullet={radius=0.01, length=0.04, nose={cone={length=0.04}}}}".parse().unwrap();
        let changes = [cone, "projectile.position=[0, 0, 0.03]".parse().unwrap()];
        let text = crate::scene::resolve(builtin("sphere-block").unwrap(), &changes).unwrap();
        let expected =
            "projectile: volume 4.1888e-6 m3, mass 3.3000e-2 kg, 7878 kg/m3, centre of mass 0.030000 m behind the tip";
        assert!(modelled_physics(&read(&text).unwrap()).iter().any(|line| line == expected));
    }
}
