//! The signal chain from a command to a spool.

use hydrocrane_machine::model::SignalChain;
use hydrocrane_sim::inputs::command_path::apply_signal_chain;

const IDENTITY: SignalChain =
    SignalChain { offset: 0.0, gain: 1.0, dead_band: 0.0, low: -0.05, high: 0.05, play: 0.0, delay: 0.0 };

#[test]
fn the_identity_changes_nothing() {
    for u in [-0.05, -0.01, 0.0, 0.02] {
        assert_eq!(apply_signal_chain(&IDENTITY, u), u);
    }
}

#[test]
fn dead_band_gain_offset_and_limits_act_in_this_order() {
    let chain =
        SignalChain { offset: 0.001, gain: -2.0, dead_band: 0.003, low: -0.02, high: 0.01, play: 0.0, delay: 0.0 };
    assert_eq!(apply_signal_chain(&chain, 0.002), 0.001);
    assert!((apply_signal_chain(&chain, 0.008) - (0.001 - 2.0 * 0.005)).abs() < 1e-15);
    assert_eq!(apply_signal_chain(&chain, 0.05), -0.02);
    assert_eq!(apply_signal_chain(&chain, -0.05), 0.01);
}
