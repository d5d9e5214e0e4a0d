//! OpenGL without a screen: EGL, or OSMesa where there is no EGL, sought when a picture is first asked for.
//!
//! Neither is linked, so that the program runs where there is none. MuJoCo takes its OpenGL functions from whichever of
//! the two libraries it finds in the process, once and for all: so a process that has drawn stays with the one it began
//! with, and the library is never unloaded. EGL is spoken to through khronos-egl; for OSMesa there is no crate.

use std::ffi::{CStr, c_int, c_uint, c_void};
use std::marker::PhantomData;
use std::ptr::{null, null_mut};
use std::sync::OnceLock;

use khronos_egl as egl;
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

/// A context of OpenGL, current in the thread that made it until it is dropped, and bound to that thread.
pub(super) struct OffscreenContext {
    handle: ContextHandle,
    /// Contexts belong to threads.
    not_send: PhantomData<*mut ()>,
}

enum ContextHandle {
    Egl { egl: &'static Egl, context: egl::Context, surface: egl::Surface },
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
                let made = context(&egl.instance, egl.display, egl.config);
                let (context, surface) = made.map_err(|reason| Error::OpenGl { reason })?;
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
            ContextHandle::Egl { egl: Egl { instance, display, .. }, context, surface } => {
                let surface = Some(*surface);
                instance.make_current(*display, surface, surface, Some(*context)).is_ok()
            }
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
            ContextHandle::Egl { egl: Egl { instance, display, .. }, context, surface } => {
                // What cannot be freed is left to the end of the process.
                let _ = instance.make_current(*display, None, None, None);
                let _ = instance.destroy_surface(*display, *surface);
                let _ = instance.destroy_context(*display, *context);
            }
            // SAFETY: this value's alone and freed once.
            ContextHandle::OsMesa { osmesa, context, .. } => unsafe { (osmesa.destroy_context)(*context) },
        }
    }
}

enum Platform {
    Egl(Box<Egl>),
    OsMesa(OsMesa),
}

/// The library that draws in this process.
fn library() -> Result<&'static Platform> {
    static FOUND: OnceLock<std::result::Result<Platform, String>> = OnceLock::new();
    let wanted = std::env::var(OPENGL_VARIABLE).unwrap_or_default();
    let found = FOUND.get_or_init(|| match wanted.as_str() {
        "" => {
            let first = match Egl::load() {
                Ok(egl) => return Ok(Platform::Egl(Box::new(egl))),
                Err(reason) => reason,
            };
            // MuJoCo would take the functions of a library that stayed in the process.
            if is_loaded(EGL) {
                return Err(format!(
                    "{first}; {OPENGL_VARIABLE}=osmesa does without it, if libosmesa6 is installed"
                ));
            }
            OsMesa::load().map(Platform::OsMesa).map_err(|second| format!("{first}, {second}"))
        }
        "egl" => Egl::load().map(|egl| Platform::Egl(Box::new(egl))),
        "osmesa" => OsMesa::load().map(Platform::OsMesa),
        "none" => Err(format!("{OPENGL_VARIABLE}=none disables it")),
        other => Err(format!("{OPENGL_VARIABLE} is {other}: set it to egl, osmesa or none")),
    });
    found.as_ref().map_err(|reason| Error::OpenGl { reason: reason.clone() })
}

/// The first library of some names that is there.
fn open(names: &[&str]) -> std::result::Result<Library, String> {
    // SAFETY: what these libraries do when they are loaded is what every program has done that draws with them.
    let found = names.iter().find_map(|name| unsafe { Library::new(*name) }.ok());
    found.ok_or_else(|| format!("{} not found", names[0]))
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
    found.map(|function| *function).map_err(|_| format!("{} is missing", name.to_string_lossy()))
}

/// EGL: one display of it, on which contexts are made.
struct Egl {
    instance: egl::DynamicInstance<egl::EGL1_4>,
    display: egl::Display,
    config: egl::Config,
}

// SAFETY: EGL's functions may be called from any thread, with a display that all of them share.
unsafe impl Send for Egl {}
// SAFETY: as above.
unsafe impl Sync for Egl {}

