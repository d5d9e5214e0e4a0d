//! A limb that grows on the stage: the creature is not told.

use std::sync::Arc;

use super::core::StageCore;
use crate::creature::Body;
use crate::mujoco::{self, Data};
use crate::senses::ContactReader;

impl StageCore {
    /// Puts the joint that moves a limb farther out, by `length`, metres, on the limb that carries it; nearer where that is
    /// negative. All else stays as it is, the skin of either limb too.
    pub fn grow_limb(&mut self, limb: usize, length: f64) -> mujoco::Result<()> {
        self.look_for_self_touch()?;
        let Some(segment) = limb.checked_sub(1).map(|joint| &self.body.segments[joint]) else {
            return Ok(());
        };
        let position = self.untouched.body(segment.body).pos;
        let Some(outward) = position.try_normalize(1e-6) else { return Ok(()) };
        self.untouched = self.untouched.with_body_position(segment.body, &(position + outward * length))?;
        let grown = Arc::new(self.untouched.touching_with(&self.touchable)?);
        let mut data = Data::new(grown.clone())?;
        data.take_state(&self.data)?;
        data.forward()?;
        let mut body: Body = (*self.body).clone();
        body.model = grown;
        self.body = Arc::new(body);
        self.reader = ContactReader::new(&self.body, self.agent.skin());
        self.data = data;
        self.stillness.disturb();
        Ok(())
    }
}
