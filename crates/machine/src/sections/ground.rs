//! `[payload]`, `[ground]` and `[ground.support.<name>]`: what hangs at the tip, and what it can come to lie on.

use crate::errors::ErrorKind;
use crate::model::{Ground, Payload, Support};
use crate::quantities::{length, mass, stiffness};
use crate::reader::{Reader, Sign};
use crate::sections::Result;
use crate::units::Quantity;

const KEYS: [&str; 6] = ["height", "stiffness", "damping", "friction", "status", "support"];
const SUPPORT_KEYS: [&str; 5] = ["height", "from", "to", "edge", "status"];
/// As many as the law of the ground has room for.
const MOST_SUPPORTS: usize = 4;

/// Firm soil, N/m: the weight of 1 t sinks 5 cm.
const STIFFNESS: f64 = 2e5;
/// s/m: at 0.2 m/s the ground pushes back twice as hard as at rest, and a load does not bounce.
const DAMPING: f64 = 5.0;
/// Wood or steel on soil.
const FRICTION: f64 = 0.5;
/// m
const EDGE: f64 = 0.1;

const STATUS: [(&str, bool); 2] = [("active", true), ("inactive", false)];

pub fn payload(root: &Reader) -> Result<Payload> {
    let Some(table) = root.table("payload", &["mass", "hang", "hang-growth"])? else {
        return Ok(Payload { mass: 0.0, hang: 0.0, hang_growth: 0.0 });
    };
    let growth = Quantity::new("length per root of a mass", "m/kg^0.5");
    Ok(Payload {
        mass: table.quantity_or("mass", &mass(), Sign::NonNegative, 0.0)?,
        hang: table.quantity_or("hang", &length(), Sign::NonNegative, 0.0)?,
        hang_growth: table.quantity_or("hang-growth", &growth, Sign::NonNegative, 0.0)?,
    })
}

/// The ground, where a machine has one that is not put out of force.
pub fn read(root: &Reader) -> Result<Option<Ground>> {
    let Some(table) = root.table("ground", &KEYS)? else { return Ok(None) };
    let per_speed = Quantity::new("damping per normal force", "s/m");
    let mut ground = Ground {
        height: table.quantity("height", &length(), Sign::Any)?,
        stiffness: table.quantity_or("stiffness", &stiffness(), Sign::Positive, STIFFNESS)?,
        damping: table.quantity_or("damping", &per_speed, Sign::NonNegative, DAMPING)?,
        friction: table.quantity_or("friction", &Quantity::number(), Sign::NonNegative, FRICTION)?,
        supports: Vec::new(),
    };
    for (name, support) in table.named_tables("support", &SUPPORT_KEYS)? {
        // A machine that extends another has no other way to be rid of its supports.
        if support.choice_or("status", &STATUS, true)? {
            ground.supports.push(one(name, &support, ground.height)?);
        }
        if ground.supports.len() > MOST_SUPPORTS {
            let message = format!("more than {MOST_SUPPORTS} supports");
            return Err(support.error(ErrorKind::TooLarge, "height", message).help("leave some of them out"));
        }
    }
    Ok(table.choice_or("status", &STATUS, true)?.then_some(ground))
}

fn one(name: &str, table: &Reader, ground: f64) -> Result<Support> {
    let support = Support {
        name: name.into(),
        height: table.quantity("height", &length(), Sign::Any)?,
        from: table.quantity("from", &length(), Sign::Any)?,
        to: table.quantity("to", &length(), Sign::Any)?,
        edge: table.quantity_or("edge", &length(), Sign::Positive, EDGE)?,
    };
    if support.height < ground {
        let message = format!("{} m lies below the ground at {ground} m", support.height);
        return Err(table
            .error(ErrorKind::OutOfRange, "height", message)
            .help("heights are those of the inertial frame, not above the ground"));
    }
    if support.to <= support.from {
        let message = format!("ends at {} m, where it does not yet begin ({} m)", support.to, support.from);
        return Err(table.error(ErrorKind::OutOfRange, "to", message).help("exchange `from` and `to`"));
    }
    Ok(support)
}
