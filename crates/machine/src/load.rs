//! Loads a checked machine from a bundled name or a path.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, OnceLock};

use crate::errors::{ErrorKind, Location, MachineError};
use crate::model::Machine;
use crate::nearest::suggestion;
use crate::number::{Number, Variable};
use crate::sections;
use crate::text::bundled::{bundled_machines, bundled_scenarios};
use crate::text::disk;
use crate::text::document::{self, Budget, Node, NodeKind, Place, Scalar, SourceFile};
use crate::text::merge::{apply_override, merge, take_out, Override, OverrideValue};
use crate::whole;

type Result<T> = std::result::Result<T, MachineError>;

/// Names and texts of files in place of those on disk.
pub type Given = [(String, String)];

/// A file's text and where the files lie that it names: in a folder, or among those `given` (both empty: bundled).
pub struct Source {
    pub file: Arc<SourceFile>,
    pub folder: Option<PathBuf>,
    pub given: Arc<Given>,
}

/// A text in memory with the files that it may name.
pub fn in_memory(text: &str, origin: &str, given: &Given) -> Source {
    Source { file: Arc::new(SourceFile { name: origin.into(), text: text.into() }), folder: None, given: given.into() }
}

/// Loads the machine `source`, a bundled name or a path, with `overrides` by dotted key in place of its values.
///
/// # Errors
/// The first problem met, with its place and cure.
pub fn load(source: &str, overrides: &[(String, OverrideValue)]) -> Result<Machine> {
    load_with(source, &placed(overrides))
}

/// As [`load`], for overrides written in a file.
pub fn load_with(source: &str, overrides: &[Override]) -> Result<Machine> {
    match bundled(source) {
        Some(kept) if overrides.is_empty() => kept?.machine().cloned(),
        _ => build(named_tree(source)?, overrides),
    }
}

/// Overrides of a caller.
pub fn placed(overrides: &[(String, OverrideValue)]) -> Vec<Override> {
    overrides.iter().map(Override::from_caller).collect()
}

/// As [`load`], for text in memory; `origin` is what errors call it.
///
/// # Errors
/// The first problem met, with its place and cure.
pub fn parse(text: &str, origin: &str, overrides: &[(String, OverrideValue)]) -> Result<Machine> {
    parse_with(text, origin, &placed(overrides))
}

/// As [`parse`], for overrides written in a file.
pub fn parse_with(text: &str, origin: &str, overrides: &[Override]) -> Result<Machine> {
    build(Cow::Owned(machine_tree(&in_memory(text, origin, &[]))?), overrides)
}

/// As [`load_with`], for a machine among the files `given`.
pub fn load_given(name: &str, given: &Given, overrides: &[Override]) -> Result<Machine> {
    build(Cow::Owned(machine_tree(&open_given(name, given)?)?), overrides)
}

/// The text of the machine `source`, a path, with the content of all files that it needs beside it.
///
/// # Errors
/// The first problem met.
pub fn whole_text(source: &str) -> Result<String> {
    in_one(&read(Path::new(source))?)
}

/// As [`whole_text`], for a machine among the files `given`.
pub fn whole_text_of(name: &str, given: &Given) -> Result<String> {
    in_one(&open_given(name, given)?)
}

/// Names of the tables and keys at the top of the file `path`; none if it cannot be read.
pub fn tables_of(path: &str) -> Vec<String> {
    let tree = read(Path::new(path)).and_then(|source| document::parse(&source.file));
    tree.map_or(Vec::new(), |tree| tree.entries().unwrap_or_default().iter().map(|entry| entry.key.clone()).collect())
}

/// A file that needs no other one stays as it is, so that errors in it keep their lines.
fn in_one(source: &Source) -> Result<String> {
    let tree = document::parse(&source.file)?;
    let extended = |node: &Node| match &node.kind {
        NodeKind::Value { value: Scalar::Text(name), .. } => is_path(name),
        _ => true,
    };
    if root_entry(&tree, "include").is_none() && !root_entry(&tree, "extends").is_some_and(extended) {
        return Ok(source.file.text.clone());
    }
    Template { tree: Cow::Owned(machine_tree(source)?), bundled: None }.to_toml(&[])
}

