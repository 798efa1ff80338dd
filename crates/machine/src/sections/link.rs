//! `[link.<name>]`: points, mass properties, further bodies fixed on the link.

use crate::document::join;
use crate::errors::ErrorKind;
use crate::model::{InertiaAbout, Link, Point};
use crate::reader::Reader;
use crate::sections::chain::Chain;
use crate::sections::Result;

/// Mass properties with the moment of inertia about the centre of gravity.
#[derive(Clone, Copy)]
struct Body {
    mass: f64,
    centre_of_gravity: [f64; 2],
    inertia: f64,
}

pub fn read(chain: &Chain) -> Result<Vec<Link>> {
    let links = chain.links.iter().enumerate();
    links.map(|(index, (name, table))| read_link(index, name, table)).collect()
}

fn read_link(index: usize, name: &str, table: &Reader) -> Result<Link> {
    let axis = table.quantity_or_default("axis")?;
    let outline = table.optional("outline")?.map(|field| field.points()).transpose()?.unwrap_or_default();
    let mut link = Link {
        name: name.into(),
        axis,
        mass: 0.0,
        centre_of_gravity: [0.0; 2],
        inertia: 0.0,
        inertia_about: InertiaAbout::CentreOfGravity,
        points: points(index, table)?,
        outline,
    };
    let bodies = bodies(table)?;
    // The base is fixed, and a link may consist of its bodies alone.
    if table.has("mass") || (index > 0 && bodies.is_empty()) {
        own_mass(&mut link, table, index == 0)?;
    } else if let Some(key) = ["centre-of-gravity", "inertia", "inertia-about"].into_iter().find(|key| table.has(key)) {
        return Err(table.error(ErrorKind::ConflictingKeys, key, "given without `mass`").help("give the mass too"));
    }
    if !bodies.is_empty() {
        combine(&mut link, &bodies);
    }
    Ok(link)
}

fn points(index: usize, table: &Reader) -> Result<Vec<Point>> {
    let Some(names) = table.names("point")? else { return Ok(Vec::new()) };
    names.keys().map(|name| Ok(Point { link: index, name: name.into(), position: names.point(name)? })).collect()
}

/// The link's own mass, centre of gravity and inertia; the inertia of a fixed base may be left out.
fn own_mass(link: &mut Link, table: &Reader, is_base: bool) -> Result<()> {
    link.mass = table.quantity("mass")?;
    link.centre_of_gravity = table.point("centre-of-gravity")?;
    let abouts = [InertiaAbout::Frame, InertiaAbout::CentreOfGravity];
    if is_base && !table.has("inertia") {
        table.optional_choice("inertia-about", &abouts)?;
        return Ok(());
    }
    link.inertia = table.quantity("inertia")?;
    link.inertia_about = table.choice("inertia-about", &abouts)?;
    let about_centre = about_centre_of_gravity(link);
    if about_centre.inertia < 0.0 {
        let least = link.inertia - about_centre.inertia;
        let message = format!("less than mass times distance squared of the centre of gravity, {least:.6} kg m^2");
        return Err(table
            .error(ErrorKind::OutOfRange, "inertia", message)
            .help("if the inertia is meant about the centre of gravity, set inertia-about = \"centre-of-gravity\""));
    }
    Ok(())
}

fn bodies(table: &Reader) -> Result<Vec<Body>> {
    let read = |(_, body): (&str, Reader)| {
        Ok(Body {
            mass: body.quantity("mass")?,
            centre_of_gravity: body.point("centre-of-gravity")?,
            inertia: body.quantity("inertia")?,
        })
    };
    table.named_tables("body")?.into_iter().map(read).collect()
}

fn distance_squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

fn about_centre_of_gravity(link: &Link) -> Body {
    let shift = match link.inertia_about {
        InertiaAbout::Frame => link.mass * distance_squared(link.centre_of_gravity, [0.0; 2]),
        InertiaAbout::CentreOfGravity => 0.0,
    };
    Body { mass: link.mass, centre_of_gravity: link.centre_of_gravity, inertia: link.inertia - shift }
}

/// Adds `bodies` to the link: common centre of gravity, inertia about it by the parallel axis theorem.
fn combine(link: &mut Link, bodies: &[Body]) {
    let own = about_centre_of_gravity(link);
    let all: Vec<Body> = std::iter::once(own).chain(bodies.iter().copied()).collect();
    let mass: f64 = all.iter().map(|body| body.mass).sum();
    let moment = |axis: usize| all.iter().map(|body| body.mass * body.centre_of_gravity[axis]).sum::<f64>();
    let centre = [moment(0) / mass, moment(1) / mass];
    link.inertia =
        all.iter().map(|body| body.inertia + body.mass * distance_squared(body.centre_of_gravity, centre)).sum();
    link.inertia_about = InertiaAbout::CentreOfGravity;
    link.mass = mass;
    link.centre_of_gravity = centre;
}

/// Dotted path of a point, for messages.
pub fn point_path(link: &Link, point: &Point) -> String {
    join(&link.name, &point.name)
}
