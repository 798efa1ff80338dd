//! Dates and times of day in the formats of loggers, as seconds from the first.

/// Which of two numbers before a year is which.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DateOrder {
    DayMonth,
    MonthDay,
}

/// A date with a time, or a time of day.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    day: Day,
    /// Since the start of that day, in UTC where a zone is stated.
    nanoseconds: i64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Day {
    /// A time of day alone.
    Unstated,
    /// Counted from 1970-01-01.
    Known(i32),
    /// Day and month, or month and day.
    Either(Pair),
}

/// Two numbers before a year.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Pair {
    first: u8,
    second: u8,
    year: u16,
}

/// Moments of a column as seconds.
pub struct Seconds {
    /// From the first moment; NaN where a date does not exist.
    pub values: Vec<f64>,
    /// Of the first moment, s since 1970, or since midnight where no date is stated.
    pub start: f64,
    /// Whether nothing says in which order day and month stand.
    pub undecided: bool,
}

const SECOND: i64 = 1_000_000_000;
const DAY: i64 = 86_400 * SECOND;
/// s
pub const DAY_SECONDS: f64 = 86_400.0;

impl Moment {
    /// A cell like `2024-05-01T12:30:00.25Z`, `2024/5/1 12:30:00`, `31.12.2024 12:30:00`, `12/31/2024 1:30:00 PM`, `12:30:00,25`, or a date
    /// alone. Times without a zone are taken as they are.
    pub fn parse(cell: &str) -> Option<Self> {
        let cell = cell.trim();
        if !cell.contains(':') {
            return Some(Moment { day: Day::parse(cell)?, nanoseconds: 0 });
        }
        if let Some(nanoseconds) = time_of_day(cell, true) {
            return Some(Moment { day: Day::Unstated, nanoseconds });
        }
        let (date, time) = cell.split_at(cell.find([' ', 'T', 't', '_'])?);
        let (time, offset) = without_zone(time[1..].trim_start())?;
        Some(Moment { day: Day::parse(date)?, nanoseconds: time_of_day(time, false)? - offset })
    }

    /// Since 1970 in nanoseconds; `None`: there is no such date.
    fn since_1970(self, day_first: bool) -> Option<i128> {
        let days = match self.day {
            Day::Unstated => 0,
            Day::Known(days) => days,
            Day::Either(pair) => pair.days(day_first)?,
        };
        Some(i128::from(days) * i128::from(DAY) + i128::from(self.nanoseconds))
    }
}

impl Day {
    fn parse(date: &str) -> Option<Self> {
        let mark = date.find(['-', '/', '.'])?;
        let mut parts = date.split(['-', '/', '.']);
        let [a, b, c] = [parts.next()?, parts.next()?, parts.next()?];
        let short = |text: &str| digits(text, 1, 2).and_then(|number| u8::try_from(number).ok());
        let year = |text: &str| digits(text, 4, 4).and_then(|number| u16::try_from(number).ok());
        if parts.next().is_some() {
            return None;
        }
        if let Some(year) = year(a) {
            return days_of(year, short(b)?, short(c)?).map(Day::Known);
        }
        let pair = Pair { first: short(a)?, second: short(b)?, year: year(c)? };
        match &date[mark..=mark] {
            "." => pair.days(true).map(Day::Known),
            _ => [true, false].iter().any(|first| pair.days(*first).is_some()).then_some(Day::Either(pair)),
        }
    }
}

impl Pair {
    fn days(self, day_first: bool) -> Option<i32> {
        let (day, month) = if day_first { (self.first, self.second) } else { (self.second, self.first) };
        days_of(self.year, month, day)
    }
}

/// The number that a text of `least` to `most` digits is.
fn digits(text: &str, least: usize, most: usize) -> Option<u32> {
    let right = (least..=most).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    right.then(|| text.parse().ok()).flatten()
}

/// Days since 1970-01-01 in the Gregorian calendar; `None`: there is no such date.
fn days_of(year: u16, month: u8, day: u8) -> Option<i32> {
    const BEFORE: [i32; 12] = [0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334];
    let leaps = |years: i32| years / 4 - years / 100 + years / 400;
    let (year, index) = (i32::from(year), usize::from(month).checked_sub(1)?);
    let leap = leaps(year) > leaps(year - 1);
    let after_february = |month: usize| i32::from(leap && month >= 2);
    let start = BEFORE.get(index)? + after_february(index);
    let end = BEFORE.get(index + 1).map_or(365 + i32::from(leap), |days| days + after_february(index + 1));
    let exists = year >= 1 && day >= 1 && start + i32::from(day) <= end;
    exists.then(|| 365 * (year - 1970) + leaps(year - 1) - leaps(1969) + start + i32::from(day) - 1)
}

