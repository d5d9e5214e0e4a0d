//! A stick in a hand as a part of the body: skin at its tip, and a surface that keeps clear as limbs do.

use nalgebra::Matrix3;

use super::collision::CollisionChecker;
use super::own_body::OwnBody;
use crate::geometry::{Shape, tangent_basis};
use crate::learning::touch_set::PreparedTouch;
use crate::learning::{Certainty, Tool};
use crate::skin::{Receptor, Skin, Surface};

/// What the place at a stick's tip is called.
pub const STICK_TIP: &str = "stick_tip";

/// A learned stick as a surface of the limb that holds it; `None` if it has no length.
fn surface(tool: &Tool) -> Option<Surface> {
    let along = tool.tip - tool.grip;
    let direction = along.try_normalize(1e-6)?;
    let across = tangent_basis(&direction);
    let first = across.column(0).into_owned();
    Some(Surface {
        limb: tool.limb,
        origin: 0.5 * (tool.grip + tool.tip),
        rotation: Matrix3::from_columns(&[first, direction.cross(&first), direction]),
        shape: Shape::Capsule { radius: tool.radius, half_length: 0.5 * along.norm() },
        geom: 0,
    })
}

impl OwnBody {
    /// The body with a learned stick, whose tip is one more receptor, the last: it faces where the stick leads. `None`
    /// if the stick has no length.
    pub fn holding(&self, tool: &Tool) -> Option<OwnBody> {
        let surface = surface(tool)?;
        let Skin { mut receptors, mut surfaces } = self.skin().clone();
        let [tangent, _, normal] = [0, 1, 2].map(|k| surface.rotation.column(k).into_owned());
        receptors.push(Receptor {
            id: STICK_TIP.into(),
            limb: tool.limb,
            position: tool.tip + normal * tool.radius,
            normal,
            tangent,
            half_extents: [tool.radius; 2],
            surface: Some(surfaces.len()),
        });
        surfaces.push(surface);
        let agent = self.agent.with_skin(Skin { receptors, surfaces }).ok()?;
        Some(OwnBody { agent, ..self.clone() })
    }

    /// How well touches tell where a stick's tip is, one standard deviation, metres; infinite where they do not. What is not
    /// known of the body counts.
    pub fn tip_deviation(&self, tool: &Tool, touches: &[&PreparedTouch]) -> f64 {
        let body = match &self.certainty {
            Certainty::Exact => None,
            Certainty::Estimated(account) => Some(&account.observability),
            Certainty::Unknown => return f64::INFINITY,
        };
        tool.tip_deviation(self.skin(), &self.schema, touches, body)
    }
}

impl CollisionChecker {
    /// The same where a limb holds a learned stick, which keeps clear of everything but that limb and those that carry it
    /// or that it carries.
    pub fn holding(&self, own: &OwnBody, tool: &Tool) -> CollisionChecker {
        match surface(tool) {
            Some(surface) => self.with_surface(own.creature(), surface),
            None => self.clone(),
        }
    }
}
