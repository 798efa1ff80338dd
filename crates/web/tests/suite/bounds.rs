//! What a request may ask for, and how much of it an answer quotes.

use crate::common::opened;
use hydrocrane_web::Cockpit;
use serde_json::json;

#[test]
fn a_row_stays_short_however_fine_an_outline_is() {
    let outline: Vec<String> = (0..50_000).map(|i| format!("\"({}, 0.1) m\"", 1e-5 * f64::from(i))).collect();
    let text =
        format!("extends = \"rottne-f9-lab\"\n[link.boom]\nclass = \"assumed\"\noutline = [{}]\n", outline.join(", "));
    let (mut cockpit, description) = opened(json!({ "machine": "mine.toml", "text": text }));
    let corners: u64 =
        description["shapes"].as_array().expect("a list").iter().filter_map(|s| s["points"].as_u64()).sum();
    let signals = description["signals"].as_array().expect("a list").len();
    assert!(corners < 1000 && cockpit.frame().len() == signals + 2 * corners as usize, "{corners}");
}

#[test]
fn what_a_link_asks_for_has_bounds() {
    let machine = |more: &str| format!("extends = \"rottne-f9-lab\"\n[machine]\nclass = \"assumed\"\n{more}");
    let far = "[keep-out.far]\noutline = [\"(0, 0) m\", \"(1e300, 0) m\", \"(0, 1) m\"]\n";
    for (request, word) in [
        (json!({ "machine": "rottne-f9-lab", "friction": 1e300 }), "friction"),
        (json!({ "machine": "rottne-f9-lab", "delay": 1e300 }), "delay"),
        (json!({ "machine": "rottne-f9-lab", "ramp": -1.0 }), "ramp"),
        (json!({ "machine": "rottne-f9-lab", "payload": 1e300 }), "payload"),
        (json!({ "machine": "rottne-f9-lab", "overrides": { "control.period": "1e-9 s" } }), "control.period"),
        (json!({ "machine": "rottne-f9-lab", "overrides": { "link.extension.point.tip": [1e6, 0.0] } }), "tip"),
        (json!({ "machine": "mine.toml", "text": machine(far) }), "keep-out.far.outline"),
        (json!({ "machine": "rottne-f9-lab", "payload": 10.0, "overrides": { "payload.mass": "20 kg" } }), "omit one"),
        (json!({ "machine": "rottne-f9-lab", "overrides": { "control.period": 1e-9 } }), "control.period"),
        (json!({ "machine": "rig-kalmar", "overrides": { "fluid.bulk-modulus-max": 5e-324 } }), "bulk-modulus-max"),
        (json!({ "machine": "rottne-f9-lab", "seed": u64::MAX }), "whole number up to"),
    ] {
        let problem = Cockpit::default().open(&request.to_string()).expect_err("a bounded request");
        assert!(problem.message().contains(word), "{problem:?}");
    }
    let same = json!({ "machine": "rottne-f9-lab", "payload": 20.0, "overrides": { "payload.mass": "20 kg" } });
    assert_eq!(opened(same).1["payload"], 20.0);
}

#[test]
fn what_a_request_quotes_is_shortened() {
    let long = "long ".repeat(60_000);
    for request in [
        json!({ "machine": long }),
        json!({ "machine": "rottne-f9-lab", "controller": long }),
        json!({ "machine": "rottne-f9-lab", "payload": long }),
        json!({ "machine": long, "text": "[machine]\nname = 1\n" }),
        json!({ "machine": "rottne-f9-lab", "overrides": { "friction.lift.model": long } }),
        json!({ "machine": "mine.toml", "text": format!("extends = \"rottne-f9-lab\"\n\"{long}\" = 1\n") }),
    ] {
        let problem = Cockpit::default().open(&request.to_string()).expect_err("a bad request");
        let message = problem.message();
        assert!(message.contains(" ... ") && message.chars().count() < 4000, "{message:.5000}");
    }
}
