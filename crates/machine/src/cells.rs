//! Cells of a text table as numbers. What a comma and a point mean is decided once per column, from all its cells and from
//! the other columns; a column that stays undecided has no numbers.

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
    /// Rows of the cells that are neither numbers nor missing, and the cells.
    pub bad: Vec<(usize, String)>,
    /// Whether all cells are empty.
    pub blank: bool,
    pub decision: Decision,
    /// First cell of each format that no other explains.
    certain: [Option<String>; 2],
    /// By mark, point and comma: the first cell that both formats explain differently, and the rows of all of them, whose
    /// values are those with decimals.
    either: [Option<(String, Vec<usize>)>; 2],
}

/// A table that grows row by row.
pub struct Table {
    delimiter: char,
    stated: Option<Format>,
    pub columns: Vec<Cells>,
    rows: usize,
}

const POINT: u8 = 1;
const COMMA: u8 = 2;
/// Marks of thousands that are no decimal marks.
const GAPS: [char; 5] = [' ', '\u{a0}', '\u{202f}', '\'', '\u{2019}'];
/// Cells that say that there is no number.
const MISSING: [&str; 12] = ["", "nan", "na", "n/a", "null", "inf", "-inf", "+inf", "#n/a", "-nan", "nil", "--"];

impl Table {
    /// An empty table; ` ` delimits by any white space. `stated` leaves nothing to decide.
    pub fn new(delimiter: char, stated: Option<Format>) -> Self {
        Table { delimiter, stated, columns: Vec::new(), rows: 0 }
    }

    /// Appends a line; returns the number of its cells, and that without empty ones at its end.
    pub fn push(&mut self, line: &str) -> (usize, usize) {
        let mut filled = 0;
        let (row, stated) = (self.rows, self.stated);
        let mut at = 0;
        let columns = &mut self.columns;
        each_cell(line, self.delimiter, |cell| {
            if columns.len() == at {
                columns.push(Cells { values: vec![f64::NAN; row], blank: true, ..Cells::default() });
            }
            columns[at].push(row, cell, stated);
            at += 1;
            filled = if cell.is_empty() { filled } else { at };
        });
        for short in &mut columns[at..] {
            short.values.push(f64::NAN);
        }
        self.rows += 1;
        (at, filled)
    }

