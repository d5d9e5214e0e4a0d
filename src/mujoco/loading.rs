//! Loading a model, whoever made it: one door for every file.
//!
//! A file is read as a tree and handed to the engine as it is. Where the engine refuses it, the tree is put in terms that
//! it knows ([`crate::model_files`]), and the caller is told what was left out. What is to be changed in every tree before
//! the engine sees it goes into [`prepare`].

use std::ffi::CString;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::engine::{self, Version};
use super::error::{Error, Result};
use super::ffi;
use super::model::Model;
use super::refusal::{Complaint, refusal};
use super::vfs::{self, Vfs};
use crate::model_files::{
    Element, LeftOut, Reduced, Refused, Source, Texts, anchor_assets, check_assets, check_limits,
    check_numbers, check_values, element, numbered, set_compiler, urdf_to_mjcf,
};
use crate::plausible::bounded;

/// Bytes for the engine's message about a file.
const MESSAGE_BYTES: usize = 2000;

/// Least room for contacts in the data of any model: MuJoCo 2.2 reserves 100, which a body curled up
/// exceeds.
#[cfg(mujoco_nconmax)]
const LEAST_CONTACTS: i32 = 2000;

/// Least mass and inertia of a body, kg and kg·m², where the engine finds those of the file too small: tiny creatures, and
/// bodies that only carry others.
const LEAST_MASS: [(&str, &str); 2] = [("boundmass", "1e-6"), ("boundinertia", "1e-9")];

/// What the engine says of a body whose geoms weigh too little for it to find where they are heaviest.
const TOO_LIGHT: [&str; 2] = ["body mass is too small", "alternative for principal axes"];

/// What the engine says of meshes that hold no volume; where a mesh is, its surface tells as well.
const SURFACE_FAULTS: [&str; 3] = [
    "mesh volume is too small",
    "eigenvalue of mesh inertia must be positive",
    "eigenvalues of mesh inertia violate",
];

/// The engine keeps the model that was loaded last in a global of its own: one load at a time.
static LOADING: Mutex<()> = Mutex::new(());

impl Model {
    /// Reads an MJCF or URDF file and what it includes; what this MuJoCo cannot read of it is left out.
    ///
    /// # Errors
    /// [`Error::Read`] where a file is missing, malformed, has numbers that would crash or hang the engine, or is refused
    /// by the engine for the body in it, [`Error::Version`] where the library is not the one the crate was built with.
    pub fn from_path(path: impl AsRef<Path>) -> Result<Self> {
        Ok(Self::read_with_textures(path)?.0)
    }

    /// Reads an MJCF or URDF file and what it includes, but its textures, which pictures alone need, and tells what was left
    /// out of it.
    ///
    /// # Errors
    /// As [`Model::from_path`].
    pub fn read(path: impl AsRef<Path>) -> Result<(Self, LeftOut)> {
        Self::read_by(&Loader::bare(), path.as_ref())
    }

    /// The same with its textures.
    ///
    /// # Errors
    /// As [`Model::from_path`].
    pub fn read_with_textures(path: impl AsRef<Path>) -> Result<(Self, LeftOut)> {
        Self::read_by(&Loader::new(), path.as_ref())
    }

    fn read_by(loader: &Loader, path: &Path) -> Result<(Self, LeftOut)> {
        let (model, mut left_out) = loader.open(Source::read(path)?, &[])?;
        for joint in
            model.joints().filter(|joint| joint.limited && bounded(joint.range, 0.0) != Some(joint.range))
        {
            let ([least, greatest], name) = (joint.range, joint.name.unwrap_or_default());
            let note = format!(
                "the limits of joint {name}, {least:?} to {greatest:?}, are beyond all that can be: taken for none"
            );
            left_out.notes.push(note);
        }
        Ok((model, left_out))
    }

