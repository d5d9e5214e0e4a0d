//! How badly a start explains touches that it was not fitted to.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, Vector3};

use super::{FEW, MOST_NOISE, OPEN, SecondOrder};
use crate::learning::Input;
use crate::learning::annealing::{NARROWEST, gaps, quantile, shrinkage, sorted, typical_gap};
use crate::learning::growing::{Evidence, Start};
use crate::learning::noise::{Adjusted, Compared, Noise, gaps_of, information, likeness};
use crate::learning::observation::PointsMeet;
use crate::learning::open_gaps::{GapTally, MOST_FALSE, OpenGaps};
use crate::learning::prediction::{covariance, information_inverse};
use crate::learning::surface_gap::CERTAIN_NOISE;
use crate::learning::touch_set::{PairTouches, PreparedTouch, TouchSet};
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;
use crate::skin::Skin;

/// The share that noise may be of how far touches lie about their middle on the limbs: of more, a body whose limbs are all in
/// one place would explain them as well.
const MOST_OF_EXTENT: f64 = 0.5;
/// So many times as far apart as in their own postures are points that touched in others, and surfaces: of these right answers
/// leave five times as much where angles are read to 2 degrees, twelve times to one, and wrong ones four times at the most.
const POINTS_APART: f64 = 2.0;
const GAPS_APART: f64 = 4.5;
/// Limbs that meet within this in any posture are a point, metres.
const POINT: f64 = 1e-6;
/// Eight tenths of the gaps of touches not fitted to stay within this many of the deviations that the
/// schema predicts for them: 1.28 of a normal distribution, and a margin for few touches.
const FRESH_GAP: f64 = 1.9;
/// Share of open gaps that no joint exceeds on touches not fitted to: false touches, and chance in few.
const FRESH_OPEN: f64 = 0.3;
/// Likeness of gaps of neighbouring touches from which on it is the schema that is wrong: right ones leave less than 0.17,
/// wrong ones that look like noise more than 0.44.
const ALIKE: f64 = 0.3;
/// Touches of a limb from which on others of it are foretold.
const FORETOLD_BY: usize = 4;
/// Points are exact where this share of their touches misses by less than so many deviations.
const USUAL: f64 = 0.8;
const EXACTLY: f64 = 1e-4;
/// A touch tests a schema that predicts its gap to this, metres.
const TELLING: f64 = 0.01;
/// Width of a gap that nothing asks to predict better, metres.
const CLOSE_ENOUGH: f64 = 2e-5;

impl SecondOrder {
    /// How badly a start misses touches it was not fitted to, 1 is just acceptable; and the noise of the
    /// touches that it was fitted to, metres.
    pub(super) fn judge(
        &self,
        evidence: Evidence,
        fitted: &TouchSet,
        fresh: &TouchSet,
        start: &Start,
    ) -> (f64, f64) {
        let used = fresh.filter(|pair| start.covers(pair));
        if used.is_empty() {
            return (f64::INFINITY, f64::INFINITY);
        }
        let known = fitted.filter(|pair| start.covers(pair));
        let is_by_gaps = match evidence {
            Evidence::Surfaces(_) => true,
            // What few touches leave open is no noise.
            _ => evidence.may_be_noisy() && usual_misfit(&known, &start.schema) >= EXACTLY,
        };
        if is_by_gaps {
            return self.judge_gaps(&known, &used, start);
        }
        // Points without noise are their own proof. Touches of a limb that hardly any other tells of are not foretold.
        let of_limbs = fitted.count_of_limbs(self.agent.creature());
        let foretold = used.filter(|pair| pair.limbs.iter().all(|&limb| of_limbs[limb] >= FORETOLD_BY));
        if foretold.is_empty() {
            return (f64::INFINITY, f64::INFINITY);
        }
        let shrunk = self.shrunk(&foretold, &start.schema);
        let misfit = foretold.misfit(PointsMeet::Shaped, &start.schema);
        ((misfit / evidence.acceptance()).max(shrunk), 0.0)
    }

