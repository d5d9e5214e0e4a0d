//! How much noise of each kind there is, and what touches determine in it.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn, Matrix3, Vector3};

use super::gap::{Compared, NoisyGap};
use crate::learning::Parameters;
use crate::learning::annealing::{NARROWEST, NORMAL_MEDIAN, quantile};
use crate::learning::prediction::{add_row, doubt_axes, invert, row_variance};
use crate::learning::touch_set::TouchSet;

/// Rounds of who is honest, what the touches say and how much noise there is, one after the other.
const ROUNDS: usize = 12;
/// Steps to the deviations of one round.
const STEPS: usize = 100;
/// Relative change of the deviations that is none.
const SETTLED: f64 = 1e-2;
/// Standard deviations of chance beyond which gaps that share a receptor are alike: independent noise is left as it is
/// in 49 of 50 cases.
const CHANCE: f64 = 2.0;

/// The least radius of a limb's surface, metres: that of a finger.
const BENT: f64 = 0.01;
/// How near the places of two touches on both limbs are whose gaps are alike if the schema is wrong, metres: hardly any
/// limb is thinner.
const NEAR: f64 = 0.08;

/// How much noise there is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of any gap, `σ₀`, metres.
    pub contact: f64,
    /// Standard deviation of a joint's angle as it is read, `σ_q`, radians.
    pub joint: f64,
    /// Standard deviation, per coordinate, of where the skin under a receptor is, `σ_r`, metres.
    pub receptor: f64,
    /// Share of touches that are false, `ε`.
    pub false_share: f64,
}

impl Noise {
    /// Noise of gaps alone.
    pub fn of_gaps(deviation: f64) -> Noise {
        Noise { contact: deviation, joint: 0.0, receptor: 0.0, false_share: 0.0 }
    }

    /// The variance that is a gap's own, `σ₀² + σ_q² |∂g/∂q|²` and what it was told to have, m², by `|∂g/∂q|²` and that.
    fn own_variance(&self, slope: f64, told: f64) -> f64 {
        self.contact.powi(2) + self.joint.powi(2) * slope + self.bend() + told
    }

    /// The variance that shifts of skin along itself add, m²: to second order they move a surface of the radius `R` by
    /// `d²/R`, which is no linear function of the shifts.
    fn bend(&self) -> f64 {
        (self.receptor.powi(2) / BENT).powi(2)
    }

    /// The variance of an honest gap, m².
    pub fn variance(&self, gap: &NoisyGap) -> f64 {
        self.variance_by(gap.slope, gap.told)
    }

    /// The same by `|∂g/∂q|²` and what it was told to have, m² a square radian and m².
    pub(super) fn variance_by(&self, slope: f64, told: f64) -> f64 {
        self.own_variance(slope, told) + 2.0 * self.receptor.powi(2)
    }

    /// The probability that a touch is an inlier whose gap misses what is expected by so much, with such a variance, where a false one
    /// may be so wide (metres, m², metres).
    pub fn inlier_probability(&self, width: f64, miss: f64, variance: f64) -> f64 {
        let normal = (-0.5 * miss * miss / variance).exp() / (std::f64::consts::TAU * variance).sqrt();
        let (honest, other) = ((1.0 - self.false_share) * normal, self.false_share / width);
        if honest + other > 0.0 { honest / (honest + other) } else { 0.0 }
    }

