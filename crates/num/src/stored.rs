//! Parameters as bytes, for a machine without an operating system: one function visits their numbers, for writing and for reading.

use crate::{Archive, Vec2, Vec3};

/// A value that is written number by number and read back to the bit.
pub trait Stored: Sized {
    /// Differs between two types whose numbers mean something else.
    const LAYOUT: u64;

    /// Writes `own`; without it, reads the next value.
    fn exchange(archive: &mut Archive, own: Option<&Self>) -> Self;
}

/// Of no fields (FNV-1a, 64 bits).
pub const EMPTY: u64 = 0xcbf2_9ce4_8422_2325;

/// A layout that goes on with a field of this name and layout.
pub const fn joined(mut layout: u64, name: &str, field: u64) -> u64 {
    const PRIME: u64 = 0x0100_0000_01b3;
    let (bytes, mut i) = (name.as_bytes(), 0);
    while i < bytes.len() {
        layout = (layout ^ bytes[i] as u64).wrapping_mul(PRIME);
        i += 1;
    }
    let (field, mut i) = (field.to_le_bytes(), 0);
    while i < field.len() {
        layout = (layout ^ field[i] as u64).wrapping_mul(PRIME);
        i += 1;
    }
    layout
}

/// Implements [`Stored`] for a struct or an enum by its fields; in square brackets its generics. Variants are numbered from 0 on.
#[macro_export]
macro_rules! stored {
    ([$($generics:tt)*] enum $name:ty { $($number:literal: $variant:ident { $($field:tt: $kind:ty),* $(,)? }),* $(,)? }) => {
        impl<$($generics)*> $crate::Stored for $name {
            const LAYOUT: u64 = {
                let layout = $crate::stored::EMPTY;
                $(
                    let layout = $crate::stored::joined(layout, stringify!($variant), $number);
                    $(let layout = $crate::stored::joined(layout, stringify!($field), <$kind as $crate::Stored>::LAYOUT);)*
                )*
                layout
            };

            fn exchange(archive: &mut $crate::Archive, own: Option<&Self>) -> Self {
                let mut number: u64 = match own {
                    $(Some(Self::$variant { .. }) => $number,)*
                    None => 0,
                };
                archive.whole(&mut number);
                loop {
                    $(if number == $number {
                        return Self::$variant {
                            $($field: <$kind as $crate::Stored>::exchange(archive, match own {
                                Some(Self::$variant { $field: field, .. }) => Some(field),
                                _ => None,
                            }),)*
                        };
                    })*
                    archive.spoil();
                    number = 0;
                }
            }
        }
    };
    ([$($generics:tt)*] $name:ty { $($field:tt: $kind:ty),* $(,)? }) => {
        impl<$($generics)*> $crate::Stored for $name {
            const LAYOUT: u64 = {
                let layout = $crate::stored::EMPTY;
                $(let layout = $crate::stored::joined(layout, stringify!($field), <$kind as $crate::Stored>::LAYOUT);)*
                layout
            };

            fn exchange(archive: &mut $crate::Archive, own: Option<&Self>) -> Self {
                Self { $($field: <$kind as $crate::Stored>::exchange(archive, own.map(|own| &own.$field)),)* }
            }
        }
    };
}

/// Values that an [`Archive`] takes as they are.
macro_rules! plain {
    ($($kind:ty, $method:ident);*) => {$(
        impl Stored for $kind {
            const LAYOUT: u64 = joined(EMPTY, stringify!($kind), 0);

            fn exchange(archive: &mut Archive, own: Option<&Self>) -> Self {
                let mut value = own.copied().unwrap_or_default();
                archive.$method(&mut value);
                value
            }
        }
    )*};
}

plain!(f64, number; u64, whole; bool, flag);

impl Stored for usize {
    const LAYOUT: u64 = joined(EMPTY, "usize", 0);

    fn exchange(archive: &mut Archive, own: Option<&Self>) -> Self {
        u64::exchange(archive, own.map(|own| *own as u64).as_ref()) as usize
    }
}

impl<T: Stored, const N: usize> Stored for [T; N] {
    const LAYOUT: u64 = joined(T::LAYOUT, "array", N as u64);

    fn exchange(archive: &mut Archive, own: Option<&Self>) -> Self {
        crate::array::from_fn(|i| T::exchange(archive, own.map(|own| &own[i])))
    }
}

impl<T: Stored> Stored for Option<T> {
    const LAYOUT: u64 = joined(T::LAYOUT, "option", 0);

    fn exchange(archive: &mut Archive, own: Option<&Self>) -> Self {
        let there = bool::exchange(archive, own.map(Option::is_some).as_ref());
        there.then(|| T::exchange(archive, own.and_then(Option::as_ref)))
    }
}

stored!([] Vec2<f64> { x: f64, z: f64 });
stored!([] Vec3<f64> { x: f64, y: f64, z: f64 });

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq)]
    enum Law {
        None,
        Before(f64),
        Both { first: f64, second: [bool; 2] },
    }

    #[derive(Debug, PartialEq)]
    struct Things {
        count: usize,
        laws: [Law; 3],
        maybe: Option<f64>,
    }

    stored!([] enum Law { 0: None {}, 1: Before { 0: f64 }, 2: Both { first: f64, second: [bool; 2] } });
    stored!([] Things { count: usize, laws: [Law; 3], maybe: Option<f64> });

    fn things() -> Things {
        let laws = [Law::None, Law::Before(-0.0), Law::Both { first: 1e-310, second: [true, false] }];
        Things { count: 7, laws, maybe: Some(f64::INFINITY) }
    }

    #[test]
    fn what_is_written_is_read_back_and_a_variant_that_is_none_is_damage() {
        let mut archive = Archive::writing();
        Things::exchange(&mut archive, Some(&things()));
        let mut bytes = archive.into_bytes();
        let mut archive = Archive::reading(&bytes);
        assert_eq!(Things::exchange(&mut archive, None), things());
        assert!(archive.is_sound());
        // The number of the first law.
        bytes[8] = 9;
        let mut archive = Archive::reading(&bytes);
        Things::exchange(&mut archive, None);
        assert!(!archive.is_sound());
    }

    #[test]
    fn another_name_kind_or_number_of_fields_is_another_layout() {
        struct Other {
            amount: usize,
            laws: [Law; 2],
            maybe: Option<bool>,
        }
        stored!([] Other { amount: usize, laws: [Law; 2], maybe: Option<bool> });
        let layouts = [
            Other::LAYOUT,
            Things::LAYOUT,
            Law::LAYOUT,
            <[f64; 2]>::LAYOUT,
            <[f64; 3]>::LAYOUT,
            Option::<f64>::LAYOUT,
            f64::LAYOUT,
        ];
        assert!((0..layouts.len()).all(|i| !layouts[..i].contains(&layouts[i])), "{layouts:?}");
    }
}
