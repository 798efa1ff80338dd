//! What whoever runs a machine should know, as plain values; the words are made where there is a heap.

use crate::estimate::model_error::Likely;
#[cfg(feature = "std")]
use crate::interface::controller::Alarm;
use crate::interface::controller::PlaceName;
use arrayvec::ArrayVec;

/// What the messages call things.
#[cfg(feature = "std")]
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Names {
    pub joints: Vec<String>,
    /// Whether a joint turns.
    pub revolute: Vec<bool>,
    pub cylinders: Vec<String>,
}

/// Joints or cylinders by index.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Indices(u32);

impl Indices {
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    pub fn iter(self) -> impl Iterator<Item = usize> {
        (0..u32::BITS as usize).filter(move |i| self.0 >> i & 1 == 1)
    }
}

impl FromIterator<usize> for Indices {
    fn from_iter<I: IntoIterator<Item = usize>>(indices: I) -> Self {
        Indices(indices.into_iter().fold(0, |set, i| set | 1 << i))
    }
}

/// Why the set-point of the tip stands; joints and cylinders by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The supply pressure cannot move the load of these cylinders where the stick asks to go.
    Load(Indices),
    /// The tip is too far behind.
    Lag,
    /// A region to keep out of.
    Region,
    /// Further on the oil could not hold this joint.
    Holding(usize),
    /// Limits of these joints; none where several limits hold the tip together.
    Range(Indices),
}

/// What the tip shall do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim {
    /// To move as the stick says.
    Stick,
    /// To go to this place (x, z), m.
    Place([f64; 2]),
}

#[cfg(feature = "std")]
impl Cause {
    /// For whoever moves the tip.
    pub fn text(&self, names: &Names, aim: Aim) -> String {
        let (why, cure) = self.explained(names);
        match aim {
            Aim::Stick => {
                let cure = if cure.is_empty() { String::new() } else { format!("; {cure}") };
                format!("the tip stands or hardly moves although the stick is deflected: {why}{cure}")
            }
            Aim::Place(place) => format!(
                "the tip stops before its goal {}: {why}; give a goal that a free straight line reaches, or steer there",
                PlaceName(place)
            ),
        }
    }

    /// Why, and what whoever holds the stick can do.
    fn explained(&self, names: &Names) -> (String, &'static str) {
        match self {
            Cause::Load(cylinders) => {
                let (what, verb) = (listed("cylinder", &names.cylinders, *cylinders), "cannot lift this here");
                (format!("{what} {verb}: the load is too heavy for the supply pressure"), ANOTHER_WAY)
            }
            Cause::Lag => {
                let why = "it does not follow its set-point; the load may be too heavy for the supply pressure";
                (why.to_string(), "")
            }
            Cause::Region => ("a keep-out region lies ahead".to_string(), "steer away from it"),
            Cause::Holding(joint) => {
                let whose = listed("joint", &names.joints, [*joint].into_iter().collect());
                let near = "comes so near its dead centre that closed valves could not hold it";
                (format!("on the straight line {whose} {near}"), ANOTHER_WAY)
            }
            Cause::Range(joints) => {
                let whose = if joints.is_empty() { String::new() } else { listed(": joint", &names.joints, *joints) };
                (format!("the straight line leads out of the range of the joints{whose}"), ANOTHER_WAY)
            }
        }
    }
}

#[cfg(feature = "std")]
const ANOTHER_WAY: &str = "steer another way";

/// Something that `tip` tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Notice {
    /// The tip stands though it shall move.
    Stands(Cause, Aim),
    /// A goal is given up, cancelled or for the stick.
    GivenUp {
        place: PlaceName,
        cancelled: bool,
    },
    Arrived(PlaceName),
    /// The tip sinks at rest because these cylinders cannot lift it.
    Sinks(Indices),
    /// This joint runs away though its valve is closed.
    RunsAway(usize),
    /// This cylinder does not hold its place, though nothing measures its load.
    Yields(usize),
    /// The crane swings on by itself: gains of the damping are halved.
    Oscillates,
    /// The tip was off its path by this (m), most of it by this cylinder.
    Strays(f64, usize, Likely),
}

/// Notices that are kept until somebody asks for them; whatever happens in one sample has room.
#[derive(Debug, Clone, PartialEq)]
pub struct News<T = Notice, const MOST: usize = 16>(ArrayVec<T, MOST>);

impl<T, const MOST: usize> Default for News<T, MOST> {
    fn default() -> Self {
        News(ArrayVec::new())
    }
}

impl<T, const MOST: usize> News<T, MOST> {
    /// Keeps a notice; the oldest one goes where nobody has asked for any.
    pub fn tell(&mut self, notice: T) {
        if self.0.is_full() {
            self.0.remove(0);
        }
        self.0.push(notice);
    }

    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.0.iter()
    }
}

