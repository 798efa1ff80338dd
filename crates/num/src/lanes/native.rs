//! The vector register that this platform certainly, or most likely, has.

/// The register for the few equal parts of one machine; only x86-64 processors can be without theirs.
#[cfg(all(feature = "std", target_arch = "x86_64"))]
pub type NativeSimd = crate::lanes::register_x86::Avx2;
/// The register for the few equal parts of one machine.
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
pub type NativeSimd = crate::lanes::register_wasm::Simd128;
/// The register for the few equal parts of one machine.
#[cfg(not(any(
    all(feature = "std", target_arch = "x86_64"),
    all(target_arch = "wasm32", target_feature = "simd128")
)))]
pub type NativeSimd = f64;
