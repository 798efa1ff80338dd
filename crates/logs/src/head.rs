//! What stands above the numbers: the delimiter, titles, names and units.

use crate::cells::{is_missing, number};
use crate::clock::Moment;
use crate::split::{cells_of, BLANK};
use std::borrow::Cow;

/// Blanks come last, because they also follow other delimiters and occur within titles.
const DELIMITERS: [u8; 4] = [b'\t', b';', b',', BLANK];

/// The lines above the numbers.
pub struct Head {
    /// Of the first columns; a name or a unit may be empty.
    pub names: Vec<String>,
    pub units: Vec<String>,
    /// Number of columns that have a name; without names the usual number of cells of a row.
    pub width: usize,
    /// Lines before the first row of numbers.
    pub lines: usize,
}

/// The delimiter that splits most lines into the same number of cells, with numbers in them; one column needs none.
pub fn delimiter(lines: &[&str]) -> u8 {
    let (mut best, mut score) = (b',', (0, 0));
    for candidate in DELIMITERS {
        let rows: Vec<_> = lines.iter().map(|line| cells_of(line, candidate)).collect();
        let (width, count) = usual(rows.iter().map(Vec::len));
        if width == 1 || 2 * count <= lines.len() {
            continue;
        }
        // What parts every line alike, and is part of no number, parts them more surely than blanks, which leave empty cells out.
        if candidate == BLANK && matches!(best, b'\t' | b';') && score.1 == lines.len() {
            continue;
        }
        let filled = rows.iter().filter(|row| row.len() == width).flatten().filter(|cell| !is_missing(cell));
        let (all, numbers) =
            filled.fold((0, 0), |(all, numbers), cell| (all + 1, numbers + usize::from(is_value(cell))));
        // In tenths: a few words more or fewer decide nothing.
        let share = (20 * numbers + all) / (2 * all).max(1);
        if (share, count) > score && !(candidate == BLANK && share == 0) {
            (best, score) = (candidate, (share, count));
        }
    }
    best
}

/// The most frequent number, the first of several, and how often it occurs.
fn usual(counts: impl Iterator<Item = usize>) -> (usize, usize) {
    let mut found: Vec<(usize, usize)> = Vec::new();
    for number in counts {
        match found.iter_mut().find(|(known, _)| *known == number) {
            Some((_, count)) => *count += 1,
            None => found.push((number, 1)),
        }
    }
    found.into_iter().rev().max_by_key(|(_, count)| *count).unwrap_or((1, 0))
}

impl Head {
    /// The head of a table that begins with `lines`. The header is the first row of words that is as wide as the rows of numbers, with only
    /// titles above it. Without such a row it is the comment above the numbers, if that has as many names as there are columns.
    pub fn of(lines: &[&str], delimiter: u8, comment: impl Fn(&str) -> Option<String>) -> Self {
        let rows: Vec<_> = lines.iter().map(|line| cells_of(line, delimiter)).collect();
        let numbers = rows.iter().filter(|row| row.iter().any(|cell| number(cell).is_some())).map(Vec::len);
        let width = match usual(numbers) {
            (_, 0) => rows.iter().map(Vec::len).max().unwrap_or(1),
            (width, _) => width,
        };
        let mut first = None;
        for (i, row) in rows.iter().enumerate() {
            let words = match delimiter {
                BLANK => words(&names_of(lines[i], delimiter, width)),
                _ => words(row),
            };
            // A row of words half as wide: names, if decimal commas split each number into two; a title, if names follow.
            if 2 * words > width || (2 * words == width && first.is_none()) {
                first = Some(i);
            }
            if 2 * words > width || (words == 0 && !is_title(row, width)) {
                break;
            }
        }
        let Some(first) = first else {
            let start = rows.iter().position(|row| !is_title(row, width)).unwrap_or(0);
            let names = lines.get(start).and_then(|line| comment(line)).map(|line| names_of(&line, BLANK, width));
            let names = names.filter(|names| names.len() == width && 2 * words(names) > width).unwrap_or_default();
            return Head { names, units: Vec::new(), width, lines: start };
        };
        let names = names_of(lines[first], delimiter, width);
        let units = lines.get(first + 1).map(|line| names_of(line, delimiter, width)).filter(|cells| are_units(cells));
        let lines = first + 1 + usize::from(units.is_some());
        Head { width: names.len(), names, lines, units: units.unwrap_or_default() }
    }
}

fn is_value(cell: &str) -> bool {
    // A date alone is rather part of a title.
    number(cell).is_some() || (cell.contains(':') && Moment::parse(cell).is_some())
}

/// Number of cells of a row that are words; zero if one is a number or all are missing.
fn words<S: AsRef<str>>(row: &[S]) -> usize {
    if row.iter().any(|cell| is_value(cell.as_ref())) || row.iter().all(|cell| is_missing(cell.as_ref())) {
        return 0;
    }
    row.iter().filter(|cell| !cell.as_ref().is_empty()).count()
}

/// A line above the table: narrower than it, or with a word in it.
fn is_title(row: &[Cow<'_, str>], width: usize) -> bool {
    let mut filled = row.iter().filter(|cell| !cell.is_empty());
    let first = filled.next();
    2 * (usize::from(first.is_some()) + filled.count()) <= width
        || first.is_none_or(|cell| !is_value(cell) && !is_missing(cell))
}

/// Whether all cells are words, except the 1 of a ratio.
fn are_units(cells: &[String]) -> bool {
    let word = |cell: &String| cell == "-" || !(is_value(cell) || is_missing(cell));
    cells.iter().any(word) && cells.iter().all(|cell| ["", "1", "--"].contains(&cell.as_str()) || word(cell))
}

/// The names in a line between blanks: as many as there are columns, if they are parted by blanks, by another delimiter, or by wide
/// gaps; a bracket belongs to the name before it.
fn names_of(line: &str, delimiter: u8, width: usize) -> Vec<String> {
    if delimiter != BLANK {
        return cells_of(line, delimiter).into_iter().map(Into::into).collect();
    }
    let words: Vec<String> = line.split_whitespace().map(str::to_string).collect();
    let by = |delimiter: u8| cells_of(line, delimiter).into_iter().map(Into::into).collect::<Vec<String>>();
    let gaps = line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).map(str::to_string).collect();
    let mut joined: Vec<String> = Vec::new();
    for word in &words {
        match joined.last_mut().filter(|_| word.starts_with(['[', '('])) {
            Some(name) => *name = format!("{name} {word}"),
            None => joined.push(word.clone()),
        }
    }
    let splits = [by(b','), by(b';'), by(b'\t'), words.clone(), gaps, joined];
    splits.into_iter().find(|names| names.len() == width).unwrap_or(words)
}
