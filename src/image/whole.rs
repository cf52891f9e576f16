//! Output files that appear whole or not at all.
//!
//! Contents wait in memory. A temporary file next to the final name exists only from the moment in which all contents are
//! there to the renaming, so that nothing stays where a signal ends the process while it works.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::TempPath;

use crate::error::InputError;

/// A file under construction; dropped without [`WholeFile::commit`], it never was.
///
/// A link is followed: the file it points to is replaced. The rights of a file that is replaced stay.
/// A device or pipe (`/dev/null`, and stdout, which is `-`) cannot be
/// replaced and is written to directly.
#[derive(Debug)]
pub struct WholeFile {
    path: PathBuf,
    contents: Vec<u8>,
}

impl WholeFile {
    /// Checks the path at once, so that a bad one fails before any work is done.
    ///
    /// # Errors
    ///
    /// A folder that does not exist or cannot be written to, and a path that is itself a folder.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, InputError> {
        let path = path.into();
        let path = target(path);
        let checked = if is_stdout(&path) {
            Ok(())
        } else if path.is_dir() {
            Err(io::Error::other("a folder"))
        } else if is_special(&path) {
            std::fs::File::options().write(true).open(&path).map(drop)
        } else if path.file_name().is_none() {
            Err(io::Error::other("no file name"))
        } else {
            temporary(&path).map(drop)
        };
        checked.map_err(|e| unwritable(&path, &e))?;
        Ok(Self { path, contents: Vec::new() })
    }

    /// Lets `write` fill the file and names the file in any error.
    ///
    /// # Errors
    ///
    /// What `write` failed with.
    pub fn write_with(
        &mut self,
        write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>,
    ) -> Result<(), InputError> {
        write(&mut self.contents).map_err(|e| unwritable(&self.path, &e))
    }

    /// Gives the file its final name, replacing what was there.
    ///
    /// # Errors
    ///
    /// What writing (on a full disk for instance) or renaming failed with; nothing is left behind then.
    pub fn commit(self) -> Result<(), InputError> {
        commit_all([self])
    }

    /// Writes the contents, under their final name only where that is a device.
    fn put(&self) -> io::Result<Option<TempPath>> {
        if is_stdout(&self.path) {
            let mut out = io::stdout().lock();
            return out.write_all(&self.contents).and_then(|()| out.flush()).map(|()| None);
        }
        if is_special(&self.path) {
            std::fs::File::options().write(true).open(&self.path)?.write_all(&self.contents)?;
            return Ok(None);
        }
        std::fs::create_dir_all(folder(&self.path))?;
        let mut file = temporary(&self.path)?;
        file.write_all(&self.contents)?;
        if let Ok(before) = std::fs::metadata(&self.path) {
            file.as_file().set_permissions(before.permissions())?;
        }
        Ok(Some(file.into_temp_path()))
    }
}

/// Gives files their final names; all are written before the first gets it.
///
/// # Errors
///
/// Those of [`WholeFile::commit`].
pub fn commit_all(files: impl IntoIterator<Item = WholeFile>) -> Result<(), InputError> {
    let mut written = Vec::new();
    for file in files {
        let temporary = file.put().map_err(|e| unwritable(&file.path, &e))?;
        written.push((file.path, temporary));
    }
    for (path, temporary) in written {
        if let Some(temporary) = temporary {
            temporary.persist(&path).map_err(|e| unwritable(&path, &e.error))?;
        }
    }
    Ok(())
}

/// A folder for outputs, made when the first file gets its name in it.
///
/// Folders that had to be made and are still empty go when this is dropped.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// Folders that did not exist, innermost first.
    missing: Vec<PathBuf>,
}

