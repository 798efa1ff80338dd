//! Texts as loggers write them. One binary: linking takes longer than compiling.

mod cells;
mod moments;
mod tables;

use hydrocrane_logs::{read, Column, Content, Form, Loss};

/// The values of a column.
fn values(column: &Column) -> &[f64] {
    match &column.content {
        Content::Numbers { values, .. } => values,
        Content::Lost(loss) => panic!("{}: {loss:?}", column.name),
    }
}

/// The columns of rows without a head.
fn rows(delimiter: char, lines: &[&str], form: Form) -> Vec<Column> {
    let names = (1..=lines[0].split(delimiter).count()).map(|index| format!("c{index}")).collect();
    let form = Form { delimiter: u8::try_from(delimiter).ok(), names, ..form };
    let mut columns = read(&format!("{}\n", lines.join("\n")), &form).expect("a table").columns;
    // A delimiter between quotes is none.
    columns.retain(|column| column.content != Content::Lost(Loss::NoCells));
    columns
}
