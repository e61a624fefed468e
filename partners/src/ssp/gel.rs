//! The command of the gel, `gelfmu`: bodies of a scene, and the FMUs that it packs.

use crate::run;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use serde_json::Value;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;
use zip::ZipArchive;

/// Path of the command.
pub struct GelCommand(pub PathBuf);

/// Options of a packed gel.
#[derive(Debug)]
pub struct GelOptions {
    /// Built-in name or path of the scene.
    pub scene: String,
    /// Coupling mode.
    pub mode: &'static str,
    /// Set of outputs.
    pub outputs: &'static str,
}

/// Inputs, outputs and default experiment of a packed gel.
#[derive(Debug, Default)]
pub struct GelPorts {
    /// End of the run, s, as the description writes it.
    pub stop_time: String,
    /// Communication step, s, as the description writes it.
    pub step: String,
    /// Scalars that the gel takes.
    pub inputs: BTreeSet<String>,
    /// Scalars that the gel offers.
    pub outputs: BTreeSet<String>,
}

impl GelCommand {
    /// Returns the bodies of a scene, the projectile first, as `gelfmu check --json` describes them.
    pub fn bodies(&self, scene: &str) -> Result<Vec<Value>, String> {
        let output = self.command().args(["check", scene, "--json"]).output();
        let output = output.map_err(|error| {
            format!(
                "{}: {error}; cargo build --release makes it, and --gelfmu FILE names another one",
                self.0.display()
            )
        })?;
        if !output.status.success() {
            return Err(format!("scene {scene}: {}", String::from_utf8_lossy(&output.stderr).trim()));
        }
        let checked: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        let bodies = checked["bodies"].as_array().filter(|bodies| !bodies.is_empty()).cloned();
        bodies.ok_or_else(|| {
            format!("{}: its check --json describes no bodies: a gelfmu of other sources", self.0.display())
        })
    }

    /// Packs the gel into a file, and returns the ports that it has.
    pub fn pack(&self, options: &GelOptions, file: &Path) -> Result<GelPorts, String> {
        let GelOptions { scene, mode, outputs } = options;
        let set = format!("coupling.mode={mode}");
        let mut command = self.command();
        command.args(["pack", "--scene", scene, "--set", &set, "--outputs", outputs, "--out"]).arg(file);
        run(&mut command)?;
        GelPorts::of(file).map_err(|error| format!("{}: {error}", file.display()))
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.0);
        command.arg("--quiet");
        command
    }
}

impl GelPorts {
    /// Reads the ports in the description of an FMU.
    fn of(file: &Path) -> Result<Self, String> {
        let file = File::open(file).map_err(|error| error.to_string())?;
        let mut archive = ZipArchive::new(file).map_err(|error| error.to_string())?;
        let mut entry = archive.by_name("modelDescription.xml").map_err(|error| error.to_string())?;
        let mut text = String::new();
        entry.read_to_string(&mut text).map_err(|error| error.to_string())?;
        Self::read(&text)
    }

    /// Reads the ports in the text of a description.
    fn read(text: &str) -> Result<Self, String> {
        let mut ports = Self::default();
        let mut reader = Reader::from_str(text);
        loop {
            let element = match reader.read_event().map_err(|error| error.to_string())? {
                Event::Eof => return Ok(ports),
                Event::Start(element) | Event::Empty(element) => element,
                _ => continue,
            };
            match element.name().as_ref() {
                "DefaultExperiment" => {
                    ports.stop_time = attribute(&element, "stopTime")?;
                    ports.step = attribute(&element, "stepSize")?;
                }
                "ScalarVariable" => ports.insert(&element)?,
                _ => {}
            }
        }
    }

    /// Inserts the name of an input or output.
    fn insert(&mut self, variable: &BytesStart) -> Result<(), String> {
        match attribute(variable, "causality").as_deref() {
            Ok("input") => self.inputs.insert(attribute(variable, "name")?),
            Ok("output") => self.outputs.insert(attribute(variable, "name")?),
            _ => return Ok(()),
        };
        Ok(())
    }
}

/// Returns the value of an attribute of an element.
fn attribute(element: &BytesStart, name: &str) -> Result<String, String> {
    let found = element.try_get_attribute(name).map_err(|error| error.to_string())?;
    let found = found.ok_or_else(|| format!("a {} has no {name}", element.name().as_ref()))?;
    found.normalized_value(XmlVersion::Explicit1_0).map(Cow::into_owned).map_err(|error| error.to_string())
}
