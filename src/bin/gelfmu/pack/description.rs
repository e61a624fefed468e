//! `modelDescription.xml`.

use super::PackedInterface;
use ballistic_gel::fmi2::{self, Causality, Kind, ScalarVariable, Start};
use ballistic_gel::scene::Scene;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;

/// Writer of an XML document.
pub type Xml = Writer<Vec<u8>>;

/// Author, as in CITATION.cff.
const AUTHOR: &str = "The ballistic-gel authors";
/// Characters of the description of an archive that importers show in full.
const LONGEST_DESCRIPTION: usize = 99;
/// Relative tolerance proposed to the solvers of other components; the FMU does not use it.
const TOLERANCE: &str = "1e-4";

/// Makes the model description of an FMU with this packed scene, this interface and this GUID. `tool` is the name and
/// version of the generator.
pub fn xml(scene: &Scene, interface: &PackedInterface, guid: &str, tool: &str) -> io::Result<String> {
    // Some importers refuse an independent variable, which is optional.
    let is_listed = |scalar: &ScalarVariable| scalar.variable.causality != Causality::Independent;
    let scalars: Vec<ScalarVariable> = interface.ports.scalars().filter(is_listed).collect();
    let table = fmi2::table_of(scene);
    let attributes = [
        ("fmiVersion", "2.0"),
        ("modelName", &printable(&format!("{} {}", fmi2::MODEL, scene.scene.name))),
        ("guid", guid),
        ("description", &about(scene)),
        ("author", AUTHOR),
        ("version", env!("CARGO_PKG_VERSION")),
        ("license", env!("CARGO_PKG_LICENSE")),
        ("generationTool", tool),
        ("variableNamingConvention", "structured"),
    ];
    document("fmiModelDescription", &attributes, |xml| {
        capabilities(xml)?;
        units(xml)?;
        categories(xml)?;
        experiment(xml, scene)?;
        variables(xml, &scalars, interface, &table)?;
        structure(xml, &scalars, interface)
    })
}

/// Writes a document of one root element.
pub fn document(
    root: &str,
    attributes: &[(&str, &str)],
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<String> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    xml.create_element(root).with_attributes(attributes.iter().copied()).write_inner_content(content)?;
    String::from_utf8(xml.into_inner()).map_err(io::Error::other)
}

/// Describes the packed scene: by its title, or by the component without one.
fn about(scene: &Scene) -> String {
    let title = Some(printable(&scene.scene.title)).filter(|title| !title.trim().is_empty());
    let text = title.unwrap_or_else(|| env!("CARGO_PKG_DESCRIPTION").to_owned());
    if text.chars().count() <= LONGEST_DESCRIPTION {
        return text;
    }
    text.chars().take(LONGEST_DESCRIPTION - 1).chain(['\u{2026}']).collect()
}

/// Replaces the characters that XML 1.0 does not have.
fn printable(text: &str) -> String {
    text.replace(|c: char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}'), " ")
}

fn capabilities(xml: &mut Xml) -> io::Result<()> {
    xml.create_element("CoSimulation")
        .with_attributes([
            ("modelIdentifier", fmi2::MODEL),
            ("needsExecutionTool", "false"),
            ("canHandleVariableCommunicationStepSize", "true"),
            ("canInterpolateInputs", "true"),
            ("maxOutputDerivativeOrder", "1"),
            ("canRunAsynchronuously", "false"),
            ("canBeInstantiatedOnlyOncePerProcess", "false"),
            ("canNotUseMemoryManagementFunctions", "true"),
            ("canGetAndSetFMUstate", "true"),
            ("canSerializeFMUstate", "true"),
            ("providesDirectionalDerivative", "true"),
        ])
        .write_empty()?;
    Ok(())
}

