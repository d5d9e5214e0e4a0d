//! The second-order learner: all touches at once, from any initial guess to the optimum.
//!
//! It starts from random initial guesses, growing the tree limb pair by limb pair or solving it whole (see
//! [`growing`](super::growing)), and accepts a start only on touches that it was not fitted to: a low
//! residual on the touches used is no proof. What it accepts is fitted once more to all touches.
//!
//! In order: `searching` makes starts, `fitting` fits each to the noise that it shows, `judging` holds it against touches that it
//! was not fitted to, `fitting` fits the one that is taken to all touches, `observing` says what they determine there.

mod fitting;
mod judging;
mod observing;
mod searching;

use self::judging::extent;
use self::searching::{Judged, kept_back};
use crate::agent::Agent;
use crate::deadline::Deadline;
use crate::learning::growing::{Evidence, Start};
use crate::learning::observation::SkinKnowledge;
use crate::learning::surface_gap::CERTAIN_NOISE;
use crate::learning::touch_set::{LimbTouch, PreparedTouch, TouchSet};
use crate::learning::{
    Account, AxisModel, Basis, Learned, Learner, LimbFrames, Parameters, PriorKnowledge, Verdict,
};
use crate::schema::BodySchema;
use crate::senses::Input;
use crate::senses::Touch;

/// Starts tried before the learner says that it failed.
const STARTS: usize = 24;
/// How far apart two points that are one may be where nothing else is given, per coordinate, metres.
const CONTACT_DEVIATION: f64 = 1e-4;
/// The share of all touches that limbs which could be placed have at the least where there is noise: of the wrong answers
/// seen none had more than 0.14, of the right ones of 512 touches most had more than 0.3.
const FEWEST_TELL: f64 = 0.2;
/// The most noise of gaps that is believed, and of the points of a first part, metres: in more, schemas that are wrong look like noise.
const MOST_NOISE: f64 = 0.02;
/// Touches of a limb that lie less about their middle than this share of how far they are from its joint are at one point.
const ONE_POINT: f64 = 0.05;
/// A gap is open when it is wider than this many predicted deviations.
const OPEN: f64 = 5.0;
/// Touches with a joint below which their share of open gaps says little of it.
const FEW: usize = 4;

/// The learner `lm`.
pub struct SecondOrder {
    agent: Agent,
    input: Input,
    knowledge: SkinKnowledge,
    frames: LimbFrames,
    seed: u64,
    known: PriorKnowledge,
    deadline: Deadline,
    touches: Vec<Touch>,
}

impl SecondOrder {
    /// A learner whose initial guesses are drawn from `seed`.
    pub fn new(agent: &Agent, input: Input, seed: u64) -> SecondOrder {
        let known = PriorKnowledge::nothing(agent);
        let knowledge = SkinKnowledge::Surface;
        let frames = LimbFrames::Joint;
        SecondOrder {
            agent: agent.clone(),
            input,
            knowledge,
            frames,
            seed,
            known,
            deadline: Deadline::Never,
            touches: Vec::new(),
        }
    }

    /// Sets what the agent knows of its skin, its surfaces by default. Contact points need no skin.
    pub fn with_skin(mut self, knowledge: SkinKnowledge) -> SecondOrder {
        self.knowledge = knowledge;
        self
    }

    /// Sets which frames points on limbs are given in, those of their joints by default. Limbs with frames of
    /// their own need exact points; nothing that is known of joints is minded with them.
    pub fn with_frames(mut self, frames: LimbFrames) -> SecondOrder {
        self.frames = frames;
        self
    }

    /// Sets what is known of the joints already.
    pub fn with_known(mut self, known: PriorKnowledge) -> SecondOrder {
        self.known = known;
        self
    }

    pub(crate) fn basis(&self) -> Basis {
        Basis { input: self.input, skin: self.knowledge, frames: self.frames }
    }

    fn evidence(&self) -> Evidence<'_> {
        match (self.input, self.knowledge) {
            (Input::Contact, _) => Evidence::Points,
            (Input::Receptor, SkinKnowledge::Centres) => Evidence::Centres,
            (Input::Receptor, SkinKnowledge::Surface) => Evidence::Surfaces(self.agent.skin()),
        }
    }

    /// The touches so far.
    pub fn touches(&self) -> &[Touch] {
        &self.touches
    }

    /// Forgets all touches but the last ones.
    pub fn forget_before(&mut self, last: usize) {
        self.touches.drain(..self.touches.len().saturating_sub(last));
    }

    /// All touches between their limbs, ready for a solver.
    pub fn prepared(&self) -> impl Iterator<Item = ([usize; 2], PreparedTouch)> {
        self.touches.iter().map(|touch| self.prepare_one(touch))
    }

    /// The limbs, the earlier one first, and a touch ready for a solver.
    pub fn prepare_one(&self, touch: &Touch) -> ([usize; 2], PreparedTouch) {
        self.limb_touch(touch).prepare(self.agent.creature())
    }

    fn prepare<'t>(&self, touches: impl Iterator<Item = &'t Touch>) -> TouchSet {
        TouchSet::new(self.agent.creature(), touches.map(|touch| self.limb_touch(touch)))
    }

    fn limb_touch<'t>(&self, touch: &'t Touch) -> LimbTouch<'t> {
        LimbTouch::of(self.agent.skin(), touch, self.input, contact_variance)
    }

    /// What may be fitted of joints that are known at all and limbs that are placed.
    fn parameters(&self, known: &[bool], placed: &[bool]) -> Parameters {
        let free = |joint: usize| known[joint] && !self.known.frozen[joint];
        let parameters = Parameters::new(self.agent.creature(), AxisModel::Unit, free);
        match self.frames {
            LimbFrames::Joint => parameters,
            LimbFrames::Limb => parameters.with_limb_poses(|joint| known[joint] && placed[joint + 1], None),
        }
    }
}

