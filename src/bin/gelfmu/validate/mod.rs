//! `gelfmu validate`: runs the measured shots of the library and compares depths and necks.

mod case;
mod measured;
mod options;
mod picture;
mod queue;
mod row;
mod table;

pub use options::ValidateOptions;

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::progress::ProgressDisplay;
use crate::{interrupt, results};
use ballistic_gel::output::{FolderClaim, FolderState, ResultFolder, TakeoverPolicy};
use ballistic_gel::scene;
use case::cases_of;
use measured::ValidationShot;
pub use measured::measured_shots;
use serde_json::json;
use table::AgreementCount;

/// Name of the command in the folder manifest.
const COMMAND: &str = "validate";
/// Files beside the rows.
const FILES: [&str; 3] = ["validation.csv", "validation.md", "validation.svg"];
/// Answer to the first Ctrl-C.
const WAITING: &str = "interrupted: finished runs are kept, the others are left; the same command goes on from there";

/// Runs the cases, writes table and picture, and returns the exit status.
pub fn validate(options: &ValidateOptions, console: &Console) -> Result<u8, CommandError> {
    let shots = wanted_shots(options)?;
    let cases = shots.iter().flat_map(cases_of);
    let cases: Vec<_> = cases.filter(|case| options.level.as_ref().is_none_or(|level| level == case.level)).collect();
    let needs = FILES.map(str::to_owned);
    let claim = FolderClaim {
        command: COMMAND,
        policy: TakeoverPolicy::Continue,
        needs: &needs,
        inputs: &[],
        is_of_fmu: false,
    };
    let mut folder = results::claim(&options.out, &claim)?;
    if let Err(error) = interrupt::listen(WAITING, console.listener()) {
        console.note(&format!("Ctrl-C will not keep what was computed: {error}"));
    }
    if options.afresh {
        folder.remove_all(queue::ROWS_FOLDER).map_err(RunError::from)?;
    }
    console.note(&format!("{} shots, {} runs, into {}", shots.len(), cases.len(), options.out.display()));
    let bar = ProgressDisplay::new(console);
    let finished = queue::run_cases(cases, options.jobs, &mut folder, &bar);
    bar.clear();
    let results = table::by_shot(&finished?, &shots);
    write_files(&mut folder, &results)?;
    report(&results, console);
    let has_failures = results.iter().any(|result| !result.failures.is_empty());
    let code = finish(folder, options, console)?;
    Ok(if code == 0 && has_failures { 1 } else { code })
}

fn wanted_shots(options: &ValidateOptions) -> Result<Vec<ValidationShot>, CommandError> {
    let all = measured_shots();
    if let Some(unknown) = options.only.iter().find(|name| all.iter().all(|shot| shot.name != **name)) {
        let names: Vec<&str> = all.iter().map(|shot| shot.name.as_str()).collect();
        let hint = scene::did_you_mean(unknown, names.iter().copied());
        return Err(CommandError::BadInput(format!(
            "--only {unknown}: found no measured shot of this name{hint}, expected one of {}",
            names.join(", ")
        )));
    }
    Ok(all.into_iter().filter(|shot| options.only.is_empty() || options.only.contains(&shot.name)).collect())
}

fn write_files(folder: &mut ResultFolder, results: &[table::ShotResult]) -> Result<(), CommandError> {
    let contents = [table::to_csv(results), table::to_markdown(results), picture::draw_svg(results)];
    for (name, content) in FILES.iter().zip(contents) {
        folder.write(name, content.as_bytes()).map_err(RunError::from)?;
    }
    Ok(())
}

fn report(results: &[table::ShotResult], console: &Console) {
    let AgreementCount { agreeing, judged } = table::count_agreement(results);
    let failures: Vec<&String> = results.iter().flat_map(|result| &result.failures).collect();
    let value = json!({
        "rows": results.iter().flat_map(|result| &result.rows).collect::<Vec<_>>(),
        "agreeing": agreeing,
        "judged": judged,
        "failures": failures,
    });
    let band = 100.0 * table::BAND;
    let failed: Vec<&str> = failures.iter().map(|why| why.as_str()).collect();
    let text = format!(
        "{}\n{agreeing} of {judged} shots of grade B that the gel is not fitted to agree within {band:.0} %\n{}",
        table::to_markdown(results),
        failed.join("\n")
    );
    console.result(&value, &text);
}

/// Completes the folder and returns the exit status.
fn finish(mut folder: ResultFolder, options: &ValidateOptions, console: &Console) -> Result<u8, CommandError> {
    let state = if interrupt::asked() { FolderState::Interrupted } else { FolderState::Complete };
    folder.begin().and_then(|()| folder.mark(state)).map_err(RunError::from)?;
    if state == FolderState::Complete {
        return Ok(0);
    }
    console.error(&format!("interrupted; finished runs are kept in {}", options.out.display()));
    Ok(interrupt::INTERRUPTED)
}
