//! `[keep-out.<name>]`: regions that controllers keep the tip out of.

use crate::errors::ErrorKind;
use crate::reading::reader::Reader;
use crate::sections::Result;

/// Most regions, because each is checked in every sample.
const MOST_CORNERS: usize = 1000;

/// Name and corners of each active polygon.
pub fn read(root: &Reader) -> Result<Vec<(String, Vec<[f64; 2]>)>> {
    let (mut heeded, mut all) = (Vec::new(), 0);
    for (name, table) in root.named_tables("keep-out")? {
        let corners = polygon(&table)?;
        all += corners.len();
        if all > MOST_CORNERS {
            let message = format!("{all} corners up to here; all regions together have at most {MOST_CORNERS}");
            return Err(table
                .error(ErrorKind::TooLarge, "outline", message)
                .help("draw the regions with fewer corners"));
        }
        // A machine that extends another can only remove regions this way.
        if table.choice_or_default("status", &[true, false])? {
            heeded.push((name.to_string(), corners));
        }
    }
    Ok(heeded)
}

fn polygon(table: &Reader) -> Result<Vec<[f64; 2]>> {
    let field = table.required("outline", "the corners, for example [\"(-3, -2) m\", \"(6, -2) m\", \"(0, -4) m\"]")?;
    let corners = field.points()?;
    // Twice the area by the shoelace formula; zero for a line.
    let twice_the_area: f64 = (0..corners.len()).map(|i| cross(corners[i], corners[(i + 1) % corners.len()])).sum();
    if corners.len() >= 3 && twice_the_area.abs() > 1e-9 {
        return Ok(corners);
    }
    let message = format!("{} corners enclose no area", corners.len());
    Err(field.error(ErrorKind::OutOfRange, message).help("give three corners or more, not in one line"))
}

fn cross([ax, az]: [f64; 2], [bx, bz]: [f64; 2]) -> f64 {
    ax * bz - az * bx
}
