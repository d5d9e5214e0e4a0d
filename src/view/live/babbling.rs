//! Babbling and learning as a live view: the body as it touches itself, and beside it the one that is learned.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use nalgebra::Vector3;
use serde_json::json;

use super::learner::miss;
use super::pace::Pace;
use super::server::{LivePage, Reception};
use super::{HEIGHT, page};
use crate::agent::Agent;
use crate::creature::Posture;
use crate::ground_truth::GroundTruth;
use crate::schema::BodySchema;
use crate::senses::Touch;
use crate::view::body::{
    AURAS, AuraOverlay, BodyMesh, BodyScene, Clothes, Layer, MAP, MapOverlay, Pose, Skeleton,
};
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Ruler, Scale};
use crate::view::figure;
use crate::view::text::short_number as number;

/// Most points of a curve; a curve that has more loses every second one.
const MOST_POINTS: usize = 240;
/// Most touches that wait for who learns on the way: what comes on top of these is not learned from then.
const MOST_FRESH: usize = 200;
/// Most touches that wait to be shown: bouts come as a whole, and are shown touch by touch.
const MOST_UNSEEN: usize = 20;
/// Seconds between two points of the curve of touches, at first.
const POINT_EVERY: f64 = 0.25;
/// What sets the pace.
const PACES: &str = "<div class=\"pace\" role=\"group\" aria-label=\"Touches a second\">\n\
    <button type=\"button\" data-pace=\"0\">❚❚ pause</button>\n\
    <button type=\"button\" data-pace=\"1\">1 touch a second</button>\n\
    <button type=\"button\" data-pace=\"20\">20 a second</button>\n\
    <button type=\"button\" data-pace=\"\" aria-pressed=\"true\">as fast as it goes</button>\n</div>\n";
/// How wide the room about the body is by its extent: arms that are stretched out may leave it.
const ROOM: f64 = 0.86;

/// What is shown of a session.
pub struct BabblingView {
    agent: Agent,
    /// The body that is simulated, which the learner never sees.
    simulated: BodySchema,
    state: Mutex<BabblingState>,
    pace: Pace,
    clothes: Clothes,
    receptors: BodyMesh,
    /// The greatest distance of any skin from the root, metres.
    extent: f64,
}

/// What is newest.
struct BabblingState {
    /// What is done, in a word or two.
    doing: String,
    began: Instant,
    /// Touches before this view began.
    before: usize,
    touches: usize,
    wanted: usize,
    posture: Posture,
    /// Touches that were not shown yet, the newest last.
    unseen: VecDeque<Touch>,
    /// Per receptor, how often it lit up.
    lit: Vec<u32>,
    /// Touches that nobody has learned from on the way.
    fresh: Vec<Touch>,
    /// Seconds and touches.
    made: Vec<[f64; 2]>,
    point_every: f64,
    /// The rate of babbling, touches a second, as long as it goes on.
    rate: Option<f64>,
    learned: Option<BodySchema>,
    /// Whether the creature itself learns while it babbles.
    grows: bool,
    learned_from: usize,
    /// Touches learned from, and how far apart the schema had put the surfaces that touched, millimetres.
    missed: Vec<[f64; 2]>,
    report: Option<PathBuf>,
}

impl BabblingState {
    /// A touch is to be shown, after those that wait for it; where too many do, the oldest only lights up.
    fn will_show(&mut self, touch: &Touch) {
        if self.unseen.len() == MOST_UNSEEN
            && let Some(oldest) = self.unseen.pop_front()
        {
            self.light(&oldest);
        }
        self.unseen.push_back(touch.clone());
    }

    /// Shows the next touch, where one waits.
    fn show_next(&mut self) {
        if let Some(next) = self.unseen.pop_front() {
            self.light(&next);
            self.posture = next.posture;
        }
    }

    /// Lights the receptors of a touch up.
    fn light(&mut self, touch: &Touch) {
        for end in touch.ends {
            self.lit[end.receptor] = self.lit[end.receptor].wrapping_add(1);
        }
    }

    /// A touch was so far from its prediction, metres.
    fn miss(&mut self, number: usize, missed: f64) {
        if missed.is_finite() {
            self.missed.push([number as f64, 1e3 * missed.abs()]);
        }
        if self.missed.len() > MOST_POINTS {
            halve(&mut self.missed);
        }
    }
}

