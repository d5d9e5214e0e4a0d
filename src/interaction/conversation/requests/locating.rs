//! "Where is it?", "how far is it?", "is it near or far?", "where is your left elbow?", "what do you feel?"

use super::super::speaking::Placed;
use super::super::{Conversation, OwnSpot};
use super::{Act, Answer, RequestKind};
use crate::geometry::Capsule;
use crate::interaction::body_part::{self, BodyPart};
use crate::interaction::conversation::language::{End, PartName, Request};
use crate::interaction::things::KnownThing;
use crate::named::in_words;
use crate::peripersonal::Level;

pub(super) const HOW_FAR: RequestKind = RequestKind {
    asked: &[
        "how far|distant",
        "how near|close be|to|do|does|THING|it|$",
        "distance",
        "how much farther|further|space|room",
        "how many centimetres|centimeters|cm|inches|metres|meters|steps|millimetres|feet",
        "metre|meter|centimetre|foot|metres|centimetres off|away|from|or",
        "gap|space between",
        "in ?terms ?of centimetres|cm|centimeters|metres|inches",
        "the range to|of THING",
        "how long be the|your way|reach",
        "how long be THING to|from",
        "how long|far|big|great a way|distance|stretch|gap|reach",
    ],
    past: &["distance"],
    ..RequestKind::new(
        ["tell how far it is", "told how far it is"],
        Act::Tells(|creature, request| creature.how_far(request)),
    )
};

pub(super) const NEAR_OR_FAR: RequestKind = RequestKind {
    asked: &[
        "BODY be ?long enough|long",
        "near|nearby|close far",
        "or a|some ?long way off|away",
        "near|nearby|close or|versus far|distant|not|away|farther|out",
        "far or|versus near|close|not",
        "within|in|inside|out|outside|beyond|at ?of ?easy ?arm|is|your|the|BODY ?easy|is|own ?arm reach|range|grasp|length|distance",
        "reachable|touchable|accessible|graspable|unreachable|attainable",
        "too|very far|distant|remote",
        "be THING|SOME|there ?quite|very|really|still|all|somewhat|pretty ?that near|nearby|close|far|distant|remote",
        "have|need|must|do you|i|BODY ?have|need to stretch|lean|bend|strain|step|extend",
        "able|capable|possible|manage of|to|for ?you ?to reach|=reaching|touch|get|grasp",
        "which ?THING|one|of be ?the nearer|closer|nearest|closest|farther|farthest",
        "do|would|can|could BODY ?ever reach|get|stretch|make|extend",
        "BODY long|enough ?enough",
        "reach THING",
        "get at THING",
        "get to THING ?without|with|from|if",
        "far away or",
        "can|could THING be reached|touched|grasped",
        "be THING =reached",
    ],
    needs_body: true,
    ..RequestKind::new(
        ["tell whether I reach it", "told whether I reach it"],
        Act::Tells(|creature, request| creature.near_or_far(request)),
    )
};

pub(super) const WHERE_OWN: RequestKind = RequestKind {
    told: &["find|locate BODY $", "show ?me BODY"],
    asked: &[
        "what be BODY do $",
        "where|whereabouts ?exactly|precisely ?do|be|would|can|have|about ?i|THING|you ?find|keep|hold|see|leave|have|locate BODY",
        "where have you get BODY",
        "BODY .. where",
        "whereabouts|location|position|place|posture|pose|direction|spot|coordinates|orientation|height ?of|are|be BODY",
        "be BODY now|there|here|up|down $",
        "how far|high|low ?out|up|off|down be BODY",
        "be BODY ?still|now !touch|contact hanging|resting|pointing|above|near|close|in|on|to|bent|raised|up|down|out|over|under|below|behind|beside|left|right|by|at|stretched|straight|extended|high|low|higher|lower",
        "how|what do|be BODY $",
        "how ?high|low|far|bent|be ?be BODY",
        "which|what side|way|direction|height|level .. BODY",
        "how far|high .. BODY from|above|to|off",
        "know|say|tell|describe|find BODY $",
        "show me BODY",
        "BODY be where|located|now",
    ],
    needs_body: true,
    ..RequestKind::new(
        ["tell where it is", "told where it is"],
        Act::Tells(|creature, request| creature.where_own(request)),
    )
};