    /// A model's tree with what the engine has to be given before it takes it, such as least masses; as it is where the
    /// engine takes it so, or does not take it for anything else. Meshes are sought from the file `path`.
    ///
    /// # Errors
    /// [`Error::Version`] where the library is not the one the crate was built with.
    pub(crate) fn accepted(root: Element, path: &Path) -> Result<Element> {
        let version = engine::check()?;
        let loader = Loader { hulls: false, ..Loader::new() };
        let mut given = root.clone();
        anchor_assets(&mut given, path);
        let mut mended = given.clone();
        if loader.mended(&mut mended, version).is_err() || mended == given {
            return Ok(root);
        }
        // The folders of meshes and textures are told as they were.
        let is_compiler = |e: &&Element| e.name == "compiler";
        let mut before = root.children.iter().filter(is_compiler);
        let settings = mended.children.iter_mut();
        for compiler in settings.filter(|e| e.name == "compiler") {
            let own = before.next();
            for name in ["meshdir", "texturedir"] {
                compiler.remove(name);
                if let Some(folder) = own.and_then(|own| own.get(name)) {
                    compiler.set(name, folder);
                }
            }
        }
        Ok(mended)
    }

    /// Compiles a model from MJCF text; files that it includes or takes meshes from are sought in the
    /// working folder.
    ///
    /// # Errors
    /// As [`Model::from_path`], with [`Model::STRING_NAME`] in place of the file.
    pub fn from_xml(xml: &str) -> Result<Self> {
        Ok(Loader::new().open(Source::of_text(Path::new(Self::STRING_NAME), xml)?, &[])?.0)
    }

