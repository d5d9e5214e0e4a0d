//! What of an answer stands: an answer that explains its touches need not be right.
//!
//! Whatever a learner comes to is held against its touches joint by joint and limb by limb. Wrong answers leave gaps open that right
//! ones do not (`open`), leave gaps that are a function of the posture (`patterned`), or have a mirror image that explains the
//! touches as well, or better (`mirrored`). What does not stand is not told of: the touches that tell of it are left out, and the
//! rest is fitted and asked once more.

mod mirrored;
mod open;
mod patterned;

use std::collections::BTreeMap;

use crate::agent::Agent;
use crate::creature::{Creature, DofElement, Posture};
use crate::kinematics::Chain;
use crate::learning::touch_set::{PreparedTouch, TouchSet};
use crate::learning::{Input, Learned, PriorKnowledge};
use crate::schema::BodySchema;

/// A gap narrower than this is closed, metres: a fiftieth of what a wrong answer leaves, and fifty times what a motion
/// that stops at touch does.
pub const CLOSED: f64 = 1e-6;
/// Deviation of a gap down to which answers are sought, metres.
pub const SHARP: f64 = 1e-8;
/// Mirror images of axes that are taken up at the most.
const MOST_IMAGES: usize = 20;
/// So many touches against a joint or a limb are more than chance.
const CONTRADICTIONS: f64 = 3.0;
/// How many times more false touches there may be than others let expect, which is only roughly so, …
const ROUGHLY: f64 = 1.25;
/// … and how many standard deviations luck adds.
const LUCK: f64 = 2.0;
/// Where touches may be false, so many are expected before the first, of so many: where there are few others these tell little.
const BEFOREHAND: [f64; 2] = [2.0, 5.0];

