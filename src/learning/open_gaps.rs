//! Which touches a schema leaves open, and which joints they blame.
//!
//! A joint that turns little leaves a trace in the touches that a mirrored axis can nearly imitate, and
//! receptor centres are too coarse to tell the two apart. The surfaces are not: where most gaps are
//! closed and some stay open, the joints that the open ones share are at fault.

use crate::creature::Creature;
use crate::learning::annealing::{gaps, typical_gap};
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::TouchSet;
use crate::schema::BodySchema;
use crate::skin::Skin;

/// A gap is open when it is wider than this, metres, and than [`DEVIATIONS`].
const OPEN: f64 = 5e-4;
/// Standard deviations of the gaps, as the gaps show it, that a closed gap stays within.
const DEVIATIONS: f64 = 5.0;
/// Share of open gaps that false touches may make up in the long run …
const FALSE_SHARE: f64 = 0.12;
/// … and standard deviations that chance may add to it in few.
const CHANCE: f64 = 2.0;
/// Touches with a joint below which their share says little of it.
const FEW: f64 = 6.0;

/// How many gaps are open under a schema, in all and per joint of their chains.
#[derive(Clone, Debug)]
pub struct OpenGaps {
    /// Share of open gaps among all touches.
    pub share: f64,
    /// Share of open gaps among the touches whose chain has the joint; 0 where these are few.
    pub by_joint: Vec<f64>,
    /// The greatest share in units of what false touches and chance may make up.
    worst: f64,
}

impl OpenGaps {
    /// Counts the open gaps of a schema.
    pub fn new(creature: &Creature, skin: &Skin, touches: &TouchSet, schema: &BodySchema) -> OpenGaps {
        let model = SurfaceGap::new(skin, 1.0);
        let noise = typical_gap(&gaps(skin, touches, schema));
        let limit = OPEN.max(DEVIATIONS * noise);
        let joints = creature.joints().len();
        let (mut open, mut all) = (vec![0.0; joints + 1], vec![0.0; joints + 1]);
        for pair in &touches.pairs {
            for touch in &pair.touches {
                let gap = model.meeting(&touch.ends, &touch.frames(schema)).gap.abs();
                let is_open = f64::from(u8::from(gap > limit));
                for joint in pair.chain.joints().chain([joints]) {
                    open[joint] += is_open;
                    all[joint] += 1.0;
                }
            }
        }
        let share = |j: usize| if all[j] >= FEW { open[j] / all[j] } else { 0.0 };
        let excess = |j: usize| {
            let chance = (FALSE_SHARE * (1.0 - FALSE_SHARE) / all[j].max(FEW)).sqrt();
            share(j) / (FALSE_SHARE + CHANCE * chance)
        };
        let worst = (0..=joints).map(excess).fold(0.0, f64::max);
        let share_of_all = open[joints] / all[joints].max(1.0);
        OpenGaps { share: share_of_all, by_joint: (0..joints).map(share).collect(), worst }
    }

    /// Whether false touches and chance may have left open what is open, for every joint.
    pub fn tolerable(&self) -> bool {
        self.worst <= 1.0
    }

    /// The joint whose touches stay open most; none where all are closed.
    pub fn worst_joint(&self) -> Option<usize> {
        let shares = self.by_joint.iter().enumerate().filter(|(_, share)| **share > 0.0);
        shares.max_by(|a, b| a.1.total_cmp(b.1)).map(|(joint, _)| joint)
    }

    /// The joints at fault: those whose touches stay open nearly as often as the worst joint's.
    pub fn suspects(&self) -> Vec<usize> {
        let worst = self.by_joint.iter().copied().fold(0.0, f64::max);
        (0..self.by_joint.len()).filter(|&joint| self.by_joint[joint] > 0.6 * worst).collect()
    }
}
