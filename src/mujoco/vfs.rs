//! A model's text handed to the engine from memory, through MuJoCo's virtual file system.

use std::ffi::CStr;

use super::engine::guarded;
use super::error::Result;
use super::ffi;

/// The one file's name inside the virtual file system.
pub(super) const FILE: &CStr = c"model.xml";

/// A virtual file system that holds one XML text.
///
/// The structure is two megabytes large in MuJoCo 2, so it lives on the heap.
pub(super) struct Vfs(Box<ffi::mjVFS>);

impl Vfs {
    /// A file system in which [`FILE`] has the content `xml`.
    ///
    /// # Errors
    /// [`Error::Engine`](super::Error::Engine) where the engine has no room for the text.
    pub(super) fn new(xml: &str) -> Result<Self> {
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
        guarded("mj_makeEmptyFileVFS", || vfs.fill(xml.as_bytes()))?;
        Ok(vfs)
    }

    /// The pointer for `mj_loadXML`.
    pub(super) fn as_ptr(&self) -> *const ffi::mjVFS {
        &raw const *self.0
    }

    #[cfg(mujoco_buffer_vfs)]
    fn fill(&mut self, bytes: &[u8]) {
        // SAFETY: name and buffer live through the call, and the engine copies the buffer.
        unsafe {
            ffi::mj_addBufferVFS(&raw mut *self.0, FILE.as_ptr(), bytes.as_ptr().cast(), bytes.len() as _);
        }
    }

    #[cfg(not(mujoco_buffer_vfs))]
    fn fill(&mut self, bytes: &[u8]) {
        // SAFETY: the engine allocates `bytes.len()` bytes under the index that it then finds; the
        // copy stays inside them. `fill` is called once, on an empty file system.
        unsafe {
            let made = ffi::mj_makeEmptyFileVFS(&raw mut *self.0, FILE.as_ptr(), bytes.len() as i32);
            let index = ffi::mj_findFileVFS(&raw const *self.0, FILE.as_ptr());
            if made == 0 && index >= 0 {
                let target = self.0.filedata[index as usize].cast::<u8>();
                std::ptr::copy_nonoverlapping(bytes.as_ptr(), target, bytes.len());
            }
        }
    }
}

impl Drop for Vfs {
    fn drop(&mut self) {
        // SAFETY: initialised in `new`, deleted once; it frees the file's content alone.
        unsafe { ffi::mj_deleteVFS(&raw mut *self.0) }
    }
}
