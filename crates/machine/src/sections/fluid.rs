//! `[fluid]`.

use crate::errors::ErrorKind;
use crate::model::{Cavitation, Fluid};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::{required_table, Result};
use crate::units::quantities::{Kind, KINEMATIC, VISCOSITY};

/// Least distance of vacuum below zero, Pa; with less, gas would fill a chamber instantaneously.
const LEAST_VACUUM: f64 = 1e4;
/// Least modulus of oil without pressure, Pa; with less, about 100 bar would compress the oil to nothing.
const LEAST_MODULUS: f64 = 2e6;

/// Coefficients of the pressure-dependent bulk modulus, thesis (96).
struct BulkModulus<T> {
    max: T,
    c1: T,
    c2: T,
    reference_pressure: T,
}

pub fn read<T: Number>(root: &Reader) -> Result<Fluid<T>> {
    let table = required_table(root, "fluid")?;
    let bulk = bulk_modulus(&table)?;
    let density = table.quantity("density")?;
    Ok(Fluid {
        density,
        bulk_modulus_max: bulk.max,
        bulk_c1: bulk.c1,
        bulk_c2: bulk.c2,
        bulk_reference_pressure: bulk.reference_pressure,
        cavitation: cavitation(&table)?,
        viscosity: viscosity(&table, density)?,
        printed_leakage_viscosity: table
            .table("printed")?
            .map(|printed| printed.quantity("leakage-viscosity"))
            .transpose()?,
    })
}

/// Dynamic viscosity; a kinematic one counts times the density, of which it keeps the derivative.
fn viscosity<T: Number>(table: &Reader, density: T) -> Result<T> {
    let [dynamic, kinematic] = [VISCOSITY, KINEMATIC].map(Kind::quantity);
    let field = table.required("viscosity", &dynamic.example())?;
    let plain = density.plain();
    let viscosity: T = field.quantity_or(&dynamic, &kinematic, plain)?;
    Ok(if field.is(&kinematic) { viscosity * (density / T::c(plain)) } else { viscosity })
}

fn bulk_modulus<T: Number>(table: &Reader) -> Result<BulkModulus<T>> {
    let groups: [&[&str]; 2] =
        [&["bulk-modulus"], &["bulk-modulus-max", "bulk-c1", "bulk-c2", "bulk-reference-pressure"]];
    match table.either(groups)? {
        // With c1 = 0 and c2 = 100, half the decimal logarithm is one.
        Some(0) => {
            let max = table.quantity("bulk-modulus")?;
            Ok(BulkModulus { max, c1: T::c(0.0), c2: T::c(100.0), reference_pressure: T::c(1e5) })
        }
        Some(_) => varying_bulk_modulus(table),
        None => Err(table.missing("bulk-modulus", "give it, or `bulk-modulus-max` with its coefficients")),
    }
}

fn varying_bulk_modulus<T: Number>(table: &Reader) -> Result<BulkModulus<T>> {
    let bulk: BulkModulus<T> = BulkModulus {
        max: table.quantity("bulk-modulus-max")?,
        c1: table.quantity("bulk-c1")?,
        c2: table.quantity("bulk-c2")?,
        reference_pressure: table.quantity("bulk-reference-pressure")?,
    };
    let [max, c2] = [bulk.max, bulk.c2].map(T::plain);
    if c2 <= 1.0 {
        return Err(table
            .error(ErrorKind::OutOfRange, "bulk-c2", "must exceed 1: the modulus at zero pressure is its logarithm")
            .help("the literature gives 3"));
    }
    let at_zero = 0.5 * max * libm::log10(c2);
    if at_zero >= LEAST_MODULUS {
        return Ok(bulk);
    }
    let message = format!("with `bulk-c2` the modulus at zero pressure is {:.3} MPa, below 2 MPa", at_zero * 1e-6);
    Err(table.error(ErrorKind::OutOfRange, "bulk-modulus-max", message).help("oil has some 1000 MPa; check the unit"))
}

fn cavitation<T: Number>(table: &Reader) -> Result<Cavitation<T>> {
    let free_gas = table.choice("cavitation", &[true, false])?;
    let vacuum: Option<T> = table.optional_quantity("vacuum")?;
    if !free_gas {
        return Ok(Cavitation::None);
    }
    let vacuum = vacuum.ok_or_else(|| table.missing("vacuum", "give the gauge pressure of vacuum, \"-1 bar\""))?;
    if vacuum.plain() <= -LEAST_VACUUM {
        return Ok(Cavitation::FreeGas { vacuum });
    }
    Err(table
        .error(ErrorKind::OutOfRange, "vacuum", "pressures are gauge: vacuum lies below -0.1 bar")
        .help("give \"-1 bar\""))
}
