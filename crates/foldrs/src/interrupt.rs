//! Stopping long work from outside.
//!
//! ```
//! use foldrs::interrupt::{interruptible, Interrupt};
//! let interrupt = Interrupt::default();
//! let elsewhere = interrupt.clone(); // for another thread, which may call `elsewhere.request()`
//! let answer = interruptible(&interrupt, || 6 * 7);
//! assert_eq!(answer, Ok(42));
//! ```
//!
//! Stages that compute in parallel look at the request between any two of their tasks, each of which takes a few
//! milliseconds, and leave by unwinding: no stage carries a result that it never has, and none returns half of one.
//! The others (folding, sampling, comparing two pieces) are too short to be stopped.

use std::cell::RefCell;
use std::panic::{catch_unwind, resume_unwind, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

/// A request to stop, shared by whoever makes it and the work it is for.
#[derive(Debug, Clone, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Asks the work to stop.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether that was asked for.
    #[must_use]
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The work was stopped before it was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the work was interrupted")]
pub struct Interrupted;

thread_local! {
    /// What may stop the work this thread is at.
    static CURRENT: RefCell<Option<Interrupt>> = const { RefCell::new(None) };
}

/// Runs stages of this crate so that they can be stopped. Needs a program that unwinds (`panic = "unwind"`).
///
/// Work that itself waits for a thread pool, other than in a stage, should do so outside: what the waiting thread takes up
/// meanwhile would be stopped as well.
///
/// # Errors
/// [`Interrupted`] if the request came before the work was done.
pub fn interruptible<R>(interrupt: &Interrupt, work: impl FnOnce() -> R) -> Result<R, Interrupted> {
    let current = Some(interrupt.clone());
    // Whatever the work had in hand is dropped with it.
    catch_unwind(AssertUnwindSafe(|| checked(&current, work))).map_err(|payload| {
        match payload.downcast::<Interrupted>() {
            Ok(interrupted) => *interrupted,
            Err(other) => resume_unwind(other),
        }
    })
}

/// What may stop the work this thread is at, to be handed to the threads that share it.
pub(crate) fn current() -> Option<Interrupt> {
    CURRENT.with_borrow(Clone::clone)
}

/// Runs one task of the work that `interrupt` may stop, unless it did.
pub(crate) fn checked<R>(interrupt: &Option<Interrupt>, task: impl FnOnce() -> R) -> R {
    if interrupt.as_ref().is_some_and(Interrupt::is_requested) {
        resume_unwind(Box::new(Interrupted));
    }
    let _restored = Restored(CURRENT.replace(interrupt.clone()));
    task()
}

/// Has nothing stop what this thread is at until the guard is dropped.
#[cfg(feature = "parallel")]
pub(crate) fn set_aside() -> Restored {
    Restored(CURRENT.take())
}

/// Puts back what was current before, however a task ends.
pub(crate) struct Restored(Option<Interrupt>);

impl Drop for Restored {
    fn drop(&mut self) {
        CURRENT.set(self.0.take());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel;

    #[test]
    fn work_stops_between_two_tasks() {
        let interrupt = Interrupt::default();
        let tasks: Vec<u32> = (0..10_000).collect();
        let done = std::sync::atomic::AtomicU32::new(0);
        let outcome = interruptible(&interrupt, || {
            parallel::map(&tasks, |_| {
                done.fetch_add(1, Ordering::Relaxed);
                interrupt.request();
            })
        });
        assert_eq!(outcome, Err(Interrupted));
        assert!(done.into_inner() < 1000);
    }

    #[test]
    fn nested_tasks_stop_too_and_other_work_goes_on() {
        let interrupt = Interrupt::default();
        let outcome = interruptible(&interrupt, || {
            parallel::map(&[1, 2, 3], |_| {
                interrupt.request();
                parallel::map(&[4], |x| *x)
            })
        });
        assert_eq!(outcome, Err(Interrupted));
        assert_eq!(parallel::map(&[1, 2, 3], |x| 2 * x), [2, 4, 6]);
        assert_eq!(interruptible(&Interrupt::default(), || 1), Ok(1));
    }

    #[cfg(feature = "parallel")]
    #[test]
    fn work_that_a_waiting_thread_takes_up_goes_on() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let interrupt = Interrupt::default();
        let (told, heard) = std::sync::mpsc::channel();
        let outcome = pool.install(|| {
            interruptible(&interrupt, || {
                parallel::map(&[0, 1, 2, 3], |k| {
                    if *k == 0 {
                        // The only thread comes to it between two tasks, or when all are done.
                        let told = told.clone();
                        rayon::spawn(move || told.send(parallel::map(&[1, 2], |x| 2 * x)).unwrap());
                        interrupt.request();
                    }
                })
            })
        });
        assert_eq!(outcome, Err(Interrupted));
        assert_eq!(heard.recv().unwrap(), [2, 4]);
    }

    #[test]
    fn defects_are_not_taken_for_interruptions() {
        let caught =
            catch_unwind(|| interruptible(&Interrupt::default(), || resume_unwind(Box::new("defect"))));
        let payload = caught.map(|outcome: Result<(), _>| outcome.is_err());
        assert_eq!(payload.unwrap_err().downcast_ref(), Some(&"defect"));
    }
}
