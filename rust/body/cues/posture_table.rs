//! How people hold their arms: numbers learned by `tests/learn_posture.py`, which writes this file.
//!
//! From captured motion of seven people who walk, dance, exercise and balance: CMU motion capture (mocap.cs.cmu.edu,
//! created with funding from NSF EIA-0196217) and HDM05 (Müller et al. 2007).

/// A Gaussian over directions of upper arm and forearm, outwards, up, forward each.
pub struct Component {
    /// Log of its share and scale, beside the density of any two directions.
    pub log_weight: f64,
    /// Its middle.
    pub mean: [f64; 6],
    /// Inverse of the lower factor of its covariance, row by row.
    pub whitening: [[f64; 6]; 6],
}

/// The heaviest first.
pub const COMPONENTS: [Component; 4] = [
    Component {
        log_weight: 3.416,
        mean: [0.396, -0.732, -0.115, 0.291, -0.411, 0.448],
        whitening: [
            [1.884, 0.000, 0.000, 0.000, 0.000, 0.000],
            [-0.684, 2.111, 0.000, 0.000, 0.000, 0.000],
            [-0.093, -0.174, 2.064, 0.000, 0.000, 0.000],
            [-0.578, -0.260, 0.164, 1.745, 0.000, 0.000],
            [-0.615, -0.561, -0.257, -0.048, 1.784, 0.000],
            [0.088, 0.049, -0.136, 0.428, -0.274, 2.109],
        ],
    },
    Component {
        log_weight: 1.213,
        mean: [0.640, -0.152, 0.352, 0.023, 0.748, 0.314],
        whitening: [
            [1.991, 0.000, 0.000, 0.000, 0.000, 0.000],
            [-0.551, 1.729, 0.000, 0.000, 0.000, 0.000],
            [0.563, 0.326, 1.923, 0.000, 0.000, 0.000],
            [-0.120, -0.189, -0.036, 1.842, 0.000, 0.000],
            [0.205, -0.138, -0.123, 0.083, 2.126, 0.000],
            [-0.425, 0.093, 0.336, 0.040, 0.483, 1.986],
        ],
    },
    Component {
        log_weight: -0.297,
        mean: [0.719, -0.071, 0.262, 0.055, 0.707, 0.394],
        whitening: [
            [2.110, 0.000, 0.000, 0.000, 0.000, 0.000],
            [-0.472, 1.696, 0.000, 0.000, 0.000, 0.000],
            [0.477, 0.294, 1.916, 0.000, 0.000, 0.000],
            [-0.110, -0.191, -0.083, 1.775, 0.000, 0.000],
            [0.161, -0.215, -0.080, 0.111, 2.091, 0.000],
            [-0.319, 0.148, 0.229, 0.068, 0.462, 2.042],
        ],
    },
    Component {
        log_weight: -1.215,
        mean: [0.530, -0.547, 0.002, 0.265, -0.101, 0.486],
        whitening: [
            [1.883, 0.000, 0.000, 0.000, 0.000, 0.000],
            [-0.764, 1.854, 0.000, 0.000, 0.000, 0.000],
            [-0.083, -0.258, 1.921, 0.000, 0.000, 0.000],
            [-0.423, -0.103, 0.243, 1.647, 0.000, 0.000],
            [-0.604, -0.703, -0.368, 0.122, 1.661, 0.000],
            [0.017, 0.098, -0.153, 0.362, -0.128, 2.082],
        ],
    },
];
