//! Where the meshes of a model are, and their corners, for what the engine cannot read or whose faces it refuses: what touches is a
//! mesh's convex hull, and its corners are enough for that.

use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::collada;
use super::source::{Refused, Source, whole_folder_of, with_slashes};
use super::tree::Element;

/// The kinds of files that meshes are read from: by the engine, and here alone.
const OF_ENGINE: [&str; 3] = ["stl", "obj", "msh"];
const OF_OTHERS: [&str; 2] = ["ply", "dae"];

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
        None => Some(
            "it has neither a file nor vertices, or is generated by the engine it was written for".into(),
        ),
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
        return Some(format!("neither {place} nor a file of that name beside the model exists"));
    }
    let mut begins = vec![0; POINTER.len()];
    let read = std::fs::File::open(file).and_then(|mut file| file.read_exact(&mut begins));
    if read.is_ok() && begins == POINTER {
        return Some(format!("{place} is a Git LFS pointer, not a mesh; fetch it with `git lfs pull`"));
    }
    (!OF_ENGINE.contains(&kind(file).as_str()) && !is_of_others(file))
        .then(|| format!("{place} is not STL, OBJ, PLY, DAE or MSH; convert it to one of these"))
}

/// Greatest bytes of a mesh's file.
const GREATEST_FILE: u64 = 256 << 20;
/// The corners of a hull at least.
const LEAST: usize = 4;
/// A mesh is flat where it is less thick than this part of its length: no hull can be made of it.
const FLAT: f64 = 1e-6;

/// The corners in a file of STL, OBJ, PLY or COLLADA, each once; `None` if it holds none, is malformed or flat.
pub(super) fn corners(file: &Path) -> Option<Vec<[f32; 3]>> {
    let mut seen = BTreeSet::new();
    let once: Vec<[f32; 3]> =
        all_corners(file)?.into_iter().filter(|corner| seen.insert(corner.map(f32::to_bits))).collect();
    (once.len() >= LEAST && !is_flat(&once)).then_some(once)
}

/// Whether a file can be read as what its name says, and has corners.
pub(super) fn holds_corners(file: &Path) -> bool {
    all_corners(file).is_some_and(|corners| !corners.is_empty())
}

/// Whether a file is of a kind that the engine does not read, but whose corners are read here.
pub(super) fn is_of_others(file: &Path) -> bool {
    OF_OTHERS.contains(&kind(file).as_str())
}

