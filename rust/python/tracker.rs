//! `Tracker`: the one online tracker, of an arm or a body.

use super::arm_arguments::{ArmArgument, ViewArgument, extract_method as extract_arm_method};
use super::body_arguments::{PartArgument, extract_method as extract_body_method, extract_projection};
use super::border::compute;
use super::estimate::{Estimate, table};
use super::observation::Observation;
use super::record::{LayerRecord, records};
use super::rows;
use super::skeleton::Skeleton;
use crate::arm::ArmFilter;
use crate::body::cues::orientation::Segment;
use crate::body::{BodyFilter, Figure, Part};
use crate::error::guarded;
use crate::estimate;
use crate::filter::History;
use crate::particles::ParticleSet;
use crate::smoothing;
use crate::tracker::{self, Subject};
use crate::{Error, Result, observation};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::borrow::Cow;

/// Follows an arm or a body, observation by observation: `Tracker(recording, method, seed)`.
///
/// Of the recording only the set-up is used, no data: arm and cameras, or skeleton, first pose and camera. What comes up to
/// `delay_s` after a later observation is put in order, and estimates come so much later. The same seed gives the same bits,
/// online and for a whole recording, for any number of threads. Raises `InputError` for what is out of range. Can be pickled
/// and copied, but while observations wait: a copy goes on where this stands.
#[pyclass(module = "pytracker._core")]
pub struct Tracker(tracker::Tracker);

/// A recording that is smoothed window by window: see `Tracker.smoothed`.
#[pyclass(module = "pytracker._core")]
pub struct Smoothing {
    tracker: Py<Tracker>,
    threads: Option<usize>,
    of: smoothing::Smoothing,
}

#[pymethods]
impl Smoothing {
    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Self { tracker, threads, of } = self;
        // Another thread may be at it.
        let tracker = tracker.bind(py).try_borrow()?;
        let tracker = &tracker.0;
        let estimates = compute(py, *threads, || tracker.smoothed(of))?;
        if estimates.is_empty() { Ok(None) } else { Ok(Some(table(py, &tracker.places(), &estimates)?)) }
    }
}

/// What a body's tracker needs of a `pytracker.Skeleton`, read.
#[derive(FromPyObject)]
struct SkeletonArgument<'py> {
    core: PyRef<'py, Skeleton>,
    limits_rad: PyReadonlyArray2<'py, f64>,
}

fn arm(recording: &Bound<'_, PyAny>, method: &Bound<'_, PyAny>, seed: u64) -> PyResult<tracker::Tracker> {
    let arm = recording.getattr("arm")?;
    let side: String = arm.getattr("side")?.extract()?;
    let arm: ArmArgument = arm.extract()?;
    let views: Vec<ViewArgument> = recording.getattr("views")?.extract()?;
    let (noise, method) =
        extract_arm_method(&method.call_method1("known_by", (recording.getattr("spreads")?,))?, recording)?;
    let made = || {
        let views = views.into_iter().map(ViewArgument::view).collect::<Result<_>>()?;
        let upper_arm = Segment::from_name(&format!("{side}_upper_arm"))?;
        let tracker: tracker::Tracker = ArmFilter::new(arm.into(), views, noise, method, seed)?.into();
        Ok(tracker.with_upper_arm(upper_arm))
    };
    compute(recording.py(), None, made)
}

fn body(recording: &Bound<'_, PyAny>, method: &Bound<'_, PyAny>, seed: u64) -> PyResult<tracker::Tracker> {
    let skeleton = recording.getattr("skeleton")?;
    let free: Vec<usize> = skeleton.call_method1("columns", (method.getattr("channels")?,))?.extract()?;
    let projection = extract_projection(&recording.getattr("view")?.getattr("camera")?)?;
    let pose: Vec<f64> = recording.getattr("initial")?.extract()?;
    let method = &method.call_method1("known_by", (recording.getattr("spreads")?,))?;
    let parts: Vec<PartArgument> = skeleton.call_method1("outer_shape", (method.getattr("crown_m")?,))?.extract()?;
    let method = extract_body_method(method)?;
    let SkeletonArgument { core, limits_rad } = skeleton.extract()?;
    let parts: Vec<Part> = parts.into_iter().map(Into::into).collect();
    let (limits, skeleton) = (rows("limits", &limits_rad)?, &core.0);
    let made = || {
        let figure = Figure::new(skeleton, &pose, &free, &limits, &parts, &projection)?;
        Ok(BodyFilter::new(figure, projection, method, seed)?.into())
    };
    compute(recording.py(), None, made)
}

