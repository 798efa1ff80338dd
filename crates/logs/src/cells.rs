//! Cells of a text table as numbers. What a comma and a point mean is decided once per column, from all its cells and from
//! the other columns; a column that stays undecided has no numbers.

use crate::clock::Moment;
use crate::split::{first_cell, BLANK};
use std::ops::Range;

/// What a number's marks mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// `1,234.5`
    Point,
    /// `1.234,5`
    Comma,
}

/// How the marks of a column were decided.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Decision {
    /// By its own cells, or there is nothing to decide.
    #[default]
    Own,
    /// This cell has marks of thousands, as other columns say.
    Thousands(String),
    /// This cell may have decimals or thousands, and nothing says which.
    Undecided(String),
    /// These two cells have different decimal marks.
    Mixed(String, String),
}

/// One column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cells {
    /// NaN where a cell is missing or no number.
    pub values: Vec<f64>,
    /// Number of cells that are neither numbers nor missing, and the first of them that is no moment either.
    pub bad: (usize, String),
    /// Those of the bad ones that are dates or times of day, with their rows.
    pub moments: Vec<(u32, Moment)>,
    /// Whether all cells are empty.
    pub blank: bool,
    pub decision: Decision,
    /// Whether a number has three digits and no mark.
    whole: bool,
    /// First cell of each format that no other explains.
    certain: [Option<String>; 2],
    /// By mark, point and comma: the first cell that both formats explain differently, and the rows of all of them that may still become
    /// thousands; their values are those with decimals.
    either: [Option<(String, Vec<u32>)>; 2],
}

/// A table that grows row by row.
#[derive(Clone)]
pub struct Grid {
    delimiter: u8,
    stated: Option<Format>,
    pub columns: Vec<Cells>,
    rows: u32,
    /// Between blanks: where the cells of the last row begin and end that had one for every column.
    places: Vec<Range<usize>>,
    /// Between blanks: rows with fewer cells, of which some may belong to several columns; these are missing.
    pub unplaced: usize,
}

const POINT: u8 = 1;
const COMMA: u8 = 2;
/// Marks of thousands that are no decimal marks.
const GAPS: [char; 5] = [' ', '\u{a0}', '\u{202f}', '\'', '\u{2019}'];
/// Cells that say that there is no number.
const MISSING: [&str; 12] = ["", "nan", "na", "n/a", "null", "inf", "-inf", "+inf", "#n/a", "-nan", "nil", "--"];

/// Where the cells of a line between blanks stand.
fn places(line: &str) -> Vec<Range<usize>> {
    let place = |cell: &str| {
        let start = cell.as_ptr() as usize - line.as_ptr() as usize;
        start..start + cell.len()
    };
    line.split_whitespace().map(place).collect()
}

impl Grid {
    /// An empty table. `stated` leaves nothing to decide; `whole` is a row with a cell for every column.
    pub fn new(delimiter: u8, stated: Option<Format>, whole: &str) -> Self {
        Grid { delimiter, stated, columns: Vec::new(), rows: 0, places: places(whole), unplaced: 0 }
    }

    /// Appends a line; returns the number of its cells, and that without empty ones at its end.
    pub fn push(&mut self, line: &str) -> (usize, usize) {
        let (mut width, mut filled) = (0, 0);
        if self.delimiter == BLANK {
            width = self.push_between_blanks(line);
            filled = width;
        } else {
            let mut rest = Some(line);
            while let Some(text) = rest {
                width += 1;
                let found = plain(text, self.delimiter == b',');
                let after = found.as_ref().map(|found| text.as_bytes().get(found.length));
                // Most cells are numbers alone, which need no look at quotes and blanks.
                if after.is_some_and(|after| after.is_none_or(|byte| *byte == self.delimiter)) {
                    let (cell, left) = text.split_at(found.as_ref().map_or(0, |found| found.length));
                    self.cell(width - 1, cell, found);
                    (rest, filled) = (left.get(1..), width);
                } else {
                    let (cell, left) = first_cell(text, self.delimiter);
                    self.cell(width - 1, &cell, number(&cell));
                    (rest, filled) = (left, if cell.is_empty() { filled } else { width });
                }
            }
        }
        self.rows += 1;
        for column in &mut self.columns {
            column.values.resize(self.rows as usize, f64::NAN);
        }
        (width, filled)
    }