/// The kind of a file by its name, in small letters.
fn kind(file: &Path) -> String {
    file.extension().and_then(|kind| kind.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// All corners in a file, as often as they occur.
fn all_corners(file: &Path) -> Option<Vec<[f32; 3]>> {
    if std::fs::metadata(file).ok()?.len() > GREATEST_FILE {
        return None;
    }
    let bytes = std::fs::read(file).ok()?;
    let all = match kind(file).as_str() {
        "stl" => binary_stl(&bytes).or_else(|| text_stl(&bytes))?,
        "obj" => obj(&bytes)?,
        "ply" => ply(&bytes)?,
        "dae" => collada::corners(&bytes)?,
        _ => return None,
    };
    all.iter().flatten().all(|x| x.is_finite()).then_some(all)
}

/// Whether corners lie in a plane.
fn is_flat(corners: &[[f32; 3]]) -> bool {
    let points = || corners.iter().map(|corner| nalgebra::Vector3::from(corner.map(f64::from)));
    let mean = points().sum::<nalgebra::Vector3<f64>>() / corners.len() as f64;
    let spread: nalgebra::Matrix3<f64> =
        points().map(|point| (point - mean) * (point - mean).transpose()).sum();
    let spread = spread.symmetric_eigenvalues();
    // The spread is that of squares.
    spread.min() <= FLAT * FLAT * spread.max()
}

/// Each of its triangles is a normal, three corners and two bytes; it is as long as it says.
fn binary_stl(bytes: &[u8]) -> Option<Vec<[f32; 3]>> {
    const HEAD: usize = 84;
    const TRIANGLE: usize = 50;
    let count = u32::from_le_bytes(bytes.get(HEAD - 4..HEAD)?.try_into().ok()?) as usize;
    let triangles = bytes.get(HEAD..HEAD + count.checked_mul(TRIANGLE)?)?;
    let corner = |bytes: &[u8]| [0, 4, 8].map(|at| f32::from_le_bytes([0, 1, 2, 3].map(|k| bytes[at + k])));
    Some(
        triangles
            .chunks_exact(TRIANGLE)
            .flat_map(|t| [12, 24, 36].map(|at| corner(&t[at..at + 12])))
            .collect(),
    )
}

fn text_stl(bytes: &[u8]) -> Option<Vec<[f32; 3]>> {
    bytes.trim_ascii_start().starts_with(b"solid").then(|| lines_of("vertex", bytes))?
}

fn obj(bytes: &[u8]) -> Option<Vec<[f32; 3]>> {
    lines_of("v", bytes)
}

/// The first three numbers of all lines that begin with a word; `None` if one has fewer.
fn lines_of(word: &str, bytes: &[u8]) -> Option<Vec<[f32; 3]>> {
    let text = String::from_utf8_lossy(bytes);
    let lines = text.lines().filter_map(|line| {
        let mut tokens = line.split_whitespace();
        (tokens.next() == Some(word)).then_some(tokens)
    });
    lines.map(three).collect()
}

fn three<'t>(mut tokens: impl Iterator<Item = &'t str>) -> Option<[f32; 3]> {
    let mut next = || tokens.next()?.parse::<f32>().ok();
    Some([next()?, next()?, next()?])
}

/// PLY of text: its corners are the first of its elements.
fn ply(bytes: &[u8]) -> Option<Vec<[f32; 3]>> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    (lines.next()? == ["ply"]).then_some(())?;
    let (mut count, mut names) = (None, Vec::new());
    loop {
        match lines.next()?.as_slice() {
            ["format", "ascii", _] | ["comment" | "obj_info", ..] => {}
            ["element", "vertex", number] if count.is_none() => count = Some(number.parse::<usize>().ok()?),
            ["property", _, name] => names.push(name.to_string()),
            ["end_header"] => break,
            // Where corners are comes after what there is of them; elements before them are not known of.
            _ if count.is_none() => return None,
            _ => names.push(String::new()),
        }
    }
    let at = |name: &str| names.iter().position(|own| own == name);
    let places = [at("x")?, at("y")?, at("z")?];
    let rows = lines.take(count?);
    let corners = rows.map(|row| three(places.into_iter().filter_map(|k| row.get(k).copied())));
    let corners: Vec<[f32; 3]> = corners.collect::<Option<_>>()?;
    (Some(corners.len()) == count).then_some(corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];

    fn read(name: &str, bytes: &[u8]) -> Option<Vec<[f32; 3]>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        corners(&path)
    }

    /// The corners a line each, after a word.
    fn lines(word: &str) -> String {
        CORNERS.iter().map(|[x, y, z]| format!("{word} {x} {y} {z}\n")).collect()
    }

    #[test]
    fn the_same_corners_are_read_from_every_kind_of_file() {
        let mut stl = vec![b's'; 80];
        stl.extend(2u32.to_le_bytes());
        for triangle in [[0, 1, 2], [1, 2, 3]] {
            stl.extend([0; 12]);
            stl.extend(triangle.iter().flat_map(|&k: &usize| CORNERS[k]).flat_map(f32::to_le_bytes));
            stl.extend([0; 2]);
        }
        assert_eq!(read("a.STL", &stl).unwrap(), CORNERS);
        assert_eq!(read("a.stl", &stl[..stl.len() - 1]), None, "it is cut off");
        assert_eq!(
            read("a.stl", format!("solid a\n{}endsolid", lines(" vertex")).as_bytes()).unwrap(),
            CORNERS
        );
        assert_eq!(
            read("a.obj", format!("# v\n{}f 1 2 3\n{}", lines("v"), lines("v")).as_bytes()).unwrap(),
            CORNERS
        );
        let head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty uchar red\nproperty float x\nproperty float y\n\
                    property float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n";
        let ply = format!("{head}{}", lines("7"));
        assert_eq!(read("a.ply", ply.as_bytes()).unwrap(), CORNERS);
        assert_eq!(read("a.ply", &ply.as_bytes()[..ply.len() - 8]), None, "it is cut off");
    }

    #[test]
    fn what_makes_no_hull_has_no_corners() {
        let flat = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
        for (name, text) in [
            ("flat.obj", flat),
            ("few.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
            ("wrong.obj", &format!("{}v a b c\n", lines("v"))),
            ("nan.obj", &format!("{}v nan 0 0\n", lines("v"))),
            ("empty.obj", ""),
            ("empty.stl", ""),
            ("empty.ply", ""),
            ("empty.dae", "<COLLADA/>"),
            ("other.glb", "glTF"),
        ] {
            assert_eq!(read(name, text.as_bytes()), None, "{name}");
        }
    }
}
