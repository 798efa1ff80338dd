//! References by name: points as `link.point`, tables that name the joint or cylinder they belong to.

use crate::errors::ErrorKind;
use crate::model::{Link, Point};
use crate::nearest::suggestion;
use crate::reading::reader::{Field, Reader};
use crate::sections::Result;

/// The point that a value such as `"boom.tip"` names.
pub fn point<T: Copy>(field: &Field, links: &[Link<T>]) -> Result<Point<T>> {
    let text = field.text()?;
    let Some((link_name, point_name)) = text.split_once('.') else {
        let message = format!("`{text}` is not a point");
        return Err(field.error(ErrorKind::UnknownReference, message).help("write link and point as \"link.point\""));
    };
    let Some(link) = links.iter().find(|link| link.name == link_name) else {
        let help = suggestion(link_name, links.iter().map(|link| link.name.as_str()));
        return Err(field.error(ErrorKind::UnknownReference, format!("there is no link `{link_name}`")).help(help));
    };
    point_on(field, point_name, link)
}

/// The point `name` of `link`; `field` is where it was named.
pub fn point_on<T: Copy>(field: &Field, name: &str, link: &Link<T>) -> Result<Point<T>> {
    link.points.iter().find(|point| point.name == name).cloned().ok_or_else(|| {
        let message = format!("link `{}` has no point `{name}`", link.name);
        let help = suggestion(name, link.points.iter().map(|point| point.name.as_str()));
        field.error(ErrorKind::UnknownReference, message).help(help)
    })
}

/// The index of the name that `field` holds, among `names` of things called `what`.
pub fn index(field: &Field, what: &str, names: &[&str]) -> Result<usize> {
    let text = field.text()?;
    names.iter().position(|name| *name == text).ok_or_else(|| {
        let help = suggestion(text, names.iter().copied());
        field.error(ErrorKind::UnknownReference, format!("there is no {what} `{text}`")).help(help)
    })
}

/// Orders `tables`, each of which names its owner under the key `what`, so that they match `owners` one to one.
/// `kind` is what the tables are called in messages.
pub fn one_to_one<'a>(
    kind: &str,
    tables: Vec<(&'a str, Reader<'a>)>,
    what: &str,
    owners: &[(&'a str, Reader<'a>)],
) -> Result<Vec<(&'a str, Reader<'a>)>> {
    let names: Vec<&str> = owners.iter().map(|(name, _)| *name).collect();
    let mut ordered: Vec<Option<(&str, Reader)>> = owners.iter().map(|_| None).collect();
    for (name, table) in tables {
        let owner = index(&table.required(what, &format!("the name of its {what}"))?, what, &names)?;
        if let Some((other, _)) = &ordered[owner] {
            let message = format!("{what} `{}` belongs to `{kind}.{other}` already", names[owner]);
            let help = format!("every {what} has exactly one table [{kind}.<name>]");
            return Err(table.error(ErrorKind::NotOneToOne, what, message).help(help));
        }
        ordered[owner] = Some((name, table));
    }
    let matched = ordered.into_iter().zip(owners).map(|(table, (owner, owner_table))| {
        table.ok_or_else(|| {
            let message = format!("no table [{kind}.<name>] belongs to {what} `{owner}`");
            let help = format!("add one with {what} = \"{owner}\"");
            owner_table.place.error(ErrorKind::NotOneToOne, &owner_table.path, message).help(help)
        })
    });
    matched.collect()
}
