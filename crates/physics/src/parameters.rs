//! Parameter structs whose numbers can be lifted to another number type.

/// Declares a struct of parameters of type `T`, followed after `;` by plain configuration fields.
/// `lift` turns the `f64` struct into one over any [`hydrocrane_num::Real`]: into duals, for derivatives
/// with respect to states or to the parameters themselves.
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

        impl $name<f64> {
            /// The same parameters as constants of another number type.
            pub fn lift<U: hydrocrane_num::Real>(&self) -> $name<U> {
                $name { $($field: U::c(self.$field),)* $($($config: self.$config,)*)? }
            }
        }
    };
}
