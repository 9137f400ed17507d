//! Everything that can go wrong, one variant a cause, with the facts inside.

/// An error of the tracking mathematics.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A parameter is outside its range.
    #[error("{name} is {value}, expected {expected}")]
    Parameter {
        /// The parameter, as the caller names it.
        name: &'static str,
        /// What was given.
        value: f64,
        /// The permitted range in words.
        expected: &'static str,
    },
    /// A name is not one of those known.
    #[error("{what} '{name}' is not known, expected one of: {known}")]
    UnknownName {
        /// What kind of name.
        what: &'static str,
        /// What was given.
        name: String,
        /// The known names, comma-separated.
        known: &'static str,
    },
    /// An array has the wrong size.
    #[error("{name} has {got} {unit}, expected {expected}")]
    Size {
        /// The argument.
        name: &'static str,
        /// What was given.
        got: usize,
        /// What is counted: rows, columns, cameras.
        unit: &'static str,
        /// How many there should be.
        expected: usize,
    },
    /// A matrix that should be a camera's intrinsics, rotation or distortion is not.
    #[error("camera {part}: {reason}")]
    Camera {
        /// `matrix`, `rotation`, `translation_m` or `distortion`.
        part: &'static str,
        /// What is wrong, with the value and what was expected.
        reason: String,
    },
    /// A bone is missing, or is not what a skeleton's bone is.
    #[error("bone '{bone}' {reason}")]
    Skeleton {
        /// Its name.
        bone: String,
        /// What is wrong and what was expected.
        reason: String,
    },
    /// A value that must be finite is not.
    #[error("{name} at {time_s} s is {value}, expected a finite number that a sensor can give")]
    NotFinite {
        /// The quantity.
        name: &'static str,
        /// Recording time, s.
        time_s: f64,
        /// What was given.
        value: f64,
    },
    /// A quaternion is not of unit length.
    #[error("orientation at {time_s} s has norm {norm}, expected a unit quaternion (1 ± {tolerance})")]
    QuaternionNorm {
        /// Recording time, s.
        time_s: f64,
        /// Its norm.
        norm: f64,
        /// How far from 1 it may be.
        tolerance: f64,
    },
    /// A sample or frame is older than what the filter has already seen.
    #[error(
        "{what} at {time_s} s comes after {latest_s} s was reached, expected a later time (a tracker with delay_s waits)"
    )]
    Late {
        /// `IMU sample` or `frame`.
        what: &'static str,
        /// Its time, s.
        time_s: f64,
        /// The time already reached, s.
        latest_s: f64,
    },
    /// An observation came later than the tracker waits for.
    #[error("{what} at {time_s} s comes {late_s} s after a later one, expected at most delay_s = {delay_s} s after it")]
    TooLate {
        /// What it is.
        what: &'static str,
        /// Its time, s.
        time_s: f64,
        /// How much later than the newest one, s.
        late_s: f64,
        /// How long is waited, s.
        delay_s: f64,
    },
    /// A time that is no time of this stream.
    #[error(
        "{what} at {time_s} s comes more than {most_s} s after the last at {latest_s} s, expected of the same clock, in seconds; what is that far ahead is taken once another is too, if it is by less than a day"
    )]
    Ahead {
        /// What it is.
        what: &'static str,
        /// Its time, s.
        time_s: f64,
        /// The time already reached, s.
        latest_s: f64,
        /// How far ahead it may be, s.
        most_s: f64,
    },
    /// What this kind of subject does not take.
    #[error(
        "{what} is not what this tracker takes, expected IMU samples, patches, landmarks and the upper arm's orientations of an arm, pictures and orientations of a body"
    )]
    Foreign {
        /// What was given.
        what: &'static str,
    },
    /// A frame came before any IMU sample.
    #[error("frame at {time_s} s comes before the first IMU sample, expected at least one before it")]
    NoInertialSample {
        /// Its time, s.
        time_s: f64,
    },
    /// No particle explains the observation: every weight is zero.
    #[error(
        "all {particles} particle weights are zero at {time_s:.3} s (layer {layer}), expected at least one \
         particle that the observation allows"
    )]
    AllWeightsZero {
        /// Recording time, s.
        time_s: f64,
        /// The layer, from 0.
        layer: usize,
        /// How many particles.
        particles: usize,
    },
    /// The track was lost before.
    #[error(
        "update at {time_s} s after the track was lost at {lost_at_s} s, expected a new tracker or one saved before"
    )]
    Lost {
        /// Recording time, s.
        time_s: f64,
        /// When it was lost, s.
        lost_at_s: f64,
    },
    /// The estimate is no longer a number, or lies where the patch cannot be seen.
    #[error("the estimate at {time_s:.3} s is not finite or behind a camera that sees the patch: the track ran away")]
    RanAway {
        /// Recording time, s.
        time_s: f64,
    },
    /// For long the estimate has been what no arm can do, or nothing that was seen bears it out.
    #[error("{why}, for {lasted_s:.2} s up to {time_s:.3} s: the track ran away")]
    Implausible {
        /// Recording time, s.
        time_s: f64,
        /// What is wrong with it.
        why: &'static str,
        /// For how long, s.
        lasted_s: f64,
    },
    /// A matrix that must be invertible is not.
    #[error("innovation covariance is singular at {time_s:.3} s, expected a positive definite matrix")]
    Singular {
        /// Recording time, s.
        time_s: f64,
    },
    /// Any of the others, at a known observation of a recording.
    #[error("{what} {index}{of}: {source}")]
    At {
        /// `frame`, `IMU sample` or `orientation`.
        what: &'static str,
        /// Its number, from 0, among those of its source.
        index: usize,
        /// Of which source, in words, where there may be several; else empty.
        of: String,
        /// What went wrong there.
        source: Box<Error>,
    },
    /// Memory for so many particles is not to be had.
    #[error("{what}: no memory for {bytes} bytes, expected fewer")]
    Memory {
        /// What it was for.
        what: &'static str,
        /// How much was asked for.
        bytes: usize,
    },
    /// A fault of this crate: something was taken for granted that does not hold.
    #[error("internal error: {reason}; what it was done to must not be used again")]
    Internal {
        /// What the panic said.
        reason: String,
    },
    /// A tracker that cannot be saved now.
    #[error("the tracker cannot be saved while {count} observations or estimates wait, expected none: finish() first")]
    Waiting {
        /// How many.
        count: usize,
    },
    /// Saved state that cannot be read back.
    #[error("saved tracker state cannot be read: {reason}")]
    SavedState {
        /// What the decoder said.
        reason: String,
    },
}

