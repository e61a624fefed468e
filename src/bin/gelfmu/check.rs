//! `gelfmu check`: is the scene good, and what does it model?

use crate::console::Console;
use crate::failure::Failure;
use crate::{level, source};
use ballistic_gel::scene;
use serde_json::json;

pub fn check(name: &str, console: &Console) -> Result<(), Failure> {
    let scene = source::load(name, &[])?.scene;
    let (modelled, off) = (scene::modelled(&scene), scene::switched_off(&scene));
    let value = json!({
        "scene": scene.scene.name,
        "title": scene.scene.title,
        "valid": true,
        "modelled": modelled,
        "switched_off": off,
        "fidelity": scene.fidelity,
    });
    let levels = scene.fidelity.known().map(|(fidelity, level)| {
        let set = if level.set.is_empty() { String::new() } else { format!(" ({})", level.set.join(" ")) };
        format!("{}: {}{set}", fidelity.as_str(), level::expectation(level))
    });
    let levels: Vec<String> = levels.collect();
    let levels = if levels.is_empty() {
        String::new()
    } else {
        format!("\n\n{}\n{}", console.heading("fidelity"), bullets(&levels))
    };
    let text = format!(
        "{}: {}\n\n{}\n{}\n\n{}\n{}{levels}\n\nThe scene is good. Run it with: gelfmu run {name}",
        scene.scene.name,
        scene.scene.title,
        console.heading("models"),
        bullets(&modelled),
        console.heading("switched off"),
        bullets(&off)
    );
    console.result(&value, &text);
    Ok(())
}

fn bullets(lines: &[String]) -> String {
    lines.iter().map(|line| format!("  {line}")).collect::<Vec<_>>().join("\n")
}