    /// The noise of touches at a schema that was fitted to them by `parameters`, beside the information of a `prior`.
    /// `before` is a rough guess. Where `receptors` are not asked for, what they do counts as noise of single touches: that is
    /// enough to judge by, and many times faster.
    pub fn estimate(
        gaps: &[NoisyGap],
        parameters: &Parameters,
        prior: &DMatrix<f64>,
        before: Option<Noise>,
        receptors: bool,
    ) -> Noise {
        let mut sizes: Vec<f64> = gaps.iter().map(|gap| gap.gap.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let spare = (gaps.len() as f64 - 0.7 * parameters.len() as f64).max(1.0);
        let typical =
            (NORMAL_MEDIAN * quantile(&sizes, 0.5) * (gaps.len() as f64 / spare).sqrt()).max(NARROWEST);
        let slope = gaps.iter().map(|gap| gap.slope).sum::<f64>() / gaps.len().max(1) as f64;
        let mut noise = Noise {
            contact: typical * 0.5f64.sqrt(),
            joint: typical * (0.5 / slope.max(f64::MIN_POSITIVE)).sqrt(),
            receptor: 0.0,
            // Before anything is known of them.
            false_share: 0.1,
        };
        let mut asked = !receptors;
        if let Some(before) = before {
            asked |= before.receptor > 0.0;
            noise = before;
        }
        let mut shift = None;
        for _ in 0..ROUNDS {
            let system = MixedSystem::new(&noise, gaps, prior, shift.as_ref());
            let Some(solved) = system.solve(gaps, parameters, true) else { return noise };
            let next = noise.stepped(gaps, &system, &solved);
            let change = |a: f64, b: f64| (a - b).abs() > SETTLED * a.max(b);
            let moved = change(noise.variance_of_mean(gaps), next.variance_of_mean(gaps))
                || change(noise.receptor, next.receptor);
            noise = next;
            shift = Some(solved.residuals.clone());
            if !moved {
                if asked {
                    break;
                }
                asked = true;
                let alike = system.alike(gaps, &solved);
                if alike <= 0.0 {
                    break;
                }
                // Half of it each.
                let variance = 0.5 * noise.variance_of_mean(gaps);
                let halved = 0.5f64.sqrt();
                noise.receptor = (0.5 * variance).sqrt();
                noise.contact *= halved;
                noise.joint *= halved;
            }
        }
        noise
    }

    /// The mean variance of gaps, m².
    fn variance_of_mean(&self, gaps: &[NoisyGap]) -> f64 {
        gaps.iter().map(|gap| self.variance(gap)).sum::<f64>() / gaps.len().max(1) as f64
    }

    /// Standard deviation of a middling gap, metres.
    pub fn deviation(&self, gaps: &[NoisyGap]) -> f64 {
        self.variance_of_mean(gaps).sqrt()
    }

    /// The noise after one round.
    fn stepped(&self, gaps: &[NoisyGap], system: &MixedSystem, solved: &MixedSolution) -> Noise {
        let mut next = *self;
        let honest: f64 = system.honest.iter().sum();
        let count = gaps.len() as f64;
        // With one touch more of either kind: none of many seen does not say that there are none.
        next.false_share = (count - honest + 1.0) / (count + 2.0);
        // What the fit takes up of each gap is fixed for the round.
        let rows: Vec<[f64; 4]> =
            (gaps.iter().zip(&system.honest).zip(&solved.residuals).zip(&solved.leverages))
                .map(|(((gap, honest), residual), leverage)| {
                    [gap.slope, gap.told, honest * residual * residual, honest * (1.0 - leverage).max(1e-9)]
                })
                .collect();
        for _ in 0..STEPS {
            let mut sums = [[0.0; 2]; 2];
            for [slope, told, square, left] in &rows {
                let variance = next.own_variance(*slope, *told);
                let (up, down) = (square / (variance * variance), left / variance);
                sums[0][0] += up;
                sums[0][1] += down;
                sums[1][0] += slope * up;
                sums[1][1] += slope * down;
            }
            // The fourth root for deviations is the square root for variances, which never overshoots.
            let factor = |[up, down]: [f64; 2]| if down > 0.0 { (up / down).sqrt().sqrt() } else { 1.0 };
            let (contact, joint) = (factor(sums[0]), factor(sums[1]));
            next.contact = (next.contact * contact).max(NARROWEST);
            next.joint *= joint;
            if (contact - 1.0).abs() + (joint - 1.0).abs() < 1e-4 {
                break;
            }
        }
        if self.receptor > 0.0 {
            next.receptor = (solved.shift_squares / solved.shift_freedom.max(1e-9)).sqrt();
        }
        next
    }
}

/// The normal equations of the shifts of the skin under receptors, three coordinates each, and of the parameters after them.
pub(super) struct MixedSystem {
    /// Per gap, the probability that it is honest.
    honest: Vec<f64>,
    /// … and over its own variance, 1/m².
    pub weights: Vec<f64>,
    /// Per receptor, the place of its shift.
    places: Vec<Option<usize>>,
    pub shifts: usize,
    pub receptor: f64,
    information: DMatrix<f64>,
    gradient: DVector<f64>,
}

/// The normal equations of the parameters with the shifts eliminated.
pub(super) struct Eliminated {
    pub information: DMatrix<f64>,
    pub gradient: DVector<f64>,
    /// Of the shifts' information; none where there are no shifts.
    pub factor: Option<Cholesky<f64, Dyn>>,
}

/// What they come to.
pub(super) struct MixedSolution {
    pub residuals: Vec<f64>,
    leverages: Vec<f64>,
    shift_squares: f64,
    shift_freedom: f64,
}

impl MixedSystem {
    /// With `residuals` of the gaps as far as these are known, the gaps themselves where they are not.
    pub fn new(
        noise: &Noise,
        gaps: &[NoisyGap],
        prior: &DMatrix<f64>,
        residuals: Option<&Vec<f64>>,
    ) -> MixedSystem {
        let honest: Vec<f64> = gaps
            .iter()
            .enumerate()
            .map(|(number, gap)| {
                let (miss, variance) = match residuals {
                    Some(residuals) => (residuals[number], noise.own_variance(gap.slope, gap.told)),
                    None => (gap.gap, noise.variance(gap)),
                };
                noise.inlier_probability(gap.width, miss, variance)
            })
            .collect();
        let weights: Vec<f64> = gaps
            .iter()
            .zip(&honest)
            .map(|(gap, honest)| honest / noise.own_variance(gap.slope, gap.told))
            .collect();
        let mut places = Vec::new();
        let mut shifts = 0;
        if noise.receptor > 0.0 {
            for receptor in gaps.iter().flat_map(|gap| gap.receptors) {
                if places.len() <= receptor {
                    places.resize(receptor + 1, None);
                }
                if places[receptor].is_none() {
                    places[receptor] = Some(shifts);
                    shifts += 3;
                }
            }
        }
        let parameters = prior.nrows();
        let mut information = DMatrix::zeros(shifts + parameters, shifts + parameters);
        let of_shift = noise.receptor.powi(2).max(f64::MIN_POSITIVE).recip();
        information.view_mut((0, 0), (shifts, shifts)).fill_diagonal(of_shift);
        information.view_mut((shifts, shifts), (parameters, parameters)).copy_from(prior);
        let gradient = DVector::zeros(shifts + parameters);
        let receptor = noise.receptor;
        let mut system = MixedSystem { honest, weights, places, shifts, receptor, information, gradient };
        for (gap, weight) in gaps.iter().zip(&system.weights) {
            let row = system.row(gap);
            row.iter().for_each(|&(place, slope)| system.gradient[place] += weight * slope * gap.gap);
            add_row(&mut system.information, &row, *weight);
        }
        system
    }