    /// How nearly touches would be explained in any postures as well, 1 is just too nearly: as by a body that is shrunk to the point
    /// where its limbs meet, or whose limbs spin about themselves. In the postures for comparison each joint is as in another touch
    /// of the same limbs, and there the median miss is to be several times as large, and as the least that counts, metres.
    fn shrunk(&self, touches: &TouchSet, schema: &BodySchema) -> f64 {
        let is_by_points = self.compared().1 == Compared::Points;
        let (times, least) = if is_by_points { (POINTS_APART, POINT) } else { (GAPS_APART, NARROWEST) };
        let miss = |touch: &PreparedTouch| match is_by_points {
            true => touch.miss(schema).norm(),
            false => touch.gap(self.agent.skin(), schema).distance.abs(),
        };
        let (mut honest, mut mixed) = (Vec::new(), Vec::new());
        for pair in touches.pairs.iter().filter(|pair| pair.touches.len() > 1) {
            let count = pair.touches.len();
            for (i, touch) in pair.touches.iter().enumerate() {
                let other = |side: usize, place: usize| {
                    &pair.touches[(i + 1 + (2 * place + side) % (count - 1)) % count].sides[side]
                };
                let sides = [0, 1].map(|side| touch.sides[side].mixed(|place| other(side, place)));
                honest.push(miss(touch));
                mixed.push(miss(&PreparedTouch { sides, ends: touch.ends }));
            }
        }
        if honest.is_empty() {
            return 0.0;
        }
        let [honest, mixed] = [honest, mixed].map(|misses| quantile(&sorted(misses), 0.5).max(least));
        times * honest / mixed
    }

    /// Compares the gaps of fresh touches with what the schema predicts of them. A schema that fits by
    /// chance predicts better than it does; one that few touches leave open predicts badly, and is right.
    fn judge_gaps(&self, fitted: &TouchSet, fresh: &TouchSet, start: &Start) -> (f64, f64) {
        let free = |joint: usize| start.known[joint] && !self.known.frozen[joint];
        let parameters = Parameters::new(self.agent.creature(), AxisModel::Unit, free);
        let schema = &start.schema;
        let (of, compared) = (self.compared(), self.compared().1);
        let is_by_points = compared == Compared::Points;
        let deviation = match is_by_points {
            true => f64::INFINITY,
            false => shown_deviation(self.agent.skin(), fitted, &parameters, schema),
        };
        let mut noise = Noise::of_gaps(deviation);
        let (mut alike, mut spread) = (0.0, deviation);
        let covariance = if deviation > CERTAIN_NOISE {
            let gaps = gaps_of(of, &Adjusted::none(fitted), &parameters, schema);
            let mut prior = DMatrix::zeros(parameters.len(), parameters.len());
            self.known.prior.add_information(&parameters, &mut prior);
            noise = Noise::estimate(&gaps, &parameters, &prior, None, false);
            alike = likeness(compared, fitted, &gaps, &noise);
            spread = noise.deviation(&gaps);
            information(&gaps, &parameters, &noise)
                .and_then(|information| information_inverse(information + prior, &parameters))
        } else {
            covariance(&self.agent, fitted, &parameters, &self.known.prior, schema, deviation)
        };
        let Some(covariance) = covariance else { return (f64::INFINITY, deviation) };
        let deviation = if deviation > CERTAIN_NOISE { spread } else { deviation };
        let mut found = GapTally::new(self.agent.creature().joints().len());
        let mut normalized = Vec::with_capacity(fresh.len());
        let mut tested = 0;
        let mut gaps = gaps_of(of, &Adjusted::none(fresh), &parameters, schema).into_iter();
        for pair in &fresh.pairs {
            for gap in gaps.by_ref().take(compared.gaps_a_touch() * pair.touches.len()) {
                let predicted = gap.predicted(&covariance);
                let variance = noise.variance(&gap) + predicted + CLOSE_ENOUGH * CLOSE_ENOUGH;
                let deviations = gap.gap.abs() / variance.sqrt();
                tested += usize::from(predicted < TELLING * TELLING);
                found.add(&pair.chain, deviations > OPEN);
                normalized.push(deviations);
            }
        }
        // Who predicts nothing is never wrong: that proves nothing.
        if tested < FEW || 2 * tested < normalized.len() {
            return (f64::INFINITY, deviation);
        }
        // One open touch may be false, whatever it is with; and so may as many as elsewhere.
        let chance = GapTally::of_chance(&self.agent, fitted);
        let told = found.beyond(&chance).filter(|[_, all]| *all >= FEW as f64);
        let worst = told.map(|[open, all]| (open - 1.0) / all / FRESH_OPEN).fold(0.0, f64::max);
        let [open, all] = found.all;
        let closed = 0.8 * (1.0 - open / all);
        let misfit = (quantile(&sorted(normalized), closed) / FRESH_GAP).max(worst);
        let most = (open - 1.0) / (MOST_FALSE * all);
        let (tolerable, vague) = match is_by_points {
            // Limbs that are all in one place explain points as well as noise does.
            true => (0.0, deviation / (MOST_OF_EXTENT * extent(fitted))),
            false => (OpenGaps::new(&self.agent, fitted, schema).worst, deviation / MOST_NOISE),
        };
        // The middle of a patch is no point of the limb, and off it by the same wherever it is touched.
        let alike = if is_by_points && self.input == Input::Receptor { 0.0 } else { alike };
        let shrunk = self.shrunk(fitted, schema);
        let refusals = [misfit, most, alike / ALIKE, tolerable, vague, shrunk];
        (refusals.into_iter().fold(0.0, f64::max), deviation)
    }
}

