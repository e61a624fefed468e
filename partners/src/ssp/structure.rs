//! `SystemStructure.ssd`: the FMUs of a system, and the wires between them. Each FMU has the start values of the scene.

use crate::description::{Xml, document, empty, inside, scalar_name};
use crate::gel::GelPorts;
use std::collections::BTreeSet;
use std::io;

/// An FMU in the system.
#[derive(Debug, Clone)]
pub struct Unit {
    /// Name in the system.
    pub name: String,
    /// Name of the FMU's file.
    pub file: String,
    /// Outputs that are wired to nothing, but that an importer may want to show.
    pub watched: Vec<Port>,
}

/// A variable, its number of components, and its unit.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Port {
    /// Name without index.
    pub name: String,
    /// Number of components.
    pub size: usize,
    /// Unit of the quantity.
    pub unit: &'static str,
}

/// A unit and one of its variables.
#[derive(Debug, Clone)]
pub struct End {
    /// Name of the unit.
    pub unit: String,
    /// Name of the variable, without index.
    pub variable: String,
}

/// Some scalars wired at once.
#[derive(Debug, Clone)]
pub struct Wire {
    /// Output.
    pub from: End,
    /// Input.
    pub to: End,
    /// Number of components.
    pub size: usize,
    /// Unit of the quantity.
    pub unit: &'static str,
}

/// One scalar wired to another.
#[derive(Debug)]
struct Connection {
    from: End,
    to: End,
    unit: &'static str,
}

/// Direction of a connector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum ConnectorKind {
    Input,
    Output,
}

/// A scalar variable of a unit that the system shows.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Connector {
    name: String,
    kind: ConnectorKind,
    unit: &'static str,
}

/// Name of the unit of the gel in every system.
pub const GEL: &str = "gel";

const NAMESPACE: &str = "http://ssp-standard.org/SSP1/";
/// Namespace of the annotations of OMSimulator.
const OMSIMULATOR: &str = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";

/// Returns the description of a system. Inputs that the gel's scene cannot use stay unwired. The name of the system in
/// it is an identifier, which some importers demand: with underscores for hyphens.
pub fn ssd(name: &str, units: &[Unit], wires: &[Wire], gel: &GelPorts) -> io::Result<String> {
    let space = |which: &str| format!("{NAMESPACE}SystemStructure{which}");
    let attributes = [
        ("xmlns:ssc", space("Common")),
        ("xmlns:ssd", space("Description")),
        ("xmlns:oms", OMSIMULATOR.to_owned()),
        ("version", "1.0".to_owned()),
        ("name", name.replace('-', "_")),
    ];
    let connections = connections(wires, gel);
    let components: Vec<BTreeSet<Connector>> = units.iter().map(|unit| connectors(unit, &connections)).collect();
    check_outputs(units, &components, gel)?;
    document("ssd:SystemStructureDescription", &attributes, |xml| {
        xml.create_element("ssd:System").with_attribute(("name", "system")).write_inner_content(|xml| {
            inside(xml, "ssd:Elements", |xml| {
                units.iter().zip(&components).try_for_each(|(unit, connectors)| component(xml, unit, connectors))
            })?;
            inside(xml, "ssd:Connections", |xml| connections.iter().try_for_each(|each| connection(xml, each)))?;
            fixed_step(xml, &gel.step)
        })?;
        let times = [("startTime", "0"), ("stopTime", gel.stop_time.as_str())];
        empty(xml, "ssd:DefaultExperiment", &times)
    })
}

/// Writes the annotation without which OMSimulator runs no system: master algorithm and communication step, s.
fn fixed_step(xml: &mut Xml, step: &str) -> io::Result<()> {
    let master = [("description", "oms-ma"), ("stepSize", step), ("relativeTolerance", "1e-4")];
    inside(xml, "ssd:Annotations", |xml| {
        xml.create_element("ssc:Annotation")
            .with_attribute(("type", "org.openmodelica"))
            .write_inner_content(|xml| {
                inside(xml, "oms:Annotations", |xml| {
                    inside(xml, "oms:SimulationInformation", |xml| empty(xml, "oms:FixedStepMaster", &master))
                })
            })
            .map(drop)
    })
}

/// Returns the scalars of all wires, without those that end at an input of the gel which its scene does not have.
fn connections(wires: &[Wire], gel: &GelPorts) -> Vec<Connection> {
    let scalars = |wire: &Wire| {
        let Wire { from, to, size, unit } = wire.clone();
        let scalar =
            move |end: &End, at| End { unit: end.unit.clone(), variable: scalar_name(&end.variable, size, at) };
        (0..size).map(move |at| Connection { from: scalar(&from, at), to: scalar(&to, at), unit })
    };
    let is_there = |each: &Connection| each.to.unit != GEL || gel.inputs.contains(&each.to.variable);
    wires.iter().flat_map(scalars).filter(is_there).collect()
}

/// Returns the inputs and outputs of a unit that are wired or watched, each once.
fn connectors(unit: &Unit, connections: &[Connection]) -> BTreeSet<Connector> {
    let mut all = BTreeSet::new();
    for Connection { from, to, unit: quantity } in connections {
        for (end, kind) in [(to, ConnectorKind::Input), (from, ConnectorKind::Output)] {
            if end.unit == unit.name {
                all.insert(Connector { name: end.variable.clone(), kind, unit: quantity });
            }
        }
    }
    for Port { name, size, unit } in &unit.watched {
        let names = (0..*size).map(|at| scalar_name(name, *size, at));
        all.extend(names.map(|name| Connector { name, kind: ConnectorKind::Output, unit }));
    }
    all
}

/// Checks that the gel offers every output that the system takes from it.
fn check_outputs(units: &[Unit], components: &[BTreeSet<Connector>], gel: &GelPorts) -> io::Result<()> {
    let of_gel = units.iter().zip(components).filter(|(unit, _)| unit.name == GEL).flat_map(|(_, own)| own);
    let missing = of_gel.filter(|own| own.kind == ConnectorKind::Output && !gel.outputs.contains(&own.name));
    missing.map(|own| &own.name).next().map_or(Ok(()), |name| {
        Err(io::Error::other(format!("{name}: no output of the packed gel; it belongs to another set of outputs")))
    })
}

fn component(xml: &mut Xml, unit: &Unit, connectors: &BTreeSet<Connector>) -> io::Result<()> {
    let source = format!("resources/{}", unit.file);
    xml.create_element("ssd:Component")
        .with_attributes([
            ("name", unit.name.as_str()),
            ("type", "application/x-fmu-sharedlibrary"),
            ("source", &source),
        ])
        .write_inner_content(|xml| {
            inside(xml, "ssd:Connectors", |xml| connectors.iter().try_for_each(|each| connector(xml, each)))
        })
        .map(drop)
}

fn connector(xml: &mut Xml, connector: &Connector) -> io::Result<()> {
    let kind = match connector.kind {
        ConnectorKind::Input => "input",
        ConnectorKind::Output => "output",
    };
    xml.create_element("ssd:Connector")
        .with_attributes([("name", connector.name.as_str()), ("kind", kind)])
        .write_inner_content(|xml| empty(xml, "ssc:Real", &[("unit", connector.unit)]))
        .map(drop)
}

fn connection(xml: &mut Xml, connection: &Connection) -> io::Result<()> {
    let Connection { from, to, .. } = connection;
    let attributes = [
        ("startElement", from.unit.as_str()),
        ("startConnector", &from.variable),
        ("endElement", &to.unit),
        ("endConnector", &to.variable),
    ];
    empty(xml, "ssd:Connection", &attributes)
}
