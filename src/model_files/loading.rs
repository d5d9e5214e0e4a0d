//! Loading a model, whoever made it: one door for every file.
//!
//! A file is read as a tree and handed to the engine as it is. Where the engine refuses it, the tree is put in terms that
//! it knows (`Reduced`), and the caller is told what was left out. What is to be changed in every tree before
//! the engine sees it goes into [`Loader::prepare`].

use std::path::Path;

use super::checks::{check, check_numbers};
use super::hulls::with_hulls;
use super::reduce::Reduced;
use super::refusal::{Complaint, refusal};
use super::source::whole_folder_of;
use super::write::{Texts, numbered};
use super::{Element, LeftOut, Refused, Source, element, move_assets, set_compiler, urdf};
use crate::mujoco::{self, Compiler, Error, Model, Result};
use crate::plausible::bounded;

/// Least mass and inertia of a body, kg and kg·m², where the engine finds those of the file too small: tiny creatures, and
/// bodies that only carry others.
const LEAST_MASS: [(&str, &str); 2] = [("boundmass", "1e-6"), ("boundinertia", "1e-9")];

/// What the engine asks for, and the settings that give it.
const SETTINGS: [(&str, &[(&str, &str)]); 3] = [
    ("autolimits", &[("autolimits", "true")]),
    ("balanceinertia", &[("balanceinertia", "true")]),
    ("larger than mjMINVAL", &LEAST_MASS),
];

/// What the engine says of a body whose geoms weigh too little for it to find where they are heaviest.
const TOO_LIGHT: [&str; 2] = ["body mass is too small", "alternative for principal axes"];