    /// Reads a file with more bodies in its world, and the meshes that they are made of, given as their elements.
    ///
    /// # Errors
    /// As [`Model::from_path`].
    pub(crate) fn with_bodies(path: impl AsRef<Path>, bodies: Vec<Element>) -> Result<Self> {
        Ok(Loader::bare().open(Source::read(path.as_ref())?, &bodies)?.0)
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
        let failed = |message: String| Error::from(Refused::file(path, message));
        let name = CString::new(file.as_os_str().as_encoded_bytes())
            .map_err(|_| failed("the folder for temporary files has a zero byte in its name".into()))?;
        // The engine writes what was loaded last by anyone: nobody may load in between.
        let loader = Loader { hulls: false, ..Loader::new() };
        let (model, _) = loader.open(Source::read(path)?, &[])?;
        let mut message = vec![0u8; MESSAGE_BYTES];
        let saved = engine::guarded("mj_saveLastXML", || {
            // SAFETY: name and buffer outlive the call, the buffer's length is its own, and the loader's lock keeps
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
}

/// What is changed in every tree, in this order.
fn prepare(root: &mut Element, source: &Source, bodies: &[Element]) {
    anchor_assets(root, &source.path);
    // A trunk that stands still would be joined to the world, and its limbs fall apart into creatures of their own; and what
    // is for show alone may be all there is to touch.
    for (name, kept) in [("fusestatic", "false"), ("discardvisual", "false")] {
        let mut compilers = root.children.iter().filter(|e| e.name == "compiler");
        if compilers.any(|compiler| compiler.get(name).is_some()) {
            set_compiler(root, name, kept);
        }
    }
    if !bodies.is_empty() {
        let (assets, bodies): (Vec<_>, Vec<_>) = bodies.iter().cloned().partition(|e| e.name == "mesh");
        let nodes = |elements: Vec<Element>| elements.into_iter();
        root.section("worldbody").children.extend(nodes(bodies));
        if !assets.is_empty() {
            root.section("asset").children.extend(nodes(assets));
        }
    }
}

/// Loads while it keeps other loads away.
struct Loader {
    _one_at_a_time: MutexGuard<'static, ()>,
    /// Whether the model is to have the hulls of all meshes that it can be touched on, for which it is loaded twice.
    hulls: bool,
    /// Whether the model is to have its textures.
    textures: bool,
}

impl Loader {
    fn new() -> Loader {
        let lock = LOADING.lock().unwrap_or_else(PoisonError::into_inner);
        Loader { _one_at_a_time: lock, hulls: true, textures: true }
    }

    /// One that leaves out textures: they may be larger than all else a thousand times, and every copy of the model with them.
    fn bare() -> Loader {
        Loader { textures: false, ..Loader::new() }
    }

    /// What is changed in every tree before the engine reads it.
    fn prepare(&self, root: &mut Element, source: &Source, bodies: &[Element]) {
        prepare(root, source, bodies);
        if self.textures {
            return;
        }
        root.each(&mut |e| match e.name.as_str() {
            "asset" => e.children.retain(|child| child.name != "texture"),
            "material" => {
                e.remove("texture");
                e.children.retain(|child| child.name != "layer");
            }
            _ => {}
        });
    }

    /// Loads a file with more bodies in its world, as it is or else in terms that the engine knows.
    fn open(&self, mut source: Source, bodies: &[Element]) -> Result<(Model, LeftOut)> {
        let version = engine::check()?;
        check_limits(&source)?;
        check_values(&source)?;
        check_assets(&source)?;
        let first = match source.root.name.as_str() {
            "mujoco" => {
                let mut root = source.root.clone();
                self.prepare(&mut root, &source, bodies);
                match self.mended(&mut root, version) {
                    Ok(model) => return Ok((model, LeftOut::default())),
                    Err(Failed::Engine(error)) => return Err(error),
                    Err(Failed::Refused(complaint)) => Some(complaint),
                }
            }
            "robot" => None,
            other => return Err(Error::from(no_model(&source, other))),
        };
        let mut reduced = match &first {
            Some(_) => Reduced::new(&source, &engine::schema()?)?,
            None => urdf_to_mjcf(&source)?,
        };
        // Replicas and what is attached are written out there.
        check_numbers(&source, &reduced.root)?;
        self.prepare(&mut reduced.root, &source, bodies);
        source.root = Element::new("mujoco");
        loop {
            let complaint = match self.mended(&mut reduced.root, version) {
                Ok(model) => return Ok((model, reduced.left_out)),
                Err(Failed::Engine(error)) => return Err(error),
                Err(Failed::Refused(complaint)) => complaint,
            };
            // A mesh that the engine cannot use, such as a flat one, need not be the end of it.
            let element = complaint.element.and_then(|number| numbered(&mut reduced.root, number));
            let mesh = match element {
                Some(element) => element.get("name").filter(|_| element.name == "mesh").map(str::to_string),
                None => reduced
                    .meshes()
                    .into_iter()
                    .filter(|mesh| complaint.words.contains(mesh))
                    .max_by_key(String::len),
            };
            let mesh = mesh.filter(|_| !complaint.words.contains("repeated name"));
            if let Some(mesh) = mesh
                && (reduced.take_hull(&mesh) || reduced.drop_mesh(&mesh, &complaint.words))
            {
                continue;
            }
            // What the file says wrongly is in both readings; then the first one's words are those about the file. An
            // element that was but unknown to it, the second has put in plain terms.
            let told = first.filter(|first| {
                first.place.is_some()
                    && first.place == complaint.place
                    && !first.message.contains("unrecognized element")
            });
            let Complaint { message, place, .. } = told.unwrap_or(complaint);
            let (path, line) = place.map_or((source.path, None), |at| (at.file.to_path_buf(), Some(at.line)));
            return Err(Error::Read { path, line, message: refusal(&message, version) });
        }
    }

    /// Loads a tree; where the engine asks for what changes nothing of where limbs are, it gets it.
    fn mended(&self, root: &mut Element, version: Version) -> std::result::Result<Model, Failed> {
        loop {
            let texts = Texts::new(root, &vfs::FILE.to_string_lossy());
            let loaded = load(&Vfs::new(&texts.texts)?, version)?;
            let words = match loaded {
                Ok(model) if self.hulls => return Ok(model.with_hulls(root, |root| again(root, version))),
                Ok(model) => return Ok(model),
                Err(words) => words,
            };
            let complaint = Complaint::new(&words, root, &texts);
            if !mend(root, &complaint) {
                return Err(Failed::Refused(complaint));
            }
        }
    }
}

/// Why a tree was not loaded.
enum Failed {
    /// The engine refuses it.
    Refused(Complaint),
    /// The engine itself failed.
    Engine(Error),
}

impl From<Error> for Failed {
    fn from(error: Error) -> Failed {
        Failed::Engine(error)
    }
}

/// A refusal of what is no model.
fn no_model(source: &Source, root: &str) -> Refused {
    let message = match root {
        "mujocoinclude" => {
            "it is a part that other files include; give the file that includes it".to_string()
        }
        "sdf" => "it is SDF; convert it to URDF or MJCF first".to_string(),
        _ => format!(
            "it begins with <{root}>, and is neither MJCF (<mujoco>) nor URDF (<robot>); give one of these"
        ),
    };
    source.refused(&source.root, message)
}

/// Gives the engine what it asks for; whether there was anything that it does not have yet.
///
/// Newer engines take limits from ranges unless they are told otherwise; and what weighs too little for dynamics can be
/// moved all the same.
fn mend(root: &mut Element, complaint: &Complaint) -> bool {
    let settings: &[(&str, &str)] = if complaint.message.contains("autolimits") {
        &[("autolimits", "true")]
    } else if complaint.message.contains("balanceinertia") {
        &[("balanceinertia", "true")]
    } else if complaint.message.contains("larger than mjMINVAL") {
        &LEAST_MASS
    } else if TOO_LIGHT.iter().any(|words| complaint.message.contains(words)) {
        return weigh(root, complaint);
    } else if complaint.message.contains("inertia alternative") {
        return unweigh(root, complaint);
    } else if SURFACE_FAULTS.iter().any(|fault| complaint.message.contains(fault)) {
        return thin(root, &complaint.message);
    } else {
        return false;
    };
    let mut compilers = root.children.iter().filter(|e| e.name == "compiler");
    let last = compilers.next_back();
    if settings.iter().all(|(name, value)| last.is_some_and(|e| e.get(name) == Some(value))) {
        return false;
    }
    settings.iter().for_each(|(name, value)| set_compiler(root, name, value));
    true
}

/// Gives a body whose geoms weigh nothing the least mass there is; whether it had none yet.
fn weigh(root: &mut Element, complaint: &Complaint) -> bool {
    let [mass, inertia] = LEAST_MASS.map(|(_, least)| least.to_string());
    let Some(body) = complaint.element.and_then(|number| numbered(root, number)) else { return false };
    if body.name != "body" || body.child("inertial").is_some() {
        return false;
    }
    let least = [("pos", "0 0 0".into()), ("mass", mass), ("diaginertia", [inertia.as_str(); 3].join(" "))];
    body.children.insert(0, element("inertial", &least));
    set_compiler(root, "inertiafromgeom", "auto");
    true
}

/// Takes an inertia that no body can have from its body, which then weighs what its geoms do; whether it had one.
fn unweigh(root: &mut Element, complaint: &Complaint) -> bool {
    let Some(body) = complaint.element.and_then(|number| numbered(root, number)) else { return false };
    let before = body.children.len();
    body.children.retain(|child| child.name != "inertial");
    body.children.len() < before
}

/// Lets the geoms of a flat mesh weigh as its surface does; whether there is any that does not.
fn thin(root: &mut Element, message: &str) -> bool {
    let mut changed = false;
    root.each(&mut |e| {
        if e.name == "geom"
            && e.get("mesh").is_some_and(|mesh| message.contains(mesh))
            && !e.has("shellinertia")
        {
            e.set("shellinertia", "true");
            changed = true;
        }
    });
    changed
}

/// Loads a tree that was loaded before with other filters; none where the engine fails.
fn again(root: &Element, version: Version) -> Option<std::result::Result<Model, String>> {
    let texts = Texts::new(root, &vfs::FILE.to_string_lossy());
    load(&Vfs::new(&texts.texts).ok()?, version).ok()
}

/// Loads a text; the engine's words where it refuses.
fn load(vfs: &Vfs, version: Version) -> Result<std::result::Result<Model, String>> {
    let mut message = vec![0u8; MESSAGE_BYTES];
    let outcome = engine::guarded("mj_loadXML", || {
        // SAFETY: name and buffer outlive the call, the buffer's length is its own, and the file system is
        // initialised. The caller keeps other loads away.
        unsafe {
            ffi::mj_loadXML(
                vfs::FILE.as_ptr(),
                vfs.as_ptr(),
                message.as_mut_ptr().cast(),
                MESSAGE_BYTES as i32,
            )
        }
    });
    // SAFETY: the engine ends what it writes with a zero byte, and the buffer began as zeros.
    let message = unsafe { engine::text(message.as_ptr().cast()) };
    let raw = match outcome {
        Ok(raw) => raw,
        Err(Error::Engine { message, .. }) => return Ok(Err(message)),
        Err(other) => return Err(other),
    };
    let Some(raw) = NonNull::new(raw) else { return Ok(Err(message)) };
    let warning = engine::take_warning().or(Some(message)).filter(|text| !text.is_empty());
    let model = Model { raw, version, warning };
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