/// A touch between two limbs, and what it tells of.
#[derive(Clone, Debug)]
pub struct ToldTouch {
    /// The limbs, the earlier one first.
    pub limbs: [usize; 2],
    /// The touch by its receptors or contact points, ready for a solver.
    pub prepared: PreparedTouch,
    /// The joints between the limbs.
    pub chain: Vec<usize>,
    /// Those of them that do not rest.
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

/// What touches say of a joint or a limb.
#[derive(Clone, Copy, Debug, Default)]
pub struct Testimony {
    /// How many agree with it, …
    pub right: f64,
    /// … how many are against it, …
    pub against: f64,
    /// … and how many false touches there may be among them, as those against all others let expect.
    pub by_chance: f64,
}

impl Testimony {
    /// The share of touches that are against it, but for those that may be false.
    pub fn beyond(&self) -> f64 {
        (self.against - self.by_chance).max(0.0) / (self.right + self.against).max(1.0)
    }
}

/// Whether a posture has a joint turned or pushed.
fn moves(creature: &Creature, joint: usize, posture: &[f64]) -> bool {
    // What turns a ball are the last three numbers of its quaternion.
    let turn = |at: DofElement| at.of(posture)[usize::from(at.is_ball())..].iter().any(|&q| q != 0.0);
    creature.joints()[joint].elements().any(turn)
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
    /// Another answer, nearly fitted, explains the touches of a joint better.
    Better(usize, BodySchema),
}

impl Doubt {
    /// The joint or the limb that is wrong as the schema has it.
    fn member(&self) -> Member {
        match self {
            Doubt::Of(member) => *member,
            Doubt::Better(joint, _) => Member::Joint(*joint),
        }
    }
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
            false => touch.prepared.gap(self.agent.skin(), schema).distance.abs(),
        }
    }

    /// The same, of surfaces as [`PreparedTouch::felt_gap`] has it.
    pub fn felt_gap(&self, widest: f64, touch: &ToldTouch, schema: &BodySchema) -> f64 {
        match self.by_points() {
            true => self.miss(touch, schema),
            false => touch.prepared.felt_gap(self.agent.skin(), schema, widest),
        }
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
            let Some(doubt) = self.doubt(&of, &learned.schema, deviation) else {
                if let Some(account) = &learned.account {
                    learned.verdict = account.verdict(self.agent.creature());
                }
                return (learned, fallen);
            };
            let schema = match doubt {
                Doubt::Better(_, other) if images < MOST_IMAGES => {
                    images += 1;
                    other
                }
                doubt => {
                    let wrong = doubt.member();
                    fallen.push(wrong);
                    told.retain(|&number| !touches[number].tells_of(wrong));
                    learned.schema
                }
            };
            learned = fit(&schema, &told);
        }
    }

    /// The joint or the limb that speaks most against a schema that was fitted to touches, if any does; `deviation` is that of a
    /// gap, metres.
    pub fn doubted(&self, told: &[&ToldTouch], schema: &BodySchema, deviation: f64) -> Option<Member> {
        self.doubt(told, schema, deviation).map(|doubt| doubt.member())
    }

    /// What speaks most against a schema that was fitted to touches; `deviation` is that of a gap, metres.
    fn doubt(&self, told: &[&ToldTouch], schema: &BodySchema, deviation: f64) -> Option<Doubt> {
        if let Some(wrong) = self.most_open(told, schema, deviation) {
            return Some(Doubt::Of(wrong));
        }
        let is_true = |touch: &&ToldTouch| !self.has_false_touches || !self.is_open(touch, schema, deviation);
        let true_ones: Vec<&ToldTouch> = told.iter().copied().filter(is_true).collect();
        if let Some(wrong) = self.patterned(&true_ones, schema, deviation) {
            return Some(Doubt::Of(wrong));
        }
        self.image(&true_ones, schema, deviation)
    }

    /// Of the joints and limbs that several touches are against that one which the greatest share of its touches is, beyond chance;
    /// each touch comes with whether it is against what it tells of. `wrong` judges by the touches for and against it.
    pub fn most_suspect<'t>(
        &self,
        told: impl Iterator<Item = (&'t ToldTouch, bool)>,
        wrong: impl Fn(Member, &Testimony) -> bool,
    ) -> Option<Member> {
        let told: Vec<(&ToldTouch, bool)> = told.collect();
        let creature = self.agent.creature();
        let joints = (0..creature.joints().len()).map(Member::Joint);
        let members = joints.chain((0..creature.limbs().len()).map(Member::Limb));
        let chances = self.chances(&told);
        let tally = |tells: &dyn Fn(&ToldTouch) -> bool| {
            let mut tally = Testimony::default();
            for (&(_, against), chance) in told.iter().zip(&chances).filter(|((touch, _), _)| tells(touch)) {
                *(if against { &mut tally.against } else { &mut tally.right }) += 1.0;
                tally.by_chance += chance;
            }
            tally
        };
        let all = tally(&|_| true);
        let [false_before, before] = if self.has_false_touches { BEFOREHAND } else { [0.0, 1.0] };
        let testimony = members.map(|member| {
            let of_it = tally(&|touch| touch.tells_of(member));
            let elsewhere = all.by_chance - of_it.by_chance + before;
            let expected = (all.against - of_it.against + false_before) * of_it.by_chance / elsewhere;
            (member, Testimony { by_chance: ROUGHLY * expected + LUCK * expected.sqrt(), ..of_it })
        });
        let suspects =
            testimony.filter(|(member, of_it)| of_it.against >= CONTRADICTIONS && wrong(*member, of_it));
        suspects.max_by(|a, b| a.1.beyond().total_cmp(&b.1.beyond())).map(|(member, _)| member)
    }

    /// Per touch its share of what false touches are expected in, 1 on average: one end of these is any receptor, so that of limbs
    /// that seldom touch most touches may be false.
    fn chances(&self, told: &[(&ToldTouch, bool)]) -> Vec<f64> {
        let mut receptors = vec![0.0; self.agent.creature().limbs().len()];
        self.agent.skin().receptors.iter().for_each(|receptor| receptors[receptor.limb] += 1.0);
        let mut felt = vec![0.0; receptors.len()];
        let mut between: BTreeMap<[usize; 2], f64> = BTreeMap::new();
        for (touch, _) in told {
            touch.limbs.into_iter().for_each(|limb| felt[limb] += 1.0);
            *between.entry(touch.limbs).or_default() += 1.0;
        }
        let of_pair = |[a, b]: [usize; 2]| receptors[a] * felt[b] + felt[a] * receptors[b];
        let all: f64 = between.keys().map(|&limbs| of_pair(limbs)).sum();
        let one = told.len() as f64 / all.max(1.0);
        told.iter().map(|(touch, _)| one * of_pair(touch.limbs) / between[&touch.limbs]).collect()
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
