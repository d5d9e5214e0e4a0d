//! Mending a schema that is right but for a few joints.
//!
//! A joint that turns little leaves a trace in the touches that a mirrored axis can nearly imitate, and
//! receptor centres are too coarse to tell the two apart. The surfaces are not: where most gaps are
//! closed and some stay open, the joints that the open ones share are at fault. Each of their axes is
//! turned round, and the whole is annealed again; the best is kept, until nothing is open.

use crate::creature::Creature;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::TouchSet;
use crate::schema::BodySchema;
use crate::skin::Skin;

/// A gap is open when it is wider than this, metres, and than six deviations.
const OPEN: f64 = 5e-4;

/// How many gaps are open under a schema, in all and per joint of their chains.
pub struct OpenGaps {
    /// Share of open gaps among all touches.
    pub share: f64,
    /// Share of open gaps among the touches whose chain has the joint.
    pub by_joint: Vec<f64>,
}

/// Counts the open gaps.
pub fn open_gaps(
    creature: &Creature,
    skin: &Skin,
    touches: &TouchSet,
    schema: &BodySchema,
    gap_deviation: f64,
) -> OpenGaps {
    let model = SurfaceGap::new(skin, 1.0);
    let limit = OPEN.max(6.0 * gap_deviation);
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
    let share = |j: usize| if all[j] > 0.0 { open[j] / all[j] } else { 0.0 };
    OpenGaps { share: share(joints), by_joint: (0..joints).map(share).collect() }
}

impl OpenGaps {
    /// The joints at fault: those whose touches stay open nearly as often as the worst joint's.
    pub fn suspects(&self) -> Vec<usize> {
        let worst = self.by_joint.iter().copied().fold(0.0, f64::max);
        (0..self.by_joint.len()).filter(|&joint| self.by_joint[joint] > 0.6 * worst).collect()
    }
}
