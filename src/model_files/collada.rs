//! The corners of COLLADA files (.dae), which many models in URDF have their meshes in.
//!
//! A file holds geometries, and nodes that place them, each with its transformations in the order in which they are applied
//! (COLLADA 1.4.1, 2008). Lengths are in the file's unit; which way is up counts for nothing, as in ROS.

use std::cell::Cell;
use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Matrix4, Point3, Rotation3, Unit, Vector3};

use super::source::{first_tag, parse, text_from};
use super::tree::{Element, numbers};

/// The elements that say where a node is.
const MOVES: [&str; 4] = ["matrix", "translate", "scale", "rotate"];
/// Nodes at the most, one in the other and in all: what places itself would go on for ever, or nearly.
const DEEPEST: usize = 100;
const MOST: usize = 100_000;
/// Corners at the most: what places a large mesh again and again would fill the memory.
const MOST_CORNERS: usize = 10_000_000;

/// A file's text and what is in it.
struct Collada<'t> {
    text: &'t str,
    /// What can be called, the first of a name and an `id`.
    called: HashMap<[&'t str; 2], &'t Element>,
    /// How many nodes were placed.
    placed: Cell<usize>,
}

/// All corners in a file, as often as they are placed, metres; `None` where it is malformed, or these are too many.
pub(super) fn corners(bytes: &[u8]) -> Option<Vec<[f32; 3]>> {
    let text = text_from(bytes);
    let root = parse(Path::new(""), &text).ok().filter(|root| root.name == "COLLADA")?;
    let mut file = Collada { text: &text, called: HashMap::new(), placed: Cell::new(0) };
    for (id, element) in root.descendants().filter_map(|element| Some((element.get("id")?, element))) {
        file.called.entry([element.name.as_str(), id]).or_insert(element);
    }
    let unit = root.child("asset").and_then(|asset| asset.child("unit")?.number("meter"));
    let metres = Matrix4::new_scaling(unit.unwrap_or(1.0));
    let mut corners = Vec::new();
    let scenes = root.all("library_visual_scenes").flat_map(|library| &library.children);
    for node in scenes.flat_map(|scene| scene.all("node")) {
        file.place(node, &metres, DEEPEST, &mut corners)?;
    }
    Some(corners)
}

