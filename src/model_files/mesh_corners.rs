//! The corners of a mesh's file, for what the engine cannot read or whose faces it refuses: what touches is a mesh's convex
//! hull, and its corners are enough for that.

use std::collections::BTreeSet;
use std::path::Path;

/// Greatest bytes of a mesh's file.
const GREATEST_FILE: u64 = 256 << 20;
/// The corners of a hull at least.
const LEAST: usize = 4;
/// A mesh is flat where it is less thick than this part of its length: no hull can be made of it.
const FLAT: f64 = 1e-6;

/// The corners in a file of STL, OBJ or PLY, each once; none where it holds none, is malformed or flat.
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

/// The kind of a file by its name, in small letters.
pub(super) fn kind(file: &Path) -> String {
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

/// The first three numbers of all lines that begin with a word; none where one has fewer.
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
            ("other.dae", "<COLLADA/>"),
        ] {
            assert_eq!(read(name, text.as_bytes()), None, "{name}");
        }
    }
}
