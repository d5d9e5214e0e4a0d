//! Babbling and learning as a live view: the body as it touches itself, and beside it the learned one.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::slice::from_ref;
use std::sync::Mutex;
use std::time::Instant;

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::server::LivePage;
use super::{HEIGHT, extent, locked, page, room};
use crate::agent::Agent;
use crate::creature::Posture;
use crate::evaluation::touch_misses;
use crate::ground_truth::GroundTruth;
use crate::learning::growth::Growth;
use crate::schema::BodySchema;
use crate::senses::{RecordedTouch, Touch};
use crate::session::{LearningStep, Observer, Phase};
use crate::view::body::{BodyScene, Layer, Pose};
use crate::view::charts::{Chart, ChartGroup, ChartMark, Ink, Panel, Scale};
use crate::view::figure;
use crate::view::text::short_number as number;

/// Most points of a curve: a longer one loses every second point.
const MOST_POINTS: usize = 240;
/// Most touches waiting to be shown: bouts arrive as a whole, and are shown touch by touch.
const MOST_WAITING: usize = 20;
/// Seconds between two points of the curve of touches, at first.
const POINT_EVERY: f64 = 0.25;
/// The learned body stands aside by this share of the body's extent.
const ASIDE: f64 = 1.05;

/// The view of a session.
pub struct BabblingView {
    agent: Agent,
    /// The simulated body, which the learner never sees.
    truth: GroundTruth,
    /// The greatest distance of any skin from the root, metres.
    extent: f64,
    state: Mutex<BabblingState>,
}

/// The newest state.
struct BabblingState {
    /// The phase in a word, or the verdict.
    doing: String,
    began: Instant,
    /// Touches before this view began.
    before: usize,
    touches: usize,
    wanted: usize,
    posture: Posture,
    /// Touches not shown yet, the newest last.
    waiting: VecDeque<Touch>,
    /// Per receptor, how often it lit up.
    lit: Vec<u32>,
    /// Seconds and touches.
    made: Vec<[f64; 2]>,
    point_every: f64,
    /// Touches a second while babbling.
    rate: Option<f64>,
    learned: Option<BodySchema>,
    learned_from: usize,
    /// Touches, and how far apart the schema before had put the surfaces that touched, millimetres.
    missed: Vec<[f64; 2]>,
    report: Option<PathBuf>,
}

impl BabblingState {
    /// Queues a touch to be shown; where too many wait, the oldest only lights up.
    fn will_show(&mut self, touch: &Touch) {
        if self.waiting.len() == MOST_WAITING
            && let Some(oldest) = self.waiting.pop_front()
        {
            self.light(&oldest);
        }
        self.waiting.push_back(touch.clone());
    }

    fn light(&mut self, touch: &Touch) {
        for end in touch.ends {
            self.lit[end.receptor] = self.lit[end.receptor].wrapping_add(1);
        }
    }

    /// Adds a touch's distance from its prediction, millimetres.
    fn miss(&mut self, touch: usize, missed: f64) {
        if missed.is_finite() {
            self.missed.push([touch as f64, missed]);
        }
        if self.missed.len() > MOST_POINTS {
            halve(&mut self.missed);
        }
    }
}

impl BabblingView {
    /// A view of a session of up to `wanted` touches, `before` of which are there already.
    pub fn new(agent: &Agent, truth: &GroundTruth, wanted: usize, before: usize) -> BabblingView {
        let state = BabblingState {
            doing: "getting ready".into(),
            began: Instant::now(),
            before,
            touches: before,
            wanted,
            posture: agent.creature().reference_posture(),
            waiting: VecDeque::new(),
            lit: vec![0; agent.skin().receptors.len()],
            made: Vec::new(),
            point_every: POINT_EVERY,
            rate: None,
            learned: None,
            learned_from: 0,
            missed: Vec::new(),
            report: None,
        };
        let extent = extent(agent, &truth.schema);
        BabblingView { agent: agent.clone(), truth: truth.clone(), extent, state: Mutex::new(state) }
    }

    /// Shows the result: the verdict, the learned body, and the report to read.
    pub fn done(&self, verdict: &str, schema: &BodySchema, report: PathBuf) {
        let mut state = locked(&self.state);
        state.doing = verdict.to_string();
        state.learned = Some(schema.clone());
        state.report = Some(report);
    }

    /// How far the learned body stands aside along y, metres.
    fn aside(&self) -> f64 {
        ASIDE * self.extent
    }

    /// The touches made so far, and the distance of each from its prediction: the id, the chart and its caption.
    fn charts_of(made: &[[f64; 2]], missed: &[[f64; 2]]) -> [(&'static str, Chart, &'static str); 2] {
        let along = |points: &[[f64; 2]], k: usize| Scale::linear(0.0, points.iter().map(|p| p[k]));
        let chart = |says: &str, x, y, group| Chart::new(says, Panel::new(x, y, vec![group], [420.0, 170.0]));
        let line = ChartGroup::new("", Ink::Blue, vec![ChartMark::line(made.to_vec(), "", 2.0)]);
        let (x, y) = (("seconds", along(made, 0)), ("touches", along(made, 1)));
        let dot = |p: &[f64; 2]| ChartMark::dot(*p, 2.0, format!("touch {:.0}: {} mm", p[0], number(p[1])));
        let dots = ChartGroup::new("", Ink::Grey, missed.iter().map(dot).collect());
        let millimetres = ("prediction error, mm", Scale::logarithmic(missed.iter().map(|p| p[1])));
        let missed =
            chart("Prediction error of each touch", ("touches", along(missed, 0)), millimetres, dots);
        [
            ("made", chart("Touches over time", x, y, line), "Touches made."),
            (
                "missed",
                missed,
                "Distance between the two touching surfaces as predicted by the learned body before the touch.",
            ),
        ]
    }
}

