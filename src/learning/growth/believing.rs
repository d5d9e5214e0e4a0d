//! What is believed of all that is known: information that touches add to, and fits of all of them now and then.

use nalgebra::{DMatrix, DVector};

use super::evidence::Equation;
use super::part::Member;
use super::{CLOSED, GrownTouch, Growth};
use crate::creature::DofKind;
use crate::learning::annealing::{NARROWEST, quantile};
use crate::learning::online::Belief;
use crate::learning::open_gaps::{EXACTLY_OPEN, FELT};
use crate::learning::prediction::{GapRow, add_row};
use crate::learning::surface_gap::SHARPEST;
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// Of so many touches one that was closed may open.
const FEW_OPEN: usize = 50;
/// So many touches against a joint or a limb, and this share of all that tell of it, take it back.
const CONTRADICTIONS: f64 = 3.0;
const CONTRADICTED: f64 = 0.08;
/// After a fit a gap is open that is wider than [`EXACTLY_OPEN`] and than so many standard deviations.
const DEVIATIONS: f64 = 5.0;
/// A joint or a limb is wrong that leaves this share of its touches open, …
const OPEN_SHARE: f64 = 0.05;
/// A gap that is open among touches without noise: wider than this, metres, and so many times as wide as half of all. Of
/// right answers 95 in 100 gaps are narrower than three nanometres, but for edges; …
pub(super) const SHARPLY_OPEN: f64 = 2e-8;
const MANY_TIMES: f64 = 10.0;
/// … and by so much more than among all others is the share of those that are open of a wrong answer.
const SHARPLY_OPEN_SHARE: f64 = 0.25;
/// … beyond so many times the share of all others.
const MORE_OPEN: f64 = 2.0;
/// So many touches at the least are to feel a joint.
pub(super) const FEWEST_FELT: usize = 8;
/// Touches are taken in when so many times as many are believed, or fewer.
const TOO_FEW: usize = 50;
/// All is fitted again where there are so many times more touches than at the last time.
const MORE_TO_FIT: f64 = 1.5;

/// All that an answer may change.
pub(super) struct BeforeAnswer {
    belief: Option<Belief>,
    information: DMatrix<f64>,
    base: usize,
    fitted: usize,
}

impl Growth {
    pub(super) fn clone_belief(&self) -> BeforeAnswer {
        BeforeAnswer {
            belief: self.belief.clone(),
            information: self.information.clone(),
            base: self.base,
            fitted: self.fitted,
        }
    }

    pub(super) fn restore_belief(&mut self, before: BeforeAnswer, new: &[usize]) {
        new.iter().for_each(|&number| self.touches[number].used = false);
        (self.belief, self.information) = (before.belief, before.information);
        (self.base, self.fitted) = (before.base, before.fitted);
    }

    /// What a touch weighs: the inverse of its gap's variance, 1/m².
    pub(super) fn weight(&self) -> f64 {
        self.deviation().powi(-2)
    }

    /// Standard deviation of a touch's gap, metres.
    fn deviation(&self) -> f64 {
        self.belief.as_ref().map_or(SHARPEST, |belief| belief.deviation)
    }

    /// How much is known.
    pub(super) fn known(&self) -> usize {
        self.resolved.iter().filter(|&&resolved| resolved).count() + self.placed_limbs()
    }

    /// The touches that belief rests on.
    fn used(&self) -> impl Iterator<Item = &GrownTouch> {
        self.touches.iter().filter(|touch| touch.used)
    }

