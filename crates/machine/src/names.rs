//! The rule for names, and that for texts. Names of files travel: they become names of other files, keys, comments of programs, elements
//! of XML and labels of charts, on every system. What none of these takes is refused where a file is read.

/// Most letters of a name: with what is put around it, it stays below what file systems take.
const MOST_LETTERS: usize = 64;

/// What is wrong with a name, and the cure; `None` if it is one.
pub fn name_fault(name: &str) -> Option<(String, String)> {
    let letters = name.chars().count();
    let fault = if name.is_empty() {
        "a name has at least one letter".into()
    } else if let Some(c) = name.chars().find(|c| !is_of_names(*c)) {
        format!("{} is no part of a name", shown(c))
    } else if letters > MOST_LETTERS {
        format!("a name of {letters} letters; it has at most {MOST_LETTERS}")
    } else if name.starts_with('.') {
        format!("`{name}` begins with a dot, which hides files")
    } else if is_device(name) {
        format!("`{name}` is the name of a device on Windows")
    } else {
        return None;
    };
    Some((fault, format!("use letters, digits, `-`, `_` and `.`, for example `{}`", valid(name))))
}

/// Whether no text has this character: it controls a terminal or the direction of writing, by which a text shows another one than it holds,
/// or Unicode reserves it, so that no XML takes it.
pub fn is_strange(c: char) -> bool {
    let reserved = c as u32 & 0xFFFE == 0xFFFE || matches!(c, '\u{FDD0}'..='\u{FDEF}');
    c.is_control() || reserved || matches!(c, '\u{2028}'..='\u{202E}' | '\u{2066}'..='\u{2069}')
}

/// What is wrong with a text of one line; `None` if nothing is.
pub fn text_fault(text: &str) -> Option<String> {
    let strange = text.chars().find(|c| is_strange(*c))?;
    Some(format!("the control character U+{:04X} is no part of a name or text", strange as u32))
}

/// The text with what is strange in it as its number.
pub fn escaped(text: &str) -> String {
    let part = |c: char| if is_strange(c) { c.escape_unicode().collect() } else { c.to_string() };
    text.chars().map(part).collect()
}

fn is_of_names(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '-' | '_' | '.') || is_mark(c)
}

/// Whether it is an accent or a vowel sign that joins the letter before it: such a character alone is escaped only at the beginning of a text.
fn is_mark(c: char) -> bool {
    c.escape_debug().len() > 1 && format!("a{c}").escape_debug().count() == 2
}

/// Whether Windows takes a file of this name for a device, whatever its suffix.
pub fn is_device(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_ascii_uppercase();
    let numbered = ["COM", "LPT"].iter().find_map(|port| stem.strip_prefix(port));
    let is_number = |rest: &str| rest.chars().count() == 1 && rest.chars().all(|c| "0123456789¹²³".contains(c));
    matches!(stem.as_str(), "CON" | "PRN" | "AUX" | "NUL" | "CONIN$" | "CONOUT$") || numbered.is_some_and(is_number)
}

/// A character as messages show it.
fn shown(c: char) -> String {
    match c {
        ' ' => "a space".into(),
        '`' => "a backtick".into(),
        _ if is_strange(c) => format!("U+{:04X}", c as u32),
        _ => format!("`{c}`"),
    }
}

/// The name nearest to `name`: with hyphens for what is not allowed.
fn valid(name: &str) -> String {
    let parts = name.split(|c| !is_of_names(c)).map(|part| part.trim_matches('.')).filter(|part| !part.is_empty());
    let kept: String = parts.collect::<Vec<_>>().join("-").chars().take(MOST_LETTERS).collect();
    match kept.as_str() {
        "" => "crane-2".into(),
        name if is_device(name) => format!("my-{name}"),
        _ => kept,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_any_script_are_names() {
        let long = "x".repeat(MOST_LETTERS);
        for name in [
            "lift",
            "crane---v2",
            "-x",
            "a..b",
            "Größe",
            "Gro\u{308}ße",
            "кран",
            "起重机",
            "क्रेन",
            "رافعة",
            "٣",
            "com",
            "console",
            "nul-1",
            &long,
        ] {
            assert_eq!(name_fault(name), None, "{name}");
        }
    }

    #[test]
    fn what_is_no_name_is_reported_with_one_that_is() {
        let long = "ü".repeat(MOST_LETTERS + 1);
        for (name, words, nearest) in [
            ("", "at least one", "`crane-2`"),
            ("a b", "a space", "`a-b`"),
            ("x*/ system(\"id\"); /*", "`*`", "`x-system-id`"),
            ("../../../x", "`/`", "`x`"),
            ("/abs/x", "`/`", "`abs-x`"),
            ("C:\\x", "`:`", "`C-x`"),
            (".hidden", "begins with a dot", "`hidden`"),
            ("..", "begins with a dot", "`crane-2`"),
            ("NUL", "device", "`my-NUL`"),
            ("com1.toml", "device", "`my-com1.toml`"),
            ("LPT²", "device", "`my-LPT²`"),
            ("[/bold]", "`[`", "`bold`"),
            ("$\\frac{$", "`$`", "`frac`"),
            ("=HYPERLINK(1)", "`=`", "`HYPERLINK-1`"),
            ("a\u{1b}[31m", "U+001B", "`a-31m`"),
            ("a\u{202e}b", "U+202E", "`a-b`"),
            ("a\u{fffe}b", "U+FFFE", "`a-b`"),
            ("a\u{200d}b", "no part", "`a-b`"),
            ("🚜", "`🚜`", "`crane-2`"),
            (&long, "65 letters", "`üü"),
        ] {
            let (fault, cure) = name_fault(name).unwrap_or_else(|| panic!("`{name}` was taken"));
            assert!(fault.contains(words) && cure.contains(nearest), "{name}: {fault}; {cure}");
            let nearest = cure.rsplit('`').nth(1).expect("one");
            assert_eq!(name_fault(nearest), None, "{cure}");
        }
    }

    #[test]
    fn texts_have_no_character_of_control_or_of_none() {
        for text in [
            "a\0",
            "a\u{1b}[2J",
            "\u{7f}",
            "\u{9b}",
            "\u{202e}",
            "\u{2066}",
            "\u{2028}",
            "\u{fffe}",
            "\u{1ffff}",
            "\u{fdd0}",
            "a\nb",
        ] {
            assert!(text_fault(text).is_some(), "{text:?}");
        }
        for text in ["Kran № 1 „groß“ = 5 < 6 & 7", "=HYPERLINK(1)", "$\\frac{$", "[/bold]", "🚜 \u{200d}", "\u{feff}"]
        {
            assert_eq!(text_fault(text), None, "{text}");
        }
    }
}
