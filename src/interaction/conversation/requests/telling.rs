//! "How far is it?", "where do you feel this?", "what can you do?"

use super::super::Conversation;
use super::{Intent, Reply, RequestKind, Utterance};

/// What it can do, as it says it.
pub(super) const ABILITIES: &str = "I can feel about for things (\"is there something in front of you?\"), touch what I felt \
with either hand, tell where I feel it and how far it is, put it as far away as possible, bring it near, lean forward and \
try again, and go back to rest";

pub(super) const HOW_FAR: RequestKind = RequestKind {
    means: |utterance: &Utterance| {
        ["how far", "how near", "how close"].iter().any(|words| utterance.text.contains(words))
            || utterance.any(&["distance"])
    },
    needs_body: false,
    needs_thing: false,
    act: |creature, _| Ok(creature.how_far()),
};

pub(super) const WHERE_FELT: RequestKind = RequestKind {
    means: |utterance: &Utterance| {
        utterance.any(&["where"]) && utterance.any(&["feel", "felt", "touch", "is", "touched"])
    },
    needs_body: false,
    needs_thing: false,
    act: |creature, _| Ok(creature.where_felt()),
};

pub(super) const HELP: RequestKind = RequestKind {
    means: |utterance: &Utterance| utterance.any(&["help", "can"]) && utterance.any(&["help", "do"]),
    needs_body: false,
    needs_thing: false,
    act: |creature, request| Ok(creature.reply(request.intent, format!("{ABILITIES}."), None, false)),
};

impl Conversation {
    fn how_far(&self) -> Reply {
        let it = self.things.it().or((self.things.len() == 1).then_some(0));
        let Some(known) = it.map(|i| &self.things[i]) else {
            let said =
                if self.things.is_empty() { "I have not felt anything yet".into() } else { self.question() };
            return self.reply(Intent::HowFar, said, None, false);
        };
        let distances = self.actor.distances(&known.at);
        let nearest = distances.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let hands = self.actor.hands.each_ref().map(|hand| {
            let distance =
                distances.iter().find(|(limb, _)| *limb == hand.limb).map_or(f64::NAN, |(_, d)| *d);
            format!("{:.0} cm from my {}", 100.0 * distance.max(0.0), hand.name.replace('_', " "))
        });
        let near = nearest.map_or(String::new(), |(limb, distance)| {
            let limb = self.actor.own.creature().limbs()[*limb].replace('_', " ");
            format!("; the nearest to it is my {limb}, {:.0} cm away", 100.0 * distance.max(0.0))
        });
        let said = format!("It is {}: {} and {}{near}", self.place(&known.at), hands[0], hands[1]);
        self.reply(Intent::HowFar, said, None, false)
    }

    fn where_felt(&self) -> Reply {
        let touching =
            self.things.iter().filter_map(|known| known.in_touch.map(|receptor| (known, receptor)));
        let told: Vec<String> = touching
            .map(|(known, receptor)| {
                let id = &self.actor.own.skin().receptors[receptor].id;
                format!(
                    "I feel it with my {} (receptor {id}), {}",
                    self.limb_in_words(receptor),
                    self.place(&known.at)
                )
            })
            .collect();
        let said = match (told.is_empty(), self.things.it().or(self.things.len().checked_sub(1))) {
            (false, _) => told.join("; "),
            (true, Some(i)) => {
                let known = &self.things[i];
                format!(
                    "I do not feel it now; I felt it with my {}, and it is {}",
                    self.limb_in_words(known.found.receptor),
                    self.place(&known.at)
                )
            }
            (true, None) => "I do not feel anything".into(),
        };
        self.reply(Intent::WhereFelt, said, None, false)
    }
}