    /// Believes a schema with what some touches more tell of it; false where rounding forbids. What is open then is not in
    /// use any more, or is no more than [`Growth::still_closed`] allows.
    pub(super) fn believe(&mut self, schema: BodySchema, new: &[usize]) -> bool {
        new.iter().for_each(|&number| self.touches[number].used = true);
        let parameters = self.parameters();
        let (deviation, weight) = (self.deviation(), self.weight());
        let same = self.belief.as_ref().is_some_and(|belief| belief.parameters.len() == parameters.len());
        let mut gradient = DVector::zeros(parameters.len());
        let told = new.iter().map(|&number| &self.touches[number]);
        let rows: Vec<Equation> =
            told.flat_map(|touch| self.equations(touch, &parameters, &schema)).collect();
        let mut information = self.information_over(&parameters);
        for row in &rows {
            row.entries.iter().for_each(|&(place, slope)| gradient[place] += weight * slope * row.gap);
            add_row(&mut information, &row.entries, weight);
        }
        let before = self.belief.take();
        let belief = match before.clone().filter(|_| same) {
            Some(mut belief) => {
                rows.iter().for_each(|row| belief.tell(&row.entries));
                belief.schema = schema;
                Some(belief)
            }
            None => {
                let mut all = information.clone();
                self.prior.add_information(&parameters, &mut all);
                Belief::new(schema, parameters, all, deviation)
            }
        };
        let Some(mut belief) = belief else { return false };
        // What is left of the gaps is taken up as all touches so far allow.
        let step = -(&belief.covariance * gradient);
        belief.schema = belief.parameters.step(&belief.schema, &step);
        let jumped = before.as_ref().is_some_and(|before| before.jumps(&belief.schema));
        if before.is_none() {
            let mut of_limb = vec![0; self.placement.len()];
            self.used().for_each(|touch| touch.limbs.iter().for_each(|&limb| of_limb[limb] += 1));
            self.base = (0..of_limb.len()).max_by_key(|&limb| of_limb[limb]).unwrap_or(0);
        }
        self.belief = Some(belief);
        self.information = information;
        let used = self.used().count();
        let due = jumped || used as f64 >= MORE_TO_FIT * self.fitted as f64 || !self.still_closed(new);
        !due || self.fit()
    }

    /// What the touches so far tell of some parameters.
    fn information_over(&self, parameters: &Parameters) -> DMatrix<f64> {
        let mut information = DMatrix::zeros(parameters.len(), parameters.len());
        let Some(belief) = &self.belief else { return information };
        let places = belief.parameters.places_in(parameters);
        for &(from, to) in &places {
            for &(other_from, other_to) in &places {
                information[(other_to, to)] = self.information[(other_from, from)];
            }
        }
        information
    }

    /// Whether what was closed before some new touches stays closed, and so do they.
    fn still_closed(&self, new: &[usize]) -> bool {
        let Some(schema) = self.schema() else { return false };
        let (mut open, mut used) = ([0; 2], 0);
        for (number, touch) in self.touches.iter().enumerate().filter(|(_, touch)| touch.used) {
            used += 1;
            if !self.closes(touch, schema) {
                open[usize::from(new.binary_search(&number).is_ok())] += 1;
            }
        }
        FEW_OPEN * open[0] <= used && FEW_OPEN * open[1] <= new.len() + FEW_OPEN
    }

    /// The parameters that the touches in use tell of.
    fn parameters(&self) -> Parameters {
        let creature = self.agent.creature();
        let joints = creature.joints().len();
        let (mut between, mut moving) = (vec![false; joints], vec![false; joints]);
        for touch in self.used() {
            touch.chain.iter().for_each(|&joint| between[joint] = true);
            touch.moving.iter().for_each(|&joint| moving[joint] = true);
        }
        Parameters::of(creature, AxisModel::Unit, |joint| between[joint], |joint, _| moving[joint])
    }

    /// Fits all that is used, from a schema that is nearly right, and takes back what leaves its touches open; false where
    /// rounding forbids.
    fn fit(&mut self) -> bool {
        while let Some(deviation) = self.fit_once() {
            let used: Vec<usize> =
                (0..self.touches.len()).filter(|&number| self.touches[number].used).collect();
            let wrong = self.schema().and_then(|schema| self.most_open(&used, schema, deviation));
            let Some(wrong) = wrong else { return true };
            self.take_back(wrong);
        }
        false
    }

