//! What of a body's senses can be drawn over it: the aura about its limbs, and which receptors are neighbours.

use nalgebra::{Point3, Vector3};

use crate::geometry::Frame;
use crate::mujoco::Mark;
use crate::skin::{ProximityGeometry, Skin, SomatotopicMap};

/// The colours of auras, one after the other along the limbs, so that each is told from those beside it, …
const AURAS: [[f32; 3]; 5] =
    [[0.20, 0.55, 0.95], [0.10, 0.70, 0.60], [0.60, 0.45, 0.90], [0.95, 0.60, 0.20], [0.90, 0.35, 0.50]];
/// … and how opaque each is: some ten of Max's lie before each other.
const AURA_OPACITY: f32 = 0.055;
/// Neighbours on a limb, those across limbs, and receptors that have none: seen on skin as on dark clothes.
const WITHIN: [f32; 4] = [1.0, 0.8, 0.1, 1.0];
const ACROSS: [f32; 4] = [1.0, 0.2, 0.6, 1.0];
const ALONE: [f32; 4] = [0.9, 0.1, 0.1, 1.0];
/// By the size of a body: how thick a line is, a receptor's dot, and how high above the skin both are.
const LINE_RADIUS: f64 = 0.0009;
const DOT_RADIUS: f64 = 0.0022;
const LIFT: f64 = 0.002;
/// Straight pieces of a line round a limb, where there are few enough lines for that.
const PIECES: usize = 4;
const MOST_BENT: usize = 10_000;

/// Auras where limbs are at `X_WL`.
pub fn auras(geometries: &[ProximityGeometry], frames: &[Frame]) -> Vec<Mark> {
    let mark = |(number, geometry): (usize, &ProximityGeometry)| {
        let capsule = geometry.capsule.placed(&frames[geometry.limb]);
        let [red, green, blue] = AURAS[number % AURAS.len()];
        let rgba = [red, green, blue, AURA_OPACITY];
        Mark { emission: 0.5, ..Mark::capsule(capsule.ends.map(Point3::from), capsule.radius, rgba) }
    };
    geometries.iter().enumerate().map(mark).collect()
}

/// Receptors as dots, and a line between any two that are neighbours, along the skin, where limbs are at `X_WL`. `size` is
/// the body's, metres.
pub fn map(skin: &Skin, map: &SomatotopicMap, frames: &[Frame], size: f64) -> Vec<Mark> {
    let places: Vec<(Vector3<f64>, Vector3<f64>)> = skin
        .receptors
        .iter()
        .map(|receptor| {
            let frame = &frames[receptor.limb];
            let out = frame.rotation * receptor.normal;
            (frame.point(&receptor.position) + out * (LIFT * size), out)
        })
        .collect();
    let pairs: Vec<[usize; 2]> = map.pairs().collect();
    let pieces = if pairs.len() <= MOST_BENT { PIECES } else { 1 };
    let mut marks = Vec::new();
    for (receptor, (place, _)) in places.iter().enumerate() {
        let alone = map.neighbours(receptor).is_empty();
        let (radius, colour) = if alone { (2.0 * DOT_RADIUS, ALONE) } else { (DOT_RADIUS, WITHIN) };
        marks.push(shining(Mark::sphere(&Point3::from(*place), radius * size, colour)));
    }
    for [a, b] in pairs {
        let across = skin.receptors[a].limb != skin.receptors[b].limb;
        let colour = if across { ACROSS } else { WITHIN };
        let line = along_the_skin([places[a], places[b]], pieces);
        for ends in line.windows(2) {
            let ends = [ends[0], ends[1]].map(Point3::from);
            marks.push(shining(Mark::capsule(ends, LINE_RADIUS * size, colour)));
        }
    }
    marks
}

fn shining(mark: Mark) -> Mark {
    Mark { emission: 0.6, ..mark }
}

/// Points of a line from one place to another, each with its outward normal: it rises over the straight way as the arc of
/// a circle with these normals does.
fn along_the_skin([from, to]: [(Vector3<f64>, Vector3<f64>); 2], pieces: usize) -> Vec<Vector3<f64>> {
    let turn = from.1.dot(&to.1).clamp(-1.0, 1.0).acos();
    let out = (from.1 + to.1).try_normalize(1e-3).unwrap_or_default();
    // Along a limb it is straight: only what goes round it rises.
    let round = (to.1 - from.1).try_normalize(1e-3).unwrap_or_default();
    let rise = 0.5 * (to.0 - from.0).dot(&round).abs() * (0.25 * turn).tan();
    (0..=pieces)
        .map(|k| k as f64 / pieces as f64)
        .map(|share| from.0.lerp(&to.0, share) + out * (4.0 * share * (1.0 - share) * rise))
        .collect()
}