fn build(tree: Cow<Node>, overrides: &[Override]) -> Result<Machine> {
    sections::machine(&*overridden(tree, overrides)?, &[])
}

/// The tree of the machine `source`, a bundled name or a path.
fn named_tree(source: &str) -> Result<Cow<'static, Node>> {
    match bundled_tree(source) {
        Some(tree) => tree.map(Cow::Borrowed),
        None => machine_tree(&open(source, "machine", bundled_machines())?).map(Cow::Owned),
    }
}

/// A bundled machine, read and checked once, because it cannot change.
#[derive(Debug)]
struct Bundled {
    tree: Node,
    checked: OnceLock<Machine>,
}

impl Bundled {
    /// The machine as the file describes it.
    fn machine(&self) -> Result<&Machine> {
        match self.checked.get() {
            Some(machine) => Ok(machine),
            None => sections::machine(&self.tree, &[]).map(|machine| self.checked.get_or_init(|| machine)),
        }
    }
}

/// `None`: no such name.
fn bundled(name: &str) -> Option<Result<&'static Bundled>> {
    static READ: LazyLock<Vec<OnceLock<Bundled>>> =
        LazyLock::new(|| bundled_machines().iter().map(|_| OnceLock::new()).collect());
    let index = bundled_machines().iter().position(|(known, _)| *known == name)?;
    Some(match READ[index].get() {
        Some(read) => Ok(read),
        None => open(name, "machine", bundled_machines())
            .and_then(|source| machine_tree(&source))
            .map(|tree| READ[index].get_or_init(|| Bundled { tree, checked: OnceLock::new() })),
    })
}

/// The tree of a bundled machine. `None`: no such name.
fn bundled_tree(name: &str) -> Option<Result<&'static Node>> {
    Some(bundled(name)?.map(|read| &read.tree))
}

/// The tree of a machine file with all extended and included files.
fn machine_tree(source: &Source) -> Result<Node> {
    let tree = extended(source, &mut Opened::default())?;
    match tree.entries().unwrap_or_default().iter().find(|entry| entry.key == "scenario") {
        Some(entry) => Err(entry
            .place
            .error(ErrorKind::WrongKindOfFile, "scenario", "this is a scenario, but a machine is expected")
            .help(FOR_A_SCENARIO)),
        None => Ok(tree),
    }
}

fn overridden<'a>(mut tree: Cow<'a, Node>, overrides: &[Override]) -> Result<Cow<'a, Node>> {
    for change in overrides {
        apply_override(tree.to_mut(), change)?;
    }
    Ok(tree)
}

/// A machine file that is read once and built many times, with other values each time.
#[derive(Clone)]
pub struct Template {
    tree: Cow<'static, Node>,
    /// Whether it is an unchanged bundled file.
    bundled: Option<&'static Bundled>,
}

impl Template {
    /// Reads `source` as [`load`] does; `overrides` stay in force.
    ///
    /// # Errors
    /// What is wrong with the files or the keys of the overrides; their values are checked when built.
    pub fn open(source: &str, overrides: &[(String, OverrideValue)]) -> Result<Self> {
        let tree = overridden(named_tree(source)?, &placed(overrides))?;
        let bundled = if overrides.is_empty() { bundled(source).transpose()? } else { None };
        Ok(Self { tree, bundled })
    }

    /// As [`Self::open`], for text in memory; `origin` is what errors call it.
    ///
    /// # Errors
    /// What is wrong with the text, its values excepted.
    pub fn of_text(text: &str, origin: &str) -> Result<Self> {
        Ok(Self { tree: Cow::Owned(machine_tree(&in_memory(text, origin, &[]))?), bundled: None })
    }

    /// What was read, as the text of a single file with the content of all extended and included files.
    pub fn text(&self) -> String {
        whole::text(&self.tree, &[])
    }

    /// The machine with `changes` as the text of a single file, with the content of all extended and included files.
    ///
    /// # Errors
    /// As [`load`].
    pub fn to_toml(&self, changes: &[(String, OverrideValue)]) -> Result<String> {
        let tree = overridden(Cow::Borrowed(&self.tree), &placed(changes))?;
        let machine: Machine = sections::machine(&tree, &[])?;
        let tree = overridden(tree, &placed(&rated_speeds(&machine)))?;
        Ok(whole::text(&tree, &machine.provenance))
    }

