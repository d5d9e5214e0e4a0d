//! A somatotopic map as a file: the neighbours of every receptor, by their ids.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::stamp::Stamp;
use crate::error::Error;
use crate::skin::{MOST_NEIGHBOURS, Skin, SomatotopicMap};

const STAMP: Stamp = Stamp { format: "bodyschema map", version: 1 };

/// What a file has beside its stamp.
#[derive(Serialize, Deserialize)]
struct MapContent {
    creature: String,
    /// Per receptor its neighbours, nearest first.
    neighbours: BTreeMap<String, Vec<String>>,
}

/// Writes a map of a creature's skin to `path`: per receptor its neighbours, nearest first.
///
/// # Errors
/// If the file cannot be written.
pub fn write_map(path: &Path, creature: &str, skin: &Skin, map: &SomatotopicMap) -> Result<(), Error> {
    let id = |receptor: usize| skin.receptors[receptor].id.clone();
    let of = |receptor: usize| map.neighbours(receptor).iter().map(|&other| id(other)).collect();
    let neighbours = (0..map.receptors()).map(|receptor| (id(receptor), of(receptor))).collect();
    STAMP.write(path, &MapContent { creature: creature.to_string(), neighbours })
}

/// Reads the map of a creature's skin from `path`.
///
/// # Errors
/// If the file cannot be read; or if it is no map or one of a newer
/// version, where it is of another creature or names other receptors than the skin has, where a receptor has more than eight neighbours, or is its own, and where one of two receptors has the other for a neighbour, but not
/// the other way round.
pub fn read_map(path: &Path, creature: &str, skin: &Skin) -> Result<SomatotopicMap, Error> {
    let read: MapContent = STAMP.read(path, "map of neighbours")?;
    let refuse = |message: String| Err(Error::content(path, None, message));
    if read.creature != creature {
        return refuse(format!(
            "it is a map of \"{}\", not of \"{creature}\": give the one that `bodyschema skin map` wrote for this creature",
            read.creature
        ));
    }
    let numbers = skin.numbers();
    let number = |id: &str| {
        numbers.get(id).copied().ok_or_else(|| {
            let message = format!(
                "{creature} has no receptor \"{id}\": remove it, or give the map of this skin (`bodyschema \
                 inspect` lists the receptors)"
            );
            Error::content(path, None, message)
        })
    };
    let mut neighbours: Vec<Option<Vec<usize>>> = vec![None; skin.receptors.len()];
    for (id, others) in &read.neighbours {
        let receptor = number(id)?;
        let found = others.iter().map(|other| number(other)).collect::<Result<Vec<usize>, Error>>()?;
        if found.contains(&receptor) {
            return refuse(format!("\"{id}\" is its own neighbour: remove it from its list"));
        }
        if let Some(twice) = (1..found.len()).find(|k| found[..*k].contains(&found[*k])) {
            let other = &others[twice];
            return refuse(format!("\"{id}\" lists its neighbour \"{other}\" twice: remove one"));
        }
        if found.len() > MOST_NEIGHBOURS {
            let count = found.len();
            return refuse(format!(
                "\"{id}\" has {count} neighbours: keep only the nearest, at most {MOST_NEIGHBOURS}"
            ));
        }
        neighbours[receptor] = Some(found);
    }
    if let Some(missing) = neighbours.iter().position(Option::is_none) {
        return refuse(format!(
            "it lists {} of the {} receptors of {creature}, and \"{}\" is none of them: give the map of this \
             skin; a receptor without neighbours has an empty list",
            neighbours.iter().flatten().count(),
            neighbours.len(),
            skin.receptors[missing].id
        ));
    }
    let neighbours: Vec<Vec<usize>> = neighbours.into_iter().flatten().collect();
    for (receptor, of) in neighbours.iter().enumerate() {
        if let Some(&other) = of.iter().find(|&&other| !neighbours[other].contains(&receptor)) {
            let [id, other] = [receptor, other].map(|r| &skin.receptors[r].id);
            return refuse(format!(
                "\"{id}\" lists its neighbour \"{other}\", but not the other way round: add \"{id}\" to the list \
                 of \"{other}\", or remove it"
            ));
        }
    }
    Ok(SomatotopicMap::of_lists(neighbours))
}
