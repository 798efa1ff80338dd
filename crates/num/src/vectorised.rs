//! The same code for several instruction sets, chosen where it runs.

/// Defines a method that runs another one compiled for the widest vectors that the processor has:
/// `vectorised! { fn name, name_avx2 by plain(argument: type, ...) -> type }`. The results are the same bits everywhere, since
/// no instruction set fuses or reorders operations. What is to be vectorised must be inlined into the method.
#[macro_export]
macro_rules! vectorised {
    ($(#[$meta:meta])* $vis:vis fn $name:ident, $wide:ident by $plain:ident($($argument:ident: $type:ty),*) -> $out:ty) => {
        $(#[$meta])*
        $vis fn $name(&self, $($argument: $type),*) -> $out {
            #[cfg(target_arch = "x86_64")]
            if ::std::arch::is_x86_feature_detected!("avx2") {
                // SAFETY: the processor has the feature.
                return unsafe { self.$wide($($argument),*) };
            }
            self.$plain($($argument),*)
        }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2")]
        unsafe fn $wide(&self, $($argument: $type),*) -> $out {
            self.$plain($($argument),*)
        }
    };
}
