//! `modelDescription.xml` of a partner, from its table.

use crate::table::{Causality, Model, Variable};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;

/// What is written into.
pub type Xml = Writer<Vec<u8>>;

/// A unit and its exponents of kg, m, s and rad.
const UNITS: [(&str, [i32; 4]); 15] = [
    ("1", [0, 0, 0, 0]),
    ("kg", [1, 0, 0, 0]),
    ("kg/m2", [1, -2, 0, 0]),
    ("kg.m2", [1, 2, 0, 0]),
    ("m", [0, 1, 0, 0]),
    ("m/s", [0, 1, -1, 0]),
    ("rad/s", [0, 0, -1, 1]),
    ("N", [1, 1, -2, 0]),
    ("N.m", [1, 2, -2, 0]),
    ("N.s", [1, 1, -1, 0]),
    ("N.m.s", [1, 2, -1, 0]),
    ("N.s2", [1, 1, 0, 0]),
    ("N/m", [1, 0, -2, 0]),
    ("J", [1, 2, -2, 0]),
    ("s", [0, 0, 1, 0]),
];

/// The description of a partner with these start values.
pub fn xml(model: &Model, starts: &[f64]) -> io::Result<String> {
    document("fmiModelDescription", &attributes(model, starts), |xml| {
        capabilities(xml, model)?;
        units(xml)?;
        let category = [("name", "error"), ("description", "what went wrong")];
        inside(xml, "LogCategories", |xml| empty(xml, "Category", &category))?;
        empty(xml, "DefaultExperiment", &[("startTime", "0"), ("stopTime", "0.01"), ("stepSize", "1e-5")])?;
        inside(xml, "ModelVariables", |xml| {
            model.scalars().enumerate().try_for_each(|(reference, (of, at))| {
                let name = scalar_name(of.name, of.start.len(), at);
                variable(xml, (reference, &name), of, starts[reference])
            })
        })?;
        structure(xml, model)
    })
}

/// A document with one root.
pub fn document(
    root: &str,
    attributes: &[(&str, String)],
    body: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<String> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let attributes = attributes.iter().map(|(key, value)| (*key, value.as_str()));
    xml.create_element(root).with_attributes(attributes).write_inner_content(body)?;
    String::from_utf8(xml.into_inner()).map_err(io::Error::other)
}

/// An element without attributes around others.
pub fn inside(xml: &mut Xml, name: &str, body: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<()> {
    xml.create_element(name).write_inner_content(body).map(drop)
}

/// An element without content.
pub fn empty(xml: &mut Xml, name: &str, attributes: &[(&str, &str)]) -> io::Result<()> {
    xml.create_element(name).with_attributes(attributes.iter().copied()).write_empty().map(drop)
}

/// Name of a component, as FMI writes it.
pub fn scalar_name(name: &str, size: usize, at: usize) -> String {
    if size == 1 { name.to_owned() } else { format!("{name}[{}]", at + 1) }
}

fn attributes(model: &Model, starts: &[f64]) -> Vec<(&'static str, String)> {
    vec![
        ("fmiVersion", "2.0".to_owned()),
        ("modelName", model.name.to_owned()),
        ("guid", model.guid(starts)),
        ("description", model.description.to_owned()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("license", env!("CARGO_PKG_LICENSE").to_owned()),
        ("generationTool", concat!("ballistic-gel ", env!("CARGO_PKG_VERSION"), ", partners/ssp").to_owned()),
        ("variableNamingConvention", "structured".to_owned()),
    ]
}

fn capabilities(xml: &mut Xml, model: &Model) -> io::Result<()> {
    let attributes = [
        ("modelIdentifier", model.name),
        ("canHandleVariableCommunicationStepSize", "true"),
        ("canNotUseMemoryManagementFunctions", "true"),
        ("canGetAndSetFMUstate", "true"),
        ("canSerializeFMUstate", "true"),
    ];
    empty(xml, "CoSimulation", &attributes)
}

fn units(xml: &mut Xml) -> io::Result<()> {
    inside(xml, "UnitDefinitions", |xml| {
        UNITS.iter().try_for_each(|(name, exponents)| {
            let exponents = ["kg", "m", "s", "rad"].into_iter().zip(exponents).filter(|(_, exponent)| **exponent != 0);
            let exponents: Vec<(&str, String)> =
                exponents.map(|(base, exponent)| (base, exponent.to_string())).collect();
            let exponents: Vec<(&str, &str)> = exponents.iter().map(|(base, text)| (*base, text.as_str())).collect();
            xml.create_element("Unit")
                .with_attribute(("name", *name))
                .write_inner_content(|xml| empty(xml, "BaseUnit", &exponents))
                .map(drop)
        })
    })
}

fn variable(xml: &mut Xml, (reference, name): (usize, &str), of: &Variable, start: f64) -> io::Result<()> {
    let reference = reference.to_string();
    let (causality, variability, initial) = match of.causality {
        Causality::Parameter => ("parameter", "fixed", Some("exact")),
        Causality::Input => ("input", "continuous", None),
        Causality::Output => ("output", "discrete", Some("calculated")),
        Causality::Local => ("local", "discrete", Some("calculated")),
    };
    let mut attributes = vec![
        ("name", name),
        ("valueReference", &reference),
        ("description", of.description),
        ("causality", causality),
        ("variability", variability),
    ];
    attributes.extend(initial.map(|initial| ("initial", initial)));
    let start = format!("{start:?}");
    let mut real = vec![("unit", of.unit)];
    real.extend(matches!(of.causality, Causality::Parameter | Causality::Input).then_some(("start", start.as_str())));
    xml.create_element("ScalarVariable")
        .with_attributes(attributes)
        .write_inner_content(|xml| empty(xml, "Real", &real))
        .map(drop)
}

/// Nothing feeds through within a step; what is there at first comes from the parameters.
fn structure(xml: &mut Xml, model: &Model) -> io::Result<()> {
    let of = |wanted| {
        let found = model.scalars().enumerate().filter(move |(_, (variable, _))| variable.causality == wanted);
        found.map(|(index, _)| (index + 1).to_string()).collect::<Vec<String>>()
    };
    let parameters = of(Causality::Parameter).join(" ");
    let unknowns = |xml: &mut Xml, dependencies: &str| {
        let each = |index: &String| empty(xml, "Unknown", &[("index", index), ("dependencies", dependencies)]);
        of(Causality::Output).iter().try_for_each(each)
    };
    inside(xml, "ModelStructure", |xml| {
        inside(xml, "Outputs", |xml| unknowns(xml, ""))?;
        inside(xml, "InitialUnknowns", |xml| unknowns(xml, &parameters))
    })
}
