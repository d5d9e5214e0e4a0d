//! When a body has changed: noticed from predictions, and explained by one joint that moved or one tool.
//!
//! A schema that is right predicts almost every touch. A false touch is surprising, too, but alone; when
//! nearly all of the last touches with one joint between the limbs surprise, the body is no longer the one
//! that was learned. Each suspect is then tried for an explanation of the touches since: its joint somewhere
//! else, as when the limb that carries it has grown; or a stick in the limb that it moves.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::agent::Agent;
use crate::kinematics::Chain;
use crate::learning::annealing::{AnnealingLimits, anneal, gaps};
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
/// Share of open gaps among the touches with a joint that makes it a suspect.
const SUSPECT: f64 = 0.6;
/// Share of the touches since the change that an explanation explains.
const EXPLAINED: f64 = 0.75;
/// Surprising touches that an explanation rests on at the least.
const FEWEST: usize = 8;
/// Width of a gap that is as good as closed, metres, where noise is less.
const CLOSE: f64 = 5e-4;
/// Standard deviations of a closed gap.
const DEVIATIONS: f64 = 5.0;
/// Touches kept to explain a change by.
const KEPT: usize = 400;
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

/// What may have changed, by what its touches have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Suspect {
    /// A joint between the limbs.
    Joint(usize),
    /// A receptor: whatever a stick touches is felt where it is held.
    Receptor(usize),
}

/// The watch over the last touches of every joint and receptor.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    windows: BTreeMap<Suspect, VecDeque<(usize, bool)>>,
    recent: VecDeque<Watched>,
    /// Touches that explanations were looked for at, so that it is not done at every one.
    tried_at: usize,
}

impl Watch {
    /// Takes in a touch; the number of the first surprising touch where the body seems to have changed.
    pub fn see(&mut self, chain: &Chain, watched: Watched) -> Option<usize> {
        let receptors = watched.touch.ends.iter().map(|end| Suspect::Receptor(end.receptor));
        for suspect in chain.joints().map(Suspect::Joint).chain(receptors) {
            let window = self.windows.entry(suspect).or_default();
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
        let alarmed = |window: &&VecDeque<(usize, bool)>| surprises(window) >= SURPRISES;
        let onset = self.windows.values().filter(alarmed).filter_map(first_surprise).min()?;
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

    /// Forgets all surprises; the touches themselves may be needed again.
    pub fn calm(&mut self) {
        self.windows.clear();
    }

    /// What explains the touches since `onset`, if anything does.
    pub fn explain(
        &self,
        onset: usize,
        agent: &Agent,
        schema: &BodySchema,
        free: &Parameters,
        deviation: f64,
    ) -> Option<Explanation> {
        let skin = agent.skin();
        let creature = agent.creature();
        let close = CLOSE.max(DEVIATIONS * deviation);
        let model = SurfaceGap::new(skin, 1.0);
        let is_open =
            |touch: &PreparedTouch| model.gap(&touch.ends, &touch.frames(schema)).distance.abs() >= close;
        let since: Vec<(&Watched, Chain, bool)> = self
            .since(onset)
            .map(|w| (w, Chain::between(creature, w.limbs[0], w.limbs[1]), is_open(&w.touch)))
            .collect();
        let open = since.iter().filter(|(.., open)| *open).count();
        let mut best: Option<(usize, Explanation)> = None;
        // How many touches of all an explanation leaves open decides; of two alike, the first.
        let mut offer = |explained: usize, explanation: Explanation| {
            if best.as_ref().is_none_or(|(most, _)| explained > *most) {
                best = Some((explained, explanation));
            }
        };
        let enough = |explained: usize, of: usize| explained as f64 >= EXPLAINED * of as f64;
        for joint in (0..creature.joints().len()).filter(|&joint| free.positions[joint].is_some()) {
            let with_joint = || since.iter().filter(|(_, chain, _)| chain.joints().any(|j| j == joint));
            let (all, open) = (with_joint().count(), with_joint().filter(|(.., open)| *open).count());
            if (open as f64) < SUSPECT * all as f64 || open < WINDOW / 2 {
                continue;
            }
            if open < FEWEST {
                // It may be this one; a few more touches will tell.
                return None;
            }
            let mut touches = TouchSet::default();
            with_joint().for_each(|(w, ..)| touches.push_prepared(creature, w.limbs, w.touch.clone()));
            let mut prior = Prior::size(creature, SHIFT);
            prior.mean = schema.clone();
            let position = Parameters::position(creature, joint);
            let limits = AnnealingLimits::default();
            let found = anneal(limits, agent, &touches, &position, &prior, schema.clone()).schema;
            let explained = (closed(skin, &touches, &found, close) * all as f64).round() as usize;
            if enough(explained, all) {
                offer(explained.saturating_sub(all - open), Explanation::Moved(joint, found));
            }
        }
        let holds = |(suspect, window): (&Suspect, &VecDeque<(usize, bool)>)| match *suspect {
            Suspect::Receptor(receptor) if surprises(window) >= SURPRISES => {
                Some(skin.receptors[receptor].limb)
            }
            _ => None,
        };
        for limb in self.windows.iter().filter_map(holds).collect::<BTreeSet<usize>>() {
            // What surprises is by the stick; the bare hand's touches are as they were.
            let with_limb = since.iter().filter(|(w, _, open)| *open && w.limbs.contains(&limb));
            let touches: Vec<&PreparedTouch> = with_limb.map(|(w, ..)| &w.touch).collect();
            if touches.len() < FEWEST {
                continue;
            }
            if let Some((tool, explained)) = Tool::fit(limb, skin, schema, &touches, close)
                && enough(explained, touches.len())
            {
                offer(explained, Explanation::Holds(tool));
            }
        }
        best.filter(|(explained, _)| 2 * explained > open).map(|(_, explanation)| explanation)
    }
}

fn surprises(window: &VecDeque<(usize, bool)>) -> usize {
    window.iter().filter(|(_, surprising)| *surprising).count()
}

/// The first of the surprises that come nearly without a break up to now.
fn first_surprise(window: &VecDeque<(usize, bool)>) -> Option<usize> {
    window.iter().find(|(_, surprising)| *surprising).map(|(number, _)| *number)
}

/// Share of the touches whose gaps are narrower than `close`, metres.
pub fn closed(skin: &Skin, touches: &TouchSet, schema: &BodySchema, close: f64) -> f64 {
    let gaps = gaps(skin, touches, schema);
    gaps.partition_point(|gap| *gap < close) as f64 / gaps.len().max(1) as f64
}