    /// The machine with `changes`.
    ///
    /// # Errors
    /// As [`load`].
    pub fn build(&self, changes: &[(String, OverrideValue)]) -> Result<Machine> {
        match self.bundled {
            Some(bundled) if changes.is_empty() => bundled.machine().cloned(),
            _ => build(Cow::Borrowed(&self.tree), &placed(changes)),
        }
    }

    /// As [`Self::build`], with the derivatives of all numbers by `variables`, the first of them by the first of these.
    ///
    /// # Errors
    /// As [`load`].
    ///
    /// # Panics
    /// If numbers of type `T` have fewer derivatives than there are variables.
    pub fn build_with<T: Number>(
        &self,
        changes: &[(String, OverrideValue)],
        variables: &[Variable],
    ) -> Result<Machine<T>> {
        sections::machine(&*overridden(Cow::Borrowed(&self.tree), &placed(changes))?, variables)
    }
}

/// The rated speeds of pumps that follow from a speed which was overridden since.
fn rated_speeds(machine: &Machine) -> Vec<(String, OverrideValue)> {
    let pumps = machine.supply.mains.iter().flat_map(|mains| mains.pumps());
    let changed = pumps.filter(|pump| pump.rated_speed != pump.speed);
    let keys = changed.map(|pump| (format!("pump.{}.rated-speed", pump.name), pump.rated_speed));
    let followed = keys.filter(|(key, _)| machine.provenance.iter().all(|stated| stated.key != *key));
    followed.map(|(key, speed)| (key, OverrideValue::Text(format!("{speed} rad/s")))).collect()
}

/// The files that are read for one machine.
#[derive(Default)]
struct Opened {
    /// Those that extend each other, to detect a cycle.
    chain: Vec<String>,
    budget: Budget,
}

/// The tree of a file merged onto the file it extends, with the included files merged onto both.
fn extended(source: &Source, opened: &mut Opened) -> Result<Node> {
    let tree = opened.budget.parse(&source.file)?;
    let parts = included(source, &tree, &mut opened.budget)?;
    let whole = match root_entry(&tree, "extends") {
        Some(node) => merge(reduced(extended_base(source, node, opened)?, &tree)?, tree),
        None => match root_entry(&tree, WITHOUT) {
            Some(node) => {
                let message = "there is no file to take keys from";
                return Err(node
                    .place
                    .error(ErrorKind::ConflictingKeys, WITHOUT, message)
                    .help("name it by `extends`"));
            }
            None => tree,
        },
    };
    Ok(parts.into_iter().fold(whole, merge))
}

fn root_entry<'a>(tree: &'a Node, key: &str) -> Option<&'a Node> {
    tree.entries().unwrap_or_default().iter().find(|entry| entry.key == key).map(|entry| &entry.node)
}

fn extended_base(source: &Source, node: &Node, opened: &mut Opened) -> Result<Node> {
    let place = &node.place;
    let NodeKind::Value { value: Scalar::Text(name), .. } = &node.kind else {
        let found = format!("expected the name of a machine, found {}", node.kind_name());
        return Err(place.error(ErrorKind::WrongType, "extends", found).help("put the name in quotes"));
    };
    // A bundled machine extends only bundled files.
    if let Some(tree) = bundled_tree(name) {
        return tree.cloned();
    }
    if opened.chain.len() >= MOST_EXTENDED {
        let message = format!("more than {MOST_EXTENDED} files extend each other");
        return Err(place
            .error(ErrorKind::TooLarge, "extends", message)
            .help("extend a file that does not lead back to this one"));
    }
    opened.chain.push(identity(source));
    let base = open_extended(source, name).map_err(|error| relocate(&error, place, "extends"))?;
    if opened.chain.contains(&identity(&base)) {
        let message = format!("`{name}` is this file, or leads back to it");
        return Err(place
            .error(ErrorKind::ExtendsCycle, "extends", message)
            .help("extend a file that does not lead back to this one"));
    }
    extended(&base, opened)
}

/// The tree of an extended file but for what the file that extends it does `without`.
fn reduced(mut base: Node, tree: &Node) -> Result<Node> {
    for (key, place) in texts(tree, WITHOUT, "keys", "[\"valve.lift.overlap\"]")? {
        take_out(&mut base, key, place)?;
    }
    Ok(base)
}

