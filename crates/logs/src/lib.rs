//! Text tables of data loggers as columns of numbers.
//!
//! [`decoded`] makes text of a file's bytes, [`read`] columns of the text. Separators, titles, names, units, decimal marks and dates are
//! found; what a column means is decided once, from all its cells. What was decided, and what is lost, is told.

mod cells;
mod clock;
mod column;
mod decode;
mod head;
mod split;
mod table;

pub use cells::Format;
pub use clock::{in_days, DateOrder};
pub use column::{Column, Content, Loss, Note};
pub use decode::decoded;
pub use table::{read, Fault, Form, Table};
