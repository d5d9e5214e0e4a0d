//! What touches determine at a schema, and how noisy they show themselves to be.

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use super::judging::shown_deviation;
use super::{CONTACT_DEVIATION, FEW, OPEN, SecondOrder, taken_deviation};
use crate::agent::Agent;
use crate::learning::annealing::{NARROWEST, gaps, typical_gap};
use crate::learning::curvature::distances_by_curvature;
use crate::learning::growing::Evidence;
use crate::learning::least_squares::LeastSquares;
use crate::learning::noise::{Adjusted, Compared, Noise, NoisyGap, gaps_of, information};
use crate::learning::observability::Observability;
use crate::learning::observation::PointsMeet;
use crate::learning::open_gaps::witnesses;
use crate::learning::prediction::{GapRow, covariance};
use crate::learning::surface_gap::{CERTAIN_NOISE, MEAN_WEIGHT, SHARPEST, SurfaceGap, TAIL, gap_scale};
use crate::learning::touch_set::{PairTouches, TouchProblem, TouchSet};
use crate::learning::{Account, Input, LengthUnit, LimbFrames, Parameters, Witnesses};
use crate::schema::{BodySchema, unfelt_shifts};
use crate::skin::Skin;

/// Leverage of a touch from which on no other one checks it, in noise.
const UNCHECKED: f64 = 0.98;
/// Wrong answers miss touches by this, metres. A fit to them leaves open what their leverage lacks to 1, which shows in touches that
/// are exact however little it is.
const MISS: f64 = 1e-3;
/// A bias of all gaps is taken up by parameters and leaves a fiftieth of itself; what exact gaps tell at second order is told
/// by no less than so many times what is left.
const TAKEN_UP: f64 = 1e3;
/// … and by no less than this, metres.
const SHARPLY: f64 = 1e-8;

/// What touches determine at a schema.
struct Seen {
    observability: Observability,
    witnesses: Witnesses,
    /// The touches that others check: what it all rests on.
    checked: TouchSet,
    /// The deviation of a touch that they show, metres.
    deviation: f64,
}

impl SecondOrder {
    /// What all touches so far determine at a schema, and the deviation of a touch that they show, metres.
    pub fn observe(&self, schema: &BodySchema) -> (Observability, f64) {
        let seen = self.observe_touches(&self.placed_touches(schema), schema);
        (seen.observability, seen.deviation)
    }

    /// The account of a schema by all touches so far, and the deviation of a touch that they show, metres.
    pub fn account(&self, schema: &BodySchema) -> (Account, f64) {
        self.account_of(&self.placed_touches(schema), schema)
    }

    /// The touches of limbs that a schema places.
    fn placed_touches(&self, schema: &BodySchema) -> TouchSet {
        let placed =
            |pair: &PairTouches| pair.limbs.iter().all(|&limb| schema.places(self.agent.creature(), limb));
        self.prepare(self.touches.iter()).filter(placed)
    }

    pub(super) fn account_of(&self, used: &TouchSet, schema: &BodySchema) -> (Account, f64) {
        let Seen { observability, witnesses, checked, deviation } = self.observe_touches(used, schema);
        let account = Account::new(&self.agent, schema, observability, witnesses);
        (self.with_curvature(account, &checked, schema), deviation)
    }

    /// An account with what exact touches of round limbs tell at second order, where limbs are open at first order.
    fn with_curvature(&self, account: Account, checked: &TouchSet, schema: &BodySchema) -> Account {
        let Evidence::Surfaces(skin) = self.evidence() else { return account };
        let all_placed = account.classes().len() <= 1;
        if all_placed || self.frames != LimbFrames::Joint {
            return account;
        }
        let deviation = SHARPLY.max(TAKEN_UP * typical_gap(&gaps(skin, checked, schema)));
        if deviation > SHARPEST {
            return account;
        }
        let distances = distances_by_curvature(&self.agent, schema, &account, checked, deviation);
        account.with_distances(self.agent.creature(), distances)
    }

