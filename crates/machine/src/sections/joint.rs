//! `[joint.<name>]`: motion of a link relative to the previous one.

use crate::errors::ErrorKind;
use crate::model::{AngleConvention, Joint, JointKind, Link};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::chain::Chain;
use crate::sections::{reference, Result};
use crate::units::quantities::{ANGLE, LENGTH};
use crate::units::Quantity;

pub fn read<T: Number>(chain: &Chain, links: &[Link<T>]) -> Result<Vec<Joint<T>>> {
    let joints = chain.joints.iter().enumerate();
    joints.map(|(index, (name, table))| read_joint(name, table, &links[index])).collect()
}

fn read_joint<T: Number>(name: &str, table: &Reader, parent: &Link<T>) -> Result<Joint<T>> {
    let revolute = table.choice("type", &[true, false])?;
    let at = table.required("at", "the name of a point of the parent link")?;
    let axis = axis(table, revolute)?;
    let (kind, sense) = match (revolute, axis) {
        (true, None) => revolute_kind(table)?,
        (true, Some(_)) => turning_kind(table)?,
        (false, _) => prismatic_kind(table)?,
    };
    let coordinate = coordinate(&kind);
    let point = reference::point_on(&at, at.text()?, parent)?;
    Ok(Joint {
        name: name.into(),
        kind,
        at: point.position,
        aside: point.aside,
        axis,
        zero: table.quantity_or_default_of("zero", &coordinate)?,
        sense,
        limits: limits(table, &coordinate)?,
        dead_centre_margin: table.quantity_or_default_of("dead-centre-margin", &coordinate)?,
    })
}

/// Quantity of the joint's coordinate: an angle or a length.
pub fn coordinate<T>(kind: &JointKind<T>) -> Quantity {
    match kind {
        JointKind::Revolute(_) => ANGLE.quantity(),
        JointKind::Prismatic { .. } => LENGTH.quantity(),
    }
}

fn revolute_kind<T>(table: &Reader) -> Result<(JointKind<T>, f64)> {
    forbid(table, "direction", "prismatic")?;
    let convention = table.choice("convention", &[AngleConvention::Included, AngleConvention::Relative])?;
    Ok((JointKind::Revolute(convention), sense(table, [("counter-clockwise", 1.0), ("clockwise", -1.0)])?))
}

/// About an axis of its own.
fn turning_kind<T>(table: &Reader) -> Result<(JointKind<T>, f64)> {
    forbid(table, "direction", "prismatic")?;
    if table.has("convention") {
        let message = "applies to joints in the plane only";
        return Err(table.error(ErrorKind::ConflictingKeys, "convention", message).help(
            "remove it: with `axis` the coordinate is the angle from `zero`, where parent and child are parallel",
        ));
    }
    let sense = sense(table, [("counter-clockwise", 1.0), ("clockwise", -1.0)])?;
    Ok((JointKind::Revolute(AngleConvention::Relative), sense))
}

/// The unit vector that `axis` names.
fn axis(table: &Reader, revolute: bool) -> Result<Option<[f64; 3]>> {
    let Some(field) = table.optional("axis")? else { return Ok(None) };
    if !revolute {
        forbid(table, "axis", "revolute")?;
    }
    let text = field.text()?.trim();
    let (sign, name) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest.trim()));
    let named = match name {
        "x" => Some([sign, 0.0, 0.0]),
        "y" => Some([0.0, sign, 0.0]),
        "z" => Some([0.0, 0.0, sign]),
        _ => None,
    };
    let numbers = || -> Option<[f64; 3]> {
        let inside = text.strip_prefix('(')?.strip_suffix(')')?;
        let found: Vec<f64> = inside.split(',').map(|number| number.trim().parse().ok()).collect::<Option<_>>()?;
        let [x, y, z] = found.try_into().ok()?;
        let norm = libm::sqrt(x * x + y * y + z * z);
        (norm.is_finite() && norm > 0.0).then(|| [x / norm, y / norm, z / norm])
    };
    match named.or_else(numbers) {
        Some(axis) => Ok(Some(axis)),
        None => Err(field
            .error(ErrorKind::WrongType, format!("`{text}` is no axis"))
            .help("give \"z\" for a vertical one, \"x\", \"y\", one of these with a minus, or three numbers as \"(0, 0.6, 0.8)\"")),
    }
}

fn prismatic_kind<T: Number>(table: &Reader) -> Result<(JointKind<T>, f64)> {
    forbid(table, "convention", "revolute")?;
    let direction = table.quantity("direction")?;
    Ok((JointKind::Prismatic { direction }, sense(table, [("along", 1.0), ("against", -1.0)])?))
}

/// Direction of a growing coordinate; the first one by default.
fn sense(table: &Reader, senses: [(&str, f64); 2]) -> Result<f64> {
    Ok(table.optional("positive")?.map(|field| field.choice_of(&senses)).transpose()?.unwrap_or(senses[0].1))
}

fn forbid(table: &Reader, key: &str, kind: &str) -> Result<()> {
    if !table.has(key) {
        return Ok(());
    }
    let message = format!("applies to {kind} joints only");
    Err(table.error(ErrorKind::ConflictingKeys, key, message).help("remove it, or change `type`"))
}

fn limits(table: &Reader, coordinate: &Quantity) -> Result<Option<[f64; 2]>> {
    let Some(field) = table.optional("limits")? else { return Ok(None) };
    let [low, high]: [f64; 2] = field.pair_of([coordinate, coordinate])?;
    if low < high {
        return Ok(Some([low, high]));
    }
    let unit = &coordinate.unit;
    let message = format!("the lower limit {low} {unit} is not below the upper limit {high} {unit}");
    Err(field.error(ErrorKind::CrossedLimits, message).help("write them as [lower, upper]"))
}
