//! `[friction.<name>]`: seal friction of a cylinder. Pairs are (extending, retracting).

use crate::errors::ErrorKind;
use crate::model::{Friction, FrictionModel};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;
use crate::units::quantities::viscous_friction;

/// Largest exponent of the velocity.
const LARGEST_EXPONENT: f64 = 10.0;

pub fn read<T: Number>(table: &Reader) -> Result<Friction<T>> {
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

fn exponent<T: Number>(table: &Reader, key: &str) -> Result<[T; 2]> {
    let exponents: [T; 2] = table.pair(key)?;
    if exponents.iter().all(|exponent| exponent.plain() <= LARGEST_EXPONENT) {
        return Ok(exponents);
    }
    let message = format!("an exponent above {LARGEST_EXPONENT} is not a friction law");
    Err(table.error(ErrorKind::OutOfRange, key, message).help("the literature gives 0.5 to 2"))
}

/// The unit of the viscous coefficient follows its exponent.
fn viscous<T: Number>(table: &Reader, exponents: [T; 2]) -> Result<[T; 2]> {
    let quantities = exponents.map(|exponent| viscous_friction(exponent.plain()));
    let field = table.required("viscous", &quantities[0].example())?;
    field.pair_of([&quantities[0], &quantities[1]])
}

/// Only LuGre needs the bristle's values; the static map ignores them, so that `model` can be overridden.
struct Bristle<T> {
    stiffness: T,
    damping: T,
    damping_velocity: Option<T>,
}

impl<T: Number> Bristle<T> {
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
        table.optional_quantity::<T>(stiffness_key)?;
        table.optional_quantity::<T>(damping_key)?;
        Ok(Self { stiffness: T::c(0.0), damping: T::c(0.0), damping_velocity: None })
    }
}

fn check_breakaway<T: Number>(table: &Reader, friction: &Friction<T>) -> Result<()> {
    let [breakaway, coulomb] = [friction.breakaway, friction.coulomb].map(|pair| pair.map(T::plain));
    if (0..2).all(|side| breakaway[side] >= coulomb[side]) {
        return Ok(());
    }
    Err(table
        .error(ErrorKind::OutOfRange, "breakaway", "smaller than the Coulomb force, which it contains")
        .help("breakaway is Coulomb friction plus the Stribeck rise"))
}
