//! Sessions and models to look at: their bodies in any posture, touch by touch, one beside another, and how well each limb is
//! located.

use axum::http::StatusCode;
use nalgebra::Vector3;
use serde_json::json;

use super::server::{Asked, LivePage, Reception, ShowRequest};
use super::{HEIGHT, extent, page, room};
use crate::agent::Agent;
use crate::creature::{Appearance, Creature, Posture};
use crate::learning::Account;
use crate::named::in_words;
use crate::schema::BodySchema;
use crate::senses::RecordedTouch;
use crate::session::{LearningRecord, same_tree};
use crate::view::body::{BodyScene, Pose, certainty};
use crate::view::text::escape;
use crate::view::tone::Tone;

/// How far apart two bodies stand by how far both extend.
const APART: f64 = 0.55;
/// The name of the second body.
const BESIDE: &str = "the other body";

/// A body to look at: a session's as it was learned, or a model's as it is.
pub struct LookedAt {
    /// The session's folder, or the model's file.
    pub name: String,
    /// What it was given.
    pub agent: Agent,
    /// Its body: as it was learned, or as it is.
    pub schema: BodySchema,
    /// What it should have learned, where that is another thing and known.
    pub truth: Option<BodySchema>,
    /// What it looks like, where that is known.
    pub appearance: Option<Appearance>,
    /// The record of learning; `None` for a model, which is shown as it is.
    pub record: Option<LearningRecord>,
    /// Its touches.
    pub touches: Vec<RecordedTouch>,
}

/// What is shown of some sessions and models. It keeps nothing of what a browser looks at: each has its own.
pub struct LookingView {
    all: Vec<LookedAt>,
    /// How far each reaches from its root, metres.
    extents: Vec<f64>,
}

/// What a browser looks at.
struct Looking {
    shown: usize,
    beside: Option<usize>,
    /// The touch that is shown, counted from 1; 0 for none.
    touch: usize,
    posture: Posture,
    /// The limb that was clicked last.
    limb: Option<usize>,
}

impl LookingView {
    /// A view of one or more.
    pub fn new(all: Vec<LookedAt>) -> LookingView {
        LookingView { extents: all.iter().map(|looked| extent(&looked.agent, &looked.schema)).collect(), all }
    }

    /// What is asked for; `None` if there is no such thing.
    fn looking(&self, asked: &ShowRequest) -> Option<Looking> {
        let shown = self.all.get(asked.session)?;
        if asked.beside.is_some_and(|beside| beside >= self.all.len()) {
            return None;
        }
        let creature = shown.agent.creature();
        let (posture, touch) = match (&asked.posture, asked.touch.checked_sub(1)) {
            (Some(coordinates), _) => (posture(creature, coordinates)?, 0),
            (None, Some(touch)) => (shown.touches.get(touch)?.posture.clone(), asked.touch),
            (None, None) => (Posture::start(creature), 0),
        };
        let receptor = |receptor: usize| Some(shown.agent.skin().receptors.get(receptor)?.limb);
        let limb = match asked.receptor {
            Some(clicked) => Some(receptor(clicked)?),
            None => None,
        };
        Some(Looking { shown: asked.session, beside: asked.beside, touch, posture, limb })
    }

    /// What a page's address asks for, as in `session=2&beside=0`: the first one, and where there are two the other beside it,
    /// unless others are named.
    fn chosen(&self, query: &str) -> Option<Looking> {
        let given = |name: &str| query.split('&').find_map(|pair| pair.strip_prefix(name)?.strip_prefix('='));
        let session = given("session").map_or(Some(0), |number| number.parse().ok())?;
        let beside = match given("beside") {
            None => (self.all.len() == 2 && session == 0).then_some(1),
            Some("") => None,
            Some(number) => Some(number.parse().ok()?),
        };
        self.looking(&ShowRequest { session, beside, ..ShowRequest::default() })
    }

    /// How far aside along y the other body stands, metres.
    fn aside(&self, state: &Looking) -> f64 {
        state.beside.map_or(0.0, |beside| APART * (self.extents[state.shown] + self.extents[beside]))
    }

    /// The poses of all that is shown.
    fn poses(&self, state: &Looking) -> Vec<(&'static str, Pose)> {
        let shown = &self.all[state.shown];
        let creature = shown.agent.creature();
        let mut poses = vec![("learned", Pose::new(creature, &shown.schema, &state.posture))];
        if let Some(truth) = &shown.truth {
            poses.push(("true", Pose::new(creature, truth, &state.posture)));
        }
        if let Some(other) = state.beside.map(|beside| &self.all[beside]) {
            let own = other.agent.creature();
            // What moves otherwise cannot be in the same posture.
            let posture =
                if same_tree(creature, own) { state.posture.clone() } else { own.reference_posture() };
            let aside = Vector3::y() * self.aside(state);
            poses.push(("other", Pose::new(own, &other.schema, &posture).moved(&aside)));
        }
        poses
    }

    /// What is known of a limb, in a sentence.
    fn certainty(looked: &LookedAt, limb: usize) -> String {
        let creature = looked.agent.creature();
        match &looked.record {
            None => in_words(&creature.limbs()[limb]),
            Some(record) => certainty(creature, record.reliable_account(), limb),
        }
    }

    /// The touch that is shown, in words.
    fn doing(&self, state: &Looking) -> String {
        let shown = &self.all[state.shown];
        let Some(touch) = state.touch.checked_sub(1).and_then(|number| shown.touches.get(number)) else {
            return shown
                .record
                .as_ref()
                .map_or("the model as it is".into(), |record| record.verdict.clone());
        };
        let limb = |end: usize| {
            let receptor = &shown.agent.skin().receptors[touch.ends[end].receptor];
            in_words(&shown.agent.creature().limbs()[receptor.limb])
        };
        format!("touch {} of {}: {} and {}", state.touch, shown.touches.len(), limb(0), limb(1))
    }

