//! A text as a table.

use crate::cells::{is_missing, Cells, Decision, Format, Grid};
use crate::clock::{seconds_of, DateOrder, Moment};
use crate::column::{join_dates, Column, Content, Loss, Note};
use crate::head::{delimiter, Head};
use crate::split::{cells_of, lines};
use std::fmt;
use std::panic::resume_unwind;
use std::thread;

/// How a text is written; `None`, or no names, where it says so itself.
#[derive(Debug, Clone, Default)]
pub struct Form {
    pub numbers: Option<Format>,
    pub dates: Option<DateOrder>,
    pub delimiter: Option<u8>,
    /// Of the columns: every line is then a row.
    pub names: Vec<String>,
}

/// The columns of a text.
#[derive(Debug)]
pub struct Table {
    pub columns: Vec<Column>,
    /// Rows of every column.
    pub rows: usize,
    /// The first comment lines, with their marks.
    pub comments: Vec<String>,
    /// On the whole file.
    pub notes: Vec<Note>,
}

/// Why a text is no table, as the end of a sentence, and the cure.
#[derive(Debug, PartialEq, Eq)]
pub struct Fault {
    pub what: String,
    pub cure: &'static str,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.what, self.cure)
    }
}

const COMMENTS: [&str; 3] = ["#", "%", "//"];
/// Lines that are looked at for delimiter, names and units.
const LOOKED_AT: usize = 50;
/// Most columns, lines, letters of a line, and numbers.
const MOST_COLUMNS: usize = 2000;
const MOST_LINES: usize = 5_000_000;
const LONGEST_LINE: usize = 1 << 20;
const MOST_VALUES: usize = 1 << 26;
/// Most parts of a text that are read at once, and least letters of one.
const MOST_PARTS: usize = 4;
const SHORTEST_PART: usize = 1 << 20;
/// Most comments that are kept.
const MOST_COMMENTS: usize = 1000;
const SHORTER: &str = "keep the signals that are needed, or a part of the time, or save it as .h5 or .nc";

/// Reads a table: perhaps titles, a row of names, perhaps a row of units, then rows of numbers.
///
/// # Errors
/// If it is empty, too large, or has no row of numbers.
pub fn read(text: &str, form: &Form) -> Result<Table, Fault> {
    let stated = form.delimiter.is_some();
    let mut sample: Vec<&str> = lines(text).filter(|line| stated || is_row(line)).take(LOOKED_AT).collect();
    if sample.is_empty() {
        return Err(Fault { what: "is empty".into(), cure: "a log is a table with a time column" });
    }
    sample.iter().try_for_each(|line| checked(line))?;
    let said = sample.first().and_then(|line| separator(line));
    if said.is_some() {
        sample.remove(0);
    }
    let delimiter = form.delimiter.or(said).unwrap_or_else(|| delimiter(&sample));
    let head = if form.names.is_empty() {
        Head::of(&sample, delimiter, |line| comment_above(text, line))
    } else {
        Head { width: form.names.len(), names: form.names.clone(), units: Vec::new(), lines: 0 }
    };
    let Some(at) = sample.get(head.lines).and_then(|line| place(text, line)) else {
        let what = format!("holds {} line(s) of text and no row of numbers", head.lines);
        return Err(Fault { what, cure: "is it a CSV log?" });
    };
    let (above, body) = text.split_at(at);
    let count = |line: &&&str| line.split_whitespace().count();
    let whole = sample[head.lines..].iter().filter(|line| count(line) <= head.width).max_by_key(count);
    let start = Filling::new(Grid::new(delimiter, form.numbers, whole.unwrap_or(&"")), delimiter, head.width);
    let filled = in_parts(body, |part| start.clone().fill(part, stated))?;
    let comments = lines(above).map(str::trim).filter(|line| !stated && is_comment(line)).map(str::to_string);
    let comments = comments.chain(filled.comments.iter().cloned()).take(MOST_COMMENTS).collect();
    let (cells, notes, count) = filled.finish()?;
    let mut columns = columns(cells, head, count, form.dates);
    join_dates(&mut columns);
    Ok(Table { columns, rows: count, comments, notes })
}

