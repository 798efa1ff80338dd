//! Cells of a text table as numbers. What a comma and a point mean is decided once per column, from all its cells and from
//! the other columns; a column that stays undecided has no numbers.

use crate::clock::Moment;
use crate::split::{first_cell, BLANK};

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
    /// First cell of each format that no other explains.
    certain: [Option<String>; 2],
    /// By mark, point and comma: the first cell that both formats explain differently, and the rows of all of them that may still become
    /// thousands; their values are those with decimals.
    either: [Option<(String, Vec<u32>)>; 2],
}

/// A table that grows row by row.
pub struct Grid {
    delimiter: u8,
    stated: Option<Format>,
    pub columns: Vec<Cells>,
    rows: u32,
}

const POINT: u8 = 1;
const COMMA: u8 = 2;
/// Marks of thousands that are no decimal marks.
const GAPS: [char; 5] = [' ', '\u{a0}', '\u{202f}', '\'', '\u{2019}'];
/// Cells that say that there is no number.
const MISSING: [&str; 12] = ["", "nan", "na", "n/a", "null", "inf", "-inf", "+inf", "#n/a", "-nan", "nil", "--"];

impl Grid {
    /// An empty table. `stated` leaves nothing to decide.
    pub fn new(delimiter: u8, stated: Option<Format>) -> Self {
        Grid { delimiter, stated, columns: Vec::new(), rows: 0 }
    }

    /// Appends a line; returns the number of its cells, and that without empty ones at its end.
    pub fn push(&mut self, line: &str) -> (usize, usize) {
        let (mut width, mut filled) = (0, 0);
        if self.delimiter == BLANK {
            for cell in line.split_whitespace() {
                self.cell(width, cell, plain(cell, false).filter(|number| number.length == cell.len()));
                width += 1;
            }
            filled = width;
        } else {
            let mut rest = Some(line);
            while let Some(text) = rest {
                let number = plain(text, self.delimiter == b',');
                let after = number.as_ref().and_then(|number| text.as_bytes().get(number.length));
                // Most cells are numbers alone, which need no look at quotes and blanks.
                let cell = match number {
                    Some(number) if after.is_none_or(|byte| *byte == self.delimiter) => {
                        let (cell, left) = text.split_at(number.length);
                        self.cell(width, cell, Some(number));
                        rest = left.get(1..);
                        filled = width + 1;
                        width += 1;
                        continue;
                    }
                    _ => first_cell(text, self.delimiter),
                };
                self.cell(width, &cell.0, plain(&cell.0, false).filter(|number| number.length == cell.0.len()));
                rest = cell.1;
                width += 1;
                filled = if cell.0.is_empty() { filled } else { width };
            }
        }
        for short in self.columns.iter_mut().skip(width) {
            short.values.push(f64::NAN);
        }
        self.rows += 1;
        (width, filled)
    }

    #[inline]
    fn cell(&mut self, index: usize, cell: &str, number: Option<Plain>) {
        let row = self.rows;
        if self.columns.len() == index {
            let values = vec![f64::NAN; row as usize];
            self.columns.push(Cells { values, blank: true, ..Cells::default() });
        }
        self.columns[index].push(row, cell, number, self.stated);
    }

