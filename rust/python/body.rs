//! `BodyTracker`: the online tracker of the body; `Skeleton`: forward kinematics.

use super::border::compute;
use super::record::{LayerRecord, records};
use super::rows;
use crate::body::edges::EdgeImage;
use crate::body::{
    self, BodyEvidence, BodyLayer, BodyMethod, Diffusion, Figure, Group, KEY_JOINTS, Part, Region, Regions, Unseen,
    Weighing,
};
use crate::camera::Camera;
use crate::error::guarded;
use crate::filter::{History, Resampling};
use crate::particles::{ParticleSet, Summary};
use crate::projection::Projection;
use crate::resample::Scheme;
use crate::skeleton::{self, Bone, Channel};
use crate::{Error, Result};
use nalgebra::{Matrix3, Vector3};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// `pytracker.Bone`, read.
#[derive(FromPyObject)]
struct BoneArgument {
    name: String,
    parent: Option<usize>,
    reach_m: [f64; 3],
    frame: [[f64; 3]; 3],
    order: [usize; 3],
    channels: Vec<String>,
}

/// A skeleton: bones, the root first and parents before children (`pytracker.Bone`). Raises `InputError`.
#[pyclass(frozen, module = "pytracker._core")]
pub struct Skeleton(skeleton::Skeleton);

#[pymethods]
impl Skeleton {
    #[new]
    fn new(bones: Vec<BoneArgument>) -> PyResult<Self> {
        let bones = bones
            .into_iter()
            .map(|bone| {
                Ok(Bone {
                    name: bone.name,
                    parent: bone.parent,
                    reach: Vector3::from(bone.reach_m),
                    frame: Matrix3::from_fn(|r, c| bone.frame[r][c]),
                    order: bone.order,
                    channels: bone.channels.iter().map(|name| Channel::from_name(name)).collect::<Result<_>>()?,
                })
            })
            .collect::<Result<_>>()?;
        Ok(Self(guarded(|| skeleton::Skeleton::new(bones))?))
    }

    /// Forward kinematics of poses `(T, C)`, metres and radians: starts and ends of all bones, `(T, B, 3)` each, world,
    /// m. Raises `InputError`.
    fn pose<'py>(&self, py: Python<'py>, poses: PyReadonlyArray2<'py, f64>) -> PyResult<Pair<'py>> {
        let (poses, bones) = (poses.as_array(), self.0.bones().len());
        let (mut starts, mut ends) = (Vec::new(), Vec::new());
        for pose in poses.rows() {
            let posed = guarded(|| self.0.pose(&pose.to_vec()))?;
            starts.extend(posed.starts.iter().flatten().copied());
            ends.extend(posed.ends.iter().flatten().copied());
        }
        let shape = [poses.nrows(), bones, 3];
        Ok((PyArray1::from_vec(py, starts).reshape(shape)?, PyArray1::from_vec(py, ends).reshape(shape)?))
    }
}

type Pair<'py> = (Bound<'py, PyArray3<f64>>, Bound<'py, PyArray3<f64>>);

/// `pytracker.Part`, read.
#[derive(FromPyObject)]
struct PartArgument {
    start: (String, f64),
    end: (String, f64),
    half_width_m: [f64; 2],
}

/// A camera of the body: a weak-perspective matrix or a pinhole.
#[derive(FromPyObject)]
enum ProjectionArgument {
    #[pyo3(transparent)]
    Weak(WeakArgument),
    #[pyo3(transparent)]
    Pinhole(super::arm::CameraArgument),
}

#[derive(FromPyObject)]
struct WeakArgument {
    affine: [[f64; 4]; 2],
}

/// What every body method has, read.
#[derive(FromPyObject)]
struct MethodArgument {
    particles: usize,
    islands: usize,
    layers: Vec<(Vec<String>, f64, f64)>,
    resampling: String,
    ess_threshold: f64,
    base_density: f64,
    base_turn_density: f64,
    trunk_density: f64,
    joint_density: f64,
    blob_sd_m: f64,
    blob_reach: f64,
    gate_m: f64,
    anew_share: f64,
    limits: bool,
    penetration: bool,
    unseen_distance_sd_m: f64,
    unseen_lean_sd_rad: f64,
    unseen_turn_sd_rad: f64,
    skin_loss: f64,
    foreground_loss: f64,
    region_reach_m: f64,
}

