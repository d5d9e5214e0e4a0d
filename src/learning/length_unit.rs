//! The unit of length that a body is learned in.
//!
//! What is closed, placed or known is told in metres while a body is learned, as it holds for bodies of a person's size: the
//! wrong answers of a hand of four centimetres leave gaps as narrow as right ones of a person. So a smaller body is learned
//! as if it were larger, and a giant as if it were smaller. All lengths are multiplied by a power of two, which changes no
//! digit: of two bodies of one shape the same is learned, whatever their size.

use std::borrow::Cow;

use crate::agent::Agent;
use crate::deadline::Deadline;
use crate::learning::online::What;
use crate::learning::{BodyChange, Expectation, Learned, Learner, Tool};
use crate::schema::BodySchema;
use crate::senses::Touch;

/// The skin of the longest limb, in the unit that its body is learned in: at the least, and less than …
const LONGEST: [f64; 2] = [0.1, 1.6];
/// The smallest and the greatest unit, metres: of what is smaller than a millimetre no touches are exact enough.
const UNITS: [f64; 2] = [1.0 / 1024.0, 1024.0];

/// A unit of length: a power of two, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthUnit(f64);

impl LengthUnit {
    /// The metre, which bodies of a person's size are learned in.
    pub const METRE: LengthUnit = LengthUnit(1.0);

    /// The unit that a body is learned in, by the skin of its longest limb.
    pub fn of(agent: &Agent) -> LengthUnit {
        let longest = agent.skin().longest_limb();
        let mut unit = 1.0;
        if longest <= 0.0 {
            return LengthUnit::METRE;
        }
        while longest < LONGEST[0] * unit && unit > UNITS[0] {
            unit *= 0.5;
        }
        while longest >= LONGEST[1] * unit && unit < UNITS[1] {
            unit *= 2.0;
        }
        LengthUnit(unit)
    }

    /// The unit of so many metres; none of what is no unit of any body.
    pub fn from_metres(metres: f64) -> Option<LengthUnit> {
        let is_unit = (UNITS[0]..=UNITS[1]).contains(&metres) && metres.log2().fract() == 0.0;
        is_unit.then_some(LengthUnit(metres))
    }

    /// How many metres it is.
    pub fn metres(self) -> f64 {
        self.0
    }

    /// An agent in this unit.
    pub fn agent(self, agent: &Agent) -> Agent {
        if self == LengthUnit::METRE { agent.clone() } else { agent.scaled(1.0 / self.0) }
    }
}

/// A learner in the unit that suits its body, of touches in metres and with answers in metres.
pub struct LearnerInUnit {
    unit: LengthUnit,
    agent: Agent,
    learner: Box<dyn Learner>,
}

impl LearnerInUnit {
    /// The learner that `make` makes for an agent in the unit that suits its body.
    pub fn of(agent: &Agent, make: impl FnOnce(&Agent, LengthUnit) -> Box<dyn Learner>) -> Box<dyn Learner> {
        let unit = LengthUnit::of(agent);
        if unit == LengthUnit::METRE {
            return make(agent, unit);
        }
        let learner = make(&unit.agent(agent), unit);
        Box::new(LearnerInUnit { unit, agent: agent.clone(), learner })
    }
}

impl Learner for LearnerInUnit {
    fn touch(&mut self, touch: &Touch) {
        self.learner.touch(&touch.scaled(self.agent.creature(), 1.0 / self.unit.metres()));
    }

    fn learn(&mut self) -> Learned {
        in_metres(self.learner.learn(), self.unit, &self.agent)
    }

    fn end_at(&mut self, deadline: Deadline) {
        self.learner.end_at(deadline);
    }

    fn expectation(&self) -> Option<Expectation> {
        let metres = self.unit.metres();
        let Expectation { gap, deviation } = self.learner.expectation()?;
        Some(Expectation { gap: metres * gap, deviation: metres * deviation })
    }

    fn schema(&self) -> Option<Cow<'_, BodySchema>> {
        self.learner.schema().map(|schema| Cow::Owned(schema.scaled(self.unit.metres())))
    }

    fn way(&self) -> Vec<(usize, BodySchema)> {
        let way = self.learner.way().into_iter();
        way.map(|(touches, schema)| (touches, schema.scaled(self.unit.metres()))).collect()
    }
}

/// What was learned in a unit, in metres.
fn in_metres(learned: Learned, unit: LengthUnit, agent: &Agent) -> Learned {
    let metres = unit.metres();
    let creature = agent.creature();
    let account = learned.account.as_ref().map(|account| account.in_metres(creature, unit));
    // What an account says, it says with its lengths.
    let verdict = match learned.account.as_ref().zip(account.as_ref()) {
        Some((before, account)) if before.verdict(creature) == learned.verdict => account.verdict(creature),
        _ => learned.verdict,
    };
    let in_metres = |change: BodyChange| BodyChange { what: what_in_metres(&change.what, metres), ..change };
    Learned {
        verdict,
        schema: learned.schema.scaled(metres),
        account,
        deviation: learned.deviation.map(|deviation| metres * deviation),
        changes: learned.changes.into_iter().map(in_metres).collect(),
        ..learned
    }
}

fn what_in_metres(what: &What, metres: f64) -> What {
    match *what {
        What::Joint { joint, distance } => What::Joint { joint, distance: metres * distance },
        What::Corrected { joint, distance } => What::Corrected { joint, distance: metres * distance },
        What::Tool(tool) => What::Tool(Tool {
            grip: metres * tool.grip,
            tip: metres * tool.tip,
            radius: metres * tool.radius,
            ..tool
        }),
        What::Beyond => What::Beyond,
    }
}
