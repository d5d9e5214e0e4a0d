//! What of an answer stands: an answer that explains its touches need not be right.
//!
//! Whatever a learner comes to is held against its touches joint by joint and limb by limb. Wrong answers leave gaps open that right
//! ones do not (`open`), leave gaps that are a function of the posture (`patterned`), or have a mirror image that explains the
//! touches as well, or better (`mirrored`). What does not stand is not told of: the touches that tell of it are left out, and the
//! rest is fitted and asked once more.

mod mirrored;
mod open;
mod patterned;

use crate::agent::Agent;
use crate::creature::{Creature, Posture};
use crate::kinematics::Chain;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::{PreparedTouch, TouchSet};
use crate::learning::{Input, Learned, PriorKnowledge};
use crate::schema::BodySchema;
use mirrored::Image;

/// A gap narrower than this is closed, metres: a fiftieth of what a wrong answer leaves, and fifty times what a motion
/// that stops at touch does.
pub const CLOSED: f64 = 1e-6;
/// Deviation of a gap down to which answers are sought, metres.
pub const SHARP: f64 = 1e-8;
/// Mirror images of axes that are taken up at the most.
const MOST_IMAGES: usize = 20;
/// So many touches against a joint or a limb are more than chance.
const CONTRADICTIONS: f64 = 3.0;

/// A touch between two limbs, and what it tells of.
#[derive(Clone, Debug)]
pub struct ToldTouch {
    /// The limbs, the earlier one first.
    pub limbs: [usize; 2],
    /// The touch by its receptors or contact points, ready for a solver.
    pub prepared: PreparedTouch,
    /// The joints between the limbs.
    pub chain: Vec<usize>,
    /// Those of them that have axes and do not rest.
    pub moving: Vec<usize>,
    /// The coordinates of the joints between the limbs, in their order.
    coordinates: Vec<f64>,
}

/// What touches tell of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Member {
    /// A joint.
    Joint(usize),
    /// A limb.
    Limb(usize),
}

impl ToldTouch {
    /// A touch of two limbs, the earlier one first, that was made in a posture.
    pub fn new(
        creature: &Creature,
        limbs: [usize; 2],
        prepared: PreparedTouch,
        posture: &Posture,
    ) -> ToldTouch {
        let chain: Vec<usize> = Chain::between(creature, limbs[0], limbs[1]).joints().collect();
        let moves = |joint: &usize| moves(creature, *joint, posture);
        let moving = chain.iter().copied().filter(moves).collect();
        let of_joint = |&joint: &usize| posture[creature.joints()[joint].coordinates()].to_vec();
        let coordinates = chain.iter().flat_map(of_joint).collect();
        ToldTouch { limbs, prepared, chain, moving, coordinates }
    }

    /// Whether it tells of a joint or of a limb.
    pub fn tells_of(&self, member: Member) -> bool {
        match member {
            Member::Joint(joint) => self.moving.contains(&joint),
            Member::Limb(limb) => self.limbs.contains(&limb),
        }
    }
}

/// Whether a posture has a joint turned or pushed about an axis that is to be learned.
pub fn moves(creature: &Creature, joint: usize, posture: &[f64]) -> bool {
    let mut elements = creature.joints()[joint].elements();
    elements.any(|at| !at.is_ball() && posture[at.coordinate()] != 0.0)
}

/// Answers are held against what an agent was told by touches of some input, and what it knew before them.
#[derive(Clone, Copy, Debug)]
pub struct Scrutiny<'a> {
    agent: &'a Agent,
    input: Input,
    known: &'a PriorKnowledge,
    /// Whether some touches may be false.
    has_false_touches: bool,
}

/// What speaks against an answer.
enum Doubt {
    /// A joint or a limb is wrong, or may be.
    Of(Member),
    /// Another answer, nearly fitted, explains the touches better.
    Better(BodySchema),
}

