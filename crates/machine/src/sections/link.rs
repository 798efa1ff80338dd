//! `[link.<name>]`: points, mass properties, further bodies fixed on the link.

use crate::document::{check_name, join, Node};
use crate::errors::ErrorKind;
use crate::model::{InertiaAbout, Link, Point};
use crate::number::Number;
use crate::reader::Reader;
use crate::sections::chain::Chain;
use crate::sections::Result;

/// Mass properties with the moment of inertia about the centre of gravity.
#[derive(Clone, Copy)]
struct Body<T> {
    mass: T,
    centre_of_gravity: [T; 2],
    inertia: T,
}

pub fn read<T: Number>(chain: &Chain) -> Result<Vec<Link<T>>> {
    let links = chain.links.iter().enumerate();
    links.map(|(index, (name, table))| read_link(index, name, table)).collect()
}

fn read_link<T: Number>(index: usize, name: &str, table: &Reader) -> Result<Link<T>> {
    let axis = table.quantity_or_default("axis")?;
    let outline = table.optional("outline")?.map(|field| field.points()).transpose()?.unwrap_or_default();
    let mut link = Link {
        name: name.into(),
        axis,
        mass: T::c(0.0),
        centre_of_gravity: [T::c(0.0); 2],
        inertia: T::c(0.0),
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

fn points<T: Number>(index: usize, table: &Reader) -> Result<Vec<Point<T>>> {
    let Some(names) = table.names("point")? else { return Ok(Vec::new()) };
    let point = |(name, node): (&str, &Node)| {
        check_name(name, &join(&names.path, name), &node.place)?;
        Ok(Point { link: index, name: name.into(), position: names.point(name)? })
    };
    names.nodes().map(point).collect()
}

/// The link's own mass, centre of gravity and inertia; the inertia of a fixed base may be left out.
fn own_mass<T: Number>(link: &mut Link<T>, table: &Reader, is_base: bool) -> Result<()> {
    link.mass = table.quantity("mass")?;
    link.centre_of_gravity = table.point("centre-of-gravity")?;
    let abouts = [InertiaAbout::Frame, InertiaAbout::CentreOfGravity];
    if is_base && !table.has("inertia") {
        table.optional_choice("inertia-about", &abouts)?;
        return Ok(());
    }
    link.inertia = table.quantity("inertia")?;
    link.inertia_about = table.choice("inertia-about", &abouts)?;
    let about_centre = about_centre_of_gravity(link).inertia.plain();
    if about_centre < 0.0 {
        let least = link.inertia.plain() - about_centre;
        let message = format!("less than mass times distance squared of the centre of gravity, {least:.6} kg m^2");
        return Err(table
            .error(ErrorKind::OutOfRange, "inertia", message)
            .help("if the inertia is meant about the centre of gravity, set inertia-about = \"centre-of-gravity\""));
    }
    Ok(())
}

fn bodies<T: Number>(table: &Reader) -> Result<Vec<Body<T>>> {
    let read = |(_, body): (&str, Reader)| {
        Ok(Body {
            mass: body.quantity("mass")?,
            centre_of_gravity: body.point("centre-of-gravity")?,
            inertia: body.quantity("inertia")?,
        })
    };
    table.named_tables("body")?.into_iter().map(read).collect()
}

fn distance_squared<T: Number>(a: [T; 2], b: [T; 2]) -> T {
    (a[0] - b[0]).square() + (a[1] - b[1]).square()
}

fn about_centre_of_gravity<T: Number>(link: &Link<T>) -> Body<T> {
    let shift = match link.inertia_about {
        InertiaAbout::Frame => link.mass * distance_squared(link.centre_of_gravity, [T::c(0.0); 2]),
        InertiaAbout::CentreOfGravity => T::c(0.0),
    };
    Body { mass: link.mass, centre_of_gravity: link.centre_of_gravity, inertia: link.inertia - shift }
}

/// Adds `bodies` to the link: common centre of gravity, inertia about it by the parallel axis theorem.
fn combine<T: Number>(link: &mut Link<T>, bodies: &[Body<T>]) {
    let own = about_centre_of_gravity(link);
    let all: Vec<Body<T>> = std::iter::once(own).chain(bodies.iter().copied()).collect();
    let sum = |of: &dyn Fn(&Body<T>) -> T| all.iter().map(of).reduce(|sum, part| sum + part).expect("the link's own");
    let mass = sum(&|body| body.mass);
    let moment = |axis: usize| sum(&|body| body.mass * body.centre_of_gravity[axis]);
    let centre = [moment(0) / mass, moment(1) / mass];
    link.inertia = sum(&|body| body.inertia + body.mass * distance_squared(body.centre_of_gravity, centre));
    link.inertia_about = InertiaAbout::CentreOfGravity;
    link.mass = mass;
    link.centre_of_gravity = centre;
}

/// Dotted path of a point, for messages.
pub fn point_path<T>(link: &Link<T>, point: &Point<T>) -> String {
    join(&link.name, &point.name)
}
