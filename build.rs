//! Makes Rust bindings from the MuJoCo headers that are installed, and links its library.
//!
//! Structure layouts differ between MuJoCo versions, so nothing is taken from a published binding:
//! the headers beside the library are the only source. `MUJOCO_DIR` names an installation (the
//! folder that holds `include/` and `lib/`) to use in place of the system's.

use std::env;
use std::panic;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex};

/// The calls that `src/mujoco` makes; with them bindgen takes along the types that they need.
const FUNCTIONS: &str = "mj_(version|versionString|loadXML|printSchema|saveLastXML|copyModel|deleteModel|makeData|deleteData|resetData\
|kinematics|comPos|collision|makeConstraint|projectConstraint|referenceConstraint|forward|step|step1|step2|mulM\
|contactForce|sensorPos|id2name|name2id\
|camlight|tendon\
|defaultVFS|deleteVFS|makeEmptyFileVFS|findFileVFS|addBufferVFS)\
|mju_(error|warning|warningText)\
|mjv_(defaultCamera|defaultOption|defaultPerturb|defaultScene|makeScene|freeScene|updateScene|initGeom)\
|mjr_(defaultContext|makeContext|freeContext|setBuffer|render|readPixels)";
/// Enumerations of which constants are compared with plain integers of the model.
const TYPES: &str = "mjModel_?|mjData_?|mjContact_?|mjVFS_?\
|mjt(Joint|Geom|Obj|Sensor|Warning|Collision|DisableBit|EnableBit|Integrator|Eq|Camera|Texture|CatBit|RndFlag|VisFlag|Framebuffer)_?";
const VARIABLES: &str = "mju_user_(error|warning)|mjVERSION_HEADER|mjMAXVAL|mjNEQDATA";

/// How every complaint about MuJoCo itself ends.
const MUJOCO_MEND: &str = "install Debian's package libmujoco-dev, or set MUJOCO_DIR to the folder \
of another MuJoCo that holds include/ and lib/";
/// How every complaint about bindgen's tool ends.
const LIBCLANG_MEND: &str = "install Debian's package libclang-dev, or set LIBCLANG_PATH to the \
folder that holds libclang.so";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=MUJOCO_DIR");
    println!("cargo::rustc-check-cfg=cfg(mujoco_buffer_vfs)");
    println!("cargo::rustc-check-cfg=cfg(mujoco_nconmax)");
    println!("cargo::rustc-check-cfg=cfg(mujoco_nstack)");
    println!("cargo::rustc-check-cfg=cfg(mujoco_collision_option)");
    println!("cargo::rustc-check-cfg=cfg(mujoco_signature_from_one)");
    println!("cargo::rustc-check-cfg=cfg(mujoco_eq_active0)");
    println!("cargo::rustc-check-cfg=cfg(mujoco_sensornoise)");
    if let Err(sentence) = build() {
        println!("cargo::error={sentence}");
    }
}

