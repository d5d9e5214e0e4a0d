//! A creature among things as a live view, with the conversation beside it.

use std::sync::Mutex;
use std::sync::mpsc::{SyncSender, TrySendError};

use axum::http::StatusCode;
use nalgebra::Vector3;
use serde_json::json;

use super::server::{Asked, LivePage, Reception};
use super::{HEIGHT, locked, page};
use crate::agent::Agent;
use crate::error::Result;
use crate::geometry::Frame;
use crate::ground_truth::GroundTruth;
use crate::senses::SkinContact;
use crate::simulation::Stage;
use crate::skin::{Skin, surface_of_body};
use crate::view::body::{BodyMesh, BodyScene, Pose, mesh_of_surfaces};

/// Most lines of the conversation that are shown.
const MOST_LINES: usize = 200;
/// Colours of the table and of things.
const COLOURS: [&str; 6] = ["#b8875a", "#bf4a3a", "#3a8f5a", "#3f5fb0", "#8a5190", "#b0953f"];
/// Room about what is there, metres.
const ROOM: f64 = 0.1;

/// What is shown of a conversation.
pub struct TableView {
    agent: Agent,
    truth: GroundTruth,
    /// The bodies of the scene that are not the creature's, each with its name and its mesh.
    things: Vec<(usize, String, BodyMesh)>,
    state: Mutex<TableState>,
    asked: SyncSender<Asked>,
}

#[derive(Default)]
struct TableState {
    own: Pose,
    things: Pose,
    felt: Vec<usize>,
    /// Who said what.
    lines: Vec<[String; 2]>,
    /// Whether it is at something and hears later.
    busy: bool,
    over: bool,
}

impl TableView {
    /// A view of a scene; what a page asks for is sent on, as long as there is room for it.
    ///
    /// # Errors
    /// If the engine fails.
    pub fn new(stage: &Stage, asked: SyncSender<Asked>) -> Result<TableView> {
        let body = stage.body();
        let model = &body.model;
        let mut things: Vec<(usize, String, BodyMesh)> = Vec::new();
        for thing in (0..model.nbody()).filter(|&b| body.limb_of_body[b].is_none()) {
            let mut skin = Skin { receptors: Vec::new(), surfaces: surface_of_body(model, thing) };
            skin.surfaces.iter_mut().for_each(|surface| surface.limb = things.len());
            let mesh = mesh_of_surfaces(&skin);
            if !mesh.is_empty() {
                things.push((thing, stage.thing_name(thing), mesh));
            }
        }
        let view = TableView {
            agent: stage.agent().clone(),
            truth: GroundTruth::new(body)?,
            things,
            state: Mutex::default(),
            asked,
        };
        view.shows(stage, &[]);
        Ok(view)
    }

    /// Shows where all is now, and which receptors feel something.
    pub fn shows(&self, stage: &Stage, felt: &[SkinContact]) {
        let own = Pose::of_parts(stage.limb_frames());
        let things = self.things.iter().map(|(body, ..)| Frame::from(stage.thing_pose(*body)));
        let things = Pose::of_parts(things.collect());
        let mut state = locked(&self.state);
        (state.own, state.things) = (own, things);
        state.felt = felt.iter().flat_map(SkinContact::spots).map(|spot| spot.receptor).collect();
    }

    /// Shows that receptors are touched, whatever touches them.
    pub fn feels(&self, receptors: &[usize]) {
        locked(&self.state).felt = receptors.to_vec();
    }

    /// A line of the conversation; `busy` where what it asks for is being done.
    pub fn says(&self, who: &str, said: &str, busy: bool) {
        let mut state = locked(&self.state);
        state.busy = busy;
        state.lines.push([who.into(), said.into()]);
        if state.lines.len() > MOST_LINES {
            state.lines.remove(0);
        }
    }

    /// The conversation is over.
    pub fn ends(&self) {
        locked(&self.state).over = true;
    }
}

impl LivePage for TableView {
    fn page(&self, _query: &str) -> Option<String> {
        let (own, things) = {
            let state = locked(&self.state);
            (state.own.clone(), state.things.clone())
        };
        let truth = &self.truth;
        let mut scene = BodyScene::of_body(&self.agent, &truth.schema, &[], Some(&truth.appearance), "own");
        for (k, (_, name, mesh)) in self.things.iter().enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let labels = vec![name.clone(); mesh.len()];
            scene.add_mesh("things", "things", mesh.clone(), colour).labels = labels;
        }
        let poses = |mesh: usize| if mesh < 2 { &own } else { &things };
        let drawn = scene.meshes.iter().enumerate().map(|(k, mesh)| (mesh, poses(k)));
        let room = BodyScene::room_of(drawn).unwrap_or_default();
        scene.room = [room[0] - Vector3::repeat(ROOM), room[1] + Vector3::repeat(ROOM)];
        scene.poses = vec![("own", own), ("things", things)];
        let caption =
            "Click on its skin to touch it there. Drag to rotate; receptors that feel a touch light up.";
        let body = scene.figure("The creature and its surroundings", HEIGHT, "", caption);
        let content = format!(
            "<section class=\"talk\">\n<div>{body}</div>\n<div class=\"dialogue\">\n\
             <ol id=\"lines\" aria-live=\"polite\"></ol>\n<p id=\"doing\" class=\"note\"></p>\n\
             <form id=\"say\"><input id=\"text\" autocomplete=\"off\" maxlength=\"500\" \
             aria-label=\"What you say\" placeholder=\"Is there something in front of you?\"/>\
             <button>Say</button></form>\n</div>\n</section>\n"
        );
        Some(page(
            self.agent.creature().name(),
            "It is blindfolded: it knows its body from self-touch, and the scene from what it feels",
            &content,
        ))
    }

    fn newest(&self) -> String {
        let state = locked(&self.state);
        let doing = match (state.over, state.busy) {
            (true, _) => "The conversation is over.",
            (_, true) => "…",
            _ => "",
        };
        json!({
            "poses": { "own": state.own.told(), "things": state.things.told() },
            "felt": state.felt,
            "lines": state.lines,
            "doing": doing,
        })
        .to_string()
    }

    fn ask(&self, asked: Asked) -> Reception {
        let known = match &asked {
            Asked::Touch(receptor) => *receptor < self.agent.skin().receptors.len(),
            Asked::Say(text) => !text.is_empty(),
            Asked::Show(_) => false,
        };
        if !known {
            return Err(StatusCode::NOT_FOUND);
        }
        match self.asked.try_send(asked) {
            Ok(()) => Ok(None),
            Err(TrySendError::Full(_)) => Err(StatusCode::SERVICE_UNAVAILABLE),
            Err(TrySendError::Disconnected(_)) => Err(StatusCode::NOT_FOUND),
        }
    }
}
