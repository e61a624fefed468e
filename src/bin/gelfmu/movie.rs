//! `gelfmu movie`: a film of a finished run, as a GIF, or as an MP4 by ffmpeg if that is installed.

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::report_options::MovieOptions;
use crate::results;
use crate::source;
use ballistic_gel::output::{OpaquePicture, SCENE, movie_pictures};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Speed of the choice of colours, from 1 (best) to 30.
const PALETTE_SPEED: i32 = 10;

/// Form in which a film is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum MovieFormat {
    Gif,
    Mp4,
    /// Numbered PNG files, where there is no ffmpeg for an MP4.
    Pictures,
}

impl MovieFormat {
    fn of(file: &Path) -> Result<Self, CommandError> {
        match file.extension().and_then(|extension| extension.to_str()) {
            Some("gif") => Ok(Self::Gif),
            Some("mp4") if run_quietly(Command::new("ffmpeg").arg("-version")) => Ok(Self::Mp4),
            Some("mp4") => Ok(Self::Pictures),
            _ => Err(refuse(file, "found another ending", "a file that ends in .gif or .mp4")),
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
    let place = if format == MovieFormat::Pictures { out.with_extension("frames") } else { out };
    if place.exists() && !options.force {
        return Err(refuse(&place, "found something of this name", "a new name, or --force"));
    }
    let source = source::load(&scene_file.to_string_lossy(), &[])?;
    let pictures =
        movie_pictures(folder, &source.scene).map_err(|error| CommandError::BadInput(format!("movie: {error}")))?;
    let n_pictures = pictures.len();
    match format {
        MovieFormat::Gif => {
            let failed = |error| CommandError::Stopped(format!("movie: the pictures make no GIF: {error}"));
            results::replace(&place, &encode_gif(pictures, options.rate).map_err(failed)?)?;
        }
        MovieFormat::Mp4 => encode(&pictures, options.rate, &place)?,
        MovieFormat::Pictures => {
            write_pictures(&pictures, &place)?;
            console.note(
                "ffmpeg is not installed or not on the PATH: the film is left as PNG files; a .gif needs no ffmpeg",
            );
        }
    }
    let result = json!({ "file": place, "pictures": n_pictures, "encoded": format != MovieFormat::Pictures });
    console.result(&result, &format!("{}: {n_pictures} pictures", place.display()));
    Ok(())
}

/// Encodes the pictures as a GIF that repeats.
fn encode_gif(pictures: Vec<OpaquePicture>, rate: u32) -> Result<Vec<u8>, gif::EncodingError> {
    let [width, height] = pictures.first().map_or([0; 2], |first| first.size.map(side));
    let mut film = vec![];
    let mut encoder = gif::Encoder::new(&mut film, width, height, &[])?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    pictures.into_iter().try_for_each(|picture| encoder.write_frame(&gif_frame(picture, rate)))?;
    drop(encoder);
    Ok(film)
}

/// Returns a picture as a frame of a GIF with colours of its own, shown for 1/`rate` s.
fn gif_frame(picture: OpaquePicture, rate: u32) -> gif::Frame<'static> {
    let [width, height] = picture.size.map(side);
    let mut pixels = picture.pixels.into_flattened();
    let frame = gif::Frame::from_rgba_speed(width, height, &mut pixels, PALETTE_SPEED);
    // Hundredths of a second.
    gif::Frame { delay: u16::try_from(100_u32.div_ceil(rate.max(1))).unwrap_or(u16::MAX), ..frame }
}

/// Returns a width or height as a GIF has it.
fn side(pixels: usize) -> u16 {
    u16::try_from(pixels).expect("a picture of a film has some thousand pixels a side")
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
fn write_pictures(pictures: &[OpaquePicture], folder: &Path) -> Result<(), CommandError> {
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
        std::fs::write(&file, picture.png()).map_err(|error| failed(&file, error))?;
    }
    Ok(())
}

/// Encodes the pictures as an MP4 with ffmpeg.
fn encode(pictures: &[OpaquePicture], rate: u32, out: &Path) -> Result<(), CommandError> {
    let folder =
        tempfile::tempdir().map_err(|source| RunError::File { verb: "write", path: std::env::temp_dir(), source })?;
    write_pictures(pictures, folder.path())?;
    let film = folder.path().join("film.mp4");
    let mut command = Command::new("ffmpeg");
    command.args(["-y", "-loglevel", "error", "-framerate", &rate.to_string(), "-i"]);
    command.arg(folder.path().join("%05d.png"));
    command.args(["-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "18"]).arg(&film);
    let output = command.stdin(Stdio::null()).output();
    let why = match &output {
        Ok(output) if output.status.success() => None,
        Ok(output) => Some(String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or_default().to_owned()),
        Err(error) => Some(error.to_string()),
    };
    if let Some(why) = why {
        return Err(CommandError::Stopped(format!(
            "ffmpeg made no film ({why}): choose a .gif, or an ffmpeg with H.264"
        )));
    }
    // An earlier film stays until the new one is complete.
    let copied = std::fs::copy(&film, out).map(drop);
    copied.map_err(|source| RunError::File { verb: "write", path: out.to_path_buf(), source }.into())
}
