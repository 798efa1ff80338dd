//! `[friction.<name>]`: seal friction of a cylinder. Pairs are (extending, retracting).

use crate::errors::ErrorKind;
use crate::model::{Friction, FrictionModel};
use crate::quantities::{damping, force, stiffness, velocity, viscous_friction};
use crate::reader::{Reader, Sign};
use crate::sections::Result;
use crate::units::Quantity;

pub const KEYS: [&str; 12] = [
    "cylinder",
    "model",
    "coulomb",
    "breakaway",
    "stribeck-velocity",
    "stribeck-exponent",
    "viscous",
    "viscous-exponent",
    "smoothing-velocity",
    "bristle-stiffness",
    "bristle-damping",
    "bristle-damping-velocity",
];

/// Powers of the velocity beyond this are no friction law.
const LARGEST_EXPONENT: f64 = 10.0;

pub fn read(table: &Reader) -> Result<Friction> {
    let model = table.choice("model", &[("lugre", FrictionModel::LuGre), ("static", FrictionModel::Static)])?;
    let viscous_exponent = exponent(table, "viscous-exponent")?;
    let bristle = Bristle::read(table, model)?;
    let friction = Friction {
        model,
        coulomb: pair(table, "coulomb", &force(), Sign::NonNegative)?,
        breakaway: pair(table, "breakaway", &force(), Sign::NonNegative)?,
        stribeck_velocity: pair(table, "stribeck-velocity", &velocity(), Sign::Positive)?,
        stribeck_exponent: exponent(table, "stribeck-exponent")?,
        viscous: viscous(table, viscous_exponent)?,
        viscous_exponent,
        smoothing_velocity: table.optional_quantity("smoothing-velocity", &velocity(), Sign::Positive)?,
        bristle_stiffness: bristle.stiffness,
        bristle_damping: bristle.damping,
        bristle_damping_velocity: bristle.damping_velocity,
    };
    check_breakaway(table, &friction)?;
    Ok(friction)
}

fn pair(table: &Reader, key: &str, quantity: &Quantity, sign: Sign) -> Result<[f64; 2]> {
    table.required(key, &quantity.example())?.pair([quantity, quantity], sign)
}

fn exponent(table: &Reader, key: &str) -> Result<[f64; 2]> {
    let exponents = pair(table, key, &Quantity::number(), Sign::Positive)?;
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
    field.pair([&quantities[0], &quantities[1]], Sign::NonNegative)
}

/// LuGre alone demands the bristle's values; the static map ignores them, so that `model` can be overridden.
struct Bristle {
    stiffness: f64,
    damping: f64,
    damping_velocity: Option<f64>,
}

impl Bristle {
    fn read(table: &Reader, model: FrictionModel) -> Result<Self> {
        let damping_velocity = table.optional_quantity("bristle-damping-velocity", &velocity(), Sign::Positive)?;
        let [stiffness_key, damping_key] = ["bristle-stiffness", "bristle-damping"];
        if model == FrictionModel::LuGre {
            return Ok(Self {
                stiffness: table.quantity(stiffness_key, &stiffness(), Sign::Positive)?,
                damping: table.quantity(damping_key, &damping(), Sign::NonNegative)?,
                damping_velocity,
            });
        }
        table.optional_quantity(stiffness_key, &stiffness(), Sign::Positive)?;
        table.optional_quantity(damping_key, &damping(), Sign::NonNegative)?;
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
