//! Sensors that fail: whether a reading may be true, and the safe state.

#[cfg(feature = "std")]
pub mod monitored;
pub(crate) mod passage;
pub mod plausibility;
pub mod safe_state;
pub(crate) mod spool_history;
pub(crate) mod suspect;
pub(crate) mod vanished;
pub(crate) mod whereabouts;