    /// The same, but leaves out single touches alone; the standard deviation of a gap, metres.
    fn fit_once(&mut self) -> Option<f64> {
        let belief = self.belief.as_ref()?;
        let set = self.set(self.used());
        let (schema, deviation) = self.fitted_to(&set, &belief.parameters, belief.schema.clone());
        let opened: Vec<usize> = (0..self.touches.len())
            .filter(|&number| self.touches[number].used && !self.closes(&self.touches[number], &schema))
            .collect();
        opened.into_iter().for_each(|number| self.touches[number].used = false);
        let parameters = self.parameters();
        let sharp = deviation.max(SHARPEST);
        let information = self.information_at(&parameters, &schema, sharp);
        let mut all = information.clone();
        self.prior.add_information(&parameters, &mut all);
        self.belief = Some(Belief::new(schema, parameters, all, sharp)?);
        self.information = information;
        self.fitted = self.used().count();
        Some(deviation)
    }

    /// The touches among what is known become evidence where they nearly meet what is believed; whether any did.
    pub(super) fn take_in(&mut self) -> bool {
        let Some(belief) = &self.belief else { return false };
        let schema = belief.schema.clone();
        let known = self.known();
        let mut contradicted = Vec::new();
        let mut new = Vec::new();
        for (number, touch) in self.touches.iter().enumerate() {
            let refused = touch.refused == Some(known);
            if touch.used
                || touch.spare
                || refused
                || touch.moving.is_empty()
                || !self.lacks(touch).is_nothing()
            {
                continue;
            }
            match self.miss(touch, &schema) < super::placement::PLACED {
                true => new.push(number),
                false => contradicted.push(number),
            }
        }
        contradicted.into_iter().for_each(|number| self.touches[number].refused = Some(known));
        // Few among many hardly change what is believed.
        if new.is_empty() || TOO_FEW * new.len() < self.used().count() {
            return false;
        }
        let before = self.clone_belief();
        let stands = self.believe(schema, &new) && self.still_closed(&[]);
        if !stands {
            self.restore_belief(before, &new);
        }
        for number in new {
            let touch = &mut self.touches[number];
            touch.refused = (!touch.used).then_some(known);
        }
        self.place();
        self.revoke();
        stands
    }

    /// The joint or the limb of whose touches among some a fit to them leaves most open, where these are more than chance;
    /// `deviation` is that of a gap, metres.
    pub(super) fn most_open(&self, among: &[usize], schema: &BodySchema, deviation: f64) -> Option<Member> {
        let exact = !self.by_points() && deviation <= NARROWEST;
        let told: Vec<&GrownTouch> = among.iter().map(|&number| &self.touches[number]).collect();
        // Where touches are exact, what meets out of the patches that felt it is as wrong as what is apart.
        let miss = |touch: &GrownTouch| match exact {
            true => self.felt_gap(CLOSED, touch, schema),
            false => self.miss(touch, schema),
        };
        let misses: Vec<(&GrownTouch, f64)> = told.iter().map(|&touch| (touch, miss(touch))).collect();
        let suspect = |wide: f64, wrong: fn([f64; 2], [f64; 2]) -> bool| {
            self.most_suspect(misses.iter().map(|&(touch, miss)| (touch, miss > wide)), wrong)
        };
        let wide = EXACTLY_OPEN.max(DEVIATIONS * deviation);
        let open = suspect(wide, |of_it, others| share(of_it) > OPEN_SHARE + MORE_OPEN * share(others));
        if open.is_some() || !exact {
            return open;
        }
        if let Some(unfelt) = self.least_felt(&told, schema) {
            return Some(Member::Joint(unfelt));
        }
        // Without noise a wrong axis of a joint that hardly turns closes its touches to a tenth of a micrometre, and all others
        // to some nanometres.
        let mut sorted: Vec<f64> = misses.iter().map(|(_, miss)| *miss).collect();
        sorted.sort_by(f64::total_cmp);
        let wide = SHARPLY_OPEN.max(MANY_TIMES * quantile(&sorted, 0.5));
        suspect(wide, |of_it, others| share(of_it) > SHARPLY_OPEN_SHARE + share(others))
    }

