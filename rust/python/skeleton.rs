//! `Skeleton`: forward kinematics.

use crate::error::guarded;
use crate::skeleton::{self, Bone, Channel};
use crate::{Error, Result};
use nalgebra::{Matrix3, Vector3};
use numpy::{PyArray1, PyArray3, PyArray4, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

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
pub struct Skeleton(pub skeleton::Skeleton);

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
    /// m, and how they are turned from the base pose `(T, B, 3, 3)`. Raises `InputError`.
    fn pose<'py>(&self, py: Python<'py>, poses: PyReadonlyArray2<'py, f64>) -> PyResult<Posed<'py>> {
        let (poses, bones) = (poses.as_array(), self.0.bones().len());
        let (mut starts, mut ends, mut rotations) = (Vec::new(), Vec::new(), Vec::new());
        for pose in poses.rows() {
            let posed = guarded(|| self.0.pose(&pose.to_vec()))?;
            starts.extend(posed.starts.iter().flatten().copied());
            ends.extend(posed.ends.iter().flatten().copied());
            // Row by row.
            rotations
                .extend(posed.rotations.iter().flat_map(|turn| turn.transpose().iter().copied().collect::<Vec<_>>()));
        }
        let shape = [poses.nrows(), bones, 3];
        let rotations = PyArray1::from_vec(py, rotations).reshape([poses.nrows(), bones, 3, 3])?;
        Ok((PyArray1::from_vec(py, starts).reshape(shape)?, PyArray1::from_vec(py, ends).reshape(shape)?, rotations))
    }

    /// A pose `(C,)`, metres and radians, in a world that `rotation` `(3, 3)` turns its own to. Raises `InputError` where the
    /// root lacks a channel, or for another number of values.
    fn turned(&self, pose: Vec<f64>, rotation: [[f64; 3]; 3]) -> PyResult<Vec<f64>> {
        Ok(guarded(|| {
            self.0.pose(&pose)?;
            let reason = "does not stand by itself, expected channels for place and turn, six in all".into();
            let root = self.0.root().ok_or(Error::Skeleton { bone: self.0.bones()[0].name.clone(), reason })?;
            Ok(root.turned(&pose, &Matrix3::from_fn(|r, c| rotation[r][c])))
        })?)
    }
}

type Posed<'py> = (Bound<'py, PyArray3<f64>>, Bound<'py, PyArray3<f64>>, Bound<'py, PyArray4<f64>>);
