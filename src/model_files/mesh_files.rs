//! Where the meshes of a model are.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::mesh_corners::{corners, holds_corners, kind};
use super::source::{Refused, Source, whole_folder_of, with_slashes};
use super::tree::Element;

/// The kinds of files that meshes are read from: those of the engine, and PLY here.
const KINDS: [&str; 4] = ["stl", "obj", "msh", "ply"];

/// How a file begins that Git LFS has in the place of another.
const POINTER: &[u8] = b"version https://git-lfs.github.com/spec/";

/// Where a model's meshes are sought, and whether files keep but their names.
pub(super) struct MeshFolder {
    /// The folder that the model names, and its own.
    folders: Vec<PathBuf>,
    bare: bool,
}

impl MeshFolder {
    /// By the settings of a model's compiler, which URDF has in an element of its own.
    pub fn of(source: &Source) -> MeshFolder {
        let root = &source.root;
        let setting = |name: &str| {
            let of_urdf = root.child("mujoco").and_then(|own| own.setting("compiler", name));
            of_urdf.or_else(|| root.setting("compiler", name))
        };
        let folder = whole_folder_of(&source.path);
        let own = setting("meshdir").or_else(|| setting("assetdir"));
        let mut folders: Vec<PathBuf> = own.map(|own| folder.join(with_slashes(own))).into_iter().collect();
        folders.push(folder);
        MeshFolder { folders, bare: setting("strippath") == Some("true") }
    }

    /// Gives a mesh the whole path of its file, and a name: that of the file where it has none of its own.
    pub fn settle(&self, mesh: &mut Element) {
        if let Some(name) = mesh_name(mesh) {
            mesh.set("name", name);
        }
        if let Some(file) = mesh.get_mut("file") {
            *file = self.find(file).display().to_string();
        }
    }

    /// The file that a name means, which people copy, rename and pack otherwise than the model has it; where there is none,
    /// the one that it says.
    pub fn find(&self, name: &str) -> PathBuf {
        let plain = with_slashes(name);
        let plain = if self.bare { plain.rsplit('/').next().unwrap_or_default().to_string() } else { plain };
        let all: Vec<PathBuf> =
            [plain.clone(), unescaped(&plain)].iter().flat_map(|name| self.meant(name)).collect();
        let found = all.iter().find(|path| path.is_file()).cloned();
        let near = || all.iter().filter(|path| self.is_near(path)).find_map(|path| in_any_case(path));
        found.or_else(near).or(all.into_iter().next()).unwrap_or_default()
    }

    /// The paths that a name may mean, likeliest first.
    fn meant(&self, name: &str) -> Vec<PathBuf> {
        let home = self.folders.last().expect("the model's own folder");
        let packaged = ["package://", "model://"].iter().find_map(|scheme| name.strip_prefix(scheme));
        let path = packaged.or_else(|| {
            ["file://localhost", "file://", "file:"].iter().find_map(|scheme| name.strip_prefix(scheme))
        });
        let path = path.unwrap_or(name);
        let mut meant = Vec::new();
        if packaged.is_some() {
            // A package is one of the folders above, or beside one of these.
            let inside = path.split_once('/').map_or(path, |(_, inside)| inside);
            meant.extend(home.ancestors().flat_map(|above| [above.join(path), above.join(inside)]));
        } else {
            meant.extend(self.folders.iter().map(|folder| folder.join(path)));
        }
        // Copied into fewer folders than it was in, the bare name last.
        let parts: Vec<&str> = path.split('/').filter(|part| !matches!(*part, "" | "." | "..")).collect();
        let Some((bare, above)) = parts.split_last() else { return meant };
        let kept = (0..above.len()).flat_map(|k| (k + 1..=above.len()).rev().map(move |end| (k, end)));
        let kept = kept.map(|(k, end)| format!("{}/{bare}", above[k..end].join("/")));
        for path in kept.chain([bare.to_string()]) {
            meant.extend(self.near().map(|folder| folder.join(&path)));
        }
        meant
    }

    /// The folders that a model's own files are in.
    fn near(&self) -> impl Iterator<Item = &Path> {
        let beside = self.folders.last().and_then(|home| home.parent());
        self.folders.iter().map(PathBuf::as_path).chain(beside)
    }

