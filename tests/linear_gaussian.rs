//! The filters against the Kalman answer on a linear-Gaussian model: particles nearly, one Gaussian to rounding.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use pytracker::Error;
use pytracker::filter::{
    Blend, Gaussian, History, Layer, LayeredFilter, Likelihood, Mixture, Resampling, Transition, backward,
};
use pytracker::particles::{BlockMut, ParticleSet};
use pytracker::resample::Scheme;
use pytracker::rng::{Stream, Streams};
use rand::RngExt;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

const DT: f64 = 0.1;
const WALK: f64 = 0.3;
const SENSOR: f64 = 0.2;

/// Position and velocity; the velocity walks.
struct Motion;

impl Transition for Motion {
    fn propagate(&self, mut block: BlockMut<'_>, rng: &mut Stream) {
        let [x, v] = block.columns_mut([0, 1]);
        for i in 0..x.len() {
            let z: f64 = rng.sample(StandardNormal);
            x[i] += DT * v[i];
            v[i] += WALK * z;
        }
    }

    fn log_densities(&self, from: &[f64], to: &[f64], out: &mut [f64]) {
        for (out, from) in out.iter_mut().zip(from.chunks(2)) {
            let z = (to[1] - from[1]) / WALK;
            let is_there = (to[0] - from[0] - DT * from[1]).abs() < 1e-12;
            *out = if is_there { -0.5 * (z * z + (TAU * WALK * WALK).ln()) } else { f64::NEG_INFINITY };
        }
    }
}

struct Position(f64);

impl Likelihood for Position {
    fn log_likelihood(&self, particles: &ParticleSet, out: &mut [f64]) {
        particles.map_blocks(out, |block, out| {
            for (o, x) in out.iter_mut().zip(block.column(0)) {
                let z = (self.0 - x) / SENSOR;
                *o = -0.5 * (z * z + (TAU * SENSOR * SENSOR).ln());
            }
        });
    }
}

/// Moves nothing: the transition of a layer that only weighs.
struct Still;

