//! Feeling oneself over: learning a body anew that may have changed since it was learned.
//!
//! He moves both arms, and what carries them a little, to random postures in which his skin should meet, until it does. From
//! there he comes once more, slowly, and tells the learner of the two receptors and the posture. The learner goes on from what
//! was known ([`Online::going_on`]): it foretells each touch; where it fails again and again it looks for the joint that is
//! elsewhere now. He takes the schema over once it foretells touches in a row with both arms; where it does not, he does not
//! rely on the old one any more.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Trouble;
use crate::creature::Posture;
use crate::interaction::actor::Actor;
use crate::kinematics::Chain;
use crate::learning::{BodyChange, Certainty, Learner, Online, What};
use crate::peripersonal::CollisionChecker;
use crate::senses::{SkinContact, Touch, TouchEnd, Toucher};

/// What is felt farther from where the schema has it than this was not to be expected, metres: a hand that is stopped in
/// the middle of a swift motion is in what it met by a millimetre.
const UNEXPECTED: f64 = 0.005;
/// How often he moves at the most, …
const MOTIONS: usize = 400;
/// … touches after which he gives up, …
const MOST: usize = 160;
/// … and those that it takes at the least.
const LEAST: usize = 24;
/// With every joint of the arms between the two places, so many of the last touches must have been predicted, …
const FORETOLD: usize = 5;
/// … nearer than this, metres, however unsure the learner is, …
const NEAR: f64 = 5e-4;
/// … and of all since the last change at least this share, for skin may be touched where two limbs meet.
const EXPLAINED: f64 = 0.9;
/// The share of motions in which a hand is to touch, or what it carries: that tells of all joints of an arm.
const BY_HAND: f64 = 0.75;
/// How often he draws where to go.
const DRAWS: usize = 80;
/// How far the joints that carry both arms go from where they are, radians.
const TRUNK: f64 = 0.25;
/// Deviation of a touch's gap, metres: the last way is gone a hundredth of a millimetre a step.
const DEVIATION: f64 = 2e-5;

/// What exploring the body by self-touch showed.
#[derive(Clone, Debug, PartialEq)]
pub struct FeltOver {
    /// The self-touches.
    pub touches: usize,
    /// What they show of the body.
    pub body: BodyFound,
}

/// What self-touches show of a body that may have changed since it was learned.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyFound {
    /// It is as it was known.
    Same,
    /// It has changed: joints, and how far each is from its known position on the limb that carries it, metres. It has been
    /// learned again.
    Changed(Vec<(usize, f64)>),
    /// It is not as it was known, and the reason was not found. What was known is no longer relied on.
    Unexplained,
    /// The touches are too few to decide; there is none if the accuracy of what was known is unknown. That stays.
    Undecided,
}

/// What a touch told: its number, the joints between its places, and whether it was not predicted.
struct Told {
    number: usize,
    chain: Chain,
    surprising: bool,
}

impl Actor {
    /// Takes in whether two limbs touched that the schema has apart or in each other. The limbs count, not the receptors: a sensor
    /// reads what presses under its patch on any surface of its limb, and which receptors met when several fire is not known.
    pub(in crate::interaction) fn heed_own_touch(&mut self, felt: &[SkinContact]) {
        let unexpected = felt.iter().find_map(|contact| {
            let spots = [contact.spot, contact.by.own()?];
            // A stick's tip is known otherwise.
            let bare = spots.iter().all(|spot| Some(spot.receptor) != self.stick_tip());
            let off = self.clearance.gap(&self.frames(), spots.map(|spot| spot.limb));
            let off = off.filter(|off| bare && off.abs() > UNEXPECTED)?;
            Some((spots.map(|spot| spot.receptor), off))
        });
        self.unexpected = unexpected.or(self.unexpected);
    }

    /// The two receptors that last touched where the schema did not have it, and how far apart it had them, metres; `None`
    /// if that did not happen since it was asked.
    pub fn take_unexpected(&mut self) -> Option<([usize; 2], f64)> {
        self.unexpected.take()
    }

