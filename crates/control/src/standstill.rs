//! Notices a tip that stands though the stick is out, and why.             theory: docs/theory/control/tip.md
//!
//! The set-point may slow down, not turn, so that a straight path can end where the tip could well go on another way. Whoever
//! holds the stick is told once, and again only after the tip has moved.

use crate::controller::place_name;
use crate::safe_state::Names;

/// Why the set-point of the tip stands; joints and cylinders by index.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Cause {
    /// The supply pressure cannot move the load of these cylinders where the stick asks to go.
    Load(Vec<usize>),
    /// The tip is too far behind.
    Lag,
    /// A region to keep out of.
    Region,
    /// Further on the oil could not hold this joint.
    Holding(usize),
    /// Limits of these joints; none where several limits hold the tip together.
    Range(Vec<usize>),
}

/// What the tip was told to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim {
    /// To move as the stick says.
    Stick,
    /// To go to this place (x, z), m.
    Place([f64; 2]),
}

impl Cause {
    /// For whoever told the tip to move.
    pub fn text(&self, names: &Names, aim: Aim) -> String {
        let (why, cure) = self.told(names);
        match aim {
            Aim::Stick => {
                let cure = if cure.is_empty() { String::new() } else { format!("; {cure}") };
                format!("the tip stands or hardly moves although the stick is deflected: {why}{cure}")
            }
            Aim::Place(place) => format!(
                "the tip stops before its goal {}: {why}; give a goal that a free straight line reaches, or steer there",
                place_name(place)
            ),
        }
    }

    /// Why, and what whoever holds the stick can do.
    fn told(&self, names: &Names) -> (String, &'static str) {
        match self {
            Cause::Load(cylinders) => {
                let (what, verb) = (listed("cylinder", &names.cylinders, cylinders), "cannot lift this here");
                (format!("{what} {verb}: the load is too heavy for the supply pressure"), ANOTHER_WAY)
            }
            Cause::Lag => {
                let why = "it does not follow its set-point; the load may be too heavy for the supply pressure";
                (why.to_string(), "")
            }
            Cause::Region => ("a keep-out region lies ahead".to_string(), "steer away from it"),
            Cause::Holding(joint) => {
                let whose = listed("joint", &names.joints, &[*joint]);
                let near = "comes so near its dead centre that closed valves could not hold it";
                (format!("on the straight line {whose} {near}"), ANOTHER_WAY)
            }
            Cause::Range(joints) => {
                let whose = if joints.is_empty() { String::new() } else { listed(": joint", &names.joints, joints) };
                (format!("the straight line leads out of the range of the joints{whose}"), ANOTHER_WAY)
            }
        }
    }
}

const ANOTHER_WAY: &str = "steer another way";

/// Says that joint `i` runs away though its valve is closed.
pub fn runaway(names: &Names, joint: usize) -> String {
    format!(
        "{} is so near its dead centre that closed valves cannot hold it: the load pushes it on; \
         start farther away from the dead centre, or with less load",
        listed("joint", &names.joints, &[joint])
    )
}

/// Says that cylinder `c` does not hold its place, though nothing measures its load.
pub fn yielding(names: &Names, c: usize) -> String {
    format!(
        "{} moves away from its rest position although its valve opens against it: its load may be too heavy for the \
         supply pressure; the valve stays closed until the tip is moved again; carry less, or state the load in `payload.mass`",
        listed("cylinder", &names.cylinders, &[c])
    )
}

/// Says that the tip sinks at rest because these cylinders cannot lift it.
pub fn sinks(names: &Names, cylinders: &[usize]) -> String {
    let what = listed("cylinder", &names.cylinders, cylinders);
    format!(
        "the tip stands and sinks slowly: {what} cannot hold it here, because the load is too heavy for the supply pressure; move it to \
         where it needs less force, or set it down"
    )
}

/// `what` and the names, with an s where there are several.
fn listed(what: &str, names: &[String], which: &[usize]) -> String {
    let quoted: Vec<String> = which.iter().filter_map(|&i| names.get(i)).map(|name| format!("`{name}`")).collect();
    format!("{what}{} {}", if quoted.len() > 1 { "s" } else { "" }, quoted.join(" and "))
}

/// Share of the speed asked for below which the tip counts as standing.
const STANDING: f64 = 0.1;
/// Time for which it stands before anybody is told, s.
const PATIENCE: f64 = 0.9;

/// Since when the tip has stood under a deflected stick.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Standstill {
    /// s
    lasted: f64,
}

impl Standstill {
    /// Takes in the speed asked for and that of the set-point (m/s) over one `period` (s); whether to tell now.
    pub fn watch(&mut self, asked: f64, given: f64, period: f64) -> bool {
        if given >= STANDING * asked {
            self.lasted = 0.0;
            return false;
        }
        let before = self.lasted;
        self.lasted += period;
        before < PATIENCE && self.lasted >= PATIENCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tells_once_and_again_only_after_the_tip_has_moved() {
        let mut still = Standstill::default();
        let mut told =
            |asked: f64, given: f64, samples: usize| (0..samples).filter(|_| still.watch(asked, given, 0.25)).count();
        assert_eq!(told(0.2, 0.0, 3), 0, "too early");
        assert_eq!(told(0.2, 0.0, 50), 1);
        assert_eq!(told(0.2, 0.1, 1) + told(0.2, 0.005, 3), 0);
        assert_eq!(told(0.2, 0.005, 1), 1);
        // Nobody asks for anything.
        assert_eq!(told(0.0, 0.0, 50), 0);
    }

    #[test]
    fn cylinders_and_joints_are_named() {
        let named = |names: [&str; 2]| names.map(str::to_string).to_vec();
        let names =
            Names { joints: named(["boom", "jib"]), revolute: vec![true; 2], cylinders: named(["lift", "tilt"]) };
        let text = |cause: Cause| cause.text(&names, Aim::Stick);
        assert!(text(Cause::Load(vec![0])).contains("cylinder `lift` cannot lift this here"));
        assert!(text(Cause::Load(vec![0, 1])).contains("cylinders `lift` and `tilt` cannot"));
        assert!(text(Cause::Range(vec![1])).contains("range of the joints: joint `jib`;"));
        assert!(text(Cause::Range(vec![])).contains("range of the joints;"));
        assert!(sinks(&names, &[0]).contains("sinks slowly: cylinder `lift` cannot hold it here"));
        let told = Cause::Region.text(&names, Aim::Place([1.0, -0.5]));
        assert!(told.starts_with("the tip stops before its goal (1.000, -0.500) m: a keep-out region lies ahead; give"));
    }
}
