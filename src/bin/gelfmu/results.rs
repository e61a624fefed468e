//! Destinations of results: folders that are claimed for one run, and single files that are replaced whole.

use crate::failure::Failure;
use crate::job::RunError;
use crate::source::Source;
use ballistic_gel::output::{FolderClaim, OutputError, ResultFolder, TakeoverPolicy};
use ballistic_gel::scene;
use same_file::Handle;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;
use zip::ZipArchive;

/// Claims the folder of `--out`; a refusal names the option.
pub fn claim(folder: &Path, wanted: &FolderClaim) -> Result<ResultFolder, Failure> {
    ResultFolder::claim(folder, wanted).map_err(|error| {
        let why = match &error {
            OutputError::Refused { refusal, .. } => refusal.to_string(),
            OutputError::Write { path, source } => {
                format!("found {source} at {}, expected a folder that can be written", path.display())
            }
            other => other.to_string(),
        };
        refused(folder, &why)
    })
}

fn refused(out: &Path, why: &str) -> Failure {
    Failure::BadInput(format!("--out {}: {why}", out.display()))
}

/// The policy for results that are there, with or without `--force`.
pub fn policy(is_forced: bool) -> TakeoverPolicy {
    if is_forced { TakeoverPolicy::Replace } else { TakeoverPolicy::Refuse }
}

/// Files that a scene of a name is read from: its own, if it is not built in, and those that it names.
pub fn inputs(name: &str, source: &Source) -> Vec<PathBuf> {
    let own = scene::builtin(name).is_none().then(|| PathBuf::from(name));
    let named = source.scene.files().into_iter().map(|(_, file)| source.folder.join(file));
    own.into_iter().chain(named).collect()
}

/// Refuses a path for an archive where something else than an archive is, or a file that is read.
pub fn check_archive(file: &Path, inputs: &[PathBuf]) -> Result<(), Failure> {
    let expected = "a new file, or an FMU to replace";
    let found = match fs::metadata(file) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(_) => "a place that cannot be looked at",
        Ok(there) if there.is_dir() => "a folder",
        Ok(there) if !there.is_file() => "a device or a pipe",
        Ok(_) => match Handle::from_path(file) {
            Ok(own) if inputs.iter().any(|input| Handle::from_path(input).is_ok_and(|input| input == own)) => {
                "the file that is read"
            }
            Ok(_) if has_other_content(file) => "a file that is no FMU",
            Ok(_) => return Ok(()),
            Err(_) => "a file that cannot be read",
        },
    };
    Err(refused(file, &format!("found {found}, expected {expected}")))
}

/// Returns true if a file has bytes, and they are not those of an FMU.
fn has_other_content(file: &Path) -> bool {
    let Ok(opened) = File::open(file) else { return true };
    let is_empty = opened.metadata().is_ok_and(|about| about.len() == 0);
    let is_fmu = |opened| ZipArchive::new(opened).is_ok_and(|mut zip| zip.by_name("modelDescription.xml").is_ok());
    !is_empty && !is_fmu(opened)
}

/// Writes a file in whole: until then an old one of the path stays as it is.
pub fn replace(file: &Path, bytes: &[u8]) -> Result<(), RunError> {
    // Through a link, the file that it leads to is replaced.
    let place = fs::canonicalize(file).unwrap_or_else(|_| file.to_path_buf());
    let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let written = |path: &Path, source: io::Error| RunError::File { verb: "write", path: path.to_path_buf(), source };
    fs::create_dir_all(folder).map_err(|error| written(folder, error))?;
    let made = begun(folder).and_then(|mut whole| whole.write_all(bytes).map(|()| whole));
    let whole = made.map_err(|error| written(file, error))?;
    whole.persist(&place).map(drop).map_err(|error| written(file, error.error))
}

/// A file that goes if it is not finished. It has the permissions of any new file.
fn begun(folder: &Path) -> io::Result<NamedTempFile> {
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
    fn a_file_is_replaced_in_whole_and_never_by_half() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new/a.fmu");
        replace(&file, b"PK\x03\x04 one").unwrap();
        replace(&file, b"PK\x03\x04 two").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"PK\x03\x04 two");
        assert_eq!(fs::read_dir(file.parent().unwrap()).unwrap().count(), 1, "nothing is left beside it");
    }

    #[test]
    fn an_archive_is_not_written_over_what_is_none() {
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