    /// Feels himself over, and knows his body as it is now; see [`FeltOver`]. What stands on the table, and where that is, he
    /// then knows no more where the body has changed.
    ///
    /// # Errors
    /// [`Trouble`] on the way.
    pub fn feel_over(&mut self) -> Result<FeltOver, Trouble> {
        let agent = self.own.agent().clone();
        let mut rng = self.new_rng();
        let learner = self.own.account().and_then(|account| {
            Online::going_on(&agent, self.own.schema.clone(), account, DEVIATION, self.seed)
        });
        let mut touches = 0;
        let Some(mut learner) = learner else { return Ok(FeltOver { touches, body: BodyFound::Undecided }) };
        let mut told: Vec<Told> = Vec::new();
        for motion in 0..MOTIONS {
            let Some(target) = self.where_skin_may_meet(&mut rng) else { continue };
            let Some(touch) = self.own_touch_going_to(&target, motion as u64)? else { continue };
            let [a, b] = touch.limbs(self.own.skin());
            let before = learner.surprises().len();
            learner.touch(&touch);
            touches += 1;
            // Of joints of which nothing is known nothing can be predicted.
            if let (Some(&surprising), Some(expected)) =
                (learner.surprises().get(before), learner.expectation())
            {
                let surprising = surprising || expected.gap.abs() > NEAR;
                let chain = Chain::between(self.own.creature(), a, b);
                told.push(Told { number: touches - 1, chain, surprising });
            }
            if told.len() >= LEAST && self.is_foretold(&learner, &told) {
                return Ok(FeltOver { touches, body: self.take_over(&mut learner) });
            }
            if touches >= MOST {
                break;
            }
        }
        if told.len() < LEAST {
            return Ok(FeltOver { touches, body: BodyFound::Undecided });
        }
        self.own.certainty = Certainty::Unknown;
        Ok(FeltOver { touches, body: BodyFound::Unexplained })
    }

    /// Whether a learner has predicted the last touches with every joint of the arms, and nearly all since the body was last
    /// found to have changed.
    fn is_foretold(&self, learner: &Online, told: &[Told]) -> bool {
        let changed = learner.changes().last().map(|change| change.touch);
        let since = told.partition_point(|told| changed.is_some_and(|changed| told.number <= changed));
        let since = &told[since..];
        let foretold = since.iter().filter(|told| !told.surprising).count();
        let with = |joint: usize| {
            let mut last = since.iter().rev().filter(|told| told.chain.joints().any(|j| j == joint));
            let foretold = last.by_ref().take(FORETOLD).filter(|told| !told.surprising).count();
            foretold == FORETOLD
        };
        foretold as f64 >= EXPLAINED * since.len() as f64
            && self.hands.iter().flat_map(|hand| &hand.arm).all(|&joint| with(joint))
    }

    /// Takes over what a learner has learned that foretells touches.
    fn take_over(&mut self, learner: &mut Online) -> BodyFound {
        let changes: Vec<BodyChange> = learner.changes().to_vec();
        if changes.is_empty() {
            return BodyFound::Same;
        }
        let moved = |change: &BodyChange| match change.what {
            What::Joint { joint, distance } | What::Corrected { joint, distance } => Some((joint, distance)),
            What::Tool(_) | What::Beyond => None,
        };
        let joints: Option<Vec<(usize, f64)>> = changes.iter().map(moved).collect();
        let learned = learner.conclude();
        let account = learned.as_ref().and_then(|learned| learned.account.clone());
        let (Some(joints), Some(learned), Some(account)) = (joints, learned, account) else {
            self.own.certainty = Certainty::Unknown;
            return BodyFound::Unexplained;
        };
        (self.own.schema, self.own.certainty) = (learned.schema, Certainty::Estimated(Box::new(account)));
        self.clearance = CollisionChecker::new(&self.own);
        // It was felt with the body that he had believed in.
        (self.table, self.reach) = (None, None);
        self.made_way_for.clear();
        BodyFound::Changed(joints)
    }

    /// A random posture over the table in which by the schema skin of the arms is in other skin.
    fn where_skin_may_meet(&mut self, rng: &mut ChaCha8Rng) -> Option<Posture> {
        let (arms, carriers) = (self.arms(), self.trunk());
        let from = self.posture();
        let base = self.own.at_ease();
        let moving = if rng.random_bool(BY_HAND) {
            self.hands.iter().flat_map(|hand| hand.arm.last().copied()).collect()
        } else {
            arms.clone()
        };
        let mut clearance = self.clearance.moved_by(&self.own, &moving);
        clearance.obstacles.clear();
        (0..DRAWS).find_map(|_| {
            let leant = self.own.posture_near(&base, &carriers, TRUNK, rng);
            let leant = Posture::with_joints(self.own.creature(), &from, carriers.iter().copied(), &leant);
            let target = self.own.random_posture(&leant, &arms, rng);
            let frames = self.own.frames(&target);
            let high = self.is_high(self.hands.iter().map(|hand| frames[hand.limb].origin));
            (high && !clearance.free(&frames, 0.0)).then_some(target)
        })
    }

    /// Goes straight to a posture until his own skin meets, and nothing else does; that touch.
    fn own_touch_going_to(&mut self, target: &Posture, motion: u64) -> Result<Option<Touch>, Trouble> {
        let touch = self.touch_exactly(
            target,
            |_, contact| contact.by.own().is_some(),
            |_, contacts| match contacts {
                [SkinContact { spot, by: Toucher::Own(other), .. }] => Some([*spot, *other]),
                _ => None,
            },
        )?;
        Ok(touch.map(|(spots, posture)| Touch {
            bout: 0,
            motion,
            posture,
            ends: spots.map(|spot| TouchEnd::at(spot.receptor)),
            moment: None,
        }))
    }
}
