//! "Feel yourself over", "has your body changed?": it touches itself until it knows its body as it is now.

use super::super::{Conversation, Pending};
use super::{Act, Acted, Answer, Intent, Reply, RequestKind};
use crate::interaction::conversation::grammar::Request;
use crate::interaction::tasks::FeltOver;
use crate::named::in_words;

pub(super) const FEEL_OVER: RequestKind = RequestKind::new(
    ["feel myself over", "felt myself over"],
    Act::Moves(|creature, _, _| creature.feel_over()),
)
.asked("be ?your body ?still same|changed|different|=changed ; have ?your body changed|=changed")
.past("have BODY|your ?body changed|=changed")
.told(
    "FEEL|TOUCH|pat ?your ?whole|entire yourself|body ?ALL ?over|everywhere|AGAIN|AROUND ; \
         FEEL|TOUCH|pat yourself|BODY ALL|over|everywhere|anew|AROUND ; \
         FEEL|TOUCH|pat ALL over ?your yourself|body|BODY ; \
         EXAMINE|SEARCH|learn|relearn|KNOW|study ?your yourself|body ; CALIBRATE ; \
         CALIBRATE ?your|yourself ?body|yourself ; FIND|work out ?how|what|whether ?your body ; \
         EXAMINE your body ; FEEL your body ; \
         EXAMINE|FIND|see|test|check .. whether|if|how .. body|limbs|BODY .. \
         changed|=changed|=same|as|still ; body|limbs .. changed ; \
         EXAMINE|FEEL|pat|check|test|SEARCH|learn|KNOW .. body|yourself|limbs & !stick ; \
         give yourself|body .. once|check|feel|exam|examination ; update|refresh .. body|yourself ; \
         GO|RUN ?HAND over|along ?your yourself|body|limbs ; FEEL|TOUCH ALL ?over ?of yourself|body ; \
         self check|test|exam|calibration|CALIBRATE ; pat yourself down ; EXAMINE|check|test ?your PART ; \
         body scan|check|test|exam ; ^ body SEARCH|EXAMINE ; do .. body EXAMINE",
);

impl Conversation {
    /// Feels itself over, and tells what has changed.
    fn feel_over(&mut self) -> Acted {
        self.let_be();
        self.settle_at_ready();
        let found = match self.actor.feel_over() {
            Ok(found) => found,
            Err(trouble) => {
                let trouble = self.in_words(&trouble.of_task()?);
                return Ok(Answer::failed(format!("I could not touch myself all over: {trouble}")));
            }
        };
        // What he touched himself with was meant.
        self.actor.take_unexpected();
        if matches!(found, FeltOver::Changed { .. }) {
            self.things.forget_all();
            self.search = None;
            self.felt.clear();
            self.reachable.take();
            self.ready = self.actor.ready();
        }
        self.settle_at_ready();
        Ok(match found {
            FeltOver::Same { touches } => {
                Answer::done(format!("I touched myself {touches} times: my body is as I know it"))
            }
            FeltOver::Changed { touches, joints } => {
                let names = self.actor.own.creature().joints();
                let told = |(joint, distance): &(usize, f64)| {
                    let cm = 100.0 * distance;
                    format!("my {} is {cm:.1} cm from where I had it", in_words(&names[*joint].name))
                };
                let told: Vec<String> = joints.iter().map(told).collect();
                let changed =
                    format!("I touched myself {touches} times, and my body has changed: {}", told.join("; "));
                Answer::done(format!(
                    "{changed}. I act by what I know of it now, and have to feel anew where the table is and what stands on it"
                ))
            }
            FeltOver::Unexplained { touches } => Answer::failed(format!(
                "I touched myself {touches} times: my body is not as I know it, and I did not find out how it has changed. I keep from acting by what I know of it"
            )),
            FeltOver::TooFew { touches: 0 } => Answer::failed(
                "I know nothing of how sure I am of my body, so I cannot tell whether it has changed: I should babble anew",
            ),
            FeltOver::TooFew { touches } => Answer::failed(format!(
                "I touched myself only {touches} times, which does not tell whether my body has changed"
            )),
        })
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
