//! A file of lines that grows during a run, under another name until it is whole.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::files::check_regular;
use super::lock::OutputLock;
use super::writing::{check_output, destination, sync_folder};
use crate::error::{Error, Result};

/// Writes lines to the file `OUTPUT.part` as they come, and renames it to `OUTPUT` at the end. A
/// run that ends early leaves the old `OUTPUT` whole, and a part that the next one may continue.
#[derive(Debug)]
pub struct GrowingFile {
    output: PathBuf,
    part: PathBuf,
    origin: Origin,
    /// Opened at the first line: nothing is touched before.
    file: Option<File>,
    /// Length of all whole lines \[bytes\].
    length: u64,
    _locks: [OutputLock; 2],
}

/// Contents with which the part begins.
#[derive(Debug)]
enum Origin {
    Nothing,
    Part,
    Output,
}

impl GrowingFile {
    /// Begins an empty file; `what` and `is_own` are those of [`check_output`].
    ///
    /// # Errors
    /// [`Error::Write`] if `OUTPUT` or `OUTPUT.part` is of another kind, or if another run writes
    /// it.
    pub fn begin(output: &Path, what: &str, is_own: fn(&[u8]) -> bool) -> Result<Self> {
        check_output(output, what, is_own)?;
        let growing = Self::held(output)?;
        check_output(&growing.part, what, is_own)?;
        Ok(growing)
    }

    /// Continues the part that an earlier run left, or else its output. `line` is given each whole
    /// line and returns what is wrong with it. Half a line at the end is left out.
    ///
    /// # Errors
    /// As [`GrowingFile::begin`], and [`Error::Read`] with the problem that `line` returns.
    pub fn resume(
        output: &Path,
        what: &str,
        is_own: fn(&[u8]) -> bool,
        line: impl FnMut(&[u8]) -> std::result::Result<(), String>,
    ) -> Result<Self> {
        let mut growing = Self::held(output)?;
        check_output(output, what, is_own)?;
        check_output(&growing.part, what, is_own)?;
        let source = if growing.part.exists() {
            growing.origin = Origin::Part;
            growing.part.clone()
        } else if output.exists() {
            growing.origin = Origin::Output;
            output.to_path_buf()
        } else {
            return Ok(growing);
        };
        growing.length = whole_lines(&source, line).map_err(|error| Error::Read { path: source, source: error })?;
        Ok(growing)
    }

    fn held(output: &Path) -> Result<Self> {
        let in_words = |source| Error::Write { path: output.into(), source };
        // A link stays one, and its target may be in another file system.
        let target = if output.is_symlink() { destination(output).map_err(in_words)?.1 } else { output.to_path_buf() };
        let mut part = target.clone().into_os_string();
        part.push(".part");
        let part = PathBuf::from(part);
        let locks = [OutputLock::take(output)?, OutputLock::take(&part)?];
        Ok(Self { output: target, part, origin: Origin::Nothing, file: None, length: 0, _locks: locks })
    }