#[pymethods]
impl Tracker {
    #[new]
    #[pyo3(signature = (recording, method, seed = 0, delay_s = 0.0))]
    fn new(recording: &Bound<'_, PyAny>, method: &Bound<'_, PyAny>, seed: u64, delay_s: f64) -> PyResult<Self> {
        let of = |thing: &Bound<'_, PyAny>| thing.getattr("kind")?.extract::<String>();
        let (kind, takes) = (of(recording)?, of(method)?);
        if kind != takes {
            let name = method.get_type().name()?;
            let words = format!("{name} tracks a recording of kind '{takes}', this one is '{kind}'");
            return Err(super::InputError::new_err(words));
        }
        let made = if kind == "arm" { arm(recording, method, seed)? } else { body(recording, method, seed)? };
        Ok(Self(made.with_delay(delay_s)?))
    }

    /// Take an observation; the estimate of a frame, `None` between frames. Where late ones are waited for it is that of a
    /// frame that is due by now, the oldest that was not handed out. `threads` limits how many work; it does not change the
    /// result. Raises `InputError` for what cannot be used, after which it is as before, or `TrackingError` when the track is lost.
    #[pyo3(signature = (observation, threads = None))]
    fn observe(
        &mut self,
        py: Python<'_>,
        observation: &Observation,
        threads: Option<usize>,
    ) -> PyResult<Option<Estimate>> {
        let of = observation.of.clone();
        let found = compute(py, threads, || self.0.observe(of))?;
        Ok(found.map(|of| self.named(of)))
    }

    /// The same, with what every layer of a particle method did: same bits, more memory. Raises as `observe`.
    fn observe_recorded(
        &mut self,
        py: Python<'_>,
        observation: &Observation,
    ) -> PyResult<(Option<Estimate>, Vec<LayerRecord>)> {
        let (of, mut history) = (observation.of.clone(), History::default());
        let found = compute(py, None, || self.0.observe_recorded(of, Some(&mut history)))?;
        Ok((found.map(|of| self.named(of)), records(history)))
    }

    /// Wait no longer: estimates of the frames that are left. Raises as `observe`; what came before is given by the next call.
    fn finish(&mut self, py: Python<'_>) -> PyResult<Vec<Estimate>> {
        let found = compute(py, None, || self.0.finish())?;
        Ok(found.into_iter().map(|of| self.named(of)).collect())
    }

