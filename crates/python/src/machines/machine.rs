//! The machine for Python: batches of rows in, arrays out.

use crate::handed::answers::{warnings_of, WarningEntry};
use crate::handed::arrays::{matrix, row, rows, tensor, vector, Row, Rows};
use crate::handed::errors::{assembly_error, file_error};
use crate::handed::overrides::{overrides, pairs_of};
use hydrocrane_machine::model::Cylinder;
use hydrocrane_machine::{OverrideValue, Template};
use hydrocrane_sim::assembly::AssemblyError;
use hydrocrane_sim::build;
use hydrocrane_sim::{ledger_terms, model::controllers, EquilibriumMode, Model, OutputInfo};
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use std::sync::Arc;

/// A machine with its file, from which it can be made with other values.
#[pyclass(frozen, module = "hydrocrane._core")]
#[derive(Clone)]
pub struct Machine {
    pub model: Arc<dyn Model>,
    source: String,
    file: Arc<Template>,
    /// In force, by key.
    overrides: Vec<(String, OverrideValue)>,
}

impl Machine {
    /// The machine that `source`, a bundled name or path, describes with these overrides.
    pub fn open(source: &str, overrides: &[(String, OverrideValue)]) -> Result<Self, AssemblyError> {
        Self::build(source, &Arc::new(Template::open(source, &[])?), overrides)
    }

    /// The machine that a text describes, which names no files.
    pub fn of_text(text: &str, source: &str, overrides: &[(String, OverrideValue)]) -> Result<Self, AssemblyError> {
        Self::build(source, &Arc::new(Template::of_text(text, source)?), overrides)
    }

    fn build(source: &str, file: &Arc<Template>, overrides: &[(String, OverrideValue)]) -> Result<Self, AssemblyError> {
        let description = file.build(overrides)?;
        let model = build(&description).map_err(|error| AssemblyError::Build(source.to_string(), error))?;
        Ok(Machine { model, source: source.to_string(), file: file.clone(), overrides: overrides.to_vec() })
    }

    /// The same with further overrides; itself if they change nothing.
    pub fn with(&self, changes: &[(String, OverrideValue)]) -> Result<Self, AssemblyError> {
        if changes.iter().all(|change| self.overrides.contains(change)) {
            return Ok(self.clone());
        }
        let kept = self.overrides.iter().filter(|(key, _)| !changes.iter().any(|(changed, _)| changed == key));
        let all: Vec<_> = kept.chain(changes).cloned().collect();
        Self::build(&self.source, &self.file, &all)
    }
}

/// The payload of each row, or that of all, kg.
#[derive(FromPyObject)]
enum Loads<'py> {
    Each(Row<'py>),
    One(f64),
}

type Vector<'py> = PyResult<Bound<'py, PyArray1<f64>>>;
type Matrix<'py> = PyResult<Bound<'py, PyArray2<f64>>>;
/// Kind, name and (k, 2) points.
type Polyline<'py> = (&'static str, String, Bound<'py, PyArray2<f64>>);
type Tensor<'py> = PyResult<Bound<'py, PyArray3<f64>>>;

impl Machine {
    fn n(&self) -> usize {
        self.model.layout().joints()
    }
    fn states(&self) -> usize {
        self.model.layout().len()
    }

    /// Applies `f(index, out_row)` to `count` rows of `width` numbers without the interpreter lock.
    fn fill(&self, py: Python<'_>, count: usize, width: usize, f: impl Fn(usize, &mut [f64]) + Sync) -> Vec<f64> {
        py.detach(|| {
            let mut out = vec![0.0; count * width];
            out.chunks_exact_mut(width.max(1)).enumerate().for_each(|(i, row)| f(i, row));
            out
        })
    }

