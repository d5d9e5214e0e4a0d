//! Starts from random initial guesses, until one is accepted or none will be.

use std::collections::BTreeMap;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{MOST_NOISE, SecondOrder, taken_deviation};
use crate::deadline::{count, side_by_side, worked};
use crate::learning::annealing::NARROWEST;
use crate::learning::growing::{Evidence, MultiStart, Start, WHOLE_DOF};
use crate::learning::surface_gap::CERTAIN_NOISE;
use crate::learning::touch_set::TouchSet;
use crate::learning::{LimbFrames, PriorKnowledge};
use crate::senses::Input;
use crate::senses::Touch;

/// Every how many touches one is kept back to judge a start.
const KEPT_BACK: usize = 5;
/// Starts tried with a body that is seldom solved whole.
const LARGE_STARTS: usize = 2;
/// Starts after which one is taken though it knows fewer joints than have touches of their own.
const INCOMPLETE_STARTS: usize = 2;
/// The same where limbs have frames of their own, …
const INCOMPLETE_LIMB_STARTS: usize = 6;
/// … and after which none is made more where all know nothing: chains are too long to begin with any.
const BLIND_LIMB_STARTS: usize = 3;
/// Where gaps show noise, only trying can tell whether less of it was to be had: two starts must agree on the
/// least noise to this share of it.
const AGREEMENT: f64 = 0.03;
/// So many starts that agree on what the touches do not bear out are not bettered by more, …
const HOPELESS_STARTS: usize = 3;
/// … but tangles are many, and alike in how wide their gaps are, metres.
const TANGLED: f64 = 5e-3;
/// Touches of one limb pair that a start uses at most; the last fit uses all.
const TOUCHES_PER_PAIR: usize = 150;
/// Whitened residuals above which points are taken to have noise, and a second start must agree.
const VISIBLE_NOISE: f64 = 0.1;
/// Random stream of the look at how much noise points have; starts count from 0 and never get here.
const NOISE_STREAM: u64 = u64::MAX - 4;
/// Starts tried with points that have noise.
const NOISY_STARTS: usize = 8;

/// A start and how it did on touches that it was not fitted to.
pub(super) struct Judged {
    pub start: Start,
    /// 1 is just acceptable.
    pub judged: f64,
    /// Noise of the touches that it was fitted to, metres.
    pub noise: f64,
}

impl Judged {
    /// How many joints it knows, and limbs.
    pub fn known(&self) -> usize {
        self.start.known.iter().chain(&self.start.placed).filter(|&&known| known).count()
    }

    fn better(&self, other: &Judged) -> bool {
        if self.start.accepted != other.start.accepted {
            return self.start.accepted;
        }
        if self.start.accepted && self.known() != other.known() {
            return self.known() > other.known();
        }
        let score = |judged: &Judged| judged.judged.max(1.0) * judged.noise.max(NARROWEST);
        if self.start.accepted { self.noise < other.noise } else { score(self) < score(other) }
    }
}

impl SecondOrder {
    /// The touches that starts are fitted to: not those kept back, and not all of the most frequent pairs.
    pub(super) fn fitted(&self) -> impl Iterator<Item = &Touch> {
        let mut per_pair = BTreeMap::new();
        let few_of_a_pair = move |touch: &&Touch| {
            let limbs = touch.ends.map(|end| self.agent.skin().receptors[end.receptor].limb);
            let count = per_pair.entry(limbs).or_insert(0);
            *count += 1;
            *count <= TOUCHES_PER_PAIR
        };
        let fitted = self.touches.iter().enumerate().filter(|(i, _)| !kept_back(*i));
        fitted.map(|(_, touch)| touch).filter(few_of_a_pair)
    }

