//! "Where is it?", "how far is it?", "is it near or far?", "where is your left elbow?", "what do you feel?"

use super::super::speaking::{Placed, cm, sentence};
use super::super::{Conversation, OwnSpot};
use super::{Act, Answer, RequestKind};
use crate::geometry::Capsule;
use crate::interaction::body_part::{self, BodyPart};
use crate::interaction::conversation::grammar::{End, PartName, Request};
use crate::interaction::things::KnownThing;
use crate::named::{enumerated, in_words};
use crate::peripersonal::Level;

pub(super) const HOW_FAR: RequestKind = RequestKind::answer(
    Act::Tells(|creature, _| creature.asked_about().map_or_else(|answer| answer, |it| creature.how_far(it))),
    "asked: how many cms; how FAR do you have ?to; GAP & !close|BODY; distance|range ?to|of|from|between \
     ?THING|it; UNIT ?off|away|from|or; how many|much UNIT|FAR|MORE|space|room; how SIZED|FAR a|be way; how long \
     a|be ?THING ?way to|from|distance|stretch|gap|reach; how FAR|NEAR; what .. RANGE; a long way ?off|away|to; \
     long way off|away",
);

pub(super) const NEAR_OR_FAR: RequestKind = RequestKind {
    needs_body: true,
    ..RequestKind::answer(
        Act::Tells(|creature, request| {
            creature.asked_about().map_or_else(|answer| answer, |it| creature.near_or_far(it, request))
        }),
        "asked: FAR or|versus|and|not ?NEAR; or ?some ?long way off|away; within|in|inside|out|outside|beyond|at ?of \
     ?easy|your|HAND|arm ?arm|easy RANGE & !put; REACHABLE; be THING|SOME|there ?still|ALL|that|BIT ?that NEAR|FAR \
     & !from|how|where; have|need|must|do you|i|BODY ?have|need ?to REACH|LEAN|step; \
     able|possible|manage|easy|hard|difficult|capable of|to|for ?you ?to REACH|TOUCH|get|GRAB|=reaching|=touching; \
     ^ can|could|will|would|may|might you|i|BODY|HAND ?be ?able ?to ?ever ?maybe !feel REACH|TOUCH|GRAB|get|make \
     THING|SOME|to|that|at|there; able; BODY long|enough; BODY be ?long enough|long; REACH THING|SOME|that|there; \
     get at|to THING; HELPING THING be =reached|=touched|=grasped; near enough; close enough; far enough; FAR $; \
     which ?THING be NEAR; HELPING .. need|have ?to LEAN",
    )
};

pub(super) const WHERE_OWN: RequestKind = RequestKind {
    needs_body: true,
    ..RequestKind::answer(
        Act::Tells(Conversation::where_own),
        "told: show ?me BODY; asked: WHEREABOUTS .. BODY; be BODY ?still \
     bent|raised|resting|hanging|pointing|ON|up|down|out|under|below|behind|beside|left|right|by|above|STILL|UPRIGHT|high|low|higher|lower|near|close|stretched|extended; \
     how|what ?low|FAR|SIZED|bent ?out|up|off|down be|DO|have BODY; which|what WHEREABOUTS|side|way|height|level \
     .. BODY; TELL|know|find BODY $; BODY .. ?is WHEREABOUTS",
    )
};

pub(super) const WHERE_FELT: RequestKind = RequestKind::answer(
    Act::Tells(|creature, _| Answer::tells(creature.where_felt())),
    "asked: where|whereabouts .. THING|SOME|FEEL|TOUCH|they|FIND|i|we; WHEREABOUTS of|OF|be THING|SOME|you; \
     WHEREABOUTS; which|what WHEREABOUTS|side|part|limb|way|receptor|finger; be THING ?MORE \
     ?STILL|somewhere|UPRIGHT ?ON ?your|my left|right|ahead|front|behind|side|above|below|middle; which|what ?of \
     ?your HAND|BODY|part|limb|hand|arm; which|what part|area|patch|piece|bit|spot|place of|on you|your|BODY; \
     where HELPING you|i|THING|BODY FEEL|TOUCH; which|what HAND|BODY|limb|part|place|spot|side|finger HELPING \
     you|i|THING FEEL|TOUCH; which|what place|spot|part ?of BODY|body; where ON you|your|BODY HELPING; where .. ON \
     ?your BODY|skin|body|you; behind|front|left|right .. or; past: where & you|THING|SOME|BODY|HAND",
);