impl Notice {
    #[cfg(feature = "std")]
    pub fn text(&self, names: &Names) -> String {
        match self {
            Notice::Stands(cause, aim) => cause.text(names, *aim),
            Notice::GivenUp { place, cancelled } => {
                let why = if *cancelled { "the goal is cancelled" } else { "the stick takes over" };
                format!("{why}: the tip no longer goes to {place}")
            }
            Notice::Arrived(place) => format!("the tip has reached its goal {place}"),
            Notice::Sinks(cylinders) => sinks(names, *cylinders),
            Notice::RunsAway(joint) => runaway(names, *joint),
            Notice::Yields(cylinder) => yielding(names, *cylinder),
            Notice::Oscillates => "the crane swings on although the valves damp it, so they may act later than the \
                                   machine file says: the gain of the damping is halved"
                .to_string(),
            Notice::Strays(off, cylinder, likely) => strays(names, *off, *cylinder, *likely),
        }
    }

    /// What the run is warned of.
    #[cfg(feature = "std")]
    pub fn alarm(&self) -> Option<Alarm> {
        match self {
            Notice::Oscillates => Some(Alarm::Oscillates),
            Notice::Strays(..) => Some(Alarm::Strays),
            _ => None,
        }
    }
}

#[cfg(feature = "std")]
fn runaway(names: &Names, joint: usize) -> String {
    format!(
        "{} is so near its dead centre that closed valves cannot hold it: the load pushes it on; \
         start farther away from the dead centre, or with less load",
        listed("joint", &names.joints, [joint].into_iter().collect())
    )
}

#[cfg(feature = "std")]
fn yielding(names: &Names, c: usize) -> String {
    format!(
        "{} moves away from its rest position although its valve opens against it: its load may be too heavy for the \
         supply pressure; the valve stays closed until the tip is moved again; carry less, or state the load in `payload.mass`",
        listed("cylinder", &names.cylinders, [c].into_iter().collect())
    )
}

#[cfg(feature = "std")]
fn sinks(names: &Names, cylinders: Indices) -> String {
    let what = listed("cylinder", &names.cylinders, cylinders);
    format!(
        "the tip stands and sinks slowly: {what} cannot hold it here, because the load is too heavy for the supply pressure; move it to \
         where it needs less force, or set it down"
    )
}

#[cfg(feature = "std")]
fn strays(names: &Names, off: f64, cylinder: usize, likely: Likely) -> String {
    let why = match likely {
        Likely::Flow(times) => format!("its valve gives some {times:.2} times the flow of the machine file"),
        Likely::Late(time) => format!("its valve answers some {:.0} ms later than in the machine file", 1e3 * time),
        Likely::Soft(times) => format!("its oil gives way some {times:.1} times as far as in the machine file"),
        Likely::Force => {
            "it needs another force than the machine file tells: another load, friction or mass".to_string()
        }
        Likely::Unknown => "no single error of flow, delay, oil or load explains it".to_string(),
    };
    let whose = listed("cylinder", &names.cylinders, [cylinder].into_iter().collect());
    format!("the tip was {:.0} mm off its path, most of it by {whose}: {why}", 1e3 * off)
}

/// `what` and the names, with an s where there are several.
#[cfg(feature = "std")]
fn listed(what: &str, names: &[String], which: Indices) -> String {
    let quoted: Vec<String> = which.iter().filter_map(|i| names.get(i)).map(|name| format!("`{name}`")).collect();
    format!("{what}{} {}", if quoted.len() > 1 { "s" } else { "" }, quoted.join(" and "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_of_too_many_notices_goes() {
        let mut news: News = News::default();
        (0..20).for_each(|joint| news.tell(Notice::RunsAway(joint)));
        assert!(news.iter().eq((4..20).map(Notice::RunsAway).collect::<Vec<_>>().iter()));
    }

    #[test]
    fn cylinders_and_joints_are_named() {
        let named = |names: [&str; 2]| names.map(str::to_string).to_vec();
        let names =
            Names { joints: named(["boom", "jib"]), revolute: vec![true; 2], cylinders: named(["lift", "tilt"]) };
        let of = |indices: &[usize]| indices.iter().copied().collect::<Indices>();
        let text = |cause: Cause| Notice::Stands(cause, Aim::Stick).text(&names);
        assert!(text(Cause::Load(of(&[0]))).contains("cylinder `lift` cannot lift this here"));
        assert!(text(Cause::Load(of(&[0, 1]))).contains("cylinders `lift` and `tilt` cannot"));
        assert!(text(Cause::Range(of(&[1]))).contains("range of the joints: joint `jib`;"));
        assert!(text(Cause::Range(of(&[]))).contains("range of the joints;"));
        let late = Notice::Strays(0.0105, 1, Likely::Late(0.0321)).text(&names);
        assert!(late.contains("10 mm off") && late.contains("`tilt`: its valve answers some 32 ms later"), "{late}");
        assert!(Notice::Sinks(of(&[0])).text(&names).contains("sinks slowly: cylinder `lift` cannot hold it here"));
        let explained = Notice::Stands(Cause::Region, Aim::Place([1.0, -0.5])).text(&names);
        assert!(explained
            .starts_with("the tip stops before its goal (1.000, -0.500) m: a keep-out region lies ahead; give"));
    }
}