/// What weighs, told apart by what it has.
#[derive(FromPyObject)]
enum WeighingArgument {
    Rescaled { sharpness: f64, alpha: f64, adapt: f64 },
    Fixed { edge_loss: f64 },
}

fn extract_projection(camera: &Bound<'_, PyAny>) -> PyResult<Projection> {
    Ok(match camera.extract()? {
        ProjectionArgument::Weak(weak) => Projection::weak(weak.affine)?,
        ProjectionArgument::Pinhole(camera) => Projection::Pinhole(Box::new(Camera::try_from(camera)?)),
    })
}

fn extract_method(method: &Bound<'_, PyAny>) -> PyResult<BodyMethod> {
    let m: MethodArgument = method.extract()?;
    let weighing = match method.extract()? {
        WeighingArgument::Rescaled { sharpness, alpha, adapt } => Weighing::Rescaled { base: sharpness, alpha, adapt },
        WeighingArgument::Fixed { edge_loss } => Weighing::Fixed { edge_loss },
    };
    let layer = |(groups, spread, sharpness): (Vec<String>, f64, f64)| {
        let groups = groups.iter().map(|group| Group::from_name(group)).collect::<Result<_>>()?;
        Ok(BodyLayer { groups, spread, sharpness })
    };
    let method = BodyMethod {
        len: m.particles,
        islands: m.islands,
        layers: m.layers.into_iter().map(layer).collect::<Result<_>>()?,
        resampling: Resampling::new(Scheme::from_name(&m.resampling)?, m.ess_threshold)?,
        diffusion: Diffusion {
            base: m.base_density,
            base_turn: m.base_turn_density,
            trunk: m.trunk_density,
            joint: m.joint_density,
        },
        anew_share: m.anew_share,
        weighing,
        blob_sd_m: m.blob_sd_m,
        blob_reach: m.blob_reach,
        gate_m: m.gate_m,
        limits: m.limits,
        penetration: m.penetration,
        regions: Regions { skin_loss: m.skin_loss, foreground_loss: m.foreground_loss, reach_m: m.region_reach_m },
        unseen: Unseen { distance_m: m.unseen_distance_sd_m, lean: m.unseen_lean_sd_rad, turn: m.unseen_turn_sd_rad },
    };
    method.check()?;
    Ok(method)
}

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

    /// Take a frame: time in s, edges `(H, W)` bytes (0 is none), centres of blobs `(B, 2)` px in no order; skin and
    /// foreground as regions, each a pair: distance of every pixel `(H, W)`, px, and some points `(P, 2)`, px. Raises
    /// `InputError`, or `TrackingError` when no particle explains what was seen. `threads` limits how many work on the
    /// particles; it does not change the result.
    #[pyo3(signature = (time_s, edges, blobs, skin = None, foreground = None, threads = None))]
    #[allow(clippy::too_many_arguments)] // one argument a sense; keywords in Python
    fn update(
        &mut self,
        py: Python<'_>,
        time_s: f64,
        edges: PyReadonlyArray2<'_, u8>,
        blobs: PyReadonlyArray2<'_, f64>,
        skin: Option<RegionArgument<'_>>,
        foreground: Option<RegionArgument<'_>>,
        threads: Option<usize>,
    ) -> PyResult<BodyEstimate> {
        let evidence = evidence(&edges, &blobs, skin, foreground)?;
        Ok(BodyEstimate(compute(py, threads, || self.0.update(time_s, &evidence))?))
    }

    /// The same, with what every layer did: same bits, more memory. Raises as `update`.
    #[pyo3(signature = (time_s, edges, blobs, skin = None, foreground = None))]
    fn update_recorded(
        &mut self,
        py: Python<'_>,
        time_s: f64,
        edges: PyReadonlyArray2<'_, u8>,
        blobs: PyReadonlyArray2<'_, f64>,
        skin: Option<RegionArgument<'_>>,
        foreground: Option<RegionArgument<'_>>,
    ) -> PyResult<(BodyEstimate, Vec<LayerRecord>)> {
        let evidence = evidence(&edges, &blobs, skin, foreground)?;
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

/// What a body tracker knows at one frame: key joints in the world, metres; the state in metres and radians.
#[pyclass(frozen, module = "pytracker._core")]
pub struct BodyEstimate(body::BodyEstimate);

/// Mean, mode, standard deviation, 2.5 % and 97.5 % quantile, `(5, K)`.
fn five<'py>(py: Python<'py>, summary: &Summary) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let k = summary.bands.len();
    let sd = (0..k).map(|d| summary.covariance[(d, d)].max(0.0).sqrt());
    let numbers = summary.mean.iter().take(k).copied().chain(summary.mode.iter().copied()).chain(sd);
    let bands = summary.bands.iter().map(|b| b.lo).chain(summary.bands.iter().map(|b| b.hi));
    PyArray1::from_iter(py, numbers.chain(bands)).reshape([5, k])
}

