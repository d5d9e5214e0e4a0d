//! What is known of a body, and what may be said: one account, worked out once and carried everywhere.
//!
//! Known is what can be placed. For every limb that has skin the account holds how far any of its skin may be off in
//! every other limb's frame. Limbs that are placed against one another form a class; that two limbs are of one class
//! is a *claim*, and the only kind of claim that there is. What joints and limbs are named as undetermined follows
//! from the classes: joints could not say that a thorax and a femur are known and the coxa between them is not.

use nalgebra::DMatrix;

use super::observability::Observability;
use super::placement::{Z95, distances};
use super::{LengthUnit, Verdict};
use crate::agent::Agent;
use crate::creature::Creature;
use crate::kinematics::Chain;
use crate::schema::BodySchema;
use crate::senses::Touch;

/// Skin is placed where it is known to this along every direction, in the unit that its body is learned in: one standard
/// deviation, a millimetre on bodies of a person's size.
pub const PLACED: f64 = 1e-3;
/// Farther off than this, in the unit that the body is learned in, is no bound: the body itself is smaller.
const FARTHEST: f64 = 10.0;

/// So many times as many touches are no advice to anybody.
const MANY_TIMES: f64 = 20.0;

/// What is known of a body.
#[derive(Clone, Debug)]
pub struct Account {
    /// What the touches determine of positions and axes.
    pub observability: Observability,
    /// The touches that it rests on.
    pub witnesses: Witnesses,
    /// The limbs that have skin, in the creature's order.
    limbs: Vec<usize>,
    /// Between each two of these, how far off skin may be, metres.
    distances: DMatrix<f64>,
    /// What is placed, metres.
    limit: f64,
    /// The limbs of each class, the largest class first.
    classes: Vec<Vec<usize>>,
    /// Per limb its class; none without skin.
    class_of: Vec<Option<usize>>,
    undetermined: Vec<usize>,
    undetermined_limbs: Vec<usize>,
}

/// The touches that an account rests on.
#[derive(Clone, Debug)]
pub struct Witnesses {
    /// Per limb, its touches that support the schema.
    pub of_limbs: Vec<usize>,
    /// Per limb, all its touches, those included that the schema leaves open.
    pub made_of_limbs: Vec<usize>,
    /// How far off the points are that touches tell, metres, a standard deviation; of surfaces the gaps, or 0 where these
    /// show no noise. Touches place nothing better than they are known themselves.
    pub point_deviation: f64,
    /// Whether they show no more noise than the least that the learner assumes: they are explained to the numerical
    /// floor, and the account says no less than is the case.
    pub at_floor: bool,
}

/// What is known of a limb, as every output has it.
#[derive(Clone, Debug)]
pub struct LimbLine {
    /// The limb.
    pub limb: usize,
    /// All touches of its skin.
    pub touches: usize,
    /// Those that support the schema.
    pub supporting: usize,
    /// How far off its skin may be at 95 %, metres, in the frame of the located limb where it is known best, and in that
    /// where it is known worst; infinite without a bound.
    pub bounds: [f64; 2],
    /// Why it is not located; `None` if it is.
    pub why: Option<String>,
}

/// Why a limb is not placed in the frames of the largest class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Openness {
    /// Nothing touched its skin.
    NeverTouched,
    /// So many touches of its skin, none of which supports the schema.
    Unsupported(usize),
    /// A joint on the way has no touch across it that counts.
    JointNeverTouched(usize),
    /// It can move without any touch feeling it.
    MovesUnfelt,
    /// Its touches are too few or too noisy.
    TooFewTouches,
}

impl Openness {
    /// It in words.
    pub fn words(self, creature: &Creature) -> String {
        match self {
            Openness::NeverTouched => "never touched".to_string(),
            Openness::Unsupported(1) => "its one touch does not support the schema".to_string(),
            Openness::Unsupported(touches) => format!("none of its {touches} touches supports the schema"),
            Openness::JointNeverTouched(joint) => {
                format!("no touch across {}", creature.joints()[joint].name)
            }
            Openness::MovesUnfelt => "moves without any touch feeling it".to_string(),
            Openness::TooFewTouches => "too few touches".to_string(),
        }
    }
}

