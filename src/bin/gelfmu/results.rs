//! Result destinations: folders claimed for one run, and single files replaced atomically.

use crate::failure::{CommandError, RunError};
use crate::source::SceneSource;
use ballistic_gel::output::{FolderClaim, OutputError, ResultFolder, TakeoverPolicy};
use ballistic_gel::scene;
use same_file::Handle;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;
use zip::ZipArchive;

/// Claims the folder of `--out`; a refusal names the option.
pub fn claim(folder: &Path, wanted: &FolderClaim) -> Result<ResultFolder, CommandError> {
    ResultFolder::claim(folder, wanted).map_err(|error| {
        let why = match &error {
            OutputError::Refused { refusal, .. } => refusal.to_string(),
            OutputError::Write { path, source } => {
                let source = source.to_string();
                let found = source.strip_prefix("found ").unwrap_or(&source);
                format!("found {found} at {}, expected a folder that can be written", path.display())
            }
            other => other.to_string(),
        };
        refuse_out(folder, &why)
    })
}

fn refuse_out(out: &Path, why: &str) -> CommandError {
    CommandError::BadInput(format!("--out {}: {why}", out.display()))
}

/// Returns the takeover policy of a folder with results: replace with `--force`, else refuse.
pub fn policy(is_forced: bool) -> TakeoverPolicy {
    if is_forced { TakeoverPolicy::Replace } else { TakeoverPolicy::Refuse }
}

/// Lists the input files of a scene: the scene file, unless built in, and the files named in the scene.
pub fn inputs(name: &str, source: &SceneSource) -> Vec<PathBuf> {
    let own = scene::builtin(name).is_none().then(|| PathBuf::from(name));
    let named = source.scene.files().into_iter().map(|(_, file)| source.folder.join(file));
    own.into_iter().chain(named).collect()
}

/// Refuses an archive path with content other than an FMU, and the path of an input file.
pub fn check_archive(file: &Path, inputs: &[PathBuf]) -> Result<(), CommandError> {
    let expected = "a new file, or an FMU to replace";
    let found = match fs::metadata(file) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(_) => "a place that cannot be looked at",
        Ok(about) if about.is_dir() => "a folder",
        Ok(about) if !about.is_file() => "a device or a pipe",
        Ok(_) => match Handle::from_path(file) {
            Ok(own) if inputs.iter().any(|input| Handle::from_path(input).is_ok_and(|input| input == own)) => {
                "the file that is read"
            }
            Ok(_) if is_foreign_file(file) => "a file that is no FMU",
            Ok(_) => return Ok(()),
            Err(_) => "a file that cannot be read",
        },
    };
    Err(refuse_out(file, &format!("found {found}, expected {expected}")))
}

/// Returns true if a file is not empty and is not an FMU.
fn is_foreign_file(file: &Path) -> bool {
    let Ok(opened) = File::open(file) else { return true };
    let is_empty = opened.metadata().is_ok_and(|about| about.len() == 0);
    let is_fmu = |opened| ZipArchive::new(opened).is_ok_and(|mut zip| zip.by_name("modelDescription.xml").is_ok());
    !is_empty && !is_fmu(opened)
}

/// Replaces a file atomically: the old content stays until the new content is complete.
pub fn replace(file: &Path, bytes: &[u8]) -> Result<(), RunError> {
    // A link stays; its target is replaced.
    let place = fs::canonicalize(file).unwrap_or_else(|_| file.to_path_buf());
    let folder = folder_of(&place);
    let written = |path: &Path, source: io::Error| RunError::File { verb: "write", path: path.to_path_buf(), source };
    fs::create_dir_all(folder).map_err(|error| written(folder, error))?;
    let whole = write_part_file(folder, bytes).map_err(|error| written(file, error))?;
    whole.persist(&place).map(drop).map_err(|error| written(file, error.error))
}

/// Creates a file that does not exist, whole or not at all: a full disk leaves nothing of it.
pub fn create(file: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = folder_of(file);
    fs::metadata(folder)?; // an error without the name of the temporary file
    let whole = write_part_file(folder, bytes)?;
    whole.as_file().sync_all()?;
    whole.persist_noclobber(file).map(drop).map_err(|error| error.error)
}

fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Writes a temporary file; it is removed unless it is given its name.
fn write_part_file(folder: &Path, bytes: &[u8]) -> io::Result<NamedTempFile> {
    create_part_file(folder).and_then(|mut whole| whole.as_file_mut().write_all(bytes).map(|()| whole))
}

/// Creates a temporary file with the permissions of any new file; an unfinished one is removed.
fn create_part_file(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".gelfmu-").suffix(".part");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_atomically() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new/a.fmu");
        replace(&file, b"PK\x03\x04 one").unwrap();
        replace(&file, b"PK\x03\x04 two").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"PK\x03\x04 two");
        assert_eq!(fs::read_dir(file.parent().unwrap()).unwrap().count(), 1, "nothing is left beside it");
    }

    #[test]
    fn a_new_file_takes_the_place_of_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.toml");
        create(&file, b"one").unwrap();
        assert_eq!(create(&file, b"two").unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read(&file).unwrap(), b"one");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
    }

    #[test]
    fn an_archive_is_not_written_over_a_foreign_file() {
        let folder = tempfile::tempdir().unwrap();
        let refusal = |name: &str, inputs: &[PathBuf]| {
            check_archive(&folder.path().join(name), inputs).err().map(|error| error.to_string())
        };
        for (name, inside) in [("old.fmu", "modelDescription.xml"), ("thesis.docx", "word/document.xml")] {
            let mut zip = zip::ZipWriter::new(File::create(folder.path().join(name)).unwrap());
            zip.start_file(inside, zip::write::SimpleFileOptions::default()).unwrap();
            zip.finish().unwrap();
        }
        for (name, bytes) in [("scene.toml", b"[scene]" as &[u8]), ("empty", b"")] {
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        assert!(refusal("thesis.docx", &[]).is_some_and(|text| text.contains("found a file that is no FMU")));
        assert!(refusal("scene.toml", &[]).is_some_and(|text| text.contains("found a file that is no FMU")));
        assert_eq!([refusal("old.fmu", &[]), refusal("empty", &[]), refusal("new", &[])], [None, None, None]);
        fs::hard_link(folder.path().join("old.fmu"), folder.path().join("link.fmu")).unwrap();
        let inputs = [folder.path().join("link.fmu")];
        assert!(refusal("old.fmu", &inputs).is_some_and(|text| text.contains("found the file that is read")));
    }
}