/// What the engine says of meshes that hold no volume; where a mesh is, its surface tells as well.
const SURFACE_FAULTS: [&str; 3] = [
    "mesh volume is too small",
    "eigenvalue of mesh inertia must be positive",
    "eigenvalues of mesh inertia violate",
];

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
        Self::read_by(&Loader::bare()?, path.as_ref())
    }

    /// The same with its textures.
    ///
    /// # Errors
    /// As [`Model::from_path`].
    pub fn read_with_textures(path: impl AsRef<Path>) -> Result<(Self, LeftOut)> {
        Self::read_by(&Loader::new()?, path.as_ref())
    }

    fn read_by(loader: &Loader, path: &Path) -> Result<(Self, LeftOut)> {
        let (model, mut left_out) = loader.open(Source::read(path)?, &[])?;
        for joint in
            model.joints().filter(|joint| joint.limited && bounded(joint.range, 0.0) != Some(joint.range))
        {
            let ([least, greatest], name) = (joint.range, joint.name.unwrap_or_default());
            let note = format!(
                "the limits of joint {name}, {least:?} to {greatest:?}, are out of range and ignored"
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
        let loader = Loader { hulls: false, ..Loader::new()? };
        let mut mended = root.clone();
        Ok(if matches!(loader.mended(&mut mended, path), Ok(Ok(_))) { mended } else { root })
    }

    /// Compiles a model from MJCF text; files that it includes or takes meshes from are sought in the
    /// working folder.
    ///
    /// # Errors
    /// As [`Model::from_path`], with [`Model::STRING_NAME`] in place of the file.
    pub fn from_xml(xml: &str) -> Result<Self> {
        Ok(Loader::new()?.open(Source::of_text(Path::new(Self::STRING_NAME), xml)?, &[])?.0)
    }

    /// Reads a file with more bodies in its world, and the meshes that they are made of, given as their elements.
    ///
    /// # Errors
    /// As [`Model::from_path`].
    pub(crate) fn with_bodies(path: impl AsRef<Path>, bodies: Vec<Element>) -> Result<Self> {
        Ok(Loader::bare()?.open(Source::read(path.as_ref())?, &bodies)?.0)
    }

    /// The model in a file as the engine writes it out: includes, composites and replicas as bodies, angles
    /// in radians.
    ///
    /// # Errors
    /// As [`Model::from_path`], and where no temporary file can be written.
    pub(crate) fn written_out(path: &Path) -> Result<String> {
        let loader = Loader { hulls: false, ..Loader::new()? };
        let (model, _) = loader.open(Source::read(path)?, &[])?;
        loader.compiler.write_out(&model)?.map_err(|fault| Refused::file(path, fault))
    }
}

/// Loads models while nobody else does.
struct Loader {
    compiler: Compiler,
    /// Whether the model is to have the hulls of all meshes that it can be touched on, for which it is loaded twice.
    hulls: bool,
    /// Whether the model is to have its textures.
    textures: bool,
}

impl Loader {
    fn new() -> Result<Loader> {
        Ok(Loader { compiler: Compiler::take()?, hulls: true, textures: true })
    }

    /// One that leaves out textures: they may be larger than all else a thousand times, and every copy of the model with them.
    fn bare() -> Result<Loader> {
        Ok(Loader { textures: false, ..Loader::new()? })
    }

    /// What is changed in every tree before the engine reads it.
    fn prepare(&self, root: &mut Element, bodies: &[Element]) {
        // A trunk that stands still would be joined to the world, and its limbs fall apart into creatures of their own; and
        // what is for show alone may be all there is to touch.
        for (name, kept) in [("fusestatic", "false"), ("discardvisual", "false")] {
            if root.setting("compiler", name).is_some() {
                set_compiler(root, name, kept);
            }
        }
        for body in bodies {
            let section = if body.name == "mesh" { "asset" } else { "worldbody" };
            root.section(section).children.push(body.clone());
        }
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
        check(&source)?;
        let first = match source.root.name.as_str() {
            "mujoco" => {
                let mut root = source.root.clone();
                self.prepare(&mut root, bodies);
                match self.mended(&mut root, &source.path)? {
                    Ok(model) => return Ok((model, LeftOut::default())),
                    Err(complaint) => Some(complaint),
                }
            }
            "robot" => None,
            other => return Err(no_model(&source, other)),
        };
        let mut reduced = match &first {
            Some(_) => Reduced::new(&source, &mujoco::schema()?)?,
            None => urdf::to_mjcf(&source)?,
        };
        // Replicas and what is attached are written out there.
        check_numbers(&source, &reduced.root)?;
        self.prepare(&mut reduced.root, bodies);
        source.root = Element::new("mujoco");
        loop {
            let complaint = match self.mended(&mut reduced.root, &source.path)? {
                Ok(model) => return Ok((model, reduced.left_out)),
                Err(complaint) => complaint,
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
            return Err(Error::Read { path, line, message: refusal(&message, self.compiler.version) });
        }
    }

    /// Loads a tree whose assets are sought from the file `path`, or returns why the engine refuses it; where the engine asks
    /// for what changes nothing of where limbs are, the tree gets it.
    ///
    /// # Errors
    /// If the engine itself fails.
    fn mended(&self, root: &mut Element, path: &Path) -> Result<std::result::Result<Model, Complaint>> {
        loop {
            let mut anchored = root.clone();
            move_assets(&mut anchored, &whole_folder_of(path));
            let texts = Texts::new(&anchored, &Compiler::first_text());
            let words = match self.compiler.compile(&texts.texts)? {
                Ok(model) if self.hulls => return Ok(Ok(with_hulls(model, &anchored, &self.compiler))),
                Ok(model) => return Ok(Ok(model)),
                Err(words) => words,
            };
            let complaint = Complaint::new(&words, root, &texts);
            if !mend(root, &complaint) {
                return Ok(Err(complaint));
            }
        }
    }
}

/// A refusal of what is no model.
fn no_model(source: &Source, root: &str) -> Refused {
    let message = match root {
        "mujocoinclude" => {
            "it is a fragment included by other files; give the file that includes it".to_string()
        }
        "sdf" => "it is SDF; convert it to URDF or MJCF first".to_string(),
        _ => format!(
            "it begins with <{root}> and is neither MJCF (<mujoco>) nor URDF (<robot>); give one of these"
        ),
    };
    source.refused(&source.root, message)
}

/// Gives the engine what it asks for; whether there was anything that it does not have yet.
///
/// Newer engines take limits from ranges unless they are told otherwise; and what weighs too little for dynamics can be
/// moved all the same.
fn mend(root: &mut Element, complaint: &Complaint) -> bool {
    let says = |words: &&str| complaint.message.contains(*words);
    if let Some((_, settings)) = SETTINGS.iter().find(|(words, _)| says(words)) {
        let last = root.all("compiler").next_back();
        let given = settings.iter().all(|(name, value)| last.is_some_and(|e| e.get(name) == Some(value)));
        settings.iter().for_each(|(name, value)| set_compiler(root, name, value));
        return !given;
    }
    if SURFACE_FAULTS.iter().any(says) {
        // The geoms of a flat mesh weigh as its surface does.
        let mut changed = false;
        root.each(&mut |e| {
            let of_mesh = e.name == "geom" && e.get("mesh").is_some_and(|mesh| says(&mesh));
            if of_mesh && !e.has("shellinertia") {
                e.set("shellinertia", "true");
                changed = true;
            }
        });
        return changed;
    }
    let Some(body) = complaint.element.and_then(|number| numbered(root, number)) else { return false };
    let has_inertia = body.child("inertial").is_some();
    if TOO_LIGHT.iter().any(says) && body.name == "body" && !has_inertia {
        let [mass, inertia] = LEAST_MASS.map(|(_, least)| least.to_string());
        let moments = [inertia.as_str(); 3].join(" ");
        let least = [("pos", "0 0 0".into()), ("mass", mass), ("diaginertia", moments)];
        body.children.insert(0, element("inertial", &least));
        set_compiler(root, "inertiafromgeom", "auto");
        return true;
    }
    // An inertia that no body can have: it then weighs what its geoms do.
    let impossible = has_inertia && says(&"inertia alternative");
    body.children.retain(|child| !impossible || child.name != "inertial");
    impossible
}