pub(super) const WHAT_FELT: RequestKind = RequestKind::answer(
    Act::Tells(|creature, _| creature.what_felt()),
    "asked: can|could you FEEL ?SOME|THING|ANY; what HELPING you|BODY|HAND FEEL|TOUCH; ^ still FEEL THING|SOME; \
     what|HELPING|how|tell|if|whether|any .. FEEL|detect|contact; what|be|do|how .. =touching|=touches|=feeling; \
     any|which|what|your|the|in ?any CONTACT; SOME|THING|who|i|what TOUCH|hold|PUSH|CONTACT|=pressing|lean \
     ?ON|into BODY|you|your; be|do SOME|THING|you|BODY|HAND|there ?still|in|any ?in|any \
     TOUCH|CONTACT|against|hold|FEEL; what be ON|under HAND|BODY; you FEEL|TOUCH|hold; FEEL SOME; SOME ?else \
     under|beneath|ON HAND|BODY; do|be you|BODY|HAND ?still TOUCH|carry|FEEL|GRAB ?SOME|THING; have|do|be you|BODY \
     ?have|get hold|grip of; receptors|receptor; get|have SOME ?ON BODY",
);

impl Conversation {
    /// The thing that a question is about.
    fn asked_about(&self) -> Result<&KnownThing, Answer> {
        match self.mind.things.it() {
            Some(known) => Ok(known),
            None if self.mind.things.is_empty() => Err(Answer::tells("I have not felt anything yet")),
            None => Err(Answer::asks(self.mind.question(&self.actor))),
        }
    }

    fn how_far(&self, known: &KnownThing) -> Answer {
        let distances = self.actor.distances(&known.at);
        let hands = self.actor.hands.each_ref().map(|hand| {
            let distance =
                distances.iter().find(|(limb, _)| *limb == hand.limb).map_or(f64::NAN, |(_, d)| *d);
            format!("{} from my {}", cm(distance), in_words(&hand.name))
        });
        let nearest = distances.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let near = nearest.map_or(String::new(), |(limb, distance)| {
            let limb = in_words(&self.actor.own.creature().limbs()[*limb]);
            format!("; the nearest to it is my {limb}, {} away", cm(*distance))
        });
        let stick = self.actor.from_stick(&known.at);
        let stick = stick
            .map_or(String::new(), |distance| format!("; the stick in my hand is {} from it", cm(distance)));
        Answer::tells(format!("It is {}: {}{near}{stick}", self.place(&known.at), enumerated(&hands)))
    }

    /// From the map of what its hands reach, which knows joints' ranges and nothing in the way.
    fn near_or_far(&self, known: &KnownThing, request: &Request) -> Answer {
        let Some(maps) = self.reachable() else {
            return Answer::tells("I do not know how far my hands reach");
        };
        let only = self.hand_for(request.hand);
        let hand_of = |map: usize| self.actor.hands.iter().position(|hand| hand.limb == maps[map].hand);
        // How those of some level reach it.
        let reach = |wanted: Level, how: &str| {
            let of_level = (0..maps.len()).filter(|&map| {
                only.is_none_or(|only| hand_of(map) == Some(only))
                    && maps[map].level(&maps[map].frame.inverse_point(&known.at)) == wanted
            });
            let name = |map: usize| match self.actor.hands.get(map) {
                Some(hand) => format!("my {}", in_words(&hand.name)),
                None => "the stick".to_string(),
            };
            let names: Vec<String> = of_level.map(name).collect();
            let verb = if names.len() == 1 { "reaches" } else { "reach" };
            (!names.is_empty()).then(|| format!("{} {verb} it {how}", enumerated(&names)))
        };
        let near = reach(Level::Near, "without leaning");
        let far = reach(Level::Far, "only if I lean forward");
        Answer::tells(match (near, far) {
            (None, None) => "It is out of reach, even if I lean forward".to_string(),
            (None, Some(far)) => format!("It is far: {far}"),
            (Some(near), far) => {
                format!(
                    "It is near: {}",
                    [Some(near), far].into_iter().flatten().collect::<Vec<_>>().join(", ")
                )
            }
        })
    }

