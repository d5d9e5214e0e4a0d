//! A creature among things as a live view, with the conversation beside it.

use std::sync::mpsc::Sender;
use std::sync::{Mutex, MutexGuard, PoisonError};

use nalgebra::Vector3;
use serde_json::json;

use super::figure::{Moving, figure, frame, poses};
use super::page::page;
use super::server::{Asked, View};
use crate::evaluation::report::mesh::Mesh;
use crate::interaction::{Feeling, Scene};
use crate::kinematics::Frame;
use crate::skin::{Skin, surface_of_body};

/// Most lines of the conversation that are shown.
const MOST_LINES: usize = 200;
/// Colours of the table and of things.
const COLOURS: [&str; 6] = ["#b8875a", "#bf4a3a", "#3a8f5a", "#3f5fb0", "#8a5190", "#b0953f"];
/// Room about what is there, metres.
const ROOM: f64 = 0.1;

/// A line of the conversation.
struct Line {
    who: String,
    said: String,
}

/// What is shown of a conversation.
pub struct TableView {
    name: String,
    limbs: Mesh,
    receptors: Mesh,
    known: usize,
    /// Per body of the scene that is not the creature's, its name and its mesh.
    things: Vec<(String, Mesh)>,
    bodies: Vec<usize>,
    state: Mutex<State>,
    asked: Mutex<Sender<Asked>>,
}

struct State {
    own: Vec<Frame>,
    things: Vec<Frame>,
    felt: Vec<usize>,
    lines: Vec<Line>,
    /// Whether it is at something and hears later.
    busy: bool,
    over: bool,
}

impl TableView {
    /// A view of a scene; what a page asks for is sent on.
    pub fn new(scene: &Scene, skin: &Skin, asked: Sender<Asked>) -> TableView {
        let model = &scene.body.model;
        let mut things = Vec::new();
        let mut bodies = Vec::new();
        for body in (0..model.nbody()).filter(|&b| scene.body.limb_of_body[b].is_none()) {
            let mesh = Mesh::of_surfaces(&Skin {
                receptors: Vec::new(),
                surfaces: surface_of_body(model, body)
                    .into_iter()
                    .map(|mut surface| {
                        surface.limb = things.len();
                        surface
                    })
                    .collect(),
            });
            if !mesh.corners.is_empty() {
                things.push((scene.thing_name(body), mesh));
                bodies.push(body);
            }
        }
        let state = State {
            own: Vec::new(),
            things: Vec::new(),
            felt: Vec::new(),
            lines: Vec::new(),
            busy: false,
            over: false,
        };
        let view = TableView {
            name: scene.body.creature.name().to_string(),
            limbs: Mesh::of_surfaces(skin),
            receptors: Mesh::of_receptors(&skin.receptors),
            known: skin.receptors.len(),
            things,
            bodies,
            state: Mutex::new(state),
            asked: Mutex::new(asked),
        };
        view.shows(scene, &[]);
        view
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows where all is now, and which receptors feel something.
    pub fn shows(&self, scene: &Scene, felt: &[Feeling]) {
        let limbs = 0..scene.body.creature.limbs().len();
        let own =
            limbs.map(|limb| frame(&scene.body.limb_pose(&scene.data, limb).unwrap_or_default())).collect();
        let things = self.bodies.iter().map(|&body| frame(&scene.thing_pose(body))).collect();
        let mut state = self.state();
        (state.own, state.things) = (own, things);
        state.felt = felt.iter().map(|feeling| feeling.receptor).collect();
    }

    /// Shows that receptors are touched, whatever touches them.
    pub fn feels(&self, receptors: &[usize]) {
        self.state().felt = receptors.to_vec();
    }

    /// A line of the conversation; `busy` where what it asks for is being done.
    pub fn says(&self, who: &str, said: &str, busy: bool) {
        let mut state = self.state();
        state.busy = busy;
        state.lines.push(Line { who: who.into(), said: said.into() });
        if state.lines.len() > MOST_LINES {
            state.lines.remove(0);
        }
    }

    /// The conversation is over.
    pub fn ends(&self) {
        self.state().over = true;
    }
}

impl View for TableView {
    fn page(&self) -> String {
        let mut meshes = vec![
            Moving { name: "body", poses: "own", mesh: &self.limbs, colour: Some("#b9c7d3") },
            Moving { name: "receptors", poses: "own", mesh: &self.receptors, colour: None },
        ];
        for (k, (name, mesh)) in self.things.iter().enumerate() {
            meshes.push(Moving { name, poses: "things", mesh, colour: Some(COLOURS[k % COLOURS.len()]) });
        }
        let (own, things) = {
            let state = self.state();
            (state.own.clone(), state.things.clone())
        };
        let places = meshes.iter().flat_map(|moving| {
            let at = if moving.poses == "own" { &own } else { &things };
            moving.mesh.corners.iter().map(|(part, p)| at.get(*part).map_or(*p, |frame| frame.point(p)))
        });
        let mut room = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
        for place in places {
            room = [room[0].inf(&place), room[1].sup(&place)];
        }
        let room = [room[0] - Vector3::repeat(ROOM), room[1] + Vector3::repeat(ROOM)];
        let caption =
            "Click on its skin to touch it there. Turn it with the mouse; receptors light up where it feels.";
        let body = figure("The creature and what is about it", 620, &meshes, room, caption);
        let content = format!(
            "<section class=\"talk\">\n<div>{body}</div>\n<div class=\"dialogue\">\n\
             <ol id=\"lines\" aria-live=\"polite\"></ol>\n<p id=\"doing\" class=\"note\"></p>\n\
             <form id=\"say\"><input id=\"text\" autocomplete=\"off\" maxlength=\"500\" \
             aria-label=\"What you say\" placeholder=\"Is there something in front of you?\"/>\
             <button>Say</button></form>\n</div>\n</section>\n"
        );
        page(
            &self.name,
            "It is blindfolded: it knows its body from touching itself, and the scene from what it feels",
            &content,
        )
    }

    fn newest(&self) -> String {
        let state = self.state();
        let lines: Vec<[&str; 2]> =
            state.lines.iter().map(|line| [line.who.as_str(), line.said.as_str()]).collect();
        let doing = match (state.over, state.busy) {
            (true, _) => "The conversation is over.",
            (_, true) => "…",
            _ => "",
        };
        json!({
            "poses": { "own": poses(&state.own), "things": poses(&state.things) },
            "felt": state.felt,
            "lines": lines,
            "doing": doing,
        })
        .to_string()
    }

    fn ask(&self, asked: Asked) -> bool {
        let known = match &asked {
            Asked::Touch(receptor) => *receptor < self.known,
            Asked::Say(text) => !text.is_empty(),
        };
        let asks = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
        known && asks.send(asked).is_ok()
    }
}
