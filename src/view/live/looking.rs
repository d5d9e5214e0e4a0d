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

impl LookedAt {
    /// How well a limb is located, in a sentence; of a model, which is no claim, the limb's name.
    fn certainty(&self, limb: usize) -> String {
        let creature = self.agent.creature();
        match &self.record {
            None => in_words(&creature.limbs()[limb]),
            Some(record) => certainty(creature, record.reliable_account(), limb),
        }
    }
}

/// Sessions and models to look at. It keeps nothing of what a browser looks at: each has its own.
pub struct LookingView {
    all: Vec<LookedAt>,
    /// How far each reaches from its root, metres.
    extents: Vec<f64>,
}

/// What a browser looks at.
struct Looking<'a> {
    /// The one that is shown, with its number.
    shown: (usize, &'a LookedAt),
    /// The one that stands beside it.
    beside: Option<(usize, &'a LookedAt)>,
    /// The touch that is shown, counted from 1.
    touch: Option<(usize, &'a RecordedTouch)>,
    posture: Posture,
    /// How far aside along y the other body stands, metres.
    aside: f64,
}

impl LookingView {
    /// A view of one or more.
    pub fn new(all: Vec<LookedAt>) -> LookingView {
        LookingView { extents: all.iter().map(|looked| extent(&looked.agent, &looked.schema)).collect(), all }
    }

    /// What is asked for; `None` if there is no such thing.
    fn looking(&self, asked: &ShowRequest) -> Option<Looking<'_>> {
        let numbered = |number: usize| Some((number, self.all.get(number)?));
        let shown @ (_, LookedAt { agent, touches, .. }) = numbered(asked.session)?;
        let beside = match asked.beside {
            Some(beside) => Some(numbered(beside)?),
            None => None,
        };
        let creature = agent.creature();
        let (posture, touch) = match (&asked.posture, asked.touch.checked_sub(1)) {
            (Some(coordinates), _) => (posture(creature, coordinates)?, None),
            (None, Some(touch)) => {
                let touch = touches.get(touch)?;
                (touch.posture.clone(), Some((asked.touch, touch)))
            }
            (None, None) => (Posture::start(creature), None),
        };
        let aside = beside.map_or(0.0, |(beside, _)| APART * (self.extents[shown.0] + self.extents[beside]));
        Some(Looking { shown, beside, touch, posture, aside })
    }

    /// What a page's address asks for, as in `session=2&beside=0`: the first one, and where there are two the other beside it,
    /// unless others are named.
    fn chosen(&self, query: &str) -> Option<Looking<'_>> {
        let given = |name: &str| query.split('&').find_map(|pair| pair.strip_prefix(name)?.strip_prefix('='));
        let session = given("session").map_or(Some(0), |number| number.parse().ok())?;
        let beside = match given("beside") {
            None => (self.all.len() == 2 && session == 0).then_some(1),
            Some("") => None,
            Some(number) => Some(number.parse().ok()?),
        };
        self.looking(&ShowRequest { session, beside, ..ShowRequest::default() })
    }

    /// The choice of what is shown, of what stands beside it, of a touch and of a posture.
    fn controls(&self, looking: &Looking) -> String {
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
            let beside = option("", false, "nothing") + &all(looking.beside.map(|(number, _)| number));
            let choices = choice("shown", "shown:", all(Some(looking.shown.0)))
                + &choice("beside", "beside it:", beside);
            html += &format!("<div class=\"choices\">\n{choices}</div>\n");
        }
        let shown = looking.shown.1;
        if !shown.touches.is_empty() {
            html += &format!(
                "<label class=\"slider\">touch: <output id=\"touch-number\">{0}</output>\n<input type=\"range\" id=\"touch\" \
                 min=\"0\" max=\"{1}\" value=\"{0}\"/></label>\n",
                looking.touch.map_or(0, |(number, _)| number),
                shown.touches.len()
            );
        }
        html
    }
}

