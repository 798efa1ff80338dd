//! `[payload]`, `[ground]` and `[ground.support.<name>]`: the load at the tip, and the surfaces that it can touch.

use crate::errors::ErrorKind;
use crate::model::{Ground, Payload, Support};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;

/// Most supports of the law of the ground.
const MOST_SUPPORTS: usize = 4;

/// Meanings of the choices of `status`.
const STATUS: [bool; 2] = [true, false];

pub fn payload<T: Number>(root: &Reader) -> Result<Payload<T>> {
    let table = root.table_or_empty("payload")?;
    Ok(Payload {
        mass: table.quantity_or_default("mass")?,
        hang: table.quantity_or_default("hang")?,
        hang_growth: table.quantity_or_default("hang-growth")?,
        tool: table.choice_or_default("tool", table.choices("tool"))?,
    })
}

/// The ground, if a machine has one that is active.
pub fn read<T: Number>(root: &Reader) -> Result<Option<Ground<T>>> {
    let Some(table) = root.table("ground")? else { return Ok(None) };
    let mut ground: Ground<T> = Ground {
        height: table.quantity("height")?,
        stiffness: table.quantity_or_default("stiffness")?,
        damping: table.quantity_or_default("damping")?,
        friction: table.quantity_or_default("friction")?,
        supports: Vec::new(),
    };
    for (name, support) in table.named_tables("support")? {
        // A machine that extends another can only remove supports this way.
        if support.choice_or_default("status", &STATUS)? {
            ground.supports.push(one(name, &support, ground.height.plain())?);
        } else {
            // It may be incomplete, but its values must be valid.
            for key in ["height", "from", "to", "edge"] {
                support.optional_quantity::<f64>(key)?;
            }
        }
        if ground.supports.len() > MOST_SUPPORTS {
            let message = format!("more than {MOST_SUPPORTS} supports");
            return Err(support.error(ErrorKind::TooLarge, "height", message).help("remove some of them"));
        }
    }
    Ok(table.choice_or_default("status", &STATUS)?.then_some(ground))
}

fn one<T: Number>(name: &str, table: &Reader, ground: f64) -> Result<Support<T>> {
    let support = Support {
        name: name.into(),
        height: table.quantity("height")?,
        from: table.quantity("from")?,
        to: table.quantity("to")?,
        edge: table.quantity_or_default("edge")?,
    };
    let [height, from, to] = [support.height, support.from, support.to].map(T::plain);
    if height < ground {
        let message = format!("{height} m lies below the ground at {ground} m");
        return Err(table
            .error(ErrorKind::OutOfRange, "height", message)
            .help("heights are those of the inertial frame, not above the ground"));
    }
    if to <= from {
        let message = format!("ends at {to} m, before it begins ({from} m)");
        return Err(table.error(ErrorKind::OutOfRange, "to", message).help("exchange `from` and `to`"));
    }
    Ok(support)
}
