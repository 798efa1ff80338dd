//! Joint limits: the nearest of the file's own, stroke end, rod contact and dead centre.

use crate::errors::BuildError;
use hydrocrane_machine::model as file;
use hydrocrane_num::{bisect, Archive, Stored};
use hydrocrane_physics::geometry::frames::Joint;
use hydrocrane_physics::geometry::stroke::Actuation;
use std::cell::RefCell;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Cause of a joint limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitReason {
    StrokeEnd,
    RodContact,
    DeadCentre,
    /// Given in the machine file.
    File,
}

impl LimitReason {
    pub fn name(self) -> &'static str {
        match self {
            LimitReason::StrokeEnd => "stroke end",
            LimitReason::RodContact => "rod contact",
            LimitReason::DeadCentre => "dead centre",
            LimitReason::File => "machine file",
        }
    }
}

/// Limits of one joint coordinate and of the stroke on the branch between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimits {
    /// rad or m
    pub lower: f64,
    pub upper: f64,
    pub reasons: [LimitReason; 2],
}

/// Scan step of a revolute joint, rad, and of a prismatic one as a share of the stroke.
const SCAN: f64 = 0.25 * PI / 180.0;
const SHARE: f64 = 1.0 / 1000.0;
/// Scan steps to either side after which a linkage counts as impossible; lengths of one machine differ by less.
const MOST_STEPS: f64 = 2e5;

/// Most joints whose limits a thread remembers: those of the longest chain, twice.
const MOST_KNOWN: usize = 12;

thread_local! {
    /// Limits found before. The machines of a study differ seldom in their geometry, and a search takes a tenth of the
    /// time that a machine is built in.
    static KNOWN: RefCell<Vec<(Vec<u8>, JointLimits)>> = const { RefCell::new(Vec::new()) };
}

/// One joint with its cylinder.
pub struct JointActuation<'a> {
    pub joint: &'a Joint<f64>,
    pub actuation: &'a Actuation<f64>,
    pub description: &'a file::Joint,
    pub cylinder: &'a file::Cylinder,
}

/// An error of stated limits, to be made of joint, cylinder and cure.
type Fault = fn(String, String, String) -> BuildError;

