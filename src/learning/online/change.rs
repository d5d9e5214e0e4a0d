//! When a body has changed: noticed from predictions, and explained by one joint that moved or one tool.
//!
//! A schema that is right predicts almost every touch. A false touch is surprising, too, but alone; when
//! nearly all of the last touches with one joint between the limbs surprise, the body is no longer the one
//! that was learned. Each suspect is then tried for an explanation of the touches since: its joint somewhere
//! else, as when the limb that carries it has grown; or a stick in the limb that it moves.

use std::collections::VecDeque;

use crate::creature::Creature;
use crate::kinematics::Chain;
use crate::learning::annealing::anneal;
use crate::learning::online::tool::Tool;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::{PreparedTouch, TouchSet};
use crate::learning::{Parameters, Prior};
use crate::schema::BodySchema;
use crate::skin::Skin;

/// The last touches with a joint that are looked at …
const WINDOW: usize = 8;
/// … and how many of them surprise when the body has changed.
const SURPRISES: usize = 7;
/// Share of surprises among the last touches with a joint that makes it a suspect.
const SUSPECT: f64 = 0.6;
/// Share of the touches since the change that an explanation explains.
const EXPLAINED: f64 = 0.75;
/// The same for a stick: the bare hand still touches, too.
const EXPLAINED_BY_TOOL: f64 = 0.6;
/// Touches that an explanation rests on at the least.
const FEWEST: usize = 8;
/// Width of a gap that is as good as closed, metres, where noise is less.
const CLOSE: f64 = 5e-4;
/// Standard deviations of a closed gap.
const DEVIATIONS: f64 = 5.0;
/// How far a joint may move, metres: a standard deviation.
const SHIFT: f64 = 0.15;

/// One touch as the watch sees it.
#[derive(Clone, Debug)]
pub struct Watched {
    /// Its number in the stream, from 0.
    pub number: usize,
    /// The limbs.
    pub limbs: [usize; 2],
    /// The touch.
    pub touch: PreparedTouch,
    /// Whether the schema did not expect it.
    pub surprising: bool,
}

/// What explains touches that the schema did not expect.
#[derive(Clone, Debug)]
pub enum Explanation {
    /// The joint is somewhere else on the limb that carries it: the schema with it there.
    Moved(usize, BodySchema),
    /// A stick is held.
    Holds(Tool),
}

/// The watch over the last touches of every joint.
#[derive(Clone, Debug)]
pub struct Watch {
    by_joint: Vec<VecDeque<(usize, bool)>>,
    recent: VecDeque<Watched>,
    /// Touches that explanations were looked for at, so that it is not done at every one.
    tried_at: usize,
}

/// Touches kept to explain a change by.
const KEPT: usize = 400;

impl Watch {
    /// A watch over a creature's joints.
    pub fn new(creature: &Creature) -> Watch {
        Watch {
            by_joint: vec![VecDeque::new(); creature.joints().len()],
            recent: VecDeque::new(),
            tried_at: 0,
        }
    }

    /// Takes in a touch; the number of the first surprising touch where the body seems to have changed.
    pub fn see(&mut self, chain: &Chain, watched: Watched) -> Option<usize> {
        for joint in chain.joints() {
            let window = &mut self.by_joint[joint];
            window.push_back((watched.number, watched.surprising));
            if window.len() > WINDOW {
                window.pop_front();
            }
        }
        let number = watched.number;
        self.recent.push_back(watched);
        if self.recent.len() > KEPT {
            self.recent.pop_front();
        }
        let alarmed = |window: &&VecDeque<(usize, bool)>| {
            window.iter().filter(|(_, surprising)| *surprising).count() >= SURPRISES
        };
        let onset = self.by_joint.iter().filter(alarmed).filter_map(first_surprise).min()?;
        // Looked for again when an eighth more touches have come.
        let since = number + 1 - onset;
        if self.tried_at > onset && number < self.tried_at + since / 8 {
            return None;
        }
        self.tried_at = number;
        Some(onset)
    }

    /// The touches since a number.
    pub fn since(&self, onset: usize) -> impl Iterator<Item = &Watched> {
        self.recent.iter().filter(move |watched| watched.number >= onset)
    }

    /// Forgets all surprises.
    pub fn calm(&mut self) {
        self.by_joint.iter_mut().for_each(VecDeque::clear);
        self.recent.clear();
    }

    /// What explains the touches since `onset`, if anything does.
    pub fn explain(
        &self,
        onset: usize,
        creature: &Creature,
        skin: &Skin,
        schema: &BodySchema,
        free: &Parameters,
        deviation: f64,
    ) -> Option<Explanation> {
        let close = CLOSE.max(DEVIATIONS * deviation);
        let suspect = |joint: &usize| {
            let window = &self.by_joint[*joint];
            let surprises = window.iter().filter(|(_, surprising)| *surprising).count();
            free.positions[*joint].is_some()
                && window.len() > WINDOW / 2
                && surprises as f64 >= SUSPECT * window.len() as f64
        };
        let suspects: Vec<usize> = (0..self.by_joint.len()).filter(suspect).collect();
        let mut best: Option<(f64, Explanation)> = None;
        let mut offer = |share: f64, explanation: Explanation| {
            if best.as_ref().is_none_or(|(most, _)| share > *most) {
                best = Some((share, explanation));
            }
        };
        for &joint in &suspects {
            let mut touches = TouchSet::default();
            for watched in self.since(onset) {
                if Chain::between(creature, watched.limbs[0], watched.limbs[1]).joints().any(|j| j == joint) {
                    touches.push_prepared(creature, watched.limbs, watched.touch.clone());
                }
            }
            if touches.len() < FEWEST {
                continue;
            }
            let mut prior = Prior::size(creature, SHIFT);
            prior.mean = schema.clone();
            let position = Parameters::position(creature, joint);
            let found = anneal(creature, skin, &touches, &position, &prior, schema.clone()).schema;
            let share = closed(skin, &touches, &found, close);
            if share >= EXPLAINED {
                offer(share, Explanation::Moved(joint, found));
            }
        }
        for &joint in &suspects {
            let limb = joint + 1;
            let with_limb = self.since(onset).filter(|watched| watched.limbs.contains(&limb));
            let touches: Vec<&PreparedTouch> = with_limb.map(|watched| &watched.touch).collect();
            if touches.len() < FEWEST {
                continue;
            }
            if let Some((tool, explained)) = Tool::fit(limb, skin, schema, &touches, close) {
                let share = explained as f64 / touches.len() as f64;
                if share >= EXPLAINED_BY_TOOL {
                    // Of two that explain alike, a joint has one number less to do it with.
                    offer(share - 0.1, Explanation::Holds(tool));
                }
            }
        }
        best.map(|(_, explanation)| explanation)
    }
}

/// The first of the surprises that come nearly without a break up to now.
fn first_surprise(window: &VecDeque<(usize, bool)>) -> Option<usize> {
    window.iter().find(|(_, surprising)| *surprising).map(|(number, _)| *number)
}

/// Share of the touches whose gaps are narrower than `close`, metres.
pub fn closed(skin: &Skin, touches: &TouchSet, schema: &BodySchema, close: f64) -> f64 {
    let model = SurfaceGap::new(skin, 1.0);
    let all = touches.pairs.iter().flat_map(|pair| &pair.touches);
    let gap = |touch: &PreparedTouch| model.meeting(&touch.ends, &touch.frames(schema)).gap.abs();
    let count = all.filter(|touch| gap(touch) < close).count();
    count as f64 / touches.len().max(1) as f64
}
