//! Check of a value against the usual range of its key: a warning outside, an error far outside.

use crate::keys::{Key, Sign, Usual};
use crate::units::{self, Dimension, Quantity};
use std::cell::RefCell;

/// Usual ranges of keys that declare none, by dimension.
const OF_DIMENSION: &[Usual] = &[
    ("0 m", "100 m", 10.0),
    ("0 deg", "720 deg", 100.0),
    ("0 s", "1e6 s", 1e3),
    ("0 bar", "2000 bar", 10.0),
    ("0 kg", "50 t", 1e3),
];

/// Bounds of magnitudes for keys without a range, SI.
const LEAST: f64 = 1e-18;
const MOST: f64 = 1e15;

/// Further units for the guess of the intended one.
const WRITTEN_UNITS: [&str; 9] = ["l/min", "mm/s", "N/mm", "kN/mm", "kN s/m", "kg/l", "g/l", "kg mm^2", "mPa s"];

thread_local! {
    /// Ranges of this program in SI, in the order of their places: each is parsed once, because every value of a file is held against several.
    static RANGES: RefCell<Vec<(*const Usual, Range)>> = RefCell::default();
}

/// A usual range in SI.
#[derive(Debug, Clone, Copy)]
struct Range {
    /// `None`: of any.
    dimension: Option<Dimension>,
    low: f64,
    high: f64,
    margin: f64,
    /// As they are declared.
    texts: [&'static str; 2],
}

impl Range {
    fn of(usual: &'static Usual) -> Self {
        RANGES.with_borrow_mut(|known| {
            let place = known.binary_search_by_key(&std::ptr::from_ref(usual), |(of, _)| *of).unwrap_or_else(|place| {
                known.insert(place, (usual, Self::new(usual)));
                place
            });
            known[place].1
        })
    }

    fn new(&(low, high, margin): &Usual) -> Self {
        let ends = [low, high].map(units::own_scalar);
        let [from, to] = ends.map(|(number, unit)| unit.to_si(number));
        let dimension = low.contains(' ').then_some(ends[0].1.dimension);
        Range { dimension, low: from, high: to, margin, texts: [low, high] }
    }
}

/// How a value compares with its usual range.
#[derive(Debug, Clone, PartialEq)]
pub enum Plausibility {
    Usual,
    /// A warning: what is usual, and the cure.
    Unusual(String, String),
    /// An error: what is allowed, and the cure.
    Refused(String, String),
}

/// Judges the value `si` of `key`, written as `number` in some unit. A positive one may be too small for any use.
pub fn judge(key: &Key, quantity: &Quantity, number: f64, si: f64) -> Plausibility {
    let positive = key.sign() == Sign::Positive;
    let magnitude = si.abs();
    if magnitude == 0.0 {
        return Plausibility::Usual;
    }
    let too_small = positive && magnitude < LEAST;
    let range = range_of(key, quantity.dimension).filter(|range| range.low > 0.0 || !too_small);
    let Some(range) = range else {
        if magnitude <= MOST && !too_small {
            return Plausibility::Usual;
        }
        let unit = if quantity.is_number() { String::new() } else { format!(" {}", quantity.unit) };
        let limits = format!("must lie between {LEAST:e} and {MOST:e}{unit}");
        return Plausibility::Refused(limits, "check the value and its unit".into());
    };
    // No warning because of rounding.
    let outside = |margin: f64| (range.low / magnitude).max(magnitude / range.high) > margin * (1.0 + 1e-9);
    let too_large = magnitude > range.high;
    if !outside(1.0) {
        return Plausibility::Usual;
    }
    let usual = format!("usual is {} to {}", range.texts[0], range.texts[1]);
    let cure = likely(&range, quantity, number, si).unwrap_or_else(|| "check the value and its unit".into());
    if (too_large || positive) && outside(range.margin) {
        return Plausibility::Refused(usual, cure);
    }
    Plausibility::Unusual(usual, cure)
}

fn range_of(key: &Key, dimension: Dimension) -> Option<Range> {
    let of_dimension = if dimension == Dimension::NONE { &[] } else { OF_DIMENSION };
    let mut ranges = key.usual.iter().chain(of_dimension).map(Range::of);
    ranges.find(|range| range.dimension.is_none_or(|of_range| of_range == dimension))
}

/// How far the value `si` of `key` is from what is usual: 0 usual, 1 up to ten times outside, 2 further.
pub fn size(key: &Key, dimension: Dimension, si: f64) -> u8 {
    let Some(range) = range_of(key, dimension) else { return 0 };
    let within = |margin: f64| (range.low / margin..=range.high * margin).contains(&si.abs());
    [1.0, 10.0].iter().take_while(|margin| !within(**margin)).count() as u8
}

/// The number with the probably intended unit: the one that people write most, or that for which it is nearest to the middle of the range.
/// Who wrote the one that people write most meant no other, unless the number is SI.
fn likely(range: &Range, quantity: &Quantity, number: f64, si: f64) -> Option<String> {
    let written = units::parse_unit(quantity.written()).ok()?;
    let only_si = written.factor != 1.0 && written.to_si(number) == si;
    let distance = |si: f64| libm::log(si * si / (range.low.max(1e-3 * range.high) * range.high)).abs();
    let meant = units::usual_symbols().chain(WRITTEN_UNITS).filter_map(|symbol| {
        let unit = units::own_unit(symbol);
        let si = unit.to_si(number).abs();
        let meant = unit.factor == 1.0 || !only_si;
        let fits = meant && unit.dimension == quantity.dimension && (range.low..=range.high).contains(&si);
        fits.then_some((symbol, if symbol == quantity.written() { 0.0 } else { distance(si) }))
    });
    let (symbol, _) = meant.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!("did you mean \"{} {symbol}\"?", short(number)))
}

