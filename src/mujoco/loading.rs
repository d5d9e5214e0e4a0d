//! Loading a model: from a file, from text, stripped to what a body schema needs, or written out again.

use std::collections::BTreeMap;
use std::ffi::{CStr, CString};
use std::path::{Path, PathBuf};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use super::engine::{self, Version};
use super::error::{Error, Result};
use super::model::Model;
use super::vfs::{self, Vfs};
use super::{ffi, limits};
use crate::mjcf_xml::Stripped;

/// Bytes for the engine's message about a file.
const MESSAGE_BYTES: usize = 2000;

/// Least room for contacts in the data of any model: MuJoCo 2.2 reserves 100, which a body curled up
/// exceeds.
#[cfg(mujoco_nconmax)]
const LEAST_CONTACTS: i32 = 2000;

/// The engine keeps the model that was loaded last in a global of its own: one load at a time.
static LOADING: Mutex<()> = Mutex::new(());

impl Model {
    /// Reads an MJCF (or URDF) file and what it includes.
    ///
    /// # Errors
    /// [`Error::Read`] where a file is missing, malformed or refused by the engine,
    /// [`Error::Unsuitable`] where its numbers would crash or hang the engine,
    /// [`Error::Version`] where the library is not the one the crate was built with.
    pub fn from_path(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::load(path, &Self::checked_name(path)?, None)
    }

    /// The path as the engine wants it, of a file whose numbers do it no harm.
    fn checked_name(path: &Path) -> Result<CString> {
        limits::check_file(path)?;
        CString::new(path.as_os_str().as_encoded_bytes()).map_err(|_| {
            let message = "the path has a zero byte: give one without".into();
            Error::Read { path: path.to_path_buf(), message }
        })
    }

    /// Compiles a model from MJCF text; files that it includes or takes meshes from are sought in the
    /// working folder.
    ///
    /// # Errors
    /// As [`Model::from_path`], with [`Model::STRING_NAME`] in place of the file.
    pub fn from_xml(xml: &str) -> Result<Self> {
        let name = Path::new(Self::STRING_NAME);
        limits::check_text(name, xml)?;
        engine::check()?;
        Self::load(name, vfs::FILE, Some(&Vfs::new(xml)?))
    }

    /// Reads an MJCF file with more bodies in its world, given as their elements.
    ///
    /// # Errors
    /// As [`Model::from_path`].
    pub(crate) fn with_bodies(path: impl AsRef<Path>, bodies: Vec<xmltree::Element>) -> Result<Self> {
        let path = path.as_ref();
        limits::check_file(path)?;
        let refused = |(path, message)| Error::Read { path, message };
        let mut root = crate::mjcf_xml::read(path).map_err(refused)?;
        crate::mjcf_xml::anchor_assets(&mut root, path);
        let world = crate::mjcf_xml::section(&mut root, "worldbody");
        world.children.extend(bodies.into_iter().map(xmltree::XMLNode::Element));
        let text = crate::mjcf_xml::write(&root).map_err(|message| refused((path.to_path_buf(), message)))?;
        Self::load(path, vfs::FILE, Some(&Vfs::new(&text)?))
    }

