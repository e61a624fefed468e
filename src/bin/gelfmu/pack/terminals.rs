//! `terminalsAndIcons/`: the ports of each body and sensor as one terminal, and the icon (FMI 2.0.4, as FMI 3.0 defines them).

use super::PackedInterface;
use super::description::{Xml, document};
use ballistic_gel::fmi2::{Causality, ScalarVariable};
use std::collections::BTreeMap;
use std::io;

/// Path of the file in the archive.
pub const FILE: &str = "terminalsAndIcons/terminalsAndIcons.xml";
/// Path of the icon in the archive.
pub const ICON: &str = "terminalsAndIcons/icon.png";

/// Makes the file of an interface: a partner with members of the same names can be connected to a terminal at once.
pub fn xml(interface: &PackedInterface) -> io::Result<String> {
    let is_port = |scalar: &ScalarVariable| {
        let belongs = scalar.variable.each || scalar.variable.is_of_sensors();
        belongs && matches!(interface.causality(scalar), Causality::Input | Causality::Output)
    };
    let mut terminals: BTreeMap<TerminalKey, Vec<ScalarVariable>> = BTreeMap::new();
    for scalar in interface.ports.scalars().filter(is_port) {
        let key = TerminalKey { is_sensor: scalar.variable.is_of_sensors(), number: scalar.body };
        terminals.entry(key).or_default().push(scalar);
    }
    document("fmiTerminalsAndIcons", &[("fmiVersion", "3.0")], |xml| {
        xml.create_element("GraphicalRepresentation").write_inner_content(icon)?;
        xml.create_element("Terminals")
            .write_inner_content(|xml| terminals.iter().try_for_each(|(key, scalars)| terminal(xml, *key, scalars)))?;
        Ok(())
    })
}

/// Body or sensor of a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct TerminalKey {
    is_sensor: bool,
    /// Number of the body, or of the sensor from 0.
    number: usize,
}

impl TerminalKey {
    fn name(self) -> String {
        match (self.is_sensor, self.number) {
            (true, sensor) => format!("sensor[{}]", sensor + 1),
            (false, 0) => "projectile".to_owned(),
            (false, body) => format!("fragment[{body}]"),
        }
    }

    fn kind(self) -> &'static str {
        if self.is_sensor { "org.ballistic-gel.sensor" } else { "org.ballistic-gel.body" }
    }
}

fn icon(xml: &mut Xml) -> io::Result<()> {
    let corners = [("x1", "-100"), ("y1", "-100"), ("x2", "100"), ("y2", "100")];
    let system = corners.into_iter().chain([("suggestedScalingFactorTo_mm", "0.1")]);
    xml.create_element("CoordinateSystem").with_attributes(system).write_empty()?;
    xml.create_element("Icon").with_attributes(corners).write_empty().map(drop)
}

fn terminal(xml: &mut Xml, key: TerminalKey, scalars: &[ScalarVariable]) -> io::Result<()> {
    let name = key.name();
    let attributes = [("name", name.as_str()), ("matchingRule", "bus"), ("terminalKind", key.kind())];
    xml.create_element("Terminal")
        .with_attributes(attributes)
        .write_inner_content(|xml| scalars.iter().try_for_each(|scalar| member(xml, scalar)))?;
    Ok(())
}

/// Writes a member under its name without the body.
fn member(xml: &mut Xml, scalar: &ScalarVariable) -> io::Result<()> {
    let (name, member) = (scalar.name(), scalar.member_name());
    let attributes = [("variableName", name.as_str()), ("variableKind", "signal"), ("memberName", &member)];
    xml.create_element("TerminalMemberVariable").with_attributes(attributes).write_empty().map(drop)
}
