//! One body, drawn one way: its triangles, its postures, and the viewer that report and live page share.
//!
//! A [`BodyScene`] is what the viewer is given: meshes on limbs whose poses it is told, layers that draw a mesh at some
//! poses in one look, skeletons, and what its senses are: auras and which receptors are neighbours. The viewer is `paint.js`, which
//! fills pixels, `pull.js`, the kinematics of a body that is pulled, and `body.js`, which turns, points and switches.

mod mesh;
mod pose;

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::Serialize;
use serde_json::{Map, Value, json};

pub(super) use mesh::{BodyMesh, mesh_of_surfaces};
use mesh::{Piece, Topology, mesh_of_appearance, mesh_of_receptors};
pub(super) use pose::Pose;

use super::text::{error_number, escape, harmless};
use crate::agent::Agent;
use crate::creature::{Appearance, Creature, DofElement, Joint};
use crate::geometry::box_about;
use crate::kinematics::limb_frames;
use crate::learning::Account;
use crate::named::in_words;
use crate::schema::BodySchema;
use crate::skin::{ProximityGeometry, Skin, SomatotopicMap, grow_aura};

/// What draws bodies in a page.
pub(super) const SCRIPT: &str =
    concat!(include_str!("paint.js"), include_str!("pull.js"), include_str!("body.js"));

/// The colours of limbs that have none of their own, and of a shade.
const LIMB: &str = "#b9c7d3";
const SHADE: &str = "#8a939c";
/// What joints are called where they are switched on.
const JOINTS: &str = "joints";
const TRUE_JOINTS: &str = "true joints";
/// What the auras and the map are called where they are switched on; both are hidden at first.
pub(super) const AURAS: &str = "auras";
pub(super) const MAP: &str = "neighbouring receptors";

/// Most receptors whose neighbours are drawn.
const MOST_NEIGHBOURS: usize = 3000;
/// Numbers are told in so many parts of a metre, and of one.
const PARTS: f64 = 1e4;

/// A number as the viewer takes it.
pub(super) fn whole(x: f64) -> i64 {
    (x * PARTS).round() as i64
}

/// A point as the viewer takes it.
fn point(p: &Vector3<f64>) -> [i64; 3] {
    [p.x, p.y, p.z].map(whole)
}

/// A point of a limb: the limb, and where it is in the limb's frame.
fn on_limb(limb: usize, p: &Vector3<f64>) -> [i64; 4] {
    let [x, y, z] = point(p);
    [limb as i64, x, y, z]
}

/// How well a limb is located by an account of held-out touches, in a sentence.
pub(super) fn certainty(creature: &Creature, account: Option<&Account>, limb: usize) -> String {
    let name = in_words(&creature.limbs()[limb]);
    let Some(account) = account else {
        return format!("{name}: not located, no held-out touches confirm the schema");
    };
    let bounds = account.distance_to_most(limb).filter(|[_, worst]| worst.is_finite());
    match (account.openness(creature, limb), bounds) {
        (Some(why), _) => format!("{name}: not located, {}", why.words(creature)),
        (None, Some(_)) if limb > 0 && account.distance(0, limb).is_finite() => {
            let [error, root] =
                [error_number(1e3 * account.distance(0, limb)), in_words(&creature.limbs()[0])];
            format!("{name}: located to within {error} mm (95 %) relative to the {root}")
        }
        (None, Some(bounds)) => {
            let [best, worst] = bounds.map(|metres| error_number(1e3 * metres));
            format!("{name}: located to within {best} to {worst} mm (95 %), depending on the reference limb")
        }
        (None, None) => format!("{name}: no skin to locate"),
    }
}

/// The limbs that a page may mean by a name: of a limb, of an aura's part of the body, or of a joint the limb beyond it.
fn limbs_by_name(creature: &Creature) -> BTreeMap<String, Vec<usize>> {
    let auras = creature.aura_limbs().iter().map(|aura| (in_words(&aura.name), aura.limbs.clone()));
    let joints = creature.joints().iter().zip(1..).map(|(joint, limb)| (joint.name.clone(), vec![limb]));
    let limbs = creature.limbs().iter().enumerate();
    let limbs = limbs.flat_map(|(limb, name)| [name.clone(), in_words(name)].map(|name| (name, vec![limb])));
    // An aura is called after the limb that it is about, and may be about more.
    joints.chain(limbs).chain(auras).collect()
}

/// How a layer looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Look {
    /// In one colour, or each piece in its own.
    #[default]
    Solid,
    /// Receptors, by how much each is touched.
    Receptors,
    /// A shade that stands behind all else.
    Ghost,
}

