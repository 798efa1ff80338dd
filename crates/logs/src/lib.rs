//! Text tables of data loggers as columns of numbers.
//!
//! [`decoded`] makes text of a file's bytes, [`read`] columns of the text. Separators, titles, names, units, decimal marks and dates are
//! found; what a column means is decided once, from all its cells. What was decided, and what is lost, is told.

mod cells;
mod clock;
mod column;
mod decode;
mod head;
mod names;
mod split;
mod table;

pub use cells::Format;
pub use clock::DateOrder;
pub use column::{column_named, time_column, Column, Content, Loss, Note, TIME_NAMES};
pub use decode::decoded;
pub use names::split_name;
pub use table::{read, Fault, Form, Table};
