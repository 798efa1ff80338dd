//! What sensors make of what they measure. These are `f64` only: counting and rounding have no derivative.

pub mod analogue;
pub mod converter;
pub mod encoder;
pub mod load_cell;
pub mod pressure_transmitter;
pub mod wire_potentiometer;

pub use converter::Converter;
pub use encoder::Encoder;
pub use load_cell::LoadCell;
pub use pressure_transmitter::PressureTransmitter;
pub use wire_potentiometer::WirePotentiometer;