    /// Reads what a body schema needs of an MJCF file, its bodies, joints, geoms, meshes and touch sensors, and leaves
    /// out everything else: what this MuJoCo is too old for, and what has nothing to do with where limbs are. Returns
    /// what was left out as well, with its number.
    ///
    /// # Errors
    /// As [`Model::from_path`].
    pub fn stripped(path: impl AsRef<Path>) -> Result<(Self, BTreeMap<String, usize>)> {
        let path = path.as_ref();
        limits::check_file(path)?;
        let refused = |(path, message)| Error::Read { path, message };
        let mut stripped = Stripped::new(path, &engine::schema()?).map_err(refused)?;
        loop {
            let text = stripped.text().map_err(|message| refused((path.to_path_buf(), message)))?;
            match Self::load(path, vfs::FILE, Some(&Vfs::new(&text)?)) {
                Ok(model) => return Ok((model, stripped.left_out)),
                // A mesh that the engine cannot use, such as a flat one, need not be the end of it.
                Err(Error::Read { message, .. })
                    if mesh_at_fault(&stripped, &message).is_some_and(|mesh| stripped.drop_mesh(&mesh)) => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// The model in a file as the engine writes it out: includes, composites and replicas as bodies, angles
    /// in radians.
    ///
    /// # Errors
    /// As [`Model::from_path`], and where no temporary file can be written.
    pub fn written_out(path: impl AsRef<Path>) -> Result<String> {
        let path = path.as_ref();
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let file = std::env::temp_dir().join(format!("bodyschema-{}-{number}.xml", std::process::id()));
        let failed = |message: String| Error::Read { path: path.to_path_buf(), message };
        let name = CString::new(file.as_os_str().as_encoded_bytes())
            .map_err(|_| failed("the folder for temporary files has a zero byte in its name".into()))?;
        let source = Self::checked_name(path)?;
        // The engine writes what was loaded last by anyone: nobody may load in between.
        let _one_at_a_time = LOADING.lock().unwrap_or_else(PoisonError::into_inner);
        let model = Self::load_alone(path, &source, None)?;
        let mut message = vec![0u8; MESSAGE_BYTES];
        let saved = engine::guarded("mj_saveLastXML", || {
            // SAFETY: name and buffer outlive the call, the buffer's length is its own, and the lock keeps
            // loads away from the engine's copy of the model.
            unsafe {
                ffi::mj_saveLastXML(
                    name.as_ptr(),
                    model.raw.as_ptr(),
                    message.as_mut_ptr().cast(),
                    MESSAGE_BYTES as i32,
                )
            }
        });
        let text = std::fs::read_to_string(&file);
        let _ = std::fs::remove_file(&file);
        // SAFETY: the engine ends what it writes with a zero byte, and the buffer began as zeros.
        let message = unsafe { engine::text(message.as_ptr().cast()) };
        match (saved?, text) {
            (0, _) => Err(failed(format!("MuJoCo cannot write it out: {message}"))),
            (_, Ok(text)) => Ok(text),
            (_, Err(error)) => {
                Err(failed(format!("it cannot be written out to {}: {error}", file.display())))
            }
        }
    }

    fn load(path: &Path, name: &CStr, vfs: Option<&Vfs>) -> Result<Self> {
        let _one_at_a_time = LOADING.lock().unwrap_or_else(PoisonError::into_inner);
        Self::load_alone(path, name, vfs)
    }

    /// Loads while the caller keeps other loads away with [`LOADING`].
    fn load_alone(path: &Path, name: &CStr, vfs: Option<&Vfs>) -> Result<Self> {
        let version = engine::check()?;
        let mut message = vec![0u8; MESSAGE_BYTES];
        let outcome = {
            let files = vfs.map_or(std::ptr::null(), Vfs::as_ptr);
            engine::guarded("mj_loadXML", || {
                // SAFETY: name and buffer outlive the call, the buffer's length is its own, and the
                // file system is null or initialised. The caller keeps other loads away.
                unsafe {
                    ffi::mj_loadXML(name.as_ptr(), files, message.as_mut_ptr().cast(), MESSAGE_BYTES as i32)
                }
            })
        };
        // SAFETY: the engine ends what it writes with a zero byte, and the buffer began as zeros.
        let message = unsafe { engine::text(message.as_ptr().cast()) };
        let refused =
            |message: &str| Error::Read { path: PathBuf::from(path), message: refusal(message, version) };
        let raw = match outcome {
            Ok(raw) => NonNull::new(raw).ok_or_else(|| refused(&message))?,
            Err(Error::Engine { message, .. }) => return Err(refused(&message)),
            Err(other) => return Err(other),
        };
        let warning = engine::take_warning().or(Some(message)).filter(|text| !text.is_empty());
        let model = Self { raw, version, warning };
        #[cfg(mujoco_nconmax)]
        // SAFETY: the model is not shared yet; the field is the room that mj_makeData reserves.
        unsafe {
            let room = &raw mut (*model.raw.as_ptr()).nconmax;
            if *room >= 0 {
                *room = (*room).max(LEAST_CONTACTS as _);
            }
        }
        Ok(model)
    }
}

/// The mesh that the engine complains of, the longest name that it mentions.
fn mesh_at_fault(stripped: &Stripped, message: &str) -> Option<String> {
    stripped.meshes().into_iter().filter(|mesh| message.contains(mesh.as_str())).max_by_key(String::len)
}

/// The engine's words about a file, with the mend.
fn refusal(message: &str, version: Version) -> String {
    let message = &plain(message.trim_start_matches("Error: "));
    if message.is_empty() {
        "MuJoCo refuses it without a word: check that it is an MJCF file".into()
    } else if message.contains("unrecognized") {
        format!("{message}; MuJoCo {version} does not know it: correct or remove it there")
    } else {
        format!("{message}; correct it there")
    }
}

/// What the engine passes on from its XML parser, in words: the parser gives codes.
fn plain(message: &str) -> String {
    const NOTHING: &str = "it holds no XML";
    if message.contains("empty file") {
        return NOTHING.to_string();
    }
    let field = |name: &str| {
        let (_, rest) = message.split_once(name)?;
        rest.split([' ', ',', ':']).next()
    };
    let (Some(code), Some(line)) = (field("Error=XML_"), field("Line number=")) else {
        return message.to_string();
    };
    let code = code.trim_start_matches("ERROR_");
    match (code, field("filename=")) {
        ("FILE_NOT_FOUND", Some(file)) => {
            let (_, place) = message.rsplit_once("', ").unwrap_or_default();
            format!("it includes {file}, which cannot be found, in {place}")
        }
        ("EMPTY_DOCUMENT", _) => NOTHING.to_string(),
        _ => format!("malformed XML ({}) in line {line}", code.to_lowercase().replace('_', " ")),
    }
}