    /// The choice of what is shown, of what stands beside it, of a touch and of a posture.
    fn controls(&self, state: &Looking) -> String {
        let option = |value: &str, chosen: bool, name: &str| {
            let selected = if chosen { " selected=\"\"" } else { "" };
            format!("<option value=\"{value}\"{selected}>{}</option>", escape(name))
        };
        let all = |chosen: Option<usize>| -> String {
            let all = self.all.iter().enumerate();
            all.map(|(k, looked)| option(&k.to_string(), chosen == Some(k), &looked.name)).collect()
        };
        let choice = |id: &str, says: &str, options: String| {
            format!("<label>{says} <select id=\"{id}\" autocomplete=\"off\">{options}</select></label>\n")
        };
        let mut html = String::new();
        if self.all.len() > 1 {
            let beside = option("", false, "nothing") + &all(state.beside);
            let choices =
                choice("shown", "shown:", all(Some(state.shown))) + &choice("beside", "beside it:", beside);
            html += &format!("<div class=\"choices\">\n{choices}</div>\n");
        }
        let shown = &self.all[state.shown];
        if !shown.touches.is_empty() {
            html += &format!(
                "<label class=\"slider\">touch: <output id=\"touch-number\">{0}</output>\n<input type=\"range\" id=\"touch\" \
                 min=\"0\" max=\"{1}\" value=\"{0}\"/></label>\n",
                state.touch,
                shown.touches.len()
            );
        }
        html += "<details class=\"posture\"><summary>Posture</summary>\n<div class=\"dofs\">\n";
        for at in shown.agent.creature().elements().filter(|at| !at.is_ball() && at.follows.is_none()) {
            let ([low, high], coordinate, name) = (at.range, at.coordinate(), escape(&at.name));
            let value = state.posture[coordinate];
            html += &format!(
                "<label>{name} <input type=\"range\" data-coordinate=\"{coordinate}\" min=\"{low}\" max=\"{high}\" step=\"any\" \
                 value=\"{value}\"/></label>\n"
            );
        }
        html + "</div></details>\n"
    }
}

/// A posture of coordinates that a page has, within the joints' ranges; `None` if they are no such.
fn posture(creature: &Creature, coordinates: &[f64]) -> Option<Posture> {
    if coordinates.len() != creature.coordinates() || !coordinates.iter().all(|x| x.is_finite()) {
        return None;
    }
    let mut posture = Posture::from(coordinates.to_vec());
    for ball in creature.elements().filter(|at| at.is_ball()) {
        let quaternion = &mut posture[ball.coordinates()];
        let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length < 1e-6 {
            return None;
        }
        quaternion.iter_mut().for_each(|x| *x /= length);
    }
    posture.clamp(creature);
    creature.couple(&mut posture);
    Some(posture)
}

impl LivePage for LookingView {
    fn page(&self, query: &str) -> Option<String> {
        let state = self.chosen(query)?;
        let shown = &self.all[state.shown];
        let agent = &shown.agent;
        let account = shown.record.as_ref().and_then(LearningRecord::reliable_account);
        let open = account.map_or(&[][..], Account::undetermined);
        let mut scene = BodyScene::of_body(agent, &shown.schema, open, shown.appearance.as_ref(), "learned");
        // Without touches the skin itself is what there is to see.
        scene.layers[1].lit_alone = !shown.touches.is_empty();
        scene.add_joints(agent, open);
        if shown.truth.is_some() {
            scene.add_truth(agent);
        }
        if let Some(other) = state.beside.map(|beside| &self.all[beside]) {
            scene.add(BESIDE, "other", other.agent.skin(), other.appearance.as_ref());
        }
        scene.poses = self.poses(&state);
        scene.room = room(self.extents[state.shown], self.aside(&state));
        let caption = "Click a limb to see how well it is located. Drag or use the arrow keys to rotate; Ctrl and the wheel zoom.";
        let body = scene.figure("The selected body", HEIGHT, "", caption);
        let content = format!(
            "<p class=\"verdict\" id=\"doing\" aria-live=\"polite\">{}</p>\n<section class=\"looking\" \
             data-session=\"{}\" data-beside=\"{}\">\n<div>{body}</div>\n<div class=\"controls\">\n{}<p id=\"about\" class=\"note\" aria-live=\"polite\"></p>\n</div>\n</section>\n",
            escape(&self.doing(&state)),
            state.shown,
            state.beside.map_or(String::new(), |beside| beside.to_string()),
            self.controls(&state)
        );
        Some(page(agent.creature().name(), &shown.name, &content))
    }

    fn ask(&self, asked: Asked) -> Reception {
        let Asked::Show(asked) = asked else { return Err(StatusCode::NOT_FOUND) };
        let state = self.looking(&asked).ok_or(StatusCode::NOT_FOUND)?;
        let shown = &self.all[state.shown];
        let touch = state.touch.checked_sub(1).and_then(|number| shown.touches.get(number));
        let poses = self.poses(&state).into_iter().map(|(name, pose)| (name.to_string(), pose.told()));
        let told = json!({
            "doing": self.doing(&state),
            "tone": shown.record.as_ref().filter(|_| state.touch == 0).map_or("", |record| Tone::of(record).class()),
            "about": state.limb.map_or(String::new(), |limb| LookingView::certainty(shown, limb)),
            "touch": state.touch,
            "posture": &state.posture[..],
            "felt": touch.map_or(Vec::new(), |touch| touch.ends.map(|end| end.receptor).to_vec()),
            "poses": poses.collect::<serde_json::Map<_, _>>(),
        });
        Ok(Some(told.to_string()))
    }
}
