//! Names of variables in FMI's structured naming.

/// `supply.tank-pressure` becomes `supply.'tank-pressure'`: a part that is no identifier is quoted. A list index `[0]`
/// at the end is kept.
pub fn structured(name: &str) -> String {
    let (name, element) = match name.rfind('[') {
        Some(at) if name.ends_with(']') => name.split_at(at),
        _ => (name, ""),
    };
    let parts: Vec<String> = name.split('.').map(part).collect();
    parts.join(".") + element
}

fn part(text: &str) -> String {
    let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    let plain = text.starts_with(letter) && text.chars().all(|c| letter(c) || c.is_ascii_digit());
    if plain {
        return text.to_string();
    }
    // Letters that the standard's names do not have.
    let kept = |c: char| if c == ' ' || (c.is_ascii_graphic() && !"'\"\\`".contains(c)) { c } else { '_' };
    format!("'{}'", text.chars().map(kept).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::structured;

    #[test]
    fn identifiers_stay_and_everything_else_is_quoted() {
        assert_eq!(structured("cylinder.lift.p1"), "cylinder.lift.p1");
        assert_eq!(structured("supply.tank-pressure"), "supply.'tank-pressure'");
        assert_eq!(structured("friction.lift-seal.coulomb[1]"), "friction.'lift-seal'.coulomb[1]");
        assert_eq!(structured("joint.1.q"), "joint.'1'.q");
        assert_eq!(structured("joint.förare's.q"), "joint.'f_rare_s'.q");
    }
}
