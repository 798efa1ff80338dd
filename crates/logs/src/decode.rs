//! Bytes of a file as text.

use std::borrow::Cow;

/// The text of a file: UTF-8, UTF-16 with its mark at the start, or else the encoding of older loggers on Windows, in which almost all
/// bytes of Latin-1 mean the same. In a browser, which decodes files itself, UTF-8 alone.
///
/// # Errors
/// If the bytes are no text.
pub fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>, &'static str> {
    #[cfg(not(target_family = "wasm"))]
    if let Some((encoding, mark)) = encoding_rs::Encoding::for_bom(bytes) {
        let (text, damaged) = encoding.decode_without_bom_handling(&bytes[mark..]);
        let fault = "is damaged: not all of it is text in the encoding that its first bytes state";
        return if damaged { Err(fault) } else { Ok(text) };
    }
    if bytes[..bytes.len().min(LOOKED_AT)].contains(&0) {
        return Err("is a binary file");
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => Ok(Cow::Borrowed(text)),
        #[cfg(not(target_family = "wasm"))]
        Err(_) => Ok(encoding_rs::WINDOWS_1252.decode_without_bom_handling(bytes).0),
        #[cfg(target_family = "wasm")]
        Err(_) => Err("is not UTF-8 text"),
    }
}

/// Bytes in which a zero says that a file is binary.
const LOOKED_AT: usize = 4096;