/// Nanoseconds of `12:30:00.25`, or `1:30:00 pm`; `seconds`: they must be stated, because `12:30` may mean minutes.
fn time_of_day(text: &str, seconds: bool) -> Option<i64> {
    let (text, half) = match text.len().checked_sub(2).and_then(|at| text.split_at_checked(at)) {
        Some((start, half)) if half.eq_ignore_ascii_case("am") => (start.trim_end(), Some(0)),
        Some((start, half)) if half.eq_ignore_ascii_case("pm") => (start.trim_end(), Some(12)),
        _ => (text, None),
    };
    let mut parts = text.splitn(3, ':');
    let hours = digits(parts.next()?, 1, 2)?;
    let minutes = digits(parts.next()?, 2, 2).filter(|minutes| *minutes < 60)?;
    let (whole, part) = match parts.next() {
        None if seconds => return None,
        None => (0, 0),
        Some(text) => {
            let (whole, part) = text.split_once(['.', ',']).unwrap_or((text, "0"));
            let known = digits(part.get(..part.len().min(9))?, 1, 9)?;
            let rest = part.bytes().all(|b| b.is_ascii_digit());
            // A logger that rounds writes 60.0.
            (
                digits(whole, 2, 2).filter(|seconds| rest && *seconds <= 60)?,
                known * 10_u32.pow(9 - part.len().min(9) as u32),
            )
        }
    };
    let hours = half.map_or(hours, |half| hours % 12 + half);
    Some(i64::from(60 * (60 * hours + minutes) + whole) * SECOND + i64::from(part))
}

/// A time without its zone, and how far this is ahead of UTC, ns.
fn without_zone(time: &str) -> Option<(&str, i64)> {
    if let Some(plain) = time.strip_suffix(['Z', 'z']) {
        return Some((plain.trim_end(), 0));
    }
    let Some(at) = time.rfind(['+', '-']) else { return Some((time, 0)) };
    let (plain, zone) = (time[..at].trim_end(), &time[at + 1..]);
    let sign = if time[at..].starts_with('-') { -1 } else { 1 };
    let (hours, minutes) = match zone.len() {
        2 => (zone, "00"),
        4 if zone.is_ascii() => zone.split_at(2),
        _ => zone.split_once(':')?,
    };
    let minutes = 60 * digits(hours, 2, 2)? + digits(minutes, 2, 2)?;
    Some((plain, sign * i64::from(minutes) * 60 * SECOND))
}

/// Moments as seconds from the first. A time of day that jumps back by more than half a day has passed midnight. Without an `order` of day
/// and month all moments together decide it.
pub fn seconds_of(moments: &[Moment], order: Option<DateOrder>) -> Seconds {
    let day_first = match order {
        Some(order) => Some(order == DateOrder::DayMonth),
        None => day_first(moments),
    };
    let instants: Vec<Option<i128>> = moments.iter().map(|moment| moment.since_1970(day_first == Some(true))).collect();
    let start = instants.iter().flatten().next().copied().unwrap_or(0);
    let mut values: Vec<f64> = instants
        .iter()
        .map(|instant| instant.map_or(f64::NAN, |instant| (instant - start) as f64 / SECOND as f64))
        .collect();
    if moments.iter().all(|moment| moment.day == Day::Unstated) {
        let (mut last, mut days) = (0.0, 0.0);
        for value in &mut values {
            days += if *value - last < -0.5 * DAY_SECONDS { DAY_SECONDS } else { 0.0 };
            last = *value;
            *value += days;
        }
    }
    Seconds { values, start: start as f64 / SECOND as f64, undecided: day_first.is_none() }
}

/// Whether moments, as [`Seconds`] has them, are dates without a time.
pub fn in_days(start: f64, values: &[f64]) -> bool {
    values.iter().all(|value| value.is_nan() || (start + value).rem_euclid(DAY_SECONDS) <= 0.0)
}

/// Whether the day is the first of two numbers before a year, in all dates of a column; `None` if nothing says so.
fn day_first(moments: &[Moment]) -> Option<bool> {
    let mut pairs: Vec<Pair> = Vec::new();
    for moment in moments {
        match moment.day {
            Day::Either(pair) if pairs.last() != Some(&pair) => pairs.push(pair),
            _ => {}
        }
    }
    if pairs.len() < 2 {
        // Seconds from the first moment do not depend on its date.
        return Some(pairs.iter().any(|pair| pair.first > 12));
    }
    let days = |day_first: bool| pairs.iter().map(|pair| pair.days(day_first)).collect::<Option<Vec<i32>>>();
    // A log goes on from one day to the next.
    let goes_on = |days: &Vec<i32>| days.windows(2).all(|pair| pair[1] == pair[0] + 1);
    match [days(true), days(false)] {
        [Some(_), None] => Some(true),
        [None, Some(_)] => Some(false),
        [Some(one), Some(other)] if goes_on(&one) != goes_on(&other) => Some(goes_on(&one)),
        _ => None,
    }
}