    /// The derivative of a gap by the shifts of its receptors' skin.
    pub fn shifts_of(&self, gap: &NoisyGap) -> impl Iterator<Item = (usize, f64)> {
        let placed = |(receptor, normal)| Some((self.places.get(receptor).copied().flatten()?, normal));
        let shifts = gap.shifts().filter_map(placed);
        shifts.flat_map(|(place, normal)| [0, 1, 2].map(|i| (place + i, normal[i])))
    }

    /// The derivative of a gap by all of them.
    fn row(&self, gap: &NoisyGap) -> Vec<(usize, f64)> {
        let of_parameters = gap.entries.iter().map(|&(place, slope)| (self.shifts + place, slope));
        self.shifts_of(gap).chain(of_parameters).collect()
    }

    /// Schur's complement; none where rounding forbids.
    pub fn eliminated(&self) -> Option<Eliminated> {
        let (shifts, parameters) = (self.shifts, self.gradient.len() - self.shifts);
        let mut information = self.information.view((shifts, shifts), (parameters, parameters)).clone_owned();
        let mut gradient = self.gradient.rows(shifts, parameters).clone_owned();
        if shifts == 0 {
            return Some(Eliminated { information, gradient, factor: None });
        }
        let factor = self.information.view((0, 0), (shifts, shifts)).clone_owned().cholesky()?;
        let lower = factor.l_dirty();
        let across = self.information.view((0, shifts), (shifts, parameters));
        let across = lower.solve_lower_triangular(&across)?;
        let pull = lower.solve_lower_triangular(&self.gradient.rows(0, shifts))?;
        information -= across.tr_mul(&across);
        gradient -= across.tr_mul(&pull);
        Some(Eliminated { information, gradient, factor: Some(factor) })
    }