impl JointActuation<'_> {
    /// Piston position and lever arm, `None` where the linkage does not close.
    fn stroke(&self, q: f64) -> Option<(f64, f64)> {
        let pose = self.joint.pose(q);
        let closes = self.actuation.closure(&pose) > 0.0;
        let (x, lever_arm) = self.actuation.stroke(&pose);
        (closes && x.is_finite() && lever_arm.is_finite()).then_some((x, lever_arm))
    }

    fn stroke_limits(&self) -> (f64, f64, LimitReason) {
        let half = self.cylinder.stroke / 2.0;
        match self.cylinder.rod_contact {
            Some(contact) if contact > -half => (contact, half, LimitReason::RodContact),
            _ => (-half, half, LimitReason::StrokeEnd),
        }
    }

    pub fn limits(&self) -> Result<JointLimits, BuildError> {
        if let Some(range) = self.description.limits {
            let (joint, cylinder) = (&self.description.name, &self.cylinder.name);
            return self.stated(range).map_err(|fault| fault(joint.clone(), cylinder.clone(), self.cure(range)));
        }
        let geometry = self.geometry();
        let found = KNOWN.with_borrow(|known| known.iter().find(|(of, _)| *of == geometry).map(|(_, limits)| *limits));
        if let Some(limits) = found {
            return Ok(limits);
        }
        let start = self.start()?;
        let (lower, lower_reason) = self.walk(start, -1.0);
        let (upper, upper_reason) = self.walk(start, 1.0);
        let limits = JointLimits { lower, upper, reasons: [lower_reason, upper_reason] };
        KNOWN.with_borrow_mut(|known| {
            known.truncate(MOST_KNOWN - 1);
            known.insert(0, (geometry, limits));
        });
        Ok(limits)
    }

    fn stated(&self, [lower, upper]: [f64; 2]) -> Result<JointLimits, Fault> {
        self.within_stroke(self.require_one_branch(JointLimits { lower, upper, reasons: [LimitReason::File; 2] })?)
    }

    /// The cure of limits that do not fit: the unit in which their numbers would.
    fn cure(&self, range: [f64; 2]) -> String {
        let fits = |scale: f64| self.joint.revolute && self.stated(range.map(|limit| scale * limit)).is_ok();
        match [("deg", PI / 180.0), ("rad", 180.0 / PI)].into_iter().find(|(_, scale)| fits(*scale)) {
            Some((unit, _)) => format!("write them in {unit}, in which these numbers fit"),
            None if self.joint.revolute && range.iter().any(|limit| limit.abs() > TAU) => {
                "they are more than a turn: write degrees as deg".into()
            }
            None => "change them, or check the pins and the lengths of the cylinder, with their units".into(),
        }
    }

    /// Everything that limits which are searched for depend on, as bytes.
    fn geometry(&self) -> Vec<u8> {
        let mut archive = Archive::writing();
        Joint::exchange(&mut archive, Some(self.joint));
        Actuation::exchange(&mut archive, Some(self.actuation));
        let (low, high, reason) = self.stroke_limits();
        let contact = f64::from(u8::from(reason == LimitReason::RodContact));
        let (start, (step, reach)) = (self.preferred(), self.scan());
        for mut number in [low, high, contact, start, step, reach, self.description.dead_centre_margin] {
            archive.number(&mut number);
        }
        archive.into_bytes()
    }

    /// The coordinate next to which the branch is searched for.
    fn preferred(&self) -> f64 {
        match self.description.kind {
            file::JointKind::Revolute(file::AngleConvention::Included) => FRAC_PI_2,
            _ => 0.0,
        }
    }

    /// A coordinate with the piston as near to mid-stroke as possible. A pin triangle has two mirror images; the one
    /// nearest to a right angle (included angles) or to zero (relative angles) is chosen.
    fn start(&self) -> Result<f64, BuildError> {
        let preferred = self.preferred();
        let (step, reach) = self.scan();
        let count = (reach / step).ceil().min(MOST_STEPS) as i64;
        let (low, high, _) = self.stroke_limits();
        let middle = 0.5 * (low + high);
        let mut best: Option<(f64, f64)> = None;
        for i in 0..=count {
            // Far from mid-stroke counts more than far from the preferred coordinate within one branch.
            let aside = 0.1 * i as f64 * step / reach;
            if best.is_some_and(|(least, _)| aside >= least) {
                break;
            }
            for q in [preferred - i as f64 * step, preferred + i as f64 * step] {
                let Some((x, lever_arm)) = self.stroke(q) else { continue };
                if x < low || x > high || lever_arm.abs() < 1e-9 {
                    continue;
                }
                let residual = (x - middle).abs() / (high - low) + aside;
                if best.is_none_or(|(least, _)| residual < least) {
                    best = Some((residual, q));
                }
            }
        }
        best.map(|(_, q)| q).ok_or_else(|| BuildError::NoStroke(self.cylinder.name.clone()))
    }

    fn scan(&self) -> (f64, f64) {
        if self.joint.revolute {
            (SCAN, PI)
        } else {
            let reach = 2.0 * (self.cylinder.stroke + self.cylinder.mid_length);
            (self.cylinder.stroke * SHARE, reach)
        }
    }

    /// Searches from `start` in one direction for the first limit.
    fn walk(&self, start: f64, direction: f64) -> (f64, LimitReason) {
        let (step, reach) = self.scan();
        let (low, high, low_reason) = self.stroke_limits();
        let sign = self.stroke(start).map_or(1.0, |(_, lever_arm)| lever_arm.signum());
        let blocked = |q: f64| match self.stroke(q) {
            None => Some(LimitReason::DeadCentre),
            Some((_, lever_arm)) if lever_arm * sign <= 0.0 => Some(LimitReason::DeadCentre),
            Some((x, _)) if x > high => Some(LimitReason::StrokeEnd),
            Some((x, _)) if x < low => Some(low_reason),
            Some(_) => None,
        };
        let mut inside = start;
        while (inside - start).abs() < 2.0 * reach {
            let next = inside + direction * step;
            if let Some(reason) = blocked(next) {
                let edge = bisect(inside, next, HALVINGS, |q| blocked(q).is_none());
                let reason = blocked(edge + direction * 1e-9).unwrap_or(reason);
                let margin = if reason == LimitReason::DeadCentre { self.description.dead_centre_margin } else { 0.0 };
                return (edge - direction * margin, reason);
            }
            inside = next;
        }
        (inside, LimitReason::StrokeEnd)
    }

    fn require_one_branch(&self, limits: JointLimits) -> Result<JointLimits, Fault> {
        const SAMPLES: usize = 400;
        let span = limits.upper - limits.lower;
        let mut lever_arms = (0..=SAMPLES).map(|i| self.stroke(limits.lower + span * i as f64 / SAMPLES as f64));
        let sign = lever_arms.next().flatten().map_or(0.0, |(_, lever_arm)| lever_arm.signum());
        let monotone = sign != 0.0 && lever_arms.all(|s| s.is_some_and(|(_, lever_arm)| lever_arm * sign > 0.0));
        if monotone {
            Ok(limits)
        } else {
            Err(BuildError::DeadCentreInside)
        }
    }

    /// The part of the file's range that the stroke allows.
    fn within_stroke(&self, file: JointLimits) -> Result<JointLimits, Fault> {
        let ([low, high], (least, most, low_reason)) = (self.stroke_range(&file), self.stroke_limits());
        if low >= most || high <= least {
            return Err(BuildError::LimitsBeyondStroke);
        }
        let mut limits = file;
        let rising = self.stroke(file.lower) < self.stroke(file.upper);
        for (beyond, end, x, reason) in
            [(low < least, !rising, least, low_reason), (high > most, rising, most, LimitReason::StrokeEnd)]
        {
            if beyond {
                let q = self.joint_from_stroke(&file, x);
                *(if end { &mut limits.upper } else { &mut limits.lower }) = q;
                limits.reasons[usize::from(end)] = reason;
            }
        }
        Ok(limits)
    }

    /// Strokes at the joint limits, in ascending order.
    pub fn stroke_range(&self, limits: &JointLimits) -> [f64; 2] {
        let ends = [limits.lower, limits.upper].map(|q| self.stroke(q).map_or(f64::NAN, |(x, _)| x));
        [ends[0].min(ends[1]), ends[0].max(ends[1])]
    }

    /// The joint coordinate with piston position `x`, inside the limits, by Newton's method in a shrinking bracket.
    pub fn joint_from_stroke(&self, limits: &JointLimits, x: f64) -> f64 {
        let (mut low, mut high) = (limits.lower, limits.upper);
        let at = |q: f64| self.actuation.stroke(&self.joint.pose(q));
        let rising = at(high).0 > at(low).0;
        let mut q = 0.5 * (low + high);
        for _ in 0..200 {
            let (value, lever_arm) = at(q);
            if (value > x) == rising {
                high = q;
            } else {
                low = q;
            }
            let newton = q - (value - x) / lever_arm;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - q).abs() <= 1e-15 * (1.0 + q.abs()) {
                return next.clamp(limits.lower, limits.upper);
            }
            q = next;
        }
        q
    }
}