/// Standard deviation of the gaps of touches that parameters were fitted to, as they show it, metres.
pub(super) fn shown_deviation(
    skin: &Skin,
    touches: &TouchSet,
    parameters: &Parameters,
    schema: &BodySchema,
) -> f64 {
    let typical = typical_gap(&gaps(skin, touches, schema));
    (typical * shrinkage(touches.len(), parameters)).max(NARROWEST)
}

/// How far, per coordinate and as a root mean square, the places of touches lie about their middle on a limb: on that of the
/// two limbs of a touch on which they lie the farther, metres.
pub(super) fn extent(touches: &TouchSet) -> f64 {
    let mut places: BTreeMap<usize, Vec<Vector3<f64>>> = BTreeMap::new();
    for pair in &touches.pairs {
        for (limb, end) in pair.limbs.into_iter().zip([0, 1]) {
            places.entry(limb).or_default().extend(pair.touches.iter().map(|touch| touch.ends[end].position));
        }
    }
    let variance = |places: Vec<Vector3<f64>>| {
        let count = places.len() as f64;
        let middle = places.iter().sum::<Vector3<f64>>() / count;
        places.iter().map(|place| (place - middle).norm_squared()).sum::<f64>() / (3.0 * count)
    };
    let variances: BTreeMap<usize, f64> =
        places.into_iter().map(|(limb, places)| (limb, variance(places))).collect();
    let larger = |pair: &PairTouches| variances[&pair.limbs[0]].max(variances[&pair.limbs[1]]);
    let sum: f64 = touches.pairs.iter().map(|pair| pair.touches.len() as f64 * larger(pair)).sum();
    (sum / touches.len().max(1) as f64).sqrt()
}

/// The root mean square of its three whitened residuals that most touches stay below.
fn usual_misfit(touches: &TouchSet, schema: &BodySchema) -> f64 {
    let squares = touches.squared_misfits(PointsMeet::Shaped, schema);
    quantile(&sorted(squares.map(|squared| (squared / 3.0).sqrt())), USUAL)
}