    /// The residuals after a step to the least cost, and how much of each gap it takes up.
    pub fn solve(&self, gaps: &[NoisyGap], parameters: &Parameters, leverage: bool) -> Option<MixedSolution> {
        let mut information = self.information.clone();
        doubt_axes(&mut information, parameters, self.shifts);
        let (step, covariance) = if leverage {
            let covariance = invert(information)?;
            (-&covariance * &self.gradient, covariance)
        } else {
            (-information.cholesky()?.solve(&self.gradient), DMatrix::zeros(0, 0))
        };
        let mut residuals = Vec::with_capacity(gaps.len());
        let mut leverages = Vec::with_capacity(gaps.len());
        for (gap, weight) in gaps.iter().zip(&self.weights) {
            let row = self.row(gap);
            residuals.push(gap.gap + row.iter().map(|&(place, slope)| slope * step[place]).sum::<f64>());
            if leverage {
                leverages.push((weight * row_variance(&row, &covariance)).clamp(0.0, 1.0));
            }
        }
        let shift_covariance: f64 = covariance.diagonal().iter().take(self.shifts).sum();
        let shift_freedom =
            self.shifts as f64 - shift_covariance / self.receptor.powi(2).max(f64::MIN_POSITIVE);
        let shift_squares = step.rows(0, self.shifts).norm_squared();
        Some(MixedSolution { residuals, leverages, shift_squares, shift_freedom })
    }

    /// The likeliest shift of the skin under each receptor by some gaps, in its limb's frame, metres; `factor` is that of the
    /// shifts' information.
    pub fn likeliest_shifts(&self, gaps: &[NoisyGap], factor: &Cholesky<f64, Dyn>) -> Vec<Vector3<f64>> {
        let mut pull = DVector::zeros(self.shifts);
        for (gap, weight) in gaps.iter().zip(&self.weights) {
            self.shifts_of(gap).for_each(|(place, slope)| pull[place] -= weight * slope * gap.gap);
        }
        factor.solve_mut(&mut pull);
        let shift = |place: &Option<usize>| place.map(|place| pull.fixed_rows::<3>(place).into_owned());
        self.places.iter().map(|place| shift(place).unwrap_or_default()).collect()
    }

