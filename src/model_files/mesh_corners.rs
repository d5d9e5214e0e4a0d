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

/// Its corners are the first of its elements, as text or in bytes.
fn ply(bytes: &[u8]) -> Option<Vec<[f32; 3]>> {
    const END: &[u8] = b"end_header";
    let end = bytes.windows(END.len()).position(|window| window == END)?;
    let head = String::from_utf8_lossy(&bytes[..end]);
    let body = &bytes[end + END.len()..];
    let body = &body[body.iter().position(|&byte| byte == b'\n')? + 1..];
    let mut lines = head.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    (lines.next()? == ["ply"]).then_some(())?;
    let (mut format, mut count, mut properties) = (None, None, Vec::new());
    for line in lines {
        match line.as_slice() {
            ["format", kind, _] => format = Some(kind.to_string()),
            ["element", "vertex", number] if count.is_none() => count = Some(number.parse::<usize>().ok()?),
            // Where corners are comes after what there is of them; elements before them are not known of.
            ["element", ..] if count.is_none() => return None,
            ["element", ..] => break,
            ["property", kind, name] => properties.push((kind.to_string(), name.to_string())),
            ["property", ..] => return None,
            _ => {}
        }
    }
    let at = |name: &str| properties.iter().position(|(_, own)| own == name);
    let places = [at("x")?, at("y")?, at("z")?];
    let count = count?;
    if format.as_deref() == Some("ascii") {
        let text = String::from_utf8_lossy(body);
        let rows = text.lines().take(count).map(|line| line.split_whitespace().collect::<Vec<_>>());
        let corners = rows.map(|row| three(places.into_iter().filter_map(|k| row.get(k).copied())));
        let corners: Vec<[f32; 3]> = corners.collect::<Option<_>>()?;
        return (corners.len() == count).then_some(corners);
    }
    let little = match format?.as_str() {
        "binary_little_endian" => true,
        "binary_big_endian" => false,
        _ => return None,
    };
    let sizes: Vec<usize> = properties.iter().map(|(kind, _)| size(kind)).collect::<Option<_>>()?;
    let start = |property: usize| sizes[..property].iter().sum::<usize>();
    let row: usize = sizes.iter().sum();
    let rows = body.get(..row.checked_mul(count)?)?.chunks_exact(row);
    let number = |row: &[u8], property: usize| {
        let mut bytes = row[start(property)..start(property) + sizes[property]].to_vec();
        if !little {
            bytes.reverse();
        }
        match properties[property].0.as_str() {
            "float" | "float32" => Some(f32::from_le_bytes(bytes.try_into().ok()?)),
            "double" | "float64" => Some(f64::from_le_bytes(bytes.try_into().ok()?) as f32),
            _ => None,
        }
    };
    rows.map(|row| Some([number(row, places[0])?, number(row, places[1])?, number(row, places[2])?]))
        .collect()
}

/// The bytes of a number of PLY.
fn size(kind: &str) -> Option<usize> {
    match kind {
        "char" | "uchar" | "int8" | "uint8" => Some(1),
        "short" | "ushort" | "int16" | "uint16" => Some(2),
        "int" | "uint" | "int32" | "uint32" | "float" | "float32" => Some(4),
        "double" | "float64" => Some(8),
        _ => None,
    }
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
        let head = |format: &str, kind: &str| {
            format!(
                "ply\nformat {format} 1.0\nelement vertex 4\nproperty uchar red\nproperty {kind} x\nproperty {kind} y\n\
                 property {kind} z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n"
            )
        };
        assert_eq!(read("a.ply", (head("ascii", "float") + &lines("7")).as_bytes()).unwrap(), CORNERS);
        let mut little = head("binary_little_endian", "double").into_bytes();
        let mut big = head("binary_big_endian", "float").into_bytes();
        for corner in CORNERS {
            little.push(7);
            little.extend(corner.iter().flat_map(|&x| f64::from(x).to_le_bytes()));
            big.push(7);
            big.extend(corner.iter().flat_map(|x| x.to_be_bytes()));
        }
        assert_eq!(read("a.ply", &little).unwrap(), CORNERS);
        assert_eq!(read("a.ply", &big).unwrap(), CORNERS);
        assert_eq!(read("a.ply", &big[..big.len() - 1]), None, "it is cut off");
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
