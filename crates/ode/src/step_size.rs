//! Sizes of equal steps, for one crane and for cranes in lanes.   theory: docs/theory/integration.md

/// Share of a step by which an interval may be longer than whole steps: rounding must not add one.
pub const EVEN: f64 = 1e-6;

/// The longest of equal parts of `span` that are not longer than `most`, but for a share [`EVEN`]; `most` where the span
/// is infinite.
pub fn equal_part(span: f64, most: f64) -> f64 {
    if span.is_finite() {
        span / (span / most - EVEN).ceil().max(1.0)
    } else {
        most
    }
}

/// The longest step that [`equal_part`] makes of parts of at most `most`, with rounding.
pub fn longest_part(most: f64) -> f64 {
    most * (1.0 + 2.0 * EVEN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_a_whole_fraction_and_no_longer_than_was_asked_but_for_rounding() {
        for i in 1..20_000 {
            let (span, most) = (0.05 * (1.0 + f64::from(i) * 1e-7), 5e-4 * (1.0 + f64::from(i % 97) * 3e-8));
            let part = equal_part(span, most);
            assert!(part <= longest_part(most) && (span / part).fract().min(1.0 - (span / part).fract()) < 1e-9);
        }
    }

    #[test]
    fn rounding_adds_no_step() {
        assert_eq!(equal_part(0.01 + 1e-12, 0.01), 0.01 + 1e-12);
        assert_eq!(equal_part(f64::INFINITY, 0.01), 0.01);
    }
}