pub(super) const WHERE_FELT: RequestKind = RequestKind {
    asked: &[
        "where|whereabouts .. THING|SOME|feel|touch|contact|they|find|poke|press|tap|pat|stroke|rub",
        "^ where|whereabouts ?exactly|precisely|about ?be|now $",
        "whereabouts|location|position|place|coordinates|spot|direction|bearing|site",
        "which|what side|direction|place|spot|part|limb|way|receptor|finger",
        "be THING ?more|now|still|somewhere|straight ?to|on|at|in ?the|your left|right|ahead|front|behind|side|above|below|middle|centre|center",
        "which|what HAND|BODY|limb|hand|arm do|be|feel|touch",
        "with which|what HAND|BODY|part|limb|hand|arm",
        "which|what bit|area|patch|piece|spot|place of you|your",
        "left or ?to ?on ?the right",
        "where on|at|in the",
        "where be we",
        "^ ?tell|say|show ?me|us where $",
        "^ THING be where",
    ],
    past: &["where"],
    ..RequestKind::new(
        ["tell where I feel it", "told where I feel it"],
        Act::Tells(|creature, _| creature.where_felt()),
    )
};

pub(super) const WHAT_FELT: RequestKind = RequestKind {
    asked: &[
        "what|do|be|can|how|tell|if|whether .. feel|sense|perceive|notice|detect|contact",
        "what|be|do|how .. =touching|=touches|=feeling",
        "any|which|what|your|the ?any contact|sensation|sensations|touch|feeling|feelings|pressure",
        "SOME|THING|who|i touch|press|hold|push|contact|poke|tap|brush ?on|against|into|at BODY|you|your",
        "be|do SOME|THING|you|BODY|there ?now|still|currently|in|any touch|contact|press|against|hold|feel|SOME",
        "what be in|on|at|under|against HAND|BODY",
        "you feel|sense|touch|hold",
        "^ still =feeling|=touching|=holding|=sensing",
        "feel|sense|notice|perceive SOME",
        "SOME ?else under|at|against|in|beneath|on HAND|BODY",
        "do|be you|BODY ?still hold|touch|carry|feel|grasp|grip",
        "hold SOME|THING",
        "what ?do your skin|BODY|HAND|receptors say|feel|sense|tell|notice|touch|report",
    ],
    ..RequestKind::new(
        ["tell what I feel", "told what I feel"],
        Act::Tells(|creature, _| creature.what_felt()),
    )
};

/// Names as they are listed: "a, b and c".
fn listed(names: &[String]) -> String {
    match names {
        [first @ .., next, last] if !first.is_empty() => format!("{}, {next} and {last}", first.join(", ")),
        names => names.join(" and "),
    }
}

