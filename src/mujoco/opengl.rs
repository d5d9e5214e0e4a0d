//! OpenGL without a screen: EGL, or OSMesa where there is no EGL, sought when a picture is first asked for.
//!
//! Neither is linked, so that the program runs where there is none. MuJoCo takes its OpenGL functions from whichever of
//! the two libraries it finds in the process, once and for all: so a process that has drawn stays with the one it began
//! with, and the library is never unloaded.

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::marker::PhantomData;
use std::ptr::{null, null_mut};
use std::sync::OnceLock;

use libloading::Library;

use super::error::{Error, Result};

/// The environment variable that says which library draws: `egl`, `osmesa`, or `none`. Without it EGL is tried, then
/// OSMesa.
pub const OPENGL_VARIABLE: &str = "BODYSCHEMA_GL";

/// Names of EGL's library.
const EGL: &[&str] = &["libEGL.so.1", "libEGL.so"];
/// Names of OSMesa's library.
const OSMESA: &[&str] = &["libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"];

/// Side of the surface that a context wants and nobody draws on, pixels: MuJoCo has a buffer of its own.
const SIDE: c_int = 16;

type Handle = *mut c_void;
type Attributes = *const c_int;
type Function = unsafe extern "C" fn();

/// A context of OpenGL, current in the thread that made it until it is dropped, and bound to that thread.
pub(super) struct OffscreenContext {
    handle: ContextHandle,
    /// Contexts belong to threads.
    not_send: PhantomData<*mut ()>,
}

enum ContextHandle {
    Egl { egl: &'static Egl, context: Handle, surface: Handle },
    OsMesa { osmesa: &'static OsMesa, context: Handle, buffer: Vec<u8> },
}

impl OffscreenContext {
    /// A new context, current in this thread.
    ///
    /// # Errors
    /// [`Error::OpenGl`] where no library gives one.
    pub fn new() -> Result<OffscreenContext> {
        let handle = match library()? {
            Platform::Egl(egl) => {
                let (context, surface) = egl.context().map_err(|reason| Error::OpenGl { reason })?;
                ContextHandle::Egl { egl, context, surface }
            }
            Platform::OsMesa(osmesa) => {
                let context = osmesa.context().map_err(|reason| Error::OpenGl { reason })?;
                let buffer = vec![0; (4 * SIDE * SIDE) as usize];
                ContextHandle::OsMesa { osmesa, context, buffer }
            }
        };
        let mut context = OffscreenContext { handle, not_send: PhantomData };
        context.make_current()?;
        Ok(context)
    }

    /// Makes the context the one that OpenGL calls of this thread go to.
    ///
    /// # Errors
    /// [`Error::OpenGl`] where the library refuses.
    pub fn make_current(&mut self) -> Result<()> {
        let done = match &mut self.handle {
            // SAFETY: display, surface and context are of one EGL and live as long as `self`.
            ContextHandle::Egl { egl, context, surface } => unsafe {
                (egl.make_current)(egl.display, *surface, *surface, *context) != 0
            },
            // SAFETY: the context lives as long as `self`, as does the buffer, which holds four bytes a pixel.
            ContextHandle::OsMesa { osmesa, context, buffer } => unsafe {
                const UNSIGNED_BYTE: c_uint = 0x1401;
                (osmesa.make_current)(*context, buffer.as_mut_ptr().cast(), UNSIGNED_BYTE, SIDE, SIDE) != 0
            },
        };
        if done {
            return Ok(());
        }
        Err(Error::OpenGl { reason: "its context cannot be used in this thread".into() })
    }
}

impl Drop for OffscreenContext {
    fn drop(&mut self) {
        match &self.handle {
            // SAFETY: both are this value's alone and freed once; no context is current afterwards.
            ContextHandle::Egl { egl, context, surface } => unsafe {
                (egl.make_current)(egl.display, null_mut(), null_mut(), null_mut());
                (egl.destroy_surface)(egl.display, *surface);
                (egl.destroy_context)(egl.display, *context);
            },
            // SAFETY: this value's alone and freed once.
            ContextHandle::OsMesa { osmesa, context, .. } => unsafe { (osmesa.destroy_context)(*context) },
        }
    }
}

enum Platform {
    Egl(Egl),
    OsMesa(OsMesa),
}

/// The library that draws in this process.
fn library() -> Result<&'static Platform> {
    static FOUND: OnceLock<std::result::Result<Platform, String>> = OnceLock::new();
    let wanted = std::env::var(OPENGL_VARIABLE).unwrap_or_default();
    let found = FOUND.get_or_init(|| match wanted.as_str() {
        "" => {
            let first = match Egl::load() {
                Ok(egl) => return Ok(Platform::Egl(egl)),
                Err(reason) => reason,
            };
            // MuJoCo would take the functions of a library that stayed in the process.
            if is_loaded(EGL) {
                return Err(format!(
                    "{first}; {OPENGL_VARIABLE}=osmesa draws without it, if libosmesa6 is there"
                ));
            }
            OsMesa::load().map(Platform::OsMesa).map_err(|second| format!("{first}, {second}"))
        }
        "egl" => Egl::load().map(Platform::Egl),
        "osmesa" => OsMesa::load().map(Platform::OsMesa),
        "none" => Err(format!("{OPENGL_VARIABLE}=none keeps it out")),
        other => Err(format!("{OPENGL_VARIABLE} is {other}: set it to egl, osmesa or none")),
    });
    found.as_ref().map_err(|reason| Error::OpenGl { reason: reason.clone() })
}

/// The first library of some names that is there.
fn open(names: &[&str]) -> std::result::Result<Library, String> {
    // SAFETY: what these libraries do when they are loaded is what every program has done that draws with them.
    let found = names.iter().find_map(|name| unsafe { Library::new(*name) }.ok());
    found.ok_or_else(|| format!("there is no {}", names[0]))
}

/// Whether a library is in the process already.
fn is_loaded(names: &[&str]) -> bool {
    use libloading::os::unix::{Library, RTLD_LAZY};
    const RTLD_NOLOAD: c_int = 4;
    // SAFETY: with that flag nothing is loaded.
    names.iter().any(|name| unsafe { Library::open(Some(*name), RTLD_LAZY | RTLD_NOLOAD) }.is_ok())
}

/// A function of a library, as a plain pointer: good for as long as the library is loaded.
///
/// # Safety
/// `T` is the type of the function of that name.
unsafe fn symbol<T: Copy>(library: &Library, name: &CStr) -> std::result::Result<T, String> {
    // SAFETY: as promised by the caller.
    let found = unsafe { library.get::<T>(name.to_bytes_with_nul()) };
    found.map(|function| *function).map_err(|_| format!("it lacks {}", name.to_string_lossy()))
}

/// EGL: one display of it, on which contexts are made.
struct Egl {
    display: Handle,
    config: Handle,
    create_context: unsafe extern "C" fn(Handle, Handle, Handle, Attributes) -> Handle,
    create_surface: unsafe extern "C" fn(Handle, Handle, Attributes) -> Handle,
    make_current: unsafe extern "C" fn(Handle, Handle, Handle, Handle) -> c_uint,
    destroy_context: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    destroy_surface: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    bind_api: unsafe extern "C" fn(c_uint) -> c_uint,
    function: unsafe extern "C" fn(*const c_char) -> Option<Function>,
}

// SAFETY: EGL's functions may be called from any thread, with a display that all of them share.
unsafe impl Send for Egl {}
// SAFETY: as above.
unsafe impl Sync for Egl {}

/// EGL's numbers, as its headers have them.
mod egl {
    use std::ffi::{c_int, c_uint};