    /// Where a row has fewer cells than others, each belongs to the column below which it stands.
    fn push_between_blanks(&mut self, line: &str) -> usize {
        let cells = places(line);
        if cells.len() >= self.places.len() {
            cells.iter().enumerate().for_each(|(index, place)| self.cell_at(index, line, place));
            let width = cells.len();
            if width == self.places.len() {
                self.places = cells;
            }
            return width;
        }
        let below = |place: &Range<usize>| {
            let mut above = (0..self.places.len())
                .filter(|at| self.places[*at].start < place.end && place.start < self.places[*at].end);
            above.next().filter(|_| above.next().is_none())
        };
        let found: Vec<Option<usize>> = cells.iter().map(below).collect();
        if found.iter().all(Option::is_some) && found.windows(2).all(|pair| pair[0] < pair[1]) {
            found.iter().flatten().zip(&cells).for_each(|(index, place)| self.cell_at(*index, line, place));
        } else {
            self.unplaced += 1;
        }
        cells.len()
    }

    fn cell_at(&mut self, index: usize, line: &str, place: &Range<usize>) {
        let cell = &line[place.clone()];
        self.cell(index, cell, number(cell));
    }

    #[inline]
    fn cell(&mut self, index: usize, cell: &str, number: Option<Number>) {
        let row = self.rows;
        while self.columns.len() <= index {
            let values = vec![f64::NAN; row as usize];
            self.columns.push(Cells { values, blank: true, ..Cells::default() });
        }
        self.columns[index].push(row, cell, number, self.stated);
    }

    /// Appends the rows of another part of the text.
    pub fn append(&mut self, next: Grid) {
        let (rows, all) = (self.rows, (self.rows + next.rows) as usize);
        let mut parts = next.columns.into_iter();
        for column in &mut self.columns {
            if let Some(part) = parts.next() {
                column.append(part, rows);
            }
            column.values.resize(all, f64::NAN);
        }
        for part in parts {
            let mut column = Cells { values: vec![f64::NAN; rows as usize], blank: true, ..Cells::default() };
            column.append(part, rows);
            self.columns.push(column);
        }
        self.unplaced += next.unplaced;
        self.rows += next.rows;
    }

    /// Decides what is left undecided.
    pub fn finish(mut self) -> Vec<Cells> {
        let said =
            |format: usize| self.columns.iter().any(|c| c.certain[format].is_some() && c.certain[1 - format].is_none());
        // Between commas a comma is no decimal mark, so that a point is one where nothing says otherwise: 900 above 1.100 may.
        let elsewhere = match (said(0), said(1)) {
            (true, false) => Some(Format::Point),
            (false, true) => Some(Format::Comma),
            (false, false) if self.delimiter == b',' && !self.columns.iter().any(Cells::may_have_thousands) => {
                Some(Format::Point)
            }
            _ => None,
        };
        for column in &mut self.columns {
            column.decide(elsewhere);
        }
        self.columns
    }
}