/// Finds MuJoCo, writes `$OUT_DIR/mujoco.rs` and tells cargo what to link.
///
/// # Errors
/// One sentence that says what is missing and how to mend it.
fn build() -> Result<(), String> {
    let include = match env::var_os("MUJOCO_DIR").filter(|folder| !folder.is_empty()) {
        Some(folder) => vec![link_installation(Path::new(&folder))?],
        None => link_system()?,
    };
    let headers = Headers::default();
    let bindings = generate(&include, headers.clone())?;
    // Older versions count the two bodies of a pair's signature from one; the header's comment tells.
    let comments = headers.read("mjmodel.h").replace(' ', "");
    if comments.contains("(body1+1)<<16") {
        println!("cargo::rustc-cfg=mujoco_signature_from_one");
    }
    for (needle, name) in [
        ("fn mj_addBufferVFS", "mujoco_buffer_vfs"),
        ("pub nconmax:", "mujoco_nconmax"),
        ("pub nstack:", "mujoco_nstack"),
        ("pub collision:", "mujoco_collision_option"),
        ("pub eq_active0:", "mujoco_eq_active0"),
        ("const mjENBL_SENSORNOISE", "mujoco_sensornoise"),
    ] {
        if bindings.contains(needle) {
            println!("cargo::rustc-cfg={name}");
        }
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo sets no OUT_DIR")?);
    std::fs::write(out.join("mujoco.rs"), bindings)
        .map_err(|error| format!("cannot write the MuJoCo bindings into {}: {error}", out.display()))
}

/// Links the MuJoCo in `folder` and returns its include folder.
fn link_installation(folder: &Path) -> Result<PathBuf, String> {
    let include = folder.join("include");
    let library = folder.join("lib");
    if !include.join("mujoco/mujoco.h").is_file() {
        return Err(format!(
            "no MuJoCo header at {}, where MUJOCO_DIR points: set MUJOCO_DIR to the folder that holds \
             include/ and lib/, or unset it and install Debian's package libmujoco-dev",
            include.join("mujoco/mujoco.h").display()
        ));
    }
    let names = ["libmujoco.so", "libmujoco.dylib", "mujoco.lib"];
    if !names.iter().any(|name| library.join(name).exists()) {
        return Err(format!(
            "no MuJoCo library (libmujoco.so) in {}, where MUJOCO_DIR points: set MUJOCO_DIR to the \
             folder that holds include/ and lib/, or unset it and install Debian's package libmujoco-dev",
            library.display()
        ));
    }
    println!("cargo::rustc-link-search=native={}", library.display());
    println!("cargo::rustc-link-lib=dylib=mujoco");
    if !cfg!(windows) {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{}", library.display());
    }
    Ok(include)
}

/// Links the system's MuJoCo and returns the include folders that pkg-config knows of, if any.
fn link_system() -> Result<Vec<PathBuf>, String> {
    // Debian's package has no pkg-config file and needs none; other systems may.
    if let Ok(found) = pkg_config::Config::new().probe("mujoco") {
        return Ok(found.include_paths);
    }
    if linker_finds("libmujoco.so") == Some(false) {
        return Err(format!("the linker finds no MuJoCo library (libmujoco.so): {MUJOCO_MEND}"));
    }
    println!("cargo::rustc-link-lib=dylib=mujoco");
    Ok(Vec::new())
}

/// Whether the C compiler that links finds `library`; `None` where it cannot be asked.
fn linker_finds(library: &str) -> Option<bool> {
    if env::var("TARGET") != env::var("HOST") || !cfg!(target_os = "linux") {
        return None;
    }
    let answer = Command::new("cc").arg(format!("-print-file-name={library}")).output().ok()?;
    Some(String::from_utf8_lossy(&answer.stdout).trim() != library)
}

/// The bindings as Rust source.
fn generate(include: &[PathBuf], headers: Headers) -> Result<String, String> {
    let builder = bindgen::Builder::default()
        .header_contents("bodyschema_mujoco.h", "#include <mujoco/mujoco.h>\n")
        .clang_args(include.iter().map(|folder| format!("-I{}", folder.display())))
        .allowlist_function(FUNCTIONS)
        .allowlist_type(TYPES)
        .allowlist_var(VARIABLES)
        .override_abi(bindgen::Abi::CUnwind, ".*")
        .default_enum_style(bindgen::EnumVariation::Consts)
        .prepend_enum_name(false)
        .layout_tests(false)
        .derive_debug(false)
        .parse_callbacks(Box::new(bindgen::CargoCallbacks::new()))
        .parse_callbacks(Box::new(headers));

    // bindgen panics where it finds no libclang: that is a sentence, not a backtrace.
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let outcome = panic::catch_unwind(panic::AssertUnwindSafe(|| builder.generate()));
    panic::set_hook(hook);

    match outcome {
        Ok(Ok(bindings)) => Ok(bindings.to_string()),
        Ok(Err(error)) => Err(explain(&error.to_string())),
        Err(payload) => {
            let text = payload
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| payload.downcast_ref::<&str>().copied())
                .unwrap_or("bindgen stopped");
            if text.contains("libclang") {
                return Err(format!("bindgen finds no libclang: {LIBCLANG_MEND}"));
            }
            Err(explain(text))
        }
    }
}

/// One sentence for what clang said about the headers.
fn explain(message: &str) -> String {
    let line = message.lines().find(|line| line.contains("error:")).unwrap_or(message).trim();
    if line.contains("mujoco.h' file not found") {
        format!("clang finds no MuJoCo header (mujoco/mujoco.h): {MUJOCO_MEND}")
    } else if line.contains("file not found") {
        format!("libclang lacks its own headers ({line}): {LIBCLANG_MEND}")
    } else {
        format!("bindgen cannot read the MuJoCo headers ({line}): {MUJOCO_MEND}")
    }
}

/// The headers that clang opened, for what their comments alone say.
#[derive(Debug, Default, Clone)]
struct Headers(Arc<Mutex<Vec<PathBuf>>>);

impl Headers {
    /// The text of the header called `name`; empty where it was not opened.
    fn read(&self, name: &str) -> String {
        let opened = self.0.lock().map(|paths| paths.clone()).unwrap_or_default();
        let found = opened.iter().find(|path| path.file_name().is_some_and(|file| file == name));
        found.and_then(|path| std::fs::read_to_string(path).ok()).unwrap_or_default()
    }
}

impl bindgen::callbacks::ParseCallbacks for Headers {
    fn include_file(&self, path: &str) {
        if let Ok(mut paths) = self.0.lock() {
            paths.push(PathBuf::from(path));
        }
    }
}