    /// What touches determine at a schema.
    fn observe_touches(&self, used: &TouchSet, schema: &BodySchema) -> Seen {
        let Evidence::Surfaces(skin) = self.evidence() else { return self.observe_witnesses(used, schema) };
        let parameters = self.touched(used).0;
        let deviation = self.gap_deviation(skin, used, &parameters, schema);
        let used = if deviation > CERTAIN_NOISE {
            let (noise, _) = self.noise(used, &parameters, schema, None, true);
            let gaps = gaps_of(self.compared(), &Adjusted::none(used), &parameters, schema);
            witnesses(&self.agent, used, schema, |number| noise.variance(&gaps[number]).sqrt(), false)
        } else {
            witnesses(&self.agent, used, schema, |_| deviation, true)
        };
        self.observe_witnesses(&used, schema)
    }

    /// The noise of touches at a schema that was fitted to them, and the touches as they most likely were.
    /// `before` is a rough guess. Noise of `receptors` is told from that of single touches where it is asked for.
    pub(super) fn noise<'t>(
        &self,
        touches: &'t TouchSet,
        parameters: &Parameters,
        schema: &BodySchema,
        before: Option<Noise>,
        receptors: bool,
    ) -> (Noise, Adjusted<'t>) {
        let mut prior = DMatrix::zeros(parameters.len(), parameters.len());
        self.known.prior.add_information(parameters, &mut prior);
        let estimate = |adjusted: &Adjusted, before| {
            let gaps = gaps_of(self.compared(), adjusted, parameters, schema);
            // Points of contact are wherever they are, by no fault of a receptor.
            let receptors = receptors && self.compared().1 == Compared::Surfaces;
            Noise::estimate(&gaps, parameters, &prior, before, receptors)
        };
        let noise = before.unwrap_or_else(|| estimate(&Adjusted::none(touches), None));
        let adjusted = Adjusted::of(self.compared(), touches, schema, &noise);
        (estimate(&adjusted, Some(noise)), adjusted)
    }

    /// What of the joints and limbs of some touches may be fitted, and which limbs are placed at all.
    fn touched(&self, used: &TouchSet) -> (Parameters, Vec<bool>) {
        let mut touched = vec![false; self.agent.creature().joints().len()];
        used.pairs.iter().flat_map(|pair| pair.chain.joints()).for_each(|joint| touched[joint] = true);
        let mut placed = vec![self.frames == LimbFrames::Joint; self.agent.creature().limbs().len()];
        used.pairs.iter().flat_map(|pair| pair.limbs).for_each(|limb| placed[limb] = true);
        (self.parameters(&touched, &placed), placed)
    }

    fn observe_witnesses(&self, used: &TouchSet, schema: &BodySchema) -> Seen {
        let (parameters, placed) = self.touched(used);
        let mut spread = 0.0;
        let mut touches = used.clone();
        let sharp = match self.evidence() {
            Evidence::Surfaces(skin) => Some(self.gap_deviation(skin, used, &parameters, schema)),
            _ => None,
        };
        let sharp = sharp.filter(|deviation| *deviation <= CERTAIN_NOISE);
        let (found, deviation, at_floor) = match (self.evidence(), sharp) {
            (Evidence::Points | Evidence::Centres, _) if !self.shows_noise(used, &parameters, schema) => {
                let linearize = |touches: &TouchSet| {
                    TouchProblem::new(self.agent.creature(), touches, &parameters, PointsMeet::Shaped)
                        .linearize(schema)
                };
                let (found, misses) = loop {
                    let mut model = linearize(&touches);
                    let spare = (3 * touches.len()).saturating_sub(parameters.len()).max(1);
                    let misses = (2.0 * model.cost / spare as f64).sqrt();
                    if self.input == Input::Receptor {
                        model = linearize(&shared_by_receptors(&touches));
                    }
                    // Points that miss by more than they were taken to say that much less.
                    let least = misses.max(1.0).powi(2);
                    let found =
                        self.observability(&parameters, schema, model.hessian / least, 3 * touches.len());
                    match self.checked_points(&touches, schema, &found, least) {
                        Some(few) => touches = few,
                        None => break (found, misses),
                    }
                };
                spread = taken_deviation(used) * misses;
                (found, spread, misses <= 1.0)
            }
            (Evidence::Surfaces(skin), Some(deviation)) => {
                let noise = Noise::of_gaps(deviation.max(SHARPEST));
                let told = |touches: &TouchSet, _: &[NoisyGap]| {
                    let model = SurfaceGap::new(skin, noise.contact).without_places();
                    let mut problem = TouchProblem::new(self.agent.creature(), touches, &parameters, model);
                    problem.linearize(schema).hessian / MEAN_WEIGHT
                };
                let found = self.observed_in((&noise, deviation), &mut touches, &parameters, schema, told);
                (found, deviation, deviation <= NARROWEST)
            }
            _ => {
                let mut noise = self.noise(used, &parameters, schema, None, true).0;
                spread =
                    noise.deviation(&gaps_of(self.compared(), &Adjusted::none(used), &parameters, schema));
                noise.contact = noise.contact.max(SHARPEST);
                let told = |_: &TouchSet, gaps: &[NoisyGap]| {
                    information(gaps, &parameters, &noise)
                        .unwrap_or_else(|| DMatrix::zeros(parameters.len(), parameters.len()))
                };
                let found = self.observed_in((&noise, spread), &mut touches, &parameters, schema, told);
                (found, spread, false)
            }
        };
        let witnesses = Witnesses {
            of_limbs: used.count_of_limbs(self.agent.creature()),
            made_of_limbs: used.count_of_limbs(self.agent.creature()),
            point_deviation: spread,
            at_floor,
        };
        Seen { observability: found.with_placed(placed), witnesses, checked: touches, deviation }
    }

    /// What touches determine in some noise, by the information that they and their gaps hold; `touches` are left that others
    /// check.
    fn observed_in(
        &self,
        (noise, deviation): (&Noise, f64),
        touches: &mut TouchSet,
        parameters: &Parameters,
        schema: &BodySchema,
        told: impl Fn(&TouchSet, &[NoisyGap]) -> DMatrix<f64>,
    ) -> Observability {
        loop {
            let gaps = {
                let adjusted = Adjusted::of(self.compared(), touches, schema, noise);
                gaps_of(self.compared(), &adjusted, parameters, schema)
            };
            let found = self.observability(parameters, schema, told(touches, &gaps), 5 * touches.len());
            // Without some of the touches others may be the only ones that are left.
            match checked(touches, &gaps, &found, noise, deviation) {
                Some(few) => *touches = few,
                None => return found,
            }
        }
    }

    /// What is compared of touches.
    pub(super) fn compared(&self) -> (&Agent, Compared) {
        let compared = match self.evidence() {
            Evidence::Surfaces(_) => Compared::Surfaces,
            _ => Compared::Points,
        };
        (&self.agent, compared)
    }

    /// The same as [`checked`] of points, of which each gives three equations: those are left whose every equation others
    /// check. One false touch places a limb that has no other one, and no residual shows it. `found` is what they determine
    /// with a variance so many times (`share`) that of the points.
    fn checked_points(
        &self,
        touches: &TouchSet,
        schema: &BodySchema,
        found: &Observability,
        share: f64,
    ) -> Option<TouchSet> {
        let mut few = touches.clone();
        // Many touches of one pair of limbs check one another.
        for pair in few.pairs.iter_mut().filter(|pair| pair.touches.len() < FEW) {
            let (limbs, chain) = (pair.limbs, pair.chain.clone());
            pair.touches.retain(|touch| {
                let alone = PairTouches { limbs, chain: chain.clone(), touches: vec![touch.clone()] };
                let alone = TouchSet { pairs: vec![alone] };
                let mut problem =
                    TouchProblem::new(self.agent.creature(), &alone, &found.parameters, PointsMeet::Shaped);
                let information = problem.linearize(schema).hessian / share;
                found.greatest_leverage(&information) < UNCHECKED
            });
        }
        few.pairs.retain(|pair| !pair.touches.is_empty());
        (few.len() < touches.len()).then_some(few)
    }

    /// What information (lower triangle) of so many residuals determines, with what was known in advance.
    fn observability(
        &self,
        parameters: &Parameters,
        schema: &BodySchema,
        mut hessian: DMatrix<f64>,
        rows: usize,
    ) -> Observability {
        self.known.given.add_information(parameters, &mut hessian);
        self.fix_choices(parameters, schema, &mut hessian);
        Observability::new(
            self.agent.creature(),
            parameters.clone(),
            &self.known.frozen,
            hessian,
            rows,
            LengthUnit::METRE,
        )
    }

    /// Adds to normal equations (lower triangle) that limbs' origins do not shift where their joints cannot feel
    /// it, for that is gauge freedom: see [`BodySchema::settle_positions`].
    fn fix_choices(&self, parameters: &Parameters, schema: &BodySchema, hessian: &mut DMatrix<f64>) {
        for (joint, offset) in self.agent.creature().joints().iter().zip(&parameters.limb_origins) {
            if let Some(offset) = *offset {
                let mut block = hessian.fixed_view_mut::<3, 3>(offset, offset);
                block +=
                    unfelt_shifts(self.agent.creature(), joint, &schema.axes) * CONTACT_DEVIATION.powi(-2);
            }
        }
    }

    /// Standard deviation of the gaps at a fitted schema, metres.
    pub(super) fn gap_deviation(
        &self,
        skin: &Skin,
        touches: &TouchSet,
        parameters: &Parameters,
        schema: &BodySchema,
    ) -> f64 {
        let start = shown_deviation(skin, touches, parameters, schema);
        let found = covariance(&self.agent, touches, parameters, &self.known.prior, schema, start);
        let Some(covariance) = found else { return start };
        let mut row = GapRow::default();
        let rows = touches.touches().map(|touch| {
            row.set(skin, parameters, schema, touch);
            (row.gap, MEAN_WEIGHT * row.variance(&covariance) / start.powi(2))
        });
        gap_scale(&rows.collect::<Vec<_>>(), start).max(NARROWEST)
    }
}

