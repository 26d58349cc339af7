//! Unsafe code stands here only where a name is exported, and nowhere else in the workspace.

use std::path::{Path, PathBuf};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn only_exported_names_are_unsafe() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    sources(&own, &mut found);
    assert!(found.len() >= 4, "{found:?}");
    for path in found {
        let text = std::fs::read_to_string(&path).unwrap();
        for (number, line) in text.lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default().trim();
            // `unsafe_code` is the name of the lint.
            let rest = code.replace("#[unsafe(no_mangle)]", "").replace("unsafe_code", "");
            assert!(!rest.contains("unsafe"), "{}:{}: {line}", path.display(), number + 1);
        }
    }
}

#[test]
fn no_other_crate_has_any() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut found = Vec::new();
    for entry in std::fs::read_dir(crates).unwrap() {
        let path = entry.unwrap().path();
        if path.file_name().is_some_and(|name| name != "web") && path.join("src").is_dir() {
            sources(&path.join("src"), &mut found);
        }
    }
    assert!(found.len() > 50);
    for path in found {
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(!text.contains("unsafe {") && !text.contains("unsafe fn") && !text.contains("unsafe impl"), "{path:?}");
    }
}