    fn is_near(&self, path: &Path) -> bool {
        self.near().any(|folder| path.starts_with(folder))
    }
}

/// A text with the characters that `%20` and the like stand for.
fn unescaped(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, after @ ..] = rest {
        let digits = after.get(..2).filter(|_| *first == b'%').and_then(|two| std::str::from_utf8(two).ok());
        let escaped = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(escaped.unwrap_or(*first));
        rest = if escaped.is_some() { &after[2..] } else { after };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The file of a path whose letters may be small or capital.
fn in_any_case(path: &Path) -> Option<PathBuf> {
    let mut found = PathBuf::new();
    for part in path.components() {
        let exact = found.join(part);
        if exact.exists() {
            found = exact;
            continue;
        }
        let mut same: Vec<PathBuf> = std::fs::read_dir(&found)
            .ok()?
            .flatten()
            .filter(|entry| entry.file_name().eq_ignore_ascii_case(part.as_os_str()))
            .map(|entry| entry.path())
            .collect();
        same.sort();
        found = same.into_iter().next()?;
    }
    found.is_file().then_some(found)
}

/// A mesh's name, or that of its file.
pub(super) fn mesh_name(mesh: &Element) -> Option<String> {
    let stem = || Path::new(mesh.get("file")?).file_stem()?.to_str().map(str::to_string);
    mesh.get("name").map(str::to_string).or_else(stem)
}

/// Gives a mesh the corners of its file in the place of the file, or takes its faces from it, so that the engine makes its
/// hull; whether there was anything to be changed.
pub(super) fn take_corners(mesh: &mut Element) -> bool {
    if let Some(corners) = mesh.get("file").and_then(|file| corners(Path::new(file))) {
        let corners: Vec<String> = corners.as_flattened().iter().map(f32::to_string).collect();
        mesh.remove("file");
        mesh.set("vertex", corners.join(" "));
        return true;
    }
    mesh.has("vertex") && mesh.remove("face").is_some()
}

/// A refusal of MJCF by the first of its meshes whose file cannot be read, where there is one.
pub(crate) fn unreadable_mesh(path: &Path) -> Option<Refused> {
    let source = Source::read(path).ok()?;
    let folder = MeshFolder::of(&source);
    let mut meshes = source.root.all("asset").flat_map(|e| &e.children).filter(|e| e.name == "mesh");
    meshes.find_map(|mesh| {
        let mut settled = mesh.clone();
        folder.settle(&mut settled);
        let file = PathBuf::from(settled.get("file")?);
        let sound = kind(&file) == "msh" || corners(&file).is_some();
        (file.is_file() && !sound).then(|| {
            let message = format!(
                "the mesh {} cannot be read as STL or OBJ; correct the file or the path there",
                file.display()
            );
            source.refused(mesh, message)
        })
    })
}

/// Why the engine cannot read a mesh, as far as that can be told from outside.
pub(super) fn fault(mesh: &Element) -> Option<String> {
    if mesh.get("vertex").is_some() {
        return None;
    }
    match mesh.get("file") {
        Some(file) => found_fault(Path::new(file)),
        None => Some("it has neither file nor vertices, or is made by the engine it was written for".into()),
    }
}

/// Why a mesh's file cannot be read, its content included.
pub(super) fn file_fault(file: &Path) -> Option<String> {
    let unreadable = || kind(file) != "msh" && !holds_corners(file);
    let message =
        || format!("{} cannot be read as {}; correct it", file.display(), kind(file).to_uppercase());
    found_fault(file).or_else(|| unreadable().then(message))
}

/// The same by its name and first bytes alone.
fn found_fault(file: &Path) -> Option<String> {
    let place = file.display();
    if !file.is_file() {
        return Some(format!("there is no {place}, nor such a file beside the model"));
    }
    let mut begins = vec![0; POINTER.len()];
    let read = std::fs::File::open(file).and_then(|mut file| file.read_exact(&mut begins));
    if read.is_ok() && begins == POINTER {
        return Some(format!("{place} is a pointer of Git LFS and no mesh; fetch it with `git lfs pull`"));
    }
    (!KINDS.contains(&kind(file).as_str()))
        .then(|| format!("{place} is not STL, OBJ, PLY or MSH; convert it to one of these"))
}