    /// What start number `turn` is made from.
    pub(super) fn multi_start<'t>(
        &'t self,
        evidence: Evidence<'t>,
        touches: &'t TouchSet,
        turn: usize,
    ) -> MultiStart<'t> {
        let PriorKnowledge { prior, frozen, .. } = &self.known;
        let (agent, frames, deadline) = (&self.agent, self.frames, self.deadline);
        MultiStart { agent, touches, evidence, frames, prior, frozen, turn, deadline }
    }

    /// What answers are sought by: of points that show noise, of which nobody knows how much it is, in that of a first part.
    pub(super) fn shown_evidence(&self, touches: &TouchSet) -> Evidence<'_> {
        let evidence = self.evidence();
        if self.input != Input::Contact || self.frames == LimbFrames::Limb {
            return evidence;
        }
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(NOISE_STREAM);
        let most = MOST_NOISE / taken_deviation(touches);
        let noise = self.multi_start(evidence, touches, 0).point_noise(&mut rng);
        let noise = noise.filter(|noise| (VISIBLE_NOISE..=most).contains(&noise.of_points));
        noise.map_or(evidence, Evidence::NoisyPoints)
    }

    /// Makes so many starts at most, as many as it takes: the best, and how many random initial guesses it took.
    pub(super) fn search(&self, starts: usize, touches: &TouchSet, fresh: &TouchSet) -> (Judged, usize) {
        let evidence = self.shown_evidence(touches);
        let solvable = self.multi_start(evidence, touches, 0).solvable();
        // Starts of a large body are long.
        let is_large = self.agent.creature().dof() > WHOLE_DOF;
        let (most, incomplete_starts) = match (self.frames, evidence) {
            (LimbFrames::Limb, _) => (starts, INCOMPLETE_LIMB_STARTS),
            (_, Evidence::NoisyPoints(_)) => (NOISY_STARTS, NOISY_STARTS),
            _ if is_large && !evidence.exact() => (LARGE_STARTS, INCOMPLETE_STARTS),
            _ => (starts, INCOMPLETE_STARTS),
        };
        let make = |number: usize| {
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
            rng.set_stream(number as u64);
            let mut start = self.multi_start(evidence, touches, number).start(&mut rng);
            self.fit_start_in_noise(touches, &mut start);
            let (judged, noise) = self.judge(evidence, touches, fresh, &start);
            // How wide noise leaves a part is for all touches to say.
            start.accepted = judged <= 1.0 && (start.accepted || evidence.may_be_noisy());
            Judged { start, judged, noise }
        };
        // All cores make starts; which one is taken does not depend on how many there are.
        let mut best: Option<Judged> = None;
        let mut initial_guesses = 0;
        let mut noises: Vec<f64> = Vec::new();
        let points = self.input == Input::Contact;
        let numbers: Vec<usize> = (0..starts.min(most)).collect();
        let before = worked();
        'waves: for wave in numbers.chunks(rayon::current_num_threads()) {
            let made = side_by_side(before, wave.to_vec(), make);
            for ((trial, done), number) in made.into_iter().zip(wave) {
                // As if one had been made after the other: those beyond the last one did not happen.
                if best.is_some() && self.deadline.has_passed() {
                    break 'waves;
                }
                count(done);
                initial_guesses += trial.start.initial_guesses;
                noises.push(trial.noise);
                if best.as_ref().is_none_or(|best| trial.better(best)) {
                    best = Some(trial);
                }
                let best = best.as_ref().expect("one was made");
                let complete = best.known() >= solvable || *number + 1 >= incomplete_starts;
                let blind = self.frames == LimbFrames::Limb && best.known() == 0;
                let is_found = best.start.accepted && complete && is_certain(&noises, best.noise);
                if is_found || (blind && *number + 1 >= BLIND_LIMB_STARTS) {
                    break 'waves;
                }
                // With points it is the least noise that starts have to agree on, whoever is best by other measures.
                let least =
                    if points { noises.iter().copied().fold(f64::INFINITY, f64::min) } else { best.noise };
                let plausible = CERTAIN_NOISE < least && least < TANGLED;
                if !best.start.accepted && plausible && agreeing(&noises, least) >= HOPELESS_STARTS {
                    break 'waves;
                }
            }
        }
        let mut best = best.expect("at least one start is made");
        // Noise that no second start finds may be a wrong minimum as well.
        best.start.accepted &= is_certain(&noises, best.noise);
        (best, initial_guesses)
    }
}

/// How many starts left no more noise than one did, metres.
fn agreeing(noises: &[f64], least: f64) -> usize {
    noises.iter().filter(|&&noise| noise <= (1.0 + AGREEMENT) * least).count()
}

/// Whether no less noise than a start left was to be had: there is none, or a second start left as much.
fn is_certain(noises: &[f64], noise: f64) -> bool {
    noise <= CERTAIN_NOISE || agreeing(noises, noise) >= 2
}

pub(super) fn kept_back(touch: usize) -> bool {
    touch % KEPT_BACK == KEPT_BACK - 1
}