impl Learner for SecondOrder {
    fn touch(&mut self, touch: &Touch) {
        self.touches.push(touch.clone());
    }

    fn end_at(&mut self, deadline: Deadline) {
        self.deadline = deadline;
    }

    fn learn(&mut self) -> Learned {
        self.learn_in(STARTS)
    }
}

impl SecondOrder {
    /// Learns from all touches in so many starts at most.
    pub fn learn_in(&self, starts: usize) -> Learned {
        let fresh = self.touches.iter().enumerate().filter(|(i, _)| kept_back(*i)).map(|(_, touch)| touch);
        let fresh = self.prepare(fresh);
        let touches = self.prepare(self.fitted());
        let (found, initial_guesses) = self.search(starts, &touches, &fresh);
        self.conclude(found, initial_guesses)
    }

    /// Fits what was found to all touches, or says why nothing was.
    fn conclude(&self, found: Judged, initial_guesses: usize) -> Learned {
        let Judged { start, judged, .. } = found;
        if start.accepted {
            let (schema, account, deviation) = self.polish(&start);
            let verdict = self.few_tell(&account, deviation);
            let verdict = verdict.unwrap_or_else(|| account.verdict(self.agent.creature()));
            return Learned {
                fresh_rms: judged,
                account: Some(account),
                deviation: Some(deviation),
                ..Learned::unaccounted(schema, self.basis(), verdict, initial_guesses)
            };
        }
        let why = if initial_guesses == 0 && self.deadline.has_passed() {
            format!(
                "the search ended {}, before one random initial guess was tried to its end",
                self.deadline.limit()
            )
        } else if initial_guesses == 0 {
            "no joint has as many touches as it has unknowns: give more touches".to_string()
        } else if self.is_at_one_point() {
            "all touches are at one point of each limb, and a body shrunk to a point explains them as well: touch other \
             places of a limb, or give known joints (--known)"
                .to_string()
        } else {
            format!(
                "none of {initial_guesses} random initial guesses explains held-out touches; try more touches \
                 (--touches) or another seed (--seed){}",
                if self.known.is_given() { ", or check what is known (--known)" } else { "" }
            )
        };
        let schema = self.with_frozen(&start.schema);
        Learned {
            fresh_rms: judged,
            ..Learned::unaccounted(schema, self.basis(), Verdict::Failed(why), initial_guesses)
        }
    }

    /// Where gaps show noise, an answer that rests on few of the touches may be a chance among them; why it is refused then.
    fn few_tell(&self, account: &Account, deviation: f64) -> Option<Verdict> {
        if deviation <= CERTAIN_NOISE || !matches!(self.evidence(), Evidence::Surfaces(_)) {
            return None;
        }
        let receptors = &self.agent.skin().receptors;
        let told = self.touches.iter().filter(|touch| {
            let [a, b] = touch.ends.map(|end| receptors[end.receptor].limb);
            account.claims(a, b)
        });
        let (told, all) = (told.count(), self.touches.len());
        (account.claims_any() && (told as f64) < FEWEST_TELL * all as f64).then(|| {
            Verdict::Failed(format!(
                "in such noise only {told} of {all} touches are of limbs that could be placed, which may be chance: give more \
                 touches (--touches), or sharper ones"
            ))
        })
    }

    /// Whether all touches of each limb are so near one point that a body without size explains them as well.
    fn is_at_one_point(&self) -> bool {
        if let Evidence::Surfaces(_) = self.evidence() {
            return false;
        }
        let touches = self.prepare(self.touches.iter());
        let from_joints =
            touches.touches().flat_map(|touch| touch.ends).map(|end| end.position.norm_squared());
        let size = (from_joints.sum::<f64>() / (2 * touches.len()).max(1) as f64).sqrt();
        extent(&touches) < ONE_POINT * size
    }

    /// Fits all touches so far from a schema that is nearly right, without any initial guess or judgement: the last
    /// step of [`Learner::learn`] alone.
    pub fn refine(&self, schema: &BodySchema) -> Learned {
        self.refine_known(schema, vec![true; self.agent.creature().joints().len()])
    }

    /// The same for the joints that are `known` at all, and the touches with only such joints between limbs.
    pub(crate) fn refine_known(&self, schema: &BodySchema, known: Vec<bool>) -> Learned {
        let placed = vec![true; self.agent.creature().limbs().len()];
        let start = Start { schema: schema.clone(), known, placed, accepted: true, initial_guesses: 0 };
        let (schema, account, deviation) = self.polish(&start);
        let verdict = Verdict::Unjudged("it was refined from a given schema".to_string());
        Learned {
            account: Some(account),
            deviation: Some(deviation),
            ..Learned::unaccounted(schema, self.basis(), verdict, 0)
        }
    }
}

/// The variance of each coordinate of a point of contact, m²: from its standard deviation where that is given, but
/// no point is taken to be more exact than [`CONTACT_DEVIATION`] allows.
fn contact_variance(deviation: Option<f64>) -> f64 {
    let least = 0.5 * CONTACT_DEVIATION * CONTACT_DEVIATION;
    deviation.map_or(least, |deviation| least.max(deviation * deviation))
}

/// How far apart, per coordinate and as a root mean square, the two places of a touch are taken to be, metres.
fn taken_deviation(touches: &TouchSet) -> f64 {
    let touches = || touches.touches();
    let variance =
        |touch: &PreparedTouch| (touch.ends[0].covariance + touch.ends[1].covariance).trace() / 3.0;
    (touches().map(variance).sum::<f64>() / touches().count().max(1) as f64).sqrt()
}