#[pymethods]
impl BodyEstimate {
    /// Recording time, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.0.time_s
    }

    /// Mean, mode, standard deviation, 2.5 % and 97.5 % quantile of the key joints, `(5, 8, 3)` m, in the order of
    /// `KEY_JOINTS`.
    #[getter]
    fn joints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        five(py, &self.0.joints)?.reshape([5, KEY_JOINTS.len(), 3])
    }

    /// The same of the state, `(5, D)`.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        five(py, &self.0.state)
    }

    /// Covariance of the state, `(D, D)`.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let c = &self.0.state.covariance;
        c.as_slice().to_pyarray(py).reshape([c.nrows(), c.ncols()])
    }

    /// The blob given to head, left hand and right hand, `(3, 2)` px; NaN where none was.
    #[getter]
    fn blobs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let numbers = self.0.blobs.iter().flat_map(|blob| blob.unwrap_or([f64::NAN; 2]));
        PyArray1::from_iter(py, numbers).reshape([3, 2])
    }

    /// Effective sample size.
    #[getter]
    fn ess(&self) -> f64 {
        self.0.ess
    }

    /// Log evidence of this frame; `None` where the weights are no likelihoods (`Plain`, `Annealed`).
    #[getter]
    fn log_evidence(&self) -> Option<f64> {
        self.0.log_evidence
    }

    fn __repr__(&self) -> String {
        format!("BodyEstimate(time_s={:.3}, ess={:.1})", self.0.time_s, self.0.ess)
    }
}

/// Distances `(H, W)` and points `(P, 2)` of a region.
type RegionArgument<'py> = (PyReadonlyArray2<'py, f32>, PyReadonlyArray2<'py, f64>);

fn evidence(
    edges: &PyReadonlyArray2<'_, u8>,
    blobs: &PyReadonlyArray2<'_, f64>,
    skin: Option<RegionArgument<'_>>,
    foreground: Option<RegionArgument<'_>>,
) -> PyResult<BodyEvidence> {
    let region = |(distance, points): RegionArgument<'_>| -> PyResult<Region> {
        let view = distance.as_array();
        let (height, width) = view.dim();
        Ok(Region::new(width, height, view.iter().copied().collect(), rows("points of a region", &points)?)?)
    };
    Ok(BodyEvidence {
        edges: image(edges)?,
        blobs: rows("blobs", blobs)?,
        skin: skin.map(region).transpose()?,
        foreground: foreground.map(region).transpose()?,
    })
}

/// Edges `(H, W)`, any strides.
fn image(edges: &PyReadonlyArray2<'_, u8>) -> Result<EdgeImage> {
    let view = edges.as_array();
    let (height, width) = view.dim();
    match view.as_slice() {
        Some(bytes) => EdgeImage::new(width, height, bytes),
        None => EdgeImage::new(width, height, &view.iter().copied().collect::<Vec<_>>()),
    }
}

/// Names of the key joints, in the order of every estimate.
pub fn key_joints() -> Vec<&'static str> {
    KEY_JOINTS.iter().map(|(name, _, _)| *name).collect()
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