/// Platforms of displays without a screen, which EGL 1.4 has as extensions.
const PLATFORM_SURFACELESS: c_uint = 0x31DD;
const PLATFORM_DEVICE: c_uint = 0x313F;
/// What a context wants: colours, depth and stencil bits, surfaces that nobody sees, OpenGL.
const CONFIG: [egl::Int; 15] = [
    egl::RED_SIZE,
    8,
    egl::GREEN_SIZE,
    8,
    egl::BLUE_SIZE,
    8,
    egl::DEPTH_SIZE,
    24,
    egl::STENCIL_SIZE,
    8,
    egl::SURFACE_TYPE,
    egl::PBUFFER_BIT,
    egl::RENDERABLE_TYPE,
    egl::OPENGL_BIT,
    egl::NONE,
];
const SURFACE: [egl::Int; 5] = [egl::WIDTH, SIDE, egl::HEIGHT, SIDE, egl::NONE];

impl Egl {
    fn load() -> std::result::Result<Egl, String> {
        let library = open(EGL)?;
        // SAFETY: it is EGL's library, whose functions have the types of EGL.
        let instance = unsafe { egl::DynamicInstance::<egl::EGL1_4>::load_required_from(library) };
        let instance = instance.map_err(|error| format!("EGL is too old: {error:?}"))?;
        let mut displays = displays_without_screen(&instance);
        // SAFETY: the default display is one of every platform.
        displays.extend(unsafe { instance.get_display(egl::DEFAULT_DISPLAY) });
        for display in displays {
            let config =
                instance.initialize(display).and_then(|_| instance.choose_first_config(display, &CONFIG));
            let Ok(Some(config)) = config else { continue };
            if let Ok((context, surface)) = context(&instance, display, config) {
                let _ = instance.destroy_surface(display, surface);
                let _ = instance.destroy_context(display, context);
                return Ok(Egl { instance, display, config });
            }
        }
        Err("EGL has no driver that draws OpenGL".into())
    }
}

/// The displays of all graphics cards, and that of no card at all.
fn displays_without_screen(instance: &egl::DynamicInstance<egl::EGL1_4>) -> Vec<egl::Display> {
    type QueryDevices = unsafe extern "system" fn(egl::Int, *mut Handle, *mut egl::Int) -> egl::Boolean;
    type GetPlatformDisplay = unsafe extern "system" fn(c_uint, Handle, *const egl::Int) -> Handle;
    const MOST: usize = 16;
    let Some(get) = instance.get_proc_address("eglGetPlatformDisplayEXT") else { return Vec::new() };
    let mut displays = Vec::new();
    // SAFETY: the types are those of EGL_EXT_platform_base and EGL_EXT_device_enumeration, and at most as many devices
    // are written as there is room for.
    unsafe {
        let get = std::mem::transmute::<extern "system" fn(), GetPlatformDisplay>(get);
        if let Some(query) = instance.get_proc_address("eglQueryDevicesEXT") {
            let query = std::mem::transmute::<extern "system" fn(), QueryDevices>(query);
            let (mut devices, mut count) = ([null_mut(); MOST], 0);
            if query(MOST as egl::Int, devices.as_mut_ptr(), &raw mut count) == egl::TRUE {
                let known = devices.iter().take(count.max(0) as usize);
                displays.extend(known.map(|device| get(PLATFORM_DEVICE, *device, null())));
            }
        }
        displays.push(get(PLATFORM_SURFACELESS, null_mut(), null()));
        let there = displays.into_iter().filter(|display| !display.is_null());
        there.map(|display| egl::Display::from_ptr(display)).collect()
    }
}

/// A new context with a surface of its own.
fn context(
    instance: &egl::DynamicInstance<egl::EGL1_4>,
    display: egl::Display,
    config: egl::Config,
) -> std::result::Result<(egl::Context, egl::Surface), String> {
    // It is bound per thread.
    let bound = instance.bind_api(egl::OPENGL_API);
    let context = bound.and_then(|()| instance.create_context(display, config, None, &[egl::NONE]));
    let context = context.map_err(|error| format!("EGL provides no OpenGL context: {error}"))?;
    instance.create_pbuffer_surface(display, config, &SURFACE).map(|surface| (context, surface)).map_err(
        |error| {
            let _ = instance.destroy_context(display, context);
            format!("EGL provides no drawing surface: {error}")
        },
    )
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
        if context.is_null() { Err("OSMesa provides no OpenGL context".into()) } else { Ok(context) }
    }
}