    /// Decides what is left undecided.
    pub fn finish(mut self) -> Vec<Cells> {
        let said =
            |format: usize| self.columns.iter().any(|c| c.certain[format].is_some() && c.certain[1 - format].is_none());
        // Between commas a comma is no decimal mark, so that a point is one where nothing says otherwise.
        let elsewhere = match (said(0), said(1)) {
            (true, false) => Some(Format::Point),
            (false, true) => Some(Format::Comma),
            (false, false) if self.delimiter == b',' && !self.columns.iter().any(Cells::has_comma) => {
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
    fn push(&mut self, row: u32, cell: &str, number: Option<Plain>, stated: Option<Format>) {
        self.blank &= cell.is_empty();
        let every = number.as_ref().map_or_else(|| readings(cell), |number| number.readings);
        let found = every & stated.map_or(POINT | COMMA, |format| [POINT, COMMA][format as usize]);
        let format = match found {
            POINT => Format::Point,
            COMMA => Format::Comma,
            _ if cell.contains(',') => Format::Comma,
            _ => Format::Point,
        };
        self.values.push(match number {
            _ if found == 0 => f64::NAN,
            // One mark that this format takes for that of decimals.
            Some(Plain { value, mark, .. }) if mark.is_none_or(|mark| (mark == b',') == (format == Format::Comma)) => {
                value
            }
            _ => value(cell, format),
        });
        match found {
            0 if !is_missing(cell) => self.push_bad(row, cell),
            POINT | COMMA if stated.is_none() => {
                self.certain[format as usize].get_or_insert_with(|| cell.into());
            }
            3 if cell.contains(['.', ',']) => {
                let same = self.either[format as usize].get_or_insert_with(|| (cell.into(), Vec::new()));
                if self.certain[format as usize].is_none() {
                    same.1.push(row);
                }
            }
            _ => {}
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

    fn has_comma(&self) -> bool {
        self.either[1].is_some()
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
            // Three decimals at most, so that the product is a whole number but for its rounding.
            let value = &mut self.values[*row as usize];
            *value = (1e3 * *value).round();
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

/// A number of digits with at most one mark and a power of ten.
struct Plain {
    /// Its letters.
    length: usize,
    /// As [`readings`].
    readings: u8,
    mark: Option<u8>,
    /// With its mark as that of decimals.
    value: f64,
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
fn plain(text: &str, commas_part: bool) -> Option<Plain> {
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
    Some(Plain { length, readings, mark, value })
}

/// Formats that explain a cell, as a set of [`POINT`] and [`COMMA`]; none: it is no number.
pub fn readings(cell: &str) -> u8 {
    let unsigned = cell.strip_prefix(['+', '-']).unwrap_or(cell);
    let (digits, power) = match unsigned.split_once(['e', 'E']) {
        Some((digits, power)) => (digits, Some(power.strip_prefix(['+', '-']).unwrap_or(power))),
        None => (unsigned, None),
    };
    if power.is_some_and(|power| power.is_empty() || !power.bytes().all(|b| b.is_ascii_digit())) {
        return 0;
    }
    let gap = digits.chars().find(|letter| GAPS.contains(letter));
    let (mut points, mut commas, mut last) = (0, 0, None);
    for letter in digits.chars() {
        match letter {
            '.' => (points, last) = (points + 1, Some('.')),
            ',' => (commas, last) = (commas + 1, Some(',')),
            _ if letter.is_ascii_digit() || Some(letter) == gap => {}
            _ => return 0,
        }
    }
    if !digits.contains(|letter: char| letter.is_ascii_digit()) {
        return 0;
    }
    let whole = digits.split(['.', ',']).next().unwrap_or(digits);
    if gap.is_some_and(|gap| !grouped(whole, gap) || digits[whole.len()..].contains(gap) || points + commas > 1) {
        return 0;
    }
    let thousands = |mark| u8::from(power.is_none() && gap.is_none() && grouped(digits, mark));
    let before = |mark| digits.rsplit_once(mark).map_or("", |(before, _)| before);
    match (points, commas) {
        (0, 0) => POINT | COMMA,
        (1, 0) => POINT | (COMMA * thousands('.')),
        (0, 1) => COMMA | (POINT * thousands(',')),
        (_, 0) => COMMA * thousands('.'),
        (0, _) => POINT * thousands(','),
        (_, 1) if last == Some(',') => COMMA * u8::from(grouped(before(','), '.')),
        (1, _) if last == Some('.') => POINT * u8::from(grouped(before('.'), ',')),
        _ => 0,
    }
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

/// The number that a cell is in a format that explains it.
fn value(cell: &str, format: Format) -> f64 {
    if let Ok(value) = cell.parse() {
        if format == Format::Point {
            return value;
        }
    }
    let thousands = if format == Format::Point { ',' } else { '.' };
    let plain: String = cell.chars().filter(|letter| *letter != thousands && !GAPS.contains(letter)).collect();
    plain.replace(',', ".").parse().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(delimiter: u8, lines: &[&str]) -> Vec<Cells> {
        let mut table = Grid::new(delimiter, None);
        lines.iter().for_each(|line| {
            table.push(line);
        });
        table.finish()
    }

    #[test]
    fn every_cell_of_a_column_is_evidence() {
        for (delimiter, lines, wanted) in [
            (b';', &["998,5", "1.001"][..], &[998.5, 1001.0][..]),
            (b',', &["\"998.5\"", "\"1,001\""], &[998.5, 1001.0]),
            (b'\t', &["1.001", "998,5", "-12"], &[1001.0, 998.5, -12.0]),
            (b';', &["0.500", "1.250"], &[0.5, 1.25]),
            (b';', &["1.250", "0.500", "1.250"], &[1.25, 0.5, 1.25]),
            (b';', &["1 234,5", "1'234,5", "1\u{202f}234\u{a0}567"], &[1234.5, 1234.5, f64::NAN]),
            (b';', &["1.234.567,5", "1.5e3"], &[f64::NAN, f64::NAN]),
            (b';', &["1.234e3", "2.000", "5.", ".5"], &[1234.0, 2.0, 5.0, 0.5]),
            (b';', &["1,234e3", "2,5E-1", "1.000"], &[1234.0, 0.25, 1000.0]),
            (b' ', &["1234.567", "1.001"], &[1234.567, 1.001]),
        ] {
            let found = read(delimiter, lines).remove(0);
            let same = found.values.iter().zip(wanted).all(|(a, b)| a == b || a.is_nan() && b.is_nan());
            assert!(same, "{lines:?}: {found:?}");
        }
    }

    #[test]
    fn other_columns_decide_where_a_column_cannot() {
        let of = |delimiter, lines: &[&str]| read(delimiter, lines).pop().unwrap();
        let thousands = of(b';', &["0.5;2,500", "1.0;-1,250"]);
        assert_eq!(thousands.values, [2500.0, -1250.0]);
        assert_eq!(thousands.decision, Decision::Thousands("2,500".into()));
        assert_eq!(of(b';', &["0,5;2,500", "1,0;-1,250"]).values, [2.5, -1.25]);
        assert_eq!(of(b';', &["0,5;2.500", "1,0;-1.250"]).values, [2500.0, -1250.0]);
        assert_eq!(of(b',', &["0,1.500", "1,1.250"]).values, [1.5, 1.25]);
        assert_eq!(of(b';', &["0;1.500", "1;1.250"]).decision, Decision::Undecided("1.500".into()));
        assert_eq!(of(b',', &["0,\"1,500\"", "1,\"1,250\""]).decision, Decision::Undecided("1,500".into()));
        assert_eq!(of(b';', &["0;1,5", "1;2.5"]).decision, Decision::Mixed("2.5".into(), "1,5".into()));
    }

    #[test]
    fn a_stated_format_decides_and_refuses_what_it_does_not_explain() {
        let mut table = Grid::new(b';', Some(Format::Comma));
        for line in ["1.234", "0,5", "0.5", "x", ""] {
            table.push(line);
        }
        let found = table.finish().remove(0);
        assert_eq!(found.values[..2], [1234.0, 0.5]);
        assert_eq!(found.bad, (2, "0.5".into()));
    }

    #[test]
    fn short_rows_and_empty_cells() {
        let columns = read(b',', &["1", "2,3", "4,", ""]);
        assert_eq!((columns.len(), columns[1].values[1], columns[1].values.len()), (2, 3.0, 4));
        let mut grid = Grid::new(b';', None);
        assert_eq!([grid.push("1;x;;"), grid.push(" 2 ; 3"), grid.push("")], [(4, 2), (2, 2), (1, 0)]);
    }

    #[test]
    fn plain_numbers_have_the_same_bits_as_those_of_the_standard_library() {
        let mut seed = 1_u64;
        for digits in 1..25 {
            for _ in 0..200 {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let text = format!("{seed:020}{seed:020}");
                let at = (seed >> 32) as usize % (digits + 1);
                let text = format!("-{}.{}", &text[..at], &text[at..digits]);
                for text in [format!("{text}e-07"), format!("{text}E12"), text] {
                    let Some(found) = plain(&text, false) else { panic!("{text}") };
                    assert_eq!(
                        (found.value.to_bits(), found.length),
                        (text.parse::<f64>().unwrap().to_bits(), text.len())
                    );
                    assert_eq!(found.readings, readings(&text), "{text}");
                }
            }
        }
        for text in ["", "-", ".", "e5", "1e", "1e+", "+.e1", "x1"] {
            assert!(plain(text, false).is_none(), "{text}");
        }
    }
}
