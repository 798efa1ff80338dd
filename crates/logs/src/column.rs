//! One column of a table, and which one holds the times.

use crate::names::split_name;

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
            Loss::Words(_) => "words, not numbers".into(),
            Loss::NoCells => "no row has a cell of it".into(),
        }
    }
}

/// Index of the column with a name, with or without its unit: as it is written, else in any case. `None` if several have it.
pub fn column_named(columns: &[Column], wanted: &str) -> Option<usize> {
    let one = |is: &dyn Fn(&str) -> bool, short: bool| {
        let own = |column: &Column| is(if short { split_name(&column.name).0 } else { &column.name });
        let mut found = (0..columns.len()).filter(|at| own(&columns[*at]));
        found.next().map(|first| found.next().is_none().then_some(first))
    };
    let any_case = |name: &str| name.eq_ignore_ascii_case(wanted);
    let exact = |name: &str| name == wanted;
    [one(&exact, false), one(&exact, true), one(&any_case, false), one(&any_case, true)].into_iter().flatten().next()?
}

/// Index of the time column: the one with such a name, or the only one with dates; `T` at last. `None` if several have one name.
pub fn time_column(columns: &[Column]) -> Option<usize> {
    let name = |at: usize| split_name(&columns[at].name).0;
    let is = |at: usize, wanted: &str| name(at) != "T" && name(at).eq_ignore_ascii_case(wanted);
    let held = |wanted: &&str| (0..columns.len()).any(|at| is(at, wanted));
    if let Some(wanted) = TIME_NAMES.into_iter().find(held) {
        return column_named(columns, wanted);
    }
    // A date alone is no time.
    let in_days =
        |start: f64, values: &[f64]| values.iter().all(|value| value.is_nan() || (start + value) % 86_400.0 <= 0.0);
    let dated = |at: &usize| match &columns[*at].content {
        Content::Numbers { start: Some(start), values, .. } => !in_days(*start, values),
        _ => false,
    };
    let mut found = (0..columns.len()).filter(dated);
    match (found.next(), found.next()) {
        (None, _) => column_named(columns, "T"),
        (first, None) => first,
        _ => None,
    }
}
