//! How large a receptor is to be, geom by geom.

use std::collections::BTreeMap;

use crate::creature::{body_name, limb_bodies};
use crate::error::Error;
use crate::mujoco::Model;

/// Receptors of a creature whose model does not say how fine its skin is, and who is not asked for a size;
/// more where it has many geoms.
const RECEPTORS: f64 = 250.0;
/// Receptors by geom of such a creature.
const RECEPTORS_PER_GEOM: f64 = 4.0;
/// Receptors of a limb of such a creature at the least: a finger on a large body feels no less than one on a small one.
const RECEPTORS_PER_LIMB: f64 = 12.0;

/// How large receptors are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PatchSize {
    /// As the model says; where it says nothing, so that some 250 cover the creature.
    #[default]
    OfCreature,
    /// Squares with sides of this length, metres, whatever the model says.
    Spacing(f64),
    /// So that there are this many in all, in the proportions that [`PatchSize::OfCreature`] has.
    Count(usize),
}

/// What a skin is to be like.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GrowOptions {
    /// How large its receptors are.
    pub size: PatchSize,
    /// How many times as many receptors a limb, by its name or its body's, has on the same area.
    pub denser: Vec<(String, f64)>,
}

/// One geom that can be touched.
pub struct Ground {
    pub geom: usize,
    pub limb: Option<usize>,
    /// Its exposed area, m².
    pub exposed: f64,
}

impl GrowOptions {
    /// The area of a receptor on each of the geoms, m². `grounds` measures what is exposed of all geoms of the creature,
    /// which takes some time and is not always needed.
    ///
    /// # Errors
    /// Where `denser` names no limb, or a size is no positive number.
    pub fn areas(
        &self,
        model: &Model,
        geoms: &[usize],
        grounds: impl Fn() -> Vec<Ground>,
    ) -> Result<Vec<f64>, Error> {
        let sound = |value: f64| value > 0.0 && value.is_finite();
        let positive = match self.size {
            PatchSize::Spacing(side) => sound(side),
            PatchSize::Count(count) => count > 0,
            PatchSize::OfCreature => true,
        };
        if !positive || self.denser.iter().any(|(_, factor)| !sound(*factor)) {
            return Err(Error::model("sizes and densities must be positive numbers"));
        }
        let denser = self.factors(model)?;
        // Limb tuples ask for cm².
        let of_model = limb_bodies(model).into_iter().filter(|(.., area)| *area > 0.0);
        let of_model: BTreeMap<usize, f64> = of_model.map(|(_, body, area)| (body, area * 1e-4)).collect();
        let said = |g: usize| of_model.get(&model.geom_body(g)).copied();
        let all_said = geoms.iter().all(|&g| said(g).is_some());
        let measured = match self.size {
            PatchSize::Count(_) => grounds(),
            PatchSize::OfCreature if !all_said => grounds(),
            _ => Vec::new(),
        };
        let area = |&g: &usize| {
            let of_limb = match self.size {
                PatchSize::Spacing(side) => side * side,
                _ => said(g).unwrap_or_else(|| evenly(&measured, g)),
            };
            of_limb / denser[model.geom_body(g)]
        };
        let mut areas: Vec<f64> = geoms.iter().map(area).collect();
        if let PatchSize::Count(total) = self.size {
            let of_geom: BTreeMap<usize, f64> = geoms.iter().copied().zip(areas.iter().copied()).collect();
            let ideal = |ground: &Ground| Some(ground.exposed / of_geom.get(&ground.geom)?);
            let ideal: f64 = measured.iter().filter_map(ideal).sum();
            areas.iter_mut().for_each(|area| *area *= ideal / total as f64);
        }
        Ok(areas)
    }

    /// Per body, how much denser its skin is.
    fn factors(&self, model: &Model) -> Result<Vec<f64>, Error> {
        let limbs = limb_names(model);
        let mut factors = vec![1.0; model.nbody()];
        for (name, factor) in &self.denser {
            let is_called = |b: &usize| limbs.get(b) == Some(name) || body_name(model, *b) == *name;
            let bodies: Vec<usize> = (1..model.nbody()).filter(is_called).collect();
            if bodies.is_empty() {
                let mut known: Vec<String> = limbs.into_values().collect();
                if known.is_empty() {
                    known = (1..model.nbody()).map(|body| body_name(model, body)).collect();
                }
                known.sort();
                known.dedup();
                let known = known.join(", ");
                return Err(Error::model(format!("no limb is called {name}; the limbs are {known}")));
            }
            bodies.into_iter().for_each(|body| factors[body] *= factor);
        }
        Ok(factors)
    }
}

/// The area of a receptor on a geom, m², so that some 250 cover the creature, and some 12 each of its limbs.
fn evenly(grounds: &[Ground], geom: usize) -> f64 {
    let exposed = |of: &dyn Fn(&Ground) -> bool| -> f64 {
        grounds.iter().filter(|ground| of(ground)).map(|ground| ground.exposed).sum()
    };
    let limb = grounds.iter().find(|ground| ground.geom == geom).and_then(|ground| ground.limb);
    let of_creature = exposed(&|_| true) / RECEPTORS.max(RECEPTORS_PER_GEOM * grounds.len() as f64);
    let of_limb = exposed(&|ground| ground.limb == limb) / RECEPTORS_PER_LIMB;
    if of_limb > 0.0 { of_creature.min(of_limb) } else { of_creature }
}

/// Per body, the name of the limb it is part of.
pub fn limb_names(model: &Model) -> BTreeMap<usize, String> {
    // Of several limbs of a body the first counts.
    limb_bodies(model).into_iter().rev().map(|(name, body, _)| (body, name.to_string())).collect()
}
