//! What the set-point is asked for, and the lags behind which it follows.    theory: docs/theory/control/reference.md

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Request<const N: usize> {
    /// Of the tip (x, z), m/s, and of the slewing joint, rad/s.
    Tip([f64; 3]),
    /// Of every joint, rad/s or m/s, while one holds the tip's height.
    Joints([f64; N]),
}

impl<const N: usize> Request<N> {
    pub fn scaled(self, share: f64) -> Self {
        match self {
            Request::Tip(velocity) => Request::Tip(velocity.map(|v| v * share)),
            Request::Joints(rates) => Request::Joints(rates.map(|rate| rate * share)),
        }
    }

    pub fn is_zero(&self) -> bool {
        match self {
            Request::Tip(velocity) => *velocity == [0.0; 3],
            Request::Joints(rates) => rates.iter().all(|rate| *rate == 0.0),
        }
    }
}

/// Two lags in a row of the velocity asked for.
#[derive(Debug, Clone, Copy)]
pub struct Lags<const K: usize>(pub [[f64; K]; 2]);

impl<const K: usize> Lags<K> {
    pub fn at(velocity: [f64; K]) -> Self {
        Lags([velocity; 2])
    }

    pub fn scaled(self, share: f64) -> Self {
        Lags(self.0.map(|lag| lag.map(|v| v * share)))
    }

    pub fn follow(&mut self, request: [f64; K], share: f64) -> [f64; K] {
        let [first, second] = &mut self.0;
        for r in 0..K {
            first[r] += share * (request[r] - first[r]);
            second[r] += share * (first[r] - second[r]);
        }
        *second
    }
}