impl Account {
    /// The account of a schema from what its touches determine.
    pub fn new(
        agent: &Agent,
        schema: &BodySchema,
        observability: Observability,
        witnesses: Witnesses,
    ) -> Account {
        let creature = agent.creature();
        let limbs = agent.limbs_with_skin();
        let distances = distances(agent, schema, &observability, &limbs);
        Account::of_distances(creature, observability, limbs, distances, witnesses)
    }

    /// The same account with how far off skin may be by what else is known, metres, a row and a column per limb of
    /// [`limbs`](Account::limbs).
    pub(super) fn with_distances(self, creature: &Creature, distances: DMatrix<f64>) -> Account {
        Account::of_distances(creature, self.observability, self.limbs, distances, self.witnesses)
    }

    /// How far off skin may be between each two of [`limbs`](Account::limbs), metres at 95 %.
    pub(super) fn distances(&self) -> &DMatrix<f64> {
        &self.distances
    }

    /// An account of which the distances (metres, a row and a column per limb of `limbs`) were worked out before.
    pub fn of_distances(
        creature: &Creature,
        observability: Observability,
        limbs: Vec<usize>,
        distances: DMatrix<f64>,
        witnesses: Witnesses,
    ) -> Account {
        let unit = observability.unit().metres();
        let distances = distances.map(|d| if d > FARTHEST * unit { f64::INFINITY } else { d });
        let placed = PLACED * unit;
        let limit = Z95 * placed.max(witnesses.point_deviation);
        let classes = classes(&limbs, &distances, limit);
        let mut class_of = vec![None; creature.limbs().len()];
        for (number, class) in classes.iter().enumerate() {
            class.iter().for_each(|&limb| class_of[limb] = Some(number));
        }
        let undetermined = undetermined_joints(creature, &classes, observability.known());
        let undetermined_limbs = undetermined_limbs(creature, &class_of, &undetermined);
        Account {
            observability,
            witnesses,
            limbs,
            distances,
            limit,
            classes,
            class_of,
            undetermined,
            undetermined_limbs,
        }
    }

    /// The same in metres, where it was worked out in another unit: what is placed stays what it was in that.
    pub(super) fn in_metres(&self, creature: &Creature, unit: LengthUnit) -> Account {
        let witnesses = Witnesses {
            point_deviation: unit.metres() * self.witnesses.point_deviation,
            ..self.witnesses.clone()
        };
        let observability = self.observability.clone().in_metres(unit);
        let distances = unit.metres() * &self.distances;
        Account::of_distances(creature, observability, self.limbs.clone(), distances, witnesses)
    }

    /// Whether it is claimed that skin of either limb is placed in the other's frame.
    pub fn claims(&self, a: usize, b: usize) -> bool {
        a == b || (self.class_of[a].is_some() && self.class_of[a] == self.class_of[b])
    }

    /// The limbs that are located relative to one another: the largest class; none where no two are.
    pub fn located(&self) -> &[usize] {
        self.classes.first().filter(|largest| largest.len() > 1).map_or(&[], Vec::as_slice)
    }

    /// Whether anything at all is claimed.
    pub fn claims_any(&self) -> bool {
        !self.located().is_empty()
    }

    /// The same account beside all touches that were made, those included that its learner left out.
    pub fn with_made(mut self, agent: &Agent, touches: &[Touch]) -> Account {
        self.witnesses.made_of_limbs = vec![0; agent.creature().limbs().len()];
        let limbs = touches.iter().flat_map(|touch| touch.limbs(agent.skin()));
        limbs.for_each(|limb| self.witnesses.made_of_limbs[limb] += 1);
        self
    }

    /// How far off skin of either limb may be in the other's frame, metres, at 95 %; infinite where nothing bounds it
    /// or one has no skin.
    pub fn distance(&self, a: usize, b: usize) -> f64 {
        let place = |limb: usize| self.limbs.iter().position(|&other| other == limb);
        match (place(a), place(b)) {
            (Some(a), Some(b)) => self.distances[(a, b)],
            _ => f64::INFINITY,
        }
    }

