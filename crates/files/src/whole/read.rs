//! Ordinary files read whole, refused with a reason.

use std::io::Read;
use std::path::Path;

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
    check_ordinary(path)?;
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(|e| reason(&e))?;
    file.take(limit + 1).read_to_end(&mut bytes).map_err(|e| reason(&e))?;
    if bytes.len() as u64 > limit {
        return Err(format!("it has more than {limit} bytes"));
    }
    Ok(bytes)
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
