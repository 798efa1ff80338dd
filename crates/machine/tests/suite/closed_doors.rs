//! What a file that somebody sends may not do: carry names that other formats read as something else, or open and show other files.

use std::fs;
use std::path::{Path, PathBuf};

use hydrocrane_machine::{load, load_scenario, parse, parse_scenario_with, MachineError, OverrideValue};

const SECRET: &str = "root:$6$salt$hash:19000:0:99999:7:::";

/// A folder of files of its own, for a test.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str, files: &[(&str, &str)]) -> Self {
        let folder = std::env::temp_dir().join(format!("hydrocrane-doors-{}-{test}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        files.iter().for_each(|(name, text)| fs::write(folder.join(name), text).unwrap());
        Self(folder)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap();
    }
}

fn machine(folder: &Folder, text: &str) -> MachineError {
    fs::write(folder.0.join("mine.toml"), text).unwrap();
    load(&folder.path("mine.toml"), &[]).unwrap_err()
}

fn scenario(folder: &Folder, text: &str) -> MachineError {
    fs::write(folder.0.join("mine.toml"), text).unwrap();
    load_scenario(&folder.path("mine.toml"), &[]).unwrap_err()
}

const HEAD: &str = "[scenario]\nname = \"x\"\nmachine = \"rottne-f9-lab\"\nduration = \"1 s\"\n";

#[test]
fn every_name_has_the_one_rule() {
    let long = "x".repeat(65);
    for name in ["", "a b", "x*/", "../x", "/x", ".x", "con", "[/bold]", "$x$", "=1", "a\u{fffe}", long.as_str()] {
        let change = [("machine.name".to_string(), OverrideValue::Text(name.into()))];
        let of_machine = load("rottne-f9-lab", &change).unwrap_err();
        let change = [("scenario.name".to_string(), OverrideValue::Text(name.into()))];
        let of_scenario = load_scenario("vertical-lift-open-loop", &change).unwrap_err();
        for error in [of_machine, of_scenario] {
            assert!(["bad-name", "not-text"].contains(&error.slug()) && error.cure().is_some(), "{name}: {error}");
        }
    }
    for table in [
        "link.'{}'",
        "link.boom.point.'{}'",
        "joint.'{}'",
        "cylinder.'{}'",
        "valve.'{}'",
        "friction.'{}'",
        "sensor.'{}'",
        "keep-out.'{}'",
        "pump.'{}'",
        "hose-leak.'{}'",
        "link.boom.body.'{}'",
    ] {
        let text = format!("extends = \"rottne-f9-lab\"\n[{}]\n", table.replace("{}", "a*/b"));
        let error = parse(&text, "mine.toml", &[]).unwrap_err();
        assert!(error.slug() == "bad-name" && error.line() == Some(2), "{table}: {error}");
    }
    for table in ["phase", "burst", "sensor-fault"] {
        let text = format!("{HEAD}[controller]\nname = \"tip\"\n[{table}.'a*/b']\n");
        let error = parse_scenario_with(&text, "mine.toml", &[]).unwrap_err();
        assert!(error.slug() == "bad-name" && error.line() == Some(7), "{table}: {error}");
    }
}

#[test]
fn titles_are_one_line_and_texts_control_nothing() {
    for (key, text, good) in [
        ("machine.title", "=HYPERLINK(1) [/bold] $\\frac{$ <&> 起重机", true),
        ("machine.title", "a\nb", false),
        ("machine.title", "a\u{1b}[31m", false),
        ("machine.title", "a\u{202e}b", false),
        ("machine.description", "one\n\ttwo", true),
        ("machine.description", "good\rbad", false),
        ("machine.description", "a\u{9b}b", false),
        ("machine.description", "a\u{1ffff}b", false),
    ] {
        let found = load("rottne-f9-lab", &[(key.to_string(), OverrideValue::Text(text.into()))]);
        assert_eq!(found.err().map(|error| error.slug()), (!good).then_some("not-text"), "{key} = {text:?}");
    }
}

#[test]
fn an_error_shows_nothing_of_somebody_elses_file() {
    let netrc = "machine github.com login me password hunter2";
    for (name, secret) in [
        ("shadow", SECRET),
        ("netrc", netrc),
        ("credentials.toml", "token = \"hunter2\"\n[registry]\n"),
        ("config", "[include]\npath = hunter2\n"),
        ("latin", "caf\u{e9} hunter2"),
    ] {
        let folder = Folder::new(&format!("secret-{name}"), &[]);
        let bytes: Vec<u8> = secret.chars().map(|c| c as u8).collect();
        fs::write(folder.0.join(name), bytes).unwrap();
        let path = folder.path(name);
        let own = "extends = \"rottne-f9-lab\"\n";
        for error in [
            machine(&folder, &format!("extends = {path:?}\n")),
            machine(&folder, &format!("{own}include = [{path:?}]\n")),
            machine(&folder, &format!("{own}include = [{name:?}]\n")),
            scenario(&folder, &HEAD.replace("rottne-f9-lab", &path)),
            load(&path.replace(name, &format!("./{name}")), &[]).unwrap_err(),
        ] {
            let shown = error.to_string();
            assert!(!shown.contains("hunter2") && !shown.contains("root:") && error.cure().is_some(), "{shown}");
        }
    }
    // The lines of machine files stay where they help.
    let folder = Folder::new("own", &[("base.toml", "# mine\n[supply]\npressure = 140 bar\n")]);
    assert!(machine(&folder, "extends = \"./base.toml\"\n").to_string().contains("3 | pressure = 140 bar"));
}

