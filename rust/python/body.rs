//! `BodyTracker`: the online tracker of the body.

use super::body_arguments::{PartArgument, extract_method, extract_projection};
use super::body_estimate::BodyEstimate;
use super::body_evidence::{extract_evidence, image};
use super::border::compute;
use super::record::{LayerRecord, records};
use super::rows;
use super::skeleton::Skeleton;
use crate::Error;
use crate::body::cues::keypoints::KEYPOINTS;
use crate::body::{self, BodyEvidence, BodyMethod, Figure, KEY_JOINTS, Part};
use crate::error::guarded;
use crate::filter::History;
use crate::particles::ParticleSet;
use crate::projection::Projection;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Follows one body, frame by frame, from edges and blobs.
///
/// `BodyTracker(skeleton, pose, free, limits, parts, camera, method, seed)`: the pose `(C,)` of the first frame, m and
/// rad; indices of the free channels `(D,)`; limits `(C, 2)`, rad; the outer shape; a camera with `affine` or a pinhole; a
/// method of `pytracker.methods`. The same seed gives the same bits for any number of threads. Raises `InputError`.
#[pyclass(module = "pytracker._core")]
pub struct BodyTracker(body::BodyTracker);

#[pymethods]
impl BodyTracker {
    #[new]
    #[pyo3(signature = (skeleton, pose, free, limits, parts, camera, method, seed = 0))]
    #[allow(clippy::too_many_arguments)] // one argument a thing; keywords in Python
    fn new(
        py: Python<'_>,
        skeleton: &Skeleton,
        pose: Vec<f64>,
        free: Vec<usize>,
        limits: PyReadonlyArray2<'_, f64>,
        parts: Vec<PartArgument>,
        #[pyo3(from_py_with = extract_projection)] camera: Projection,
        #[pyo3(from_py_with = extract_method)] method: BodyMethod,
        seed: u64,
    ) -> PyResult<Self> {
        let parts: Vec<Part> = parts
            .into_iter()
            .map(|part| Part { start: part.start, end: part.end, half_width_m: part.half_width_m })
            .collect();
        let limits = rows("limits", &limits)?;
        Ok(Self(compute(py, None, || {
            let figure = Figure::new(&skeleton.0, &pose, &free, &limits, &parts)?;
            body::BodyTracker::new(figure, camera, method, seed)
        })?))
    }

    /// Take a frame: time in s, and what it shows, such as a `pytracker.BodyEvidence`: `edges` `(H, W)` bytes (0 is none),
    /// `blobs` `(B, 2)`, centres, px, in no order; `skin_region` and `foreground_region`, each `None` or a pair: distance
    /// of every pixel `(H, W)`, px, and some points `(P, 2)`, px; `keypoints` `(P, 9, 3)`: of each person u, v and standard
    /// deviation, px, in the order of `KEYPOINTS`, NaN where not seen; `orientations`, a list of what sensors say: segment,
    /// `q_world_segment` (w first), standard deviations of direction and of roll (infinite: none), rad. Raises `InputError`,
    /// or `TrackingError` when no particle explains what was seen. `threads` limits how many work on the particles; it
    /// does not change the result.
    #[pyo3(signature = (time_s, evidence, threads = None))]
    fn update(
        &mut self,
        py: Python<'_>,
        time_s: f64,
        #[pyo3(from_py_with = extract_evidence)] evidence: BodyEvidence,
        threads: Option<usize>,
    ) -> PyResult<BodyEstimate> {
        Ok(BodyEstimate(compute(py, threads, || self.0.update(time_s, &evidence))?))
    }

    /// The same, with what every layer did: same bits, more memory. Raises as `update`.
    fn update_recorded(
        &mut self,
        py: Python<'_>,
        time_s: f64,
        #[pyo3(from_py_with = extract_evidence)] evidence: BodyEvidence,
    ) -> PyResult<(BodyEstimate, Vec<LayerRecord>)> {
        let mut history = History::default();
        let estimate = compute(py, None, || self.0.update_recorded(time_s, &evidence, Some(&mut history)))?;
        Ok((BodyEstimate(estimate), records(history)))
    }

    /// Key joints `(T, 8, 3)`, world, m, of states `(T, D)`: m and rad. Raises `InputError`.
    fn joints<'py>(&self, py: Python<'py>, states: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let view = states.as_array();
        let (rows, columns): (Vec<f64>, _) = (view.iter().copied().collect(), view.ncols());
        let joints = compute(py, None, || self.0.figure().joints_of(&ParticleSet::from_rows(columns, &rows)?))?;
        PyArray1::from_vec(py, joints.rows()).reshape([joints.len(), KEY_JOINTS.len(), 3])
    }

    /// Whole poses `(T, C)` of states `(T, D)`: m and rad. Raises `InputError`.
    fn poses<'py>(&self, py: Python<'py>, states: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (model, states) = (&self.0.figure().model, states.as_array());
        if states.ncols() != model.dim() {
            let (got, expected) = (states.ncols(), model.dim());
            return Err(Error::Size { name: "states", got, unit: "columns", expected }.into());
        }
        let poses =
            guarded(|| Ok(states.rows().into_iter().map(|state| model.pose(&state.to_vec())).collect::<Vec<_>>()))?;
        Ok(PyArray2::from_vec2(py, &poses)?)
    }

    /// The particles as they stand, `(N, D)`.
    #[getter]
    fn particles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let set = self.0.particles();
        PyArray1::from_vec(py, set.rows()).reshape([set.len(), set.dim()])
    }

    /// Their normalised weights, `(N,)`.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.particles().weights().to_pyarray(py)
    }

    /// The whole tracker as bytes, for `restore` by the same version.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &guarded(|| self.0.save())?))
    }

    /// A tracker from what `save` gave. Raises `InputError`.
    #[staticmethod]
    fn restore(state: &[u8]) -> PyResult<Self> {
        Ok(Self(guarded(|| body::BodyTracker::restore(state))?))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((py.get_type::<Self>().getattr("restore")?, (self.save(py)?,)))
    }
}

/// Names of the key joints, in the order of every estimate.
pub fn key_joints() -> Vec<&'static str> {
    KEY_JOINTS.iter().map(|(name, _, _)| *name).collect()
}

/// Names of the joints that a detector may see, in the order of `keypoints`.
pub fn keypoints() -> Vec<&'static str> {
    KEYPOINTS.iter().map(|(name, _, _)| *name).collect()
}

/// Share of an outline's pixels that lie on no edge (Li & Kulić eq. 4), 0 to 1: edges `(H, W)` bytes, outlines
/// `(N, 4, 2)` px flattened to `(N, 8)`. Raises `InputError`.
#[pyfunction]
pub fn missed_edges<'py>(
    py: Python<'py>,
    edges: PyReadonlyArray2<'py, u8>,
    outlines: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let image = image(&edges)?;
    let corners = |c: [f64; 8]| [[c[0], c[1]], [c[2], c[3]], [c[4], c[5]], [c[6], c[7]]];
    let outlines: Vec<_> = rows::<8>("outlines", &outlines)?.into_iter().map(corners).collect();
    let mut missed = vec![0.0; outlines.len()];
    compute(py, None, || {
        image.missed_all(&outlines, &mut missed);
        Ok(())
    })?;
    Ok(PyArray1::from_vec(py, missed))
}
