//! Damages a TOML file so that it is still nearly one.

use super::{one_of, pick};
use hydrocrane_num::RandomStream;

/// Values that no key expects.
const EXTREMES: [&str; 30] = [
    "0",
    "-1",
    "1",
    "1e-300",
    "1e300",
    "-1e300",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "1e400",
    "5e-324",
    "1e-9",
    "1e9",
    "1e6",
    "1e-6",
    "0.1",
    "100",
    "true",
    "\"\"",
    "[]",
    "{}",
    "\"nan m\"",
    "\"1e300 bar\"",
    "\"-1 kg\"",
    "\"0 m\"",
    "\"1e-300 s\"",
    "1979-05-27",
];
const UNITS: [&str; 24] = [
    "m", "mm", "um", "km", "bar", "Pa", "MPa", "GPa", "kg", "t", "s", "ms", "h", "rad", "deg", "N", "kN", "l", "m^3",
    "l/min", "m/s", "Hz", "%", "furlong",
];
const FACTORS: [f64; 16] =
    [0.0, -1.0, 1e-300, 1e300, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9, 0.01, 0.1, 0.5, 2.0, 10.0, 100.0];
const DEEP: usize = 20_000;
const LONG: usize = 300_000;

/// One of `files` with one to four damages, most often with one.
pub fn text(random: &mut RandomStream, files: &[String]) -> String {
    let mut text = one_of(random, files).clone();
    let many = random.uniform();
    for _ in 0..=(4.0 * many * many * many) as usize {
        text = damaged(random, &text, files);
    }
    text
}

/// `text` with one damage.
pub fn damaged(random: &mut RandomStream, text: &str, files: &[String]) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
    if lines.is_empty() {
        lines.push(String::new());
    }
    match pick(random, 50) {
        0..=24 => number(random, &mut lines),
        25..=30 => {
            let extreme = *one_of(random, &EXTREMES);
            value(random, &mut lines, extreme);
        }
        31 | 32 => unit(random, &mut lines),
        33..=35 => {
            let other = value_of(&lines[pick(random, lines.len())]).unwrap_or_default().to_string();
            value(random, &mut lines, &other);
        }
        36 | 37 => drop(lines.remove(pick(random, lines.len()))),
        38 => {
            let copy = lines[pick(random, lines.len())].clone();
            lines.insert(pick(random, lines.len()), copy);
        }
        39 => {
            let (one, other) = (pick(random, lines.len()), pick(random, lines.len()));
            lines.swap(one, other);
        }
        40 | 41 => table(random, &mut lines),
        42 => {
            let other = one_of(random, files).lines().map(str::to_string).collect::<Vec<_>>();
            lines.insert(pick(random, lines.len()), one_of(random, &other).clone());
        }
        43 | 44 => key(random, &mut lines),
        45 => return bytes(random, text),
        46 | 47 => {
            let other = one_of(random, files).clone();
            return spliced(random, text, &other);
        }
        48 => deep(random, &mut lines),
        _ => long(random, &mut lines),
    }
    lines.join("\n") + "\n"
}

/// The part of a line after its equals sign.
fn value_of(line: &str) -> Option<&str> {
    if line.trim_start().starts_with('#') {
        return None;
    }
    line.split_once(" = ").map(|(_, value)| value)
}

/// A random line that has a value.
fn keyed(random: &mut RandomStream, lines: &[String]) -> Option<usize> {
    let all: Vec<usize> = (0..lines.len()).filter(|&i| value_of(&lines[i]).is_some()).collect();
    (!all.is_empty()).then(|| all[pick(random, all.len())])
}

fn value(random: &mut RandomStream, lines: &mut [String], new: &str) {
    let Some(at) = keyed(random, lines) else { return };
    if let Some((key, _)) = lines[at].split_once(" = ") {
        lines[at] = format!("{key} = {new}");
    }
}

/// Start and end of each run of digits with point, sign and exponent.
fn numbers(line: &str) -> Vec<(usize, usize)> {
    let bytes = line.as_bytes();
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let begins = bytes[at].is_ascii_digit()
            && (at == 0 || !(bytes[at - 1].is_ascii_alphanumeric() || bytes[at - 1] == b'_'));
        if !begins {
            at += 1;
            continue;
        }
        let start = at;
        while at < bytes.len() && (bytes[at].is_ascii_digit() || bytes[at] == b'.') {
            at += 1;
        }
        found.push((start, at));
    }
    found
}

