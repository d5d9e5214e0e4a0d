//! Contact residuals: how far apart a schema puts the surfaces that touched.

use super::measures::touch_miss;
use crate::agent::Agent;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::{Input, Learner, SecondOrder};
use crate::schema::BodySchema;
use crate::senses::RecordedTouch;

/// The contact residuals of touches.
#[derive(Clone, Debug)]
pub struct ContactResiduals {
    /// Per touch, the two limbs and the residual, millimetres.
    pub values: Vec<([usize; 2], f64)>,
    /// Whether these are gaps between surfaces, negative where the two overlap; else distances between points of contact.
    pub gaps: bool,
}

impl ContactResiduals {
    /// Gaps of receptors on known surfaces; else distances.
    pub fn new(
        agent: &Agent,
        schema: &BodySchema,
        input: Input,
        touches: &[RecordedTouch],
    ) -> ContactResiduals {
        let skin = agent.skin();
        let surface = |surface: usize| skin.surfaces.get(surface).is_some_and(|s| s.shape.is_solid());
        let known = skin.receptors.iter().all(|receptor| receptor.surface.is_some_and(surface));
        let gaps = input == Input::Receptor && known;
        if gaps {
            let mut prepared = SecondOrder::new(agent, Input::Receptor, 0);
            touches.iter().for_each(|touch| prepared.touch(touch));
            let model = SurfaceGap::new(skin, 1.0);
            let values = prepared
                .prepared()
                .map(|(limbs, touch)| (limbs, 1e3 * model.gap(&touch.ends, &touch.frames(schema)).distance));
            return ContactResiduals { values: values.collect(), gaps };
        }
        let distance = |touch: &RecordedTouch| (touch.limbs(skin), touch_miss(agent, schema, touch));
        ContactResiduals { values: touches.iter().map(distance).collect(), gaps }
    }
}
