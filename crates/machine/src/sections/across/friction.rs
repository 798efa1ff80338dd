//! Friction against the force and the speed of its cylinder.

use super::{digits, Sizes};
use crate::model::{Cylinder, FrictionModel};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;
use std::f64::consts::PI;

/// Share of the force of the supply that seals may take at rest, and viscous friction at the speed of the fully open valve.
const SHARE: f64 = 0.5;
/// Least friction of a seal per length of its lip, N/m: a hundredth of usual ones.
const LEAST: f64 = 10.0;
/// Share of the Coulomb friction that viscous friction has there at least: nobody measures a third of a percent beside it.
const UNMEASURED: f64 = 1.0 / 300.0;
/// Share of the break-away that bristles damp with at the speed of the Stribeck rise: those of drawn machines have up to 1.3.
const DAMPED: f64 = 5.0;
/// Deflection of the bristles at break-away, as a share of the stroke.
const DEFLECTION: f64 = 0.1;

pub fn check<T: Number>(table: &Reader, of: &Cylinder<T>, sizes: &Sizes) -> Result<()> {
    let friction = &of.friction;
    let most = |pair: [T; 2]| pair[0].plain().max(pair[1].plain());
    let [coulomb, breakaway, viscous] = [friction.coulomb, friction.breakaway, friction.viscous].map(most);
    if breakaway == 0.0 && viscous == 0.0 {
        table.required("breakaway", "a force")?.warn(
            "zero, like all friction of this cylinder: nothing but oil and stops would brake it".into(),
            "state a few percent of the force at the supply pressure, class `assumed`, if it is unknown".into(),
        );
        return Ok(());
    }
    if sizes.force() > 0.0 && breakaway > SHARE * sizes.force() {
        table.required("breakaway", "a force")?.warn(
            format!("large: the supply presses the piston with {} N", digits(sizes.force())),
            "check its unit: N or kN?".into(),
        );
    }
    let least = LEAST * PI * sizes.bore;
    if coulomb > 0.0 && coulomb < least && !of.motor {
        table.required("coulomb", "a force")?.warn(
            format!("small: {} N on a seal of {} mm circumference", digits(coulomb), digits(1e3 * PI * sizes.bore)),
            "check its unit: N or kN?".into(),
        );
    }
    let at_speed = |side: usize| {
        friction.viscous[side].plain() * libm::pow(sizes.speed(), friction.viscous_exponent[side].plain())
    };
    let braking = at_speed(0).max(at_speed(1));
    if sizes.force() > 0.0 && braking > SHARE * sizes.force() {
        table.required("viscous", "a viscous coefficient")?.warn(
            format!(
                "large: {} N at the {} m/s of the fully open valve, where the supply has {} N",
                digits(braking),
                digits(sizes.speed()),
                digits(sizes.force())
            ),
            "check its unit: N s/m or N s/mm?".into(),
        );
    } else if 0.0 < braking && braking < UNMEASURED * coulomb {
        table.required("viscous", "a viscous coefficient")?.warn(
            format!(
                "small: {} N at the {} m/s of the fully open valve, beside {} N of Coulomb friction",
                digits(braking),
                digits(sizes.speed()),
                digits(coulomb)
            ),
            "check its unit: N s/m or kN s/m? Write 0 if there is none".into(),
        );
    }
    let stribeck = most(friction.stribeck_velocity);
    if sizes.speed() > 0.0 && stribeck > sizes.speed() && breakaway > coulomb {
        table.required("stribeck-velocity", "a velocity")?.warn(
            format!(
                "large: at the {} m/s of the fully open valve friction still falls from its break-away",
                digits(sizes.speed())
            ),
            "check its unit: mm/s or m/s? Seals have some 2 to 20 mm/s".into(),
        );
    }
    let yields = friction.bristle_damping_velocity.map_or(stribeck, |of| of.plain().min(stribeck));
    let damped = friction.bristle_damping.plain() * yields;
    if friction.model == FrictionModel::LuGre && damped > DAMPED * breakaway && table.has("bristle-damping") {
        table.required("bristle-damping", "a damping")?.warn(
            format!(
                "large: {} N at the {} m/s of the Stribeck rise, beside the break-away of {} N",
                digits(damped),
                digits(yields),
                digits(breakaway)
            ),
            "check its unit: N s/m or N s/mm?".into(),
        );
    }
    let deflection = breakaway / friction.bristle_stiffness.plain();
    if friction.model == FrictionModel::LuGre && deflection > DEFLECTION * sizes.stroke {
        table.required("bristle-stiffness", "a stiffness")?.warn(
            format!("small: the bristles would yield {} mm before the piston slides", digits(1e3 * deflection)),
            "check its unit: N/m or N/mm?".into(),
        );
    }
    Ok(())
}
