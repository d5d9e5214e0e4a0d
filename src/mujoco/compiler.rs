//! The engine's compiler: a model from texts, and the text of a model.

use std::ffi::{CString, c_char};
use std::ptr::NonNull;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::engine::{self, Version};
use super::error::{Error, Result};
use super::ffi;
use super::model::Model;
use super::vfs::{self, Vfs};

/// Bytes for the engine's message about a file.
const MESSAGE_BYTES: usize = 2000;

/// Least room for contacts in the data of any model: MuJoCo 2.2 reserves 100, which a body curled up
/// exceeds.
#[cfg(mujoco_nconmax)]
const LEAST_CONTACTS: i32 = 2000;

/// The engine keeps the model that was compiled last in a global of its own: one user at a time.
static COMPILING: Mutex<()> = Mutex::new(());

/// The compiler, while nobody else has it.
pub(crate) struct Compiler {
    _one_at_a_time: MutexGuard<'static, ()>,
    /// The engine's.
    pub version: Version,
}

impl Compiler {
    /// The name of the first text that is compiled.
    pub fn first_text() -> String {
        vfs::FILE.to_string_lossy().into_owned()
    }

    /// Waits for the compiler.
    ///
    /// # Errors
    /// [`Error::Version`] where the library is not the one the crate was built with.
    pub fn take() -> Result<Compiler> {
        let lock = COMPILING.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(Compiler { _one_at_a_time: lock, version: engine::check()? })
    }

    /// Compiles texts with their names, of which the first includes the others; the engine's words where it refuses.
    ///
    /// # Errors
    /// [`Error::Engine`] where it has no room for them.
    pub fn compile(&self, texts: &[(String, String)]) -> Result<std::result::Result<Model, String>> {
        let vfs = Vfs::new(texts)?;
        let (outcome, message) = with_message("mj_loadXML", |buffer, bytes| {
            // SAFETY: name and buffer outlive the call, the buffer's length is its own, and the file system is
            // initialised. The lock keeps other loads away.
            unsafe { ffi::mj_loadXML(vfs::FILE.as_ptr(), vfs.as_ptr(), buffer, bytes) }
        });
        let raw = match outcome {
            Ok(raw) => raw,
            Err(Error::Engine { message, .. }) => return Ok(Err(message)),
            Err(other) => return Err(other),
        };
        let Some(raw) = NonNull::new(raw) else { return Ok(Err(message)) };
        let warning = engine::take_warning().or(Some(message)).filter(|text| !text.is_empty());
        let model = Model { raw, version: self.version, warning };
        #[cfg(mujoco_nconmax)]
        // SAFETY: the model is not shared yet; the field is the room that mj_makeData reserves.
        unsafe {
            let room = &raw mut (*model.raw.as_ptr()).nconmax;
            if *room >= 0 {
                *room = (*room).max(LEAST_CONTACTS as _);
            }
        }
        Ok(Ok(model))
    }

    /// The model that was compiled last as the engine writes it out; in words why it cannot.
    ///
    /// # Errors
    /// Where the engine raises an error.
    pub fn write_out(&self, last: &Model) -> Result<std::result::Result<String, String>> {
        let folder = std::env::temp_dir();
        let file = folder.join(format!("bodyschema-{}.xml", std::process::id()));
        let Ok(name) = CString::new(file.as_os_str().as_encoded_bytes()) else {
            return Ok(Err("the folder for temporary files has a zero byte in its name".into()));
        };
        let (saved, message) = with_message("mj_saveLastXML", |buffer, bytes| {
            // SAFETY: name and buffer outlive the call, the buffer's length is its own, and the lock keeps
            // loads away from the engine's copy of the model.
            unsafe { ffi::mj_saveLastXML(name.as_ptr(), last.raw.as_ptr(), buffer, bytes) }
        });
        let text = std::fs::read_to_string(&file);
        let _ = std::fs::remove_file(&file);
        Ok(match (saved?, text) {
            (0, _) => Err(format!("MuJoCo cannot write it out: {message}")),
            (_, text) => {
                text.map_err(|error| format!("it cannot be written out to {}: {error}", file.display()))
            }
        })
    }
}

/// What a call of the engine comes to that is given a buffer for words and its length, and these words.
fn with_message<T>(call: &'static str, run: impl FnOnce(*mut c_char, i32) -> T) -> (Result<T>, String) {
    let mut buffer = vec![0u8; MESSAGE_BYTES];
    let outcome = engine::guarded(call, || run(buffer.as_mut_ptr().cast(), MESSAGE_BYTES as i32));
    // SAFETY: the engine ends what it writes with a zero byte, and the buffer began as zeros.
    (outcome, unsafe { engine::text(buffer.as_ptr().cast()) })
}
