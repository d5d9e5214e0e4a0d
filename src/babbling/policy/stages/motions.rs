//! Where to move for a goal: what was touched once again, or an aim by the schema, and whether that promises anything.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::trials::SURVEY_TOUCHES;
use super::{ANYWHERE, Goal, Stages};
use crate::babbling::policy::foresight::Foreseen;
use crate::creature::Posture;
use crate::kinematics::{Chain, InverseKinematics, Place};
use crate::learning::growth::{GrownTouch, rest};
use crate::skin::Receptor;

/// How far a repeated touch scatters, in shares of the ranges; how much farther it goes than the touch was, radians
/// or metres, in shares of the way that led there.
const SCATTER: f64 = 0.15;
const FARTHER: f64 = 0.5;
const FARTHEST: f64 = 0.3;
/// Random postures are this power as far from the middle of a joint's range, in shares of its half.
const OUTWARDS: f64 = 0.4;
/// Random postures of which the one is chosen on whose way the touch is foreseen that tells most.
const IMAGINED: usize = 20;
/// Pairs of receptors of which that is aimed at whose limbs touched each other least.
const DRAWS: usize = 3;
/// How deep an aim goes into both limbs, metres, and how far from it a posture may stay.
const DEPTH: f64 = 0.01;
const NEAR: f64 = 0.01;
/// A limb that is placed to this, one standard deviation, metres, is where the schema has it.
const WELL_PLACED: f64 = 5e-4;

impl Stages {
    /// Learns which limbs pass through each other from a posture that was reached.
    pub(super) fn live_through(&mut self, posture: &[f64]) {
        let Some(schema) = self.growth.schema() else { return };
        // Limbs on joints that are not known yet are not where the schema has them.
        let places = self.joints().is_empty();
        let known = |limb: usize| (places || !self.wanted[limb]) && self.growth.placement(limb) < WELL_PLACED;
        self.foresight.pass(schema, posture, known);
    }

    /// Of some random postures that one on whose way the touch is foreseen that tells most; away from bare geometry first.
    pub(super) fn most_telling(&mut self, rng: &mut ChaCha8Rng) -> Posture {
        if let Some(met) = self.met.as_ref().filter(|met| met.bare) {
            return self.retreat(met, rng);
        }
        let guessed = self.growth.touches().len() >= SURVEY_TOUCHES && rng.random::<f64>() >= ANYWHERE;
        if guessed && self.outlook.is_none() {
            self.outlook = self.growth.outlook();
        }
        let Some(outlook) = self.outlook.as_ref().filter(|_| guessed) else { return self.anywhere(rng) };
        let gain =
            |target: &Posture| match self.foresight.foresee(&outlook.schema, [&self.start, target], |_| true)
            {
                Foreseen::Meeting(limbs, posture) => self.growth.gain(outlook, limbs, &posture),
                Foreseen::Nothing | Foreseen::Stuck => 0.0,
            };
        let targets = (0..IMAGINED).map(|_| self.anywhere(rng)).map(|target| (gain(&target), target));
        targets.max_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(|| self.here(), |(_, target)| target)
    }

    /// A random posture in which only what is free moves, as far as it goes more often than not: touches there tell most.
    pub(super) fn anywhere(&self, rng: &mut ChaCha8Rng) -> Posture {
        let creature = self.agent.creature();
        let mut posture = Posture::random(creature, rng);
        for at in creature.elements().filter(|at| !at.is_ball()) {
            let [low, high] = at.range;
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            let q = &mut posture[at.coordinate()];
            let share = ((*q - middle) / half).clamp(-1.0, 1.0);
            if share.is_finite() {
                *q = middle + half * share.signum() * share.abs().powf(OUTWARDS);
            }
        }
        self.rest_others(&mut posture);
        posture
    }

    /// The present posture, but what is not free at rest.
    pub(super) fn here(&self) -> Posture {
        let mut posture = self.start.clone();
        self.rest_others(&mut posture);
        posture
    }

    /// Puts a joint where it is when the body starts.
    fn rest(&self, joint: usize, posture: &mut Posture) {
        let Some(home) = &self.home else { return };
        for at in self.agent.creature().joints()[joint].elements() {
            at.of_mut(posture).copy_from_slice(at.of(home));
        }
    }

    pub(super) fn rest_others(&self, posture: &mut Posture) {
        let creature = self.agent.creature();
        let held = (0..self.free.len()).filter(|&joint| !self.free[joint]);
        held.for_each(|joint| self.rest(joint, posture));
        creature.couple(posture);
    }

    /// Whether the schema foresees that the way to a posture brings a limb that the goal wants to another one or, where it
    /// is not known where such limbs are, at least that nothing else gets in the way.
    pub(super) fn promises(&self, target: &Posture, sure: bool) -> bool {
        let Some(schema) = self.growth.schema() else { return true };
        let creature = self.agent.creature();
        // Joints that are not known yet: at rest it is known best where their limbs are.
        let [from, to] = [&self.start, target].map(|posture| {
            let mut posture = posture.clone();
            let unknown = (0..self.free.len()).filter(|&joint| !self.growth.resolved()[joint]);
            unknown.for_each(|joint| rest(creature, joint, &mut posture));
            posture
        });
        match self.foresight.foresee(schema, [&from, &to], |limb| self.growth.placed(limb)) {
            Foreseen::Meeting([a, b], _) => self.wanted[a] != self.wanted[b],
            Foreseen::Nothing => !sure,
            Foreseen::Stuck => false,
        }
    }

