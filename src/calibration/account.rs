//! What a calibration found, what it left open, and how well both stand.

use super::estimate::Fit;
use super::held_out::{FEWEST_HELD_OUT, Judgement, Misses, mean};
use super::noise::Seen;
use super::objections::Objection;
use super::problem::Estimator;
use super::robot::{Quantity, Robot};
use super::touch::Touch;

/// What was found, of whom and by what.
pub struct Calibration<'a> {
    /// The robot at its maker's numbers.
    pub robot: &'a Robot,
    /// The touches that were fitted to.
    pub touches: &'a [Touch],
    /// What looked for the numbers.
    pub estimator: &'a Estimator<'a>,
    /// The numbers.
    pub fit: &'a Fit,
    /// What held-out touches say, part by part.
    pub judged: &'a [Judgement],
    /// What speaks against it.
    pub objections: &'a [Objection],
}

impl Calibration<'_> {
    /// The touches as they are seen at nominal values.
    pub fn before(&self) -> Vec<Seen> {
        self.estimator.seen(&self.robot.nominal(), &self.fit.noise)
    }

    /// Quantities that were to be found.
    pub fn open(&self) -> impl Iterator<Item = (usize, &Quantity)> {
        self.robot.quantities.iter().enumerate().filter(|(_, quantity)| quantity.is_open())
    }

    /// Whether any touch depends on a quantity, alone or with others.
    pub fn is_touched(&self, q: usize) -> bool {
        self.estimator.open_signs().contains(&q)
            || self.estimator.unknowns.places(q).any(|place| !self.fit.told.ties.contains(&vec![place]))
    }

    /// The standard deviations of a quantity's parameters, infinite where nothing determines them.
    pub fn deviations(&self, q: usize) -> Vec<f64> {
        if self.estimator.open_signs().contains(&q) {
            return vec![if self.fit.untold_signs.contains(&q) { f64::INFINITY } else { 0.0 }];
        }
        self.estimator.unknowns.places(q).map(|place| self.fit.told.deviation(place)).collect()
    }

    /// What is unobservable or confounded, in sentences.
    pub fn untold(&self) -> Vec<String> {
        let (mut alone, mut sentences) = (Vec::new(), Vec::new());
        for untold in self.fit.told.untold(self.robot, &self.estimator.unknowns) {
            match untold.names.as_slice() {
                [most @ .., last] if !most.is_empty() => {
                    let ways = match untold.ways {
                        1 => String::new(),
                        ways => format!(" ({ways} unobservable directions)"),
                    };
                    let most = most.join(", ");
                    sentences.push(format!("{most} and {last} are confounded by these touches{ways}"));
                }
                names => alone.extend_from_slice(names),
            }
        }
        alone.extend(self.fit.untold_signs.iter().map(|sign| self.robot.quantities[*sign].name.clone()));
        if !alone.is_empty() {
            let alone = alone.join(", ");
            sentences.push(format!("not determined by these touches, left at their nominal values: {alone}"));
        }
        sentences
    }

    /// Parameters that are determined, by their names and places among the unknowns.
    pub fn told(&self) -> Vec<(String, usize)> {
        let unknowns = &self.estimator.unknowns;
        let told = (0..unknowns.len()).filter(|place| self.fit.told.is_told(*place));
        told.map(|place| (unknowns.name(self.robot, place), place)).collect()
    }

    /// Pairs of parameters and their correlation, the greatest first; those of `least` or more.
    pub fn correlations(&self, least: f64) -> Vec<(String, String, f64)> {
        let told = self.told();
        let pairs =
            told.iter().enumerate().flat_map(|(k, one)| told[..k].iter().map(move |other| (other, one)));
        let correlated =
            pairs.map(|((a, i), (b, j))| (a.clone(), b.clone(), self.fit.told.correlation(*i, *j)));
        let mut found: Vec<_> = correlated.filter(|(_, _, correlation)| correlation.abs() >= least).collect();
        found.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
        found
    }

    /// Whether the robot explains its touches.
    pub fn is_calibrated(&self) -> bool {
        self.objections.is_empty()
    }

    /// The same in a sentence: what speaks against it, if anything does.
    pub fn verdict(&self) -> String {
        let sentences: Vec<String> = self.objections.iter().map(ToString::to_string).collect();
        match self.is_calibrated() {
            true => "calibrated: the estimated parameters explain the touches".into(),
            false => format!("NOT calibrated: {}", sentences.join("; ")),
        }
    }

    /// Contact residuals, before and after: of all touches, and of those held out.
    pub fn misses(&self) -> Vec<(String, Misses)> {
        let of_all = [("before", Misses::of(&self.before())), ("after", Misses::of(&self.fit.seen))];
        let mut misses = of_all.map(|(name, misses)| (name.to_string(), misses)).to_vec();
        if self.fit.noise.false_share > 0.0 {
            misses.push(("after, without outliers".into(), Misses::of(self.fit.inliers())));
        }
        if let [first, others @ ..] = self.judged {
            let parts = if others.is_empty() { String::new() } else { format!("{} × ", self.judged.len()) };
            let before = Misses::mean(self.judged.iter().map(|judged| judged.before));
            let after = Misses::mean(self.judged.iter().map(|judged| judged.after));
            for (when, misses_then) in [("before", before), ("after", after)] {
                misses.push((format!("{when}, {parts}{} held out", first.touches), misses_then));
            }
        }
        misses
    }

    /// How many of the held-out touches are where the deviations say, in a sentence.
    pub fn held_out(&self) -> Option<String> {
        let rows: usize = self.judged.iter().map(|judged| judged.touches).sum();
        if self.judged.is_empty() {
            return None;
        }
        if rows < FEWEST_HELD_OUT {
            return Some(format!(
                "too few held-out rows to check the 95 % interval: {rows} of at least {FEWEST_HELD_OUT}"
            ));
        }
        Some(format!(
            "{:.1} % of the held-out residuals are within the 95 % interval ({:.3} mm wide on average)",
            100.0 * mean(self.judged.iter().map(|judged| judged.within)),
            1e3 * mean(self.judged.iter().map(|judged| judged.interval))
        ))
    }
}
