//! Keys and values that a scene may not have any more.

use super::SceneError;
use toml::de::DeTable;

/// Key of a table, or one value of it, that a scene may not have any more.
struct RemovedKey {
    table: &'static str,
    key: &'static str,
    /// Removed value; `None` if the key itself is removed.
    value: Option<&'static str>,
    /// Keys that take its place.
    remedy: &'static str,
}

const fn renamed(key: &'static str, remedy: &'static str) -> RemovedKey {
    RemovedKey { table: "remesh", key, value: None, remedy }
}

const REMOVED: [RemovedKey; 8] = [
    renamed("bend", "remesh.curvature_angle, its present name"),
    renamed("compression", "remesh.min_volume_ratio, its present name"),
    renamed("thinnest", "remesh.erosion_thickness, its present name"),
    renamed("tip", "remesh.tip_size, its present name"),
    RemovedKey {
        table: "gel",
        key: "material",
        value: Some("viscoelastic"),
        remedy: "\"two-network\", its present name",
    },
    RemovedKey {
        table: "gel",
        key: "material",
        value: Some("flowing"),
        remedy: "\"two-network\", with gel.shear_modulus, gel.damage = { critical_stretch, delay } and gel.branches = \
                 [{ shear_modulus, power_law = { stress, exponent } }]: gel.strength, its confined and gel.softening \
                 are gone",
    },
    RemovedKey {
        table: "gel",
        key: "strength",
        value: None,
        remedy: "nothing: the stress that depends on the rate is that of gel.branches = [{ shear_modulus, power_law = \
                 { stress, exponent } }], which gel.strength_scale scales with the moduli",
    },
    RemovedKey {
        table: "gel",
        key: "softening",
        value: None,
        remedy: "nothing: a \"two-network\" gel softens by gel.damage = { critical_stretch, delay }",
    },
];

impl RemovedKey {
    /// Returns the text of the removed key in a scene, if it has the key with the removed value.
    fn found_in(&self, scene: &DeTable<'_>) -> Option<String> {
        let value = scene.get(self.table)?.get_ref().as_table()?.get(self.key)?.get_ref();
        match self.value {
            Some(removed) => (value.as_str() == Some(removed)).then(|| format!("{removed:?}")),
            None => Some(if value.is_table() { "a table" } else { "a value" }.to_owned()),
        }
    }
}

/// Refuses keys and values that a scene may not have any more, with those that take their place.
///
/// # Errors
/// [`SceneError`] of the first one, without a line.
pub(super) fn refuse_removed_keys(scene: &DeTable<'_>) -> Result<(), SceneError> {
    let error = |removed: &RemovedKey| {
        let found = removed.found_in(scene)?;
        Some(SceneError::value(&format!("{}.{}", removed.table, removed.key), found, removed.remedy))
    };
    REMOVED.iter().find_map(error).map_or(Ok(()), Err)
}

#[cfg(test)]
mod tests {
    use super::super::{Override, builtin, read, resolve};

    #[test]
    fn a_former_name_is_refused_with_the_present_one_and_its_line() {
        let text = builtin("bullet-yaw").unwrap();
        for (former, present) in [
            ("bend", "curvature_angle"),
            ("compression", "min_volume_ratio"),
            ("thinnest", "erosion_thickness"),
            ("tip", "tip_size"),
        ] {
            let old = text.replace(&format!("\n{present} ="), &format!("\n{former} ="));
            let error = read(&old).unwrap_err();
            let line = 1 + old.lines().position(|line| line.starts_with(&format!("{former} ="))).unwrap();
            assert_eq!((error.key.as_str(), error.line), (&*format!("remesh.{former}"), Some(line)));
            assert!(error.to_string().contains(&format!("expected remesh.{present}, its present name")), "{error}");
        }
        let named: Override = "gel.material=viscoelastic".parse().unwrap();
        let error = read(&resolve(builtin("fbi-bb").unwrap(), &[named]).unwrap()).unwrap_err();
        assert!(error.to_string().contains("expected \"two-network\", its present name"), "{error}");
    }
}