    pub const OPENGL_API: c_uint = 0x30A2;
    pub const PLATFORM_SURFACELESS: c_uint = 0x31DD;
    pub const PLATFORM_DEVICE: c_uint = 0x313F;
    const NONE: c_int = 0x3038;
    /// Red, green, blue, depth and stencil bits; surfaces that nobody sees; OpenGL.
    pub const CONFIG: [c_int; 15] =
        [0x3024, 8, 0x3023, 8, 0x3022, 8, 0x3025, 24, 0x3026, 8, 0x3033, 1, 0x3040, 8, NONE];
    /// Width and height.
    pub const SURFACE: [c_int; 5] = [0x3057, super::SIDE, 0x3056, super::SIDE, NONE];
    pub const NOTHING: [c_int; 1] = [NONE];
}

impl Egl {
    fn load() -> std::result::Result<Egl, String> {
        let library = open(EGL)?;
        // SAFETY: the types are those of EGL 1.4's functions.
        unsafe {
            type GetDisplay = unsafe extern "C" fn(Handle) -> Handle;
            type Initialise = unsafe extern "C" fn(Handle, *mut c_int, *mut c_int) -> c_uint;
            type ChooseConfig =
                unsafe extern "C" fn(Handle, Attributes, *mut Handle, c_int, *mut c_int) -> c_uint;
            let default_display: GetDisplay = symbol(&library, c"eglGetDisplay")?;
            let initialise: Initialise = symbol(&library, c"eglInitialize")?;
            let choose: ChooseConfig = symbol(&library, c"eglChooseConfig")?;
            let mut egl = Egl {
                display: null_mut(),
                config: null_mut(),
                create_context: symbol(&library, c"eglCreateContext")?,
                create_surface: symbol(&library, c"eglCreatePbufferSurface")?,
                make_current: symbol(&library, c"eglMakeCurrent")?,
                destroy_context: symbol(&library, c"eglDestroyContext")?,
                destroy_surface: symbol(&library, c"eglDestroySurface")?,
                bind_api: symbol(&library, c"eglBindAPI")?,
                function: symbol(&library, c"eglGetProcAddress")?,
            };
            let mut displays = egl.displays_without_screen();
            displays.push(default_display(null_mut()));
            for display in displays.into_iter().filter(|display| !display.is_null()) {
                let mut count = 0;
                egl.display = display;
                if initialise(display, null_mut(), null_mut()) != 0
                    && choose(display, egl::CONFIG.as_ptr(), &raw mut egl.config, 1, &raw mut count) != 0
                    && count > 0
                    && let Ok((context, surface)) = egl.context()
                {
                    (egl.destroy_surface)(display, surface);
                    (egl.destroy_context)(display, context);
                    // The functions stay good for as long as the process lives.
                    std::mem::forget(library);
                    return Ok(egl);
                }
            }
        }
        Err("EGL has no driver that draws OpenGL".into())
    }

