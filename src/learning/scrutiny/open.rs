//! Gaps that right answers do not leave, and joints that no touch feels.

use super::{CLOSED, Member, Scrutiny, ToldTouch};
use crate::creature::DofKind;
use crate::learning::annealing::{NARROWEST, quantile, sorted};
use crate::learning::open_gaps::{EXACTLY_OPEN, FELT};
use crate::schema::BodySchema;

/// After a fit a gap is open that is wider than [`EXACTLY_OPEN`] and than so many standard deviations.
const DEVIATIONS: f64 = 5.0;
/// A joint or a limb is wrong that leaves this share of its touches open, beyond chance.
const OPEN_SHARE: f64 = 0.05;
/// A gap that is open among touches without noise: wider than this, metres, and so many times as wide as half of all. Of
/// right answers 95 in 100 gaps are narrower than three nanometres, but for edges; …
pub(super) const SHARPLY_OPEN: f64 = 2e-8;
const MANY_TIMES: f64 = 10.0;
/// … and by so much more than among all others is the share of those that are open of a wrong answer.
const SHARPLY_OPEN_SHARE: f64 = 0.25;
/// So many touches at the least are to feel a joint.
pub(super) const FEWEST_FELT: usize = 8;

/// The widest gap that is not open, metres.
fn wide(deviation: f64) -> f64 {
    EXACTLY_OPEN.max(DEVIATIONS * deviation)
}

impl Scrutiny<'_> {
    /// Whether a schema leaves what touched apart; `deviation` is that of a gap, metres.
    pub fn is_open(&self, touch: &ToldTouch, schema: &BodySchema, deviation: f64) -> bool {
        self.miss(touch, schema) > wide(deviation)
    }

    /// The joint or the limb of whose touches a fit to them leaves most open, where these are more than chance;
    /// `deviation` is that of a gap, metres.
    pub fn most_open(&self, told: &[&ToldTouch], schema: &BodySchema, deviation: f64) -> Option<Member> {
        let exact = !self.by_points() && deviation <= NARROWEST;
        // Where touches are exact, what meets out of the patches that felt it is as wrong as what is apart.
        let miss = |touch: &ToldTouch| match exact {
            true => self.felt_gap(CLOSED, touch, schema),
            false => self.miss(touch, schema),
        };
        let mut misses: Vec<(&ToldTouch, f64)> = told.iter().map(|&touch| (touch, miss(touch))).collect();
        let wide = wide(deviation);
        let open = self.most_suspect(misses.iter().map(|&(touch, miss)| (touch, miss > wide)), |_, of_it| {
            of_it.beyond() > OPEN_SHARE
        });
        if open.is_some() || !exact {
            return open;
        }
        if self.has_false_touches {
            misses.retain(|(_, miss)| *miss <= wide);
        }
        if let Some(unfelt) = self.least_felt(misses.iter().map(|(touch, _)| *touch), schema) {
            return Some(Member::Joint(unfelt));
        }
        // Without noise a wrong axis of a joint that hardly turns closes its touches to a tenth of a micrometre, and all others
        // to some nanometres.
        let usual = quantile(&sorted(misses.iter().map(|(_, miss)| *miss)), 0.5);
        let wide = SHARPLY_OPEN.max(MANY_TIMES * usual);
        self.most_suspect(misses.iter().map(|&(touch, miss)| (touch, miss > wide)), |_, of_it| {
            of_it.beyond() > SHARPLY_OPEN_SHARE
        })
    }

    /// The joint of hinges that is felt by the least of some touches, where these are few: a touch feels a joint whose turning
    /// would part, or press, what touched. Limbs that are placed so that they spin about themselves touch for ever, and explain
    /// any touch of round skin, exactly.
    fn least_felt<'t>(
        &self,
        told: impl Iterator<Item = &'t ToldTouch>,
        schema: &BodySchema,
    ) -> Option<usize> {
        let creature = self.agent.creature();
        let mut counts = vec![[0; 2]; creature.joints().len()];
        for touch in told {
            let slopes = touch.prepared.gap_slopes(self.agent.skin(), schema);
            let felt: Vec<usize> =
                slopes.filter(|(_, slope)| slope.abs() > FELT).map(|(dof, _)| dof).collect();
            for &joint in &touch.moving {
                let dofs = creature.joints()[joint].dof_indices();
                let is_felt = felt.iter().any(|dof| dofs.contains(dof));
                counts[joint][0] += usize::from(is_felt);
                counts[joint][1] += 1;
            }
        }
        let of_hinges = |joint: &usize| {
            creature.joints()[*joint].elements().all(|element| element.kind == DofKind::Hinge)
        };
        let unfelt = |joint: &usize| {
            !self.known.frozen[*joint] && counts[*joint][1] > 0 && counts[*joint][0] < FEWEST_FELT
        };
        (0..counts.len()).filter(of_hinges).filter(unfelt).min_by_key(|&joint| counts[joint][0])
    }
}
