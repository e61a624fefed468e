//! Shell completion scripts: scripts of `clap_complete` in which a scene is a built-in name or a path.

use crate::options::CommandLine;
use ballistic_gel::scene;
use clap::CommandFactory;
use clap_complete::Shell;
use std::fmt::Write as _;

/// Subcommands whose first argument is a scene.
const SCENE_COMMANDS: [&str; 4] = ["run", "calibrate", "check", "scenes"];

/// Returns the completion script of a shell.
pub fn completion_script(shell: Shell) -> String {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut CommandLine::command(), "gelfmu", &mut script);
    let script = String::from_utf8_lossy(&script);
    match shell {
        Shell::Zsh => adapt_zsh(&script),
        Shell::Fish => adapt_fish(&script),
        // Bash completes paths where no name fits; the scripts of the other shells complete no values.
        _ => script.into_owned(),
    }
}

fn scene_names() -> String {
    scene::builtins().map(|(name, _)| name).collect::<Vec<_>>().join(" ")
}

/// Adapts a zsh script: paths are completed beside the names of scenes.
fn adapt_zsh(script: &str) -> String {
    let (names, action) = (scene_names(), "_gelfmu_scene");
    let function =
        format!("{action}() {{\n    _alternative 'scenes:scene:({names})' 'files:scene file:_files'\n}}\n\n");
    let script = script.replace(&format!(":({names})"), &format!(":{action}"));
    script.replacen("_gelfmu() {", &format!("{function}_gelfmu() {{"), 1)
}

/// Adapts a fish script: positional scene arguments have values, and options with values complete paths.
fn adapt_fish(script: &str) -> String {
    let mut script = script.replace(" -r -f -a \"fbi-bb", " -r -F -a \"fbi-bb");
    for command in SCENE_COMMANDS {
        let condition = format!("__fish_gelfmu_using_subcommand {command}");
        writeln!(script, "complete -c gelfmu -n \"{condition}\" -F -a \"{}\"", scene_names()).expect("a string grows");
    }
    script
}

#[cfg(test)]
mod tests {
    use super::completion_script;
    use clap_complete::Shell;

    #[test]
    fn scenes_and_levels_are_completed_and_paths_stay_possible() {
        let bash = completion_script(Shell::Bash);
        assert!(bash.contains("sphere-block") && bash.contains("draft coarse standard fine reference instant"));
        assert!(bash.contains("-o bashdefault -o default gelfmu"), "paths where no name fits");
        let zsh = completion_script(Shell::Zsh);
        assert!(zsh.contains(":_gelfmu_scene'") && zsh.contains("files:scene file:_files"), "{zsh}");
        assert!(zsh.contains("(draft coarse standard fine reference instant)"));
        let fish = completion_script(Shell::Fish);
        assert!(fish.contains("__fish_gelfmu_using_subcommand check\" -F -a \"fbi-bb"), "{fish}");
        assert!(!fish.contains("-f -a \"fbi-bb"), "options take paths, too");
    }
}
