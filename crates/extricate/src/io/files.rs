//! Reads whole files, of whatever format.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use crate::error::{Error, Result};
use crate::robot::{LoadLimit, LoadLimits};

/// Largest model or roadmap that is read: a larger file is something else, such as a disk image.
const MAX_FILE_BYTES: usize = 2 << 30;

pub fn read(path: &Path) -> Result<Vec<u8>> {
    let too_large = |_| format!("it is larger than {MAX_FILE_BYTES} bytes");
    read_at_most(path, MAX_FILE_BYTES, too_large).map_err(|source| Error::Read { path: path.into(), source })
}

/// As [`read`], for a file of at most the size that a limit allows.
pub fn read_within(path: &Path, limits: &LoadLimits, limit: LoadLimit) -> Result<Vec<u8>> {
    let too_large = |length| limits.exceeded(limit, length);
    read_at_most(path, limits.get(limit), too_large).map_err(|source| Error::Read { path: path.into(), source })
}

/// Returns a reader of the files that scenes name.
pub fn reader(limits: &LoadLimits) -> impl FnMut(&Path) -> Result<Vec<u8>> + '_ {
    |path| read_within(path, limits, LoadLimit::FileBytes)
}

fn read_at_most(path: &Path, most: usize, too_large: impl Fn(usize) -> String) -> io::Result<Vec<u8>> {
    let refused = |length: u64| {
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        Err(io::Error::new(ErrorKind::FileTooLarge, too_large(length)))
    };
    let length = check_regular(path)?;
    if length > most as u64 {
        return refused(length);
    }
    let mut bytes = Vec::with_capacity(length as usize);
    // The file may have grown, and some systems report no length of some files.
    File::open(path)?.take((most as u64).saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() > most {
        return refused(bytes.len() as u64);
    }
    Ok(bytes)
}

/// Returns the length of a file \[bytes\]. Devices may have no end, and pipes may never begin.
///
/// # Errors
/// If it is neither a file nor a link to one.
pub fn check_regular(path: &Path) -> io::Result<u64> {
    let found = fs::metadata(path)?;
    let (kind, what) = if found.is_file() {
        return Ok(found.len());
    } else if found.is_dir() {
        (ErrorKind::IsADirectory, "a directory")
    } else {
        (ErrorKind::InvalidInput, "a device or a pipe")
    };
    Err(io::Error::new(kind, format!("it is {what}, expected a file")))
}
