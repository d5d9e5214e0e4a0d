//! A learner that works in the unit of length that suits its body, and answers in metres.

use std::borrow::Cow;

use crate::agent::Agent;
use crate::deadline::Deadline;
use crate::learning::online::What;
use crate::learning::{BodyChange, Expectation, Learned, Learner, LengthUnit, Tool};
use crate::schema::BodySchema;
use crate::senses::Touch;

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
