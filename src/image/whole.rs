//! Output files that appear whole or not at all.

use super::temporary::Temporary;
use crate::error::InputError;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file under construction: a temporary beside its final name, renamed by [`WholeFile::commit`]
/// and removed when dropped without it.
///
/// A link is followed: the file it points to is replaced. A device or pipe (`/dev/null`) cannot be
/// replaced and is written to directly.
#[derive(Debug)]
pub struct WholeFile {
    path: PathBuf,
    writer: BufWriter<File>,
    temporary: Option<Temporary>,
}

impl WholeFile {
    /// Creates the temporary at once, so that a bad path fails before any work is done.
    ///
    /// # Errors
    ///
    /// A folder that does not exist or cannot be written to, and a path that is itself a folder.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, InputError> {
        let path = path.into();
        let path = if path.is_symlink() { path.canonicalize().unwrap_or(path) } else { path };
        if path.is_dir() {
            return Err(unwritable(&path, "a folder"));
        }
        if path.exists() && !path.is_file() {
            let file = File::options().write(true).open(&path);
            return Ok(Self {
                writer: BufWriter::new(file.map_err(|e| unwritable(&path, &e.to_string()))?),
                temporary: None,
                path,
            });
        }
        let (Some(folder), Some(_)) = (path.parent(), path.file_name()) else {
            return Err(unwritable(&path, "no file name"));
        };
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let (file, temporary) =
            Temporary::create(folder).map_err(|e| unwritable(&path, &plain(&e)))?;
        Ok(Self { path, writer: BufWriter::new(file), temporary: Some(temporary) })
    }

    /// The final name.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where the contents go.
    pub fn writer(&mut self) -> &mut BufWriter<File> {
        &mut self.writer
    }

    /// Lets `write` fill the file and names the file in any error.
    ///
    /// # Errors
    ///
    /// What writing failed with, a full disk for instance.
    pub fn write_with(
        &mut self,
        write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
    ) -> Result<(), InputError> {
        write(&mut self.writer).map_err(|e| unwritable(&self.path, &e.to_string()))
    }

    /// Gives the file its final name, replacing what was there.
    ///
    /// # Errors
    ///
    /// What flushing or renaming failed with; the temporary is removed then.
    pub fn commit(mut self) -> Result<(), InputError> {
        self.writer.flush().map_err(|e| unwritable(&self.path, &e.to_string()))?;
        // Closed before it is renamed, which some systems insist on.
        drop(self.writer);
        if let Some(temporary) = self.temporary {
            temporary.persist(&self.path).map_err(|e| unwritable(&self.path, &e.to_string()))?;
        }
        Ok(())
    }
}

/// The error without the temporary's name, which means nothing to a user.
fn plain(error: &std::io::Error) -> String {
    let text = error.to_string();
    text.split(" at path ").next().unwrap_or("").to_string()
}

fn unwritable(path: &Path, found: &str) -> InputError {
    InputError::new(
        path.display().to_string(),
        "a path that can be written",
        found,
        "check that the folder exists and has room, and that you may write there",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_only_when_committed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        let mut file = WholeFile::create(&path).unwrap();
        file.writer().write_all(b"whole").unwrap();
        assert!(!path.exists());
        file.commit().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
        assert_eq!(names(folder.path()), ["out.txt"]);
    }

    #[test]
    fn a_dropped_file_leaves_nothing_and_keeps_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        std::fs::write(&path, "old").unwrap();
        let mut file = WholeFile::create(&path).unwrap();
        file.write_with(|w| w.write_all(b"new")).unwrap();
        drop(file);
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["out.txt"]);
    }

    #[test]
    #[cfg(unix)]
    fn links_are_followed_and_pipes_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        std::fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        let mut file = WholeFile::create(&link).unwrap();
        file.write_with(|w| w.write_all(b"new")).unwrap();
        file.commit().unwrap();
        assert_eq!(std::fs::read(&real).unwrap(), b"new");
        assert!(link.is_symlink());
        let mut null = WholeFile::create("/dev/null").unwrap();
        assert!(null.temporary.is_none());
        null.write_with(|w| w.write_all(b"gone")).unwrap();
        null.commit().unwrap();
        assert!(!Path::new("/dev/null").is_file());
    }

    #[test]
    fn bad_paths_fail_at_once() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().to_owned(), folder.path().join("none/out.txt"), "/".into()] {
            assert!(WholeFile::create(path).is_err());
        }
        assert!(names(folder.path()).is_empty());
    }
}
