//! Regions that the tip stays out of.                        theory: docs/theory/control/reference.md
//!
//! v . n >= -k (d - margin)      at every edge of every region
//!
//! with the distance d to the edge and the direction n away from it; inside a region v . n >= 0 at its nearest edge. The
//! velocity is slowed down until it obeys, never turned. The distance to one edge, not to the whole outline, is convex in the
//! place of the tip: what is obeyed over one sample holds all along it, and the allowed speed does not jump where
//! another edge becomes the nearest.

use crate::reference::slow_down::allowed;
use hydrocrane_num::{portable, Archive, Stored, Vec2};

/// Most regions, and most corners of one, without a heap.
pub const MOST_REGIONS: usize = 4;
pub const MOST_CORNERS: usize = 16;

#[cfg(feature = "std")]
type List<T, const MOST: usize> = Vec<T>;
#[cfg(not(feature = "std"))]
type List<T, const MOST: usize> = arrayvec::ArrayVec<T, MOST>;

/// A polygon in the plane of the crane, convex or not, its corners in either sense, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    edges: List<Edge, MOST_CORNERS>,
    /// Least and greatest x and z of the corners, m.
    extent: [[f64; 2]; 2],
}

/// From one corner to the next, m.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Edge {
    from: [f64; 2],
    to: [f64; 2],
    /// Unit vectors along the edge and out of the region, and its length.
    along: [f64; 2],
    outward: [f64; 2],
    length: f64,
}

/// The way from a border to a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance {
    /// m, negative inside the region.
    pub distance: f64,
    /// Unit vector out of the region.
    pub normal: [f64; 2],
}

/// The regions of a crane and how the tip nears them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct KeepOut {
    pub regions: List<Region, MOST_REGIONS>,
    /// Distance that the set-point keeps, m: what the tip may differ from it.
    pub margin: f64,
    /// k, 1/s
    pub rate: f64,
}

/// What a moment asks for beyond that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Caution {
    /// Most of k, 1/s.
    pub rate: f64,
    /// How far the tip may be from where the sensors see it, m: added to the margin.
    pub uncertainty: f64,
}

impl Caution {
    pub const NONE: Caution = Caution { rate: f64::INFINITY, uncertainty: 0.0 };
}

/// How a border is neared: margin, m, and k, 1/s.
struct Approach {
    margin: f64,
    rate: f64,
}

/// Approach relative to the speed that counts as motion along a border.
const ALONG: f64 = 1e-9;
/// Distance that counts as on the border, m.
const TOUCHING: f64 = 1e-12;

hydrocrane_num::stored!([] Edge { from: [f64; 2], to: [f64; 2], along: [f64; 2], outward: [f64; 2], length: f64 });

impl Stored for Region {
    const LAYOUT: u64 = Edge::LAYOUT;

    fn exchange(archive: &mut Archive, own: Option<&Self>) -> Self {
        let edges = exchange_list::<_, MOST_CORNERS>(archive, own.map(|own| &own.edges));
        Region { edges, extent: <_>::exchange(archive, own.map(|own| &own.extent)) }
    }
}

impl Stored for KeepOut {
    const LAYOUT: u64 = Region::LAYOUT;

    fn exchange(archive: &mut Archive, own: Option<&Self>) -> Self {
        KeepOut {
            regions: exchange_list::<_, MOST_REGIONS>(archive, own.map(|own| &own.regions)),
            margin: f64::exchange(archive, own.map(|own| &own.margin)),
            rate: f64::exchange(archive, own.map(|own| &own.rate)),
        }
    }
}

/// A list with its length, which a controller without a heap must have room for.
fn exchange_list<T: Stored, const MOST: usize>(archive: &mut Archive, own: Option<&List<T, MOST>>) -> List<T, MOST> {
    let count = usize::exchange(archive, own.map(|own| own.len()).as_ref());
    if count > MOST {
        archive.spoil();
        return List::default();
    }
    (0..count).map(|i| T::exchange(archive, own.map(|own| &own[i]))).collect()
}

