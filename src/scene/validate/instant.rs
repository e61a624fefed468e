//! Validation of the level `instant`: a shot of a class from which coefficients were identified, in their range.

use super::domain::{CheckResult, all_finite, positive, require};
use crate::reduced::{IdentifiedClass, ReducedCoefficients};
use crate::scene::block_fit::approach;
use crate::scene::instant::body_class;
use crate::scene::model_error::{calibre, has_networks_of};
use crate::scene::{Dimension, FidelityKind, GelShape, Scene, SceneError};
use std::f64::consts::PI;

/// Remedy for a shot that the reduced model cannot compute.
const REMEDY: &str = "use --fidelity draft";
/// Least radius of the gel, calibres: the identified shots were in 4 calibres and more.
const LEAST_RADIUS: f64 = 4.0;
/// Relative margin around the identified range, for figures as people round them.
const MARGIN: f64 = 0.02;

pub(super) fn check(scene: &Scene) -> CheckResult {
    scene.instant.as_ref().map_or(Ok(()), check_coefficients)?;
    if scene.scene.fidelity == FidelityKind::Instant { check_shot(scene) } else { Ok(()) }
}

/// Refuses a shot that the reduced model cannot compute, whatever the level of the scene.
pub(in crate::scene) fn check_shot(scene: &Scene) -> CheckResult {
    check_gel(scene)?;
    check_extras(scene)?;
    check_contact(scene)?;
    let class = check_body(scene)?;
    check_range(scene, class)
}

/// Refuses what stands for the expectation.
fn refuse(good: bool, key: &str, found: &str, expected: &str) -> CheckResult {
    require(good, key, || found.to_owned(), &format!("{expected} at the level instant; {REMEDY}"))
}

/// Checks coefficients that the scene gives.
fn check_coefficients(own: &ReducedCoefficients) -> CheckResult {
    for (i, class) in own.class.iter().enumerate() {
        let key = format!("instant.class[{}]", i + 1);
        let is_new = own.class.iter().take(i).all(|other| other.body != class.body);
        require(is_new, &format!("{key}.body"), || format!("{:?} twice", class.body), "each class of bodies once")?;
        let laws = [("penetration", &class.penetration.entries()[..]), ("rings", &class.rings.entries()[..])];
        for (table, entries) in laws {
            for (name, value) in entries {
                positive(&format!("{key}.{table}.{name}"), *value, "a positive number")?;
            }
        }
        let errors = [class.depth_error, class.exit_error, class.cavity_error];
        all_finite(&format!("{key}.depth_error"), &errors)?;
        let range = &class.range;
        for (name, [least, most]) in
            [("diameter", range.diameter), ("sectional_density", range.sectional_density), ("speed", range.speed)]
        {
            let name = format!("{key}.range.{name}");
            positive(&name, least, "a positive number")?;
            let found = || format!("{:?}", [least, most]);
            require(most >= least && most.is_finite(), &name, found, "the least value before the greatest")?;
        }
    }
    Ok(())
}

fn check_gel(scene: &Scene) -> CheckResult {
    let dimension = scene.scene.dimension;
    let found = format!("{dimension:?}").to_lowercase();
    let about_axis = dimension == Dimension::Axisymmetric;
    refuse(about_axis, "scene.dimension", &format!("{found:?}"), "\"axisymmetric\": tumbling is not identified")?;
    let is_cylinder = matches!(scene.gel.shape, GelShape::Cylinder { bore: None, .. });
    refuse(is_cylinder, "gel.shape", "another shape", "a cylinder without a bore")?;
    let is_identified = scene.instant.is_some()
        || scene.reduced_coefficients().is_some()
            && scene.gel.preset.is_some_and(|preset| has_networks_of(&scene.gel, preset));
    refuse(
        is_identified,
        "gel",
        "a gel without coefficients",
        "preset = \"gelatin-10\" with its networks, or coefficients in [instant]",
    )
}

/// Refuses tables that the reduced model leaves out.
fn check_extras(scene: &Scene) -> CheckResult {
    let tables = [
        ("layer", scene.layer.len()),
        ("fragment", scene.fragment.len()),
        ("load", scene.load.len()),
        ("sensor", scene.sensor.len()),
        ("output.fields", scene.output.fields.len()),
    ];
    tables.into_iter().try_for_each(|(key, n)| refuse(n == 0, key, &format!("{n} of them"), "none"))
}

fn check_contact(scene: &Scene) -> CheckResult {
    let (contact, damping) = (&scene.contact, scene.integrator.damping);
    refuse(contact.friction == 0.0, "contact.friction", &format!("{:?}", contact.friction), "0")?;
    refuse(contact.restitution == 0.0, "contact.restitution", &format!("{:?}", contact.restitution), "0")?;
    refuse(damping == 0.0, "integrator.damping", &format!("{damping:?}"), "0")
}

fn check_body(scene: &Scene) -> Result<&IdentifiedClass, SceneError> {
    let body = &scene.projectile;
    refuse(!body.fixed, "projectile.fixed", "true", "a projectile that moves")?;
    refuse(
        body.expansion.is_none(),
        "projectile.expansion",
        "a table",
        "a rigid projectile, such as the recovered shape",
    )?;
    let expected = "a sphere, a capsule, or a bullet with a round nose and no tail: other shapes are not identified";
    let class = body_class(body).and_then(|class| scene.reduced_coefficients()?.of(class));
    class.ok_or_else(|| {
        let expected = format!("{expected} at the level instant; {REMEDY}");
        SceneError::value("projectile.shape", "another shape", expected)
    })
}

fn check_range(scene: &Scene, class: &IdentifiedClass) -> CheckResult {
    let width = calibre(&scene.shape(0));
    let mass = scene.projectile.mass.unwrap_or(0.0);
    let IdentifiedClass { range, .. } = class;
    let figures = [
        ("projectile.shape", "a calibre, m,", width, range.diameter),
        (
            "projectile.mass",
            "a sectional density m/A, kg/m2,",
            4.0 * mass / (PI * width * width),
            range.sectional_density,
        ),
        ("projectile.velocity", "a speed at the gel, m/s,", approach(scene, &scene.projectile).norm(), range.speed),
    ];
    for (key, what, found, [least, most]) in figures {
        let is_in = found >= least * (1.0 - MARGIN) && found <= most * (1.0 + MARGIN);
        refuse(is_in, key, &format!("{what} of {found:.4}"), &format!("{least} to {most}, the identified range,"))?;
    }
    let GelShape::Cylinder { radius, .. } = scene.gel.shape else { return Ok(()) };
    let expected = format!("at least {LEAST_RADIUS} calibres, {:.4} m,", LEAST_RADIUS * width);
    refuse(radius >= LEAST_RADIUS * width, "gel.shape.cylinder.radius", &format!("{radius:?}"), &expected)
}