impl Error {
    /// Whether the filter lost the track, as opposed to having been given something that it cannot use.
    pub fn is_loss_of_track(&self) -> bool {
        match self {
            Self::At { source, .. } => source.is_loss_of_track(),
            Self::AllWeightsZero { .. }
            | Self::Singular { .. }
            | Self::RanAway { .. }
            | Self::Implausible { .. }
            | Self::Internal { .. }
            | Self::Lost { .. } => true,
            _ => false,
        }
    }

    /// Whether it is of what came before at the very same time.
    pub(crate) fn is_repetition(&self) -> bool {
        match self {
            Self::At { source, .. } => source.is_repetition(),
            Self::Late { time_s, latest_s, .. } => time_s == latest_s,
            _ => false,
        }
    }
}

/// `work`, its panics as [`Error::Internal`]: none crosses the border of the crate.
#[cfg(any(test, feature = "python"))]
pub(crate) fn guarded<R>(work: impl FnOnce() -> crate::Result<R>) -> crate::Result<R> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let words = panic.downcast_ref::<&str>().map(ToString::to_string);
        let reason = words.or_else(|| panic.downcast_ref::<String>().cloned());
        Err(Error::Internal { reason: reason.unwrap_or_else(|| "no reason given".to_string()) })
    })
}

/// Room for `len` numbers, or [`Error::Memory`]: the allocator alone would end the process.
pub(crate) fn room(what: &'static str, len: usize) -> crate::Result<()> {
    let bytes = len.saturating_mul(size_of::<f64>());
    let mut probe: Vec<f64> = Vec::new();
    probe.try_reserve_exact(len).map_err(|_| Error::Memory { what, bytes })
}

/// Check that a time is one: seconds of any clock that counts from this or the last century.
pub(crate) fn require_time(name: &'static str, time_s: f64) -> crate::Result<()> {
    const MOST_S: f64 = 1e11;
    if time_s.abs() <= MOST_S { Ok(()) } else { Err(Error::NotFinite { name, time_s, value: time_s }) }
}

/// Check that `value` satisfies `ok`, or name the parameter and the range.
pub(crate) fn require(ok: bool, name: &'static str, value: f64, expected: &'static str) -> crate::Result<()> {
    if ok { Ok(()) } else { Err(Error::Parameter { name, value, expected }) }
}

/// No picture is larger, px.
pub(crate) const MOST_PX: f64 = 1e6;

/// Check that a picture may hold a pixel that was seen at `time_s`.
pub(crate) fn require_pixel(name: &'static str, time_s: f64, pixel: [f64; 2]) -> crate::Result<()> {
    match pixel.into_iter().find(|x| x.is_nan() || x.abs() > MOST_PX) {
        Some(value) => Err(Error::NotFinite { name, time_s, value }),
        None => Ok(()),
    }
}

/// Of several tries those that led to something; an error where none did.
///
/// # Errors
/// The first.
pub(crate) fn successes<T>(tries: Vec<crate::Result<T>>) -> crate::Result<Vec<T>> {
    let (good, bad): (Vec<_>, Vec<_>) = tries.into_iter().partition(Result::is_ok);
    match bad.into_iter().next() {
        Some(error) if good.is_empty() => error.map(|found| vec![found]),
        _ => good.into_iter().collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error() {
        let out_of_range = || Ok([1, 2, 3][std::hint::black_box(7)]);
        let error = guarded(out_of_range).unwrap_err();
        assert!(error.is_loss_of_track() && error.to_string().contains("index out of bounds"), "{error}");
        assert_eq!(guarded(|| Ok(3)), Ok(3));
    }

    #[test]
    fn what_cannot_be_held_is_refused() {
        assert!(room("numbers", 1000).is_ok());
        assert!(room("numbers", usize::MAX / 4).is_err());
    }

    #[test]
    fn one_success_is_enough() {
        let error = |value| Error::NotFinite { name: "pixel", time_s: 0.0, value };
        assert_eq!(successes(vec![Err(error(1e7)), Ok(1), Ok(2)]), Ok(vec![1, 2]));
        assert_eq!(successes::<u8>(vec![Err(error(1e7)), Err(error(1e8))]), Err(error(1e7)));
        assert_eq!(successes::<u8>(Vec::new()), Ok(Vec::new()));
    }
}
