//! Mass, moment of inertia and centre of gravity of a link against its size.

use super::{digits, slides};
use crate::errors::ErrorKind;
use crate::model::{InertiaAbout, Link, Machine};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;
use std::f64::consts::TAU;

/// Of lead, the densest material of counterweights, kg/m^3.
const DENSEST: f64 = 11_340.0;
/// With this many times the allowed span, no link is meant.
const SURE: f64 = 10.0;
/// Radii of gyration in spans of a link's points. A uniform beam of one span has 0.29, all mass at both ends 0.5; the bounds have beams of
/// 0.43 and 2.6 spans.
const GYRATION: [f64; 2] = [0.125, 0.75];
/// Where matter reaches beyond the points by one span, its centre of gravity does so by half of that.
const BEYOND: f64 = 0.5;
/// Share of the span of a link within which no point lies apart from the origin: in mm taken as m, all of them would.
const THOUSANDTH: f64 = 1.001e-3;
/// A point may be this many times as far from its link's origin as all the rest of the machine is long.
const FAR: f64 = 5.0;

pub fn check<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let tables = root.named_tables("link")?;
    let spans: Vec<f64> = (0..machine.links.len()).map(|link| span(machine, link)).collect();
    for (index, link) in machine.links.iter().enumerate() {
        let Some((_, table)) = tables.iter().find(|(name, _)| *name == link.name) else { continue };
        far_points(table, machine, &spans, index)?;
        near_points(table, machine, &spans, index)?;
        // The base is a vehicle, and what slews carries a house or a column: of their sizes pins say nothing.
        let large = index == 0 || machine.joints[index - 1].axis.is_some();
        if spans[index] == 0.0 || large || table.is_doubted() {
            continue;
        }
        // With further bodies fixed on it, each is judged by its own values.
        let bodies = table.named_tables("body")?;
        if table.has("mass") && bodies.is_empty() {
            let about_frame = link.inertia_about == InertiaAbout::Frame;
            let matter = Matter::of(link, about_frame);
            matter.judge(table, link, spans[index])?;
            matter.judge_lump(table, spans[index] - slides(machine, index))?;
        }
        for (_, body) in bodies {
            let matter = Matter {
                mass: value(&body, "mass")?,
                centre: {
                    let [x, _, z] = body.point::<f64>("centre-of-gravity")?;
                    [x, z]
                },
                inertia: value(&body, "inertia")?,
            };
            matter.judge(&body, link, spans[index])?;
        }
    }
    Ok(())
}

fn value(table: &Reader, key: &str) -> Result<f64> {
    table.quantity(key)
}

/// Largest distance of two points of a link, its origin and its outline among them, and of what slides in another link, m.
fn span<T: Number>(machine: &Machine<T>, link: usize) -> f64 {
    let places = places(&machine.links[link]);
    let pairs = places.iter().enumerate().flat_map(|(i, a)| places[..i].iter().map(move |b| distance(a, b)));
    pairs.fold(0.0, f64::max) + slides(machine, link)
}

fn places<T: Number>(link: &Link<T>) -> Vec<[f64; 2]> {
    let named = link.points.iter().map(|point| point.position.map(T::plain));
    named.chain(link.outline.iter().copied()).chain([[0.0; 2]]).collect()
}

