//! Pressure drop of a line, stated at one flow or computed from its walls.

use std::f64::consts::{FRAC_PI_4, PI};

use crate::errors::ErrorKind;
use crate::model::{Fluid, Resistance};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;

/// Reynolds number up to which the flow in a pipe is laminar.
const LAMINAR: f64 = 2300.0;
/// Of the law of Blasius for smooth walls: friction factor times the fourth root of the Reynolds number.
const BLASIUS: f64 = 0.3164;

/// A straight line of round bore.
pub struct Bore<T> {
    /// m
    pub length: T,
    pub inner_diameter: T,
}

/// `None`: the file states no flow, and the line has no resistance.
pub fn read<T: Number>(table: &Reader, bore: Option<&Bore<T>>, fluid: &Fluid<T>) -> Result<Option<Resistance<T>>> {
    let Some(flow) = table.optional_quantity::<T>("nominal-flow")? else {
        let lonely = ["nominal-pressure-drop", "laminar-share"].into_iter().find(|key| table.has(key));
        return lonely.map_or(Ok(None), |key| {
            Err(table.missing("nominal-flow", format!("give the flow of `{key}`, or leave both out")))
        });
    };
    match (table.optional_quantity("nominal-pressure-drop")?, bore) {
        (Some(drop), _) => stated(table, flow, drop).map(Some),
        (None, Some(bore)) if !table.has("laminar-share") => Ok(Some(of_walls(bore, fluid, flow))),
        (None, Some(_)) => {
            let message = "the drop is that of wall friction, whose laminar share is computed";
            Err(table
                .error(ErrorKind::ConflictingKeys, "laminar-share", message)
                .help("give `nominal-pressure-drop` too, or leave it out"))
        }
        (None, None) => Err(table.missing("nominal-pressure-drop", "give the drop at `nominal-flow`")),
    }
}

fn stated<T: Number>(table: &Reader, flow: T, drop: T) -> Result<Resistance<T>> {
    let share: T = table.quantity_or_default("laminar-share")?;
    if share.plain() <= 1.0 {
        return Ok(Resistance { laminar: share * drop / flow, turbulent: (T::c(1.0) - share) * drop / flow.square() });
    }
    let message = "exceeds 1: the turbulent part of the drop would be negative";
    Err(table.error(ErrorKind::OutOfRange, "laminar-share", message).help("give a share: 0.5, or \"50 %\""))
}

/// Hagen and Poiseuille, and what the law of Blasius has beyond it at this `flow` (m^3/s), if the flow is turbulent there.
fn of_walls<T: Number>(bore: &Bore<T>, fluid: &Fluid<T>, flow: T) -> Resistance<T> {
    let Bore { length, inner_diameter: d } = *bore;
    let area = d.square() * FRAC_PI_4;
    let laminar = fluid.viscosity * length * 128.0 / (d.square().square() * PI);
    let speed = flow / area;
    let reynolds = fluid.density * speed * d / fluid.viscosity;
    let factor = T::c(BLASIUS) / reynolds.sqrt().sqrt();
    let smooth = factor * length / d * fluid.density * speed.square() * 0.5;
    let beyond = if reynolds.plain() > LAMINAR { smooth - laminar * flow } else { T::c(0.0) };
    Resistance { laminar, turbulent: beyond / flow.square() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Cavitation;

    #[test]
    fn a_pipe_has_the_drop_of_its_law_at_the_stated_flow() {
        let fluid = Fluid {
            density: 870.0,
            viscosity: 0.04,
            printed_leakage_viscosity: None,
            bulk_modulus_max: 1e9,
            bulk_reference_pressure: 1e7,
            bulk_c1: 1.0,
            bulk_c2: 1.0,
            cavitation: Cavitation::None,
        };
        let bore = Bore { length: 10.0, inner_diameter: 0.012 };
        let drop = |litres: f64| {
            let q = litres / 60e3;
            let of = of_walls(&bore, &fluid, q);
            of.laminar * q + of.turbulent * q * q
        };
        // 20 l/min: 2.9 m/s, Re 769, 64/Re * L/d * rho v^2/2.
        assert!((drop(20.0) / 2.62e5 - 1.0).abs() < 5e-3, "{}", drop(20.0));
        // 120 l/min: 17.7 m/s, Re 4615, 0.3164 Re^-0.25 * L/d * rho v^2/2.
        assert!((drop(120.0) / 43.5e5 - 1.0).abs() < 5e-3, "{}", drop(120.0));
    }
}
