//! "Feel yourself over", "has your body changed?": it touches itself until it knows its body as it is now.

use super::super::{Conversation, Pending};
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::Request;
use crate::interaction::tasks::{FeltOver, Trouble};
use crate::named::in_words;
use crate::simulation::EngineError;

pub(super) const FEEL_OVER: RequestKind = RequestKind {
    told: &[
        "feel|touch|pat ?your yourself|body|BODY ?all over|everywhere|anew",
        "feel|touch|pat all over ?your yourself|body|BODY",
        "check|examine|inspect|explore|learn|relearn|know|study ?your yourself|body",
        "get|become used|accustomed ?to ?your body|limbs",
        "calibrate|recalibrate ?your|yourself ?body|yourself",
        "find|work out ?how|what|whether ?your body",
    ],
    ..RequestKind::new(
        ["feel myself over", "felt myself over"],
        Act::Moves(|creature, _, _| creature.feel_over()),
    )
};

impl Conversation {
    /// Feels itself over, and tells what has changed.
    fn feel_over(&mut self) -> Result<Reply, EngineError> {
        let intent = Intent::FeelOver;
        self.let_be();
        self.settle_at_ready();
        let found = match self.actor.feel_over() {
            Err(Trouble::Engine(error)) => return Err(error),
            Err(trouble) => {
                let said = format!("I could not touch myself all over: {}", self.in_words(&trouble));
                return self.fails(intent, said);
            }
            Ok(found) => found,
        };
        // What he touched himself with was meant.
        self.actor.take_unexpected();
        let changed = matches!(found, FeltOver::Changed { .. });
        if changed {
            self.things.forget_all();
            self.search = None;
            self.felt.clear();
            self.reachable.take();
            self.ready = self.actor.ready();
        }
        self.settle_at_ready();
        let (said, done) = match found {
            FeltOver::Same { touches } => {
                (format!("I touched myself {touches} times: my body is as I know it"), true)
            }
            FeltOver::Changed { touches, joints } => {
                let names = self.actor.own.creature().joints();
                let told = |(joint, distance): &(usize, f64)| {
                    format!(
                        "my {} is {:.1} cm from where I had it",
                        in_words(&names[*joint].name),
                        100.0 * distance
                    )
                };
                let told: Vec<String> = joints.iter().map(told).collect();
                let said = format!(
                    "I touched myself {touches} times, and my body has changed: {}. I act by what I know of it now, and have to feel anew where the table is and what stands on it",
                    told.join("; ")
                );
                (said, true)
            }
            FeltOver::Unexplained { touches } => {
                let said = format!(
                    "I touched myself {touches} times: my body is not as I know it, and I did not find out how it has changed. I keep from acting by what I know of it"
                );
                (said, false)
            }
            FeltOver::TooFew { touches: 0 } => {
                let said = "I know nothing of how sure I am of my body, so I cannot tell whether it has changed: I should babble anew";
                (said.to_string(), false)
            }
            FeltOver::TooFew { touches } => (
                format!(
                    "I touched myself only {touches} times, which does not tell whether my body has changed"
                ),
                false,
            ),
        };
        Ok(self.reply(intent, said, Some(done), false))
    }

    /// Says that it touched itself where it did not expect it, and asks whether to feel itself over, where that happened.
    pub(in super::super) fn heed_unexpected(&mut self, reply: &mut Reply) {
        let Some((receptors, off)) = self.actor.take_unexpected() else { return };
        if reply.asks || self.pending.is_some() {
            return;
        }
        let [a, b] = receptors.map(|receptor| self.limb_in_words(receptor));
        let cm = (100.0 * off.abs()).round().max(1.0);
        reply.said = format!(
            "{} My {a} and my {b} touched where I had them {cm:.0} cm {}: my body may have changed. Shall I feel myself over?",
            reply.said,
            if off > 0.0 { "apart" } else { "in each other" }
        );
        reply.asks = true;
        self.pending = Some(Pending::Whether(Request { intent: Intent::FeelOver, ..Request::default() }));
    }
}
