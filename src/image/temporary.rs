//! Temporaries of output files, on record until they are renamed or removed.
//!
//! Destructors do not run when a signal ends the process. So every temporary and every folder made for
//! outputs is entered in one list, and whoever handles the signal calls [`remove_all`].

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempPath;

/// What is to be removed if the process ends now.
#[derive(Debug)]
pub struct Pending {
    files: Vec<PathBuf>,
    folders: Vec<PathBuf>,
}

static PENDING: Mutex<Pending> = Mutex::new(Pending { files: Vec::new(), folders: Vec::new() });

fn pending() -> MutexGuard<'static, Pending> {
    PENDING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes every temporary on record and the new folders that are empty.
///
/// No temporary can be made while the caller keeps the guard, which it does until the process ends.
pub fn remove_all() -> MutexGuard<'static, Pending> {
    let mut list = pending();
    for file in list.files.drain(..) {
        // It may be gone already.
        let _ = std::fs::remove_file(file);
    }
    for folder in list.folders.drain(..).rev() {
        // Only an empty one goes.
        let _ = std::fs::remove_dir(folder);
    }
    list
}

/// A temporary file, removed when dropped.
#[derive(Debug)]
pub(super) struct Temporary {
    path: Option<TempPath>,
    name: PathBuf,
}

impl Temporary {
    /// Makes a file in `folder` and enters it in the list in one step.
    pub(super) fn create(folder: &Path) -> io::Result<(File, Self)> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".tapline-").suffix(".tmp");
        // A temporary is private by default; the result should get the rights of any new file.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let mut list = pending();
        let (file, path) = builder.tempfile_in(folder)?.into_parts();
        let name = path.to_path_buf();
        list.files.push(name.clone());
        Ok((file, Self { path: Some(path), name }))
    }

    /// Gives the file its final name.
    pub(super) fn persist(mut self, target: &Path) -> io::Result<()> {
        match self.path.take() {
            Some(path) => path.persist(target).map_err(|e| e.error),
            None => Ok(()),
        }
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // Removed before it leaves the list.
        drop(self.path.take());
        pending().files.retain(|f| *f != self.name);
    }
}

/// A folder for outputs. Those of its parents and itself that had to be made are removed again when
/// dropped, unless [`keep`](Self::keep) was called or files have come into them.
#[derive(Debug)]
pub struct OutputFolder {
    made: Vec<PathBuf>,
}

impl OutputFolder {
    /// Makes the folder and its parents where they are missing.
    ///
    /// # Errors
    /// A path that is a file, or a parent in which no folder can be made; nothing is left behind.
    pub fn create(path: &Path) -> io::Result<Self> {
        let mut missing: Vec<&Path> =
            path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.is_dir()).collect();
        let mut folder = Self { made: Vec::new() };
        while let Some(next) = missing.pop() {
            let mut list = pending();
            match std::fs::create_dir(next) {
                Ok(()) => {
                    list.folders.push(next.to_path_buf());
                    folder.made.push(next.to_path_buf());
                }
                // Another process was faster, or `a/../b` has come into being with `a`.
                Err(_) if next.is_dir() => {}
                Err(e) => {
                    drop(list);
                    return Err(e);
                }
            }
        }
        Ok(folder)
    }

    /// Leaves the folder in place for good.
    pub fn keep(mut self) {
        let made = std::mem::take(&mut self.made);
        pending().folders.retain(|f| !made.contains(f));
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        let mut list = pending();
        for folder in self.made.iter().rev() {
            let _ = std::fs::remove_dir(folder);
        }
        list.folders.retain(|f| !self.made.contains(f));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_folders_go_unless_they_are_kept_or_used() {
        let root = tempfile::tempdir().unwrap();
        let deep = root.path().join("a/b");
        drop(OutputFolder::create(&deep).unwrap());
        assert!(!root.path().join("a").exists());
        OutputFolder::create(&deep).unwrap().keep();
        assert!(deep.is_dir());
        let used = root.path().join("c");
        let folder = OutputFolder::create(&used).unwrap();
        std::fs::write(used.join("file"), "x").unwrap();
        drop(folder);
        assert!(used.join("file").exists());
        drop(OutputFolder::create(&deep).unwrap());
        assert!(deep.is_dir(), "a folder that was there before stays");
        assert!(OutputFolder::create(&used.join("file")).is_err());
        assert!(OutputFolder::create(&used.join("file/d")).is_err());
    }
}