    /// Path of the file that holds the lines until the end.
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Adds a line, which the system has when this returns.
    ///
    /// # Errors
    /// [`Error::Write`]; the lines before it stay.
    pub fn line(&mut self, text: &str) -> Result<()> {
        let written = self.opened().and_then(|file| file.write_all(format!("{text}\n").as_bytes()));
        if written.is_err() {
            self.cut();
        } else {
            self.length += text.len() as u64 + 1;
        }
        written.map_err(|source| Error::Write { path: self.part.clone(), source })
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// [`Error::Write`]; the old file is then untouched.
    pub fn finish(mut self) -> Result<()> {
        let mut place = || {
            self.opened()?.sync_all()?;
            // Systems other than Unix may refuse to rename an open file.
            self.file = None;
            fs::rename(&self.part, &self.output)?;
            sync_folder(&destination(&self.output)?.0)
        };
        let placed = place();
        placed.map_err(|source| Error::Write { path: self.output.clone(), source })
    }

    fn opened(&mut self) -> io::Result<&mut File> {
        if self.file.is_none() {
            if matches!(self.origin, Origin::Output) {
                let copied = fs::copy(&self.output, &self.part);
                copied.inspect_err(|_| drop(fs::remove_file(&self.part)))?;
            }
            let mut file = OpenOptions::new().create(true).truncate(false).write(true).open(&self.part)?;
            file.set_len(self.length)?;
            file.seek(SeekFrom::End(0))?;
            self.file = Some(file);
        }
        self.file.as_mut().ok_or_else(|| io::Error::other("it is not open"))
    }

    /// Removes half a line, or a file without lines.
    fn cut(&mut self) {
        if self.length == 0 {
            self.file = None;
            let _ = fs::remove_file(&self.part);
        } else if let Some(file) = &mut self.file {
            let _ = file.set_len(self.length).and_then(|()| file.seek(SeekFrom::End(0)));
        }
    }
}

/// Returns the length of a file up to the end of its last whole line \[bytes\].
fn whole_lines(path: &Path, mut line: impl FnMut(&[u8]) -> std::result::Result<(), String>) -> io::Result<u64> {
    check_regular(path)?;
    let (mut reader, mut text, mut length) = (BufReader::new(File::open(path)?), Vec::new(), 0);
    loop {
        text.clear();
        let read = reader.read_until(b'\n', &mut text)?;
        if text.last() != Some(&b'\n') {
            return Ok(length);
        }
        line(&text).map_err(|problem| io::Error::new(ErrorKind::InvalidData, problem))?;
        length += read as u64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHAT: &str = "file of letters";

    fn is_own(head: &[u8]) -> bool {
        head.starts_with(b"letter")
    }

    fn begun(path: &Path) -> GrowingFile {
        GrowingFile::begin(path, WHAT, is_own).unwrap()
    }

    #[test]
    fn the_old_file_stays_until_the_new_one_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let (path, part) = (folder.path().join("out"), folder.path().join("out.part"));
        fs::write(&path, "letter z\n").unwrap();
        let mut growing = begun(&path);
        assert!(!part.exists(), "nothing is touched before the first line");
        growing.line("letter a").unwrap();
        assert_eq!(fs::read(&part).unwrap(), b"letter a\n", "a line is there when it was added");
        let held = GrowingFile::begin(&path, WHAT, is_own).unwrap_err().to_string();
        assert!(held.contains("another run writes it"), "{held}");
        drop(growing);
        assert_eq!(fs::read(&path).unwrap(), b"letter z\n");
        // The part is continued from its last whole line.
        fs::write(&part, "letter a\nletter b\nlett").unwrap();
        let mut lines = 0;
        let count = |_: &[u8]| {
            lines += 1;
            Ok(())
        };
        let mut growing = GrowingFile::resume(&path, WHAT, is_own, count).unwrap();
        growing.line("letter c").unwrap();
        growing.finish().unwrap();
        assert_eq!((lines, fs::read(&path).unwrap()), (2, b"letter a\nletter b\nletter c\n".to_vec()));
        // Without a part, the output is continued.
        let mut growing = GrowingFile::resume(&path, WHAT, is_own, |_| Ok(())).unwrap();
        growing.line("letter d").unwrap();
        growing.finish().unwrap();
        assert!(fs::read(&path).unwrap().ends_with(b"c\nletter d\n"));
        begun(&path).finish().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
    }

    #[test]
    fn files_of_another_kind_stay_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let (path, part) = (folder.path().join("out"), folder.path().join("out.part"));
        fs::write(&path, "precious").unwrap();
        let refused = GrowingFile::begin(&path, WHAT, is_own).unwrap_err().to_string();
        assert!(refused.contains("exists and is no file of letters"), "{refused}");
        let wrong = |_: &[u8]| Err("expected a letter".to_string());
        // A foreign file is refused with a whole line and without one.
        for foreign in ["precious", "precious\n"] {
            fs::write(&path, foreign).unwrap();
            let refused = GrowingFile::resume(&path, WHAT, is_own, |_| Ok(())).unwrap_err().to_string();
            assert!(refused.contains("out: it exists and is no file of letters"), "{refused}");
            assert_eq!(fs::read_to_string(&path).unwrap(), foreign);
        }
        fs::write(&path, "letter a\n").unwrap();
        let refused = GrowingFile::resume(&path, WHAT, is_own, wrong).unwrap_err().to_string();
        assert!(refused.contains("out: expected a letter"), "{refused}");
        fs::remove_file(&path).unwrap();
        fs::write(&part, "precious\n").unwrap();
        let refused = GrowingFile::begin(&path, WHAT, is_own).unwrap_err().to_string();
        assert!(refused.contains("out.part: it exists"), "{refused}");
        let refused = GrowingFile::resume(&path, WHAT, is_own, wrong).unwrap_err().to_string();
        assert!(refused.contains("out.part: it exists"), "{refused}");
        assert_eq!(fs::read(&part).unwrap(), b"precious\n");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("far")).unwrap();
        fs::write(path("far/out"), "letter z\n").unwrap();
        std::os::unix::fs::symlink(path("far/out"), path("link")).unwrap();
        let mut growing = begun(&path("link"));
        growing.line("letter a").unwrap();
        growing.finish().unwrap();
        assert!(path("link").is_symlink());
        assert_eq!(fs::read(path("far/out")).unwrap(), b"letter a\n");
    }
}
