//! The engine as a whole: its version, and its errors and warnings turned into values.
//!
//! MuJoCo's own handlers write a log file, wait for a key and end the process. Here an error unwinds
//! out of the C call to the nearest [`guarded`], and a warning waits in a thread-local for whoever
//! made the call. Both need `panic = "unwind"`, cargo's default.

use std::cell::Cell;
use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::ptr::addr_of_mut;
use std::sync::Once;

use super::error::{Error, Result, version_text};
use super::ffi;

/// The type of `mju_user_error` and `mju_user_warning`, with an ABI that lets a panic through.
type Handler = unsafe extern "C-unwind" fn(*const c_char);

/// What the error handler unwinds with; nothing else in the process raises it.
struct Raised(String);

thread_local! {
    /// The first warning since somebody took one, on this thread.
    static WARNING: Cell<Option<String>> = const { Cell::new(None) };
}

/// A MuJoCo version: the number that `mj_version` returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version(pub i32);

impl std::fmt::Display for Version {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(&version_text(self.0))
    }
}

/// Installs the handlers, once in the process, and checks the library against the headers.
///
/// Every way to a model or to data passes here, so that callers need not.
///
/// # Errors
/// [`Error::Version`] where the loaded library is not the one the crate was built with: the two
/// would disagree about where every field lies.
pub fn check() -> Result<Version> {
    static HANDLERS: Once = Once::new();
    HANDLERS.call_once(|| {
        // SAFETY: the two are plain function pointers that the engine reads when it raises; they are
        // written once, before this crate calls anything that raises. The cast changes the ABI's
        // unwinding alone, which is what the platform's C ABI already allows.
        unsafe {
            addr_of_mut!(ffi::mju_user_error).cast::<Option<Handler>>().write(Some(on_error));
            addr_of_mut!(ffi::mju_user_warning).cast::<Option<Handler>>().write(Some(on_warning));
        }
    });
    // SAFETY: takes nothing and returns a constant.
    compare(ffi::mjVERSION_HEADER as i32, unsafe { ffi::mj_version() })
}

/// The elements and attributes of MJCF that the engine knows, as it prints them: an element a line, indented by its
/// depth, with its attributes.
///
/// # Errors
/// [`Error::Version`] as [`check`], [`Error::Engine`] where the engine has no such text.
pub fn schema() -> Result<String> {
    const BYTES: usize = 1 << 20;
    check()?;
    let mut buffer = vec![0u8; BYTES];
    let written = guarded("mj_printSchema", || {
        // SAFETY: without a file the engine prints into the buffer, whose length is its own, and ends the text with
        // a zero byte.
        unsafe { ffi::mj_printSchema(std::ptr::null(), buffer.as_mut_ptr().cast(), BYTES as i32, 0, 0) }
    })?;
    buffer.truncate(usize::try_from(written).unwrap_or(0).min(BYTES));
    let text = String::from_utf8_lossy(&buffer).trim_end_matches('\0').to_string();
    if text.is_empty() {
        let message = "it does not print the MJCF schema: use a complete MuJoCo".to_string();
        return Err(Error::Engine { call: "mj_printSchema", message });
    }
    Ok(text)
}

/// Compares the headers' version with the library's.
///
/// # Errors
/// [`Error::Version`] with both numbers where they differ.
pub fn compare(header: i32, library: i32) -> Result<Version> {
    if header == library { Ok(Version(library)) } else { Err(Error::Version { header, library }) }
}

/// Receives the engine's errors. It may not return, so it unwinds; `resume_unwind` calls no panic
/// hook, so nothing is printed.
unsafe extern "C-unwind" fn on_error(message: *const c_char) {
    // SAFETY: the engine hands over the message that it formatted.
    resume_unwind(Box::new(Raised(unsafe { text(message) })))
}

/// Receives the engine's warnings and keeps the first one.
unsafe extern "C-unwind" fn on_warning(message: *const c_char) {
    // SAFETY: the engine hands over the message that it formatted.
    let message = unsafe { text(message) };
    WARNING.with(|slot| slot.set(Some(slot.take().unwrap_or(message))));
}

/// Runs `body`, which makes the C call named `call`, and catches the engine's error in it.
///
/// A warning of the call stays for [`take_warning`]; one left over from an earlier call is dropped.
///
/// # Errors
/// [`Error::Engine`] where the engine raised one. What the call worked on may be half done then.
pub(super) fn guarded<T>(call: &'static str, body: impl FnOnce() -> T) -> Result<T> {
    take_warning();
    catch_unwind(AssertUnwindSafe(body)).map_err(|payload| match payload.downcast::<Raised>() {
        Ok(raised) => Error::Engine { call, message: raised.0 },
        Err(other) => resume_unwind(other),
    })
}

/// The warning that the engine raised on this thread since the last call, if any.
pub(super) fn take_warning() -> Option<String> {
    WARNING.take()
}

/// A C string as owned text on one line; empty for a null pointer.
///
/// # Safety
/// `pointer` is null or points to a string that ends in a zero byte.
pub(super) unsafe fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: not null, and zero-terminated by the caller's promise.
    let raw = unsafe { CStr::from_ptr(pointer) }.to_string_lossy();
    let lines: Vec<&str> = raw.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    lines.join(", ").replace(":, ", ": ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_version_mismatch_names_both() {
        let text = compare(222, 337).unwrap_err().to_string();
        assert!(text.contains("2.2.2") && text.contains("3.3.7"), "{text}");
        assert_eq!(compare(222, 222), Ok(Version(222)));
    }

    #[test]
    fn an_error_raised_in_the_engine_is_a_value() {
        check().unwrap();
        // SAFETY: the message is a static string; the handler unwinds, which `guarded` catches.
        let outcome = guarded("mju_error", || unsafe { ffi::mju_error(c"as a test".as_ptr()) });
        let expected = Error::Engine { call: "mju_error", message: "as a test".into() };
        assert_eq!(outcome, Err(expected));
    }

    #[test]
    fn a_warning_raised_in_the_engine_waits_for_its_caller() {
        check().unwrap();
        // SAFETY: the message is a static string.
        guarded("mju_warning", || unsafe { ffi::mju_warning(c"as a test".as_ptr()) }).unwrap();
        assert_eq!(take_warning().as_deref(), Some("as a test"));
        assert_eq!(take_warning(), None);
    }
}
