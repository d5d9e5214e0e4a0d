//! Makes Rust bindings from the MuJoCo headers that are installed, and links its library.
//!
//! Structure layouts differ between MuJoCo versions, so nothing is taken from a published binding:
//! the headers beside the library are the only source. `MUJOCO_DIR` names another MuJoCo to use in place of the
//! system's: an installation (the folder that holds `include/` and `lib/`) or pip's package (the folder that holds
//! `include/` and a library whose file name ends in its version).

use std::env;
use std::panic;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex};

/// The calls that `src/mujoco` makes; with them bindgen takes along the types that they need.
const FUNCTIONS: &str = "mj_(version|versionString|loadXML|printSchema|saveLastXML|copyModel|deleteModel|makeData|deleteData|resetData\
|kinematics|comPos|collision|makeConstraint|projectConstraint|referenceConstraint|forward|step|step1|step2|mulM\
|contactForce|sensorPos|id2name\
|camlight|tendon\
|defaultVFS|deleteVFS|makeEmptyFileVFS|findFileVFS|addBufferVFS)\
|mju_(error|warning|warningText)\
|mjv_(defaultCamera|defaultOption|defaultPerturb|defaultScene|makeScene|freeScene|updateScene|initGeom)\
|mjr_(defaultContext|makeContext|freeContext|setBuffer|render|readPixels|overlay)";
/// Enumerations of which constants are compared with plain integers of the model.
const TYPES: &str = "mjModel_?|mjData_?|mjContact_?|mjVFS_?\
|mjt(Joint|Geom|Obj|Sensor|Warning|Collision|DisableBit|EnableBit|Integrator|Eq|Camera|Texture|CatBit|RndFlag|VisFlag|Framebuffer|Font|GridPos)_?";
const VARIABLES: &str = "mju_user_(error|warning)|mjVERSION_HEADER|mjMAXVAL|mjNEQDATA";
/// Bits of the model's options that some versions lack. Where one is lacking it is no bit at all, zero: to set or to
/// clear that changes nothing.
const OPTIONAL_BITS: [&str; 10] = [
    "mjDSBL_ISLAND",
    "mjDSBL_MIDPHASE",
    "mjDSBL_MULTICCD",
    "mjDSBL_NATIVECCD",
    "mjENBL_ISLAND",
    "mjENBL_MULTICCD",
    "mjENBL_NATIVECCD",
    "mjENBL_SENSORNOISE",
    "mjENBL_SLEEP",
    "mjENBL_SPECULATIVE",
];

/// How every complaint about MuJoCo itself ends.
const MUJOCO_MEND: &str = "install Debian's package libmujoco-dev, or set MUJOCO_DIR to the folder \
of another MuJoCo, an installation with include/ and lib/ or pip's package";
/// How every complaint about the folder of another MuJoCo ends.
const FOLDER_MEND: &str = "set MUJOCO_DIR to a folder with include/ and lib/, or to pip's package, which is \
`mujoco` in its site-packages, or unset it and install Debian's package libmujoco-dev";
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
    println!("cargo::rustc-check-cfg=cfg(mujoco_body_contact_bits)");
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
        Some(folder) => vec![link_folder(Path::new(&folder))?],
        None => link_system()?,
    };
    let headers = Headers::default();
    let mut bindings = generate(&include, headers.clone())?;
    // Nobody formats the bindings: a space may be between any two words.
    let bare = bindings.replace(' ', "");
    let declares = |needle: &str| bare.contains(&needle.replace(' ', ""));
    for bit in OPTIONAL_BITS {
        if !declares(&format!("const {bit}:")) {
            bindings.push_str(&format!("pub const {bit}: u32 = 0;\n"));
        }
    }
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
        ("pub body_contype:", "mujoco_body_contact_bits"),
    ] {
        if declares(needle) {
            println!("cargo::rustc-cfg={name}");
        }
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo sets no OUT_DIR")?);
    std::fs::write(out.join("mujoco.rs"), bindings)
        .map_err(|error| format!("cannot write the MuJoCo bindings into {}: {error}", out.display()))
}

/// Links the MuJoCo in `folder`, an installation or pip's package, and returns its include folder.
fn link_folder(folder: &Path) -> Result<PathBuf, String> {
    // The program looks for the library there, from whichever folder it is started.
    let folder = &std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    let include = folder.join("include");
    let header = include.join("mujoco/mujoco.h");
    if !header.is_file() {
        return Err(format!(
            "no MuJoCo header at {}, where MUJOCO_DIR points: {FOLDER_MEND}",
            header.display()
        ));
    }
    // An installation has a folder of libraries; in pip's package the library lies beside the headers' folder.
    let (place, name) = [folder.join("lib"), folder.to_path_buf()]
        .into_iter()
        .find_map(|place| library_in(&place).map(|name| (place, name)))
        .ok_or_else(|| {
            format!(
                "no MuJoCo library (libmujoco.so) in {}, where MUJOCO_DIR points: {FOLDER_MEND}",
                folder.display()
            )
        })?;
    // Another version that is installed into the same place has another name, or another time.
    println!("cargo::rerun-if-changed={}", place.join(&name).display());
    println!("cargo::rustc-link-search=native={}", place.display());
    println!("cargo::rustc-link-lib=dylib{}", linker_name(&name));
    if !cfg!(windows) {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{}", place.display());
    }
    Ok(include)
}

/// The file name of the MuJoCo library in a folder: the plain one, or one with a version, as pip's package has it.
fn library_in(folder: &Path) -> Option<String> {
    let entries = std::fs::read_dir(folder).ok()?.flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    // The shortest name is the plain one.
    names.filter(|name| is_library(name)).min_by_key(|name| (name.len(), name.clone()))
}

/// Whether a file of this name is MuJoCo's library.
fn is_library(name: &str) -> bool {
    let versioned = |rest: &str| rest.is_empty() || rest.starts_with('.');
    name == "mujoco.lib"
        || name.strip_prefix("libmujoco.so").is_some_and(versioned)
        || name.strip_prefix("libmujoco").and_then(|rest| rest.strip_suffix(".dylib")).is_some_and(versioned)
}

/// How cargo is told of a library by its file name: `=NAME`, or the file itself where a version follows its ending.
fn linker_name(file: &str) -> String {
    let stem = file.strip_suffix(".so").or_else(|| file.strip_suffix(".dylib"));
    match stem.and_then(|stem| stem.strip_prefix("lib")).or_else(|| file.strip_suffix(".lib")) {
        Some(name) => format!("={name}"),
        None => format!(":+verbatim={file}"),
    }
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
        .formatter(bindgen::Formatter::None)
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