/// A number in usual notation.
pub fn short(number: f64) -> String {
    let magnitude = number.abs();
    if magnitude != 0.0 && !(1e-4..1e7).contains(&magnitude) {
        return format!("{number:e}");
    }
    format!("{number}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keys::{self, Value};
    use crate::units::quantities;

    /// The declaration that a machine's dotted key has.
    fn declared(path: &str) -> &'static Key {
        let (mut keys, mut names) = (keys::MACHINE, path.split('.'));
        loop {
            let key = keys::find(keys, names.next().unwrap()).unwrap();
            keys = match key.value {
                Value::Table(keys) => keys,
                Value::Tables(keys) => {
                    names.next();
                    keys
                }
                _ => return key,
            };
        }
    }

    #[test]
    fn a_wrong_unit_is_guessed() {
        let bore =
            |number: f64, si: f64| judge(declared("cylinder.lift.bore"), &quantities::LENGTH.quantity(), number, si);
        assert_eq!(bore(63.0, 0.063), Plausibility::Usual);
        for number in [63.0, 100.0] {
            let meant = format!("did you mean \"{number} mm\"?");
            assert_eq!(bore(number, number), Plausibility::Unusual("usual is 10 mm to 600 mm".into(), meant));
        }
        assert!(matches!(bore(1e5, 1e5), Plausibility::Refused(..)));
        assert!(matches!(bore(1e-9, 1e-9), Plausibility::Refused(..)));
        let pressure = judge(declared("supply.pressure"), &quantities::PRESSURE.quantity(), 100.0, 100.0);
        assert_eq!(
            pressure,
            Plausibility::Unusual("usual is 5 bar to 500 bar".into(), "did you mean \"100 bar\"?".into())
        );
        for (number, cure) in [(2200.0, "check the value and its unit"), (2e7, "did you mean \"2e7 Pa\"?")] {
            let found = judge(declared("supply.pressure"), &quantities::PRESSURE.quantity(), number, 1e5 * number);
            assert!(
                matches!(&found, Plausibility::Unusual(_, of) | Plausibility::Refused(_, of) if of == cure),
                "{found:?}"
            );
        }
    }

    #[test]
    fn keys_without_a_range_are_bounded_too() {
        for (number, refused) in [(1e-300, true), (0.5, false), (1e300, true)] {
            let found = judge(declared("sensor.lift.live-zero"), &Quantity::number(), number, number);
            assert_eq!(matches!(found, Plausibility::Refused(..)), refused, "{number}");
        }
    }
}
