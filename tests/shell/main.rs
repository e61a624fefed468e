//! Command, scenes and results: what a user reads and writes.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

#[path = "../command/lines.rs"]
mod lines;
#[path = "../output/page.rs"]
mod page;
#[path = "../output/stage.rs"]
mod stage;
#[path = "../hostile/written.rs"]
mod written;

mod calibrate;
mod command;
mod fields;
mod folders;
mod layers;
mod levels;
mod output;
mod perforation;
mod presets;
mod report_commands;
mod scene;
mod sensors;
mod shot;
mod stl_files;
mod supply;
mod terminal;
