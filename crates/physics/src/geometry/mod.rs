//! Where the links are and how far the pistons stand out (thesis 3.1).

pub mod chain;
pub mod cylinder_triangle;
pub mod four_bar;
pub mod frames;
pub mod spatial_chain;
pub mod stroke;

use hydrocrane_num::Vec2;

/// A point that moves with one joint, seen from the parent link.
#[derive(Debug, Clone, Copy)]
pub struct MovingPoint<T> {
    /// m, in the parent frame
    pub position: Vec2<T>,
    /// Derivative of `position` with respect to the joint coordinate.
    pub rate: Vec2<T>,
}
