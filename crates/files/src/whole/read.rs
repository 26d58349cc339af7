//! Ordinary files read whole, refused with a reason.

use std::io::Read;
use std::path::Path;

use iridesce_numerics::Watch;

/// Bytes between two looks at the watch: a slow disk does not delay an interrupt by more than one of them.
const PIECE: usize = 1 << 20;

/// Why a file cannot be read as an ordinary one, if it cannot.
pub fn check_ordinary(path: &Path) -> Result<(), String> {
    // Asked before opening: a named pipe would wait for ever, a device may have no end.
    let metadata = std::fs::metadata(path).map_err(|e| reason(&e))?;
    if metadata.is_dir() {
        return Err("it is a folder".into());
    }
    if !metadata.is_file() {
        return Err("it is no ordinary file".into());
    }
    Ok(())
}

/// The bytes of an ordinary file of at most `limit` bytes, or why there are none.
pub fn read_whole(path: &Path, limit: u64) -> Result<Vec<u8>, String> {
    read_whole_watched(path, limit, &Watch::new())
}

/// The same, ended by a watch that says so.
pub fn read_whole_watched(path: &Path, limit: u64, watch: &Watch) -> Result<Vec<u8>, String> {
    check_ordinary(path)?;
    let metadata = std::fs::metadata(path).map_err(|e| reason(&e))?;
    let too_long = || match limit % (1 << 20) {
        0 if limit > 0 => format!("it is longer than {} MiB", limit >> 20),
        _ => format!("it has more than {limit} bytes"),
    };
    if metadata.len() > limit {
        return Err(too_long());
    }
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(metadata.len() as usize)
        .map_err(|_| format!("its {} bytes need more memory than this process can have", metadata.len()))?;
    let mut file = std::fs::File::open(path).map_err(|e| reason(&e))?;
    loop {
        watch.check().map_err(|stopped| stopped.to_string())?;
        // A file may grow while it is read, and those of /proc say that they are empty.
        let got = file.by_ref().take(PIECE as u64).read_to_end(&mut bytes).map_err(|e| reason(&e))?;
        if bytes.len() as u64 > limit {
            return Err(too_long());
        }
        if got == 0 {
            return Ok(bytes);
        }
    }
}

/// The system's reason without its error number.
pub fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        _ => {
            let text = error.to_string();
            text.split(" (os error").next().unwrap_or(&text).to_lowercase()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_ordinary_files_within_the_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        std::fs::write(&path, b"12345").unwrap();
        assert_eq!(read_whole(&path, 5).unwrap(), b"12345");
        assert_eq!(read_whole(&path, 4).unwrap_err(), "it has more than 4 bytes");
        assert_eq!(read_whole(folder.path(), 5).unwrap_err(), "it is a folder");
        assert_eq!(read_whole(&folder.path().join("y"), 5).unwrap_err(), "there is no such file");
        let watch = Watch::new();
        watch.stop();
        assert_eq!(read_whole_watched(&path, 5, &watch).unwrap_err(), "stopped");
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_links_to_them_are_refused_before_they_are_opened() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("endless");
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        assert_eq!(read_whole(&link, 5).unwrap_err(), "it is no ordinary file");
    }
}
