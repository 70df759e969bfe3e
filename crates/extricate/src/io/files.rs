//! Reading and writing of whole files. Knows no format.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Largest file that is read \[bytes\]: beyond it something else was meant, a disk image or a
/// device without end.
const LARGEST: u64 = 2 << 30;

/// How much of a file is looked at to tell what it is \[bytes\].
pub const HEAD: u64 = 4096;

pub fn read(path: &Path) -> Result<Vec<u8>> {
    read_at_most(path, LARGEST).map_err(|source| Error::Read { path: path.into(), source })
}

pub fn read_at_most(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let mut bytes = Vec::with_capacity(file.metadata()?.len().min(most) as usize);
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(io::Error::new(ErrorKind::FileTooLarge, format!("it is larger than {most} bytes")));
    }
    Ok(bytes)
}

/// Whether a file of the kind `what` can be written at `path`; one that is there already has to be
/// empty, or to begin with bytes that `is_own` takes for its kind.
///
/// # Errors
/// [`crate::Error::Write`], see [`crate::io::check_model_output`].
pub fn check_output(path: &Path, what: &str, is_own: fn(&[u8]) -> bool) -> Result<()> {
    let check = || {
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(io::Error::other("it is a directory, expected a file name")),
            Ok(found) if !found.is_file() => return Err(io::Error::other("it is a device, expected a file name")),
            Ok(_) => {
                let mut head = Vec::new();
                File::open(path)?.take(HEAD).read_to_end(&mut head)?;
                if !head.is_empty() && !is_own(&head) {
                    let problem = format!("it exists and is no {what}, expected a new name or a {what} to replace");
                    return Err(io::Error::other(problem));
                }
            }
            Err(_) => {}
        }
        let (folder, _) = destination(path)?;
        if !folder.is_dir() {
            return Err(io::Error::other(format!("there is no directory {}", folder.display())));
        }
        temporary(&folder).map(drop)
    };
    check().map_err(|source| Error::Write { path: path.into(), source })
}

/// Writes a file: a reader sees the old one or the whole new one. A symbolic link stays one, its
/// target is replaced.
///
/// # Errors
/// [`crate::Error::Write`]; the old file, if any, is then untouched.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<()> {
    let write = || {
        let (folder, target) = destination(path)?;
        let mut file = temporary(&folder)?;
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
        file.persist(target).map(drop).map_err(|error| error.error)
    };
    write().map_err(|source| Error::Write { path: path.into(), source })
}

/// The folder that a file is written in, and the path there.
pub fn destination(path: &Path) -> io::Result<(PathBuf, PathBuf)> {
    let target = if path.exists() { path.canonicalize()? } else { path.to_path_buf() };
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Ok((folder.to_path_buf(), target))
}

pub fn temporary(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".extricate-");
    // Temporary files are private to their owner; what becomes of this one is as public as the
    // user's other files.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let explain =
        |error: io::Error| io::Error::new(error.kind(), format!("cannot create a file there ({})", cause(&error)));
    builder.tempfile_in(folder).map_err(explain)
}

/// Without the name of the temporary file, which nobody knows.
pub fn cause(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" at path ").next().unwrap_or(&text).to_string()
}
