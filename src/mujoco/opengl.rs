//! OpenGL without a screen: EGL, sought when a picture is first asked for.
//!
//! It is not linked, so that the program runs where there is none. MuJoCo takes its OpenGL functions from the library that it
//! finds in the process, once and for all: so it is never unloaded. Mesa's EGL draws without a graphics card as well.

use std::ffi::{c_uint, c_void};
use std::marker::PhantomData;
use std::ptr::{null, null_mut};
use std::sync::OnceLock;

use khronos_egl as egl;
use libloading::Library;

use super::error::{Error, Result};

/// The environment variable that says which library draws: `egl`, as without it, or `none`.
pub const OPENGL_VARIABLE: &str = "BODYSCHEMA_GL";

/// Names of EGL's library.
const EGL: [&str; 2] = ["libEGL.so.1", "libEGL.so"];

/// Side of the surface that a context wants and nobody draws on, pixels: MuJoCo has a buffer of its own.
const SIDE: egl::Int = 16;

type Handle = *mut c_void;

/// A context of OpenGL, current in the thread that made it until it is dropped, and bound to that thread.
pub(super) struct OffscreenContext {
    egl: &'static Egl,
    context: egl::Context,
    surface: egl::Surface,
    /// Contexts belong to threads.
    not_send: PhantomData<*mut ()>,
}

impl OffscreenContext {
    /// A new context, current in this thread.
    ///
    /// # Errors
    /// [`Error::OpenGl`] where the library gives none.
    pub fn new() -> Result<OffscreenContext> {
        let egl = library()?;
        let made = context(&egl.instance, egl.display, egl.config);
        let (context, surface) = made.map_err(|reason| Error::OpenGl { reason })?;
        let mut context = OffscreenContext { egl, context, surface, not_send: PhantomData };
        context.make_current()?;
        Ok(context)
    }

    /// Makes the context the one that OpenGL calls of this thread go to.
    ///
    /// # Errors
    /// [`Error::OpenGl`] where the library refuses.
    pub fn make_current(&mut self) -> Result<()> {
        let Egl { instance, display, .. } = self.egl;
        let surface = Some(self.surface);
        let refused = |_| Error::OpenGl { reason: "its context cannot be used in this thread".into() };
        instance.make_current(*display, surface, surface, Some(self.context)).map_err(refused)
    }
}

impl Drop for OffscreenContext {
    fn drop(&mut self) {
        let Egl { instance, display, .. } = self.egl;
        // What cannot be freed is left to the end of the process.
        let _ = instance.make_current(*display, None, None, None);
        let _ = instance.destroy_surface(*display, self.surface);
        let _ = instance.destroy_context(*display, self.context);
    }
}

/// The library that draws in this process.
fn library() -> Result<&'static Egl> {
    static FOUND: OnceLock<std::result::Result<Egl, String>> = OnceLock::new();
    let wanted = std::env::var(OPENGL_VARIABLE).unwrap_or_default();
    let found = FOUND.get_or_init(|| match wanted.as_str() {
        "" | "egl" => Egl::load(),
        "none" => Err(format!("{OPENGL_VARIABLE}=none disables it")),
        other => Err(format!("{OPENGL_VARIABLE} is {other}: set it to egl or none")),
    });
    found.as_ref().map_err(|reason| Error::OpenGl { reason: reason.clone() })
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
        // SAFETY: what it does when it is loaded is what every program has done that draws with it.
        let library = EGL.iter().find_map(|name| unsafe { Library::new(*name) }.ok());
        let library = library.ok_or_else(|| format!("{} not found", EGL[0]))?;
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
