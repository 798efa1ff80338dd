//! Every slug has a file that provokes it, at the place that the file's first line states.

use std::fs;
use std::path::{Path, PathBuf};

use hydrocrane_machine::{load, load_scenario, MachineError, ERROR_SLUGS};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/bad")
}

fn error_of(path: &Path) -> MachineError {
    let source = path.display().to_string();
    let is_scenario = String::from_utf8_lossy(&fs::read(path).unwrap()).contains("[scenario]");
    let error = if is_scenario { load_scenario(&source, &[]).err() } else { load(&source, &[]).err() };
    error.unwrap_or_else(|| panic!("{source} was accepted"))
}

/// `# line 7, column 12`
fn expected_place(path: &Path) -> (usize, usize) {
    let bytes = fs::read(path).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    let numbers: Vec<usize> = text
        .lines()
        .next()
        .unwrap()
        .split(|c: char| !c.is_ascii_digit())
        .filter_map(|word| word.parse().ok())
        .collect();
    (numbers[0], numbers[1])
}

#[test]
fn each_bad_file_yields_its_slug_at_its_place() {
    for slug in ERROR_SLUGS {
        let path = folder().join(format!("{slug}.toml"));
        let error = error_of(&path);
        assert_eq!(error.slug(), *slug, "{error}");
        assert_eq!((error.line(), error.column()), unzip(expected_place(&path)), "{error}");
        assert!(error.cure().is_some(), "no cure: {error}");
        assert!(error.file().unwrap().ends_with(&format!("{slug}.toml")), "{error}");
    }
}

fn unzip((line, column): (usize, usize)) -> (Option<usize>, Option<usize>) {
    (Some(line), Some(column))
}

#[test]
fn no_bad_file_lacks_a_slug() {
    for entry in fs::read_dir(folder()).unwrap() {
        let stem = entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned();
        assert!(ERROR_SLUGS.contains(&stem.as_str()), "no slug `{stem}`");
    }
}

#[test]
fn the_message_shows_place_key_cure_and_line() {
    let error = error_of(&folder().join("unknown-key.toml"));
    let shown = error.to_string();
    let lines: Vec<&str> = shown.lines().collect();
    assert!(
        lines[0].ends_with("unknown-key.toml:7:1: [unknown-key] cylinder.test.boar: unknown key; did you mean `bore`?")
    );
    assert_eq!(lines[1], "7 | boar = \"50 mm\"");
    assert_eq!(lines[2], "  | ^^^^");
}

#[test]
fn a_wrong_bundled_name_lists_the_names() {
    let error = load("rottne-f9-lap", &[]).unwrap_err();
    assert_eq!(error.slug(), "unknown-source");
    let shown = error.to_string();
    assert!(
        shown.contains(
            "rottne-f9-lab, rottne-f9-pump, rottne-f9-mobile, rottne-f9-ls, rottne-f9-forwarder, heinze-2007, hiab-xs031, sany-sy19e and 3 more"
        ),
        "{shown}"
    );
    assert!(shown.contains("did you mean `rottne-f9-lab`?"), "{shown}");
}

#[test]
fn a_missing_file_and_a_folder_are_unreadable() {
    for source in ["no/such/file.toml", "./"] {
        assert_eq!(load(source, &[]).unwrap_err().slug(), "unreadable-file");
    }
}
