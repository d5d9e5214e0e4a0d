//! Convex hulls for the meshes that limbs are made of.
//!
//! What touches is a mesh's convex hull, but the engine makes the hulls of those meshes alone that collide by their file;
//! of others it has nothing but the vertices, looks through all of them each time, and no skin grows on them. Where all of
//! a rigid part is for show alone, that is what it is touched on: the model is then compiled once more with those
//! geoms colliding, and given the filters that its file has.

use std::collections::BTreeSet;

use super::tree::Element;
use super::write::Texts;
use crate::mujoco::{Compiler, GeomKind, Model};

/// The model with the hulls of all meshes that its parts can be touched on, of the tree that it was read from; as it is where
/// the engine can make no more of them.
pub(super) fn with_hulls(model: Model, root: &Element, compiler: &Compiler) -> Model {
    let mut wanted = meshes_without_hull(&model);
    while !wanted.is_empty() {
        let mut opened = root.clone();
        if open(opened.section("worldbody"), &wanted) == 0 {
            break;
        }
        match compiler.compile(&Texts::new(&opened, &Compiler::first_text()).texts) {
            Ok(Ok(mut opened)) => return if opened.take_filters(&model) { opened } else { model },
            Ok(Err(words)) => {
                // A mesh that has no hull, such as a flat one, must not be in the way of the others.
                let named = wanted.iter().filter(|mesh| words.contains(mesh.as_str()));
                let Some(mesh) = named.max_by_key(|mesh| mesh.len()).cloned() else { break };
                wanted.remove(&mesh);
            }
            Err(_) => break,
        }
    }
    model
}

/// Lets the geoms below an element collide that are of these meshes, or may be by their class; how many there are.
fn open(element: &mut Element, meshes: &BTreeSet<String>) -> usize {
    let mut opened = 0;
    element.each(&mut |child| {
        let may_be_of_class = child.get("type").is_none_or(|kind| kind == "mesh");
        if child.name == "geom" && child.get("mesh").map_or(may_be_of_class, |mesh| meshes.contains(mesh)) {
            child.set("contype", "1");
            opened += 1;
        }
    });
    opened
}

/// The names of the meshes without a hull of parts of which nothing collides.
fn meshes_without_hull(model: &Model) -> BTreeSet<String> {
    let of_bodies: Vec<bool> = (0..model.ngeom()).map(|geom| model.geom_body(geom) > 0).collect();
    let surface = model.surface_among(&of_bodies);
    let shown = (0..model.ngeom()).filter(|&geom| {
        surface[geom] && model.geom_kind(geom) == GeomKind::Mesh && model.contact_bits(geom) == (0, 0)
    });
    shown
        .filter_map(|geom| model.mesh_of_geom(geom))
        .filter_map(|mesh| model.name_without_hull(mesh))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHOWN: &str = r#"<mujoco>
  <asset>
    <mesh name="brick" vertex="-1 -1 -1 -1 -1 1 -1 1 -1 -1 1 1 1 -1 -1 1 -1 1 1 1 -1 1 1 1" scale=".1 .1 .1"
      face="0 1 3 0 3 2 4 6 7 4 7 5 0 4 5 0 5 1 2 3 7 2 7 6 0 2 6 0 6 4 1 5 7 1 7 3"/>
    <mesh name="shell" vertex="-1 -1 -1 -1 -1 1 -1 1 -1 -1 1 1 1 -1 -1 1 -1 1 1 1 -1 1 1 1" scale=".2 .2 .2"
      face="0 1 3 0 3 2 4 6 7 4 7 5 0 4 5 0 5 1 2 3 7 2 7 6 0 2 6 0 6 4 1 5 7 1 7 3"/>
  </asset>
  <default><default class="shown"><geom type="mesh" mesh="brick" contype="0" conaffinity="0"/></default></default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="base">
      <geom class="shown"/>
      <body name="arm" pos=".5 0 0"><joint/>
        <geom class="shown" mesh="brick"/>
        <body name="hand" pos=".5 0 0"><joint/>
          <geom class="shown" mesh="shell"/><geom type="sphere" size=".1"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"#;

    #[test]
    fn what_is_for_show_alone_has_a_hull_where_nothing_else_is_touched_and_its_filters_stay() {
        let model = Model::from_xml(SHOWN).unwrap();
        let hulls: Vec<bool> = (0..model.ngeom()).map(|geom| model.mesh_hull(geom).is_some()).collect();
        // The plane, base, arm, the hand's shell over its sphere, and the sphere.
        assert_eq!(hulls, [false, true, true, false, false]);
        let bits: Vec<(i32, i32)> = (0..model.ngeom()).map(|geom| model.contact_bits(geom)).collect();
        assert_eq!(bits, [(1, 1), (0, 0), (0, 0), (0, 0), (1, 1)]);
    }

    #[test]
    fn a_file_is_read_like_text() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("shown.xml");
        std::fs::write(&path, SHOWN).unwrap();
        let model = Model::from_path(&path).unwrap();
        assert!(model.mesh_hull(2).is_some());
        assert_eq!(model.contact_bits(2), (0, 0));
    }

    #[test]
    fn a_model_that_needs_no_hull_is_not_compiled_again() {
        let model = Model::from_xml(&SHOWN.replace(r#" contype="0" conaffinity="0""#, "")).unwrap();
        assert!(meshes_without_hull(&model).is_empty());
        let model = Model::from_xml(SHOWN).unwrap();
        assert!(meshes_without_hull(&model).is_empty(), "all that there can be are made at once");
    }
}
