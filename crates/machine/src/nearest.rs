//! The valid name nearest to a misspelt one.

/// Help text for an unknown `name`: the nearest candidate, or the list of all of them.
pub fn suggestion<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    match nearest(name, &candidates) {
        Some(candidate) => format!("did you mean `{candidate}`?"),
        None if candidates.is_empty() => "there is none to choose from".into(),
        None => format!("valid: {}", candidates.join(", ")),
    }
}

/// As [`suggestion`] for symbols of units, which are so short that two letters make another unit: the one that differs in case, or in
/// one letter beside a right one. Each comes with how far a value in it is from what is usual: 0 usual, 1 near, 2 never meant.
pub fn symbol_suggestion(symbol: &str, candidates: &[(&str, u8)]) -> String {
    let letters = |text: &str| text.chars().count();
    let slips = candidates.iter().filter_map(|(candidate, size)| {
        let wrong = distance(symbol, candidate);
        let slip = *size < 2 && wrong <= 1 && wrong < letters(symbol).max(letters(candidate));
        let other = (letters(symbol).abs_diff(letters(candidate)), other_letters(symbol, candidate));
        slip.then_some(((wrong, *size, other), *candidate))
    });
    match slips.min() {
        Some((_, candidate)) => format!("did you mean `{candidate}`?"),
        None if candidates.is_empty() => "there is none to choose from".into(),
        None => format!("valid: {}", candidates.iter().map(|(candidate, _)| *candidate).collect::<Vec<_>>().join(", ")),
    }
}

/// The choice named `text`, or the help that names the nearest one.
pub fn choose<T: Copy>(text: &str, choices: &[(&str, T)]) -> Result<T, String> {
    let found = choices.iter().find(|(name, _)| *name == text).map(|(_, choice)| *choice);
    found.ok_or_else(|| suggestion(text, choices.iter().map(|(name, _)| *name)))
}

/// The candidate that `name` begins, or the one at the smallest edit distance, when it is close enough to be meant. Of equally near ones,
/// the one of the same length: a wrong letter is more common than a missing one; then the one with most letters in the same case.
fn nearest<'a>(name: &str, candidates: &[&'a str]) -> Option<&'a str> {
    // For long generated names the quadratic distance would be slow.
    if name.chars().count() > 64 {
        return None;
    }
    let begun = candidates.iter().find(|candidate| name.len() >= LEAST_BEGINNING && candidate.starts_with(name));
    if let Some(candidate) = begun {
        return Some(candidate);
    }
    candidates
        .iter()
        .map(|candidate| (distance(name, candidate), *candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.chars().count() / 3)
        .min_by_key(|(distance, candidate)| {
            (*distance, candidate.len().abs_diff(name.len()), other_letters(name, candidate))
        })
        .map(|(_, candidate)| candidate)
}

/// Places with different letters, counting case.
fn other_letters(a: &str, b: &str) -> usize {
    a.chars().zip(b.chars()).filter(|(a, b)| a != b).count()
}

/// Letters that tell which name was meant.
const LEAST_BEGINNING: usize = 4;

/// Levenshtein distance, ignoring letter case and the difference of `_` and `-`.
fn distance(a: &str, b: &str) -> usize {
    let fold = |c: char| if c == '_' { '-' } else { c.to_ascii_lowercase() };
    let b: Vec<char> = b.chars().map(fold).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().map(fold).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_finds_its_word() {
        assert_eq!(suggestion("boar", ["bore", "stroke"]), "did you mean `bore`?");
        assert_eq!(suggestion("rod_diameter", ["rod-diameter", "bore"]), "did you mean `rod-diameter`?");
    }

    #[test]
    fn a_beginning_finds_the_whole() {
        assert_eq!(
            suggestion("vertical-lift", ["tip-vertical-line", "vertical-lift-open-loop"]),
            "did you mean `vertical-lift-open-loop`?"
        );
    }

    #[test]
    fn a_likely_choice_comes_first() {
        assert_eq!(suggestion("mn", ["m", "mm", "MN"]), "did you mean `MN`?");
        assert_eq!(symbol_suggestion("mn", &[("m", 1), ("mm", 0)]), "did you mean `mm`?");
        assert_eq!(symbol_suggestion("S", &[("ms", 0), ("s", 1)]), "did you mean `s`?");
        assert_eq!(symbol_suggestion("barr", &[("bar", 2), ("mbar", 0)]), "valid: bar, mbar");
        assert_eq!(symbol_suggestion("SUS", &[("cSt", 0), ("Pas", 0)]), "valid: cSt, Pas");
    }

    #[test]
    fn nonsense_lists_the_choices() {
        assert_eq!(suggestion("zzzzzzzz", ["bore", "stroke"]), "valid: bore, stroke");
    }
}