impl Looking<'_> {
    /// The poses of all that is shown.
    fn poses(&self) -> Vec<(&'static str, Pose)> {
        let LookedAt { agent, schema, truth, .. } = self.shown.1;
        let creature = agent.creature();
        let mut poses = vec![("learned", Pose::new(creature, schema, &self.posture))];
        poses.extend(truth.iter().map(|truth| ("true", Pose::new(creature, truth, &self.posture))));
        if let Some((_, other)) = self.beside {
            let own = other.agent.creature();
            // What moves otherwise cannot be in the same posture.
            let posture =
                if same_tree(creature, own) { self.posture.clone() } else { own.reference_posture() };
            let aside = Vector3::y() * self.aside;
            poses.push(("other", Pose::new(own, &other.schema, &posture).moved(&aside)));
        }
        poses
    }

    /// The touch that is shown, in words; without one, the verdict.
    fn doing(&self) -> String {
        let LookedAt { agent, record, touches, .. } = self.shown.1;
        let Some((number, touch)) = self.touch else {
            return record.as_ref().map_or("the model as it is".into(), |record| record.verdict.clone());
        };
        let [a, b] = touch.limbs(agent.skin()).map(|limb| in_words(&agent.creature().limbs()[limb]));
        format!("touch {number} of {}: {a} and {b}", touches.len())
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
        let looking = self.chosen(query)?;
        let (number, shown) = looking.shown;
        let agent = &shown.agent;
        let account = shown.record.as_ref().and_then(LearningRecord::reliable_account);
        let open = account.map_or(&[][..], Account::undetermined);
        let mut scene = BodyScene::of_body(agent, &shown.schema, open, shown.appearance.as_ref(), "learned");
        // Without touches the skin itself is what there is to see.
        scene.layers[1].lit_alone = !shown.touches.is_empty();
        scene.add_joints(agent, open);
        scene.add_kinematics(agent.creature(), &shown.schema, |limb| shown.certainty(limb));
        if shown.truth.is_some() {
            scene.add_truth(agent);
        }
        if let Some((_, other)) = looking.beside {
            scene.add(BESIDE, "other", other.agent.skin(), other.appearance.as_ref());
        }
        scene.poses = looking.poses();
        scene.room = room(self.extents[number], looking.aside);
        let caption = "Drag a limb to pull it, or the background to rotate; click a limb to see how well it is located. Keys: arrows \
                       rotate, N and P choose a limb, Shift and arrows pull it; Ctrl and the wheel zoom.";
        let body = scene.figure("The selected body", HEIGHT, "", caption);
        let content = format!(
            "<p class=\"verdict\" id=\"doing\" aria-live=\"polite\">{}</p>\n<section class=\"looking\" \
             data-session=\"{}\" data-beside=\"{}\">\n<div>{body}</div>\n<div class=\"controls\">\n{}</div>\n</section>\n",
            escape(&looking.doing()),
            number,
            looking.beside.map_or(String::new(), |(beside, _)| beside.to_string()),
            self.controls(&looking)
        );
        Some(page(agent.creature().name(), &shown.name, &content))
    }

    fn ask(&self, asked: Asked) -> Reception {
        let Asked::Show(asked) = asked else { return Err(StatusCode::NOT_FOUND) };
        let looking = self.looking(&asked).ok_or(StatusCode::NOT_FOUND)?;
        let poses = looking.poses().into_iter().map(|(name, pose)| (name.to_string(), pose.told()));
        let record = looking.shown.1.record.as_ref().filter(|_| looking.touch.is_none());
        let felt = looking.touch.map(|(_, touch)| touch.ends.map(|end| end.receptor).to_vec());
        let told = json!({
            "doing": looking.doing(),
            "tone": record.map_or("", |record| Tone::of(record).name()),
            "touch": looking.touch.map_or(0, |(number, _)| number),
            "posture": &looking.posture[..],
            "felt": felt.unwrap_or_default(),
            "poses": poses.collect::<serde_json::Map<_, _>>(),
        });
        Ok(Some(told.to_string()))
    }
}
