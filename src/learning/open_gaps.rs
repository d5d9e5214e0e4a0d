//! Which touches a schema leaves open, and which joints they blame.
//!
//! A joint that turns little leaves a trace in the touches that a mirrored axis can nearly imitate, and
//! receptor centres are too coarse to tell the two apart. The surfaces are not: where most gaps are
//! closed and some stay open, the joints that the open ones share are at fault.

use nalgebra::DMatrix;

use crate::agent::Agent;
use crate::creature::DofKind;
use crate::kinematics::Chain;
use crate::learning::annealing::{quantile, sorted, typical_gap};
use crate::learning::noise::{Adjusted, Compared, Noise, gaps_of};
use crate::learning::surface_gap::CERTAIN_NOISE;
use crate::learning::touch_set::{PreparedTouch, TouchSet};
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// A gap is open when it is wider than this, metres, and than [`DEVIATIONS`]; …
const OPEN: f64 = 5e-5;
/// … where touches are exact: right answers leave a tenth of it, and a wrong axis of a joint that turns little ten times as
/// much.
pub const EXACTLY_OPEN: f64 = 5e-6;
/// A touch feels a joint that changes its gap by more than this, metres a radian, and than this share of its deviation: one that feels none of its joints tells of
/// nothing. Limbs that are placed so that they spin about themselves touch for ever, and explain any touch of round skin.
pub const FELT: f64 = 1e-6;
const FELT_BY_DEVIATION: f64 = 0.1;
/// Standard deviations of the gaps, as the gaps show it, that a closed gap stays within.
const DEVIATIONS: f64 = 5.0;
/// Share of open gaps that false touches may make up in the long run …
const FALSE_SHARE: f64 = 0.12;
/// … and standard deviations that chance may add to it in few.
const CHANCE: f64 = 2.0;
/// How many times more false touches two joints may have than the limbs' touches let expect, which is only roughly so.
const ROUGHLY: f64 = 1.25;
/// Open touches with two joints that are no sign of anything.
const ONE_BY_CHANCE: f64 = 3.0;
/// Touches with a joint below which their share says little of it.
const FEW: f64 = 6.0;

/// Share of false touches that are believed: of more, too few are left to tell which.
pub const MOST_FALSE: f64 = 0.4;

/// Share of open touches with two joints, beyond that of all touches, from which on none with both counts, …
const DISPUTED: f64 = 0.3;
/// … and which is enough however many are open.
const MOST_DISPUTED: f64 = 0.6;

/// How many touches are open and how many there are: in all, and with each two joints in their chains.
///
/// Two fingers may touch each other a hundred times and the rest of the body five. A schema in which they fit each
/// other and not the body leaves few gaps open of either's, but most of those with both a finger and the wrist.
#[derive(Clone, Debug)]
pub struct GapTally {
    joints: usize,
    counts: Vec<[f64; 2]>,
    /// Open ones and all.
    pub all: [f64; 2],
}

impl GapTally {
    /// Nothing counted yet.
    pub fn new(joints: usize) -> GapTally {
        GapTally { joints, counts: vec![[0.0; 2]; joints * joints], all: [0.0; 2] }
    }

    /// Counts a touch with a chain of joints.
    pub fn add(&mut self, chain: &Chain, open: bool) {
        self.add_many(chain, [f64::from(u8::from(open)), 1.0]);
    }

    fn add_many(&mut self, chain: &Chain, counts: [f64; 2]) {
        let add = |sum: &mut [f64; 2]| (0..2).for_each(|k| sum[k] += counts[k]);
        add(&mut self.all);
        for first in chain.joints() {
            for second in chain.joints().filter(|&second| second >= first) {
                add(&mut self.counts[first * self.joints + second]);
            }
        }
    }

    /// Open touches and all with two joints, the first not after the second; or one and the same.
    pub fn of(&self, first: usize, second: usize) -> [f64; 2] {
        self.counts[first * self.joints + second]
    }