    /// Many observations in one call, without the interpreter lock: a dict of arrays, a row a frame (places by name
    /// `(T, 5, 3)`: mean, mode, standard deviation, 2.5 % and 97.5 % quantile, m; `state` `(T, 5, K)`, `mean` and `sd` `(T, D)`,
    /// `place_covariance` `(T, 3, 3)` of the state's first three columns, `blobs`, `time_s`, `ess`, `log_evidence`, `doubt`); and, where the track was lost, the
    /// message, the rows ending before that frame. Where the tracker waits for late ones `finish` gives the last. Raises
    /// `InputError`, whose attribute `table` holds the rows before.
    #[pyo3(signature = (observations, threads = None))]
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        observations: Vec<PyRef<'py, Observation>>,
        threads: Option<usize>,
    ) -> PyResult<(Bound<'py, PyDict>, Option<String>)> {
        let all: Vec<observation::Observation> = observations.iter().map(|one| one.of.clone()).collect();
        let stretch = compute(py, threads, || Ok(self.0.run(all)))?;
        let table = table(py, &self.0.places(), &stretch.estimates)?;
        match stretch.stopped {
            Some(error) if !error.is_loss_of_track() => {
                let refused = PyErr::from(error);
                refused.value(py).setattr("table", table)?;
                Err(refused)
            }
            stopped => Ok((table, stopped.map(|e| e.to_string()))),
        }
    }

    /// What is known of an arm at `time_s`, between frames; draws nothing and changes nothing. Raises `InputError`.
    fn estimate(&self, py: Python<'_>, time_s: f64) -> PyResult<Estimate> {
        let of = compute(py, None, || self.0.estimate(time_s))?;
        Ok(self.named(of))
    }

    /// Frames so far, each given those about it: an iterator of dicts of arrays as of `run`, as many rows as are smoothed
    /// together; of none where the method does not smooth. It raises `TrackingError` where no trajectory is found.
    #[pyo3(signature = (*, threads = None))]
    fn smoothed(slf: Py<Self>, threads: Option<usize>) -> Smoothing {
        Smoothing { tracker: slf, threads, of: smoothing::Smoothing::default() }
    }

    /// Where states `(N, D)` put the joints: by name, world, m `(N, 3)`; an arm's forearm as at the last frame; a body's with
    /// what is not seen or without it (see `particles`). Raises `InputError`.
    fn pose<'py>(&self, py: Python<'py>, states: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyDict>> {
        let view = states.as_array();
        let given = view.as_slice().map_or_else(|| view.iter().copied().collect(), Cow::Borrowed);
        let places = compute(py, None, || self.0.pose(&ParticleSet::from_rows(view.ncols(), &given)?))?;
        let out = PyDict::new(py);
        for (p, name) in self.0.places().into_iter().enumerate() {
            let mut points = vec![0.0; 3 * places.len()];
            let mut rest = points.chunks_exact_mut(3);
            for block in places.blocks() {
                let [x, y, z] = block.columns::<3>(3 * p);
                (0..block.len()).zip(&mut rest).for_each(|(i, point)| point.copy_from_slice(&[x[i], y[i], z[i]]));
            }
            out.set_item(name, PyArray1::from_vec(py, points).reshape([places.len(), 3])?)?;
        }
        Ok(out)
    }

    /// Whole poses `(T, C)`, m and rad, of a body's states `(T, D)`, its free channels. Raises `InputError`.
    fn channels<'py>(
        &self,
        py: Python<'py>,
        states: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let Subject::Body(body) = self.0.subject() else { return Err(Error::Foreign { what: "pose" }.into()) };
        let (figure, states) = (body.figure(), states.as_array());
        if states.ncols() != figure.model.dim() {
            let (got, expected) = (states.ncols(), figure.model.dim());
            return Err(Error::Size { name: "states", got, unit: "columns", expected }.into());
        }
        let poses =
            guarded(|| Ok(states.rows().into_iter().map(|state| figure.pose(&state.to_vec())).collect::<Vec<_>>()))?;
        Ok(PyArray2::from_vec2(py, &poses)?)
    }

    /// The particles as they stand, `(N, D)`; `None` for a Gaussian method. A body's have its free channels and then, where the
    /// method has it, a draw of what the camera does not see: distance, m, lean and turn, rad.
    #[getter]
    fn particles<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let Some(set) = self.0.particles() else { return Ok(None) };
        Ok(Some(PyArray1::from_vec(py, set.rows()).reshape([set.len(), set.dim()])?))
    }

    /// Their normalised weights, `(N,)`; `None` for a Gaussian method.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0.particles().map(|set| set.weights().to_pyarray(py))
    }

    /// The whole tracker as bytes, for `restore` by the same version. Raises `InputError` while observations wait.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &guarded(|| self.0.save())?))
    }

    /// A tracker from what `save` gave. Raises `InputError`.
    #[staticmethod]
    fn restore(state: &[u8]) -> PyResult<Self> {
        Ok(Self(guarded(|| tracker::Tracker::restore(state))?))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((py.get_type::<Self>().getattr("restore")?, (self.save(py)?,)))
    }
}

impl Tracker {
    fn named(&self, of: estimate::Estimate) -> Estimate {
        Estimate { of, names: self.0.places() }
    }
}