/// Halvings that find a limit to the last digit.
const HALVINGS: usize = 80;

/// Rounding allowed at a joint limit, as a share of the joint's range.
const LIMIT_ROUNDING: f64 = 1e-6;

impl JointLimits {
    /// The limits with room for rounding.
    pub fn widened(&self) -> [f64; 2] {
        let room = LIMIT_ROUNDING * (self.upper - self.lower);
        [self.lower - room, self.upper + room]
    }

    /// Text: coordinate of `joint` and its limits, in degrees or metres.
    pub fn compared(&self, joint: &file::Joint, q: f64) -> String {
        let [low, high] = self.reasons.map(|reason| reason.name());
        let [lower, upper] = [self.lower, self.upper].map(|q| in_words(joint, q));
        format!("{}, outside its limits {lower} ({low}) and {upper} ({high})", in_words(joint, q))
    }
}

/// The first of the `joints` outside its limits in the pose `q`, as text, if any.
pub fn outside_limits(joints: &[file::Joint], limits: &[JointLimits], q: &[f64]) -> Option<(String, String)> {
    let outside = |(q, limits): (&f64, &JointLimits)| {
        let [lower, upper] = limits.widened();
        !(*q >= lower && *q <= upper)
    };
    let i = q.iter().zip(limits).position(outside)?;
    Some((joints[i].name.clone(), limits[i].compared(&joints[i], q[i])))
}

/// A joint coordinate with its unit.
pub fn in_words(joint: &file::Joint, q: f64) -> String {
    match joint.kind {
        file::JointKind::Revolute(_) => format!("{:.2} deg", q.to_degrees()),
        file::JointKind::Prismatic { .. } => format!("{q:.4} m"),
    }
}