#[test]
fn a_log_that_is_none_is_not_shown_either() {
    let folder = Folder::new("log", &[("auth.log", SECRET), ("tame.csv", "tame,lift\n0,1\n")]);
    for table in ["command", "joystick", "supply"] {
        let log = folder.path("auth.log");
        let shown = scenario(&folder, &format!("{HEAD}[{table}]\nlog = {log:?}\n")).to_string();
        assert!(!shown.contains("root:") && shown.contains("no row of numbers"), "{shown}");
        let near = scenario(&folder, &format!("{HEAD}[{table}]\nlog = \"tame.csv\"\n")).to_string();
        assert!(near.contains("did you mean `tame`?"), "{near}");
    }
}

#[test]
fn files_open_regular_files_alone_and_no_network() {
    let folder = Folder::new("places", &[("base.toml", "extends = \"rig-rottne\"\n")]);
    fs::create_dir_all(folder.0.join("sub")).unwrap();
    fs::write(folder.0.join("sub/mine.toml"), "extends = \"../base.toml\"\n").unwrap();
    assert!(load(&folder.path("sub/mine.toml"), &[]).is_ok());
    for path in
        ["\\\\host\\share\\x.toml", "//host/share/x.toml", "\\\\.\\pipe\\x.toml", "\\\\?\\C:\\x.toml", "/\\host/x.csv"]
    {
        for error in [
            machine(&folder, &format!("extends = {path:?}\n")),
            machine(&folder, &format!("extends = \"rig-rottne\"\ninclude = [{path:?}]\n")),
            scenario(&folder, &HEAD.replace("\"rottne-f9-lab\"", &format!("{path:?}"))),
            scenario(&folder, &format!("{HEAD}[command]\nlog = {:?}\n", path.replace("toml", "csv"))),
            scenario(&folder, &format!("{HEAD}[joystick]\nlog = {:?}\n", path.replace("toml", "mat"))),
        ] {
            assert!(error.slug() == "unreadable-file" && error.message().contains("leads into a network"), "{error}");
            assert!(error.line().is_some() && error.cure().is_some(), "{error}");
        }
    }
    assert!(machine(&folder, "extends = \"./\"\n").message().contains("a folder"));
}

#[cfg(unix)]
#[test]
fn a_pipe_does_not_hang() {
    let folder = Folder::new("pipe", &[]);
    let pipe = folder.path("pipe.toml");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    std::os::unix::fs::symlink(&pipe, folder.0.join("link.csv")).unwrap();
    for error in [
        machine(&folder, "extends = \"pipe.toml\"\n"),
        machine(&folder, "extends = \"rig-rottne\"\ninclude = [\"pipe.toml\"]\n"),
        machine(&folder, "extends = \"/dev/zero\"\n"),
        scenario(&folder, &HEAD.replace("rottne-f9-lab", "./pipe.toml")),
        scenario(&folder, &format!("{HEAD}[command]\nlog = \"link.csv\"\n")),
        load(&pipe, &[]).unwrap_err(),
    ] {
        assert!(error.slug() == "unreadable-file" && error.message().contains("a pipe or a device"), "{error}");
    }
}

#[test]
fn files_that_belong_together_have_one_budget() {
    let filler = format!("[machine]\ndescription = \"{}\"\n", "x".repeat(3 << 20));
    let folder = Folder::new("budget", &[("part.toml", &filler)]);
    let including = |times: usize| {
        let parts = vec!["\"part.toml\""; times].join(", ");
        fs::write(folder.0.join("mine.toml"), format!("extends = \"rig-rottne\"\ninclude = [{parts}]\n")).unwrap();
        load(&folder.path("mine.toml"), &[]).err().map(|error| (error.slug(), error.message().to_string()))
    };
    assert_eq!(including(5), None);
    let (slug, message) = including(6).unwrap();
    assert!(slug == "too-large" && message.contains("those that belong to it are longer than 16 MiB"), "{message}");
    // Many small values count as well as many letters.
    let values = format!("[machine]\nx = [{}]\n", "1,".repeat(400_000));
    fs::write(folder.0.join("part.toml"), values).unwrap();
    assert!(including(6).unwrap().1.contains("hold too many values"));
}

#[test]
fn a_text_in_memory_opens_no_path() {
    let folder = Folder::new("memory", &[("drive.csv", "time,lift,x\n0,0,0\n1,0,0\n")]);
    let log = folder.path("drive.csv");
    assert!(Path::new(&log).exists());
    for table in ["command", "joystick", "supply"] {
        let error = parse_scenario_with(&format!("{HEAD}[{table}]\nlog = {log:?}\n"), "x.toml", &[]).unwrap_err();
        assert!(error.message().contains("is not among the files at hand"), "{error}");
    }
    let given = [("drive.csv".to_string(), fs::read_to_string(&log).unwrap())];
    assert!(parse_scenario_with(&format!("{HEAD}[command]\nlog = {log:?}\n"), "x.toml", &given).is_ok());
}