/// The trees of the files that a file includes, in its order.
fn included(source: &Source, tree: &Node, budget: &mut Budget) -> Result<Vec<Node>> {
    let names = texts(tree, "include", "files", "[\"friction.toml\"]")?;
    if let Some(node) = root_entry(tree, "include").filter(|_| names.len() > MOST_INCLUDED) {
        let message = format!("{} files; at most {MOST_INCLUDED} are included", names.len());
        return Err(node.place.error(ErrorKind::TooLarge, "include", message).help("join some of them"));
    }
    names.iter().map(|(name, place)| part_of(source, name, place, budget)).collect()
}

/// The texts in the list of a `key` at the top of a file, with their places; none without that key.
fn texts<'a>(tree: &'a Node, key: &str, what: &str, example: &str) -> Result<Vec<(&'a str, &'a Place)>> {
    let Some(node) = root_entry(tree, key) else { return Ok(Vec::new()) };
    let wrong = |place: &Place, found: &str| {
        let message = format!("expected a list of {what}, found {found}");
        place.error(ErrorKind::WrongType, key, message).help(format!("write it like {example}"))
    };
    let NodeKind::Value { value: Scalar::List(items), .. } = &node.kind else {
        return Err(wrong(&node.place, node.kind_name()));
    };
    let text = |(item, place): &'a (Scalar, Place)| match item {
        Scalar::Text(text) => Ok((text.as_str(), place)),
        _ => Err(wrong(place, "something else in it")),
    };
    items.iter().map(text).collect()
}

/// The tree of one included file: tables of an incomplete machine.
fn part_of(source: &Source, name: &str, place: &Place, budget: &mut Budget) -> Result<Node> {
    let file = beside(source, name).map_err(|error| relocate(&error, place, "include"))?;
    let tree = budget.parse(&file.file)?;
    for key in ["extends", "include", WITHOUT] {
        if let Some(node) = root_entry(&tree, key) {
            let message = format!("an included file cannot have `{key}` of its own");
            let cure = format!("move `{key}` to `{}`", source.file.name);
            return Err(node.place.error(ErrorKind::ConflictingKeys, key, message).help(cure));
        }
    }
    Ok(tree)
}

fn open_extended(source: &Source, name: &str) -> Result<Source> {
    if is_path(name) {
        return beside(source, name);
    }
    open(name, "machine", bundled_machines())
}

/// The file that `source` names.
fn beside(source: &Source, name: &str) -> Result<Source> {
    match &source.folder {
        Some(folder) => {
            check_path(name)?;
            read(&folder.join(name))
        }
        None => open_given(name, &source.given),
    }
}

/// An error if a file may not name this path.
pub fn check_path(name: &str) -> Result<()> {
    match disk::path_fault(name) {
        None => Ok(()),
        Some((fault, cure)) => {
            Err(MachineError::new(ErrorKind::UnreadableFile, Location::Source(name.into()), fault).help(cure))
        }
    }
}

/// A file among those `given`.
pub fn open_given(name: &str, files: &Given) -> Result<Source> {
    if let Some((own, text)) = given(files, name) {
        return Ok(in_memory(text, own, files));
    }
    let names: Vec<&str> = files.iter().map(|(own, _)| own.as_str()).collect();
    let there = if names.is_empty() { "nothing".into() } else { listed(&names) };
    let message = format!("is not among the files at hand: there is {there}");
    Err(MachineError::new(ErrorKind::UnreadableFile, Location::Source(name.into()), message)
        .help(format!("choose `{}` together with the file that names it", file_name(name))))
}

/// The file `given` that has this name, whatever folder it is in.
pub fn given<'a>(files: &'a Given, name: &str) -> Option<&'a (String, String)> {
    files.iter().find(|(own, _)| file_name(own) == file_name(name))
}

fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// The same problem, reported where the name was written.
pub fn relocate(error: &MachineError, place: &Place, key: &str) -> MachineError {
    let file = error.file().map_or(String::new(), |file| format!("`{file}` "));
    let message = match error.kind() {
        ErrorKind::UnreadableFile => format!("{file}{}", error.message()),
        _ => error.message().into(),
    };
    let moved = place.error(error.kind(), key, message);
    match error.cure() {
        Some(cure) => moved.help(cure),
        None => moved,
    }
}

