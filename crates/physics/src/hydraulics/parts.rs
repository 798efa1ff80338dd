//! Whether the laws of a valve section look for optional parts, known when they are compiled.
//!
//! A part that a section has not is `None`. The branch on it is free, its law in the same function is not: it takes registers
//! from the rest. Sections without any part are therefore evaluated by laws that have been compiled without them.

/// Which optional parts the compiler has to expect.
pub trait Parts {
    const EXPECTED: bool;

    /// A part, or `None` where none is expected.
    #[inline(always)]
    fn part<P>(part: Option<P>) -> Option<P> {
        if Self::EXPECTED {
            part
        } else {
            None
        }
    }
}

/// Any of them may be there, those of mobile machines where the program has their laws.
pub struct AnyParts;

/// For sections of which it is known that they have none.
pub struct NoParts;

impl Parts for AnyParts {
    const EXPECTED: bool = cfg!(feature = "mobile");
}

impl Parts for NoParts {
    const EXPECTED: bool = false;
}