/// Words with a capital letter first.
fn sentence(said: &str) -> String {
    let mut letters = said.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

impl Conversation {
    /// The thing that a question is about.
    fn asked_about(&self, request: &Request) -> Result<&KnownThing, Answer> {
        let named = request.which.and_then(|which| self.which(which));
        match named.and_then(|id| self.things.get(id)).or(self.things.it()) {
            Some(known) => Ok(known),
            None if self.things.is_empty() => Err(Answer::tells("I have not felt anything yet")),
            None => Err(Answer { said: self.question(), done: None, asks: true }),
        }
    }

    fn how_far(&self, request: &Request) -> Answer {
        let known = match self.asked_about(request) {
            Ok(known) => known,
            Err(answer) => return answer,
        };
        let distances = self.actor.distances(&known.at);
        let nearest = distances.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let hands = self.actor.hands.each_ref().map(|hand| {
            let distance =
                distances.iter().find(|(limb, _)| *limb == hand.limb).map_or(f64::NAN, |(_, d)| *d);
            format!("{:.0} cm from my {}", 100.0 * distance.max(0.0), in_words(&hand.name))
        });
        let near = nearest.map_or(String::new(), |(limb, distance)| {
            let limb = in_words(&self.actor.own.creature().limbs()[*limb]);
            format!("; the nearest to it is my {limb}, {:.0} cm away", 100.0 * distance.max(0.0))
        });
        let stick = self.actor.from_stick(&known.at);
        let stick = stick.map_or(String::new(), |distance| {
            format!("; the stick in my hand is {:.0} cm from it", 100.0 * distance.max(0.0))
        });
        Answer::tells(format!("It is {}: {} and {}{near}{stick}", self.place(&known.at), hands[0], hands[1]))
    }

    /// From the map of what its hands reach, which knows joints' ranges and nothing in the way.
    fn near_or_far(&self, request: &Request) -> Answer {
        let known = match self.asked_about(request) {
            Ok(known) => known,
            Err(answer) => return answer,
        };
        let Some(maps) = self.reachable() else {
            return Answer::tells("I do not know how far my hands reach");
        };
        let only = self.hand_for(request.hand);
        let hand_of = |map: usize| self.actor.hands.iter().position(|hand| hand.limb == maps[map].hand);
        let levels: Vec<(usize, Level)> = (0..maps.len())
            .filter(|&map| only.is_none_or(|only| hand_of(map) == Some(only)))
            .map(|map| (map, maps[map].level(&maps[map].frame.inverse_point(&known.at))))
            .collect();
        let with = |wanted: Level| -> Vec<String> {
            let hands = levels.iter().filter(|(_, level)| *level == wanted);
            let name = |(map, _): &(usize, Level)| match self.actor.hands.get(*map) {
                Some(hand) => format!("my {}", in_words(&hand.name)),
                None => "the stick".to_string(),
            };
            hands.map(name).collect()
        };
        let (near, far) = (with(Level::Near), with(Level::Far));
        let verb = |hands: &[String]| if hands.len() == 1 { "reaches" } else { "reach" };
        Answer::tells(match (near.as_slice(), far.as_slice()) {
            ([], []) => "It is out of reach, even if I lean forward".to_string(),
            ([], far) => format!("It is far: {} {} it only if I lean forward", listed(far), verb(far)),
            (near, []) => format!("It is near: {} {} it without leaning", listed(near), verb(near)),
            (near, far) => format!(
                "It is near: {} {} it without leaning, {} only if I lean forward",
                listed(near),
                verb(near),
                listed(far)
            ),
        })
    }

    fn where_own(&self, request: &Request) -> Answer {
        let Some(part) = &request.part else {
            return Answer::tells("I do not know which part of me you mean");
        };
        let found = match body_part::find(&self.actor, part, self.hand_touching()) {
            Ok(found) => found,
            Err(unknown) => return Answer::tells(unknown.to_string()),
        };
        let told: Vec<String> = found
            .iter()
            .map(|part| {
                let at = part.at(&self.actor.frames());
                format!("my {} is {}", part.name, self.place_of_own(&at))
            })
            .collect();
        Answer::tells(sentence(&told.join("; ")))
    }

    /// How what a question puts in relation is placed, one relative to the other; nothing where it asks for none.
    pub(in super::super) fn relation(&self, request: &Request) -> Option<Answer> {
        let (what, to) = request.related.as_ref()?;
        if let Some(doubt) = self.doubt() {
            return Some(Answer::does(doubt, false));
        }
        Some(self.related(request, what, to).map_or_else(|answer| answer, Answer::tells))
    }

    fn related(&self, request: &Request, what: &End, to: &[PartName]) -> Result<String, Answer> {
        let frames = self.actor.frames();
        let parts = |part: &PartName| -> Result<Vec<Placed<'_>>, Answer> {
            let found = body_part::find(&self.actor, part, self.hand_touching());
            let found = found.map_err(|unknown| Answer::tells(unknown.to_string()))?;
            let extent = |part: &BodyPart| part.extent(&self.actor, &frames);
            Ok(found
                .iter()
                .map(|part| Placed { name: format!("my {}", part.name), extent: extent(part) })
                .collect())
        };
        let what = match what {
            End::Part(part) => parts(part)?,
            End::Thing => {
                let at = Capsule::ball(self.asked_about(request)?.at, 0.0);
                vec![Placed { name: "it".to_string(), extent: vec![Box::new(at)] }]
            }
        };
        let mut told: Vec<String> = Vec::new();
        for part in to {
            for to in parts(part)? {
                // Of "your hands" the one and the other: that is told once.
                let others = what.iter().take_while(|one| one.name != to.name);
                told.extend(others.filter_map(|one| self.relation_in_words([one, &to])));
            }
        }
        match told.is_empty() {
            true => Err(Answer::tells("That is one and the same part of me")),
            false => Ok(sentence(&told.join("; "))),
        }
    }

    fn where_felt(&self) -> Answer {
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
        Answer::tells(match (told.is_empty(), self.things.it().or(self.things.iter().next_back())) {
            (false, _) => told.join("; "),
            (true, Some(known)) => format!(
                "I do not feel it now; I felt it with my {}, and it is {}",
                self.limb_in_words(known.found.receptor),
                self.place(&known.at)
            ),
            (true, None) => "I do not feel anything".into(),
        })
    }

    fn what_felt(&self) -> Answer {
        let holds = self.actor.stick().map(|stick| {
            format!("I hold the stick with my {}", in_words(&self.actor.hands[stick.hand].name))
        });
        let touched = match &self.spot {
            Some(OwnSpot { receptor, by_stick }) => {
                let by = if *by_stick { "the stick" } else { "my own hand" };
                Some(format!("I feel {by} on my {}", self.limb_in_words(*receptor)))
            }
            None => {
                let any = self.things.iter().any(|known| known.in_touch.is_some());
                any.then(|| self.where_felt().said)
            }
        };
        Answer::tells(match (touched, holds) {
            (Some(touched), Some(holds)) => format!("{touched}; {holds}"),
            (Some(touched), None) => touched,
            (None, Some(holds)) => format!("{holds}, and feel nothing else"),
            (None, None) => "I do not feel anything now".to_string(),
        })
    }
}