impl Collada<'_> {
    /// Adds the corners of what a node places, given where its parent is.
    fn place(
        &self,
        node: &Element,
        parent: &Matrix4<f64>,
        deepest: usize,
        corners: &mut Vec<[f32; 3]>,
    ) -> Option<()> {
        let deeper = deepest.checked_sub(1)?;
        self.placed.set(self.placed.get() + 1);
        if self.placed.get() > MOST {
            return None;
        }
        let mut at = *parent;
        for child in node.children.iter().filter(|child| MOVES.contains(&child.name.as_str())) {
            at *= match (child.name.as_str(), numbers(self.content(child)?).as_slice()) {
                ("matrix", all) if all.len() == 16 => Matrix4::from_row_slice(all),
                ("translate", &[x, y, z]) => Matrix4::new_translation(&Vector3::new(x, y, z)),
                ("scale", &[x, y, z]) => Matrix4::new_nonuniform_scaling(&Vector3::new(x, y, z)),
                ("rotate", &[x, y, z, degrees]) => {
                    let axis = Unit::try_new(Vector3::new(x, y, z), f64::MIN_POSITIVE)?;
                    Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous()
                }
                _ => return None,
            };
        }
        for child in &node.children {
            match child.name.as_str() {
                "node" => self.place(child, &at, deeper, corners)?,
                "instance_node" => {
                    self.place(self.called("node", child.get("url")?)?, &at, deeper, corners)?
                }
                "instance_geometry" => {
                    let own = self.positions(self.called("geometry", child.get("url")?)?)?;
                    if corners.len() + own.len() > MOST_CORNERS {
                        return None;
                    }
                    corners.extend(own.iter().map(|p| <[f32; 3]>::from(at.transform_point(p).cast::<f32>())));
                }
                _ => {}
            }
        }
        Some(())
    }

    /// The corners of a geometry; none of one that is no mesh.
    fn positions(&self, geometry: &Element) -> Option<Vec<Point3<f64>>> {
        let Some(mesh) = geometry.child("mesh") else { return Some(Vec::new()) };
        let position =
            mesh.child("vertices")?.all("input").find(|of| of.get("semantic") == Some("POSITION"))?;
        let source = self.called("source", position.get("source")?)?;
        let accessor = source.descendants().find(|child| child.name == "accessor");
        let stride = accessor.and_then(|accessor| accessor.number("stride")).unwrap_or(3.0) as usize;
        let all = numbers(self.content(source.child("float_array")?)?);
        Some(all.chunks_exact(stride.max(3)).map(|p| Point3::new(p[0], p[1], p[2])).collect())
    }

    /// The element of a name that `#id` means.
    fn called(&self, name: &str, url: &str) -> Option<&Element> {
        self.called.get(&[name, url.strip_prefix('#')?]).copied()
    }

    /// What stands in an element.
    fn content(&self, element: &Element) -> Option<&str> {
        let place = element.place.as_ref()?;
        let own = self.text.get(first_tag(self.text, place.at)?.1..place.end)?;
        Some(own.rsplit_once('<').map_or("", |(inside, _)| inside))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with a corner at 1, 2, 3, and some nodes.
    fn file(nodes: &str) -> Option<Vec<[f32; 3]>> {
        let text = format!(
            r##"<?xml version="1.0"?><COLLADA version="1.4.1"><asset><unit name="centimeter" meter="0.01"/></asset>
  <library_geometries><geometry id="g"><mesh><source id="s"><float_array id="f" count="3">1 2 3</float_array>
    <technique_common><accessor source="#f" count="1" stride="3"/></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#s"/></vertices></mesh></geometry></library_geometries>
  <library_nodes><node id="part"><instance_geometry url="#g"/></node>
    <node id="ring"><instance_node url="#ring"/></node><node id="g"/>
    <node id="many"><instance_node url="#many"/><instance_node url="#many"/></node></library_nodes>
  <library_visual_scenes><visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes></COLLADA>"##
        );
        corners(text.as_bytes())
    }

    #[test]
    fn corners_are_where_nodes_place_them_in_metres() {
        let placed = r##"<instance_geometry url="#g"/></node>"##;
        for (transformations, expected) in [
            ("", [0.01, 0.02, 0.03]),
            ("<translate>100 0 0</translate><scale>2 2 2</scale>", [1.02, 0.04, 0.06]),
            ("<scale>2 2 2</scale><translate>100 0 0</translate>", [2.02, 0.04, 0.06]),
            ("<rotate>0 0 1 90</rotate>", [-0.02, 0.01, 0.03]),
            ("<matrix>0 0 1 0  1 0 0 0  0 1 0 100  0 0 0 1</matrix>", [0.03, 0.01, 1.02]),
            ("<translate>100 0 0</translate><node><translate>0 100 0</translate></node>", [1.01, 0.02, 0.03]),
        ] {
            let found = file(&format!("<node>{transformations}{placed}")).unwrap();
            assert_eq!(found.len(), 1, "{transformations}");
            assert!(found[0].iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
        }
        let inner =
            r##"<node><translate>100 0 0</translate><node><instance_node url="#part"/></node></node>"##;
        assert_eq!(file(inner).unwrap(), [[1.01, 0.02, 0.03]]);
    }

    #[test]
    fn what_is_malformed_has_no_corners() {
        for nodes in [
            r##"<node><instance_geometry url="#other"/></node>"##,
            r##"<node><instance_node url="#ring"/></node>"##,
            r##"<node><instance_node url="#many"/></node>"##,
            r##"<node><matrix>1 0 0</matrix></node>"##,
            r##"<node><rotate>0 0 0 90</rotate></node>"##,
            "<node>",
        ] {
            assert_eq!(file(nodes), None, "{nodes}");
        }
        assert_eq!(file("<node/>"), Some(Vec::new()));
        assert_eq!(corners(b"<svg/>"), None);
    }
}