/// A mesh at some poses.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Layer {
    /// What it is called where it is switched on and off.
    pub name: String,
    /// Its mesh, by number.
    pub mesh: usize,
    /// The name of its poses.
    pub poses: &'static str,
    /// How it looks.
    pub look: Look,
    /// Its colour, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour: Option<&'static str>,
    /// The colours of its pieces, and which each has; empty where all have one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub palette: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub painted: Vec<usize>,
    /// Whether only those of its receptors are seen that feel something: the others are there to be pointed at.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub lit_alone: bool,
    /// What each of its pieces is called; empty where that tells nothing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub labels: Vec<String>,
}

/// The joints by which a schema moves limbs: of each its parent, its position, its degrees of freedom with their axes and ranges, and
/// the pose of the limb on it if limbs have frames of their own.
fn kinematics(creature: &Creature, schema: &BodySchema) -> Vec<Value> {
    let dof = |dof: DofElement| {
        let axis = point(&schema.axes[dof.axis()]);
        json!({ "name": dof.name, "kind": dof.kind, "axis": axis, "range": dof.range, "follows": dof.follows })
    };
    let joint = |(j, joint): (usize, &Joint)| {
        json!({
            "parent": joint.parent,
            "at": point(&schema.positions[j]),
            "dofs": joint.elements().map(dof).collect::<Vec<_>>(),
            "pose": schema.limb_poses.get(j).map(pose::numbers),
        })
    };
    creature.joints().iter().enumerate().map(joint).collect()
}

/// The joints of a body and what lies between them; the `open` ones are not determined.
fn skeleton(agent: &Agent, name: &str, poses: &str, look: Look, open: &[usize]) -> Value {
    let joints = agent.creature().joints();
    json!({
        "name": name,
        "poses": poses,
        "look": look,
        "colour": SHADE,
        "names": joints.iter().map(|joint| &joint.name).collect::<Vec<_>>(),
        // Per joint the limb that it is on, and per limb at an end the middle of its skin.
        "parents": joints.iter().map(|joint| joint.parent).collect::<Vec<_>>(),
        "tips": pose::tips(agent).iter().map(|(limb, p)| on_limb(*limb, p)).collect::<Vec<_>>(),
        "open": open,
        // What is said after a joint's name.
        "says": if look == Look::Ghost { " in truth" } else { "" },
    })
}

/// The auras that a schema gives, but about limbs beyond joints that are not determined, the `open` ones: per aura its limb, both
/// ends of its segment in that limb's frame, and its radius.
fn auras(agent: &Agent, schema: &BodySchema, open: &[usize], poses: &str) -> Value {
    let creature = agent.creature();
    let mut unknown = vec![false; creature.limbs().len()];
    for (j, joint) in creature.joints().iter().enumerate() {
        unknown[j + 1] = unknown[joint.parent] || open.contains(&j);
    }
    let frames = limb_frames(creature, schema, &creature.reference_posture());
    let capsule = |aura: ProximityGeometry| {
        let limbs = &creature.aura_limbs()[aura.aura_limb].limbs;
        let [a, b] = aura.capsule.ends.map(|end| point(&end));
        let numbers = [&[aura.limb as i64][..], &a, &b, &[whole(aura.capsule.radius)]].concat();
        limbs.iter().all(|&limb| !unknown[limb]).then_some(numbers)
    };
    let capsules: Vec<_> =
        grow_aura(creature, agent.skin(), &frames).into_iter().filter_map(capsule).collect();
    json!({ "name": AURAS, "poses": poses, "capsules": capsules })
}

/// The somatotopic map of an agent's skin on limbs placed by a schema: per receptor its limb and its middle in that limb's frame,
/// and pairs of receptors.
fn map(agent: &Agent, schema: &BodySchema, poses: &str) -> Value {
    let (creature, skin) = (agent.creature(), agent.skin());
    let frames = limb_frames(creature, schema, &creature.reference_posture());
    let links: Vec<_> = SomatotopicMap::new(creature, skin, &frames).pairs().collect();
    let points = skin.receptors.iter().map(|receptor| on_limb(receptor.limb, &receptor.position));
    json!({ "name": MAP, "poses": poses, "points": points.collect::<Vec<_>>(), "links": links })
}

/// A step of a slider: the learned body after so many touches, what that is called, and how far off it is then, millimetres.
pub(super) fn step(name: &str, touches: usize, millimetres: Option<f64>, pose: &Pose) -> Value {
    // As many digits as anybody reads of it.
    let off = millimetres.filter(|off| off.is_finite()).map(|off| format!("{off:.3e}"));
    let off = off.and_then(|off| off.parse::<f64>().ok());
    json!({ "name": name, "touches": touches, "mm": off, "poses": { "learned": pose.told() } })
}