    /// The limbs that have skin, in the creature's order.
    pub fn limbs(&self) -> &[usize] {
        &self.limbs
    }

    /// How far off skin may be at 95 % that is placed nevertheless, metres.
    pub fn limit(&self) -> f64 {
        self.limit
    }

    /// The limbs of each class, the largest class first.
    pub fn classes(&self) -> &[Vec<usize>] {
        &self.classes
    }

    /// The joints across which nothing is claimed, but those that were known before the first touch.
    pub fn undetermined(&self) -> &[usize] {
        &self.undetermined
    }

    /// The limbs that are not placed although no joint between them and limbs that are is undetermined.
    pub fn undetermined_limbs(&self) -> &[usize] {
        &self.undetermined_limbs
    }

    /// How far off a limb's skin may be in the frames of the largest class' other limbs, metres: in that where it is
    /// known best, and in that where it is known worst. None where there is no such limb.
    pub fn distance_to_most(&self, limb: usize) -> Option<[f64; 2]> {
        let largest = self.classes.first()?;
        // Where nothing is placed against anything no class is better than others.
        let most = if largest.len() > 1 { largest } else { &self.limbs };
        let others = most.iter().filter(|&&other| other != limb);
        others.map(|&other| self.distance(limb, other)).fold(None, |found, d| {
            let [least, most] = found.unwrap_or([d, d]);
            Some([d.min(least), d.max(most)])
        })
    }

    /// What is known of each limb that has skin, the limb that is known worst first.
    pub fn limb_lines(&self, creature: &Creature) -> Vec<LimbLine> {
        let line = |limb: usize| LimbLine {
            limb,
            touches: self.witnesses.made_of_limbs[limb],
            supporting: self.witnesses.of_limbs[limb],
            bounds: self.distance_to_most(limb).unwrap_or([f64::INFINITY; 2]),
            why: self.openness(creature, limb).map(|why| why.words(creature)),
        };
        let mut lines: Vec<LimbLine> = self.limbs.iter().map(|&limb| line(limb)).collect();
        lines.sort_by(|a, b| {
            let [best, worst] = [0, 1].map(|k| b.bounds[k].total_cmp(&a.bounds[k]));
            best.then(worst)
        });
        lines
    }

    /// Why a limb is not placed among the largest class; none where it is.
    pub fn openness(&self, creature: &Creature, limb: usize) -> Option<Openness> {
        let most = self.classes.first()?;
        // A limb alone is placed against nothing.
        if most.len() > 1 && most.contains(&limb) {
            return None;
        }
        if self.witnesses.of_limbs[limb] == 0 {
            return Some(match self.witnesses.made_of_limbs[limb] {
                0 => Openness::NeverTouched,
                made => Openness::Unsupported(made),
            });
        }
        let nearest =
            most.iter().min_by_key(|&&other| Chain::between(creature, limb, other).joints().count())?;
        let never = |joint: &usize| self.observability.untouched(*joint);
        if let Some(joint) = Chain::between(creature, limb, *nearest).joints().find(never) {
            return Some(Openness::JointNeverTouched(joint));
        }
        let bounded = self.distance_to_most(limb).is_some_and(|[least, _]| least.is_finite());
        Some(if bounded { Openness::TooFewTouches } else { Openness::MovesUnfelt })
    }

