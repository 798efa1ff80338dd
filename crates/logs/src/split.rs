//! Lines of a text, and cells of a line.

use std::borrow::Cow;

/// Delimits cells by any white space.
pub const BLANK: u8 = b' ';

/// The lines of a text that ends them with `\n`, `\r\n` or `\r`.
pub fn lines(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = Some(text);
    std::iter::from_fn(move || {
        let all = rest.filter(|text| !text.is_empty())?;
        let Some(end) = memchr::memchr2(b'\n', b'\r', all.as_bytes()) else { return rest.take() };
        let (line, after) = all.split_at(end);
        rest = after.strip_prefix("\r\n").or_else(|| after.get(1..));
        Some(line)
    })
}

/// The first cell without blanks about it, and what follows its delimiter. Quotes keep a delimiter inside; a quote that nothing closes
/// ends with the line.
pub fn first_cell(text: &str, delimiter: u8) -> (Cow<'_, str>, Option<&str>) {
    let end = memchr::memchr(delimiter, text.as_bytes());
    let plain = &text[..end.unwrap_or(text.len())];
    if !plain.contains('"') {
        return (Cow::Borrowed(plain.trim()), end.map(|end| &text[end + 1..]));
    }
    let trimmed = |cell: String| Cow::Owned(cell.trim().to_string());
    let (mut cell, mut quoted, mut blank) = (String::new(), false, true);
    let mut letters = text.char_indices().peekable();
    while let Some((at, letter)) = letters.next() {
        match letter {
            // Two quotes inside of a quoted cell are one.
            '"' if quoted && letters.next_if(|(_, next)| *next == '"').is_some() => cell.push('"'),
            '"' if quoted || blank => {
                quoted = !quoted;
                continue;
            }
            _ if letter == char::from(delimiter) && !quoted => return (trimmed(cell), Some(&text[at + 1..])),
            _ => cell.push(letter),
        }
        blank &= letter.is_whitespace();
    }
    (trimmed(cell), None)
}

/// The cells of a line.
pub fn cells_of(line: &str, delimiter: u8) -> Vec<Cow<'_, str>> {
    if delimiter == BLANK {
        return line.split_whitespace().map(Cow::Borrowed).collect();
    }
    let (mut cells, mut rest) = (Vec::new(), Some(line));
    while let Some(text) = rest {
        let (cell, left) = first_cell(text, delimiter);
        cells.push(cell);
        rest = left;
    }
    cells
}
