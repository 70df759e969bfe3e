//! Writes whole files, of whatever format.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result, shown};

/// Bytes of an output's name that the names of files beside it take over: systems allow 255.
const KEPT_NAME_BYTES: usize = 100;

/// Bytes at the beginning of a file that identify its kind.
pub const HEAD_BYTES: u64 = 4096;

/// Checks that a file of the kind `what` can be written at `path`. One that exists has to be empty,
/// or to begin with bytes that `is_own` accepts. Removes unfinished files of killed runs there, so
/// that even a run that fails later has done so.
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
                File::open(path)?.take(HEAD_BYTES).read_to_end(&mut head)?;
                if !head.is_empty() && !is_own(&head) {
                    let problem = format!("it exists and is no {what}, expected a new name or a {what} to replace");
                    return Err(io::Error::other(problem));
                }
            }
            Err(_) => {}
        }
        let (folder, target) = destination(path)?;
        if !folder.is_dir() {
            return Err(io::Error::other(format!("there is no directory {}", shown(&folder))));
        }
        let hidden = hidden_name(&target);
        remove_unfinished(&folder, |found| found == hidden);
        temporary(&folder, &target).map(drop)
    };
    check().map_err(|source| Error::Write { path: path.into(), source })
}

/// Refuses an output that the same run also reads, because it would be lost.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn check_not_read<'a>(output: &Path, inputs: impl IntoIterator<Item = &'a Path>) -> Result<()> {
    if inputs.into_iter().any(|input| is_same_output(output, input)) {
        let source = io::Error::other("the same command reads it, expected another file");
        return Err(Error::Write { path: output.into(), source });
    }
    Ok(())
}

/// Writes a file: a reader sees the old one or the whole new one. A symbolic link stays one, and
/// its target is replaced. Unfinished files of killed runs there are removed.
///
/// # Errors
/// [`crate::Error::Write`]; the old file, if any, is then untouched.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<()> {
    write_together(&[(path.to_path_buf(), bytes)])
}

/// Writes files that belong together, each as [`write_atomically`] does. All are on the disk before
/// the first takes its place: if one cannot be written, none is. Whoever writes several holds an
/// [`OutputLock`](super::OutputLock): systems limit the number of open files, so these are not
/// locked one by one.
///
/// # Errors
/// [`crate::Error::Write`] for the first that cannot be written.
pub fn write_together(files: &[(PathBuf, impl AsRef<[u8]>)]) -> Result<()> {
    let in_words = |path: &Path, error: &io::Error| Error::Write { path: path.into(), source: without_name(error) };
    let mut hidden: BTreeMap<PathBuf, Vec<String>> = BTreeMap::new();
    for (path, _) in files {
        let (folder, target) = destination(path).map_err(|error| in_words(path, &error))?;
        hidden.entry(folder).or_default().push(hidden_name(&target));
    }
    for (folder, names) in &mut hidden {
        names.sort_unstable();
        remove_unfinished(folder, |found| names.binary_search_by(|name| name.as_str().cmp(found)).is_ok());
    }
    let is_alone = files.len() == 1;
    let unfinished = |(path, bytes): &(PathBuf, _)| unfinished(path, AsRef::<[u8]>::as_ref(bytes), is_alone);
    let written = files.iter().map(|file| unfinished(file).map_err(|error| in_words(&file.0, &error)));
    let written: Vec<Unfinished> = written.collect::<Result<_>>()?;
    for ((path, _), Unfinished { file, folder, target, held: _held }) in files.iter().zip(written) {
        let place = || file.persist(target).map_err(|error| error.error).and_then(|()| sync_folder(&folder));
        place().map_err(|error| in_words(path, &error))?;
    }
    Ok(())
}

/// A complete file, beside that which it replaces.
struct Unfinished {
    /// Temporary file, removed if it is not renamed to `target`.
    file: tempfile::TempPath,
    folder: PathBuf,
    target: PathBuf,
    /// Keeps the lock of the file, which ends when it is closed.
    held: Option<File>,
}

fn unfinished(path: &Path, bytes: &[u8], is_alone: bool) -> io::Result<Unfinished> {
    let (folder, target) = destination(path)?;
    let mut file = temporary(&folder, &target)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    let (open, file) = file.into_parts();
    Ok(Unfinished { file, folder, target, held: is_alone.then_some(open) })
}

/// Returns the folder in which a file is written, and its path there, after links.
pub fn destination(path: &Path) -> io::Result<(PathBuf, PathBuf)> {
    let target = if path.exists() { path.canonicalize()? } else { path.to_path_buf() };
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Ok((folder.to_path_buf(), target))
}

/// Whether writing at two paths ends in one file, which need not exist.
pub fn is_same_output(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let (folder, target) = destination(path).ok()?;
        Some((folder.canonicalize().ok()?, target.file_name()?.to_owned()))
    };
    matches!((place(a), place(b)), (Some(a), Some(b)) if a == b)
}

/// Returns the prefix of names of files that exist while `path` is written.
pub fn hidden_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let least = name.len().saturating_sub(KEPT_NAME_BYTES);
    let start = (least..=name.len()).find(|at| name.is_char_boundary(*at)).unwrap_or_default();
    format!(".extricate-{}", &name[start..])
}

/// Makes a temporary file beside `path`, which is to be renamed to it. If the run is killed it
/// stays, until the next run that writes there removes it. A lock while it is open marks living
/// runs.
pub fn temporary(folder: &Path, path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let prefix = format!("{}-", hidden_name(path));
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix);
    // Temporary files are private by default; this becomes as public as the user's other files.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let explain =
        |error: io::Error| io::Error::new(error.kind(), format!("cannot create a file there ({})", cause(&error)));
    loop {
        let file = builder.tempfile_in(folder).map_err(explain)?;
        // Another run may clean up just before the lock is taken, and take the file for an
        // abandoned one. Some file systems lock nothing; there nothing is removed either.
        let is_taken = matches!(file.as_file().try_lock(), Err(TryLockError::WouldBlock));
        if !is_taken && file.path().exists() {
            return Ok(file);
        }
    }
}

/// Removes unfinished files of killed runs from a folder, of outputs whose [`hidden_name`] `is_of`
/// accepts. Files of living runs stay, because they are locked.
pub fn remove_unfinished(folder: &Path, is_of: impl Fn(&str) -> bool) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_unfinished = entry.file_name().to_str().and_then(hidden_part).is_some_and(&is_of);
        // A pipe would not open until somebody reads it.
        if is_unfinished
            && entry.file_type().is_ok_and(|kind| kind.is_file())
            && let Ok(file) = OpenOptions::new().write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Returns the name of a temporary file without its random end.
fn hidden_part(name: &str) -> Option<&str> {
    let (hidden, random) = name.rsplit_once('-')?;
    (random.len() == 6 && random.bytes().all(|b| b.is_ascii_alphanumeric())).then_some(hidden)
}

/// Syncs a folder, which keeps the names of its files. Otherwise a power cut may lose the new
/// model, and the old one too.
#[cfg(unix)]
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    match File::open(folder)?.sync_all() {
        // Some file systems cannot sync folders.
        Err(error) if error.kind() == ErrorKind::InvalidInput => Ok(()),
        done => done,
    }
}

/// On other systems folders cannot be opened, and the system keeps them.
#[cfg(not(unix))]
pub fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

fn without_name(error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), cause(error))
}

/// Returns the message without the name of the temporary file, which no user knows.
pub fn cause(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" at path ").next().unwrap_or(&text).to_string()
}