impl<'a> Scrutiny<'a> {
    /// Scrutiny of what is learned from touches that report an input.
    pub fn new(agent: &'a Agent, input: Input, known: &'a PriorKnowledge) -> Scrutiny<'a> {
        Scrutiny { agent, input, known, has_false_touches: false }
    }

    /// The same where some touches may be false: what no wrong answer but chance leaves open speaks against nothing.
    pub fn with_false_touches(self) -> Scrutiny<'a> {
        Scrutiny { has_false_touches: true, ..self }
    }

    fn by_points(&self) -> bool {
        self.input == Input::Contact
    }

    /// How far apart a schema leaves what touched, metres.
    pub fn miss(&self, touch: &ToldTouch, schema: &BodySchema) -> f64 {
        match self.by_points() {
            true => touch.prepared.miss(schema).norm(),
            false => {
                let frames = touch.prepared.frames(schema);
                SurfaceGap::new(self.agent.skin(), 1.0).gap(&touch.prepared.ends, &frames).distance.abs()
            }
        }
    }

    /// How far apart a schema leaves what touched, metres; infinitely where surfaces nearer than the `widest` tolerance that is
    /// asked for meet out of the patches that felt them.
    pub fn felt_gap(&self, widest: f64, touch: &ToldTouch, schema: &BodySchema) -> f64 {
        if self.by_points() {
            return self.miss(touch, schema);
        }
        let model = SurfaceGap::new(self.agent.skin(), 1.0);
        let frames = touch.prepared.frames(schema);
        let found = model.gap(&touch.prepared.ends, &frames);
        let gap = found.distance.abs();
        let is_elsewhere = gap < widest && !model.is_felt(&touch.prepared.ends, &frames, &found);
        if is_elsewhere { f64::INFINITY } else { gap }
    }

    /// What was learned from touches, as far as it stands: whatever does not, no touch tells of, and `fit` fits the others, of
    /// their numbers, from a schema that is nearly right. `learned` is such a fit to those that are `told` at first. The verdict is
    /// that of its account. Returned with it are the joints and limbs that do not stand.
    pub fn standing(
        &self,
        touches: &[&ToldTouch],
        mut told: Vec<usize>,
        mut learned: Learned,
        fit: impl Fn(&BodySchema, &[usize]) -> Learned,
    ) -> (Learned, Vec<Member>) {
        let (mut images, mut fallen) = (0, Vec::new());
        loop {
            let of: Vec<&ToldTouch> = told.iter().map(|&number| touches[number]).collect();
            let deviation = learned.deviation.unwrap_or(0.0);
            let Some(doubt) = self.doubt(&of, &learned.schema, deviation, images < MOST_IMAGES) else {
                if let Some(account) = &learned.account {
                    learned.verdict = account.verdict(self.agent.creature());
                }
                return (learned, fallen);
            };
            let schema = match doubt {
                Doubt::Better(other) => {
                    images += 1;
                    other
                }
                Doubt::Of(wrong) => {
                    fallen.push(wrong);
                    told.retain(|&number| !touches[number].tells_of(wrong));
                    learned.schema
                }
            };
            learned = fit(&schema, &told);
        }
    }

    /// What speaks most against a schema that was fitted to touches; `deviation` is that of a gap, metres. Where no better one is
    /// wanted, a joint that has one is in doubt.
    fn doubt(
        &self,
        told: &[&ToldTouch],
        schema: &BodySchema,
        deviation: f64,
        wants_better: bool,
    ) -> Option<Doubt> {
        if let Some(wrong) = self.most_open(told, schema, deviation) {
            return Some(Doubt::Of(wrong));
        }
        let is_true = |touch: &&ToldTouch| !self.has_false_touches || !self.is_open(touch, schema, deviation);
        let true_ones: Vec<&ToldTouch> = told.iter().copied().filter(is_true).collect();
        if let Some(wrong) = self.patterned(&true_ones, schema, deviation) {
            return Some(Doubt::Of(wrong));
        }
        Some(match self.image(&true_ones, schema, deviation)? {
            Image::Better(_, other) if wants_better => Doubt::Better(other),
            Image::Better(joint, _) | Image::AsGood(joint) => Doubt::Of(Member::Joint(joint)),
        })
    }

    /// Of the joints and limbs that several touches are against that one which the greatest share of its touches is; each
    /// touch comes with whether it is against what it tells of. `wrong` judges by the touches for and against it, and by all
    /// others.
    pub fn most_suspect<'t>(
        &self,
        told: impl Iterator<Item = (&'t ToldTouch, bool)>,
        wrong: impl Fn([f64; 2], [f64; 2]) -> bool,
    ) -> Option<Member> {
        let creature = self.agent.creature();
        let joints = (0..creature.joints().len()).map(Member::Joint);
        let members: Vec<Member> = joints.chain((0..creature.limbs().len()).map(Member::Limb)).collect();
        let (mut all, mut counts) = ([0.0; 2], vec![[0.0; 2]; members.len()]);
        for (touch, against) in told {
            let against = usize::from(against);
            all[against] += 1.0;
            let of_it = members.iter().zip(&mut counts).filter(|(member, _)| touch.tells_of(**member));
            of_it.for_each(|(_, counts)| counts[against] += 1.0);
        }
        let suspect = |at: &usize| {
            let [right, against] = counts[*at];
            against >= CONTRADICTIONS && wrong(counts[*at], [all[0] - right, all[1] - against])
        };
        let suspects = (0..members.len()).filter(suspect);
        suspects.max_by(|&a, &b| share(counts[a]).total_cmp(&share(counts[b]))).map(|at| members[at])
    }

    /// Touches by their pairs of limbs.
    pub fn set<'t>(&self, touches: impl Iterator<Item = &'t ToldTouch>) -> TouchSet {
        let mut set = TouchSet::default();
        for touch in touches {
            set.push_prepared(self.agent.creature(), touch.limbs, touch.prepared.clone());
        }
        set
    }
}

/// The share of touches that are against something.
pub fn share([right, against]: [f64; 2]) -> f64 {
    against / f64::max(right + against, 1.0)
}
