//! Long calls without the GIL, which Ctrl-C ends.

use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{channel, RecvTimeoutError};
use std::sync::Arc;
use std::time::Duration;

use crate::threads::pool;
use foldrs::interrupt::{interruptible, Interrupt, Interrupted};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

/// How often a waiting call looks for signals: well within the half second after which a program seems to hang.
const LOOK_EVERY: Duration = Duration::from_millis(50);

thread_local! {
    /// What this thread's long calls look at beside signals.
    static HEEDED: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// Ends the long calls of the threads that heed it.
#[pyclass(frozen, module = "foldrs._core")]
pub(crate) struct Stop(Arc<AtomicBool>);

#[pymethods]
impl Stop {
    #[new]
    fn new() -> Self {
        Self(Arc::default())
    }

    /// From now on the calling thread's long calls end when this is requested; of several the last one counts.
    fn heed(&self) {
        HEEDED.set(Some(self.0.clone()));
    }

    /// Makes long calls, running and to come, raise KeyboardInterrupt in every thread that heeds this.
    fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Runs stages of the crate in its pool while this thread waits without the GIL, and looks for signals.
pub(crate) fn run<R: Send>(py: Python<'_>, work: impl FnOnce() -> R + Send) -> PyResult<R> {
    let pool = pool()?;
    let interrupt = Interrupt::default();
    let mut cause = None;
    let outcome = py.detach(|| {
        let (done, waiting) = channel();
        pool.in_place_scope(|scope| {
            let interrupt = &interrupt;
            // Of a defect in the work no message comes: the scope passes its panic on.
            scope.spawn(move |_| drop(done.send(interruptible(interrupt, work))));
            loop {
                if !interrupt.is_requested() {
                    cause = reason_to_stop();
                    if cause.is_some() {
                        interrupt.request();
                    }
                }
                match waiting.recv_timeout(LOOK_EVERY) {
                    Ok(outcome) => return outcome,
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => return Err(Interrupted),
                }
            }
        })
    });
    match (outcome, cause) {
        // What a signal's handler raised must not be lost, though the work was done just then.
        (_, Some(raised)) => Err(raised),
        (outcome, None) => outcome.map_err(|stopped| PyKeyboardInterrupt::new_err(stopped.to_string())),
    }
}

fn reason_to_stop() -> Option<PyErr> {
    let stopped = HEEDED.with_borrow(|stop| stop.as_ref().is_some_and(|s| s.load(Ordering::Relaxed)));
    if stopped {
        return Some(PyKeyboardInterrupt::new_err(Interrupted.to_string()));
    }
    // Signals are handled by Python's main thread; for others this does nothing.
    Python::attach(|py| py.check_signals()).err()
}
