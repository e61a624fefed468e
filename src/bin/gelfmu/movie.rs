//! `gelfmu movie`: a film of a finished run, through ffmpeg if it is installed.

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::report_options::MovieOptions;
use crate::source;
use ballistic_gel::output::{SCENE, movie_pictures};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Filter of a GIF: its colours are chosen from the whole film.
const PALETTE: &str = "split[a][b];[a]palettegen[p];[b][p]paletteuse";

/// Format of a film.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum MovieFormat {
    Gif,
    Mp4,
}

impl MovieFormat {
    fn of(file: &Path) -> Result<Self, CommandError> {
        match file.extension().and_then(|extension| extension.to_str()) {
            Some("gif") => Ok(Self::Gif),
            Some("mp4") => Ok(Self::Mp4),
            _ => Err(refuse(file, "found another ending", "a file that ends in .gif or .mp4")),
        }
    }

    /// Returns the options of ffmpeg for the format.
    fn encoding(self) -> &'static [&'static str] {
        match self {
            Self::Gif => &["-filter_complex", PALETTE],
            Self::Mp4 => &["-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "18"],
        }
    }
}

/// Makes the film.
pub fn movie(options: &MovieOptions, console: &Console) -> Result<(), CommandError> {
    let folder = &options.folder;
    let scene_file = folder.join(SCENE);
    if !scene_file.is_file() {
        let found = format!("found no {SCENE} in {}", folder.display());
        return Err(CommandError::BadInput(format!("movie: {found}, expected a folder written by gelfmu run")));
    }
    let out = options.out.clone().unwrap_or_else(|| default_file(folder));
    let format = MovieFormat::of(&out)?;
    let has_ffmpeg = run_quietly(Command::new("ffmpeg").arg("-version"));
    let place = if has_ffmpeg { out.clone() } else { out.with_extension("frames") };
    if place.exists() && !options.force {
        return Err(refuse(&place, "found a file of this name", "a new name, or --force"));
    }
    let source = source::load(&scene_file.to_string_lossy(), &[])?;
    let pictures =
        movie_pictures(folder, &source.scene).map_err(|error| CommandError::BadInput(format!("movie: {error}")))?;
    if has_ffmpeg {
        encode(&pictures, format, options.rate, &out)?;
    } else {
        write_pictures(&pictures, &place)?;
        console.note("ffmpeg is not installed or not on the PATH: the film is left as PNG files");
    }
    let result = json!({ "file": place, "pictures": pictures.len(), "encoded": has_ffmpeg });
    console.result(&result, &format!("{}: {} pictures", place.display(), pictures.len()));
    Ok(())
}

/// Returns the file of a film without `--out`: beside the folder, under its name.
fn default_file(folder: &Path) -> PathBuf {
    let whole = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    let name = whole.file_name().map_or_else(|| "film".into(), |name| name.to_string_lossy().into_owned());
    whole.with_file_name(format!("{name}.gif"))
}

fn refuse(file: &Path, found: &str, expected: &str) -> CommandError {
    CommandError::BadInput(format!("--out {}: {found}, expected {expected}", file.display()))
}

/// Runs a command without its output; returns true if it succeeded.
fn run_quietly(command: &mut Command) -> bool {
    let quiet = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().is_ok_and(|status| status.success())
}

/// Writes the pictures as numbered PNG files into a folder.
fn write_pictures(pictures: &[Vec<u8>], folder: &Path) -> Result<(), CommandError> {
    let failed = |path: &Path, source| RunError::File { verb: "write", path: path.to_path_buf(), source };
    std::fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
    // Pictures of an earlier, longer film.
    for number in pictures.len().. {
        let file = folder.join(format!("{number:05}.png"));
        if !file.is_file() {
            break;
        }
        std::fs::remove_file(&file).map_err(|source| RunError::File { verb: "remove", path: file, source })?;
    }
    for (number, picture) in pictures.iter().enumerate() {
        let file = folder.join(format!("{number:05}.png"));
        std::fs::write(&file, picture).map_err(|error| failed(&file, error))?;
    }
    Ok(())
}

/// Encodes the pictures with ffmpeg.
fn encode(pictures: &[Vec<u8>], format: MovieFormat, rate: u32, out: &Path) -> Result<(), CommandError> {
    let folder =
        tempfile::tempdir().map_err(|source| RunError::File { verb: "write", path: std::env::temp_dir(), source })?;
    write_pictures(pictures, folder.path())?;
    let film = folder.path().join("film").with_extension(out.extension().unwrap_or_default());
    let mut command = Command::new("ffmpeg");
    command.args(["-y", "-loglevel", "error", "-framerate", &rate.to_string(), "-i"]);
    command.arg(folder.path().join("%05d.png")).args(format.encoding()).arg(&film);
    let output = command.stdin(Stdio::null()).output();
    let why = match &output {
        Ok(output) if output.status.success() => None,
        Ok(output) => Some(String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or_default().to_owned()),
        Err(error) => Some(error.to_string()),
    };
    if let Some(why) = why {
        return Err(CommandError::Stopped(format!(
            "ffmpeg made no film ({why}): choose the other of .gif and .mp4, or an ffmpeg with this format"
        )));
    }
    // An earlier film stays until the new one is complete.
    let copied = std::fs::copy(&film, out).map(drop);
    copied.map_err(|source| RunError::File { verb: "write", path: out.to_path_buf(), source }.into())
}