    /// The displays of all graphics cards, and that of no card at all.
    ///
    /// # Safety
    /// The functions are those of a loaded EGL.
    unsafe fn displays_without_screen(&self) -> Vec<Handle> {
        type QueryDevices = unsafe extern "C" fn(c_int, *mut Handle, *mut c_int) -> c_uint;
        type GetPlatformDisplay = unsafe extern "C" fn(c_uint, Handle, Attributes) -> Handle;
        const MOST: usize = 16;
        let mut displays = Vec::new();
        // SAFETY: the names end in zero bytes, the types are those of EGL_EXT_platform_base and
        // EGL_EXT_device_enumeration, and at most as many devices are written as there is room for.
        unsafe {
            let Some(get) = (self.function)(c"eglGetPlatformDisplayEXT".as_ptr()) else { return displays };
            let get = std::mem::transmute::<Function, GetPlatformDisplay>(get);
            if let Some(query) = (self.function)(c"eglQueryDevicesEXT".as_ptr()) {
                let query = std::mem::transmute::<Function, QueryDevices>(query);
                let (mut devices, mut count) = ([null_mut(); MOST], 0);
                if query(MOST as c_int, devices.as_mut_ptr(), &raw mut count) != 0 {
                    let known = devices.iter().take(count.max(0) as usize);
                    displays.extend(known.map(|device| get(egl::PLATFORM_DEVICE, *device, null())));
                }
            }
            displays.push(get(egl::PLATFORM_SURFACELESS, null_mut(), null()));
        }
        displays
    }

    /// A new context with a surface of its own.
    fn context(&self) -> std::result::Result<(Handle, Handle), String> {
        // SAFETY: display and configuration are EGL's own, and the lists end as EGL wants them to.
        unsafe {
            // It is bound per thread.
            (self.bind_api)(egl::OPENGL_API);
            let context = (self.create_context)(self.display, self.config, null_mut(), egl::NOTHING.as_ptr());
            if context.is_null() {
                return Err("EGL gives no context of OpenGL".into());
            }
            let surface = (self.create_surface)(self.display, self.config, egl::SURFACE.as_ptr());
            if surface.is_null() {
                (self.destroy_context)(self.display, context);
                return Err("EGL gives no surface to draw on".into());
            }
            Ok((context, surface))
        }
    }
}

/// OSMesa, which draws in memory.
struct OsMesa {
    create_context: unsafe extern "C" fn(c_uint, c_int, c_int, c_int, Handle) -> Handle,
    make_current: unsafe extern "C" fn(Handle, Handle, c_uint, c_int, c_int) -> u8,
    destroy_context: unsafe extern "C" fn(Handle),
}

impl OsMesa {
    fn load() -> std::result::Result<OsMesa, String> {
        let library = open(OSMESA)?;
        // SAFETY: the types are those of OSMesa's functions.
        let osmesa = unsafe {
            OsMesa {
                create_context: symbol(&library, c"OSMesaCreateContextExt")?,
                make_current: symbol(&library, c"OSMesaMakeCurrent")?,
                destroy_context: symbol(&library, c"OSMesaDestroyContext")?,
            }
        };
        // The functions stay good for as long as the process lives.
        std::mem::forget(library);
        Ok(osmesa)
    }

    fn context(&self) -> std::result::Result<Handle, String> {
        const RGBA: c_uint = 0x1908;
        const DEPTH: c_int = 24;
        const STENCIL: c_int = 8;
        // SAFETY: numbers alone; no context to share with.
        let context = unsafe { (self.create_context)(RGBA, DEPTH, STENCIL, 0, null_mut()) };
        if context.is_null() { Err("OSMesa gives no context of OpenGL".into()) } else { Ok(context) }
    }
}