fn units(xml: &mut Xml) -> io::Result<()> {
    xml.create_element("UnitDefinitions").write_inner_content(|xml| {
        for unit in fmi2::UNITS {
            xml.create_element("Unit").with_attribute(("name", unit.name)).write_inner_content(|xml| {
                let exponents: Vec<(&str, String)> = unit.base.iter().map(|(b, e)| (*b, e.to_string())).collect();
                let exponents = exponents.iter().map(|(b, e)| (*b, e.as_str()));
                xml.create_element("BaseUnit").with_attributes(exponents).write_empty()?;
                let Some(display) = &unit.display else { return Ok(()) };
                let factor = number(display.factor);
                let attributes = [("name", display.name), ("factor", factor.as_str())];
                xml.create_element("DisplayUnit").with_attributes(attributes).write_empty().map(drop)
            })?;
        }
        Ok(())
    })?;
    Ok(())
}

fn categories(xml: &mut Xml) -> io::Result<()> {
    xml.create_element("LogCategories").write_inner_content(|xml| {
        for (name, description) in fmi2::CATEGORIES {
            let attributes = [("name", name), ("description", description)];
            xml.create_element("Category").with_attributes(attributes).write_empty()?;
        }
        Ok(())
    })?;
    Ok(())
}

fn experiment(xml: &mut Xml, scene: &Scene) -> io::Result<()> {
    let (stop, step) = (number(scene.scene.end_time), number(scene.scene.communication_step));
    let attributes =
        [("startTime", "0"), ("stopTime", stop.as_str()), ("tolerance", TOLERANCE), ("stepSize", step.as_str())];
    xml.create_element("DefaultExperiment").with_attributes(attributes).write_empty()?;
    Ok(())
}

fn variables(
    xml: &mut Xml,
    scalars: &[ScalarVariable],
    interface: &PackedInterface,
    scene: &toml::Table,
) -> io::Result<()> {
    let each =
        |xml: &mut Xml| scalars.iter().try_for_each(|scalar| variable(xml, scalar, interface.causality(scalar), scene));
    xml.create_element("ModelVariables").write_inner_content(each)?;
    Ok(())
}

fn variable(xml: &mut Xml, scalar: &ScalarVariable, causality: Causality, scene: &toml::Table) -> io::Result<()> {
    let of = scalar.variable;
    let (name, description, reference) = (scalar.name(), scalar.description(), scalar.reference().to_string());
    let VariableRole { causality, initial } = role_of(causality);
    let mut attributes = vec![
        ("name", name.as_str()),
        ("valueReference", &reference),
        ("description", &description),
        ("causality", causality),
        ("variability", of.variability),
    ];
    attributes.extend(initial.map(|initial| ("initial", initial)));
    xml.create_element("ScalarVariable")
        .with_attributes(attributes)
        .write_inner_content(|xml| kind(xml, scalar, scene))?;
    Ok(())
}

fn kind(xml: &mut Xml, scalar: &ScalarVariable, scene: &toml::Table) -> io::Result<()> {
    let of = scalar.variable;
    let element = match of.kind {
        Kind::Real => "Real",
        // Some importers have no type Enumeration: they would leave out its variables, or could not set them.
        Kind::Integer | Kind::Enumeration => "Integer",
        Kind::Boolean => "Boolean",
        Kind::String => "String",
    };
    let bound = |value: f64| if of.kind == Kind::Real { number(value) } else { format!("{value:.0}") };
    let mut attributes: Vec<(&str, String)> = Vec::new();
    let unit = of.unit_of();
    attributes.extend(unit.map(|unit| ("unit", unit.name.to_owned())));
    attributes.extend(unit.and_then(|unit| Some(("displayUnit", unit.display.as_ref()?.name.to_owned()))));
    attributes.extend(of.min.map(|value| ("min", bound(value))));
    attributes.extend(of.max.map(|value| ("max", bound(value))));
    attributes.extend(unit.map(|unit| ("nominal", number(unit.nominal))));
    attributes.extend(start(scalar, scene).map(|start| ("start", start)));
    let attributes = attributes.iter().map(|(key, value)| (*key, value.as_str()));
    xml.create_element(element).with_attributes(attributes).write_empty()?;
    Ok(())
}

