//! The order of links and joints: one serial chain from the base outwards.

use crate::errors::ErrorKind;
use crate::reading::reader::Reader;
use crate::sections::reference;
use crate::sections::Result;

/// Tables of the links and joints in chain order; `joints[i]` connects `links[i]` to `links[i + 1]`.
pub struct Chain<'a> {
    pub links: Vec<(&'a str, Reader<'a>)>,
    pub joints: Vec<(&'a str, Reader<'a>)>,
}

/// A joint table and the indices of its parent and child among the link tables.
struct Connection<'a> {
    name: &'a str,
    table: Reader<'a>,
    parent: usize,
    child: usize,
}

pub fn read<'a>(root: &Reader<'a>) -> Result<Chain<'a>> {
    let links = root.named_tables("link")?;
    if links.is_empty() {
        return Err(root.missing("link", "a machine has a base and at least one moving link: add tables [link.<name>]"));
    }
    let names: Vec<&str> = links.iter().map(|(name, _)| *name).collect();
    let mut connections = Vec::new();
    for (name, table) in root.named_tables("joint")? {
        let parent = reference::index(&table.required("parent", "the name of a link")?, "link", &names)?;
        let child = reference::index(&table.required("child", "the name of a link")?, "link", &names)?;
        connections.push(Connection { name, table, parent, child });
    }
    if connections.is_empty() {
        return Err(root.missing("joint", "a machine has at least one joint: add a table [joint.<name>]"));
    }
    check_branches(&connections, &names)?;
    order(links, connections)
}

/// A link is the parent of at most one joint and the child of at most one.
fn check_branches(connections: &[Connection], names: &[&str]) -> Result<()> {
    for (i, later) in connections.iter().enumerate() {
        for earlier in &connections[..i] {
            let (key, link) = if later.parent == earlier.parent {
                ("parent", later.parent)
            } else if later.child == earlier.child {
                ("child", later.child)
            } else {
                continue;
            };
            let message = format!("link `{}` is the {key} of joint `{}` already", names[link], earlier.name);
            return Err(later
                .table
                .error(ErrorKind::NotAChain, key, message)
                .help("the links form one serial chain without branches"));
        }
    }
    Ok(())
}

fn order<'a>(links: Vec<(&'a str, Reader<'a>)>, connections: Vec<Connection<'a>>) -> Result<Chain<'a>> {
    let is_child = |link: usize| connections.iter().any(|connection| connection.child == link);
    let bases: Vec<usize> = (0..links.len()).filter(|link| !is_child(*link)).collect();
    let Some(&base) = bases.first() else {
        let first = &connections[0].table;
        return Err(first
            .error(ErrorKind::NotAChain, "parent", "the joints form a closed loop: no link is the base")
            .help("one link, the base, is the child of no joint"));
    };
    if let Some(&other) = bases.get(1) {
        let (name, table) = &links[other];
        let message = format!("no joint has the link `{name}` as its child, and the base is `{}`", links[base].0);
        return Err(table
            .place
            .error(ErrorKind::NotAChain, &table.path, message)
            .help(format!("add a joint with child = \"{name}\"")));
    }
    let mut chain = Chain { links: vec![links[base].clone()], joints: Vec::new() };
    let mut end = base;
    while let Some(next) = connections.iter().find(|connection| connection.parent == end) {
        chain.joints.push((next.name, next.table.clone()));
        chain.links.push(links[next.child].clone());
        end = next.child;
    }
    if let Some(cut) =
        connections.iter().find(|connection| !chain.joints.iter().any(|(name, _)| *name == connection.name))
    {
        return Err(cut
            .table
            .error(ErrorKind::NotAChain, "parent", "the joint is not connected to the base: its links form a loop")
            .help("every link is reached from the base"));
    }
    Ok(chain)
}
