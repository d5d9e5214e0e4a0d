//! A limb that grows on the stage: the creature is not told.

use std::sync::Arc;

use super::Stage;
use crate::error::Result;
use crate::mujoco::Data;
use crate::senses::ContactReader;

impl Stage {
    /// Lets a limb grow: the joint that moves it is farther out by `length`, metres, on the limb that carries it from now on,
    /// or nearer where that is negative. All else stays as it is, the skin of either limb and [`Stage::body`] too. The
    /// creature is not told.
    ///
    /// # Errors
    /// Where the engine fails.
    ///
    /// # Panics
    /// Where there is no such limb.
    pub fn grow_limb(&self, limb: usize, length: f64) -> Result<()> {
        let core = &mut *self.core.borrow_mut();
        core.look_for_self_touch()?;
        let Some(segment) = limb.checked_sub(1).map(|joint| &core.body.segments[joint]) else {
            return Ok(());
        };
        let position = core.untouched.body(segment.body).pos;
        let Some(outward) = position.try_normalize(1e-6) else { return Ok(()) };
        core.untouched = core.untouched.with_body_position(segment.body, &(position + outward * length))?;
        let grown = Arc::new(core.untouched.touching_with(&core.touchable)?);
        let mut data = Data::new(grown.clone())?;
        data.take_state(&core.data)?;
        data.forward()?;
        Arc::make_mut(&mut core.body).model = grown;
        core.reader = ContactReader::new(&core.body, core.agent.skin());
        core.data = data;
        core.stillness.disturb();
        Ok(())
    }
}
