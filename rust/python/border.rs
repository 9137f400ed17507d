//! The border to Python: work without the interpreter's lock, on so many threads, and no panic across it.

use crate::error::{guarded, require};
use crate::{Error, Result};
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// No laptop has more; each costs a stack.
const MOST_THREADS: usize = 256;

/// Whether this process was forked from one that had loaded this module.
static FORKED: AtomicBool = AtomicBool::new(false);

/// What a forked process does first.
#[pyfunction]
fn forked() {
    FORKED.store(true, Ordering::Relaxed);
}

/// Hear of every fork: to ask the system at each call which process this is would cost more than an IMU sample does.
pub fn hear_of_forks(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let os = module.py().import("os")?;
    // Not every system forks.
    let Ok(register) = os.getattr("register_at_fork") else { return Ok(()) };
    let hook = wrap_pyfunction!(forked, module)?;
    register.call((), Some(&[("after_in_child", hook)].into_py_dict(module.py())?)).map(|_| ())
}

/// Do `work` without the interpreter's lock, on `threads` threads, on as many as there are where none are said.
///
/// A panic becomes [`Error::Internal`].
pub fn compute<R: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    work: impl FnOnce() -> Result<R> + Send,
) -> PyResult<R> {
    Ok(py.detach(|| guarded(|| on_threads(threads, work)))?)
}

fn on_threads<R: Send>(threads: Option<usize>, work: impl FnOnce() -> Result<R> + Send) -> Result<R> {
    if let Some(count) = threads {
        require((1..=MOST_THREADS).contains(&count), "threads", count as f64, "1 to 256")?;
        return pool(count)?.install(work);
    }
    // A forked process has the parent's pool without its threads: waiting for them would never end.
    if FORKED.load(Ordering::Relaxed) { pool_of_child()?.install(work) } else { work() }
}

/// The only thread of a forked process, made once; its siblings use the other processors.
fn pool_of_child() -> Result<Arc<ThreadPool>> {
    static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let mut known = POOL.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    match &*known {
        Some((id, pool)) if *id == process::id() => Ok(Arc::clone(pool)),
        _ => {
            let made = Arc::new(pool(1)?);
            // The parent's handle is not dropped: that would wait for threads which are not here.
            std::mem::forget(known.replace((process::id(), Arc::clone(&made))));
            Ok(made)
        }
    }
}

fn pool(count: usize) -> Result<ThreadPool> {
    let refused =
        |_| Error::Parameter { name: "threads", value: count as f64, expected: "as many as the machine allows" };
    ThreadPoolBuilder::new().num_threads(count).build().map_err(refused)
}
