//! The body's work at 300 particles: kinematics, the edge cue, a whole frame. `cargo bench --bench body`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Matrix3, Vector3};
use pytracker::body::edges::{EdgeImage, rectangle};
use pytracker::body::model::{Place, SubModel};
use pytracker::particles::ParticleSet;
use pytracker::projection::Projected;
use pytracker::skeleton::{Bone, Channel, Skeleton};
use std::hint::black_box;

const LEN: usize = 256;

/// Trunk and two arms with the paper's eleven channels.
fn upper_body() -> (Skeleton, Vec<usize>) {
    let all = [0, 1, 2].map(Channel::Rotation).to_vec();
    let root = [[0, 1, 2].map(Channel::Translation).to_vec(), all.clone()].concat();
    // As in CMU's files: an arm's bones share a frame, those of the trunk stand straight.
    let arm_frame = |side: f64| *nalgebra::Rotation3::from_euler_angles(3.1, 0.5 * side, -1.57).matrix();
    let bone = |name: &str, parent, reach: [f64; 3], channels: &[Channel]| Bone {
        name: name.into(),
        parent,
        reach: Vector3::from(reach),
        frame: if name.starts_with(['h', 'r']) && parent.is_some() {
            arm_frame(reach[0].signum())
        } else {
            Matrix3::identity()
        },
        order: [0, 1, 2],
        channels: channels.to_vec(),
    };
    let mut bones = vec![bone("root", None, [0.0; 3], &root), bone("thorax", Some(0), [0.0, 0.4, 0.0], &all)];
    for side in [1.0, -1.0] {
        let thorax = 1;
        bones.push(bone(&format!("clavicle{side}"), Some(thorax), [0.18 * side, 0.08, 0.0], &[]));
        bones.push(bone(&format!("humerus{side}"), Some(bones.len() - 1), [0.3 * side, 0.0, 0.0], &all));
        bones.push(bone(&format!("radius{side}"), Some(bones.len() - 1), [0.25 * side, 0.0, 0.0], &all[..1]));
    }
    let skeleton = Skeleton::new(bones).expect("a skeleton");
    (skeleton, vec![0, 1, 5, 9, 10, 11, 12, 13, 14, 15, 16])
}

fn kinematics(c: &mut Criterion) {
    let (skeleton, free) = upper_body();
    let pose = vec![0.1; skeleton.channels().count()];
    let places: Vec<Place> = (0..skeleton.bones().len())
        .flat_map(|bone| [0.0, 1.0].map(|along| Place { bone, along, aside: Vector3::zeros() }))
        .collect();
    let model = SubModel::new(&skeleton, &pose, &free, &places, None).expect("a model");
    let rows: Vec<f64> = (0..LEN * model.dim()).map(|i| (i as f64 * 0.37).sin()).collect();
    let set = ParticleSet::from_rows(model.dim(), &rows).expect("particles");
    let mut out = vec![0.0; model.len() * 3 * LEN];
    let mut group = c.benchmark_group("kinematics");
    group.throughput(Throughput::Elements(LEN as u64));
    group.bench_function("11 DOF", |b| {
        b.iter(|| model.points(black_box(set.blocks().next().expect("a block")), 0, LEN, &mut out));
    });
    group.finish();
}

fn edge_cue(c: &mut Criterion) {
    let bytes: Vec<u8> = (0..320 * 240_u32).map(|i| u8::from(i % 7 == 0)).collect();
    let image = EdgeImage::new(320, 240, &bytes).expect("an image");
    let seen = |u: f64, v: f64| Projected { u, v, px_per_m: 139.0 };
    let outlines: Vec<_> = (0..300 * 6)
        .map(|i| {
            let turn = f64::from(i) * 0.7;
            rectangle(seen(160.0, 120.0), seen(160.0 + 65.0 * turn.cos(), 120.0 + 65.0 * turn.sin()), [0.07, 0.07])
        })
        .collect();
    let mut out = vec![0.0; outlines.len()];
    let mut group = c.benchmark_group("edges");
    group.throughput(Throughput::Elements(300));
    group.bench_function("six outlines a particle", |b| {
        b.iter(|| image.missed_all(black_box(&outlines), &mut out));
    });
    group.finish();
}

criterion_group!(benches, kinematics, edge_cue);
criterion_main!(benches);