/// Identity of a file, independent of the notation of its path.
fn identity(source: &Source) -> String {
    let name = &source.file.name;
    match (&source.folder, Path::new(name).canonicalize()) {
        (Some(_), Ok(path)) => path.to_string_lossy().into_owned(),
        _ => name.clone(),
    }
}

/// The names, or the first of many.
fn listed(names: &[&str]) -> String {
    if names.len() <= MOST_LISTED {
        return names.join(", ");
    }
    let rest = names.len() - MOST_LISTED;
    format!("{} and {rest} more, which `hydrocrane machines` lists", names[..MOST_LISTED].join(", "))
}

/// Cure for a machine in place of a scenario, and vice versa.
pub const FOR_A_MACHINE: &str =
    "give a scenario that names it: `hydrocrane new` writes one; `hydrocrane live` drives the machine as it is";
const FOR_A_SCENARIO: &str = "give the machine that it names, or `hydrocrane simulate` the scenario";
/// Key of the list of keys that a file does not take from the one that it extends.
const WITHOUT: &str = "without";
/// Most files in a chain of extensions.
const MOST_EXTENDED: usize = 16;
/// Most files that one file includes.
const MOST_INCLUDED: usize = 64;
/// Most names in one message.
const MOST_LISTED: usize = 8;

/// A name with a separator or a suffix is a path; a plain word is a bundled name.
pub fn is_path(source: &str) -> bool {
    source.contains(['/', '\\']) || source.to_ascii_lowercase().ends_with(".toml")
}

/// Opens a bundled file or one on disk; `what` names the kind of file in messages.
pub fn open(source: &str, what: &str, bundled: &[(&'static str, &'static str)]) -> Result<Source> {
    if is_path(source) {
        return read(Path::new(source));
    }
    match bundled.iter().find(|(name, _)| *name == source) {
        Some((name, text)) => {
            let file = SourceFile { name: format!("{name}.toml"), text: (*text).into() };
            Ok(Source { file: Arc::new(file), folder: None, given: Arc::new([]) })
        }
        None => {
            let all = [("machine", bundled_machines()), ("scenario", bundled_scenarios())];
            let other = all.iter().find(|(kind, files)| *kind != what && files.iter().any(|(name, _)| *name == source));
            if let Some((kind, _)) = other {
                let message = format!("`{source}` is a bundled {kind}, but a {what} is expected");
                let error = MachineError::new(ErrorKind::WrongKindOfFile, Location::Source(source.into()), message);
                return Err(error.help(if *kind == "machine" { FOR_A_MACHINE } else { FOR_A_SCENARIO }));
            }
            let names: Vec<&str> = bundled.iter().map(|(name, _)| *name).collect();
            let nearest = suggestion(source, names.iter().copied());
            let message = format!("there is no bundled {what} `{source}`; bundled: {}", listed(&names));
            let hint = if nearest.starts_with("did") { format!("{nearest} A") } else { "a".into() };
            Err(MachineError::new(ErrorKind::UnknownSource, Location::Source(source.into()), message)
                .help(format!("{hint} file of your own is given by its path, ending in .toml")))
        }
    }
}

fn read(path: &Path) -> Result<Source> {
    let name = path.display().to_string();
    let bytes = disk::read(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::FileTooLarge => {
            document::too_long(&Arc::new(SourceFile { name: name.clone(), text: String::new() }), "the text is")
        }
        _ => MachineError::new(
            ErrorKind::UnreadableFile,
            Location::Source(name.clone()),
            format!("cannot be read: {error}"),
        )
        .help("check the path"),
    })?;
    let text = decode(&name, bytes)?;
    let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    Ok(Source { file: Arc::new(SourceFile { name, text }), folder: Some(folder), given: Arc::new([]) })
}

fn decode(name: &str, bytes: Vec<u8>) -> Result<String> {
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
        let place = Place::File { file: Arc::new(SourceFile { name: name.into(), text }), span: valid..valid + 1 };
        MachineError::new(ErrorKind::NotText, place.locate(), "this is not UTF-8 text")
            .help("is it a machine or scenario file? Save it as UTF-8")
    })
}