impl BabblingView {
    /// A view of a session of so many touches, `before` of which are there already.
    pub fn new(agent: &Agent, truth: &GroundTruth, wanted: usize, before: usize) -> BabblingView {
        let (creature, skin) = (agent.creature(), agent.skin());
        let posture = creature.reference_posture();
        let clothes = Clothes::new(skin, Some(&truth.appearance));
        let receptors = BodyMesh::of_receptors(skin);
        let simulated = truth.schema.clone();
        let pose = Pose::new(creature, &simulated, &posture);
        let drawn = clothes.mesh.corners().chain(receptors.corners());
        let extent = drawn.map(|(limb, p)| pose.frames[limb].point(p).norm()).fold(0.1, f64::max);
        let state = BabblingState {
            doing: "getting ready".into(),
            began: Instant::now(),
            before,
            touches: before,
            wanted,
            posture,
            unseen: VecDeque::new(),
            lit: vec![0; skin.receptors.len()],
            fresh: Vec::new(),
            made: Vec::new(),
            point_every: POINT_EVERY,
            rate: None,
            learned: None,
            grows: false,
            learned_from: 0,
            missed: Vec::new(),
            report: None,
        };
        let (state, pace) = (Mutex::new(state), Pace::default());
        BabblingView { agent: agent.clone(), simulated, state, pace, clothes, receptors, extent }
    }

    fn state(&self) -> MutexGuard<'_, BabblingState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Babbling begins.
    pub fn begin(&self) {
        let mut state = self.state();
        (state.doing, state.began) = ("babbling".into(), Instant::now());
    }

    /// A touch was made.
    pub fn touched(&self, touch: &Touch) {
        let mut state = self.state();
        state.touches += 1;
        let foretold = state.learned.as_ref().filter(|_| state.grows);
        let missed = foretold.map(|schema| miss(&self.agent, schema, touch));
        if let Some(missed) = missed {
            let number = state.touches;
            state.miss(number, missed);
        }
        state.will_show(touch);
        if state.fresh.len() < MOST_FRESH {
            state.fresh.push(touch.clone());
        }
        let seconds = state.began.elapsed().as_secs_f64();
        if state.made.last().is_none_or(|last| seconds >= last[0] + state.point_every) {
            let touches = state.touches;
            state.made.push([seconds, touches as f64]);
            if state.made.len() > MOST_POINTS {
                halve(&mut state.made);
                state.point_every *= 2.0;
            }
        }
        state.rate = (seconds > 0.0).then(|| (state.touches - state.before) as f64 / seconds);
    }

    /// Waits until the next touch is due, where a page wants them one by one.
    pub fn keep_pace(&self) {
        self.pace.keep();
    }

    /// The schema that the creature itself has learned from all touches so far.
    pub fn grew(&self, schema: BodySchema) {
        let mut state = self.state();
        state.learned_from = state.touches;
        state.learned = Some(schema);
        state.grows = true;
    }

    /// The touches that were not taken yet, for who learns on the way.
    pub(super) fn take_fresh(&self) -> Vec<Touch> {
        std::mem::take(&mut self.state().fresh)
    }

    /// Babbling is done; what is done from here on.
    pub fn now(&self, doing: &str) {
        let mut state = self.state();
        state.doing = doing.to_string();
        state.fresh.clear();
        (state.learned_from, state.rate) = (0, None);
        state.missed.clear();
        state.grows = false;
    }

    /// What was learned from so many touches, the last of which is told where it is to be shown; and how far apart the
    /// schema had put the surfaces that touched then, metres.
    pub fn learned(
        &self,
        from: usize,
        touch: Option<&Touch>,
        schema: Option<&BodySchema>,
        missed: Option<f64>,
    ) {
        let mut state = self.state();
        state.learned_from = from;
        if let Some(touch) = touch {
            state.will_show(touch);
        }
        if let Some(schema) = schema {
            state.learned = Some(schema.clone());
        }
        if let Some(missed) = missed {
            state.miss(from, missed);
        }
    }

    /// All is done: what came of it, in a sentence, and the report to read.
    pub fn done(&self, sentence: &str, schema: &BodySchema, report: PathBuf) {
        let mut state = self.state();
        state.doing = sentence.to_string();
        state.learned = Some(schema.clone());
        state.report = Some(report);
    }

    /// The learned body stands aside of the simulated one, by so much along y, metres.
    fn aside(&self) -> f64 {
        1.05 * self.extent
    }

