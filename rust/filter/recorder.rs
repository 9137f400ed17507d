//! What a filter did, for those who want to see it: clouds, weights and ancestors of every layer.

/// One layer of one cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerRecord {
    /// Cycles before this one.
    pub step: u64,
    /// Recording time, s.
    pub time_s: f64,
    /// Which island, from 0; 0 where there is one.
    pub island: usize,
    /// Which layer, from 0.
    pub layer: usize,
    /// The set after the transition, rows `(N, D)` flattened.
    pub predicted: Vec<f64>,
    /// Its normalised weights after the likelihoods, `(N,)`.
    pub weights: Vec<f64>,
    /// Whose copies make the set that the layer leaves, `(N,)`; `None` where it was not resampled.
    pub ancestors: Option<Vec<u32>>,
}

/// Receives every layer of every cycle.
pub trait Recorder: Send {
    /// Called after the layer's resampling.
    fn record(&mut self, record: LayerRecord);
}

/// Keeps all of it in memory.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct History {
    /// In the order in which it happened.
    pub layers: Vec<LayerRecord>,
}

impl Recorder for History {
    fn record(&mut self, record: LayerRecord) {
        self.layers.push(record);
    }
}
