//! Fills the keys that the text does not set: those of a preset, derived moduli, and bodies of the library.

use super::named_body::NamedBody;
use super::preset::{Preset, PresetValue};
use super::{ConstantsSpec, LibraryValue, TermSpec};
use crate::constitutive::{MooneyRivlin, Ogden, OgdenTerm};
use serde::Deserialize;
use serde::de::IntoDeserializer;
use std::borrow::Cow;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Values that the preset of a scene fills in; empty without a preset.
#[must_use]
pub fn from_preset(text: &str) -> Vec<&'static PresetValue> {
    let Ok(parsed) = DeTable::parse(text) else { return vec![] };
    fill_gel(&mut parsed.into_inner(), None)
}

/// Writes the values of the preset and `shear_modulus` into keys of a gel that the text does not set. Returns the
/// preset's values used.
///
/// Each written value takes the source location of the preset's name, so that an error refers to that name.
pub(super) fn fill_gel<'a>(scene: &mut DeTable<'a>, shear_modulus: Option<&'a str>) -> Vec<&'static PresetValue> {
    let Some(gel) = as_table(scene.get_mut("gel")) else { return vec![] };
    if let Some(modulus) = shear_modulus {
        insert_at_path(gel, &["shear_modulus"], modulus, 0..0);
    }
    let Some((preset, place)) = named_preset(gel) else { return vec![] };
    let mut given = vec![];
    for fact in preset.facts() {
        let model = gel.get("material").and_then(|model| model.get_ref().as_str()).unwrap_or_default();
        let path: Vec<&'static str> = fact.key.split('.').skip(1).collect();
        if fact.of.includes(model) && insert_at_path(gel, &path, fact.value, place.clone()) {
            given.push(fact);
        }
    }
    given
}

/// Values that the preset of a layer fills in: key of the layer, key of the preset, and the value of a preset that
/// leaves it out.
const LAYER_VALUES: [(&str, &str, Option<&str>); 3] = [
    ("density", "gel.density", None),
    ("bulk_modulus", "gel.bulk_modulus", None),
    ("strength_scale", "gel.strength_scale", Some("1.0")),
];

/// Writes the values of their presets into keys of layers that the text does not set, each with the source location of
/// the preset's name.
pub(super) fn fill_layers(scene: &mut DeTable<'_>) {
    let Some(DeValue::Array(layers)) = scene.get_mut("layer").map(Spanned::get_mut) else { return };
    for layer in layers.iter_mut() {
        let Some(layer) = as_table(Some(layer)) else { continue };
        let Some((preset, place)) = named_preset(layer) else { continue };
        for (key, of_preset, otherwise) in LAYER_VALUES {
            if let Some(value) = preset.network_value(of_preset).or(otherwise) {
                insert_at_path(layer, &[key], value, place.clone());
            }
        }
    }
}

/// Preset that a table names, with the source location of its name.
fn named_preset(table: &DeTable<'_>) -> Option<(Preset, Range<usize>)> {
    let name = table.get("preset")?;
    Some((Preset::named(name.get_ref().as_str()?)?, name.span()))
}

/// Writes values of the library into bodies that name it, each with the source location of the name.
pub(super) fn fill_named<'a>(scene: &mut DeTable<'a>, named: &NamedBody, values: &'a [LibraryValue]) {
    let table = match named.body {
        0 => scene.get_mut("projectile"),
        number => match scene.get_mut("fragment").map(Spanned::get_mut) {
            Some(DeValue::Array(fragments)) => fragments.get_mut(number - 1),
            _ => None,
        },
    };
    let Some(body) = as_table(table) else { return };
    for LibraryValue { key, value, .. } in values {
        let path: Vec<&str> = key.split('.').collect();
        insert_at_path(body, &path, value, named.place.clone());
    }
}

/// Shear modulus that follows from the constants of a gel, as text; `None` if the scene sets it.
pub(super) fn shear_modulus(scene: &DeTable<'_>) -> Option<String> {
    let gel = scene.get("gel")?.get_ref().as_table()?;
    if gel.get("shear_modulus").is_some() {
        return None;
    }
    let modulus = match gel.get("material")?.get_ref().as_str()? {
        "mooney-rivlin" => {
            value_of(gel, "constants").map(|ConstantsSpec { c1, c2 }| MooneyRivlin::shear_modulus_of([c1, c2]))
        }
        "ogden" => value_of(gel, "terms").map(|terms: Vec<TermSpec>| {
            Ogden::shear_modulus_of(&terms.iter().map(OgdenTerm::from).collect::<Vec<_>>())
        }),
        _ => return None,
    };
    // Invalid constants are reported as such, not as an invalid modulus.
    Some(modulus.filter(|modulus| !modulus.is_nan()).map_or_else(|| "nan".to_owned(), |modulus| format!("{modulus:?}")))
}

fn value_of<T: for<'de> Deserialize<'de>>(table: &DeTable<'_>, key: &str) -> Option<T> {
    T::deserialize(table.get(key)?.clone().into_deserializer()).ok()
}

/// Writes a value at a path below a table, unless the table has one; returns true if the value was written.
fn insert_at_path<'a>(table: &mut DeTable<'a>, path: &[&'a str], value: &'a str, place: Range<usize>) -> bool {
    let (first, rest) = path.split_first().expect("a key has a name");
    let name = || Spanned::new(place.clone(), Cow::Borrowed(*first));
    if rest.is_empty() {
        let is_free = table.get(*first).is_none();
        if is_free {
            let value = DeValue::parse(value).expect("values of presets and the library are TOML").into_inner();
            table.insert(name(), Spanned::new(place, value));
        }
        return is_free;
    }
    if table.get(*first).is_none() {
        table.insert(name(), Spanned::new(place.clone(), DeValue::Table(DeTable::new())));
    }
    as_table(table.get_mut(*first)).is_some_and(|below| insert_at_path(below, rest, value, place))
}

fn as_table<'t, 'a>(value: Option<&'t mut Spanned<DeValue<'a>>>) -> Option<&'t mut DeTable<'a>> {
    match value?.get_mut() {
        DeValue::Table(table) => Some(table),
        _ => None,
    }
}
