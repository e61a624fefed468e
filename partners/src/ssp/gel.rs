//! The command of the gel, `gelfmu`: what it says of a scene, and the FMUs that it packs.

use crate::run;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Path of the command.
pub struct GelCommand(pub PathBuf);

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

    /// Packs the gel with a scene and a coupling mode into a file.
    pub fn pack(&self, scene: &str, mode: &str, file: &Path) -> Result<(), String> {
        let set = format!("coupling.mode={mode}");
        run(self.command().args(["pack", "--scene", scene, "--set", &set, "--out"]).arg(file))
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.0);
        command.arg("--quiet");
        command
    }
}