impl Transition for Still {
    fn propagate(&self, _: BlockMut<'_>, _: &mut Stream) {}

    fn log_densities(&self, from: &[f64], to: &[f64], out: &mut [f64]) {
        for (out, from) in out.iter_mut().zip(from.chunks(to.len())) {
            *out = if from == to { 0.0 } else { f64::NEG_INFINITY };
        }
    }
}

fn start(len: usize, seed: u64) -> ParticleSet {
    let mut set = ParticleSet::new(len, 2).unwrap();
    let streams = Streams::new(seed, u64::MAX, 0);
    set.for_each_block(|b, mut block| {
        let mut rng = streams.block(b);
        for d in 0..2 {
            block.column_mut(d).iter_mut().for_each(|x| *x = rng.sample(StandardNormal));
        }
    });
    set
}

fn observations() -> Vec<f64> {
    (0..25).map(|k| 0.5 * (0.15 * f64::from(k)).sin() + 0.1 * f64::from(k % 3)).collect()
}

/// A position seen, by the textbook: gain, Joseph's form, the density of the innovation.
fn corrected(state: &mut Gaussian, z: f64) -> f64 {
    let variance = state.covariance[(0, 0)] + SENSOR * SENSOR;
    let gain = state.covariance.column(0) / variance;
    let innovation = z - state.mean[0];
    state.mean += &gain * innovation;
    let keep = DMatrix::identity(2, 2) - &gain * DMatrix::from_row_slice(1, 2, &[1.0, 0.0]);
    state.covariance = &keep * &state.covariance * keep.transpose() + &gain * gain.transpose() * (SENSOR * SENSOR);
    -0.5 * (innovation * innovation / variance + (TAU * variance).ln())
}

/// Means, variances and evidence of the exact answer.
fn kalman() -> Vec<(DVector<f64>, DMatrix<f64>, f64)> {
    let transition = DMatrix::from_iterator(2, 2, Matrix2::new(1.0, DT, 0.0, 1.0).iter().copied());
    let noise = DMatrix::from_diagonal(&DVector::from_column_slice(Vector2::new(0.0, WALK * WALK).as_slice()));
    let mut state = Gaussian { mean: DVector::zeros(2), covariance: DMatrix::identity(2, 2) };
    observations()
        .iter()
        .map(|z| {
            state.predict(&transition, &DVector::zeros(2), &noise);
            let evidence = corrected(&mut state, *z);
            (state.mean.clone(), state.covariance.clone(), evidence)
        })
        .collect()
}

/// A mixture of one component, which nothing splits, is the Kalman filter, however often it is linearised.
#[test]
fn a_mixture_of_one_is_kalman() {
    let transition = DMatrix::from_row_slice(2, 2, &[1.0, DT, 0.0, 1.0]);
    let noise = DMatrix::from_diagonal(&DVector::from_vec(vec![0.0, WALK * WALK]));
    for times in [1, 3] {
        let mut mixture = Mixture::new(Gaussian { mean: DVector::zeros(2), covariance: DMatrix::identity(2, 2) });
        for (z, (mean, covariance, evidence)) in observations().iter().zip(kalman()) {
            mixture.for_each(|gaussian| gaussian.predict(&transition, &DVector::zeros(2), &noise));
            let seen = |at: &DVector<f64>, _: &DMatrix<f64>| {
                let slope = DMatrix::from_row_slice(1, 2, &[1.0, 0.0]);
                Ok(Some((DVector::from_element(1, z - at[0]), slope, DMatrix::from_element(1, 1, SENSOR * SENSOR))))
            };
            let found = mixture.correct(0.0, times, seen).unwrap().unwrap();
            let (its_mean, its_covariance) = mixture.moments();
            assert!((its_mean - mean).amax() < 1e-13 && (its_covariance - covariance).amax() < 1e-13);
            assert!((found - evidence).abs() < 1e-12, "{found} is not {evidence}");
        }
    }
}

/// Mean squared distance of the filter's means from Kalman's, over seeds.
fn distance(len: usize, scheme: Scheme, threshold: f64) -> f64 {
    let exact = kalman();
    let seeds = 6;
    let mut sum = 0.0;
    for seed in 0..seeds {
        let mut filter = LayeredFilter::new(start(len, seed), Resampling::new(scheme, threshold).unwrap(), seed);
        for (z, (mean, _, _)) in observations().iter().zip(&exact) {
            let position = Position(*z);
            let layers = [Layer { transition: &Motion, likelihoods: vec![&position], blend: Blend::PRODUCT }];
            let estimate = filter.cycle(0.0, &layers, None, |set, _| set.moments().0).unwrap();
            sum += (estimate - mean).norm_squared();
        }
    }
    sum / (f64::from(u32::try_from(seeds).unwrap()) * exact.len() as f64)
}

/// The error falls as 1/N: a hundred times the particles, about a hundredth of the squared error.
#[test]
fn converges_to_kalman_as_particles_grow() {
    for scheme in [Scheme::Residual, Scheme::Systematic, Scheme::Stratified, Scheme::Multinomial] {
        let (few, many) = (distance(300, scheme, 1.0), distance(30_000, scheme, 1.0));
        assert!(many < few / 30.0, "{scheme:?}: {few} -> {many}");
        assert!(many.sqrt() < 0.01, "{scheme:?}: {many}");
    }
    assert!(distance(30_000, Scheme::Residual, 0.5).sqrt() < 0.01, "with an ESS threshold");
}

#[test]
fn covariance_and_evidence_agree_with_kalman() {
    let exact = kalman();
    let mut filter = LayeredFilter::new(start(60_000, 1), Resampling::new(Scheme::Residual, 1.0).unwrap(), 1);
    for (z, (_, covariance, evidence)) in observations().iter().zip(&exact) {
        let position = Position(*z);
        let layers = [Layer { transition: &Motion, likelihoods: vec![&position], blend: Blend::PRODUCT }];
        let (spread, log_evidence) = filter.cycle(0.0, &layers, None, |set, e| (set.moments().1, e)).unwrap();
        assert!((spread - covariance).amax() < 0.05 * covariance.amax());
        assert!((log_evidence.unwrap() - evidence).abs() < 0.05);
    }
}

/// Weighing in a layer of its own, without moving or resampling before it, is weighing in one layer.
#[test]
fn a_list_of_layers_is_one_layer_where_nothing_moves_between() {
    let resampling = Resampling::new(Scheme::Systematic, 0.0).unwrap();
    let mut one = LayeredFilter::new(start(1000, 4), resampling, 4);
    let mut two = one.clone();
    let (a, b) = (Position(0.3), Position(0.1));
    let joint = [Layer { transition: &Motion, likelihoods: vec![&a, &b], blend: Blend::PRODUCT }];
    let apart = [
        Layer { transition: &Motion, likelihoods: vec![&a], blend: Blend::PRODUCT },
        Layer { transition: &Still, likelihoods: vec![&b], blend: Blend::PRODUCT },
    ];
    let together = one.cycle(0.0, &joint, None, |set, e| (set.moments().0, e.unwrap())).unwrap();
    let in_turn = two.cycle(0.0, &apart, None, |set, e| (set.moments().0, e.unwrap())).unwrap();
    assert!((together.0 - in_turn.0).norm() < 1e-12);
    assert!((together.1 - in_turn.1).abs() < 1e-12);
}

/// The recorder sees every layer, and its ancestors lead from each weighted cloud to the next.
#[test]
fn recorder_sees_clouds_weights_and_ancestors() {
    let mut filter = LayeredFilter::new(start(50, 2), Resampling::new(Scheme::Residual, 1.0).unwrap(), 2);
    let mut unseen = filter.clone();
    let mut history = History::default();
    let position = Position(0.4);
    let layers = [
        Layer { transition: &Motion, likelihoods: vec![&position], blend: Blend::PRODUCT },
        Layer { transition: &Still, likelihoods: vec![], blend: Blend::PRODUCT },
    ];
    filter.cycle(1.5, &layers, Some(&mut history), |_, _| ()).unwrap();
    unseen.cycle(1.5, &layers, None, |_, _| ()).unwrap();
    assert_eq!(filter, unseen, "looking changes nothing");
    let [first, second] = &history.layers[..] else { panic!("two layers") };
    assert_eq!((first.time_s, first.layer, second.layer), (1.5, 0, 1));
    assert!((first.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    let ancestors = first.ancestors.as_ref().unwrap();
    for (i, a) in ancestors.iter().enumerate() {
        assert_eq!(second.predicted[2 * i..2 * i + 2], first.predicted[2 * *a as usize..2 * *a as usize + 2]);
    }
    assert_eq!(second.ancestors, None, "a layer that weighs nothing does not resample");
}

/// A forward trajectory of the recorder has the density that the transitions say.
#[test]
fn log_density_is_that_of_the_draws() {
    let mut set = start(20_000, 3);
    let before = set.rows();
    let streams = Streams::new(3, 0, 0);
    set.for_each_block(|b, block| Motion.propagate(block, &mut streams.block(b)));
    let after = set.rows();
    let density = |from: &[f64], to: &[f64]| {
        let mut out = [0.0];
        Motion.log_densities(from, to, &mut out);
        out[0]
    };
    let mean = before.chunks(2).zip(after.chunks(2)).map(|(f, t)| density(f, t)).sum::<f64>() / 20_000.0;
    // The negative entropy of the normal.
    assert!((mean + 0.5 * (1.0 + (TAU * WALK * WALK).ln())).abs() < 0.02);
}

/// Position and velocity, both walk.
struct Free;

impl Transition for Free {
    fn propagate(&self, mut block: BlockMut<'_>, rng: &mut Stream) {
        let [x, v] = block.columns_mut([0, 1]);
        for i in 0..x.len() {
            let [a, b]: [f64; 2] = [rng.sample(StandardNormal), rng.sample(StandardNormal)];
            x[i] += DT * v[i] + DT * WALK * a;
            v[i] += WALK * b;
        }
    }

    fn log_densities(&self, from: &[f64], to: &[f64], out: &mut [f64]) {
        for (out, from) in out.iter_mut().zip(from.chunks(2)) {
            let (a, b) = ((to[0] - from[0] - DT * from[1]) / (DT * WALK), (to[1] - from[1]) / WALK);
            *out = -0.5 * (a * a + b * b);
        }
    }
}

const SEEN: [f64; 12] = [0.1, 0.25, 0.1, 0.4, 0.35, 0.6, 0.5, 0.9, 0.8, 0.7, 1.1, 1.0];

/// What a filter leaves of a recording.
fn history(motion: &dyn Transition, len: usize) -> History {
    let resampling = Resampling::new(Scheme::Systematic, 1.0).unwrap();
    let (mut filter, mut history) = (LayeredFilter::new(start(len, 8), resampling, 8), History::default());
    for (k, z) in SEEN.iter().enumerate() {
        let position = Position(*z);
        let layer = Layer { transition: motion, likelihoods: vec![&position], blend: Blend::PRODUCT };
        filter.cycle(0.1 * k as f64, &[layer], Some(&mut history), |_, _| ()).unwrap();
    }
    history
}

/// Backward simulation against Rauch, Tung and Striebel: the filter's own answer at the last time, a better one before.
#[test]
fn trajectories_are_smoothed() {
    let transition = DMatrix::from_row_slice(2, 2, &[1.0, DT, 0.0, 1.0]);
    let noise = DMatrix::from_diagonal(&DVector::from_vec(vec![(DT * WALK).powi(2), WALK * WALK]));
    let first = start(4000, 8);
    let (mean, covariance) = first.moments();
    let mut state = Gaussian { mean, covariance };
    let (mut predicted, mut filtered) = (Vec::new(), Vec::new());
    for z in &SEEN {
        state.predict(&transition, &DVector::zeros(2), &noise);
        predicted.push(state.clone());
        corrected(&mut state, *z);
        filtered.push(state.clone());
    }
    for k in (0..SEEN.len() - 1).rev() {
        let gain = &filtered[k].covariance
            * transition.transpose()
            * predicted[k + 1].covariance.clone().try_inverse().unwrap();
        let (mean, spread) = (
            &filtered[k + 1].mean - &predicted[k + 1].mean,
            &filtered[k + 1].covariance - &predicted[k + 1].covariance,
        );
        filtered[k].mean += &gain * mean;
        filtered[k].covariance += &gain * spread * gain.transpose();
    }
    let records = history(&Free, 4000).layers;
    let transitions = vec![&Free as &dyn Transition; records.len()];
    let found = backward(&records, &transitions, 600, 3).unwrap();
    assert!(found.forced < 0.01, "{}", found.forced);
    for (k, expected) in filtered.iter().enumerate() {
        for d in 0..2 {
            let values: Vec<f64> = found.trajectories.iter().map(|trajectory| trajectory[2 * k + d]).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let sd = (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
            let wanted = expected.covariance[(d, d)].sqrt();
            assert!((mean - expected.mean[d]).abs() < 0.25 * wanted, "{k} {d}: {mean} is not {}", expected.mean[d]);
            assert!((sd / wanted - 1.0).abs() < 0.2, "{k} {d}: {sd} is not {wanted}");
        }
    }
    assert_eq!(found, backward(&records, &transitions, 600, 3).unwrap());
}

/// Where the motion has no noise in some direction every state has one that led to it, and that is said.
#[test]
fn a_singular_motion_leaves_no_choice() {
    let records = history(&Motion, 300).layers;
    let transitions = vec![&Motion as &dyn Transition; records.len()];
    assert!(backward(&records, &transitions, 20, 3).unwrap().forced > 0.9);
    assert!(matches!(backward(&records, &transitions[1..], 20, 3), Err(Error::Size { name: "transitions", .. })));
    let other = vec![&Still as &dyn Transition; records.len()];
    assert!(matches!(backward(&records, &other, 20, 3), Err(Error::AllWeightsZero { .. })));
}
