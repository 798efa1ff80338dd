//! One column of a table.

use crate::clock::{in_days, DAY_SECONDS};

/// What was decided, or is missing: a stable short name of its kind, and the message.
pub type Note = (&'static str, String);

#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// As its source writes it, perhaps with a unit; without a name `column 3`.
    pub name: String,
    /// From a row of units, as it stands there; empty if there is none.
    pub unit: String,
    pub content: Content,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    Numbers {
        /// NaN where a cell is missing or no number.
        values: Vec<f64>,
        /// Of dates or times of day, whose values are seconds from the first: that one, s since 1970 or since midnight.
        start: Option<f64>,
        /// Without the name of the column.
        notes: Vec<Note>,
    },
    Lost(Loss),
}

/// Why a column has no numbers.
#[derive(Debug, Clone, PartialEq)]
pub enum Loss {
    /// This cell may have decimals or marks of thousands.
    Undecided(String),
    /// These two cells have different decimal marks.
    Mixed(String, String),
    /// Its dates may have the day or the month first.
    Dates,
    /// A time of day beside these columns of dates: of which one belongs to it, or whose order of day and month is open.
    OfNoDay(Vec<String>),
    /// Its dates belong to the times of day of this column.
    DateOf(String),
    /// Most of its cells are words, this one first.
    Words(String),
    /// The header names it, and no row reaches it.
    NoCells,
}

impl Loss {
    pub fn text(&self) -> String {
        match self {
            Loss::Undecided(cell) => {
                format!("`{cell}` may mean decimals or thousands, and nothing in the file says which")
            }
            Loss::Mixed(one, other) => format!("`{one}` and `{other}` have different decimal marks"),
            Loss::Dates => "its dates do not say which number is the day".into(),
            Loss::OfNoDay(days) => {
                format!("a time of day beside the dates in `{}`, not known of which day", days.join("` and `"))
            }
            Loss::DateOf(name) => format!("its dates belong to the times of day in `{name}`"),
            Loss::Words(_) => "words, not numbers".into(),
            Loss::NoCells => "no row has a cell of it".into(),
        }
    }
}

/// Times of day beside a column of dates count from the first of these.
pub fn join_dates(columns: &mut [Column]) {
    for at in 0..columns.len() {
        let Some((content, day)) = joined(columns, at) else { continue };
        if let Some(day) = day {
            columns[day].content = Content::Lost(Loss::DateOf(columns[at].name.clone()));
        }
        columns[at].content = content;
    }
}

/// Times of day with their dates, and the column of these, or why they cannot be joined; `None` where nothing is to be joined.
fn joined(columns: &[Column], at: usize) -> Option<(Content, Option<usize>)> {
    let Content::Numbers { values, start: Some(first), notes } = &columns[at].content else { return None };
    let of_day = |start: &f64| (0.0..DAY_SECONDS).contains(start);
    let is_day = |day: &usize| match &columns[*day].content {
        Content::Numbers { values: days, start: Some(start), .. } => {
            days.len() == values.len() && !of_day(start) && in_days(*start, days)
        }
        content => *content == Content::Lost(Loss::Dates),
    };
    let found: Vec<usize> = (0..columns.len()).filter(|day| of_day(first) && is_day(day)).collect();
    match (&found[..], found.first().map(|day| &columns[*day].content)) {
        ([], _) => None,
        ([day], Some(Content::Numbers { values: days, start: Some(start), .. })) => {
            let joint = |(day, time): (&f64, &f64)| day + (first + time).rem_euclid(DAY_SECONDS) - first;
            let values = days.iter().zip(values).map(joint).collect();
            Some((Content::Numbers { values, start: Some(start + first), notes: notes.clone() }, Some(*day)))
        }
        _ => {
            let names = found.iter().map(|day| columns[*day].name.clone()).collect();
            Some((Content::Lost(Loss::OfNoDay(names)), None))
        }
    }
}
