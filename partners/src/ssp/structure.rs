//! `SystemStructure.ssd`: which FMUs there are, and what is wired to what. Each FMU has the start values of the scene.

use crate::description::{Xml, document, empty, inside, scalar_name};
use std::collections::BTreeSet;
use std::io;

/// An FMU in the system.
#[derive(Debug)]
pub struct Unit {
    /// Name in the system.
    pub name: &'static str,
    /// Name of the FMU's file.
    pub file: &'static str,
    /// Outputs that are wired to nothing, but that an importer may want to show.
    pub watched: Vec<Port>,
}

/// A variable, its number of components, and its unit.
pub type Port = (&'static str, usize, &'static str);

/// So many scalars wired at once.
#[derive(Debug)]
pub struct Wire {
    /// Unit and variable that gives.
    pub from: (&'static str, &'static str),
    /// Unit and variable that takes.
    pub to: (&'static str, &'static str),
    /// Number of components.
    pub size: usize,
    /// Unit of the quantity.
    pub unit: &'static str,
}

const NAMESPACE: &str = "http://ssp-standard.org/SSP1/";

/// The system's description.
pub fn ssd(name: &str, units: &[Unit], wires: &[Wire]) -> io::Result<String> {
    let space = |which: &str| format!("{NAMESPACE}SystemStructure{which}");
    let attributes = [
        ("xmlns:ssc", space("Common")),
        ("xmlns:ssd", space("Description")),
        ("version", "1.0".to_owned()),
        ("name", name.to_owned()),
    ];
    document("ssd:SystemStructureDescription", &attributes, |xml| {
        xml.create_element("ssd:System")
            .with_attribute(("name", "system"))
            .write_inner_content(|xml| {
                inside(xml, "ssd:Elements", |xml| units.iter().try_for_each(|unit| component(xml, unit, wires)))?;
                inside(xml, "ssd:Connections", |xml| wires.iter().try_for_each(|wire| connections(xml, wire)))
            })
            .map(drop)
    })
}

fn component(xml: &mut Xml, unit: &Unit, wires: &[Wire]) -> io::Result<()> {
    let source = format!("resources/{}", unit.file);
    xml.create_element("ssd:Component")
        .with_attributes([("name", unit.name), ("type", "application/x-fmu-sharedlibrary"), ("source", &source)])
        .write_inner_content(|xml| {
            inside(xml, "ssd:Connectors", |xml| {
                ports(unit, wires).iter().try_for_each(|(port, kind)| connectors(xml, *port, kind))
            })
        })
        .map(drop)
}

/// What a unit takes and gives, each once.
fn ports(unit: &Unit, wires: &[Wire]) -> BTreeSet<(Port, &'static str)> {
    let taken =
        wires.iter().filter(|wire| wire.to.0 == unit.name).map(|wire| ((wire.to.1, wire.size, wire.unit), "input"));
    let given = wires.iter().filter(|wire| wire.from.0 == unit.name).map(|wire| (wire.from.1, wire.size, wire.unit));
    taken.chain(given.chain(unit.watched.iter().copied()).map(|port| (port, "output"))).collect()
}

fn connectors(xml: &mut Xml, (name, size, unit): Port, kind: &str) -> io::Result<()> {
    (0..size).try_for_each(|i| {
        let name = scalar_name(name, size, i);
        xml.create_element("ssd:Connector")
            .with_attributes([("name", name.as_str()), ("kind", kind)])
            .write_inner_content(|xml| empty(xml, "ssc:Real", &[("unit", unit)]))
            .map(drop)
    })
}

fn connections(xml: &mut Xml, wire: &Wire) -> io::Result<()> {
    (0..wire.size).try_for_each(|i| {
        let [from, to] = [wire.from, wire.to].map(|(_, name)| scalar_name(name, wire.size, i));
        let attributes = [
            ("startElement", wire.from.0),
            ("startConnector", &from),
            ("endElement", wire.to.0),
            ("endConnector", &to),
        ];
        empty(xml, "ssd:Connection", &attributes)
    })
}
