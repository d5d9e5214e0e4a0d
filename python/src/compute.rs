//! Long computations: apart from Python's lock, in a thread of their own while this one minds signals and shows progress.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bodyschema::deadline::{apart, end_all};
use bodyschema::session::{LearningStep, Observer, Phase};
use bodyschema::{Error as Fault, RecordedTouch};
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeWarning, PyUserWarning};
use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::errors::{Error, raised};

/// How often signals are minded.
const POLL: Duration = Duration::from_millis(50);
/// The stack of a computation, as large as a program's main thread has at least.
const STACK: usize = 32 << 20;

/// The process that loaded this module.
static LOADED_IN: AtomicU32 = AtomicU32::new(0);
/// Threads of a process that was forked from it, in which those of the pool do not exist.
static FORKED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Remembers in which process this is.
pub fn remember_process() {
    LOADED_IN.store(std::process::id(), Ordering::Relaxed);
}

/// How far a computation has come, and what a person should know of it.
#[derive(Default)]
pub struct Watcher {
    /// The current phase and its number of steps at most; 0 if unknown.
    phase: Mutex<(&'static str, usize)>,
    done: AtomicUsize,
    notes: Mutex<Vec<String>>,
    interrupted: AtomicBool,
}

impl Watcher {
    /// A phase of so many steps begins.
    pub fn begin(&self, phase: &'static str, steps: usize, done: usize) {
        *self.phase.lock().unwrap_or_else(PoisonError::into_inner) = (phase, steps);
        self.done.store(done, Ordering::Relaxed);
    }

    /// One more step is done; whether to go on.
    pub fn step(&self) -> bool {
        self.done.fetch_add(1, Ordering::Relaxed);
        !self.interrupted.load(Ordering::Relaxed)
    }
}

impl Observer for Watcher {
    fn note(&self, sentence: &str) {
        self.notes.lock().unwrap_or_else(PoisonError::into_inner).push(sentence.to_string());
    }

    fn phase(&self, phase: Phase) {
        match phase {
            Phase::Babbling { made, touches, .. } => self.begin("babbling", touches, made),
            Phase::Learning { touches, .. } => self.begin("learning", touches, 0),
            _ => self.begin("", 0, 0),
        }
    }

    fn touched(&self, _: &RecordedTouch) {
        self.step();
    }

    fn learned(&self, _: &LearningStep) {
        self.step();
    }
}

/// What came of a computation, and whether it was interrupted.
pub struct Computed<T> {
    pub result: T,
    pub interrupted: bool,
}

impl<T> Computed<T> {
    /// The result, with a warning if it is less than it would have been.
    pub fn kept(self, py: Python, what: &str) -> PyResult<T> {
        if self.interrupted {
            let sentence = format!("interrupted: {what}");
            PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text(&sentence), 1)?;
        }
        Ok(self.result)
    }

    /// The result, unless it was interrupted.
    pub fn whole(self) -> PyResult<T> {
        if self.interrupted { Err(PyKeyboardInterrupt::new_err(())) } else { Ok(self.result) }
    }
}

/// Computes in a thread. The first interruption ends the computation early with a partial result, the second one abandons it.
///
/// # Errors
/// If it fails, or is left.
pub fn compute<T: Send + 'static>(
    py: Python,
    work: impl FnOnce(&Watcher) -> Result<T, Fault> + Send + 'static,
) -> PyResult<Computed<T>> {
    let (watcher, (sender, mut receiver)) = (Arc::new(Watcher::default()), mpsc::channel());
    let own = watcher.clone();
    let begun = std::thread::Builder::new().name("bodyschema".into()).stack_size(STACK).spawn(move || {
        let result = catch_unwind(AssertUnwindSafe(|| on_threads(|| apart(|| work(&own)).0)));
        if own.interrupted.load(Ordering::Relaxed) {
            end_all(false);
        }
        let _ = sender.send(result);
    });
    begun.map_err(|error| Error::new_err(format!("no thread can be begun ({error}): end other programs")))?;
    let progress = py.import("bodyschema._progress")?.getattr("Progress")?.call0()?;
    let result = loop {
        let (received, back) = py.detach(move || (receiver.recv_timeout(POLL), receiver));
        receiver = back;
        match received {
            Ok(result) => break result,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Error::new_err("a computation ended without a result"));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        if let Err(interruption) = py.check_signals() {
            let again = watcher.interrupted.swap(true, Ordering::Relaxed);
            end_all(true);
            if again || !interruption.is_instance_of::<PyKeyboardInterrupt>(py) {
                return Err(interruption);
            }
        }
        let (phase, steps) = *watcher.phase.lock().unwrap_or_else(PoisonError::into_inner);
        progress.call_method1("show", (phase, watcher.done.load(Ordering::Relaxed), steps))?;
    };
    progress.call_method0("close")?;
    let notes = std::mem::take(&mut *watcher.notes.lock().unwrap_or_else(PoisonError::into_inner));
    notes.iter().try_for_each(|note| warn(py, note))?;
    let interrupted = watcher.interrupted.load(Ordering::Relaxed);
    match result {
        Ok(Ok(result)) => Ok(Computed { result, interrupted }),
        Ok(Err(_)) if interrupted => Err(PyKeyboardInterrupt::new_err(())),
        Ok(Err(fault)) => Err(raised(fault)),
        Err(panic) => {
            let words = panic.downcast_ref::<String>().map(String::as_str);
            let words =
                words.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason is known");
            Err(Error::new_err(format!("a fault of bodyschema itself ({words}): please report it")))
        }
    }
}

/// Runs something on the threads of this process.
pub fn on_threads<T: Send>(run: impl FnOnce() -> T + Send) -> T {
    let process = std::process::id();
    if process == LOADED_IN.load(Ordering::Relaxed) {
        return run();
    }
    let mut forked = FORKED.lock().unwrap_or_else(PoisonError::into_inner);
    if forked.as_ref().is_none_or(|(of, _)| *of != process) {
        // A pool of the process before has no threads here to wait for.
        std::mem::forget(forked.take());
        *forked = rayon::ThreadPoolBuilder::new().build().ok().map(|pool| (process, Arc::new(pool)));
    }
    let pool = forked.as_ref().map(|(_, pool)| pool.clone());
    drop(forked);
    match pool {
        Some(pool) => pool.install(run),
        None => run(),
    }
}

/// Warns a person.
pub fn warn(py: Python, sentence: &str) -> PyResult<()> {
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text(sentence), 1)
}

fn text(sentence: &str) -> std::ffi::CString {
    std::ffi::CString::new(sentence.replace('\0', " ")).unwrap_or_default()
}