impl Cells {
    fn push(&mut self, row: u32, cell: &str, number: Option<Number>, stated: Option<Format>) {
        self.blank &= cell.is_empty();
        let allowed = stated.map_or(POINT | COMMA, |format| [POINT, COMMA][format as usize]);
        let Some(number) = number.filter(|number| number.readings & allowed != 0) else {
            self.values.push(f64::NAN);
            if !is_missing(cell) {
                self.push_bad(row, cell);
            }
            return;
        };
        let found = number.readings & allowed;
        let comma = number.mark.map_or(found == COMMA, |mark| mark == b',');
        let thousands = number.mark.is_some() && found & [POINT, COMMA][usize::from(comma)] == 0;
        self.values.push(if thousands { in_thousands(number.value) } else { number.value });
        if found == POINT | COMMA {
            self.whole |= number.mark.is_none() && (100.0..1000.0).contains(&number.value.abs());
            if number.mark.is_some() {
                let same = self.either[usize::from(comma)].get_or_insert_with(|| (cell.into(), Vec::new()));
                if self.certain[usize::from(comma)].is_none() {
                    same.1.push(row);
                }
            }
        } else if stated.is_none() {
            self.certain[usize::from(comma)].get_or_insert_with(|| cell.into());
        }
    }

    /// Appends the cells of the rows after the first `rows`.
    fn append(&mut self, next: Cells, rows: u32) {
        self.values.extend_from_slice(&next.values);
        self.bad.0 += next.bad.0;
        if self.bad.1.is_empty() {
            self.bad.1 = next.bad.1;
        }
        self.moments.extend(next.moments.into_iter().map(|(row, moment)| (rows + row, moment)));
        self.blank &= next.blank;
        self.whole |= next.whole;
        for (own, other) in self.certain.iter_mut().zip(next.certain) {
            *own = own.take().or(other);
        }
        for (own, other) in self.either.iter_mut().zip(next.either) {
            let Some((cell, places)) = other else { continue };
            own.get_or_insert((cell, Vec::new())).1.extend(places.into_iter().map(|row| rows + row));
        }
    }

    fn push_bad(&mut self, row: u32, cell: &str) {
        self.bad.0 += 1;
        match Moment::parse(cell) {
            Some(moment) => self.moments.push((row, moment)),
            None if self.bad.1.is_empty() => self.bad.1 = cell.into(),
            None => {}
        }
    }

    fn may_have_thousands(&self) -> bool {
        self.either[1].is_some() || (self.whole && self.either[0].is_some())
    }

    fn decide(&mut self, elsewhere: Option<Format>) {
        let own = match &self.certain {
            [Some(point), Some(comma)] => return self.refuse(Decision::Mixed(point.clone(), comma.clone())),
            [Some(_), None] => Some(Format::Point),
            [None, Some(_)] => Some(Format::Comma),
            [None, None] => None,
        };
        let Some((example, _)) = self.either.iter().flatten().next() else { return };
        let Some(format) = own.or(elsewhere) else {
            return self.refuse(Decision::Undecided(example.clone()));
        };
        let Some((example, rows)) = &self.either[usize::from(format == Format::Point)] else { return };
        for row in rows {
            let value = &mut self.values[*row as usize];
            *value = in_thousands(*value);
        }
        if own.is_none() {
            self.decision = Decision::Thousands(example.clone());
        }
    }

    fn refuse(&mut self, decision: Decision) {
        self.values.fill(f64::NAN);
        self.decision = decision;
    }
}

/// Whether a cell says that there is no number.
pub fn is_missing(cell: &str) -> bool {
    MISSING.iter().any(|word| cell.eq_ignore_ascii_case(word))
}

/// A cell that is a number.
pub struct Number {
    /// Its letters.
    length: usize,
    /// Formats that explain it, as a set of [`POINT`] and [`COMMA`].
    readings: u8,
    /// The mark that is that of decimals, or parts off three digits.
    mark: Option<u8>,
    /// With this mark as that of decimals.
    value: f64,
}

/// The number that a cell is, in any format.
pub fn number(cell: &str) -> Option<Number> {
    plain(cell, false).filter(|number| number.length == cell.len()).or_else(|| in_groups(cell))
}

/// A number with three decimals whose mark is one of thousands.
fn in_thousands(value: f64) -> f64 {
    // The product is a whole number but for its rounding.
    (1e3 * value).round()
}

