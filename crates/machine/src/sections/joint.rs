//! `[joint.<name>]`: motion of a link relative to the previous one.

use crate::errors::ErrorKind;
use crate::model::{AngleConvention, Joint, JointKind, Link};
use crate::number::Number;
use crate::quantities::{ANGLE, LENGTH};
use crate::reader::Reader;
use crate::sections::chain::Chain;
use crate::sections::{reference, Result};
use crate::units::Quantity;

pub fn read<T: Number>(chain: &Chain, links: &[Link<T>]) -> Result<Vec<Joint<T>>> {
    let joints = chain.joints.iter().enumerate();
    joints.map(|(index, (name, table))| read_joint(name, table, &links[index])).collect()
}

fn read_joint<T: Number>(name: &str, table: &Reader, parent: &Link<T>) -> Result<Joint<T>> {
    let revolute = table.choice("type", &[true, false])?;
    let at = table.required("at", "the name of a point of the parent link")?;
    let (kind, sense) = if revolute { revolute_kind(table)? } else { prismatic_kind(table)? };
    let coordinate = coordinate(&kind);
    Ok(Joint {
        name: name.into(),
        kind,
        at: reference::point_on(&at, at.text()?, parent)?.position,
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
