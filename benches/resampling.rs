//! The four resampling schemes at ten thousand particles. `cargo bench --bench resampling`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use pytracker::resample::{Ancestors, Scheme};
use pytracker::rng::Streams;
use std::hint::black_box;

const LEN: usize = 10_000;

fn schemes(c: &mut Criterion) {
    let raw: Vec<f64> = (0..LEN).map(|i| (-0.5 * (i as f64 / LEN as f64 * 6.0 - 3.0).powi(2)).exp()).collect();
    let sum: f64 = raw.iter().sum();
    let weights: Vec<f64> = raw.iter().map(|w| w / sum).collect();
    let mut group = c.benchmark_group("resample");
    group.throughput(Throughput::Elements(LEN as u64));
    for (name, scheme) in [
        ("multinomial", Scheme::Multinomial),
        ("stratified", Scheme::Stratified),
        ("systematic", Scheme::Systematic),
        ("residual", Scheme::Residual),
    ] {
        let (mut rng, mut ancestors) = (Streams::new(1, 0, 0).resampling(), Ancestors::default());
        group.bench_function(name, |b| b.iter(|| scheme.draw(black_box(&weights), LEN, &mut rng, &mut ancestors)));
    }
    group.finish();
}

criterion_group!(benches, schemes);
criterion_main!(benches);
