//! Validation of the output fields: each is of the gel, and named once.

use super::domain::{CheckResult, require};
use crate::scene::{OutputField, Scene};

/// Key of the list.
const KEY: &str = "output.fields";

/// Checks that the gel has the fields.
pub(super) fn check_fields(scene: &Scene) -> CheckResult {
    let fields = &scene.output.fields;
    for (i, field) in fields.iter().enumerate() {
        let name = field.name();
        let is_first = !fields[..i].contains(field);
        require(is_first, KEY, || format!("\"{name}\" twice"), "each field once")?;
        let Some(remedy) = missing_key(*field, scene) else { continue };
        let known = OutputField::ALL.into_iter().filter(|known| missing_key(*known, scene).is_none());
        let known: Vec<String> = known.map(|known| format!("\"{}\"", known.name())).collect();
        let expected = format!("fields that this gel has, {}: \"{name}\" is of {remedy}", known.join(", "));
        require(false, KEY, || format!("\"{name}\""), &expected)?;
    }
    Ok(())
}

/// Returns the gel that has a field, if this one has not.
fn missing_key(field: OutputField, scene: &Scene) -> Option<&'static str> {
    let gel = &scene.gel;
    match field {
        OutputField::Pressure | OutputField::VonMises | OutputField::StrainRate => None,
        OutputField::ViscousStrain => {
            gel.branches.is_empty().then_some("a gel of material \"two-network\" with gel.branches")
        }
        OutputField::Layer => scene.layer.is_empty().then_some("a scene with layers"),
        OutputField::Damage => gel.damage.is_none().then_some("a gel of material \"two-network\" with gel.damage"),
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{Override, builtin, no_files, read_with};

    fn refusal(scene: &str, fields: &str) -> String {
        let text = builtin(scene).expect("a built-in scene");
        let own = Override { key: "output.fields".to_owned(), value: fields.to_owned() };
        match read_with(text, &[own], &no_files) {
            Ok(_) => String::new(),
            Err(error) => error.error.to_string(),
        }
    }

    #[test]
    fn a_field_that_the_gel_has_not_is_refused_with_those_that_it_has() {
        assert_eq!(refusal("fbi-bb", "[\"damage\", \"viscous_strain\", \"von_mises\"]"), "");
        assert_eq!(refusal("sphere-block", "[\"pressure\", \"strain_rate\"]"), "");
        // A gel with branches and without damage.
        assert_eq!(refusal("bounce-visco", "[\"viscous_strain\"]"), "");
        assert!(refusal("bounce-visco", "[\"damage\"]").ends_with("with gel.damage"));
        assert_eq!(
            refusal("sphere-block", "[\"pressure\", \"damage\"]"),
            "output.fields: found \"damage\", expected fields that this gel has, \"pressure\", \"von_mises\", \
             \"strain_rate\": \"damage\" is of a gel of material \"two-network\" with gel.damage"
        );
        assert!(refusal("sphere-block", "[\"viscous_strain\"]").ends_with("with gel.branches"));
        assert!(refusal("fbi-bb", "[\"damage\", \"damage\"]").contains("found \"damage\" twice"));
        let misspelt = refusal("fbi-bb", "[\"presure\"]");
        assert!(misspelt.contains("\"presure\" (did you mean `pressure`?)"), "{misspelt}");
    }
}