/// What a viewer draws.
#[derive(Default)]
pub(super) struct BodyScene {
    /// What the layers draw.
    pub meshes: Vec<BodyMesh>,
    /// What is drawn, and where.
    pub layers: Vec<Layer>,
    /// The skeletons, the auras and the maps that are drawn over it.
    pub skeletons: Vec<Value>,
    pub auras: Vec<Value>,
    pub maps: Vec<Value>,
    /// Poses by name, as they are at first; those that are missing are told later.
    pub poses: Vec<(&'static str, Pose)>,
    /// Per receptor how much it is touched, 0 to 1.
    pub values: Vec<f64>,
    /// The joints by which the body follows when it is pulled, and a sentence about each limb; empty if it is not pulled.
    pub joints: Vec<Value>,
    pub says: Vec<String>,
    /// What names of limbs in the page stand for.
    pub limbs: BTreeMap<String, Vec<usize>>,
    /// What a slider goes through, from a body that is not known to one that is; see [`step`].
    pub steps: Vec<Value>,
    /// HTML that stands beside the picture, above its switches, and the picture's width by its height; `None` if all stands
    /// below the picture.
    pub beside: Option<(String, f64)>,
    /// Two corners of the box that is to be seen, metres.
    pub room: [Vector3<f64>; 2],
    /// What is hidden at first, by the names of layers and skeletons.
    pub hidden: Vec<&'static str>,
}

impl BodyScene {
    /// A body by a schema, at some poses, as it looks, with receptors that are seen once they feel something. Its aura, but about
    /// limbs beyond joints that are not determined, the `open` ones, and its map are hidden at first, as joints are.
    pub fn of_body(
        agent: &Agent,
        schema: &BodySchema,
        open: &[usize],
        appearance: Option<&Appearance>,
        poses: &'static str,
    ) -> BodyScene {
        let skin = agent.skin();
        let mut scene = BodyScene {
            auras: vec![auras(agent, schema, open, poses)],
            hidden: vec![JOINTS, TRUE_JOINTS, AURAS, MAP],
            limbs: limbs_by_name(agent.creature()),
            ..BodyScene::default()
        };
        scene.add("limbs", poses, skin, appearance);
        let receptors = scene.add_mesh("receptors", poses, mesh_of_receptors(skin), LIMB);
        (receptors.look, receptors.colour, receptors.lit_alone) = (Look::Receptors, None, true);
        receptors.labels = skin.receptors.iter().map(|receptor| receptor.id.clone()).collect();
        if skin.receptors.len() <= MOST_NEIGHBOURS {
            scene.maps.push(map(agent, schema, poses));
        }
        scene
    }

    /// Adds a mesh in one colour.
    pub fn add_mesh(
        &mut self,
        name: &str,
        poses: &'static str,
        mesh: BodyMesh,
        colour: &'static str,
    ) -> &mut Layer {
        let (name, colour, last) = (name.to_string(), Some(colour), self.layers.len());
        self.layers.push(Layer { name, mesh: self.meshes.len(), poses, colour, ..Layer::default() });
        self.meshes.push(mesh);
        &mut self.layers[last]
    }

    /// Adds a body at some poses: as it looks where that is known, else the surfaces of its skin.
    pub fn add(&mut self, name: &str, poses: &'static str, skin: &Skin, appearance: Option<&Appearance>) {
        let Some(looks) = appearance.filter(|appearance| !appearance.parts.is_empty()) else {
            self.add_mesh(name, poses, mesh_of_surfaces(skin), LIMB);
            return;
        };
        let layer = self.add_mesh(name, poses, mesh_of_appearance(looks), LIMB);
        for part in &looks.parts {
            let colour = part.rgb.map_or(LIMB.to_string(), |rgb| {
                let [red, green, blue] = rgb.map(|share| (255.0 * share.clamp(0.0, 1.0)).round() as u8);
                format!("#{red:02x}{green:02x}{blue:02x}")
            });
            let known = layer.palette.iter().position(|known| *known == colour);
            layer.painted.push(known.unwrap_or(layer.palette.len()));
            layer.palette.extend(known.is_none().then_some(colour));
        }
    }

    /// Lets the body be pulled by its limbs, which move as a schema has them, and says of each how well it is located.
    pub fn add_kinematics(
        &mut self,
        creature: &Creature,
        schema: &BodySchema,
        words: impl Fn(usize) -> String,
    ) {
        self.joints = kinematics(creature, schema);
        self.says = (0..creature.limbs().len()).map(words).collect();
    }