    /// Of rows x, y, z of `width` numbers each those along which the tip moves.
    fn along_axes<'a>(&self, rows: &'a [f64], width: usize) -> impl Iterator<Item = f64> + 'a {
        self.model.tip_axes().iter().flat_map(move |axis| rows[axis * width..(axis + 1) * width].iter().copied())
    }

    /// `f` over rows of joint coordinates.
    fn over_q<'py>(
        &self,
        py: Python<'py>,
        q: &Rows<'py>,
        width: usize,
        f: impl Fn(&dyn Model, &[f64], &mut [f64]) + Sync,
    ) -> PyResult<Vec<f64>> {
        let (n, q) = (self.n(), rows(q, self.n(), "q")?);
        Ok(self.fill(py, q.len() / n, width, |i, out| f(self.model.as_ref(), &q[i * n..(i + 1) * n], out)))
    }

    /// `f` over rows of joint coordinates and of a second quantity of the same width.
    fn over_q_and<'py>(
        &self,
        py: Python<'py>,
        q: &Rows<'py>,
        other: (&Rows<'py>, &str),
        width: usize,
        f: impl Fn(&dyn Model, &[f64], &[f64], &mut [f64]) + Sync,
    ) -> PyResult<Vec<f64>> {
        let n = self.n();
        let (q, other) = (rows(q, n, "q")?, rows(other.0, n, other.1)?);
        let at = |i: usize| i * n..(i + 1) * n;
        Ok(self.fill(py, q.len().min(other.len()) / n, width, |i, out| {
            f(self.model.as_ref(), &q[at(i)], &other[at(i)], out);
        }))
    }

    /// `f` over rows of states and of commands.
    fn over_states<'py>(
        &self,
        py: Python<'py>,
        x: &Rows<'py>,
        u: &Rows<'py>,
        width: usize,
        f: impl Fn(&dyn Model, &[f64], &[f64], &mut [f64]) + Sync,
    ) -> PyResult<Vec<f64>> {
        let (n, states) = (self.n(), self.states());
        let (x, u) = (rows(x, states, "state")?, rows(u, n, "spool_command")?);
        Ok(self.fill(py, (x.len() / states).min(u.len() / n), width, |i, out| {
            f(self.model.as_ref(), &x[i * states..(i + 1) * states], &u[i * n..(i + 1) * n], out);
        }))
    }

    fn cylinder(&self, index: usize) -> PyResult<usize> {
        let n = self.n();
        (index < n).then_some(index).ok_or_else(|| PyIndexError::new_err(format!("no cylinder {index} of {n}")))
    }
}

