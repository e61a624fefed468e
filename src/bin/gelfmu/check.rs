//! `gelfmu check`: is the scene good, and what does it model?

use crate::console::Console;
use crate::failure::Failure;
use crate::source;
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
    });
    let text = format!(
        "{}: {}\n\n{}\n{}\n\n{}\n{}\n\nThe scene is good. Run it with: gelfmu run {name}",
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