impl Region {
    /// Three corners or more, not in one line.
    #[cfg(feature = "std")]
    pub fn new(corners: Vec<[f64; 2]>) -> Self {
        let pairs = || corners.iter().copied().zip(corners.iter().copied().cycle().skip(1));
        let twice_the_area: f64 = pairs().map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
        // Counter-clockwise, x to the right and z up, the region lies to the left of its edges.
        let sense = if twice_the_area < 0.0 { -1.0 } else { 1.0 };
        let along = |axis: usize| {
            corners.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], corner| {
                [low.min(corner[axis]), high.max(corner[axis])]
            })
        };
        let extent = [along(0), along(1)];
        Region { edges: pairs().map(|(from, to)| Edge::new(from, to, sense)).collect(), extent }
    }

    /// Whether the region is surely farther away than `reach` (m).
    fn beyond(&self, place: [f64; 2], reach: f64) -> bool {
        (0..2).any(|i| place[i] < self.extent[i][0] - reach || place[i] > self.extent[i][1] + reach)
    }

    /// By the number of edges that a ray from the place crosses.
    pub fn contains(&self, [x, z]: [f64; 2]) -> bool {
        let crossed = |Edge { from: a, to: b, .. }: &&Edge| {
            (a[1] > z) != (b[1] > z) && x < a[0] + (z - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        };
        self.edges.iter().filter(crossed).count() % 2 == 1
    }

    /// Signed distance to the nearest point of the border, and the way out there.
    pub fn clearance(&self, place: [f64; 2]) -> Clearance {
        let clearances = self.clearances(place);
        let nearest = clearances.min_by(|a, b| a.distance.total_cmp(&b.distance));
        let away = nearest.unwrap_or(Clearance { distance: f64::INFINITY, normal: [0.0; 2] });
        if self.contains(place) && away.distance > TOUCHING {
            return Clearance { distance: -away.distance, normal: away.normal.map(|n| -n) };
        }
        away
    }

    /// The way from each edge, its distance without a sign.
    fn clearances(&self, place: [f64; 2]) -> impl Iterator<Item = Clearance> + '_ {
        self.edges.iter().map(move |edge| edge.clearance(place))
    }

    /// What must not be neared further: every edge from outside, the nearest one from inside.
    fn slowest(&self, keep: &Approach, place: [f64; 2], velocity: [f64; 2]) -> f64 {
        // So far away the law allows any direction.
        if self.beyond(place, keep.margin + Vec2::<f64>::c(velocity).norm() / keep.rate) {
            return 1.0;
        }
        if self.contains(place) {
            return keep.share(&self.clearance(place), velocity);
        }
        self.clearances(place).map(|clearance| keep.share(&clearance, velocity)).fold(1.0, f64::min)
    }
}

impl KeepOut {
    /// `velocity` slowed down so that the regions are not neared too fast from `place`.
    pub fn slowed(&self, place: [f64; 2], velocity: [f64; 2], caution: &Caution) -> [f64; 2] {
        let approach = Approach { margin: self.margin + caution.uncertainty, rate: self.rate.min(caution.rate) };
        let share = self.regions.iter().map(|r| r.slowest(&approach, place, velocity)).fold(1.0, f64::min);
        velocity.map(|v| share * v)
    }

    /// Distance to the nearest region, m, negative inside; infinite without regions.
    pub fn distance(&self, place: [f64; 2]) -> f64 {
        self.regions.iter().map(|r| r.clearance(place).distance).fold(f64::INFINITY, f64::min)
    }

    /// A place at this `margin` (m), the shortest way from `place` out of its nearest region; `None` where another region is there.
    pub fn outside(&self, place: [f64; 2], margin: f64) -> Option<[f64; 2]> {
        let clearances = self.regions.iter().map(|region| region.clearance(place));
        let clearance = clearances.min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        let step = (margin - clearance.distance).max(0.0);
        let there = [place[0] + step * clearance.normal[0], place[1] + step * clearance.normal[1]];
        (self.distance(there) >= margin - 1e-6).then_some(there)
    }
}

impl Approach {
    /// Share of `velocity` that one border leaves.
    fn share(&self, border: &Clearance, velocity: [f64; 2]) -> f64 {
        let [vx, vz] = velocity;
        let away = vx * border.normal[0] + vz * border.normal[1];
        let [least, _] = allowed(border.distance, [self.margin, f64::INFINITY], self.rate);
        if away >= least.min(-ALONG * Vec2::<f64>::c(velocity).norm()) {
            1.0
        } else {
            least / away
        }
    }
}

impl Edge {
    #[cfg(feature = "std")]
    fn new(from: [f64; 2], to: [f64; 2], sense: f64) -> Self {
        let length = portable::hypot(to[0] - from[0], to[1] - from[1]).max(f64::MIN_POSITIVE);
        let along = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
        Edge { from, to, along, outward: [sense * along[1], -sense * along[0]], length }
    }

