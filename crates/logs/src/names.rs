//! Names of columns.

use crate::split::{cells_of, BLANK};

/// `x [mm]` or `p1 (bar(g))` as name and unit, without the brackets; the unit is empty if there is none. A number in square brackets
/// counts the columns of a matrix.
pub fn split_name(text: &str) -> (&str, &str) {
    let text = text.trim();
    let opened = match text.as_bytes().last() {
        Some(b']') => text.rfind('['),
        Some(b')') => opening(text),
        _ => None,
    };
    let Some(at) = opened else { return (text, "") };
    let (name, unit) = (text[..at].trim_end(), &text[at + 1..text.len() - 1]);
    let counts = text.ends_with(']') && !unit.is_empty() && unit.bytes().all(|b| b.is_ascii_digit());
    match name.is_empty() || counts || unit.contains(']') {
        true => (text, ""),
        false => (name, unit.trim()),
    }
}

/// Where the bracket opens that the last letter closes; one pair more may lie inside.
fn opening(text: &str) -> Option<usize> {
    let mut depth = 0;
    for (at, letter) in text.bytes().enumerate().rev() {
        match letter {
            b')' => depth += 1,
            b'(' => depth -= 1,
            _ => {}
        }
        if depth == 0 || depth > 2 {
            return Some(at).filter(|_| depth == 0);
        }
    }
    None
}

/// The names in a line between blanks: as many as there are columns, if they are parted by blanks, by another delimiter, or by wide
/// gaps; a bracket belongs to the name before it.
pub fn names_of(line: &str, delimiter: u8, width: usize) -> Vec<String> {
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
    let ways = [by(b','), by(b';'), by(b'\t'), words.clone(), gaps, joined];
    ways.into_iter().find(|names| names.len() == width).unwrap_or(words)
}