    /// What false touches would bring of which one end is any receptor, and the other touches as often as in `touches`.
    pub fn of_chance(agent: &Agent, touches: &TouchSet) -> GapTally {
        let creature = agent.creature();
        let mut on_limb = vec![0.0; creature.limbs().len()];
        agent.skin().receptors.iter().for_each(|receptor| on_limb[receptor.limb] += 1.0);
        let felt = touches.count_of_limbs(creature);
        let mut found = GapTally::new(creature.joints().len());
        for first in 0..on_limb.len() {
            for second in first + 1..on_limb.len() {
                let ways = on_limb[first] * felt[second] as f64 + felt[first] as f64 * on_limb[second];
                if ways > 0.0 {
                    found.add_many(&Chain::between(creature, first, second), [ways, ways]);
                }
            }
        }
        found
    }

    /// The most open touches that have any two joints, in units of those that false touches may make up there by
    /// `chance`: as many of them as touches elsewhere show, and what luck may add. Where nearly all others close, a
    /// handful that share two joints are no coincidence.
    fn crowded(&self, chance: &GapTally) -> f64 {
        let excess = |(counts, ways): (&[f64; 2], &[f64; 2])| {
            let expected = self.expected(counts, ways, chance);
            counts[0] / (ONE_BY_CHANCE + expected + 3.0 * expected.sqrt())
        };
        self.counts.iter().zip(&chance.counts).map(excess).fold(0.0, f64::max)
    }

    /// How many of these touches false ones leave open, as open touches elsewhere show.
    fn expected(&self, counts: &[f64; 2], ways: &[f64; 2], chance: &GapTally) -> f64 {
        let share = ways[0] / chance.all[0].max(1.0);
        ROUGHLY * (self.all[0] - counts[0]) * share / (1.0 - share).max(0.1)
    }

    /// Per two joints, the open touches beyond those that false touches and luck may make up, and all.
    pub fn beyond(&self, chance: &GapTally) -> impl Iterator<Item = [f64; 2]> {
        self.counts.iter().zip(&chance.counts).map(|(counts, ways)| {
            let expected = self.expected(counts, ways, chance);
            [(counts[0] - expected - CHANCE * expected.sqrt()).max(0.0), counts[1]]
        })
    }
}

/// Those of some touches that may testify to a schema that was fitted to them all.
///
/// A fit chooses which touches it closes where it cannot close all. The few that it chose of two joints check one
/// another, and bear out what the others deny. So where many touches with two joints stay open, no touch with both
/// counts. `deviation` is that of a touch's gap by its number, metres; one that would close
/// whichever way its hinges turned counts as open, too; and where touches are `exact` one that closes out of the patches that felt it.
pub fn witnesses(
    agent: &Agent,
    touches: &TouchSet,
    schema: &BodySchema,
    deviation: impl Fn(usize) -> f64,
    exact: bool,
) -> TouchSet {
    let skin = agent.skin();
    let wide = if exact { EXACTLY_OPEN } else { OPEN };
    let creature = agent.creature();
    let mut found = GapTally::new(creature.joints().len());
    let mut number = 0;
    for pair in &touches.pairs {
        let dofs = || pair.chain.joints().flat_map(|joint| creature.joints()[joint].elements());
        let of_hinges = dofs().all(|element| element.kind == DofKind::Hinge);
        for touch in &pair.touches {
            let wide = wide.max(DEVIATIONS * deviation(number));
            let gap = touch.felt_gap(skin, schema, if exact { wide } else { 0.0 });
            let felt = FELT.max(FELT_BY_DEVIATION * deviation(number));
            let is_unfelt =
                || of_hinges && touch.gap_slopes(skin, schema).all(|(_, slope)| slope.abs() < felt);
            found.add(&pair.chain, gap > wide || is_unfelt());
            number += 1;
        }
    }
    let share = found.all[0] / found.all[1].max(1.0);
    let most = (DISPUTED + share).min(MOST_DISPUTED);
    let disputed = |first: usize, second: usize| {
        let [open, all] = found.of(first, second);
        open >= ONE_BY_CHANCE && open > most * all
    };
    let testifies = |chain: &Chain| {
        let pairs = chain.joints().flat_map(|first| chain.joints().map(move |second| (first, second)));
        !pairs.filter(|(first, second)| first <= second).any(|(first, second)| disputed(first, second))
    };
    touches.filter(|pair| testifies(&pair.chain))
}