    /// How much more alike gaps are that share a receptor than chance makes them: the derivative of the likelihood by
    /// the receptors' variance at zero, over its deviation, less [`CHANCE`].
    fn alike(&self, gaps: &[NoisyGap], solved: &MixedSolution) -> f64 {
        let receptors = gaps.iter().flat_map(|gap| gap.receptors).max().map_or(0, |last| last + 1);
        let mut sums = vec![Vector3::zeros(); receptors];
        let mut squares = vec![Matrix3::zeros(); receptors];
        let mut expected = 0.0;
        let mut own = 0.0;
        for (k, gap) in gaps.iter().enumerate() {
            let (weight, left) = (self.weights[k], 1.0 - solved.leverages[k]);
            let pull = weight * solved.residuals[k];
            for (receptor, normal) in gap.shifts() {
                sums[receptor] += normal * pull;
                squares[receptor] += normal * normal.transpose() * weight;
                expected += pull * pull;
                own += (weight * left).powi(2);
            }
        }
        let found: f64 = sums.iter().map(|sum| sum.norm_squared()).sum::<f64>() - expected;
        let variance = 2.0 * (squares.iter().map(|square| square.norm_squared()).sum::<f64>() - own).max(0.0);
        found - CHANCE * variance.sqrt()
    }
}

/// What gaps determine in some noise, shifts of the skin under receptors eliminated: the information about
/// `parameters`, symmetric; none where rounding forbids. A gap whose touch is false tells nothing.
pub fn information(gaps: &[NoisyGap], parameters: &Parameters, noise: &Noise) -> Option<DMatrix<f64>> {
    let nothing = DMatrix::zeros(parameters.len(), parameters.len());
    let system = MixedSystem::new(noise, gaps, &nothing, None);
    Some(system.eliminated()?.information)
}

/// How alike the gaps of touches are that happened nearly in the same places, in units of their variances: 0 of noise,
/// up to 1 where gaps are a function of where limbs touch, as those of a wrong schema are. How likely the gaps are
/// does not tell that.
///
/// The mean product of each touch and its nearest neighbour of the same limb pair that shares no receptor with it, for
/// gaps that share a receptor may be alike in truth (Moran's I with one neighbour each, "Notes on Continuous Stochastic
/// Phenomena", 1950). `gaps` are those of `touches`; of the open ones, which are false, nothing is asked.
pub fn likeness(compared: Compared, touches: &TouchSet, gaps: &[NoisyGap], noise: &Noise) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0f64);
    let mut rest = gaps;
    for pair in &touches.pairs {
        let (own, others) = rest.split_at(compared.gaps_a_touch() * pair.touches.len());
        rest = others;
        let deviations = |gap: &NoisyGap| gap.gap / noise.variance(gap).sqrt();
        // Points are apart by a vector of the first limb, of which no axis is another touch's.
        let size = |of_touch: &[NoisyGap]| match of_touch {
            [gap] => Vector3::new(deviations(gap), 0.0, 0.0),
            gaps => {
                gaps.iter().map(|gap| gap.normals[0] * deviations(gap)).sum::<Vector3<f64>>() / 3f64.sqrt()
            }
        };
        let is_honest =
            |gap: &NoisyGap| noise.inlier_probability(gap.width, gap.gap, noise.variance(gap)) > 0.5;
        let closed: Vec<(&NoisyGap, Vector3<f64>)> = own
            .chunks(compared.gaps_a_touch())
            .filter(|of_touch| of_touch.iter().all(is_honest))
            .map(|of_touch| (&of_touch[0], size(of_touch)))
            .collect();
        for (gap, size) in &closed {
            let apart = |other: &NoisyGap| -> f64 {
                (0..2).map(|k| (gap.places[k] - other.places[k]).norm_squared()).sum()
            };
            let strangers =
                closed.iter().filter(|(other, _)| (0..2).all(|k| gap.receptors[k] != other.receptors[k]));
            let nearest =
                strangers.map(|(other, size)| (apart(other), size)).min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, other)) = nearest.filter(|(apart, _)| *apart < NEAR * NEAR) {
                sum += size.dot(other);
                count += 1.0;
            }
        }
    }
    sum / count.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Gaps between random receptors of 40 in some noise, and nothing fitted to them.
    fn gaps(noise: &Noise, count: usize, seed: u64) -> Vec<NoisyGap> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = |deviation: f64| -> f64 {
            let standard: f64 = StandardNormal.sample(&mut rng);
            deviation * standard
        };
        let shifts: Vec<Vector3<f64>> =
            (0..40).map(|_| Vector3::from_fn(|_, _| normal(noise.receptor))).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(seed + 1);
        let gap = |_| {
            let receptors = [rng.random_range(0..20), rng.random_range(20..40)];
            let normals = [Vector3::z(), -Vector3::z()]
                .map(|normal| (normal + Vector3::from_fn(|_, _| rng.random_range(-0.5..0.5))).normalize());
            let slope: f64 = rng.random_range(0.01..1.0);
            let standard: f64 = StandardNormal.sample(&mut rng);
            let own = standard * (noise.contact.powi(2) + noise.joint.powi(2) * slope).sqrt();
            let shifted: f64 = (0..2).map(|k| normals[k].dot(&shifts[receptors[k]])).sum();
            let honest = rng.random::<f64>() >= noise.false_share;
            let gap = if honest { own + shifted } else { rng.random_range(0.0..0.4) };
            NoisyGap {
                gap,
                told: 0.0,
                entries: Vec::new(),
                slope,
                receptors,
                places: [Vector3::zeros(); 2],
                normals,
                width: 0.4,
            }
        };
        (0..count).map(gap).collect()
    }

    fn estimated(noise: Noise, seed: u64) -> Noise {
        let nothing = Parameters::none();
        Noise::estimate(&gaps(&noise, 2000, seed), &nothing, &DMatrix::zeros(0, 0), None, true)
    }

    #[test]
    fn each_kind_of_noise_is_estimated_and_told_from_the_others() {
        let near = |a: f64, b: f64, share: f64| (a / b - 1.0).abs() < share;
        for seed in 0..3 {
            let joints = Noise { contact: 1e-4, joint: 2e-3, receptor: 0.0, false_share: 0.2 };
            let found = estimated(joints, seed);
            assert!(near(found.joint, 2e-3, 0.1) && found.receptor < 3e-4, "{found:?}");
            assert!((found.false_share - 0.2).abs() < 0.03, "{found:?}");

            let receptors = Noise { contact: 3e-4, joint: 0.0, receptor: 1e-3, false_share: 0.0 };
            let found = estimated(receptors, seed);
            assert!(near(found.receptor, 1e-3, 0.25), "{found:?}");
            assert!(found.false_share < 0.01, "{found:?}");
        }
    }

    #[test]
    fn honest_touches_are_told_from_false_ones() {
        let noise = Noise { contact: 1e-3, joint: 0.0, receptor: 0.0, false_share: 0.2 };
        let gap = &gaps(&noise, 1, 1)[0];
        assert!(noise.inlier_probability(gap.width, 1e-3, 1e-6) > 0.99);
        assert!(noise.inlier_probability(gap.width, 1e-1, 1e-6) < 1e-6);
    }
}
