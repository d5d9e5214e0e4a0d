//! A model's text handed to the engine from memory, through MuJoCo's virtual file system.

use std::ffi::{CStr, CString};

use super::engine::guarded;
use super::error::{Error, Result};
use super::ffi;

/// The name of a model's first text inside the virtual file system.
pub(super) const FILE: &CStr = c"model.xml";

/// A virtual file system that holds the texts of a model.
///
/// The structure is two megabytes large in MuJoCo 2, so it lives on the heap.
pub(super) struct Vfs(Box<ffi::mjVFS>);

impl Vfs {
    /// A file system of texts with their names.
    ///
    /// # Errors
    /// [`Error::Engine`](super::Error::Engine) where the engine has no room for them.
    pub(super) fn new(texts: &[(String, String)]) -> Result<Self> {
        let mut storage = Box::<ffi::mjVFS>::new_uninit();
        let files = guarded("mj_defaultVFS", || {
            // SAFETY: the engine initialises the structure behind the pointer, which is valid for
            // writes and large enough by its type.
            unsafe {
                ffi::mj_defaultVFS(storage.as_mut_ptr());
                storage.assume_init()
            }
        })?;
        let mut vfs = Self(files);
        for (name, text) in texts {
            let name = CString::new(name.as_str()).unwrap_or_default();
            if !guarded("mj_makeEmptyFileVFS", || vfs.fill(&name, text.as_bytes()))? {
                let message = "it has no room for the model's text".to_string();
                return Err(Error::Engine { call: "mj_makeEmptyFileVFS", message });
            }
        }
        Ok(vfs)
    }

    /// The pointer for `mj_loadXML`.
    pub(super) fn as_ptr(&self) -> *const ffi::mjVFS {
        &raw const *self.0
    }

    /// Adds a file; whether there was room for it.
    #[cfg(mujoco_buffer_vfs)]
    fn fill(&mut self, name: &CStr, bytes: &[u8]) -> bool {
        // SAFETY: name and buffer live through the call, and the engine copies the buffer.
        unsafe {
            ffi::mj_addBufferVFS(&raw mut *self.0, name.as_ptr(), bytes.as_ptr().cast(), bytes.len() as _)
                == 0
        }
    }

    /// Adds a file; whether there was room for it.
    #[cfg(not(mujoco_buffer_vfs))]
    fn fill(&mut self, name: &CStr, bytes: &[u8]) -> bool {
        // SAFETY: the engine allocates `bytes.len()` bytes under the index that it then finds; the
        // copy stays inside them.
        unsafe {
            let made = ffi::mj_makeEmptyFileVFS(&raw mut *self.0, name.as_ptr(), bytes.len() as i32);
            let index = ffi::mj_findFileVFS(&raw const *self.0, name.as_ptr());
            let made = made == 0 && index >= 0;
            if made {
                let target = self.0.filedata[index as usize].cast::<u8>();
                std::ptr::copy_nonoverlapping(bytes.as_ptr(), target, bytes.len());
            }
            made
        }
    }
}

impl Drop for Vfs {
    fn drop(&mut self) {
        // SAFETY: initialised in `new`, deleted once; it frees the file's content alone.
        unsafe { ffi::mj_deleteVFS(&raw mut *self.0) }
    }
}
