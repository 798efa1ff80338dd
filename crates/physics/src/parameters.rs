//! Parameter structs whose numbers can be lifted to another number type.

/// Declares a struct of parameters of type `T`, followed after `;` by plain configuration fields.
/// `map` takes every number to another type, in the order of the fields; `lift` makes constants of any
/// [`hydrocrane_num::Real`]. So a struct of plain numbers becomes one of duals, for derivatives with respect to states
/// or to the parameters themselves.
macro_rules! parameters {
    ($(#[$meta:meta])* pub struct $name:ident {
        $($(#[$field_meta:meta])* $field:ident,)* $(; $($(#[$config_meta:meta])* $config:ident : $kind:ty,)*)?
    }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy)]
        pub struct $name<T> {
            $($(#[$field_meta])* pub $field: T,)*
            $($($(#[$config_meta])* pub $config: $kind,)*)?
        }

        impl<T: Copy> $name<T> {
            /// The same parameters with `f` of every number.
            pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> $name<U> {
                $name { $($field: f(&self.$field),)* $($($config: self.$config,)*)? }
            }
        }

        impl $name<f64> {
            /// The same parameters as constants of another number type.
            pub fn lift<U: hydrocrane_num::Real>(&self) -> $name<U> {
                self.map(&mut |number| U::c(*number))
            }
        }

        hydrocrane_num::stored!([] $name<f64> { $($field: f64,)* $($($config: $kind,)*)? });
    };
}
