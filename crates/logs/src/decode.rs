//! Bytes of a file as text.

use std::borrow::Cow;

/// The text of a file: UTF-8, UTF-16 with its mark at the start, or else the encoding of older loggers on Windows, in which almost all
/// bytes of Latin-1 mean the same.
///
/// # Errors
/// If the bytes are no text.
#[cfg(not(target_family = "wasm"))]
pub fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>, &'static str> {
    if let Some((encoding, mark)) = encoding_rs::Encoding::for_bom(bytes) {
        let (text, damaged) = encoding.decode_without_bom_handling(&bytes[mark..]);
        return if damaged {
            Err("is damaged: not all of it is text in the encoding that its first bytes state")
        } else {
            Ok(text)
        };
    }
    if bytes[..bytes.len().min(LOOKED_AT)].contains(&0) {
        return Err("is a binary file");
    }
    Ok(match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => encoding_rs::WINDOWS_1252.decode_without_bom_handling(bytes).0,
    })
}

/// The text of a file in UTF-8.
///
/// # Errors
/// If the bytes are no such text.
#[cfg(target_family = "wasm")]
pub fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>, &'static str> {
    let text = std::str::from_utf8(bytes).map_err(|_| "is not UTF-8 text")?;
    Ok(Cow::Borrowed(text.trim_start_matches('\u{feff}')))
}

/// Bytes in which a zero says that a file is binary.
#[cfg(not(target_family = "wasm"))]
const LOOKED_AT: usize = 4096;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_text_in_every_encoding() {
        let text = "time;x [µm];φ\n";
        let wide = |order: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(order).collect::<Vec<u8>>();
        for bytes in [
            text.as_bytes().to_vec(),
            [b"\xef\xbb\xbf", text.as_bytes()].concat(),
            [&b"\xff\xfe"[..], &wide(u16::to_le_bytes)].concat(),
            [&b"\xfe\xff"[..], &wide(u16::to_be_bytes)].concat(),
        ] {
            assert_eq!(decoded(&bytes).unwrap(), text);
        }
        assert_eq!(decoded(b"x [\xb5m];T [\xb0C] \x80").unwrap(), "x [µm];T [°C] €");
        assert!(decoded(b"\xff\xfe\x00\xd8").unwrap_err().contains("damaged"));
        assert!(decoded(b"MATLAB\0").unwrap_err().contains("binary"));
    }
}
