//! The short form of `make fuzz`, and whether the tool finds what it is to find.

use hydrocrane_evidence::fuzz::parent::{fuzz, Options, Report};
use hydrocrane_evidence::fuzz::{input, Kind};

fn tried(kind: Kind, inputs: u64) -> Report {
    let program = env!("CARGO_BIN_EXE_fuzz").into();
    fuzz(&Options { program, kind, seed: 0, inputs, threads: 2, failures: None })
}

#[test]
fn damaged_files_and_links_are_refused_or_run() {
    for kind in Kind::ALL {
        let report = tried(kind, 120);
        let failures: Vec<String> = report
            .failures
            .iter()
            .map(|f| format!("{} x {}: {} (number {})", f.count, f.class, f.text, f.number))
            .collect();
        assert!(failures.is_empty(), "{}:\n{}", report.kind, failures.join("\n"));
        assert_eq!(report.refused + report.ran, 120);
        // Damage that nothing survives would test the reader alone.
        assert!(report.ran >= 10 && report.refused >= 10, "{} {} {}", report.kind, report.ran, report.refused);
    }
}

#[test]
fn panics_hangs_memory_and_numbers_that_are_none_are_found() {
    let report = tried(Kind::Trial, 5);
    let mut found: Vec<(u64, &str)> = report.failures.iter().map(|f| (f.number, f.class.as_str())).collect();
    found.sort_unstable();
    let memory = if cfg!(unix) { &[(3, "memory")][..] } else { &[] };
    let expected = [&[(1, "panic"), (2, "hang")], memory, &[(4, "wrong")]].concat();
    assert_eq!(found, expected);
    assert_eq!(report.ran, 5 - expected.len() as u64);
}

#[test]
fn a_number_makes_the_same_input_again() {
    for kind in Kind::ALL {
        assert_eq!(input(kind, 3, 17), input(kind, 3, 17));
        assert_ne!(input(kind, 3, 17), input(kind, 4, 17));
    }
}
