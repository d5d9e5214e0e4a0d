//! What is believed of all that is known: information that touches add to, and fits of all of them now and then.

use nalgebra::{DMatrix, DVector};

use super::evidence::Equation;
use super::{GrownTouch, Growth};
use crate::learning::online::Belief;
use crate::learning::prediction::add_row;
use crate::learning::scrutiny::{Member, ToldTouch};
use crate::learning::surface_gap::SHARPEST;
use crate::learning::{AxisModel, Parameters};
use crate::schema::BodySchema;

/// Of so many touches one that was closed may open.
const FEW_OPEN: usize = 50;
/// Of so many touches one that is refused may be an exact one that is not understood; of more some are false.
const SOME_FALSE: usize = 100;
/// Touches are taken in when so many times as many are believed, or fewer.
const TOO_FEW: usize = 50;
/// All is fitted again where there are so many times more touches than at the last time.
const MORE_TO_FIT: f64 = 1.5;

impl Growth {
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

    /// Whether so many touches between what is known do not agree with it that some must be false.
    pub(super) fn has_false_touches(&self) -> bool {
        let refused = self.touches.iter().filter(|touch| !touch.used && touch.refused.is_some()).count();
        SOME_FALSE * refused > self.used().count() + refused
    }

    /// The touches that belief rests on.
    pub(super) fn used(&self) -> impl Iterator<Item = &GrownTouch> {
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
                self.known.prior.add_information(&parameters, &mut all);
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
            self.used().for_each(|touch| touch.told.limbs.iter().for_each(|&limb| of_limb[limb] += 1));
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
            touch.told.chain.iter().for_each(|&joint| between[joint] = true);
            touch.told.moving.iter().for_each(|&joint| moving[joint] = true);
        }
        Parameters::of(creature, AxisModel::Unit, |joint| between[joint], |joint, _| moving[joint])
    }

    /// Fits all that is used, from a schema that is nearly right, and takes back what leaves its touches open; false where
    /// rounding forbids.
    fn fit(&mut self) -> bool {
        while let Some(deviation) = self.fit_once() {
            let used: Vec<&ToldTouch> = self.used().map(|touch| &*touch.told).collect();
            let wrong = self.schema().and_then(|schema| self.scrutiny().most_open(&used, schema, deviation));
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
        self.known.prior.add_information(&parameters, &mut all);
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
            if touch.used || touch.spare || refused || !self.lacks(touch).is_nothing() {
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
        let mut grown = self.clone();
        let stands = grown.believe(schema, &new) && grown.still_closed(&[]);
        if stands {
            *self = grown;
        }
        for number in new {
            let touch = &mut self.touches[number];
            touch.refused = (!touch.used).then_some(known);
        }
        self.place();
        stands
    }

    /// Takes back a joint or a limb that does not stand against the touches in use; whether all stands.
    pub fn stands(&mut self) -> bool {
        let Some(deviation) = self.fit_once() else { return true };
        let used: Vec<&ToldTouch> = self.used().map(|touch| &*touch.told).collect();
        let wrong = self.schema().and_then(|schema| self.scrutiny().doubted(&used, schema, deviation));
        self.take_back_all(wrong.as_slice());
        wrong.is_none()
    }

    /// Takes back joints and limbs that do not stand.
    pub(super) fn take_back_all(&mut self, wrong: &[Member]) {
        wrong.iter().for_each(|&member| self.take_back(member));
        if self.used().next().is_none() {
            self.belief = None;
        }
        self.fit();
        self.place();
    }

    /// Takes back a joint or a limb, and what nothing tells of without it.
    fn take_back(&mut self, wrong: Member) {
        for touch in self.touches.iter_mut().filter(|touch| touch.told.tells_of(wrong)) {
            (touch.used, touch.refused) = (false, None);
        }
        if let Member::Joint(joint) = wrong {
            self.resolved[joint] = false;
        }
        self.failed.clear();
        let parameters = self.parameters();
        for joint in 0..self.resolved.len() {
            let axes = self.agent.creature().joints()[joint].elements().filter(|at| !at.is_ball());
            self.resolved[joint] &= axes.map(|at| at.axis()).all(|axis| parameters.axes[axis].is_some());
        }
    }
}