/// Another number in its place, or the same one times a factor.
fn number(random: &mut RandomStream, lines: &mut [String]) {
    let all: Vec<usize> =
        (0..lines.len()).filter(|&i| value_of(&lines[i]).is_some_and(|v| !numbers(v).is_empty())).collect();
    if all.is_empty() {
        return;
    }
    let at = all[pick(random, all.len())];
    let Some((key, value)) = lines[at].split_once(" = ") else { return };
    let (start, end) = *one_of(random, &numbers(value));
    let old: f64 = value[start..end].parse().unwrap_or(1.0);
    let new = if random.uniform() < 0.7 {
        format!("{:e}", old * one_of(random, &FACTORS))
    } else {
        EXTREMES[pick(random, 20)].to_string()
    };
    lines[at] = format!("{key} = {}{new}{}", &value[..start], &value[end..]);
}

fn unit(random: &mut RandomStream, lines: &mut [String]) {
    let units: Vec<(usize, usize, usize)> = lines
        .iter()
        .enumerate()
        .flat_map(|(i, line)| {
            UNITS.iter().filter_map(move |u| line.find(&format!(" {u}\"")).map(|at| (i, at + 1, u.len())))
        })
        .collect();
    if units.is_empty() {
        return;
    }
    let (i, at, length) = units[pick(random, units.len())];
    let new = one_of(random, &UNITS);
    lines[i].replace_range(at..at + length, new);
}

/// A whole table taken out, or written twice.
fn table(random: &mut RandomStream, lines: &mut Vec<String>) {
    let heads: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].starts_with('[')).collect();
    if heads.is_empty() {
        return;
    }
    let which = pick(random, heads.len());
    let range = heads[which]..heads.get(which + 1).copied().unwrap_or(lines.len());
    if random.uniform() < 0.5 {
        lines.drain(range);
    } else {
        let mut copy = lines[range].to_vec();
        copy[0] = copy[0].replace(']', "-2]");
        lines.extend(copy);
    }
}

/// A key misspelt, or with the name of another.
fn key(random: &mut RandomStream, lines: &mut [String]) {
    let (Some(at), Some(other)) = (keyed(random, lines), keyed(random, lines)) else { return };
    let name = lines[other].split(" = ").next().unwrap_or_default().to_string();
    let Some((own, value)) = lines[at].split_once(" = ") else { return };
    let half: String = own.chars().take(own.chars().count() / 2).collect();
    let new = if random.uniform() < 0.5 { name } else { format!("{half}{own}") };
    lines[at] = format!("{new} = {value}");
}

fn bytes(random: &mut RandomStream, text: &str) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=pick(random, 5) {
        let at = pick(random, bytes.len());
        if let Some(byte) = bytes.get_mut(at) {
            *byte = pick(random, 256) as u8;
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The beginning of one text and the end of another.
fn spliced(random: &mut RandomStream, text: &str, other: &str) -> String {
    let (first, second) = (text.as_bytes(), other.as_bytes());
    let (from, to) = (pick(random, first.len() + 1), pick(random, second.len() + 1));
    String::from_utf8_lossy(&[&first[..from], &second[to..]].concat()).into_owned()
}

fn deep(random: &mut RandomStream, lines: &mut [String]) {
    let text = match pick(random, 4) {
        0 => "[".repeat(DEEP),
        1 => "{a = ".repeat(DEEP),
        2 => "[".repeat(50) + &"]".repeat(50),
        _ => format!("{{{} = 1}}", vec!["a"; DEEP].join(".")),
    };
    value(random, lines, &text);
}

fn long(random: &mut RandomStream, lines: &mut [String]) {
    let text = match pick(random, 4) {
        0 => format!("\"{}\"", "long ".repeat(LONG / 5)),
        1 => format!("[{}]", vec!["1"; LONG / 3].join(", ")),
        2 => "9".repeat(LONG),
        _ => format!("[{}]", (0..LONG / 10).map(|i| format!("\"{i} s\"")).collect::<Vec<_>>().join(", ")),
    };
    value(random, lines, &text);
}
