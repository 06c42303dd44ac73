//! Long calls without the GIL, which Ctrl-C ends.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{channel, RecvTimeoutError};
use std::time::Duration;

use foldrs::interrupt::{interruptible, Interrupt, Interrupted};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

/// How often a waiting call looks for signals: well within the half second after which a program seems to hang.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Whether all long calls are to stop.
static STOPPED: AtomicBool = AtomicBool::new(false);

/// Makes long calls, running and to come, raise KeyboardInterrupt in every thread, or no longer.
#[pyfunction]
#[pyo3(signature = (stopped=true))]
pub(crate) fn stop_all(stopped: bool) {
    STOPPED.store(stopped, Ordering::Relaxed);
}

/// Runs stages of the crate in its pool while this thread waits without the GIL, and looks for signals.
pub(crate) fn run<R: Send>(py: Python<'_>, work: impl FnOnce() -> R + Send) -> PyResult<R> {
    let interrupt = Interrupt::default();
    let mut cause = None;
    let outcome = py.detach(|| {
        let (done, waiting) = channel();
        rayon::in_place_scope(|scope| {
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
    if STOPPED.load(Ordering::Relaxed) {
        return Some(PyKeyboardInterrupt::new_err(Interrupted.to_string()));
    }
    // Signals are handled by Python's main thread; for others this does nothing.
    Python::attach(|py| py.check_signals()).err()
}
