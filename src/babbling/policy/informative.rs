//! Motions towards the touch that would tell most, of several imagined.

use rand_chacha::ChaCha8Rng;

use super::Policy;
use super::explorer::Explorer;
use super::information::Information;
use super::working_schema::WorkingSchema;
use crate::agent::Agent;
use crate::creature::Posture;
use crate::senses::Touch;
use crate::simulation::Ending;

/// Touches imagined before each motion.
const IMAGINED: usize = 16;
/// Draws of pairs for them.
const DRAWS: usize = 32;
/// How much the draws even out the pairs: the information does the rest.
const EVEN: f64 = 0.5;
/// The least and the most that a gap is taken to be uncertain by, metres.
const DEVIATION: [f64; 2] = [1e-3, 1e-2];

/// The policy `informative`.
pub struct Informative<'a> {
    explorer: Explorer<'a>,
    information: Information<'a>,
    touches: Vec<Touch>,
}

impl<'a> Informative<'a> {
    /// The policy of a creature with a skin, imagining touches by a working schema.
    pub fn new(agent: &'a Agent, working: WorkingSchema<'a>) -> Informative<'a> {
        let mut informative = Informative {
            explorer: Explorer::new(agent, working),
            information: Information::new(agent),
            touches: Vec::new(),
        };
        informative.rebuild();
        informative
    }

    fn rebuild(&mut self) {
        let working = &self.explorer.working;
        if let Some(schema) = working.schema() {
            let deviation = working.deviation().clamp(DEVIATION[0], DEVIATION[1]);
            self.information.rebuild(schema, &self.touches, deviation);
        }
    }
}

impl Policy for Informative<'_> {
    fn next_target(&mut self, posture: &[f64], rng: &mut ChaCha8Rng) -> Posture {
        if self.explorer.aims(posture, rng) {
            let mut best = None;
            let mut imagined = 0;
            for _ in 0..DRAWS {
                let Some(aim) = self.explorer.draw(posture, EVEN, rng) else { continue };
                let Some(schema) = self.explorer.working.schema() else { break };
                let explorer = &self.explorer;
                // A schema that is wrong knows least about what it is wrong about.
                let worth = match explorer.working.converged() {
                    true => self.information.gain(&self.information.row(schema, aim.receptors, &aim.posture)),
                    false => explorer.experience.need_between(aim.limbs),
                };
                let expected = worth * explorer.experience.tally(aim.limbs).success();
                if best.as_ref().is_none_or(|(most, _)| expected > *most) {
                    best = Some((expected, aim));
                }
                imagined += 1;
                if imagined == IMAGINED {
                    break;
                }
            }
            if let Some((_, aim)) = best {
                return self.explorer.take(aim);
            }
        }
        // Random postures differ most; a revisit would save motions, which count for nothing here.
        self.explorer.random(rng)
    }

    fn touched(&mut self, touch: &Touch) {
        self.touches.push(touch.clone());
        if self.explorer.touched(touch) {
            self.rebuild();
        } else if let Some(schema) = self.explorer.working.schema() {
            let receptors = touch.ends.map(|end| end.receptor);
            let row = self.information.row(schema, receptors, &touch.posture);
            self.information.update(&row);
        }
    }

    fn missed(&mut self, ending: &Ending, _: &[f64]) {
        self.explorer.missed(*ending != Ending::Again);
    }
}
