//! One pose of a sub-model, and how its points move with the state: geometric Jacobians.
//!
//! A point turns about the axis of every joint that it hangs on, as that axis lies in this pose (Siciliano et al., "Robotics:
//! Modelling, Planning and Control", 2009, ch. 3.1).

use super::segment::{Segment, Source, Turn};
use nalgebra::{Matrix3, Matrix3xX, Vector3};

/// How what hangs on a segment moves with a column of the state.
#[derive(Debug, Clone, Copy)]
enum Motion {
    /// Along, m for a unit.
    Shift(Vector3<f64>),
    /// About an axis through the segment's origin.
    Turn(Vector3<f64>),
}

/// A segment in the world.
#[derive(Debug, Clone)]
struct Frame {
    rotation: Matrix3<f64>,
    origin: Vector3<f64>,
    /// With which columns it moves, beyond its parent.
    motions: Vec<(usize, Motion)>,
}

/// A sub-model posed by one state.
#[derive(Debug, Clone)]
pub(super) struct PosedModel<'a> {
    segments: &'a [Segment],
    /// Segment, and place in its frame.
    points: &'a [(usize, Vector3<f64>)],
    frames: Vec<Frame>,
    dim: usize,
}

impl<'a> PosedModel<'a> {
    /// By a state `(D,)`.
    pub fn new(segments: &'a [Segment], points: &'a [(usize, Vector3<f64>)], state: &[f64]) -> Self {
        let mut frames: Vec<Frame> = Vec::with_capacity(segments.len());
        for segment in segments {
            let (within, from) = segment.parent.map_or((Matrix3::identity(), Vector3::zeros()), |parent| {
                (frames[parent].rotation, frames[parent].origin)
            });
            let mut motions = Vec::new();
            let origin = Vector3::from_fn(|d, _| match segment.origin[d] {
                Source::Fixed(x) => x,
                Source::Free(column) => {
                    motions.push((column, Motion::Shift(within.column(d).into())));
                    state[column]
                }
            });
            let mut rotation = segment.frame.map_or(within, |frame| within * frame);
            for (axis, turn) in &segment.turns {
                let (sin, cos) = match turn {
                    Turn::Fixed(sin, cos) => (*sin, *cos),
                    Turn::Free(column) => {
                        motions.push((*column, Motion::Turn(rotation.column(*axis).into())));
                        state[*column].sin_cos()
                    }
                };
                turn_about(&mut rotation, *axis, sin, cos);
            }
            frames.push(Frame { rotation, origin: from + within * origin, motions });
        }
        Self { segments, points, frames, dim: state.len() }
    }

    /// Where a point is: world, m.
    pub fn at(&self, point: usize) -> Vector3<f64> {
        let (segment, place) = &self.points[point];
        self.frames[*segment].origin + self.frames[*segment].rotation * place
    }

    /// How it moves with the state, `(3, D)`.
    pub fn slope(&self, point: usize) -> Matrix3xX<f64> {
        let mut slope = Matrix3xX::zeros(self.dim);
        let at = self.at(point);
        let mut next = Some(self.points[point].0);
        while let Some(s) = next {
            let Frame { origin, motions, .. } = &self.frames[s];
            for (column, motion) in motions {
                slope.column_mut(*column).copy_from(&match motion {
                    Motion::Shift(along) => *along,
                    Motion::Turn(axis) => axis.cross(&(at - origin)),
                });
            }
            next = self.segments[s].parent;
        }
        slope
    }
}

/// A rotation after a turn about one of its own axes.
fn turn_about(rotation: &mut Matrix3<f64>, axis: usize, sin: f64, cos: f64) {
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let (first, second): (Vector3<f64>, Vector3<f64>) = (rotation.column(j).into(), rotation.column(k).into());
    rotation.set_column(j, &(first * cos + second * sin));
    rotation.set_column(k, &(second * cos - first * sin));
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Unit};

    #[test]
    fn a_turn_is_a_rotation_about_its_axis() {
        for axis in 0..3 {
            let about = Unit::new_normalize(Vector3::ith(axis, 1.0));
            let before = *Rotation3::from_euler_angles(0.3, -1.1, 2.0).matrix();
            let mut turned = before;
            turn_about(&mut turned, axis, 0.7f64.sin(), 0.7f64.cos());
            let expected = before * Rotation3::from_axis_angle(&about, 0.7).matrix();
            assert!((turned - expected).amax() < 1e-15);
        }
    }
}