    /// Decides what is left undecided.
    pub fn finish(mut self) -> Vec<Cells> {
        let said =
            |format: usize| self.columns.iter().any(|c| c.certain[format].is_some() && c.certain[1 - format].is_none());
        // Between commas a comma is no decimal mark, so that a point is one where nothing says otherwise.
        let elsewhere = match (said(0), said(1)) {
            (true, false) => Some(Format::Point),
            (false, true) => Some(Format::Comma),
            (false, false) if self.delimiter == ',' && !self.columns.iter().any(Cells::has_comma) => {
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
    fn push(&mut self, row: usize, cell: &str, stated: Option<Format>) {
        self.blank &= cell.is_empty();
        let found = readings(cell) & stated.map_or(POINT | COMMA, |format| [POINT, COMMA][format as usize]);
        let value = match found {
            0 => f64::NAN,
            POINT => value(cell, Format::Point),
            COMMA => value(cell, Format::Comma),
            _ => value(cell, if cell.contains(',') { Format::Comma } else { Format::Point }),
        };
        self.values.push(value);
        match found {
            0 if !is_missing(cell) => self.bad.push((row, cell.into())),
            POINT | COMMA if stated.is_none() => {
                self.certain[usize::from(found == COMMA)].get_or_insert_with(|| cell.into());
            }
            3 if cell.contains(['.', ',']) => {
                let same = &mut self.either[usize::from(cell.contains(','))];
                same.get_or_insert_with(|| (cell.into(), Vec::new())).1.push(row);
            }
            _ => {}
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
            self.values[*row] = (1e3 * self.values[*row]).round();
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

/// The cells of a line without blanks about them; quotes keep a delimiter inside, and end with the line at the latest.
pub fn each_cell(line: &str, delimiter: char, mut take: impl FnMut(&str)) {
    if delimiter == ' ' {
        line.split_whitespace().for_each(take);
        return;
    }
    if !line.contains('"') {
        line.split(delimiter).for_each(|cell| take(cell.trim()));
        return;
    }
    let (mut cell, mut quoted) = (String::new(), false);
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            // Two quotes inside of a quoted cell are one.
            '"' if quoted && letters.next_if_eq(&'"').is_some() => cell.push('"'),
            '"' if quoted || cell.trim().is_empty() => quoted = !quoted,
            _ if letter == delimiter && !quoted => {
                take(cell.trim());
                cell.clear();
            }
            _ => cell.push(letter),
        }
    }
    take(cell.trim());
}

/// Whether a cell says that there is no number.
pub fn is_missing(cell: &str) -> bool {
    MISSING.iter().any(|word| cell.eq_ignore_ascii_case(word))
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

    fn read(delimiter: char, lines: &[&str]) -> Vec<Cells> {
        let mut table = Table::new(delimiter, None);
        lines.iter().for_each(|line| {
            table.push(line);
        });
        table.finish()
    }

    #[test]
    fn every_cell_of_a_column_is_evidence() {
        for (delimiter, lines, wanted) in [
            (';', &["998,5", "1.001"][..], &[998.5, 1001.0][..]),
            (',', &["\"998.5\"", "\"1,001\""], &[998.5, 1001.0]),
            ('\t', &["1.001", "998,5", "-12"], &[1001.0, 998.5, -12.0]),
            (';', &["0.500", "1.250"], &[0.5, 1.25]),
            (';', &["1 234,5", "1'234,5", "1\u{202f}234\u{a0}567"], &[1234.5, 1234.5, f64::NAN]),
            (';', &["1.234.567,5", "1.5e3"], &[f64::NAN, f64::NAN]),
            (';', &["1.234e3", "2.000", "5.", ".5"], &[1234.0, 2.0, 5.0, 0.5]),
            (' ', &["1234.567", "1.001"], &[1234.567, 1.001]),
        ] {
            let found = read(delimiter, lines).remove(0);
            let same = found.values.iter().zip(wanted).all(|(a, b)| a == b || a.is_nan() && b.is_nan());
            assert!(same, "{lines:?}: {found:?}");
        }
    }

    #[test]
    fn other_columns_decide_where_a_column_cannot() {
        let of = |delimiter, lines: &[&str]| read(delimiter, lines).pop().unwrap();
        let thousands = of(';', &["0.5;2,500", "1.0;-1,250"]);
        assert_eq!(thousands.values, [2500.0, -1250.0]);
        assert_eq!(thousands.decision, Decision::Thousands("2,500".into()));
        assert_eq!(of(';', &["0,5;2,500", "1,0;-1,250"]).values, [2.5, -1.25]);
        assert_eq!(of(';', &["0,5;2.500", "1,0;-1.250"]).values, [2500.0, -1250.0]);
        assert_eq!(of(',', &["0,1.500", "1,1.250"]).values, [1.5, 1.25]);
        assert_eq!(of(';', &["0;1.500", "1;1.250"]).decision, Decision::Undecided("1.500".into()));
        assert_eq!(of(',', &["0,\"1,500\"", "1,\"1,250\""]).decision, Decision::Undecided("1,500".into()));
        assert_eq!(of(';', &["0;1,5", "1;2.5"]).decision, Decision::Mixed("2.5".into(), "1,5".into()));
    }

    #[test]
    fn a_stated_format_decides_and_refuses_what_it_does_not_explain() {
        let mut table = Table::new(';', Some(Format::Comma));
        for line in ["1.234", "0,5", "0.5", "x", ""] {
            table.push(line);
        }
        let found = table.finish().remove(0);
        assert_eq!(found.values[..2], [1234.0, 0.5]);
        assert_eq!(found.bad, [(2, "0.5".into()), (3, "x".into())]);
    }

    #[test]
    fn quotes_and_short_rows() {
        let mut found = Vec::new();
        each_cell("a, \"b, \"\"c\"\"\",\"d", ',', |cell| found.push(cell.to_string()));
        assert_eq!(found, ["a", "b, \"c\"", "d"]);
        let columns = read(',', &["1", "2,3", "4,", ""]);
        assert_eq!((columns.len(), columns[1].values[1], columns[1].values.len()), (2, 3.0, 4));
    }
}
