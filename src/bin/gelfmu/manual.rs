//! `gelfmu man`: the manual pages, from the help of the commands.

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::options::CommandLine;
use crate::results;
use clap::{Command, CommandFactory};
use clap_mangen::Man;
use serde_json::json;
use std::io;
use std::path::Path;

/// Manual page.
struct ManualPage {
    /// File name, such as `gelfmu-run.1`.
    file: String,
    /// Text in roff.
    text: Vec<u8>,
}

/// Writes the page of the program and one of each command, and prints their number.
pub fn man(folder: &Path, console: &Console) -> Result<(), CommandError> {
    let unwritable = |source| RunError::File { verb: "write", path: folder.to_path_buf(), source };
    let pages = manual_pages().map_err(unwritable)?;
    for page in &pages {
        results::replace(&folder.join(&page.file), &page.text)?;
    }
    let files: Vec<&str> = pages.iter().map(|page| page.file.as_str()).collect();
    let text = format!(
        "{}: {} manual pages. The first is shown by:\n    man -l {}",
        folder.display(),
        files.len(),
        folder.join(files[0]).display()
    );
    console.result(&json!({ "folder": folder, "files": files }), &text);
    Ok(())
}

/// Returns the pages of the program and of its commands, without the former ones.
fn manual_pages() -> io::Result<Vec<ManualPage>> {
    let mut program = CommandLine::command().disable_help_subcommand(true);
    program.build();
    let commands = program.get_subcommands().filter(|command| !command.is_hide_set());
    let named = commands.map(|command| command.clone().name(format!("gelfmu-{}", command.get_name()).leak() as &str));
    [program.clone()].into_iter().chain(named).map(manual_page).collect()
}

fn manual_page(command: Command) -> io::Result<ManualPage> {
    let file = format!("{}.1", command.get_name());
    let mut text = vec![];
    Man::new(command.version(env!("CARGO_PKG_VERSION"))).render(&mut text)?;
    Ok(ManualPage { file, text })
}

#[cfg(test)]
mod tests {
    use super::manual_pages;

    #[test]
    fn every_command_has_a_page_with_its_options() {
        let pages = manual_pages().unwrap();
        let text = |file: &str| {
            let page = pages.iter().find(|page| page.file == file).unwrap_or_else(|| panic!("{file}"));
            String::from_utf8(page.text.clone()).unwrap()
        };
        assert!(text("gelfmu.1").contains(".TH gelfmu 1") && text("gelfmu.1").contains("gelfmu\\-run(1)"));
        assert!(text("gelfmu-run.1").contains("\\-\\-fidelity") && text("gelfmu-run.1").contains("GLOBAL OPTIONS"));
        assert!(pages.len() > 10 && pages.iter().all(|page| !page.file.contains("trade")), "{}", pages.len());
    }
}