    /// What was made so far, and how far each touch was from its prediction.
    fn charts_of(made: &[[f64; 2]], missed: &[[f64; 2]]) -> [(&'static str, Chart, &'static str); 2] {
        let chart = |says: &str, x: Ruler, y: Ruler, ink: Ink, marks: Vec<ChartMark>| {
            let groups = vec![ChartGroup { name: String::new(), ink, marks }];
            Chart::new(says, Panel { title: String::new(), x, y, groups, plot: [420.0, 170.0] })
        };
        let ruler = |title: &str, scale: Scale| Ruler { title: title.into(), scale };
        let along = |points: &[[f64; 2]], k: usize| points.iter().map(|p| p[k]).collect::<Vec<_>>();
        let [x, y] = [0, 1].map(|k| Scale::linear(0.0, along(made, k)));
        let line = vec![ChartMark::line(made.to_vec())];
        let first = chart("Touches over time", ruler("seconds", x), ruler("touches", y), Ink::Blue, line);
        let [x, y] = [Scale::linear(0.0, along(missed, 0)), Scale::logarithmic(along(missed, 1))];
        let dot = |p: &[f64; 2]| ChartMark::dot(*p, 2.0, format!("touch {:.0}: {} mm", p[0], number(p[1])));
        let dots = missed.iter().map(dot).collect();
        let says = "How far each touch was from its prediction";
        let second = chart(says, ruler("touches learned from", x), ruler("miss, mm", y), Ink::Grey, dots);
        [
            ("made", first, "Touches made."),
            ("missed", second, "How far apart what was learned put the two surfaces that then touched."),
        ]
    }
}

/// Keeps every second point.
fn halve(points: &mut Vec<[f64; 2]>) {
    let mut k = 0;
    points.retain(|_| {
        k += 1;
        k % 2 == 1
    });
}

impl LivePage for BabblingView {
    fn page(&self, _query: &str) -> Option<String> {
        let wanted = self.state().wanted;
        let ids = self.agent.skin().receptors.iter().map(|receptor| receptor.id.clone());
        let receptors = Layer { lit_alone: true, ..Layer::receptors("own", ids.collect()) };
        let r = ROOM * self.extent;
        let scene = BodyScene {
            meshes: vec![self.clothes.mesh.clone(), self.receptors.clone()],
            layers: vec![
                Layer::clothed("body", 0, "own", &self.clothes),
                receptors,
                Layer::clothed("what is learned", 0, "learned", &self.clothes),
            ],
            skeletons: vec![Skeleton::learned(&self.agent, &[])],
            room: [Vector3::new(-r, -r, -r), Vector3::new(r, self.aside() + r, r)],
            auras: vec![AuraOverlay::by_schema(&self.agent, &self.simulated, &[], "own")],
            maps: vec![MapOverlay::by_schema(&self.agent, &self.simulated, "own")],
            hidden: vec!["joints", AURAS, MAP],
            ..BodyScene::default()
        };
        let caption = "Left as it touches itself, right the body that it has learned so far, in the same posture. \
                       Receptors light up where they are touched. Turn it with the mouse.";
        let body = scene.figure("The body and what is learned of it", HEIGHT, "", caption);
        let charts: String =
            Self::charts_of(&[], &[]).iter().map(|(id, chart, caption)| figure(id, chart, caption)).collect();
        let content = format!(
            "<p class=\"verdict\" id=\"doing\" aria-live=\"polite\"></p>\n{PACES}<section>\n{body}</section>\n\
             <section class=\"beside\">\n{charts}</section>\n"
        );
        Some(page(
            self.agent.creature().name(),
            &format!("Exploring its body: up to {wanted} self-touches"),
            &content,
        ))
    }

    fn newest(&self) -> String {
        // Only copied under the lock: babbling waits for nobody.
        let (posture, learned, lit, mut told) = {
            let mut state = self.state();
            state.show_next();
            let told = json!({
                "doing": state.doing,
                "touches": state.touches,
                "wanted": state.wanted,
                "rate": state.rate.map(f64::round),
                "learnedFrom": state.learned_from,
                "report": state.report.as_ref().map(|path| path.display().to_string()),
            });
            (state.posture.clone(), state.learned.clone(), state.lit.clone(), told)
        };
        told["lit"] = json!(lit);
        told["poses"] = json!({ "own": Pose::new(self.agent.creature(), &self.simulated, &posture).told() });
        if let Some(learned) = learned {
            let pose = Pose::new(self.agent.creature(), &learned, &posture).moved(&Vector3::new(
                0.0,
                self.aside(),
                0.0,
            ));
            told["poses"]["learned"] = pose.told();
        }
        told.to_string()
    }

    fn charts(&self) -> String {
        let (made, missed) = {
            let state = self.state();
            (state.made.clone(), state.missed.clone())
        };
        let charts = Self::charts_of(&made, &missed);
        let drawn = charts.iter().map(|(id, chart, _)| (id.to_string(), json!(chart.in_page())));
        serde_json::Value::Object(drawn.collect()).to_string()
    }

    fn report(&self) -> Option<PathBuf> {
        self.state().report.clone()
    }

    fn pace(&self, touches_a_second: Option<f64>) -> Reception {
        self.pace.ask(touches_a_second);
        Reception::Taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_that_grows_too_long_keeps_every_second_point() {
        let mut points: Vec<[f64; 2]> = (0..5).map(|k| [f64::from(k), 0.0]).collect();
        halve(&mut points);
        assert_eq!(points, [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]]);
    }
}
