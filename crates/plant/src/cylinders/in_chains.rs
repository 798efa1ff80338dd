//! What builds for the smallest chains only leave out.

/// A part of a crane; such builds have none, so that the compiler leaves out its laws.
#[inline(always)]
pub(crate) fn in_chains<P>(part: Option<P>) -> Option<P> {
    part.filter(|_| cfg!(feature = "chains"))
}