/// How many gaps are open under a schema.
#[derive(Clone, Debug)]
pub struct OpenGaps {
    /// The greatest share, of any two joints, in units of what false touches and chance may make up.
    pub worst: f64,
    /// Of the joints that have more than few touches, the one of which more than the usual share stays open, by most deviations of
    /// chance; `None` if all are closed.
    pub worst_joint: Option<usize>,
}

impl OpenGaps {
    /// Counts the open gaps of a schema.
    pub fn new(agent: &Agent, touches: &TouchSet, schema: &BodySchema) -> OpenGaps {
        let gap = |touch: &PreparedTouch| touch.gap(agent.skin(), schema).distance.abs();
        let gaps: Vec<f64> = touches.touches().map(gap).collect();
        let sorted = sorted(gaps.iter().copied());
        let typical = typical_gap(&sorted);
        let nothing = Parameters::new(agent.creature(), AxisModel::Unit, |_| false);
        // Noisy joints open the gaps of long chains.
        let noisy = (quantile(&sorted, 0.5) > CERTAIN_NOISE).then(|| {
            let gaps = gaps_of((agent, Compared::Surfaces), &Adjusted::none(touches), &nothing, schema);
            (Noise::estimate(&gaps, &nothing, &DMatrix::zeros(0, 0), None, false), gaps)
        });
        let deviation = |number: usize| match &noisy {
            Some((noise, gaps)) => noise.variance(&gaps[number]).sqrt(),
            None => typical,
        };
        let joints = agent.creature().joints().len();
        let mut found = GapTally::new(joints);
        let mut number = 0;
        for pair in &touches.pairs {
            for _ in &pair.touches {
                found.add(&pair.chain, gaps[number] > OPEN.max(DEVIATIONS * deviation(number)));
                number += 1;
            }
        }
        let share = |[open, all]: [f64; 2]| if all >= FEW { open / all } else { 0.0 };
        let excess = |counts: [f64; 2]| {
            let chance = (FALSE_SHARE * (1.0 - FALSE_SHARE) / counts[1].max(FEW)).sqrt();
            share(counts) / (FALSE_SHARE + CHANCE * chance)
        };
        let chance = GapTally::of_chance(agent, touches);
        let most = found.all[0] / (MOST_FALSE * found.all[1]).max(FEW);
        let worst = found.beyond(&chance).map(excess).fold(found.crowded(&chance).max(most), f64::max);
        let [open, touches] = found.all;
        let usual = open / touches.max(1.0);
        // In how many deviations of chance more than the usual share of a joint's touches are open.
        let unusual = |[open, all]: [f64; 2]| match all >= FEW {
            true => (open - usual * all) / (usual * (1.0 - usual) * all).max(1.0).sqrt(),
            false => 0.0,
        };
        let of_joints = (0..joints).map(|joint| (joint, unusual(found.of(joint, joint))));
        let worst_joint = of_joints.filter(|(_, unusual)| *unusual > 0.0).max_by(|a, b| a.1.total_cmp(&b.1));
        OpenGaps { worst, worst_joint: worst_joint.map(|(joint, _)| joint) }
    }

    /// Whether false touches and chance may have left open what is open, for every joint.
    pub fn tolerable(&self) -> bool {
        self.worst <= 1.0
    }
}
