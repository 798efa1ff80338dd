//! `[friction.<name>]`: seal friction of a cylinder. Pairs are (extending, retracting).

use crate::errors::ErrorKind;
use crate::model::{Friction, FrictionModel};
use crate::quantities::viscous_friction;
use crate::reader::Reader;
use crate::sections::Result;

/// Powers of the velocity beyond this are no friction law.
const LARGEST_EXPONENT: f64 = 10.0;

pub fn read(table: &Reader) -> Result<Friction> {
    let model = table.choice("model", &[FrictionModel::LuGre, FrictionModel::Static])?;
    let viscous_exponent = exponent(table, "viscous-exponent")?;
    let bristle = Bristle::read(table, model)?;
    let friction = Friction {
        model,
        coulomb: table.pair("coulomb")?,
        breakaway: table.pair("breakaway")?,
        stribeck_velocity: table.pair("stribeck-velocity")?,
        stribeck_exponent: exponent(table, "stribeck-exponent")?,
        viscous: viscous(table, viscous_exponent)?,
        viscous_exponent,
        smoothing_velocity: table.optional_quantity("smoothing-velocity")?,
        bristle_stiffness: bristle.stiffness,
        bristle_damping: bristle.damping,
        bristle_damping_velocity: bristle.damping_velocity,
    };
    check_breakaway(table, &friction)?;
    Ok(friction)
}

fn exponent(table: &Reader, key: &str) -> Result<[f64; 2]> {
    let exponents = table.pair(key)?;
    if exponents.iter().all(|exponent| *exponent <= LARGEST_EXPONENT) {
        return Ok(exponents);
    }
    let message = format!("an exponent above {LARGEST_EXPONENT} is no friction law");
    Err(table.error(ErrorKind::OutOfRange, key, message).help("the literature gives 0.5 to 2"))
}

/// The unit of the viscous coefficient follows its exponent.
fn viscous(table: &Reader, exponents: [f64; 2]) -> Result<[f64; 2]> {
    let quantities = exponents.map(viscous_friction);
    let field = table.required("viscous", &quantities[0].example())?;
    field.pair_of([&quantities[0], &quantities[1]])
}

/// LuGre alone demands the bristle's values; the static map ignores them, so that `model` can be overridden.
struct Bristle {
    stiffness: f64,
    damping: f64,
    damping_velocity: Option<f64>,
}

impl Bristle {
    fn read(table: &Reader, model: FrictionModel) -> Result<Self> {
        let damping_velocity = table.optional_quantity("bristle-damping-velocity")?;
        let [stiffness_key, damping_key] = ["bristle-stiffness", "bristle-damping"];
        if model == FrictionModel::LuGre {
            return Ok(Self {
                stiffness: table.quantity(stiffness_key)?,
                damping: table.quantity(damping_key)?,
                damping_velocity,
            });
        }
        table.optional_quantity(stiffness_key)?;
        table.optional_quantity(damping_key)?;
        Ok(Self { stiffness: 0.0, damping: 0.0, damping_velocity: None })
    }
}

fn check_breakaway(table: &Reader, friction: &Friction) -> Result<()> {
    if (0..2).all(|side| friction.breakaway[side] >= friction.coulomb[side]) {
        return Ok(());
    }
    Err(table
        .error(ErrorKind::OutOfRange, "breakaway", "smaller than the Coulomb force, which it contains")
        .help("breakaway is Coulomb friction plus the Stribeck rise"))
}
