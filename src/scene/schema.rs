//! JSON schema of a scene file.

use super::{QuantityKind, Scene};
use serde_json::{Map, Value, json};

/// JSON schema of a scene file, with which editors complete and check scenes.
///
/// `x-quantity` of a key names its quantity; `x-quantities` has the value expected and all units of each.
///
/// # Examples
/// ```
/// let schema = ballistic_gel::scene::schema();
/// assert_eq!(schema["properties"]["mesh"]["$ref"], "#/$defs/MeshSpec");
/// ```
#[must_use]
pub fn schema() -> Value {
    let mut schema = schemars::schema_for!(Scene).to_value();
    // A preset may supply all other keys of a gel.
    schema["$defs"]["GelSpec"]["required"] = json!(["shape"]);
    // The library may supply the shape of a body.
    schema["$defs"]["ProjectileSpec"]["required"] = json!(["position"]);
    allow_units(&mut schema);
    let quantities = QuantityKind::ALL.map(|kind| (kind.name().to_owned(), describe(kind)));
    schema["x-quantities"] = Value::Object(quantities.into_iter().collect());
    schema
}

/// Describes a quantity for readers of the schema: the value expected, and all units of its texts.
fn describe(kind: QuantityKind) -> Value {
    json!({ "expected": kind.expected(), "units": kind.unit_names() })
}

/// Allows a text such as "124 gr" in all values that have a unit, and names their quantity, `x-quantity`.
fn allow_units(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            if let Some(Value::Object(properties)) = object.get_mut("properties") {
                for (key, property) in properties {
                    let (Some(kind), Some(property)) = (QuantityKind::of_key(key), property.as_object_mut()) else {
                        continue;
                    };
                    allow_text(property);
                    property.insert("x-quantity".to_owned(), json!(kind.name()));
                }
            }
            object.values_mut().for_each(allow_units);
        }
        Value::Array(values) => values.iter_mut().for_each(allow_units),
        _ => (),
    }
}

/// Allows a text instead of a number, or of the numbers of a list.
fn allow_text(property: &mut Map<String, Value>) {
    if let Some(Value::Object(items)) = property.get_mut("items") {
        allow_text(items);
    }
    let with_text = match property.get("type") {
        Some(Value::String(kind)) if kind == "number" => json!(["number", "string"]),
        Some(Value::Array(kinds)) if kinds.contains(&json!("number")) => {
            Value::Array(kinds.iter().cloned().chain([json!("string")]).collect())
        }
        _ => return,
    };
    property.insert("type".to_owned(), with_text);
}

#[cfg(test)]
mod tests {
    use super::{QuantityKind, schema};
    use serde_json::Value;

    /// Unit that a description names behind a comma.
    fn described_unit(description: &str) -> Option<QuantityKind> {
        let mut after_comma = description.split(", ").skip(1).map(|part| {
            let end = part.find([';', '.', ':', ',', '\n']).unwrap_or(part.len());
            part[..end].split(" (").next().unwrap_or_default().trim().to_owned()
        });
        after_comma.find_map(|unit| QuantityKind::ALL.into_iter().find(|kind| kind.unit() == unit))
    }

    fn properties<'a>(schema: &'a Value, into: &mut Vec<(&'a String, &'a Value)>) {
        match schema {
            Value::Object(object) => {
                if let Some(Value::Object(properties)) = object.get("properties") {
                    into.extend(properties.iter().filter(|(_, property)| property["type"] != "string"));
                }
                object.values().for_each(|value| properties(value, into));
            }
            Value::Array(values) => values.iter().for_each(|value| properties(value, into)),
            _ => (),
        }
    }

    #[test]
    fn every_description_has_the_unit_that_the_reader_of_units_takes() {
        let (schema, mut all) = (schema(), vec![]);
        properties(&schema, &mut all);
        // Figures of a measured level, and a list of rows, are no quantities to write.
        let is_written = |key: &str| !["cpu_seconds", "table"].contains(&key);
        let mut checked = 0;
        for (key, property) in all.into_iter().filter(|(key, _)| is_written(key)) {
            let description = property["description"].as_str().unwrap_or_default();
            let Some(described) = described_unit(description) else { continue };
            assert_eq!(QuantityKind::of_key(key), Some(described), "{key}: {description}");
            checked += 1;
        }
        assert!(checked > 50, "{checked} keys");
    }

    #[test]
    fn a_quantity_is_named_with_its_units() {
        let schema = schema();
        let size = &schema["$defs"]["MeshSpec"]["properties"]["size"];
        let length = &schema["x-quantities"][size["x-quantity"].as_str().unwrap()];
        let units: Vec<&str> = length["units"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        assert!(units.contains(&"mm") && !units.contains(&"kg"));
        assert!(length["expected"].as_str().unwrap().starts_with("a number in m"));
        assert!(schema["$defs"]["ContactSpec"]["properties"]["friction"].get("x-quantity").is_none());
    }

    #[test]
    fn a_value_with_a_unit_is_a_number_or_a_text() {
        let schema = schema();
        let numbers = ["number", "string"];
        assert_eq!(schema["$defs"]["MeshSpec"]["properties"]["size"]["type"], serde_json::json!(numbers));
        assert_eq!(schema["$defs"]["ProjectileSpec"]["properties"]["velocity"]["items"]["type"][1], "string");
        assert_eq!(schema["$defs"]["ContactSpec"]["properties"]["friction"]["type"], "number");
    }
}
