//! Babbling and learning as a live view: the body as it touches itself, and beside it the one that is learned.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use nalgebra::Vector3;
use plotly::common::{Line, Marker, Mode};
use plotly::layout::Margin;
use plotly::{Scatter, Trace};
use serde_json::json;

use super::figure::{Moving, figure, poses};
use super::page::page;
use super::server::View;
use crate::creature::Creature;
use crate::evaluation::report::mesh::Mesh;
use crate::evaluation::report::picture::{self, axis, layout, log_axis};
use crate::kinematics::{Frame, limb_frames};
use crate::schema::BodySchema;
use crate::senses::Touch;
use crate::skin::Skin;

/// Most points of a curve; a curve that has more loses every second one.
const MOST_POINTS: usize = 240;
/// Most touches that wait for who learns on the way: what comes on top of these is not learned from then.
const MOST_FRESH: usize = 200;
/// Seconds between two points of the curve of touches, at first.
const POINT_EVERY: f64 = 0.25;
/// How much wider than the body the room about it is: for arms that go anywhere.
const ROOM: f64 = 1.05;

/// What is shown of a session.
pub struct BabblingView {
    creature: Creature,
    /// The body that is simulated, which the learner never sees.
    simulated: BodySchema,
    state: Mutex<State>,
    limbs: Mesh,
    receptors: Mesh,
    /// The greatest distance of any skin from the root, metres.
    extent: f64,
}

/// What is newest.
struct State {
    /// What is done, in a word or two.
    doing: String,
    began: Instant,
    /// Touches before this view began.
    before: usize,
    touches: usize,
    wanted: usize,
    posture: Vec<f64>,
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
    learned_from: usize,
    /// Touches learned from, and how far apart the schema had put the surfaces that touched, millimetres.
    missed: Vec<[f64; 2]>,
    report: Option<PathBuf>,
}

impl BabblingView {
    /// A view of a session of so many touches, `before` of which are there already.
    pub fn new(
        creature: &Creature,
        skin: &Skin,
        simulated: BodySchema,
        wanted: usize,
        before: usize,
    ) -> BabblingView {
        let posture = creature.reference_posture();
        let (limbs, receptors) = (Mesh::of_surfaces(skin), Mesh::of_receptors(&skin.receptors));
        let frames = limb_frames(creature, &simulated, &posture);
        let drawn = limbs.corners.iter().chain(&receptors.corners);
        let extent = drawn.map(|(limb, p)| frames[*limb].point(p).norm()).fold(0.1, f64::max);
        let state = State {
            doing: "getting ready".into(),
            began: Instant::now(),
            before,
            touches: before,
            wanted,
            posture,
            lit: vec![0; skin.receptors.len()],
            fresh: Vec::new(),
            made: Vec::new(),
            point_every: POINT_EVERY,
            rate: None,
            learned: None,
            learned_from: 0,
            missed: Vec::new(),
            report: None,
        };
        BabblingView {
            creature: creature.clone(),
            simulated,
            state: Mutex::new(state),
            limbs,
            receptors,
            extent,
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
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
        state.posture.clone_from(&touch.posture);
        light(&mut state, touch);
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
            state.posture.clone_from(&touch.posture);
            light(&mut state, touch);
        }
        if let Some(schema) = schema {
            state.learned = Some(schema.clone());
        }
        if let Some(missed) = missed.filter(|missed| missed.is_finite()) {
            state.missed.push([from as f64, 1e3 * missed.abs()]);
            if state.missed.len() > MOST_POINTS {
                halve(&mut state.missed);
            }
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
        1.15 * self.extent
    }

    fn frames(&self, schema: &BodySchema, posture: &[f64], aside: f64) -> Vec<Frame> {
        let mut frames = limb_frames(&self.creature, schema, posture);
        frames.iter_mut().for_each(|frame| frame.origin.y += aside);
        frames
    }
}

/// Lights the receptors of a touch up.
fn light(state: &mut State, touch: &Touch) {
    for end in touch.ends {
        state.lit[end.receptor] = state.lit[end.receptor].wrapping_add(1);
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

impl View for BabblingView {
    fn page(&self) -> String {
        let wanted = self.state().wanted;
        let meshes = [
            Moving { name: "body", poses: "own", mesh: &self.limbs, colour: Some("#b9c7d3") },
            Moving { name: "receptors", poses: "own", mesh: &self.receptors, colour: None },
            Moving { name: "what is learned", poses: "learned", mesh: &self.limbs, colour: Some("#5aa5d6") },
        ];
        let r = ROOM * self.extent;
        let room = [Vector3::new(-r, -r, -r), Vector3::new(r, self.aside() + r, r)];
        let caption = "Left as it touches itself, right the body that it has learned so far, in the same posture. \
                       Receptors light up where they are touched. Turn it with the mouse.";
        let body = figure("The body and what is learned of it", 520, &meshes, room, caption);
        let made: Vec<Box<dyn Trace>> = vec![
            Scatter::new(Vec::<f64>::new(), Vec::<f64>::new())
                .mode(Mode::Lines)
                .line(Line::new().color(picture::BLUE).width(2.5)),
        ];
        let missed: Vec<Box<dyn Trace>> = vec![
            Scatter::new(Vec::<f64>::new(), Vec::<f64>::new())
                .mode(Mode::Markers)
                .marker(Marker::new().size(4).color(picture::GREY)),
        ];
        let small =
            || layout().show_legend(false).margin(Margin::new().left(70).right(12).top(12).bottom(48));
        let made = picture::figure(
            "made",
            "Touches over time",
            260,
            made,
            small().x_axis(axis("seconds")).y_axis(axis("touches")),
            "Touches made.",
        );
        let missed = picture::figure(
            "missed",
            "How far each touch was from what was foretold",
            260,
            missed,
            small()
                .x_axis(axis("touches learned from"))
                .y_axis(log_axis("mm", 1e-3, 1e3).range(Vec::<f64>::new()).auto_range(true)),
            "How far apart what was learned put the two surfaces that then touched.",
        );
        let content = format!(
            "<p class=\"verdict\" id=\"doing\" aria-live=\"polite\"></p>\n<section>\n{body}</section>\n\
             <section class=\"beside\">\n{made}{missed}</section>\n"
        );
        page(
            self.creature.name(),
            &format!("It touches itself {wanted} times and learns its body from that"),
            &content,
        )
    }

    fn newest(&self) -> String {
        // Only copied under the lock: babbling waits for nobody.
        let (posture, learned, mut told) = {
            let state = self.state();
            let told = json!({
                "doing": state.doing,
                "touches": state.touches,
                "wanted": state.wanted,
                "rate": state.rate.map(f64::round),
                "lit": state.lit,
                "made": state.made,
                "learnedFrom": state.learned_from,
                "missed": state.missed,
                "report": state.report.as_ref().map(|path| path.display().to_string()),
            });
            (state.posture.clone(), state.learned.clone(), told)
        };
        told["poses"] = json!({ "own": poses(&self.frames(&self.simulated, &posture, 0.0)) });
        if let Some(learned) = learned {
            told["poses"]["learned"] = poses(&self.frames(&learned, &posture, self.aside()));
        }
        told.to_string()
    }

    fn report(&self) -> Option<PathBuf> {
        self.state().report.clone()
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
