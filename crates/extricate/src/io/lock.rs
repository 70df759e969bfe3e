//! Allows one writer for each output, by a lock that lasts as long as a run.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use super::writing::{destination, hidden_name, remove_unfinished};
use crate::error::{Error, Result};

/// Holds an output for one run. The system releases it when the program ends, however it does.
#[derive(Debug)]
pub struct OutputLock {
    path: PathBuf,
    _file: File,
}

impl OutputLock {
    /// Takes the lock of the file that a run will write at `output`, and removes unfinished files
    /// that killed runs left there.
    ///
    /// # Errors
    /// [`Error::Write`] if another run has it, or if no file can be made.
    pub fn take(output: &Path) -> Result<Self> {
        let take = || {
            let (folder, target) = destination(output)?;
            let name = hidden_name(&target);
            let path = folder.join(format!("{name}.lock"));
            let file = loop {
                let file = OpenOptions::new().create(true).truncate(false).write(true).open(&path)?;
                file.try_lock().map_err(|error| match error {
                    TryLockError::WouldBlock => {
                        io::Error::other("another run writes it, expected an output of its own")
                    }
                    TryLockError::Error(error) => error,
                })?;
                // The run that had the lock may have removed the file in between.
                if is_at(&file, &path) {
                    break file;
                }
            };
            remove_unfinished(&folder, |found| found == name);
            Ok(Self { path, _file: file })
        };
        take().map_err(|source| Error::Write { path: output.into(), source })
    }

    /// Removes unfinished files of killed runs from a folder that only this output has.
    pub fn clear(&self, folder: &Path) {
        let prefix = hidden_name(Path::new(""));
        remove_unfinished(folder, |found| found.starts_with(&prefix));
    }
}

impl Drop for OutputLock {
    fn drop(&mut self) {
        // A lock file that stays is empty, and the next run takes it.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |found: fs::Metadata| (found.dev(), found.ino());
    matches!((file.metadata().map(place), fs::metadata(path).map(place)), (Ok(a), Ok(b)) if a == b)
}

/// On systems other than Unix, open files cannot be removed.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_run_has_an_output_and_what_was_left_unfinished_goes() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let (left, of_another) = (at(".extricate-a.model-Ab3xYz"), at(".extricate-a.model-2-Ab3xYz"));
        [&left, &of_another].iter().for_each(|path| fs::write(path, b"half").unwrap());
        let lock = OutputLock::take(&at("a.model")).unwrap();
        assert!(!left.exists() && of_another.exists());
        let message = OutputLock::take(&at("a.model")).unwrap_err().to_string();
        assert!(message.contains("another run writes it"), "{message}");
        OutputLock::take(&at("b.model")).unwrap();
        drop(lock);
        OutputLock::take(&at("a.model")).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
