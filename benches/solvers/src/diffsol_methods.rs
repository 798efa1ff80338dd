//! Methods of diffsol on these laws, with its nalgebra matrices and dense factorisation.

use crate::task::{Answer, Laws, Segment, Task};
use diffsol::{
    ConstantOp, Matrix, NalgebraContext, NalgebraLU, NalgebraMat, NalgebraVec, NonLinearOp, NonLinearOpJacobian,
    OdeBuilder, OdeEquations, OdeEquationsRef, OdeSolverMethod, OdeSolverProblem, OdeSolverStopReason, Op,
    UnitCallable, Vector, VectorCommon,
};
use std::cell::RefCell;

type Dense = NalgebraMat<f64>;
type Lu = NalgebraLU<f64>;

/// One segment's equations: the laws and the state it starts from.
struct Equations<'a> {
    laws: &'a Laws<'a>,
    start: Vec<f64>,
    context: NalgebraContext,
    columns: RefCell<Vec<f64>>,
}

impl Op for Equations<'_> {
    type T = f64;
    type V = NalgebraVec<f64>;
    type M = Dense;
    type C = NalgebraContext;

    fn context(&self) -> &NalgebraContext {
        &self.context
    }
    fn nstates(&self) -> usize {
        self.start.len()
    }
    fn nout(&self) -> usize {
        self.start.len()
    }
    fn nparams(&self) -> usize {
        0
    }
}

impl NonLinearOp for Equations<'_> {
    fn call_inplace(&self, x: &Self::V, _t: f64, dx: &mut Self::V) {
        self.laws.derivative(x.inner().as_slice(), dx.inner_mut().as_mut_slice());
    }
}

impl NonLinearOpJacobian for Equations<'_> {
    fn jac_mul_inplace(&self, x: &Self::V, _t: f64, v: &Self::V, y: &mut Self::V) {
        let mut columns = self.columns.borrow_mut();
        self.laws.jacobian(x.inner().as_slice(), &mut columns);
        let y = y.inner_mut().as_mut_slice();
        y.fill(0.0);
        for (column, factor) in columns.chunks_exact(y.len()).zip(v.inner().as_slice()) {
            y.iter_mut().zip(column).for_each(|(sum, slope)| *sum += slope * factor);
        }
    }

    fn jacobian_inplace(&self, x: &Self::V, _t: f64, jacobian: &mut Dense) {
        let mut columns = self.columns.borrow_mut();
        self.laws.jacobian(x.inner().as_slice(), &mut columns);
        for (j, column) in columns.chunks_exact(self.start.len()).enumerate() {
            jacobian.set_column(j, &NalgebraVec::from_slice(column, self.context));
        }
    }
}

impl ConstantOp for Equations<'_> {
    fn call_inplace(&self, _t: f64, x: &mut Self::V) {
        x.inner_mut().as_mut_slice().copy_from_slice(&self.start);
    }
}

impl<'b> OdeEquationsRef<'b> for Equations<'_> {
    type Rhs = &'b Self;
    type Init = &'b Self;
    type Mass = &'b UnitCallable<Dense>;
    type Root = &'b UnitCallable<Dense>;
    type Out = &'b UnitCallable<Dense>;
    type Reset = &'b UnitCallable<Dense>;
}

impl OdeEquations for Equations<'_> {
    fn rhs(&self) -> &Self {
        self
    }
    fn init(&self) -> &Self {
        self
    }
    fn mass(&self) -> Option<&UnitCallable<Dense>> {
        None
    }
    fn set_params(&mut self, _p: &Self::V) {}
    fn get_params(&self, _p: &mut Self::V) {}
}

/// Solves the task by diffsol's `method`, started anew at every change of the commands.
pub fn solve(task: &Task, relative: f64, method: &str) -> Result<Answer, String> {
    let mut laws = Laws::new(task);
    let mut states = Vec::with_capacity(task.rows * task.start.len());
    let (tolerances, mut x, mut steps) = ((relative, task.absolute(relative)), task.start.clone(), 0);
    states.extend_from_slice(&x);
    for segment in &task.segments {
        laws.spools.copy_from_slice(&segment.spools);
        let (end, taken) =
            one_segment(&tolerances, segment, &laws, x, method, &mut states).map_err(|e| e.to_string())?;
        (x, steps) = (end, steps + taken);
    }
    Ok(Answer { states, effort: laws.effort(steps) })
}

type Failure = Box<dyn std::error::Error>;

fn one_segment(
    (relative, absolute): &(f64, Vec<f64>),
    segment: &Segment,
    laws: &Laws,
    start: Vec<f64>,
    method: &str,
    states: &mut Vec<f64>,
) -> Result<(Vec<f64>, u64), Failure> {
    let columns = RefCell::new(vec![0.0; start.len() * start.len()]);
    let equations = Equations { laws, start, context: NalgebraContext::default(), columns };
    let problem: OdeSolverProblem<Equations> = OdeBuilder::<Dense>::new()
        .t0(segment.begin)
        .rtol(*relative)
        .atol(absolute.clone())
        .build_from_eqn(equations)?;
    match method {
        "diffsol-bdf" => advance(problem.bdf::<Lu>()?, segment, states),
        "diffsol-tr-bdf2" => advance(problem.tr_bdf2::<Lu>()?, segment, states),
        "diffsol-esdirk34" => advance(problem.esdirk34::<Lu>()?, segment, states),
        "diffsol-tsit45" => advance(problem.tsit45()?, segment, states),
        other => Err(format!("no solver is called {other}").into()),
    }
}

/// Steps to the end of the segment, records on the way; the state there and the number of steps.
fn advance<'p, 'l: 'p>(
    mut solver: impl OdeSolverMethod<'p, Equations<'l>>,
    segment: &Segment,
    states: &mut Vec<f64>,
) -> Result<(Vec<f64>, u64), Failure> {
    solver.set_stop_time(segment.end)?;
    let (mut record, mut steps, mut done) = (segment.record.iter().peekable(), 0, false);
    while !done {
        done = matches!(solver.step()?, OdeSolverStopReason::TstopReached);
        steps += 1;
        let reached = if done { segment.end } else { solver.state().t };
        while let Some(t) = record.next_if(|&&t| t <= reached) {
            states.extend_from_slice(solver.interpolate(t.min(solver.state().t))?.inner().as_slice());
        }
    }
    Ok((solver.state().y.inner().as_slice().to_vec(), steps))
}