    /// The joint of hinges that is felt by the least of some touches, where these are few: a touch feels a joint whose turning
    /// would part, or press, what touched. Limbs that are placed so that they spin about themselves touch for ever, and explain
    /// any touch of round skin, exactly.
    fn least_felt(&self, told: &[&GrownTouch], schema: &BodySchema) -> Option<usize> {
        let creature = self.agent.creature();
        let mut counts = vec![[0; 2]; creature.joints().len()];
        let nothing = Parameters::new(creature, AxisModel::Unit, |_| false);
        let mut row = GapRow::default();
        let mut slopes = Vec::new();
        for touch in told {
            row.set(self.agent.skin(), &nothing, schema, &touch.prepared);
            row.angle_slopes(schema, &touch.prepared, &mut slopes);
            for &joint in &touch.moving {
                let dofs = creature.joints()[joint].dof_indices();
                let is_felt = slopes.iter().any(|(dof, slope)| dofs.contains(dof) && slope.abs() > FELT);
                counts[joint][0] += usize::from(is_felt);
                counts[joint][1] += 1;
            }
        }
        let of_hinges = |joint: &usize| {
            creature.joints()[*joint].elements().all(|element| element.kind == DofKind::Hinge)
        };
        let unfelt = |joint: &usize| counts[*joint][1] > 0 && counts[*joint][0] < FEWEST_FELT;
        (0..counts.len()).filter(of_hinges).filter(unfelt).min_by_key(|&joint| counts[joint][0])
    }

    /// Takes back the joint or the limb that touches contradict most, where they do: a wrong answer explains what it was
    /// fitted to, but not what comes after.
    fn revoke(&mut self) {
        let told = self.touches.iter().filter(|touch| touch.used || touch.refused.is_some());
        let told = told.map(|touch| (touch, touch.refused.is_some()));
        let Some(wrong) = self.most_suspect(told, |of_it, _| share(of_it) > CONTRADICTED) else { return };
        self.take_back(wrong);
        self.fit();
        self.place();
    }

    /// Of the joints and limbs that several touches are against that one which the greatest share of its touches is; each
    /// touch comes with whether it is against what it tells of. `wrong` judges by the touches for and against it, and by all
    /// others.
    pub(super) fn most_suspect<'t>(
        &self,
        told: impl Iterator<Item = (&'t GrownTouch, bool)>,
        wrong: impl Fn([f64; 2], [f64; 2]) -> bool,
    ) -> Option<Member> {
        let members = (0..self.resolved.len()).map(Member::Joint);
        let members: Vec<Member> = members.chain((0..self.placement.len()).map(Member::Limb)).collect();
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

    /// Takes back a joint or a limb, and what nothing tells of without it.
    fn take_back(&mut self, wrong: Member) {
        for touch in self.touches.iter_mut().filter(|touch| touch.tells_of(wrong)) {
            (touch.used, touch.refused) = (false, None);
        }
        if let Member::Joint(joint) = wrong {
            self.resolved[joint] = false;
        }
        self.failed.clear();
        self.tentative.clear();
        let parameters = self.parameters();
        for joint in 0..self.resolved.len() {
            let axes = self.agent.creature().joints()[joint].elements().filter(|at| !at.is_ball());
            self.resolved[joint] &= axes.map(|at| at.axis()).all(|axis| parameters.axes[axis].is_some());
        }
    }
}

/// The share of touches that are against something.
fn share([right, against]: [f64; 2]) -> f64 {
    against / f64::max(right + against, 1.0)
}