    /// The parts of its body that a name means.
    fn parts(&self, part: &PartName) -> Result<Vec<BodyPart>, Answer> {
        let found = body_part::find(&self.actor, part, self.hand_touching());
        found.map_err(Answer::tells)
    }

    fn where_own(&self, request: &Request) -> Answer {
        let Some(part) = &request.part else {
            return Answer::tells("I do not know which part of my body you mean");
        };
        let frames = self.actor.frames();
        let told = |part: &BodyPart| format!("my {} is {}", part.name, self.place_of_own(&part.at(&frames)));
        self.parts(part).map_or_else(
            |answer| answer,
            |found| Answer::tells(sentence(&found.iter().map(told).collect::<Vec<_>>().join("; "))),
        )
    }

    /// How what a question puts in relation is placed, one relative to the other; nothing where it asks for none.
    pub(in super::super) fn relation(&self, request: &Request) -> Option<Answer> {
        let (what, to) = request.related.as_ref()?;
        Some(match self.doubt() {
            Some(doubt) => Answer::failed(doubt),
            None => self.related(what, to).map_or_else(|answer| answer, Answer::tells),
        })
    }

    fn related(&self, what: &End, to: &[PartName]) -> Result<String, Answer> {
        let frames = self.actor.frames();
        let parts = |part: &PartName| -> Result<Vec<Placed<'_>>, Answer> {
            let placed = |part: BodyPart| {
                let name = format!("my {}", part.name);
                Placed { name, extent: part.extent(&self.actor, &frames) }
            };
            Ok(self.parts(part)?.into_iter().map(placed).collect())
        };
        let what = match what {
            End::Part(part) => parts(part)?,
            End::Thing => {
                let at = Capsule::ball(self.asked_about()?.at, 0.0);
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
            true => Err(Answer::tells("Those are the same part of me")),
            false => Ok(sentence(&told.join("; "))),
        }
    }

    fn where_felt(&self) -> String {
        let things = &self.mind.things;
        let touching = things.iter().filter_map(|known| Some((known, known.in_touch?)));
        let told: Vec<String> = touching
            .map(|(known, receptor)| {
                let id = &self.actor.own.skin().receptors[receptor].id;
                let limb = self.limb_in_words(receptor);
                format!("I feel it with my {limb} (receptor {id}), {}", self.place(&known.at))
            })
            .collect();
        match (told.is_empty(), things.it().or(things.iter().next_back())) {
            (false, _) => told.join("; "),
            (true, Some(known)) => {
                let limb = self.limb_in_words(known.found.receptor);
                format!(
                    "I do not feel it now; I last felt it with my {limb}, and it is {}",
                    self.place(&known.at)
                )
            }
            (true, None) => "I do not feel anything".into(),
        }
    }

    fn what_felt(&self) -> Answer {
        let holds = self.actor.stick();
        let holds = holds.map(|stick| format!("I hold the stick with my {}", self.hand_name(stick.hand)));
        let touched = match &self.spot {
            Some(OwnSpot { receptor, by_stick }) => {
                let by = if *by_stick { "the stick" } else { "my own hand" };
                Some(format!("I feel {by} on my {}", self.limb_in_words(*receptor)))
            }
            None => {
                let any = self.mind.things.iter().any(|known| known.in_touch.is_some());
                any.then(|| self.where_felt())
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
