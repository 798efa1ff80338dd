//! Files that are read from disk: regular ones alone, because a pipe or a device may never end, or never begin.

use std::fs::{metadata, File, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

use crate::names::is_device;
use crate::text::document::LONGEST_TEXT;

/// The bytes of a file of up to [`LONGEST_TEXT`].
///
/// # Errors
/// What the system says, that it is no regular file, or that it is too long.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    // Opening a pipe would wait for its other end.
    regular(&metadata(path)?)?;
    let file = File::open(path)?;
    regular(&file.metadata()?)?;
    let mut bytes = Vec::new();
    // One byte more than allowed shows that the file is too long.
    file.take(LONGEST_TEXT as u64 + 1).read_to_end(&mut bytes)?;
    match bytes.len() > LONGEST_TEXT {
        true => Err(Error::new(ErrorKind::FileTooLarge, format!("it is longer than {} MiB", LONGEST_TEXT >> 20))),
        false => Ok(bytes),
    }
}

fn regular(found: &Metadata) -> Result<()> {
    match found.file_type() {
        kind if kind.is_file() => Ok(()),
        kind if kind.is_dir() => Err(Error::new(ErrorKind::IsADirectory, "it is a folder")),
        _ => Err(Error::new(ErrorKind::InvalidInput, "it is a pipe or a device, not a regular file")),
    }
}

/// Why a path that is written in a file is not opened, and the cure: only those who run the program send it into a network.
pub fn path_fault(path: &str) -> Option<(String, String)> {
    let separators = ['/', '\\'];
    let what = if path.starts_with(separators) && path[1..].starts_with(separators) {
        "leads into a network or to a device"
    } else if cfg!(windows) && path.split(separators).any(is_device) {
        "names a device"
    } else {
        return None;
    };
    let cure = "copy the file beside this one, and name it by its path from here";
    Some((format!("{what}, where a file may not send you"), cure.into()))
}