/// What `fill` makes of a text, or of its parts at once, where it is long.
fn in_parts<'a>(
    mut text: &'a str,
    fill: impl Fn(&'a str) -> Result<Filling<'a>, Fault> + Sync,
) -> Result<Filling<'a>, Fault> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let length = text.len() / cores.min(MOST_PARTS).min(text.len() / SHORTEST_PART).max(1);
    let mut parts = Vec::new();
    while text.len() > 2 * length - length / 2 {
        let rest = &text.as_bytes()[length..];
        let end = memchr::memchr(b'\n', rest).or_else(|| memchr::memchr(b'\r', rest));
        let Some((part, after)) = end.map(|end| text.split_at(length + end + 1)) else { break };
        parts.push(part);
        text = after;
    }
    let fill = &fill;
    thread::scope(|scope| {
        let started: Vec<_> = parts.into_iter().map(|part| scope.spawn(move || fill(part))).collect();
        let last = fill(text);
        let parts = started.into_iter().map(|part| part.join().unwrap_or_else(|panic| resume_unwind(panic)));
        let mut parts = parts.chain([last]);
        let first = parts.next().unwrap_or_else(|| fill(""))?;
        parts.try_fold(first, |before, part| before.join(part?))
    })
}

/// Where a line of a text begins.
fn place(text: &str, line: &str) -> Option<usize> {
    (line.as_ptr() as usize).checked_sub(text.as_ptr() as usize)
}

fn is_row(line: &str) -> bool {
    let first = line.as_bytes().first();
    // Most lines are seen to be rows by their first letter.
    first.is_some_and(u8::is_ascii_digit) || !(line.trim().is_empty() || is_comment(line.trim()))
}

fn is_comment(line: &str) -> bool {
    // A cell may be `#N/A`.
    COMMENTS.iter().any(|mark| line.starts_with(mark)) && !line.split(',').next().is_some_and(is_missing)
}

/// The delimiter of a line `sep=;`, which Excel takes.
fn separator(line: &str) -> Option<u8> {
    let (name, mark) = line.split_at_checked(4)?;
    let mark = mark.strip_prefix('"').unwrap_or(mark).as_bytes();
    mark.first().copied().filter(|mark| name.eq_ignore_ascii_case("sep=") && mark.is_ascii())
}

/// The last comment above a line of the text, without its marks.
fn comment_above(text: &str, line: &str) -> Option<String> {
    let above = lines(text.get(..place(text, line)?)?).map(str::trim).filter(|line| is_comment(line)).last()?;
    Some(above.trim_start_matches(['#', '%', '/', ' ']).to_string())
}

fn checked(line: &str) -> Result<(), Fault> {
    if line.len() <= LONGEST_LINE || line.trim().chars().count() <= LONGEST_LINE {
        return Ok(());
    }
    let what = format!("has a line of {} letters, more than {LONGEST_LINE}", line.trim().chars().count());
    Err(Fault { what, cure: "is it a table?" })
}

/// Rows on their way into columns.
#[derive(Clone)]
struct Filling<'a> {
    grid: Grid,
    delimiter: u8,
    /// Columns with names, or the usual number of cells.
    named: usize,
    /// The line that is not yet a row: the last one may be cut off.
    waiting: Option<&'a str>,
    rows: usize,
    /// Fewest cells of a row.
    narrowest: usize,
    /// Rows with more cells than there are names, and the first cell of the first of them.
    wider: (usize, String),
    comments: Vec<String>,
}

impl<'a> Filling<'a> {
    fn new(grid: Grid, delimiter: u8, named: usize) -> Self {
        let (wider, comments) = ((0, String::new()), Vec::new());
        Filling { grid, delimiter, named, waiting: None, rows: 0, narrowest: usize::MAX, wider, comments }
    }

    /// Takes the lines of a text; `every` one is a row, also empty ones and those that begin like comments.
    fn fill(mut self, text: &'a str, every: bool) -> Result<Self, Fault> {
        for line in lines(text) {
            if every || is_row(line) {
                if let Some(before) = self.waiting.replace(line) {
                    self.push(before)?;
                }
            } else if self.comments.len() < MOST_COMMENTS && !line.trim().is_empty() {
                self.comments.push(line.trim().to_string());
            }
        }
        Ok(self)
    }

    /// With the rows of the next part of the text.
    fn join(mut self, next: Self) -> Result<Self, Fault> {
        self.comments.extend(next.comments);
        if next.waiting.is_none() {
            return Ok(self);
        }
        if let Some(line) = self.waiting.take() {
            self.push(line)?;
        }
        let first = if self.wider.0 > 0 { self.wider.1 } else { next.wider.1 };
        self.wider = (self.wider.0 + next.wider.0, first);
        self.grid.append(next.grid);
        self.rows += next.rows;
        self.narrowest = self.narrowest.min(next.narrowest);
        self.waiting = next.waiting;
        self.within()?;
        Ok(self)
    }

    fn push(&mut self, line: &str) -> Result<(), Fault> {
        checked(line)?;
        let (width, filled) = self.grid.push(line);
        self.rows += 1;
        self.narrowest = self.narrowest.min(width);
        if filled > self.named {
            if self.wider.0 == 0 {
                self.wider.1 = cells_of(line, self.delimiter).first().map(ToString::to_string).unwrap_or_default();
            }
            self.wider.0 += 1;
        }
        self.within()
    }

