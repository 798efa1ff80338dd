//! The names of a log's columns: the unit in a name, which column has a name, and which one holds the times.

use crate::errors::{ErrorKind, Problem};
use crate::units::log_units::{bare_unit, bracket, log_unit};
use crate::units::own_unit;
use hydrocrane_logs::{in_days, Column, Content};

/// Names of a column of times, in any case, the likeliest first; loggers also write it in their maker's language. `T`, which may be a
/// temperature, counts where no other column may hold times.
pub const TIME_NAMES: [&str; 18] = [
    "time",
    "t",
    "time_s",
    "t_s",
    "timestamp",
    "time stamp",
    "time_stamp",
    "datetime",
    "date time",
    "date_time",
    "zeit",
    "zeitstempel",
    "temps",
    "tiempo",
    "tempo",
    "tid",
    "tijd",
    "aika",
];
/// A time column with larger numbers is not in seconds: they would be 3000 years.
const LATEST: f64 = 1e11;
/// Days of 1900 to 2100 as MATLAB and Excel count them.
const SERIAL: [(f64, f64); 2] = [(693_962.0, 767_010.0), (25_569.0, 73_051.0)];
/// Days that count as these have steps of less: more than a thousand samples per second if they were seconds. Days from zero: more than
/// fifty thousand.
const LEAST_STEP: f64 = 1e-3;
const LEAST_ELAPSED: f64 = 2e-5;

/// Index of a column, or which ones may be meant: what the log has.
pub type Found = Result<Option<usize>, Problem>;

/// `x [mm]`, `p1 (bar(g))`, `x in mm` or `x/mm` as name and unit, without the brackets; the unit is empty if there is none. A number in
/// square brackets counts the columns of a matrix.
pub fn split_name(text: &str) -> (&str, &str) {
    let text = text.trim();
    let is_unit = |unit: &str| !unit.starts_with(|c: char| c.is_ascii_digit()) && log_unit(unit).is_ok();
    if let Some((name, unit)) = text.rsplit_once(" in ").filter(|(_, unit)| is_unit(unit.trim())) {
        return (name.trim(), bare_unit(unit));
    }
    if let Some((name, unit)) = text.split_once('/').filter(|(name, unit)| is_label(name, unit, text) && is_unit(unit))
    {
        return (name.trim(), bare_unit(unit));
    }
    let Some(at) = bracket(text) else { return (text, "") };
    let (name, unit) = (text[..at].trim_end(), &text[at + 1..text.len() - 1]);
    let counts = text.ends_with(']') && !unit.is_empty() && unit.bytes().all(|b| b.is_ascii_digit());
    match name.is_empty() || counts || unit.contains(']') {
        true => (text, ""),
        false => (name, bare_unit(unit)),
    }
}

/// Whether a heading is a quantity over its unit, as in `p/bar` or `t/s`, if `unit` is one: not itself a unit, but for a time, nor the
/// path of a signal, which may end in a letter that is a unit too, as in `boom/A`.
fn is_label(name: &str, unit: &str, whole: &str) -> bool {
    let name = name.trim().to_lowercase();
    let symbol = unit.trim().len() > 1 || name.chars().count() <= 3;
    let likely = TIME_NAMES.contains(&&*name) || symbol && log_unit(whole).is_err();
    !name.is_empty() && !name.contains(['[', '(', '<']) && likely
}

/// The unit of a column by what its source states beside it, or behind its name; empty if there is none.
pub fn unit_of<'a>(name: &'a str, beside: &'a str) -> &'a str {
    match bare_unit(beside) {
        "" => split_name(name).1,
        unit => unit,
    }
}

/// Index of the first column with one of the `wanted` names, with or without its unit: as it is written, else in any case. Of each
/// column its index and name.
///
/// # Errors
/// If several columns have that name.
pub fn first_of(columns: &[(usize, &str)], wanted: &[&str]) -> Found {
    for wanted in wanted {
        let low = wanted.to_lowercase();
        for kind in 0..4 {
            let is = |(_, name): &(usize, &str)| match kind {
                0 => name == wanted,
                1 => split_name(name).0 == *wanted,
                2 => name.to_lowercase() == low,
                _ => split_name(name).0.to_lowercase() == low,
            };
            let found: Vec<_> = columns.iter().copied().filter(is).collect();
            if !found.is_empty() {
                return only(&found, &format!("`{wanted}`"));
            }
        }
    }
    Ok(None)
}

fn only(found: &[(usize, &str)], what: &str) -> Found {
    if found.len() > 1 {
        let names: Vec<String> = found.iter().map(|(_, name)| format!("`{name}`")).collect();
        let cure = format!("say by its full name which is {what}");
        return Err((ErrorKind::UnknownReference, format!("has {}", names.join(" and ")), cure));
    }
    Ok(found.first().map(|(at, _)| *at))
}

/// Index of the time column: the one with such a name whose unit may be one of time, the only one with dates, or the only one of the
/// `clocks` of other columns; `T` at last.
///
/// # Errors
/// If there are several.
pub fn time_column(columns: &[Column], clocks: &[usize]) -> Found {
    let all = |is: &dyn Fn(usize, &Column) -> bool| -> Vec<(usize, &str)> {
        let found = columns.iter().enumerate().filter(|(at, column)| is(*at, column));
        found.map(|(at, column)| (at, column.name.as_str())).collect()
    };
    let in_time = all(&|_, column| {
        let unit = unit_of(&column.name, &column.unit);
        let other = log_unit(unit).is_ok_and(|found| found.unit.dimension != own_unit("s").dimension);
        matches!(column.content, Content::Numbers { .. }) && (unit.is_empty() || !other)
    });
    let but_t: Vec<_> = in_time.iter().copied().filter(|(_, name)| split_name(name).0 != "T").collect();
    // A date alone is no time.
    let dated = all(&|_, column| match &column.content {
        Content::Numbers { values, start: Some(start), .. } => !in_days(*start, values),
        _ => false,
    });
    let kinds: [&dyn Fn() -> Found; 4] = [
        &|| first_of(&but_t, &TIME_NAMES),
        &|| only(&dated, "the time"),
        &|| only(&all(&|at, _| clocks.contains(&at)), "the time"),
        &|| first_of(&in_time, &["T"]),
    ];
    kinds.iter().find_map(|kind| kind().transpose()).transpose()
}

/// The likely unit of times without a unit, if they cannot be seconds: those since 1970 are too large for seconds, and days have too
/// small steps.
pub fn counted_in(times: &[f64]) -> Option<&'static str> {
    let finite: Vec<f64> = times.iter().copied().filter(|time| time.is_finite()).collect();
    let largest = finite.iter().fold(0.0, |most: f64, time| most.max(time.abs()));
    if largest >= LATEST {
        let units = [(1e14, "ms"), (1e17, "1e-6 s"), (f64::INFINITY, "1e-9 s")];
        return units.into_iter().find(|(most, _)| largest < *most).map(|(_, unit)| unit);
    }
    let mut steps: Vec<f64> = finite.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return None;
    }
    let middle = steps.len() / 2;
    let step = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let is_serial = |(low, high): &(f64, f64)| finite.iter().all(|time| (low..=high).contains(&time));
    let least = if SERIAL.iter().any(is_serial) { LEAST_STEP } else { LEAST_ELAPSED };
    (0.0 < step && step < least).then_some("d")
}