    /// Whether it serves the goal to touch again what a touch was of.
    pub(super) fn is_repeatable(&self, touch: &GrownTouch) -> bool {
        let [a, b] = touch.told.limbs.map(|limb| self.wanted[limb]);
        let told = match self.aim {
            // Before the first part is known whatever moves tells of it.
            Goal::Joints(_) => a != b || self.growth.schema().is_none(),
            // Of two limbs neither of which is placed a touch does not place one.
            Goal::Limb(_) => a != b && self.growth.placed(touch.told.limbs[usize::from(a)]),
        };
        !self.growth.is_spare(touch) && told && touch.told.moving.iter().all(|&joint| self.free[joint])
    }

    /// Remembers a touch by its pair of limbs, where it serves the goal to touch that again.
    pub(super) fn remember(&mut self, number: usize) {
        let touch = &self.growth.touches()[number];
        if self.growth.is_spare(touch) && self.growth.schema().is_none() {
            // Of this pair there are enough.
            self.repeatable.remove(&touch.told.limbs);
        } else if self.is_repeatable(touch) {
            self.repeatable.entry(touch.told.limbs).or_default().push(number);
        }
    }

    /// A touch that it serves the goal to repeat: each pair of limbs as likely as any other, however often it was touched.
    fn repeated(&self, rng: &mut ChaCha8Rng) -> Option<usize> {
        let pair = rng.random_range(0..self.repeatable.len().max(1));
        let known = self.repeatable.values().nth(pair)?;
        Some(known[rng.random_range(0..known.len())])
    }

    /// A posture in which two places meet, by what is known of the joints between them, from a random one; what is not
    /// between them stays where it is: the less moves, the less gets in the way.
    fn brought_together(&self, [a, b]: [Place; 2], mut start: Posture, random: &Posture) -> Option<Posture> {
        let creature = self.agent.creature();
        let between = Chain::between(creature, a.limb, b.limb);
        for at in between.joints().flat_map(|joint| creature.joints()[joint].elements()) {
            at.of_mut(&mut start).copy_from_slice(at.of(random));
        }
        creature.couple(&mut start);
        let known = |joint: usize| self.free[joint] && !self.joints().contains(&joint);
        let schema = self.growth.schema()?;
        let reach = InverseKinematics::new(creature, schema, [a, b.reversed()]).moving(known).solve(&start);
        (reach.miss < NEAR).then_some(reach.posture)
    }

    /// A posture near one in which something was touched that the goal wants: a little farther on the way that led there and a
    /// little beside it, in shares of the joints' ranges.
    pub(super) fn again(&self, rng: &mut ChaCha8Rng) -> Option<Posture> {
        let number = self.repeated(rng)?;
        let creature = self.agent.creature();
        let [touched, from] = &self.remembered[number];
        let mut target = self.here();
        let between = self.growth.touches()[number].told.chain.iter().filter(|&&joint| self.free[joint]);
        let coordinates = between.clone().map(|&joint| creature.joints()[joint].dofs.len());
        let few = SCATTER / (coordinates.sum::<usize>() as f64).sqrt();
        for &joint in between {
            // Of a joint that hardly moves its touches tell hardly anything.
            let scatter = if self.joints().contains(&joint) { SCATTER } else { few };
            for at in creature.joints()[joint].elements() {
                if at.is_ball() {
                    at.of_mut(&mut target).copy_from_slice(at.of(touched));
                    continue;
                }
                let (q, [low, high]) = (at.coordinate(), at.range);
                let further = FARTHER * (touched[q] - from[q]).clamp(-FARTHEST, FARTHEST);
                let scatter = scatter * (high - low) * (2.0 * rng.random::<f64>() - 1.0);
                target[q] = (touched[q] + further + scatter).clamp(low, high);
            }
        }
        creature.couple(&mut target);
        Some(target)
    }

    /// A posture that brings a limb that the goal wants to another one, by the schema; what is not known stays where chance
    /// puts it.
    pub(super) fn aimed(&self, sure: bool, rng: &mut ChaCha8Rng) -> Option<Posture> {
        let (creature, skin) = (self.agent.creature(), self.agent.skin());
        let on = |fits: &dyn Fn(usize) -> bool| -> Vec<usize> {
            (0..skin.receptors.len()).filter(|&receptor| fits(skin.receptors[receptor].limb)).collect()
        };
        let wanted = on(&|limb| self.wanted[limb] && (!sure || self.growth.placed(limb)));
        let others = on(&|limb| !self.wanted[limb] && self.growth.placed(limb));
        if wanted.is_empty() || others.is_empty() {
            return None;
        }
        // Limbs that hardly touched each other tell most of where they are.
        let mut draw =
            || [&wanted, &others].map(|list| &skin.receptors[list[rng.random_range(0..list.len())]]);
        let draws: Vec<_> = (0..DRAWS).map(|_| draw()).collect();
        let times = |ends: &[&Receptor; 2]| {
            let [a, b] = ends.map(|end| end.limb);
            let of_pair = |touch: &&GrownTouch| touch.told.limbs == [a.min(b), a.max(b)];
            self.growth.touches().iter().filter(of_pair).count()
        };
        let receptors = draws.into_iter().min_by_key(times)?;
        let [a, b] = receptors.map(|receptor| receptor.limb);
        if creature.neighbouring(a, b) {
            return None;
        }
        let ends = receptors.map(|receptor| receptor.place(-DEPTH));
        self.brought_together(ends, self.here(), &self.anywhere(rng))
    }
}
