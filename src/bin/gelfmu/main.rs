//! `gelfmu`: runs, checks and packs scenes of a gel block hit by a rigid projectile.

mod bench;
mod calibrate;
mod check;
mod completions;
mod console;
mod direct;
mod failure;
mod interrupt;
mod job;
mod level;
mod listing;
mod options;
mod pack;
mod progress;
mod remesh_demo;
mod results;
mod run;
mod scratch;
mod source;
mod summary;
mod through_fmu;
mod trade;

use clap::Parser;
use console::Console;
use failure::Failure;
use options::{Command, Options, RunOptions};
use std::process::ExitCode;

fn main() -> ExitCode {
    interrupt::outlive_file_limits();
    let options = match Options::try_parse() {
        Ok(options) => options,
        Err(error) => return ExitCode::from(console::usage(&error)),
    };
    let console = Console::new(&options);
    match dispatch(options.command.unwrap_or(Command::Run(RunOptions::default())), &console) {
        Ok(code) => ExitCode::from(console.status(code)),
        Err(failure) => {
            console.failure(&failure);
            ExitCode::from(console.status(failure.code()))
        }
    }
}

/// Carries out one subcommand and says with which status to end.
fn dispatch(command: Command, console: &Console) -> Result<u8, Failure> {
    match command {
        Command::Run(options) => return run::run(&options, console),
        Command::Bench(options) => return bench::bench(&options, console),
        Command::Calibrate(options) => return calibrate::calibrate(&options, console),
        Command::Trade(options) => return trade::trade(&options, console),
        Command::TradeRow(options) => trade::row(&options)?,
        Command::Check(options) => check::check(&options, console)?,
        Command::Pack(options) => listing::pack(&options, console)?,
        Command::RemeshDemo(options) => remesh_demo::show(&options, console)?,
        Command::Scenes { name } => listing::scenes(name.as_deref(), console)?,
        Command::Schema => listing::schema(console),
        Command::Completions { shell } => listing::completions(shell, console),
    }
    Ok(0)
}