fn start(scalar: &ScalarVariable, scene: &toml::Table) -> Option<String> {
    let value = scalar.start(scene);
    match scalar.variable.kind {
        Kind::Real => value.map(number),
        Kind::Integer | Kind::Enumeration => value.map(|value| format!("{value:.0}")),
        Kind::Boolean => value.map(|value| (value != 0.0).to_string()),
        Kind::String => match scalar.variable.start {
            Some(Start::Text(text)) => Some(text.to_owned()),
            _ => None,
        },
    }
}

/// Writes the dependencies. Within a step only the carrier of the directional derivative depends on inputs; initial
/// values depend on the parameters alone.
fn structure(xml: &mut Xml, scalars: &[ScalarVariable], interface: &PackedInterface) -> io::Result<()> {
    let moves =
        |s: &ScalarVariable| matches!(s.variable.name, "projectile.position" | "projectile.velocity") && is_input(s);
    let fed = |of: &ScalarVariable| match of.variable.name {
        "contact.linear_force" => indices(scalars, |s| s.body == of.body && moves(s)),
        _ => String::new(),
    };
    let parameters = indices(scalars, shapes_the_start);
    let is = |causality| move |scalar: &ScalarVariable| interface.causality(scalar) == causality;
    xml.create_element("ModelStructure").write_inner_content(|xml| {
        xml.create_element("Outputs")
            .write_inner_content(|xml| unknowns(xml, scalars, is(Causality::Output), fed))?
            .create_element("InitialUnknowns")
            .write_inner_content(|xml| {
                let first = |scalar: &_| is(Causality::Output)(scalar) || is(Causality::CalculatedParameter)(scalar);
                unknowns(xml, scalars, first, |_| parameters.clone())
            })
            .map(drop)
    })?;
    Ok(())
}

/// Returns true if the initial state depends on a variable: the scene or one of its overrides.
fn shapes_the_start(scalar: &ScalarVariable) -> bool {
    let runs_it = matches!(scalar.variable.name, "threads" | "output_directory");
    scalar.variable.causality == Causality::Parameter && !runs_it
}

fn unknowns(
    xml: &mut Xml,
    scalars: &[ScalarVariable],
    wanted: impl Fn(&ScalarVariable) -> bool,
    dependencies: impl Fn(&ScalarVariable) -> String,
) -> io::Result<()> {
    for (index, scalar) in scalars.iter().enumerate().filter(|(_, s)| wanted(s)) {
        let (index, dependencies) = ((index + 1).to_string(), dependencies(scalar));
        let attributes = [("index", index.as_str()), ("dependencies", &dependencies)];
        xml.create_element("Unknown").with_attributes(attributes).write_empty()?;
    }
    Ok(())
}

fn indices(scalars: &[ScalarVariable], wanted: impl Fn(&ScalarVariable) -> bool) -> String {
    let found = scalars.iter().enumerate().filter(|(_, s)| wanted(s)).map(|(index, _)| (index + 1).to_string());
    found.collect::<Vec<String>>().join(" ")
}

fn is_input(scalar: &ScalarVariable) -> bool {
    scalar.variable.causality == Causality::Input
}

/// Causality and kind of initial value of a variable, in the words of the standard.
struct VariableRole {
    causality: &'static str,
    initial: Option<&'static str>,
}

fn role_of(causality: Causality) -> VariableRole {
    let (causality, initial) = match causality {
        Causality::Independent => ("independent", None),
        Causality::Parameter => ("parameter", Some("exact")),
        Causality::CalculatedParameter => ("calculatedParameter", Some("calculated")),
        Causality::Input => ("input", None),
        Causality::Output => ("output", Some("calculated")),
        Causality::Local => ("local", Some("calculated")),
    };
    VariableRole { causality, initial }
}

/// Formats a number in the shortest text that reads back as the same number.
fn number(value: f64) -> String {
    format!("{value:?}")
}
