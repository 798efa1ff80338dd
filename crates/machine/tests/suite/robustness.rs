//! Damaged files give an error or a machine, never a panic.

use hydrocrane_machine::{
    bundled_machines, bundled_scenarios, load, parse, parse_scenario, MachineError, OverrideValue,
};
use proptest::prelude::*;

fn lab_crane() -> &'static str {
    bundled_machines().iter().find(|(name, _)| *name == "rottne-f9-lab").unwrap().1
}

#[test]
fn truncation_at_any_byte_is_an_error_with_a_place() {
    let text = lab_crane();
    // What comes after the supply may be left out.
    let complete_from = text.find("tank-pressure").unwrap();
    for end in (0..text.len()).filter(|end| text.is_char_boundary(*end)) {
        match parse(&text[..end], "truncated", &[]) {
            Ok(_) => assert!(end > complete_from, "accepted {end} bytes"),
            Err(error) => assert!(error.line().is_some() && !error.to_string().is_empty()),
        }
    }
}

#[test]
fn deep_nesting_is_refused() {
    for text in ["[".repeat(50_000), format!("a = {}", "[".repeat(50_000)), format!("a = {}", "{a=".repeat(50_000))] {
        assert_eq!(parse(&text, "deep", &[]).unwrap_err().slug(), "syntax");
    }
}

fn damaged(text: &'static str) -> impl Strategy<Value = String> {
    let flips = prop::collection::vec((0..text.len(), any::<u8>()), 1..6);
    flips.prop_map(move |flips| {
        let mut bytes = text.as_bytes().to_vec();
        flips.into_iter().for_each(|(at, byte)| bytes[at] = byte);
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// Lines taken out, doubled or moved: valid TOML that says nonsense.
fn shuffled(text: &'static str) -> impl Strategy<Value = String> {
    let lines: Vec<&str> = text.lines().collect();
    let edits = prop::collection::vec((0..lines.len(), 0..lines.len(), 0..3u8), 1..4);
    edits.prop_map(move |edits| {
        let mut lines = lines.clone();
        for (from, to, what) in edits {
            let [from, to] = [from % lines.len(), to % lines.len()];
            match what {
                0 => drop(lines.remove(from)),
                1 => lines.insert(to, lines[from]),
                _ => lines.swap(from, to),
            }
        }
        lines.join("\n")
    })
}

fn any_value() -> impl Strategy<Value = OverrideValue> {
    let leaf = prop_oneof![
        any::<f64>().prop_map(OverrideValue::Number),
        "[ -~]{0,12}".prop_map(OverrideValue::Text),
        any::<bool>().prop_map(OverrideValue::Bool),
    ];
    leaf.prop_recursive(2, 6, 3, |inner| prop::collection::vec(inner, 0..3).prop_map(OverrideValue::List))
}

fn any_key() -> impl Strategy<Value = String> {
    let keys: Vec<String> =
        load("rottne-f9-lab", &[]).unwrap().provenance.iter().map(|entry| entry.key.clone()).collect();
    prop_oneof![prop::sample::select(keys), "[a-z.-]{0,20}"]
}

/// Every error says where it is and what to do.
fn has_cure(error: MachineError) {
    assert!(error.cure().is_some() && error.line().is_some(), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn flipped_bytes_never_panic(text in damaged(lab_crane())) {
        let _ = parse(&text, "damaged", &[]).map_err(has_cure);
    }

    #[test]
    fn shuffled_lines_never_panic(text in shuffled(lab_crane())) {
        let _ = parse(&text, "shuffled", &[]).map_err(has_cure);
    }

    #[test]
    fn damaged_scenarios_never_panic(text in damaged(bundled_scenarios()[0].1)) {
        let _ = parse_scenario(&text, "damaged", &[]).map_err(has_cure);
    }

    #[test]
    fn overrides_never_panic_and_never_let_a_nan_through(key in any_key(), value in any_value()) {
        let loaded = load("rottne-f9-lab", &[(key, value)]);
        if let Err(error) = &loaded {
            prop_assert!(error.cure().is_some(), "{}", error);
        }
        if let Ok(machine) = loaded {
            let shown = format!("{machine:#?}");
            let finite = !shown.lines().any(|line| ["NaN,", "inf,", "-inf,"].contains(&line.trim()));
            prop_assert!(finite, "{}", shown);
        }
    }

    #[test]
    fn random_text_never_panics(text in "\\PC{0,200}") {
        let _ = parse(&text, "random", &[]).map_err(has_cure);
    }
}
