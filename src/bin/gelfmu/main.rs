//! `gelfmu`: runs, checks, calibrates and packs scenes of a gel block hit by a rigid projectile.

mod batch;
mod bench;
mod calibrate;
mod check;
mod completions;
mod console;
mod direct;
mod failure;
mod forecast;
mod help_headings;
mod interrupt;
mod job;
mod level;
mod listing;
mod manual;
mod measured;
mod moved;
mod movie;
mod new;
mod option_values;
mod options;
mod output_choice;
mod pack;
mod progress;
mod report;
mod report_options;
mod results;
mod rounding;
mod run;
mod scratch;
mod source;
mod summary;
mod text_width;
mod through_fmu;
mod units_option;
mod user_table;

use clap::{CommandFactory, FromArgMatches};
use console::Console;
use failure::CommandError;
use options::{CommandLine, GelfmuCommand, RunOptions};
use std::process::ExitCode;

fn main() -> ExitCode {
    interrupt::ignore_file_size_signal();
    let command = CommandLine::command().term_width(usize::from(text_width::output_width()));
    let parsed = command.long_version(&*pack::long_version().leak()).try_get_matches();
    let options = match parsed.and_then(|matches| CommandLine::from_arg_matches(&matches)) {
        Ok(options) => options,
        Err(error) => return ExitCode::from(console::usage(&error)),
    };
    if options.end_with_input {
        interrupt::end_with_input();
    }
    let console = Console::new(&options);
    match dispatch(options.command.unwrap_or(GelfmuCommand::Run(RunOptions::default())), &console) {
        Ok(code) => ExitCode::from(console.status(code)),
        Err(failure) => {
            console.failure(&failure);
            ExitCode::from(console.status(failure.code()))
        }
    }
}

/// Carries out one subcommand and returns the exit status.
fn dispatch(command: GelfmuCommand, console: &Console) -> Result<u8, CommandError> {
    match command {
        GelfmuCommand::Run(options) => return run::run(&options, console),
        GelfmuCommand::Batch(options) => batch::batch(&options)?,
        GelfmuCommand::Bench(options) => bench::bench(&options, console)?,
        GelfmuCommand::Calibrate(options) => return calibrate::calibrate(&options, console),
        GelfmuCommand::Trade { .. } => return Err(moved::refuse("trade", "trade SCENE")),
        GelfmuCommand::RemeshDemo { .. } => return Err(moved::refuse_pictures()),
        GelfmuCommand::Validate { .. } => return Err(moved::refuse("validate", "validate")),
        GelfmuCommand::Check(options) => check::check(&options, console)?,
        GelfmuCommand::Pack(options) => pack::pack(&options, console)?,
        GelfmuCommand::Report(options) => report::report(&options, console)?,
        GelfmuCommand::Movie(options) => movie::movie(&options, console)?,
        GelfmuCommand::New(options) => new::new(&options, console)?,
        GelfmuCommand::Projectiles { name, units } => listing::projectiles(name.as_deref(), units.system(), console)?,
        GelfmuCommand::Scenes { name } => listing::scenes(name.as_deref(), console)?,
        GelfmuCommand::Schema { of } => listing::schema(of, console),
        GelfmuCommand::Man { out } => manual::man(&out, console)?,
        GelfmuCommand::Completions { shell } => listing::completions(shell, console),
    }
    Ok(0)
}