/// Touches of which all that have a receptor in common say as much as one: where the limb is under the middle of a patch is the
/// same error in each, which no number of them averages out.
fn shared_by_receptors(touches: &TouchSet) -> TouchSet {
    let mut counts: BTreeMap<usize, f64> = BTreeMap::new();
    let receptors = touches.touches().flat_map(|touch| touch.ends.each_ref().map(|end| end.receptor));
    receptors.for_each(|receptor| *counts.entry(receptor).or_default() += 1.0);
    let mut shared = touches.clone();
    for touch in shared.pairs.iter_mut().flat_map(|pair| &mut pair.touches) {
        touch.ends.iter_mut().for_each(|end| end.covariance *= counts[&end.receptor]);
    }
    shared
}

/// The touches that are closed and that others check; none where that are all.
///
/// A touch whose leverage is nearly 1 closes its gap whatever the truth is: the fit has a parameter for it alone.
/// What rests on such touches is not known, however small it leaves the gaps (Baarda's reliability, "A Testing
/// Procedure for Use in Geodetic Networks", 1968). `found` is what they determine in some noise; `gaps` are theirs, of a
/// `deviation`, metres.
fn checked(
    touches: &TouchSet,
    gaps: &[NoisyGap],
    found: &Observability,
    noise: &Noise,
    deviation: f64,
) -> Option<TouchSet> {
    let shown = (1.0 - deviation / MISS).max(UNCHECKED);
    let mut gaps = gaps.chunks((gaps.len() / touches.len().max(1)).max(1));
    let mut few = touches.clone();
    for pair in &mut few.pairs {
        pair.touches.retain(|_| {
            gaps.next().expect("every touch has its gaps").iter().all(|gap| {
                let variance = noise.variance(gap);
                let weight = 1.0 / (1.0 + gap.gap * gap.gap / (TAIL * TAIL * variance));
                // The weights that the information was divided by are 1 for a gap that is closed.
                let leverage = weight * gap.predicted(&found.covariance) / (MEAN_WEIGHT * variance);
                // A gap that is open speaks against the schema, and for nothing.
                leverage < shown && gap.gap * gap.gap <= OPEN * OPEN * variance
            })
        });
    }
    few.pairs.retain(|pair| !pair.touches.is_empty());
    (few.len() < touches.len()).then_some(few)
}