    /// What may be said of a schema that explains fresh touches: that it does, if anything is claimed by it; else what stands in
    /// the way.
    pub fn verdict(&self, creature: &Creature) -> Verdict {
        if self.claims_any() {
            return Verdict::Converged;
        }
        let pairs = (0..self.limbs.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
        let nearest = pairs.min_by(|a, b| self.distances[*a].total_cmp(&self.distances[*b]));
        let explains = "the schema predicts held-out touches, but locates no limb relative to another";
        let mend = "try more touches (--touches), at other places and in more varied postures, or another seed (--seed)";
        Verdict::Failed(match nearest {
            Some(pair) if self.distances[pair].is_finite() => {
                let [a, b] = [pair.0, pair.1].map(|limb| &creature.limbs()[self.limbs[limb]]);
                let (off, limit) = (self.distances[pair], self.limit);
                let times = (off / limit).powi(2);
                let enough = if times < MANY_TIMES {
                    format!(", which about {times:.1} times as many touches of the same noise would resolve")
                } else {
                    String::new()
                };
                format!(
                    "{explains} to {:.1} mm: skin of {b} relative to {a}, the best known, may be {:.1} mm off{enough}; {mend}",
                    1e3 * limit,
                    1e3 * off
                )
            }
            _ => format!(
                "{explains}: each can move without any effect on the touches; {mend}, or known joints (--known)"
            ),
        })
    }
}

/// The limbs that are placed against one another, directly or by way of others; the largest class first, of equals that
/// with the earlier limb.
fn classes(limbs: &[usize], distances: &DMatrix<f64>, limit: f64) -> Vec<Vec<usize>> {
    let mut classes: Vec<Vec<usize>> = Vec::new();
    let mut seen = vec![false; limbs.len()];
    for first in 0..limbs.len() {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let mut class = vec![first];
        let mut next = 0;
        while let Some(&at) = class.get(next) {
            for other in 0..limbs.len() {
                if !seen[other] && distances[(at, other)] <= limit {
                    seen[other] = true;
                    class.push(other);
                }
            }
            next += 1;
        }
        class.sort_unstable();
        classes.push(class.into_iter().map(|number| limbs[number]).collect());
    }
    classes.sort_by_key(|class| std::cmp::Reverse(class.len()));
    classes
}

/// The joints that no two limbs of one class have between them, but those that were `known` in advance.
fn undetermined_joints(creature: &Creature, classes: &[Vec<usize>], known: &[bool]) -> Vec<usize> {
    let mut told = known.to_vec();
    for class in classes {
        // Chains to one limb of the class make up all between its limbs.
        for &other in &class[1..] {
            Chain::between(creature, class[0], other).joints().for_each(|joint| told[joint] = true);
        }
    }
    (0..told.len()).filter(|&joint| !told[joint]).collect()
}

/// The limbs outside the largest class of their piece of the tree, where it is cut at the undetermined joints.
fn undetermined_limbs(creature: &Creature, class_of: &[Option<usize>], undetermined: &[usize]) -> Vec<usize> {
    // A piece is called by the limb nearest to the root.
    let mut piece: Vec<usize> = vec![0; class_of.len()];
    for (joint, parent) in creature.joints().iter().map(|joint| joint.parent).enumerate() {
        piece[joint + 1] = if undetermined.contains(&joint) { joint + 1 } else { piece[parent] };
    }
    let mut named = Vec::new();
    for root in (0..piece.len()).filter(|&limb| piece[limb] == limb) {
        let inside = || (0..piece.len()).filter(|&limb| piece[limb] == root && class_of[limb].is_some());
        let count = |class: Option<usize>| inside().filter(|&limb| class_of[limb] == class).count();
        // Of equals the first.
        let largest = inside().map(|limb| class_of[limb]).rev().max_by_key(|&class| count(class)).flatten();
        named.extend(inside().filter(|&limb| class_of[limb] != largest));
    }
    named.sort_unstable();
    named
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limbs_are_of_one_class_by_way_of_others() {
        let far = f64::INFINITY;
        let d = DMatrix::from_row_slice(
            4,
            4,
            &[
                0.0, far, 1.0, far, //
                far, 0.0, far, far, //
                1.0, far, 0.0, 2.0, //
                far, far, 2.0, 0.0,
            ],
        );
        assert_eq!(classes(&[0, 3, 4, 7], &d, 2.0), [vec![0, 4, 7], vec![3]]);
        assert_eq!(classes(&[0, 3, 4, 7], &d, 1.5), [vec![0, 4], vec![3], vec![7]]);
        assert_eq!(classes(&[], &DMatrix::zeros(0, 0), 1.0), Vec::<Vec<usize>>::new());
    }
}
