//! Whole files or none: write beside the name, then rename.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};

use crate::error::{FileError, Stop};

/// Whether a picture could be written to `path`: its folder exists and takes new files, and what is there already, if
/// anything, is a plain file. Asked before a long render, so that the answer does not come after it.
pub fn check_output(path: &Path) -> Result<(), FileError> {
    let target = resolve(path)?;
    temporary_beside(&target).map(drop).map_err(|source| FileError::write(path, source))
}

/// Writes `bytes` as the file at `path`, whole or not at all.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    write_whole(path, &|| false, |out| out.write_all(bytes))
}

/// Runs `fill` on a temporary file in the folder of `path` and, when it succeeds, renames that to `path`.
///
/// On any failure, and when `stop` says so, the temporary file is removed and whatever was at `path` is untouched. The
/// data reach the disk before the rename: a power cut leaves the old file or the new one, not an empty one.
pub fn write_whole(
    path: &Path,
    stop: Stop<'_>,
    fill: impl FnOnce(&mut Stoppable<'_, &File>) -> io::Result<()>,
) -> Result<(), FileError> {
    let target = resolve(path)?;
    let fail = |source| FileError::write(path, source);
    let temporary = temporary_beside(&target).map_err(fail)?;
    let mut out = Stoppable { inner: temporary.as_file(), stop, stopped: false, failed: None };
    let filled = fill(&mut out);
    if out.stopped || stop() {
        return Err(FileError::Cancelled);
    }
    // Whoever drops a buffer that cannot be written may lose the error: the file says itself whether it is whole.
    out.failed.map_or(Ok(()), Err).and(filled).map_err(fail)?;
    temporary.as_file().sync_all().map_err(fail)?;
    if let Ok(old) = fs::metadata(&target) {
        // Somebody who narrowed or widened the old file's rights meant its name, not its bytes.
        temporary.as_file().set_permissions(old.permissions()).map_err(fail)?;
    }
    temporary.persist(&target).map(drop).map_err(|e| fail(e.error))
}

/// The file that is really meant: links are followed, so that a rename does not replace the link itself.
fn resolve(path: &Path) -> Result<PathBuf, FileError> {
    let fail = |kind, message: String| Err(FileError::write(path, io::Error::new(kind, message)));
    let target = if path.is_symlink() {
        match fs::canonicalize(path) {
            Ok(target) => target,
            Err(_) => return fail(ErrorKind::NotFound, "it is a link to nowhere".into()),
        }
    } else {
        path.to_owned()
    };
    if target.file_name().is_none() {
        return fail(ErrorKind::InvalidInput, "a file name is needed".into());
    }
    match fs::metadata(&target) {
        Ok(found) if found.is_dir() => return fail(ErrorKind::IsADirectory, "it is a folder".into()),
        Ok(found) if !found.is_file() => return fail(ErrorKind::InvalidInput, "it is not a plain file".into()),
        _ => {}
    }
    let folder = folder_of(&target);
    match fs::metadata(folder) {
        Ok(found) if found.is_dir() => Ok(target),
        Ok(_) => fail(ErrorKind::NotADirectory, format!("{} is not a folder", folder.display())),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            fail(ErrorKind::NotFound, format!("the folder {} does not exist", folder.display()))
        }
        Err(error) => fail(error.kind(), format!("the folder {}: {error}", folder.display())),
    }
}

fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// A temporary file in the folder of `target`, removed when dropped.
fn temporary_beside(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".iridesce-").suffix(".part");
    // A temporary file is private by default; a picture gets what the umask leaves, like any new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let folder = folder_of(target);
    builder.tempfile_in(folder).map_err(|error| {
        io::Error::new(error.kind(), format!("the folder {} takes no new file: {error}", folder.display()))
    })
}

/// A writer that fails once `stop` says so, however deep in an encoder it is.
pub struct Stoppable<'a, W> {
    inner: W,
    stop: Stop<'a>,
    stopped: bool,
    failed: Option<io::Error>,
}

impl<W> Stoppable<'_, W> {
    fn ask(&mut self) -> io::Result<()> {
        self.stopped = self.stopped || (self.stop)();
        if self.stopped { Err(io::Error::other("stopped")) } else { Ok(()) }
    }
}

impl<W: Write> Write for Stoppable<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.ask()?;
        // Pieces of 1 MiB: a slow disk does not delay an interrupt by more than one of them.
        let written = self.inner.write(&bytes[..bytes.len().min(1 << 20)]);
        if let Err(error) = &written
            && error.kind() != ErrorKind::Interrupted
            && self.failed.is_none()
        {
            self.failed = Some(match error.raw_os_error() {
                Some(code) => io::Error::from_raw_os_error(code),
                None => io::Error::new(error.kind(), error.to_string()),
            });
        }
        written
    }
    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<W: Seek> Seek for Stoppable<'_, W> {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.inner.seek(to)
    }
}

impl<W: io::Read> io::Read for Stoppable<'_, W> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.inner.read(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    fn names_in(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.png");
        write_whole(&path, &|| false, |out| out.write_all(b"old")).unwrap();
        let error = write_whole(&path, &|| false, |out| {
            out.write_all(b"half of the ne")?;
            Err(io::Error::other("disk full"))
        })
        .unwrap_err();
        assert_eq!(error.to_string(), format!("cannot write {}: disk full", path.display()));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names_in(folder.path()), ["x.png"]);
        write_whole(&path, &|| false, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names_in(folder.path()), ["x.png"]);
    }

    #[test]
    fn stopping_in_the_middle_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.exr");
        let asked = AtomicU32::new(0);
        let stop = || asked.fetch_add(1, Ordering::Relaxed) >= 2;
        let result = write_whole(&path, &stop, |out| out.write_all(&vec![7; 16 << 20]));
        assert!(matches!(result, Err(FileError::Cancelled)), "{result:?}");
        assert!(asked.load(Ordering::Relaxed) <= 4, "the write went on after the stop");
        assert!(names_in(folder.path()).is_empty());
    }

    #[test]
    fn places_that_cannot_take_a_file_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| check_output(path).unwrap_err().to_string();
        let missing = folder.path().join("no").join("x.png");
        assert!(message(&missing).contains("no/x.png") && message(&missing).contains("does not exist"));
        assert!(message(folder.path()).contains("it is a folder"));
        fs::write(folder.path().join("file"), "").unwrap();
        assert!(message(&folder.path().join("file").join("x.png")).contains("is not a folder"));
        assert!(message(Path::new("/")).contains("cannot write /: "));
        check_output(&folder.path().join("x.png")).unwrap();
        assert_eq!(names_in(folder.path()), ["file"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_rights_and_devices_are_respected() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real.png"), folder.path().join("link.png"));
        fs::write(&real, "old").unwrap();
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&real, &link).unwrap();
        write_whole(&link, &|| false, |out| out.write_all(b"new")).unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);
        symlink(folder.path().join("gone"), folder.path().join("dangling")).unwrap();
        assert!(check_output(&folder.path().join("dangling")).unwrap_err().to_string().contains("link to nowhere"));
        assert!(check_output(Path::new("/dev/null")).unwrap_err().to_string().contains("not a plain file"));
        // A new file has the rights any new file has, not those of a private temporary.
        let (plain, ours) = (folder.path().join("plain"), folder.path().join("ours"));
        fs::write(&plain, "").unwrap();
        write_whole(&ours, &|| false, |_| Ok(())).unwrap();
        assert_eq!(fs::metadata(&ours).unwrap().permissions(), fs::metadata(&plain).unwrap().permissions());
    }
}