/// Keeps every second point.
fn halve(points: &mut Vec<[f64; 2]>) {
    *points = points.iter().copied().step_by(2).collect();
}

impl Observer for BabblingView {
    fn phase(&self, phase: Phase) {
        let mut state = locked(&self.state);
        match phase {
            Phase::Babbling { .. } => (state.doing, state.began) = ("babbling".into(), Instant::now()),
            Phase::Learning { .. } => {
                state.doing = "learning".into();
                (state.learned_from, state.rate) = (0, None);
                state.missed.clear();
            }
            _ => {}
        }
    }

    fn touched(&self, touch: &RecordedTouch) {
        let mut state = locked(&self.state);
        state.touches += 1;
        let number = state.touches;
        if let Some(schema) = &state.learned {
            let missed = touch_misses(&self.agent, schema, from_ref(touch)).max;
            state.miss(number, missed);
        }
        state.will_show(touch);
        let seconds = state.began.elapsed().as_secs_f64();
        if state.made.last().is_none_or(|last| seconds >= last[0] + state.point_every) {
            state.made.push([seconds, number as f64]);
            if state.made.len() > MOST_POINTS {
                halve(&mut state.made);
                state.point_every *= 2.0;
            }
        }
        state.rate = (seconds > 0.0).then(|| (number - state.before) as f64 / seconds);
    }

    fn grew(&self, growth: &Growth) {
        let schema = growth.believed();
        let mut state = locked(&self.state);
        state.learned_from = state.touches;
        state.learned = Some(schema);
    }

    fn learned(&self, step: &LearningStep) {
        if step.schema.is_none() && step.predicted_gap.is_none() {
            return;
        }
        let mut state = locked(&self.state);
        state.learned_from = step.touches;
        state.will_show(step.touch);
        if let Some(schema) = step.schema {
            state.learned = Some(schema.clone());
        }
        if let Some(gap) = step.predicted_gap {
            state.miss(step.touches, 1e3 * gap.abs());
        }
    }
}

impl LivePage for BabblingView {
    fn page(&self, _query: &str) -> Option<String> {
        let wanted = locked(&self.state).wanted;
        let truth = &self.truth;
        let mut scene = BodyScene::of_body(&self.agent, &truth.schema, &[], Some(&truth.appearance), "own");
        let learned = Layer { name: "learned body".into(), poses: "learned", ..scene.layers[0].clone() };
        scene.layers.push(learned);
        scene.add_joints(&self.agent, &[]);
        scene.room = room(self.extent, self.aside());
        let caption = "Left: the body during self-touch. Right: the body learned so far, in the same posture. Touched receptors light up. Drag to rotate.";
        let body = scene.figure("The body, and the learned body beside it", HEIGHT, "", caption);
        let charts: String =
            Self::charts_of(&[], &[]).iter().map(|(id, chart, caption)| figure(id, chart, caption)).collect();
        let content = format!(
            "<p class=\"verdict\" id=\"doing\" aria-live=\"polite\"></p>\n<section>\n{body}</section>\n\
             <section class=\"beside\">\n{charts}</section>\n"
        );
        let about = format!("Exploring its body: up to {wanted} self-touches");
        Some(page(self.agent.creature().name(), &about, &content))
    }

    fn newest(&self) -> String {
        // Only copied under the lock: babbling waits for nobody.
        let (posture, learned, mut told) = {
            let mut state = locked(&self.state);
            if let Some(next) = state.waiting.pop_front() {
                state.light(&next);
                state.posture = next.posture;
            }
            let told = json!({
                "doing": state.doing,
                "touches": state.touches,
                "wanted": state.wanted,
                "rate": state.rate.map(f64::round),
                "learnedFrom": state.learned_from,
                "lit": state.lit,
                "report": state.report.as_ref().map(|path| path.display().to_string()),
            });
            (state.posture.clone(), state.learned.clone(), told)
        };
        let pose = |schema: &BodySchema| Pose::new(self.agent.creature(), schema, &posture);
        told["poses"] = json!({ "own": pose(&self.truth.schema).told() });
        if let Some(learned) = &learned {
            told["poses"]["learned"] = pose(learned).moved(&(Vector3::y() * self.aside())).told();
        }
        told.to_string()
    }

    fn charts(&self) -> String {
        let (made, missed) = {
            let state = locked(&self.state);
            (state.made.clone(), state.missed.clone())
        };
        let charts = Self::charts_of(&made, &missed);
        let drawn = charts.iter().map(|(id, chart, _)| (id.to_string(), json!(chart.in_page())));
        Value::Object(drawn.collect()).to_string()
    }

    fn report(&self) -> Option<PathBuf> {
        locked(&self.state).report.clone()
    }
}