impl OutputFolder {
    /// Makes the folder and its parents where they are missing, to see that it can be done, and removes them again.
    ///
    /// # Errors
    /// A path that is a file, or a parent in which no folder can be made; nothing is left behind.
    pub fn create(path: &Path) -> io::Result<Self> {
        let missing = path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.is_dir());
        let folder = Self { path: path.into(), missing: missing.map(Path::to_path_buf).collect() };
        let made = std::fs::create_dir_all(path);
        folder.remove_empty();
        made.map(|()| folder)
    }

    /// A file in it, checked like any other if the folder was there before.
    ///
    /// # Errors
    /// Those of [`WholeFile::create`].
    pub fn file(&self, name: impl AsRef<Path>) -> Result<WholeFile, InputError> {
        self.at(&self.path.join(name))
    }

    /// A file that may lie in this folder or elsewhere.
    ///
    /// # Errors
    /// Those of [`WholeFile::create`].
    pub fn at(&self, path: &Path) -> Result<WholeFile, InputError> {
        let absolute = |path: &Path| std::path::absolute(path).ok();
        let inside = absolute(folder(path)) == absolute(&self.path);
        if inside && !self.missing.is_empty() {
            return Ok(WholeFile { path: path.into(), contents: Vec::new() });
        }
        WholeFile::create(path)
    }

    fn remove_empty(&self) {
        for folder in &self.missing {
            // Only an empty one goes.
            let _ = std::fs::remove_dir(folder);
        }
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        self.remove_empty();
    }
}

/// What a link points to, whether it is there yet or not; a path that is no link stays.
fn target(mut path: PathBuf) -> PathBuf {
    // As many links in a row as Linux follows.
    for _ in 0..40 {
        let Ok(to) = path.read_link() else { break };
        path = folder(&path).join(to);
    }
    path
}

fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Whether a path names something that cannot be replaced.
fn is_special(path: &Path) -> bool {
    path.exists() && !path.is_file()
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A temporary file next to a path, with the rights of any new file.
fn temporary(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tapline-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder(path))
}

/// An error without the temporary's name, which means nothing to a user.
fn unwritable(path: &Path, found: &io::Error) -> InputError {
    InputError::new(
        path.display().to_string(),
        "a path that can be written",
        found.to_string().split(" at path ").next().unwrap_or(""),
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
    fn nothing_appears_before_it_is_committed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        let mut file = WholeFile::create(&path).unwrap();
        file.write_with(|w| w.write_all(b"whole")).unwrap();
        assert!(names(folder.path()).is_empty());
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
        // A link by a relative path to a file that is not there yet; rights stay.
        use std::os::unix::fs::PermissionsExt as _;
        let ahead = folder.path().join("ahead");
        std::os::unix::fs::symlink("later", &ahead).unwrap();
        WholeFile::create(&ahead).unwrap().commit().unwrap();
        assert!(ahead.is_symlink() && folder.path().join("later").is_file());
        std::fs::set_permissions(&real, std::fs::Permissions::from_mode(0o640)).unwrap();
        WholeFile::create(&link).unwrap().commit().unwrap();
        assert_eq!(std::fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);
        let mut null = WholeFile::create("/dev/null").unwrap();
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

    #[test]
    fn a_new_folder_comes_with_its_first_file() {
        let root = tempfile::tempdir().unwrap();
        let deep = root.path().join("a/b");
        let folder = OutputFolder::create(&deep).unwrap();
        let files = [folder.file("x").unwrap(), folder.at(&deep.join("./y")).unwrap()];
        assert!(folder.at(&root.path().join("none/z")).is_err());
        assert!(names(root.path()).is_empty());
        commit_all(files).unwrap();
        drop(folder);
        assert_eq!(names(&deep), ["x", "y"]);
        drop(OutputFolder::create(&deep.join("c/d")).unwrap());
        assert_eq!(names(&deep), ["x", "y"]);
        std::fs::create_dir(deep.join("empty")).unwrap();
        drop(OutputFolder::create(&deep.join("empty")).unwrap());
        assert!(deep.join("empty").is_dir(), "a folder that was there before stays");
        assert!(OutputFolder::create(&deep.join("x")).is_err());
        assert!(OutputFolder::create(&deep.join("x/d")).is_err());
    }
}