#[pymethods]
impl Machine {
    /// The same machine with these overrides in place of its own.
    fn rebuilt(&self, py: Python<'_>, pairs: &Bound<'_, PyList>) -> PyResult<Machine> {
        let changes = overrides(pairs)?;
        py.detach(|| Self::build(&self.source, &self.file, &changes)).map_err(|error| assembly_error(&error))
    }
    #[getter]
    pub fn source(&self) -> &str {
        &self.source
    }
    #[getter]
    fn overrides<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        pairs_of(py, &self.overrides)
    }
    /// What the machine's file states with everything that it extends and includes, without overrides, as the text of one file.
    #[getter]
    fn file_text(&self) -> String {
        self.file.text()
    }
    /// The machine with everything that its file extends and includes, and with its overrides, as the text of one file.
    pub fn to_toml(&self) -> PyResult<String> {
        self.file.to_toml(&self.overrides).map_err(|error| file_error(&error))
    }
    #[getter]
    fn name(&self) -> &str {
        &self.model.machine().name
    }
    #[getter]
    fn title(&self) -> &str {
        &self.model.machine().title
    }
    #[getter]
    fn description(&self) -> &str {
        &self.model.machine().description
    }
    /// Everything that decides what the machine does, as text: two machines with the same text behave alike.
    #[getter]
    fn resolved(&self) -> String {
        let mut machine = self.model.machine().clone();
        (machine.title, machine.description, machine.provenance, machine.words) = Default::default();
        format!("{machine:?}")
    }
    #[getter]
    fn joint_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.model.machine().joints.iter().map(|j| j.name.as_str()))
    }
    #[getter]
    fn joint_units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.model.layout().units[..self.n()])
    }
    #[getter]
    fn cylinder_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.model.machine().cylinders.iter().map(|c| c.name.as_str()))
    }
    #[getter]
    fn state_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.model.layout().names)
    }
    #[getter]
    fn state_units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.model.layout().units)
    }
    #[getter]
    fn state_long_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.model.layout().long_names)
    }
    #[getter]
    fn payload_mass(&self) -> f64 {
        self.model.machine().payload.mass
    }
    /// Name and (k, 2) corners of each region.
    #[getter]
    fn keep_out<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, Bound<'py, PyArray2<f64>>)>> {
        let regions = self.model.machine().keep_out.iter();
        regions.map(|(name, corners)| Ok((name.clone(), matrix(py, corners.concat(), 2)?))).collect()
    }
    fn clearance<'py>(&self, py: Python<'py>, places: Rows<'py>) -> Vector<'py> {
        let places = rows(&places, 3, "places")?;
        Ok(vector(py, places.chunks_exact(3).map(|p| self.model.clearance([p[0], p[1], p[2]])).collect()))
    }
    /// Heights of the undersides of `loads` (kg, one per place) at the tip above the ground, m.
    fn heights_above_ground<'py>(&self, py: Python<'py>, places: Rows<'py>, loads: Row<'py>) -> Vector<'py> {
        let (places, loads) = (rows(&places, 2, "places")?, loads.as_slice()?);
        let heights = places.chunks_exact(2).zip(loads);
        Ok(vector(py, heights.map(|(p, load)| self.model.height_above_ground([p[0], p[1]], *load)).collect()))
    }
    #[getter]
    fn supply_pressure(&self) -> f64 {
        self.model.machine().supply.pressure
    }
    #[getter]
    fn tank_pressure(&self) -> f64 {
        self.model.machine().supply.tank_pressure
    }
    /// Highest pressures that piston side and rod side can be held at, Pa.
    #[getter]
    fn holdable<'py>(&self, py: Python<'py>) -> Matrix<'py> {
        matrix(py, self.model.holdable().concat(), 2)
    }
    /// Per row of joint coordinates the payload that is held, kg, and the cylinder that ends it, -1 for none.
    fn capacity<'py>(&self, py: Python<'py>, q: Rows<'py>, ceiling: f64) -> Matrix<'py> {
        let of = |m: &dyn Model, q: &[f64], out: &mut [f64]| {
            let (payload, limiting) = m.capacity(q, ceiling);
            out.copy_from_slice(&[payload, limiting.map_or(-1.0, |c| c as f64)]);
        };
        matrix(py, self.over_q(py, &q, 2, of)?, 2)
    }
    /// Piston-side and rod-side areas, m^2, of all cylinders in parallel together.
    #[getter]
    fn areas<'py>(&self, py: Python<'py>) -> Matrix<'py> {
        matrix(py, self.model.machine().cylinders.iter().flat_map(Cylinder::areas).collect(), 2)
    }
    /// Every value of the machine file that was read: key, SI numbers, unit, class, source.
    #[getter]
    fn values(&self) -> Vec<(&str, &[f64], &str, String, &str)> {
        let entries = self.model.machine().provenance.iter();
        let class = |class| format!("{class:?}").to_lowercase();
        entries
            .map(|p| (p.key.as_str(), p.value.si.as_slice(), &*p.value.units[0], class(p.class), p.source.as_str()))
            .collect()
    }
    /// Names and choices of the machine file, each with its key.
    #[getter]
    fn words(&self) -> Vec<(&str, &str)> {
        self.model.machine().words.iter().map(|(key, word)| (key.as_str(), word.as_str())).collect()
    }
    /// Pressure at which the main relief valve opens, Pa; none without a pump.
    #[getter]
    fn relief_pressure(&self) -> Option<f64> {
        self.model.machine().supply.mains.as_ref().map(|mains| mains.relief_pressure)
    }
    /// Values outside their usual ranges.
    #[getter]
    fn warnings(&self) -> Vec<WarningEntry> {
        warnings_of(hydrocrane_sim::implausible(&self.model.machine().warnings))
    }
    /// Sensors of the file: name and measured signal.
    #[getter]
    fn sensors(&self) -> Vec<(&str, &str)> {
        self.model.machine().sensors.iter().map(|s| (s.name.as_str(), s.measures.as_str())).collect()
    }
    #[getter]
    fn errata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let e = &self.model.machine().errata;
        let out = PyDict::new(py);
        for (name, corrected) in [
            ("gravity-sign", e.gravity_sign),
            ("inertia-about", e.inertia_about),
            ("orifice-law", e.orifice_law),
            ("extension-leakage", e.extension_leakage),
            ("extension-dead-volume", e.extension_dead_volume),
            ("leakage-viscosity", e.leakage_viscosity),
            ("end-stop", e.end_stop),
            ("friction-map", e.friction_map),
            ("ik-quadrant", e.ik_quadrant),
            ("ik-unreachable", e.ik_unreachable),
            ("ik-extension", e.ik_extension),
        ] {
            out.set_item(name, corrected)?;
        }
        Ok(out)
    }
    #[getter]
    fn joint_limits<'py>(&self, py: Python<'py>) -> Matrix<'py> {
        matrix(py, self.model.joint_limits().iter().flat_map(|l| [l.lower, l.upper]).collect(), 2)
    }
    #[getter]
    fn joint_limit_reasons(&self) -> Vec<(&'static str, &'static str)> {
        self.model.joint_limits().iter().map(|l| (l.reasons[0].name(), l.reasons[1].name())).collect()
    }
    #[getter]
    fn stroke_limits<'py>(&self, py: Python<'py>) -> Matrix<'py> {
        matrix(py, self.model.stroke_limits().concat(), 2)
    }
    #[getter]
    fn spool_strokes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.model.spool_strokes())
    }

    fn strokes<'py>(&self, py: Python<'py>, q: Rows<'py>) -> Matrix<'py> {
        let n = self.n();
        let data = self.over_q(py, &q, n, |m, q, out| m.strokes(q, out, &mut vec![0.0; n]))?;
        matrix(py, data, n)
    }
    fn stroke_jacobian<'py>(&self, py: Python<'py>, q: Rows<'py>) -> Tensor<'py> {
        let n = self.n();
        let data = self.over_q(py, &q, n * n, |m, q, out| {
            let (mut x, mut gain) = (vec![0.0; n], vec![0.0; n]);
            m.strokes(q, &mut x, &mut gain);
            (0..n).for_each(|c| out[c * n + c] = gain[c]);
        })?;
        tensor(py, data, (n, n))
    }
    fn joints_from_strokes<'py>(&self, py: Python<'py>, x: Rows<'py>) -> Matrix<'py> {
        let n = self.n();
        let x = rows(&x, n, "x")?;
        let mut out = vec![0.0; x.len()];
        for (x, q) in x.chunks_exact(n).zip(out.chunks_exact_mut(n)) {
            self.model.joints_from_strokes(x, q).map_err(|e| PyValueError::new_err(e.to_string()))?;
        }
        matrix(py, out, n)
    }
    fn cylinder_slopes<'py>(&self, py: Python<'py>, q: Rows<'py>) -> Matrix<'py> {
        let n = self.n();
        matrix(py, self.over_q(py, &q, n, |m, q, out| m.cylinder_angles(q, out))?, n)
    }
    fn centres_of_gravity<'py>(&self, py: Python<'py>, q: Rows<'py>) -> Tensor<'py> {
        let n = self.n();
        let places = self.over_q(py, &q, 3 * n, |m, q, out| m.centres_of_gravity(q, out))?;
        let places = places.chunks_exact(3).flat_map(|place| self.along_axes(place, 1)).collect();
        tensor(py, places, (n, self.model.tip_axes().len()))
    }
    /// Names of the axes along which the tip moves.
    #[getter]
    fn tip_axes(&self) -> Vec<&'static str> {
        self.model.tip_axes().iter().map(|axis| ["x", "y", "z"][*axis]).collect()
    }
    /// Names of the axes of the stick that moves the tip.
    #[getter]
    fn stick_axes(&self) -> &'static [&'static str] {
        self.model.machine().tip_axes()
    }
    fn tip<'py>(&self, py: Python<'py>, q: Rows<'py>) -> Matrix<'py> {
        let tips = self.over_q(py, &q, 3, |m, q, out| out.copy_from_slice(&m.tip(q)))?;
        let tips = tips.chunks_exact(3).flat_map(|tip| self.along_axes(tip, 1)).collect();
        matrix(py, tips, self.model.tip_axes().len())
    }
    fn tip_jacobian<'py>(&self, py: Python<'py>, q: Rows<'py>) -> Tensor<'py> {
        let n = self.n();
        let all = self.over_q(py, &q, 3 * n, |m, q, out| m.tip_jacobian(q, out))?;
        let all = all.chunks_exact(3 * n).flat_map(|jacobian| self.along_axes(jacobian, n)).collect();
        tensor(py, all, (self.model.tip_axes().len(), n))
    }
    /// Whether the first joint turns all others about the vertical axis.
    #[getter]
    fn slews(&self) -> bool {
        self.model.machine().slews()
    }
    fn tip_in_plane<'py>(&self, py: Python<'py>, q: Rows<'py>) -> Matrix<'py> {
        matrix(py, self.over_q(py, &q, 2, |m, q, out| out.copy_from_slice(&m.tip_in_plane(q)))?, 2)
    }
    /// The place of the tip within the joint limits that is nearest to `place`, along the axes of the tip, m.
    fn nearest_tip<'py>(&self, py: Python<'py>, place: Row<'py>) -> Vector<'py> {
        let axes = self.model.tip_axes();
        let mut of_tip = [0.0; 3];
        axes.iter().zip(row(&place, axes.len(), "place")?).for_each(|(axis, r)| of_tip[*axis] = *r);
        let nearest = py.detach(|| self.model.nearest_tip(of_tip));
        Ok(vector(py, axes.iter().map(|axis| nearest[*axis]).collect()))
    }
    fn inverse_kinematics<'py>(&self, py: Python<'py>, tip: Row<'py>, held: f64) -> Matrix<'py> {
        let tip = row(&tip, 2, "tip")?;
        let found = self.model.inverse_kinematics([tip[0], tip[1]], held);
        let found = found.map_err(|e| PyValueError::new_err(e.to_string()))?;
        matrix(py, found.concat(), self.n())
    }
    fn drawing<'py>(&self, py: Python<'py>, q: Row<'py>) -> PyResult<Vec<Polyline<'py>>> {
        let shapes = self.model.drawing(row(&q, self.n(), "q")?);
        shapes.into_iter().map(|s| Ok((s.kind.name(), s.name, matrix(py, s.line.concat(), 2)?))).collect()
    }
    fn workspace<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        self.model.workspace().into_iter().map(|curve| matrix(py, curve.concat(), 2)).collect()
    }

    fn mass_matrix<'py>(&self, py: Python<'py>, q: Rows<'py>, payload: f64) -> Tensor<'py> {
        let n = self.n();
        let data = self.over_q(py, &q, n * n, |m, q, out| {
            m.equations(q, &vec![0.0; n], payload, out, &mut vec![0.0; n]);
        })?;
        tensor(py, data, (n, n))
    }
    fn bias_force<'py>(&self, py: Python<'py>, q: Rows<'py>, qd: Rows<'py>, payload: f64) -> Matrix<'py> {
        let n = self.n();
        let data = self.over_q_and(py, &q, (&qd, "qd"), n, |m, q, qd, out| {
            m.equations(q, qd, payload, &mut vec![0.0; n * n], out);
        })?;
        matrix(py, data, n)
    }
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Rows<'py>,
        qd: Rows<'py>,
        force: Rows<'py>,
        payload: f64,
    ) -> Matrix<'py> {
        let n = self.n();
        let (q, qd, force) = (rows(&q, n, "q")?, rows(&qd, n, "qd")?, rows(&force, n, "cylinder_force")?);
        let count = q.len().min(qd.len()).min(force.len()) / n;
        let at = |i: usize| i * n..(i + 1) * n;
        let data = self.fill(py, count, n, |i, out| {
            self.model.forward_dynamics(&q[at(i)], &qd[at(i)], &force[at(i)], payload, out);
        });
        matrix(py, data, n)
    }
    fn static_cylinder_force<'py>(&self, py: Python<'py>, q: Rows<'py>, payload: f64) -> Matrix<'py> {
        let n = self.n();
        matrix(py, self.over_q(py, &q, n, |m, q, out| m.static_force(q, payload, out))?, n)
    }
    fn piston_speeds<'py>(&self, py: Python<'py>, q: Rows<'py>, payload: f64) -> Tensor<'py> {
        let n = self.n();
        tensor(py, self.over_q(py, &q, 2 * n, |m, q, out| m.piston_speeds(q, payload, out))?, (n, 2))
    }
    fn spool_positions<'py>(&self, py: Python<'py>, shares: Rows<'py>) -> Matrix<'py> {
        let n = self.n();
        matrix(py, self.over_q(py, &shares, n, |m, shares, out| m.spool_positions(shares, out))?, n)
    }
    fn kinetic_energy<'py>(&self, py: Python<'py>, q: Rows<'py>, qd: Rows<'py>, payload: f64) -> Vector<'py> {
        let energy = |m: &dyn Model, q: &[f64], qd: &[f64], out: &mut [f64]| out[0] = m.energies(q, qd, payload).0;
        Ok(vector(py, self.over_q_and(py, &q, (&qd, "qd"), 1, energy)?))
    }
    fn potential_energy<'py>(&self, py: Python<'py>, q: Rows<'py>, payload: f64) -> Vector<'py> {
        let rest = vec![0.0; self.n()];
        Ok(vector(py, self.over_q(py, &q, 1, |m, q, out| out[0] = m.energies(q, &rest, payload).1)?))
    }

    fn orifice_flow<'py>(&self, py: Python<'py>, cylinder: usize, spool: Row<'py>, dp: Row<'py>) -> Vector<'py> {
        let c = self.cylinder(cylinder)?;
        let (spool, dp) = (spool.as_slice()?, dp.as_slice()?);
        let flows = spool.iter().zip(dp).map(|(x, dp)| self.model.orifice_flow(c, *x, *dp));
        Ok(vector(py, flows.collect()))
    }
    fn edge_areas<'py>(&self, py: Python<'py>, cylinder: usize, spool: Row<'py>) -> Matrix<'py> {
        let c = self.cylinder(cylinder)?;
        matrix(py, spool.as_slice()?.iter().flat_map(|x| self.model.edge_areas(c, *x)).collect(), 4)
    }
    fn bulk_modulus<'py>(&self, py: Python<'py>, p: Row<'py>) -> Vector<'py> {
        Ok(vector(py, p.as_slice()?.iter().map(|p| self.model.bulk_modulus(*p)).collect()))
    }
    fn density<'py>(&self, py: Python<'py>, p: Row<'py>) -> Vector<'py> {
        Ok(vector(py, p.as_slice()?.iter().map(|p| self.model.density(*p)).collect()))
    }
    fn friction_map<'py>(&self, py: Python<'py>, cylinder: usize, v: Row<'py>) -> Vector<'py> {
        let c = self.cylinder(cylinder)?;
        Ok(vector(py, v.as_slice()?.iter().map(|v| self.model.steady_friction(c, *v)).collect()))
    }
    fn passivity<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let entries = self.model.passivity().into_iter();
        entries
            .map(|p| {
                let out = PyDict::new(py);
                out.set_item("cylinder", p.cylinder)?;
                out.set_item("holds", p.fails_at.is_none())?;
                out.set_item("velocity_limit", p.fails_at)?;
                out.set_item("checked_to", p.checked_to)?;
                Ok(out)
            })
            .collect()
    }

    fn state_derivative<'py>(&self, py: Python<'py>, x: Rows<'py>, u: Rows<'py>, payload: f64) -> Matrix<'py> {
        let width = self.states();
        let data = self.over_states(py, &x, &u, width, |m, x, u, out| m.derivative(x, u, payload, out))?;
        matrix(py, data, width)
    }
    fn reference_state_derivative<'py>(
        &self,
        py: Python<'py>,
        x: Rows<'py>,
        u: Rows<'py>,
        payload: f64,
    ) -> Matrix<'py> {
        let (n, width) = (self.n(), self.states());
        let (x, u) = (rows(&x, width, "state")?, rows(&u, n, "spool_command")?);
        let mut data = Vec::with_capacity(x.len());
        for (x, u) in x.chunks_exact(width).zip(u.chunks_exact(n)) {
            let derivative = self.model.reference_derivative(x, u, payload).ok_or_else(|| {
                PyValueError::new_err(
                    "the reference model has only the corrected laws; this machine has as-printed ones",
                )
            })?;
            data.extend(derivative);
        }
        matrix(py, data, width)
    }
    fn jacobian<'py>(&self, py: Python<'py>, x: Rows<'py>, u: Rows<'py>, payload: f64) -> Tensor<'py> {
        let width = self.states();
        let data = self.over_states(py, &x, &u, width * width, |m, x, u, out| m.jacobian(x, u, payload, out))?;
        tensor(py, data, (width, width))
    }
    fn equilibrium<'py>(&self, py: Python<'py>, q: Row<'py>, mode: &str, payload: f64) -> Vector<'py> {
        let mode = match mode {
            "hold" => EquilibriumMode::Hold,
            "steady" => EquilibriumMode::Steady,
            _ => return Err(PyValueError::new_err(format!("mode must be `hold` or `steady`, got `{mode}`"))),
        };
        let found = self.model.equilibrium(row(&q, self.n(), "q")?, mode, payload);
        Ok(vector(py, found.map_err(|e| PyValueError::new_err(e.to_string()))?))
    }
    /// What is doubtful of the equilibrium `x` that was asked for in the pose `q`.
    fn doubts_at_rest(&self, q: Row<'_>, x: Row<'_>, payload: f64) -> PyResult<Vec<WarningEntry>> {
        let (q, x) = (row(&q, self.n(), "q")?, row(&x, self.model.layout().len(), "x")?);
        Ok(warnings_of(hydrocrane_sim::doubts_at_rest(self.model.as_ref(), q, x, payload)))
    }
    #[getter]
    fn output_info(&self) -> Vec<(String, &'static str, String)> {
        let info = self.model.output_info().iter();
        info.map(|OutputInfo { name, unit, long_name }| (name.clone(), *unit, long_name.clone())).collect()
    }
    /// The column of an output; `None` if the machine has none of this name.
    fn output_index(&self, name: &str) -> Option<usize> {
        self.model.output_info().iter().position(|output| output.name == name)
    }
    /// `oil`: whether `energy.oil` is wanted; else it is NaN.
    #[pyo3(signature = (x, u, payload, oil = true))]
    fn outputs<'py>(&self, py: Python<'py>, x: Rows<'py>, u: Rows<'py>, payload: Loads<'py>, oil: bool) -> Matrix<'py> {
        let (width, states) = (self.model.output_info().len(), self.states());
        let (x, count) = (rows(&x, states, "state")?, rows(&u, self.n(), "spool_command")?.len() / self.n());
        let loads = match &payload {
            Loads::Each(loads) => row(loads, count, "payload")?,
            Loads::One(load) => &vec![*load; count],
        };
        let data = self.fill(py, count.min(x.len() / states), width, |i, out| {
            let x = &x[i * states..][..states];
            match oil {
                true => self.model.outputs(x, loads[i], out),
                false => self.model.outputs_without_oil(x, loads[i], out),
            }
        });
        matrix(py, data, width)
    }
    /// Gains of the controller `tip` by key, SI: the machine's, else the defaults.
    #[getter]
    fn tip_gains<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for (key, _, value) in controllers::tip_gains(self.model.machine()) {
            out.set_item(key, value)?;
        }
        Ok(out)
    }
    /// Name, unit, meaning and sign in the energy balance.
    #[getter]
    fn ledger_info(&self) -> Vec<(String, &'static str, String)> {
        let terms = ledger_terms(self.model.machine()).into_iter();
        terms.map(|(of, (name, text, _))| (format!("{of}.{name}"), "J", format!("{of}: {text}"))).collect()
    }
    /// +1 where a ledger entry adds to the stored energy, -1 where it takes from it, 0 where it moves inside.
    #[getter]
    fn ledger_signs(&self) -> Vec<f64> {
        ledger_terms(self.model.machine()).into_iter().map(|(_, (_, _, sign))| *sign).collect()
    }
}