    fn within(&self) -> Result<(), Fault> {
        let columns = self.grid.columns.len();
        let (what, cure) = if columns > MOST_COLUMNS {
            let cure = "keep those that are needed, or turn a table that has its signals in rows";
            (format!("has {columns} columns, more than {MOST_COLUMNS}"), cure)
        } else if self.rows > MOST_LINES {
            (format!("has more than {MOST_LINES} lines"), SHORTER)
        } else if columns * self.rows > MOST_VALUES {
            (format!("has more than {MOST_VALUES} numbers"), SHORTER)
        } else {
            return Ok(());
        };
        Err(Fault { what, cure })
    }

    /// The columns, notes on the rows, and their number.
    fn finish(mut self) -> Result<(Vec<Cells>, Vec<Note>, usize), Fault> {
        let mut notes = Vec::new();
        if let Some(last) = self.waiting.take() {
            if self.rows > 0 && cells_of(last, self.delimiter).len() < self.narrowest {
                let text = "the last line is cut off and left out; was the file copied before it was complete?";
                notes.push(("truncated", text.into()));
            } else {
                self.push(last)?;
            }
        }
        let (count, first) = &self.wider;
        if *count > 0 {
            let text = format!(
                "{count} rows have more cells than the {} of the header, the first begins with `{first}`; extra cells are read without a \
                 name. Are there decimal commas while commas also separate the columns? Export with semicolons",
                self.named
            );
            notes.push(("ragged-rows", text));
        }
        if self.grid.unplaced > 0 {
            let text = format!(
                "{} rows have fewer cells than others, and do not stand below these: which cells are missing is not known, so that all \
                 count as missing. Export with semicolons",
                self.grid.unplaced
            );
            notes.push(("ragged-rows", text));
        }
        Ok((self.grid.finish(), notes, self.rows))
    }
}

/// Cells with their names, and those names that have no cells. Delimiters at the ends of lines make empty columns without a name, which count
/// where others follow.
fn columns(cells: Vec<Cells>, head: Head, rows: usize, dates: Option<DateOrder>) -> Vec<Column> {
    let (width, named) = (cells.len(), head.names.len());
    let mut units = head.units.into_iter();
    let mut names = head.names.into_iter();
    let mut found = Vec::new();
    for (index, cells) in cells.into_iter().enumerate() {
        let (name, unit) = (names.next().unwrap_or_default(), units.next().unwrap_or_default());
        let name = if name.is_empty() && !cells.blank { format!("column {}", index + 1) } else { name };
        let content = if name.is_empty() { Content::Lost(Loss::NoCells) } else { content(cells, rows, dates) };
        found.push(Column { name, unit, content });
    }
    while found.last().is_some_and(|last: &Column| last.name.is_empty()) {
        found.pop();
    }
    let lost = |name| Column { name, unit: String::new(), content: Content::Lost(Loss::NoCells) };
    found.extend(names.filter(|name| width < named && !name.is_empty()).map(lost));
    found
}

/// The numbers of a column, or why there are none.
fn content(cells: Cells, rows: usize, order: Option<DateOrder>) -> Content {
    let (mut values, (mut bad, first)) = (cells.values, cells.bad);
    let (mut notes, mut start) = (Vec::new(), None);
    if 2 * cells.moments.len() > bad && bad > 0 {
        let moments: Vec<Moment> = cells.moments.iter().map(|(_, moment)| *moment).collect();
        let seconds = seconds_of(&moments, order);
        if seconds.undecided {
            return Content::Lost(Loss::Dates);
        }
        values.fill(f64::NAN);
        for ((row, _), second) in cells.moments.iter().zip(&seconds.values) {
            values[*row as usize] = *second;
        }
        (start, bad) = (Some(seconds.start), bad - seconds.values.iter().filter(|second| second.is_finite()).count());
    }
    if let Decision::Undecided(cell) = cells.decision {
        return Content::Lost(Loss::Undecided(cell));
    }
    if let Decision::Mixed(point, comma) = cells.decision {
        return Content::Lost(Loss::Mixed(point, comma));
    }
    if 2 * bad > rows {
        return Content::Lost(Loss::Words(first));
    }
    if bad > 0 {
        let first = if first.is_empty() { "a date that there is not" } else { &first };
        let text = format!("has {bad} cells that are not numbers, the first is `{first}`; they count as missing");
        notes.push(("unreadable-cells", text));
    }
    if let Decision::Thousands(cell) = cells.decision {
        let text = format!("has `{cell}`, which is read with marks of thousands, as other columns of the file say");
        notes.push(("number-format", text));
    }
    Content::Numbers { values, start, notes }
}
