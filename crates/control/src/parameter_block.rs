//! Parameters of a controller as one block of bytes, which a machine without an operating system holds in its program memory:
//!     magic | layout | length | joints | parameters | checksum         each number little-endian, in 8 bytes
//!
//! The layout is a hash of the names and kinds of all parameters: a block of another version is refused, whatever its length.
//! The checksum is CRC-32 (ISO-HDLC) of everything before it.

use crate::lever::Lever;
use crate::model::controller_model::ControllerModel;
use crate::monitor::plausibility;
use crate::thesis::heinze_pid;
use crate::tip;
use crc::{Crc, CRC_32_ISO_HDLC};
use hydrocrane_num::{Archive, Stored};

/// All that a controller is made of.
#[derive(Debug, Clone)]
pub struct Parameters<const N: usize> {
    pub model: ControllerModel<N>,
    pub controller: Kind<N>,
    /// Of the monitor of its sensors, if it has one.
    pub monitor: Option<plausibility::Settings<N>>,
}

/// Which controller it is, with its settings.
#[derive(Debug, Clone)]
pub enum Kind<const N: usize> {
    Tip(tip::Settings<N>),
    HeinzePid(heinze_pid::Settings<N>),
    Lever(Lever<N>),
}

hydrocrane_num::stored!([const N: usize] enum Kind<N> {
    0: Tip { 0: tip::Settings<N> },
    1: HeinzePid { 0: heinze_pid::Settings<N> },
    2: Lever { 0: Lever<N> },
});
hydrocrane_num::stored!([const N: usize] Parameters<N> {
    model: ControllerModel<N>,
    controller: Kind<N>,
    monitor: Option<plausibility::Settings<N>>,
});

/// Why a block is not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    #[error("these are no controller parameters")]
    NoParameters,
    #[error("the controller parameters are damaged: their length or their checksum is wrong")]
    Damaged,
    #[error("the controller parameters are of another version; export them again")]
    OtherVersion,
}

const MAGIC: u64 = u64::from_le_bytes(*b"HCRANE-C");
/// Bytes of a number, and of the head.
const WORD: usize = 8;
const HEAD: usize = 4 * WORD;
const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Bytes that a controller of so many joints needs in a program's memory, on any machine.
pub const fn memory(joints: usize) -> usize {
    9296 + (14976 + 48 * joints) * joints
}

fn word(block: &[u8], i: usize) -> Option<u64> {
    let (bytes, _) = block.get(i * WORD..)?.split_first_chunk::<WORD>()?;
    Some(u64::from_le_bytes(*bytes))
}

/// Number of joints of a sound block.
pub fn joints(block: &[u8]) -> Result<u64, Refusal> {
    let head = (word(block, 0), word(block, 2), word(block, 3));
    let (Some(MAGIC), Some(length), Some(joints)) = head else { return Err(Refusal::NoParameters) };
    let Some((bytes, checksum)) = block.split_last_chunk::<WORD>() else { return Err(Refusal::Damaged) };
    if length != block.len() as u64 || u64::from_le_bytes(*checksum) != u64::from(CHECKSUM.checksum(bytes)) {
        return Err(Refusal::Damaged);
    }
    Ok(joints)
}

/// Hands the parameters in a block of `N` joints to `then`. To return them would take a small stack several copies.
pub fn read<const N: usize, R>(block: &[u8], then: impl FnOnce(&Parameters<N>) -> R) -> Result<R, Refusal> {
    if joints(block)? != N as u64 || word(block, 1) != Some(Parameters::<N>::LAYOUT) {
        return Err(Refusal::OtherVersion);
    }
    let mut archive = Archive::reading(block.get(HEAD..block.len() - WORD).ok_or(Refusal::Damaged)?);
    let parameters = Parameters::exchange(&mut archive, None);
    if archive.is_sound() {
        Ok(then(&parameters))
    } else {
        Err(Refusal::Damaged)
    }
}

/// The block of these parameters; the error says what there is too much of for a controller without a heap.
#[cfg(feature = "std")]
pub fn written<const N: usize>(parameters: &Parameters<N>) -> Result<Vec<u8>, String> {
    use crate::reference::keep_out::{MOST_CORNERS, MOST_REGIONS};
    let mut archive = Archive::writing();
    Parameters::exchange(&mut archive, Some(parameters));
    if !archive.is_sound() {
        return Err(format!(
            "a controller on a target has room for {MOST_REGIONS} keep-out regions of {MOST_CORNERS} corners each; \
             state fewer or simpler ones in `keep-out`"
        ));
    }
    let body = archive.into_bytes();
    let length = HEAD + body.len() + WORD;
    let head = [MAGIC, Parameters::<N>::LAYOUT, length as u64, N as u64];
    let mut block: Vec<u8> = head.into_iter().flat_map(u64::to_le_bytes).chain(body).collect();
    let checksum = u64::from(CHECKSUM.checksum(&block));
    block.extend(checksum.to_le_bytes());
    Ok(block)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lever control of a machine whose numbers are all zero, with a monitor or not.
    fn lever(monitored: bool) -> Parameters<2> {
        let zeros = [0; 8192];
        let mut archive = Archive::reading(&zeros);
        Parameters {
            model: Stored::exchange(&mut archive, None),
            controller: Kind::Lever(Lever::new(0.01, [0.05, 0.02])),
            monitor: monitored.then(|| Stored::exchange(&mut archive, None)),
        }
    }

    #[test]
    fn a_block_is_read_back_and_every_damaged_byte_is_found() {
        let (plain, block) = (written(&lever(false)).expect("small"), written(&lever(true)).expect("small"));
        assert_eq!((joints(&plain), joints(&block)), (Ok(2), Ok(2)));
        let found = [&plain, &block].map(|block| read::<2, _>(block, Parameters::clone).expect("sound"));
        let expected = Lever::new(0.01, [0.05, 0.02]);
        assert!(found.iter().all(|found| matches!(&found.controller, Kind::Lever(lever) if *lever == expected)));
        let monitors = found.map(|found| format!("{:?}", found.monitor));
        assert_eq!(monitors, [None, lever(true).monitor].map(|monitor| format!("{monitor:?}")));
        for i in 0..block.len() {
            let mut damaged = block.clone();
            damaged[i] ^= 4;
            assert!(read::<2, _>(&damaged, |_| ()).is_err(), "byte {i}");
        }
        assert_eq!(joints(&block[..block.len() - 1]), Err(Refusal::Damaged));
        assert_eq!(joints(&[0; 100]), Err(Refusal::NoParameters));
        assert_eq!(joints(&[]), Err(Refusal::NoParameters));
    }

    #[test]
    fn another_number_of_joints_or_version_is_refused() {
        let mut block = written(&lever(true)).expect("small");
        assert_eq!(read::<3, _>(&block, |_| ()), Err(Refusal::OtherVersion));
        block[WORD] ^= 1;
        let end = block.len() - WORD;
        let checksum = u64::from(CHECKSUM.checksum(&block[..end]));
        block[end..].copy_from_slice(&checksum.to_le_bytes());
        assert_eq!(read::<2, _>(&block, |_| ()), Err(Refusal::OtherVersion));
    }
}
