//! The chain of the [model](crate::model): links, the points fixed in them, and the joints between them.

/// A point fixed in a link: link index and (x, z) in its frame, m, and its place y beside the plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Point<T = f64> {
    pub link: usize,
    pub name: String,
    pub position: [T; 2],
    pub aside: T,
}

impl<T: Copy> Point<T> {
    /// (x, y, z) in the link's frame, m.
    pub fn in_space(&self) -> [T; 3] {
        let [x, z] = self.position;
        [x, self.aside, z]
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Link<T = f64> {
    pub name: String,
    /// Direction of the link's own axis in its frame, rad from x towards z.
    pub axis: T,
    /// All bodies of the link together: mass, kg.
    pub mass: T,
    /// Centre of gravity (x, z) in the link frame, m.
    pub centre_of_gravity: [T; 2],
    /// Moment of inertia about the axis normal to the plane, kg m^2, taken about `inertia_about`.
    pub inertia: T,
    /// What else there is in space; `None` where the file does not state it.
    pub solid: Option<Solid<T>>,
    pub inertia_about: InertiaAbout,
    /// Every named point of the link.
    pub points: Vec<Point<T>>,
    /// Polyline of positions in the link frame, for drawings, m; empty: drawn through joints and points.
    pub outline: Vec<[f64; 2]>,
}

/// Mass properties of a link outside the plane: the place y of the centre of gravity, m, and the other elements of the tensor of inertia
/// about it, kg m^2; off the diagonal these are the negative products of inertia.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solid<T = f64> {
    pub y: T,
    pub xx: T,
    pub zz: T,
    pub xy: T,
    pub xz: T,
    pub yz: T,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InertiaAbout {
    /// About the link frame's origin (its joint).
    Frame,
    CentreOfGravity,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Joint<T = f64> {
    pub name: String,
    pub kind: JointKind<T>,
    /// Position of the child frame's origin on the parent link (prismatic: at coordinate `zero`), m, and its place y beside the plane.
    pub at: [T; 2],
    pub aside: T,
    /// Unit vector (x, y, z) in the parent frame about which a growing angle turns, before `sense`; at `zero` the frames of parent and
    /// child are then parallel. `None`: the joint moves in the plane.
    pub axis: Option<[f64; 3]>,
    /// Coordinate (rad or m) at which the joint is in its neutral position.
    pub zero: T,
    /// +1: a growing coordinate turns the child from x towards z (counter-clockwise seen with x right, z up)
    /// or moves it along `direction`; -1: the other way.
    pub sense: f64,
    /// Joint limits given in the file, overriding the derived ones.
    pub limits: Option<[f64; 2]>,
    /// Distance kept from a dead centre of the linkage, in the joint's unit.
    pub dead_centre_margin: f64,
}

impl<T: Copy> Joint<T> {
    /// Where the child's origin lies on the parent, (x, y, z), m.
    pub fn at_in_space(&self) -> [T; 3] {
        let [x, z] = self.at;
        [x, self.aside, z]
    }

    /// The axis about which a growing angle turns, before `sense`: its own, or that across the plane, from x towards z.
    pub fn turning_axis(&self) -> [f64; 3] {
        self.axis.unwrap_or([0.0, -1.0, 0.0])
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointKind<T = f64> {
    /// Child axis direction = parent axis direction + sense (q - zero)           [Relative]
    ///                      = parent axis direction + sense (q - zero - pi)      [Included]
    /// where a link's axis direction is its frame angle plus [`Link::axis`].
    Revolute(AngleConvention),
    /// The child frame keeps the parent's orientation; its origin is `at` + sense (q - zero) along `direction`
    /// (rad from x towards z, in the parent frame).
    Prismatic { direction: T },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleConvention {
    Relative,
    Included,
}