fn distance(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// Warns of a point that lies outside of everything: several times farther away than the rest of the machine is long.
fn far_points<T: Number>(table: &Reader, machine: &Machine<T>, spans: &[f64], index: usize) -> Result<()> {
    let Some(names) = table.names("point")? else { return Ok(()) };
    let links: f64 = spans.iter().enumerate().filter(|(link, _)| *link != index).map(|(_, span)| span).sum();
    let extended = machine.cylinders.iter().map(|of| of.mid_length.plain() + 0.5 * of.stroke.plain());
    let rest = links + extended.sum::<f64>();
    for point in &machine.links[index].points {
        let away = libm::hypot(point.position[0].plain(), point.position[1].plain());
        if away > FAR * rest {
            names.required(&point.name, "a point")?.warn(
                format!(
                    "far away: {} m, while all other links and cylinders together are {} m long",
                    digits(away),
                    digits(rest)
                ),
                "check its unit: mm, cm or m?".into(),
            );
        }
    }
    Ok(())
}

/// Warns of a point, or of the centre of gravity, that all but lies in the origin of its link's frame.
fn near_points<T: Number>(table: &Reader, machine: &Machine<T>, spans: &[f64], index: usize) -> Result<()> {
    let (link, span) = (&machine.links[index], spans[index]);
    let near = |at: [f64; 3]| {
        let away = libm::hypot(libm::hypot(at[0], at[1]), at[2]);
        (0.0 < away && away <= THOUSANDTH * span).then_some(away)
    };
    let words = |away: f64| {
        (
            format!(
                "{} mm from the origin of its link's frame, and the points of the link span {} m",
                digits(1e3 * away),
                digits(span)
            ),
            "check its unit: mm, cm or m? Write 0 for the origin itself".to_string(),
        )
    };
    if let Some(names) = table.names("point")? {
        for point in &link.points {
            let [x, z] = point.position.map(T::plain);
            if let Some((text, cure)) = near([x, point.aside.plain(), z]).map(words) {
                names.required(&point.name, "a point")?.warn(text, cure);
            }
        }
    }
    if table.has("centre-of-gravity") && link.mass.plain() > 0.0 {
        if let Some((text, cure)) = near(table.point::<f64>("centre-of-gravity")?).map(words) {
            table.required("centre-of-gravity", "a point")?.warn(text, cure);
        }
    }
    Ok(())
}

/// A rigid body: kg, m in the link's frame, kg m^2 about the centre of gravity.
struct Matter {
    mass: f64,
    centre: [f64; 2],
    inertia: f64,
}

impl Matter {
    fn of<T: Number>(link: &Link<T>, about_frame: bool) -> Self {
        let (mass, centre) = (link.mass.plain(), link.centre_of_gravity.map(T::plain));
        let shift = if about_frame { mass * (centre[0] * centre[0] + centre[1] * centre[1]) } else { 0.0 };
        Self { mass, centre, inertia: link.inertia.plain() - shift }
    }

    fn judge<T: Number>(&self, table: &Reader, link: &Link<T>, span: f64) -> Result<()> {
        self.judge_centre(table, link, span)?;
        // A zero states a point mass.
        if self.inertia > 0.0 && table.has("inertia") {
            self.judge_inertia(table, span)?;
        }
        Ok(())
    }

    /// The centre against the box about the points.
    fn judge_centre<T: Number>(&self, table: &Reader, link: &Link<T>, span: f64) -> Result<()> {
        let places = places(link);
        let beyond = [0, 1].map(|axis| {
            let ends = places.iter().fold([0.0_f64; 2], |[low, high], at| [low.min(at[axis]), high.max(at[axis])]);
            (ends[0] - self.centre[axis]).max(self.centre[axis] - ends[1]).max(0.0)
        });
        let away = libm::hypot(beyond[0], beyond[1]);
        if away <= BEYOND * span {
            return Ok(());
        }
        let text = format!("beyond the link: {} m outside of its points, which span {} m", digits(away), digits(span));
        let cure = "give it in the link's frame, and check its unit and those of the points";
        if away > SURE * span {
            return Err(table.error(ErrorKind::OutOfRange, "centre-of-gravity", text).help(cure));
        }
        table.required("centre-of-gravity", "a point")?.warn(text, cure.into());
        Ok(())
    }

    fn radius(&self) -> f64 {
        libm::sqrt(self.inertia / self.mass)
    }

    /// What the moment of inertia says of the size of the link, and the cure.
    fn size(&self, word: &str, span: f64) -> [String; 2] {
        let [mass, radius, usual] = [self.mass, self.radius(), self.mass * span * span / 12.0].map(digits);
        let span = digits(span);
        [
            format!("{word} for {mass} kg: the radius of gyration would be {radius} m, and the points of the link span {span} m"),
            format!("check the units of mass and inertia: a beam of {mass} kg as long as that has {usual} kg m^2"),
        ]
    }

    /// A link of one body is no lump somewhere between its points.
    fn judge_lump(&self, table: &Reader, span: f64) -> Result<()> {
        if self.inertia > 0.0 && self.radius() < GYRATION[0] * span {
            let [text, cure] = self.size("small", span);
            table.required("inertia", "a moment of inertia")?.warn(text, format!("{cure}; write 0 for a point mass"));
        }
        Ok(())
    }

    /// The least moment of inertia has a round bar of lead across the plane, as wide as the span w: m^2 / (2 pi density w).
    fn judge_inertia(&self, table: &Reader, span: f64) -> Result<()> {
        let radius = self.radius();
        let least = self.mass * self.mass / (TAU * DENSEST * span);
        let [text, cure] = self.size("large", span);
        if radius > GYRATION[1] * span {
            if radius > SURE * span {
                return Err(table.error(ErrorKind::OutOfRange, "inertia", text).help(cure));
            }
            table.required("inertia", "a moment of inertia")?.warn(text, cure);
        } else if self.inertia < least {
            table.required("inertia", "a moment of inertia")?.warn(
                format!(
                    "small for {} kg: even a round bar of lead across the plane has {} kg m^2",
                    digits(self.mass),
                    digits(least)
                ),
                format!("{cure}; write 0 for a point mass"),
            );
        }
        Ok(())
    }
}