/// Powers of ten that a double holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];
/// Most digits of an integer that 64 bits hold in any case.
const MOST_DIGITS: usize = 19;

/// The plain number that a text begins with; `commas_part`: a comma ends it.
#[inline]
fn plain(text: &str, commas_part: bool) -> Option<Number> {
    let bytes = text.as_bytes();
    let digits = |from: usize, start: u64| {
        let (mut at, mut sum) = (from, start);
        while let Some(digit) = bytes.get(at).map(|byte| byte.wrapping_sub(b'0')).filter(|digit| *digit < 10) {
            sum = sum.wrapping_mul(10).wrapping_add(u64::from(digit));
            at += 1;
        }
        (at, sum)
    };
    let start = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let (whole, sum) = digits(start, 0);
    let mark = bytes.get(whole).copied().filter(|byte| *byte == b'.' || (*byte == b',' && !commas_part));
    let (end, sum) = mark.map_or((whole, sum), |_| digits(whole + 1, sum));
    let decimals = if mark.is_some() { end - whole - 1 } else { 0 };
    let known = whole - start + decimals;
    if known == 0 {
        return None;
    }
    let mut length = end;
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let power = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        length = digits(power, 0).0;
        if length == power {
            return None;
        }
    }
    let thousands = length == end && decimals == 3 && matches!(whole - start, 1..=3) && bytes[start] != b'0';
    let readings = match mark {
        None => POINT | COMMA,
        Some(b'.') => POINT | (COMMA * u8::from(thousands)),
        Some(_) => COMMA | (POINT * u8::from(thousands)),
    };
    // The quotient of two exact numbers is rounded once.
    let exact = length == end && known <= MOST_DIGITS && sum <= 1 << 53 && decimals < POWERS.len();
    let value = match (exact, mark) {
        (true, _) => (sum as f64 / POWERS[decimals]) * if bytes[0] == b'-' { -1.0 } else { 1.0 },
        (false, Some(b',')) => text[..length].replace(',', ".").parse().ok()?,
        (false, _) => text[..length].parse().ok()?,
    };
    Some(Number { length, readings, mark, value })
}

/// A number whose digits are parted by threes, and perhaps has decimals behind another mark.
fn in_groups(cell: &str) -> Option<Number> {
    let unsigned = cell.strip_prefix(['+', '-']).unwrap_or(cell);
    let last = unsigned.rfind(['.', ',']);
    let gap = unsigned.chars().find(|letter| GAPS.contains(letter));
    // The only mark of its kind at the end is that of decimals.
    let decimal =
        last.map(|at| unsigned.as_bytes()[at]).filter(|mark| unsigned.matches(char::from(*mark)).count() == 1);
    let (whole, part) = match (decimal, last) {
        (Some(_), Some(at)) => (&unsigned[..at], &unsigned[at + 1..]),
        _ => (unsigned, ""),
    };
    let mark = gap.or_else(|| whole.chars().find(|letter| matches!(letter, '.' | ',')))?;
    if !grouped(whole, mark) || !part.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let readings = match (decimal, mark) {
        (Some(b'.'), _) | (None, ',') => POINT,
        (Some(_), _) | (None, '.') => COMMA,
        _ => POINT | COMMA,
    };
    let value: f64 = format!("{}.{part}", whole.replace(mark, "")).parse().ok()?;
    let value = if cell.starts_with('-') { -value } else { value };
    Some(Number { length: cell.len(), readings, mark: None, value })
}

/// Whether the mark parts digits by threes, `1.234.567`.
fn grouped(digits: &str, mark: char) -> bool {
    let mut groups = digits.split(mark);
    let first = groups.next().unwrap_or("");
    let number = |group: &str| group.bytes().all(|b| b.is_ascii_digit());
    matches!(first.len(), 1..=3)
        && number(first)
        && !first.starts_with('0')
        && groups.all(|group| group.len() == 3 && number(group))
}
