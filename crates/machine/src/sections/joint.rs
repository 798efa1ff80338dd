//! `[joint.<name>]`: how a link moves against the one before it.

use crate::errors::ErrorKind;
use crate::model::{AngleConvention, Joint, JointKind, Link};
use crate::quantities;
use crate::reader::{Reader, Sign};
use crate::sections::chain::Chain;
use crate::sections::{reference, Result};
use crate::units::Quantity;

pub const KEYS: [&str; 10] =
    ["type", "parent", "child", "at", "convention", "direction", "zero", "positive", "limits", "dead-centre-margin"];

/// Distance kept from a dead centre where the file states none: 2 deg, 1 mm.
const DEFAULT_MARGIN: (f64, f64) = (2.0 * std::f64::consts::PI / 180.0, 1e-3);

pub fn read(chain: &Chain, links: &[Link]) -> Result<Vec<Joint>> {
    let joints = chain.joints.iter().enumerate();
    joints.map(|(index, (name, table))| read_joint(name, table, &links[index])).collect()
}

fn read_joint(name: &str, table: &Reader, parent: &Link) -> Result<Joint> {
    let revolute = table.choice("type", &[("revolute", true), ("prismatic", false)])?;
    let at = table.required("at", "the name of a point of the parent link")?;
    let (kind, sense) = if revolute { revolute_kind(table)? } else { prismatic_kind(table)? };
    let coordinate = coordinate(&kind);
    let default_margin = if revolute { DEFAULT_MARGIN.0 } else { DEFAULT_MARGIN.1 };
    Ok(Joint {
        name: name.into(),
        kind,
        at: reference::point_on(&at, at.text()?, parent)?.position,
        zero: table.quantity_or("zero", &coordinate, Sign::Any, 0.0)?,
        sense,
        limits: limits(table, &coordinate)?,
        dead_centre_margin: table.quantity_or("dead-centre-margin", &coordinate, Sign::NonNegative, default_margin)?,
    })
}

/// What the joint's coordinate is: an angle or a length.
pub fn coordinate(kind: &JointKind) -> Quantity {
    match kind {
        JointKind::Revolute(_) => quantities::angle(),
        JointKind::Prismatic { .. } => quantities::length(),
    }
}

fn revolute_kind(table: &Reader) -> Result<(JointKind, f64)> {
    forbid(table, "direction", "prismatic")?;
    let conventions = [("included", AngleConvention::Included), ("relative", AngleConvention::Relative)];
    let senses = [("counter-clockwise", 1.0), ("clockwise", -1.0)];
    let convention = table.choice("convention", &conventions)?;
    Ok((JointKind::Revolute(convention), table.choice_or("positive", &senses, 1.0)?))
}

fn prismatic_kind(table: &Reader) -> Result<(JointKind, f64)> {
    forbid(table, "convention", "revolute")?;
    let direction = table.quantity("direction", &quantities::angle(), Sign::Any)?;
    Ok((JointKind::Prismatic { direction }, table.choice_or("positive", &[("along", 1.0), ("against", -1.0)], 1.0)?))
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
    let [low, high] = field.pair([coordinate, coordinate], Sign::Any)?;
    if low < high {
        return Ok(Some([low, high]));
    }
    let unit = &coordinate.unit;
    let message = format!("the lower limit {low} {unit} is not below the upper limit {high} {unit}");
    Err(field.error(ErrorKind::CrossedLimits, message).help("write them as [lower, upper]"))
}
