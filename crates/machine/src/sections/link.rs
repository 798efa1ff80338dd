//! `[link.<name>]`: points, mass properties, further bodies fixed on the link.

use crate::errors::ErrorKind;
use crate::model::{InertiaAbout, Link, Point, Solid};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::chain::Chain;
use crate::sections::Result;
use crate::text::document::{check_name, join, Node};

/// Mass properties with the moment of inertia about the centre of gravity.
#[derive(Clone, Copy)]
struct Body<T> {
    mass: T,
    centre_of_gravity: [T; 2],
    inertia: T,
    solid: Option<Solid<T>>,
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
        solid: None,
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
        let [x, aside, z] = names.point(name)?;
        Ok(Point { link: index, name: name.into(), position: [x, z], aside })
    };
    names.nodes().map(point).collect()
}

/// The link's own mass, centre of gravity and inertia; the inertia of a fixed base may be left out.
fn own_mass<T: Number>(link: &mut Link<T>, table: &Reader, is_base: bool) -> Result<()> {
    link.mass = table.quantity("mass")?;
    let [x, y, z] = table.point("centre-of-gravity")?;
    link.centre_of_gravity = [x, z];
    let abouts = [InertiaAbout::Frame, InertiaAbout::CentreOfGravity];
    if is_base && !table.has("inertia") {
        table.optional_choice("inertia-about", &abouts)?;
        return Ok(());
    }
    link.inertia = table.quantity("inertia")?;
    link.inertia_about = table.choice("inertia-about", &abouts)?;
    link.solid = solid(table, y)?;
    let about_centre = about_centre_of_gravity(link).inertia.plain();
    if let Some(of) = &link.solid {
        possible(table, about_centre_of_gravity(link).inertia, of)?;
    }
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
        let [x, y, z] = body.point("centre-of-gravity")?;
        let own = Body {
            mass: body.quantity("mass")?,
            centre_of_gravity: [x, z],
            inertia: body.quantity("inertia")?,
            solid: solid(&body, y)?,
        };
        if let Some(of) = &own.solid {
            possible(&body, own.inertia, of)?;
        }
        Ok(own)
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
    let solid = link.solid;
    Body { mass: link.mass, centre_of_gravity: link.centre_of_gravity, inertia: link.inertia - shift, solid }
}

/// Adds `bodies` to the link: common centre of gravity, inertia about it by the parallel axis theorem.
fn combine<T: Number>(link: &mut Link<T>, bodies: &[Body<T>]) {
    let own = about_centre_of_gravity(link);
    let all: Vec<Body<T>> =
        std::iter::once(own).filter(|own| own.mass.plain() > 0.0).chain(bodies.iter().copied()).collect();
    let sum = |of: &dyn Fn(&Body<T>) -> T| all.iter().map(of).reduce(|sum, part| sum + part).expect("the link's own");
    let mass = sum(&|body| body.mass);
    let moment = |axis: usize| sum(&|body| body.mass * body.centre_of_gravity[axis]);
    let centre = [moment(0) / mass, moment(1) / mass];
    link.inertia = sum(&|body| body.inertia + body.mass * distance_squared(body.centre_of_gravity, centre));
    link.inertia_about = InertiaAbout::CentreOfGravity;
    link.solid = common(&all, mass, centre);
    link.mass = mass;
    link.centre_of_gravity = centre;
}

/// What `all` bodies have together outside the plane, where every one of them states it.
fn common<T: Number>(all: &[Body<T>], mass: T, [x, z]: [T; 2]) -> Option<Solid<T>> {
    let none = T::c(0.0);
    let mut sum = Solid { y: none, xx: none, zz: none, xy: none, xz: none, yz: none };
    for body in all {
        sum.y += body.mass * body.solid?.y / mass;
    }
    for Body { mass, centre_of_gravity, solid, .. } in all {
        let (own, mass) = ((*solid)?, *mass);
        let (dx, dy, dz) = (centre_of_gravity[0] - x, own.y - sum.y, centre_of_gravity[1] - z);
        sum.xx += own.xx + mass * (dy * dy + dz * dz);
        sum.zz += own.zz + mass * (dx * dx + dy * dy);
        sum.xy += own.xy - mass * dx * dy;
        sum.xz += own.xz - mass * dx * dz;
        sum.yz += own.yz - mass * dy * dz;
    }
    Some(sum)
}

/// What a table states of a body outside the plane; `y` (m) is the place of its centre of gravity.
fn solid<T: Number>(table: &Reader, y: T) -> Result<Option<Solid<T>>> {
    if !table.has("inertia-x") && !table.has("inertia-z") {
        let product = ["inertia-xy", "inertia-xz", "inertia-yz"].into_iter().find(|key| table.has(key));
        return match product {
            Some(key) => Err(table
                .error(ErrorKind::ConflictingKeys, key, "given without `inertia-x` and `inertia-z`")
                .help("give these two as well, or none of them")),
            None => Ok(None),
        };
    }
    Ok(Some(Solid {
        y,
        xx: table.quantity("inertia-x")?,
        zz: table.quantity("inertia-z")?,
        xy: table.quantity_or_default("inertia-xy")?,
        xz: table.quantity_or_default("inertia-xz")?,
        yz: table.quantity_or_default("inertia-yz")?,
    }))
}

/// Rounding of a file's numbers, as a share of the sum of the moments of inertia.
const ROUNDING: f64 = 1e-4;

/// A body has the second moments of mass tr(I)/2 - I, which are nowhere negative.
fn possible<T: Number>(table: &Reader, yy: T, of: &Solid<T>) -> Result<()> {
    let [xx, yy, zz, xy, xz, yz] = [of.xx, yy, of.zz, of.xy, of.xz, of.yz].map(T::plain);
    let half = 0.5 * (xx + yy + zz);
    let (moments, _) =
        hydrocrane_num::linear::symmetric::eigen([[half - xx, -xy, -xz], [-xy, half - yy, -yz], [-xz, -yz, half - zz]]);
    if moments.iter().all(|moment| *moment >= -ROUNDING * half) {
        return Ok(());
    }
    let message =
        "no body has such a tensor of inertia: one of its principal moments is larger than the other two together";
    Err(table
        .error(ErrorKind::OutOfRange, "inertia-x", message)
        .help("check units and signs; a flat body in the plane has inertia = inertia-x + inertia-z, and none has more"))
}

/// Dotted path of a point, for messages.
pub fn point_path<T>(link: &Link<T>, point: &Point<T>) -> String {
    join(&link.name, &point.name)
}