    /// From the nearest point of the edge. Along its length the direction is that of the edge's normal, free of rounding, so
    /// that motion along a straight border nears nothing.
    fn clearance(&self, place: [f64; 2]) -> Clearance {
        let to = [place[0] - self.from[0], place[1] - self.from[1]];
        let along = to[0] * self.along[0] + to[1] * self.along[1];
        if along > 0.0 && along < self.length {
            let height = to[0] * self.outward[0] + to[1] * self.outward[1];
            return Clearance { distance: height.abs(), normal: self.outward.map(|n| n * 1f64.copysign(height)) };
        }
        let corner = if along >= self.length { self.to } else { self.from };
        let off = [place[0] - corner[0], place[1] - corner[1]];
        let distance = portable::sqrt(off[0] * off[0] + off[1] * off[1]);
        let normal = if distance > TOUCHING { off.map(|o| o / distance) } else { self.outward };
        Clearance { distance, normal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::RandomStream;

    /// Not convex: the notch opens upwards.
    const NOTCHED: [[f64; 2]; 8] =
        [[-2.0, -1.0], [2.0, -1.0], [2.0, 1.0], [0.5, 1.0], [0.5, 0.0], [-0.5, 0.0], [-0.5, 1.0], [-2.0, 1.0]];

    fn notched() -> KeepOut {
        KeepOut { regions: vec![Region::new(NOTCHED.to_vec())], margin: 0.05, rate: 2.0 }
    }

    #[test]
    fn distance_and_way_out_in_either_sense_of_the_corners() {
        let backwards: Vec<_> = NOTCHED.iter().rev().copied().collect();
        for region in [Region::new(NOTCHED.to_vec()), Region::new(backwards)] {
            let cases = [
                ([0.0, 0.2], 0.2, [0.0, 1.0]),
                ([0.4, 0.5], 0.1, [-1.0, 0.0]),
                ([1.0, 0.9], -0.1, [0.0, 1.0]),
                ([5.0, 5.0], 5.0, [0.6, 0.8]),
                ([1.0, 1.0], 0.0, [0.0, 1.0]),
            ];
            for (place, distance, normal) in cases {
                let c = region.clearance(place);
                assert!((c.distance - distance).abs() < 1e-12, "{place:?}: {c:?}");
                assert!((0..2).all(|i| (c.normal[i] - normal[i]).abs() < 1e-12), "{place:?}: {c:?}");
            }
        }
    }

    #[test]
    fn nears_a_border_exponentially_and_leaves_it_freely() {
        let keep = notched();
        let v = keep.slowed([1.0, 1.25], [0.3, -0.6], &Caution::NONE);
        assert!((v[1] + 2.0 * 0.2).abs() < 1e-12 && (v[0] + 0.5 * v[1]).abs() < 1e-12, "{v:?}");
        for free in [[0.3, 0.6], [0.7, 0.0]] {
            assert_eq!(keep.slowed([1.0, 1.03], free, &Caution::NONE), free);
        }
        assert_eq!(keep.slowed([1.0, 1.03], [0.7, -1e-3], &Caution::NONE), [0.0, 0.0]);
    }

    #[test]
    fn caution_widens_the_margin_and_slows_the_approach() {
        let keep = notched();
        let caution = Caution { rate: 0.5, uncertainty: 0.01 };
        let v = keep.slowed([1.0, 1.25], [0.0, -0.6], &caution);
        assert!((v[1] + 0.5 * 0.19).abs() < 1e-12, "{v:?}");
        assert_eq!(keep.slowed([1.0, 1.055], [0.0, -0.6], &caution), [0.0, 0.0]);
        assert_eq!(keep.slowed([1.0, 1.25], [0.0, 0.6], &caution), [0.0, 0.6]);
    }

    #[test]
    fn from_inside_only_the_way_out_is_open() {
        let keep = notched();
        assert_eq!(keep.slowed([1.0, 0.9], [0.1, 0.2], &Caution::NONE), [0.1, 0.2]);
        assert_eq!(keep.slowed([1.0, 0.9], [0.1, -0.2], &Caution::NONE), [0.0, 0.0]);
    }

    #[test]
    fn a_place_outside_is_at_the_margin_or_there_is_none() {
        let mut keep = notched();
        for place in [[1.0, 0.9], [0.0, 0.01], [5.0, 5.0]] {
            let there = keep.outside(place, keep.margin).expect("free beside it");
            assert!(keep.distance(there) >= keep.margin - 1e-9, "{there:?}");
        }
        keep.regions.push(Region::new(vec![[0.5, 1.0], [2.0, 1.0], [2.0, 3.0], [0.5, 3.0]]));
        assert_eq!(keep.outside([1.2, 0.99], keep.margin), None);
    }

    #[test]
    fn random_motion_never_comes_nearer_than_the_margin() {
        let keep = notched();
        let mut random = RandomStream::new(5, "motion");
        let (mut place, mut nearest) = ([0.0, 1.5], f64::INFINITY);
        for k in 0..20_000 {
            let target = [2.5 * random.symmetric(), 1.6 * random.symmetric()];
            let rate = if k % 2 == 0 { 0.1 } else { 2.0 };
            for _ in 0..5 {
                let v = [rate * (target[0] - place[0]), rate * (target[1] - place[1])];
                let slowed = keep.slowed(place, v, &Caution::NONE);
                assert!((slowed[0] * v[1] - slowed[1] * v[0]).abs() < 1e-9, "turned");
                // The longest sample for which k T <= 1.
                place = [place[0] + 0.5 * slowed[0], place[1] + 0.5 * slowed[1]];
                nearest = nearest.min(keep.distance(place));
            }
        }
        assert!((keep.margin - 1e-6..keep.margin + 1e-3).contains(&nearest), "{nearest}");
    }
}