    /// Draws only some receptors, each with its label and how much it is touched, 0 to 1.
    pub fn only_receptors(&mut self, drawn: &[usize], labels: Vec<String>, values: Vec<f64>) {
        self.meshes[1] = drawn.iter().map(|&receptor| self.meshes[1][receptor].clone()).collect();
        (self.layers[1].labels, self.layers[1].lit_alone) = (labels, false);
        self.values = values;
    }

    /// Draws the learned joints, of which the `open` ones are not determined.
    pub fn add_joints(&mut self, agent: &Agent, open: &[usize]) {
        self.skeletons.push(skeleton(agent, JOINTS, "learned", Look::Solid, open));
    }

    /// Draws the true body behind the learned one, thin and grey.
    pub fn add_truth(&mut self, agent: &Agent) {
        let name = "true body".to_string();
        let (poses, colour, look) = ("true", Some(SHADE), Look::Ghost);
        self.layers.push(Layer { name, poses, colour, look, ..Layer::default() });
        self.skeletons.push(skeleton(agent, TRUE_JOINTS, "true", look, &[]));
    }

    /// The box about the corners of meshes at poses, and about joints; `None` if there is nothing.
    pub fn room_of<'a>(
        meshes: impl IntoIterator<Item = (&'a BodyMesh, &'a Pose)>,
    ) -> Option<[Vector3<f64>; 2]> {
        let places = meshes.into_iter().flat_map(|(mesh, pose)| {
            let corners = mesh.iter().flat_map(|piece| {
                let frame = pose.frames.get(piece.limb);
                piece.corners.iter().filter_map(move |corner| Some(frame?.point(corner)))
            });
            corners.chain(pose.begins.iter().copied())
        });
        let room = box_about(places.filter(|place| place.iter().all(|x| x.is_finite())))?;
        (room[1] - room[0]).iter().any(|side| *side > 0.0).then_some(room)
    }

    /// What the viewer reads.
    fn told(&self) -> String {
        // Those that are there, in the order in which they come first.
        let mut topologies: Vec<Topology> = Vec::new();
        let mut piece = |piece: &Piece| -> Vec<i64> {
            let known = topologies.iter().position(|topology| *topology == piece.topology);
            let number = known.unwrap_or(topologies.len());
            topologies.extend(known.is_none().then_some(piece.topology));
            let corners = piece.corners.iter().flat_map(point);
            [number as i64, piece.limb as i64].into_iter().chain(corners).collect()
        };
        let meshes: Vec<Vec<_>> =
            self.meshes.iter().map(|mesh| mesh.iter().map(&mut piece).collect()).collect();
        let topology = |topology: &Topology| {
            let triangles: Vec<usize> = topology.triangles().into_iter().flatten().collect();
            json!({ "round": *topology != Topology::Cuboid, "triangles": triangles })
        };
        let poses: Map<String, Value> =
            self.poses.iter().map(|(name, pose)| (name.to_string(), pose.told())).collect();
        json!({
            "topologies": topologies.iter().map(topology).collect::<Vec<_>>(),
            "meshes": meshes,
            "layers": self.layers,
            "skeletons": self.skeletons,
            "auras": self.auras,
            "maps": self.maps,
            "poses": poses,
            "values": self.values.iter().map(|value| (value * 1e3).round() / 1e3).collect::<Vec<_>>(),
            "steps": self.steps,
            "joints": self.joints,
            "says": self.says,
            "limbs": self.limbs,
            "room": self.room.map(|corner| point(&corner)),
            "hidden": self.hidden,
        })
        .to_string()
    }

    /// The figure as HTML. `says` is read out, `height` is in pixels, `caption` and `legend` are HTML.
    pub fn figure(&self, says: &str, height: usize, legend: &str, caption: &str) -> String {
        let (class, stage, above) = match &self.beside {
            Some((above, aspect)) => (
                " beside",
                format!("height:{height}px;width:{:.0}px", aspect * height as f64),
                format!("<div class=\"above\">\n{above}</div>\n"),
            ),
            None => ("", format!("height:{height}px"), String::new()),
        };
        format!(
            "<figure class=\"body{class}\">\n{above}<div class=\"stage\" style=\"{stage}\">\n<canvas id=\"body\" \
             tabindex=\"0\" role=\"img\" aria-label=\"{}\"></canvas>\n<div class=\"tip\" hidden=\"\"></div>\n\
             <div class=\"zoom\"><button type=\"button\" data-zoom=\"1.25\" aria-label=\"nearer\">+</button>\
             <button type=\"button\" data-zoom=\"0.8\" aria-label=\"farther\">−</button></div>\n</div>\n\
             <div class=\"panel\">\n{legend}<figcaption>{caption}</figcaption>\n</div>\n<script type=\"application/json\">{}</script>\n</figure>\n",
            escape(says),
            harmless(&self.told()),
        )
    }
}
