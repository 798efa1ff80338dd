//! Where a condition ceases to hold.

/// The last point found from `inside`, where `holds` is true, towards `outside`, where it is not, after so many halvings.
pub fn bisect(mut inside: f64, mut outside: f64, halvings: usize, mut holds: impl FnMut(f64) -> bool) -> f64 {
    for _ in 0..halvings {
        let middle = 0.5 * (inside + outside);
        if middle == inside || middle == outside {
            break;
        }
        *(if holds(middle) { &mut inside } else { &mut outside }) = middle;
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_within_the_halved_interval_and_stays_inside() {
        let found = bisect(0.0, 1.0, 10, |x| x * x <= 0.5);
        assert!(found * found <= 0.5 && (found + 1.0 / 1024.0) * (found + 1.0 / 1024.0) > 0.5);
        // Towards smaller numbers, until two neighbours are left.
        let found = bisect(2.0, 1.0, usize::MAX, |x| x >= 1.5);
        assert_eq!(found, 1.5);
    }
}
