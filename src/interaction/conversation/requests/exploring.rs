//! "Is there something in front of you?": it feels about on the table. "How many things are there?"

use super::super::Conversation;
use super::{Act, Acted, Answer, Intent, Reply, RequestKind};
use crate::error::{Error, Result};
use crate::interaction::FoundThing;
use crate::interaction::tasks::tried;
use crate::interaction::things::{KnownThing, ThingId};

/// What is no farther behind a thing than this is told of as behind it, metres.
const BEHIND: f64 = 0.15;
/// What it says where it felt no table.
const NO_TABLE: &str = "I lowered my hands and felt no table in front of me";

pub(super) const EXPLORE: RequestKind = RequestKind::of_body(
    ["feel around for things", "felt around for things"],
    Act::Moves(|creature, request, _| {
        let hand = creature.hand_for(request.hand);
        if request.all { Ok(creature.counted(hand)?) } else { creature.explore(hand, true) }
    }),
    "told: SEARCH|FEEL|EXAMINE|LOOK ?out|ON|ALL|AROUND|of ?ALL ?of ?ON|around ?your|this|what ?ALL \
     TABLE|SPACE|top|front; SEARCH|FEEL|LOOK|cast|move|wave|GRAB ?HAND|your ?hands ?out ?ALL AROUND; \
     SEARCH|LOOK|FEEL|EXAMINE ?out|AROUND|with ?with ?HAND ?on for SOME|THING|MORE; EXAMINE|FIND|FEEL|LOOK ?out \
     if|whether|what|for ?THING|SOME|there|you|i ?be ?SOME; REACH ?out ?HAND ?out|AROUND ?for|ON|and ?FIND|TOUCH \
     SOME; TOUCH|GRAB|get SOME; ^ SEARCH; GO|RUN|FEEL ?HAND AROUND TABLE; LOOK|SEARCH ?AROUND AGAIN|MORE; \
     FIND|SEARCH ?me THING|SOME|MORE; give TABLE|SPACE|the .. SEARCH|FEEL; have|take|give a ?GOOD ?quick \
     FEEL|LOOK|SEARCH ?AROUND|for; keep|go ?on =looking|=searching|=exploring|=feeling; FEEL ?AROUND $; \
     SEARCH|LOOK|FEEL & THING|SOME; make|do|perform|have|take ?ANY SEARCH|exploration ?of; asked: be TABLE \
     empty|bare|clear; what you HELPING FIND|see; what stand|lie|be|=standing|=lying ON TABLE|front; be there ?any \
     ?MORE|else|other SOME|THING|MORE; be SOME there|ON|AROUND|NEAR|before|out|within|left|lying|standing; ^ \
     any|more SOME|MORE|others|there; ^ SOME ?there|AROUND|ON|before|near; HELPING there be SOME; HELPING you \
     FIND|SEARCH|FEEL|LOOK SOME ?ON|AROUND|else|there|near; do|be SOME ?lie|stand|sit|=lying|=standing|=sitting \
     ON|AROUND|there; what else; SOME MORE; ?if|whether there|SOME be SOME; whether|if .. SOME & \
     there|ON|TABLE|front; SOME within|in ?easy ?your RANGE; what ?THING|SOME ?HELPING be ?out there|here|ON; what \
     ?THING|SOME HELPING you FIND|LOOK|SEARCH; be THING|SOME there; sign|trace of SOME; come across SOME; FEEL \
     SOME out there; what have|do we|you|i ?have|get ?there|here ON|before|around",
);

pub(super) const HOW_MANY: RequestKind = RequestKind::answer(
    Act::Tells(|creature, _| {
        let not_searched = match &creature.search {
            Some(search) if search.done => creature.unsearched(),
            _ => "; I have not searched the whole table".to_string(),
        };
        Answer::tells(format!("I have felt {}{not_searched}", creature.things_in_words()))
    }),
    "asked: how many & !UNIT|cms; number|total|tally of THING|SOME; what .. number|count|total|tally; just|only \
     one|THING|SOME; MORE than one|two|three|THING|SOME; be there ?only two|three|four|five|several; ^ \
     count|tally; SOME|THING or NUMBER|MORE; keep count|tally; number|total $; how much SOME; past: how many; \
     number of THING|SOME; NUMBER or; MORE than one|two",
);

impl Conversation {
    /// Feels about until something is felt that it does not know yet, and keeps touching it: "is there something?",
    /// "anything else?" Where it need not be the nearest, `quick` lets it sweep first.
    pub(in crate::interaction::conversation) fn explore(
        &mut self,
        hand: Option<usize>,
        quick: bool,
    ) -> Acted {
        self.let_be();
        // What a hand met on its way down to the table is found already.
        if let Some(met) = self.know_table()?
            && let Some(found) = self.actor.touch_anew(&met)?
        {
            return Ok(self.finds(&found));
        }
        // Where nothing is known yet a quick sweep often does.
        if quick && self.mind.things.is_empty() && self.search.is_none() {
            for hand in hand.map_or(vec![1, 0], |hand| vec![hand]) {
                if let Some(found) = tried(self.actor.explore(hand))?.flatten() {
                    return Ok(self.finds(&found));
                }
                self.settle();
            }
        }
        if !self.begin(hand)? {
            return Ok(Answer::failed(NO_TABLE));
        }
        let before: Vec<ThingId> = self.mind.things.iter().map(|known| known.id).collect();
        while let Some(mut search) = self.search.take() {
            let felt = self.actor.search_on(&mut search)?;
            self.search = Some(search);
            self.take_over();
            let Some(felt) = felt else { break };
            let new = self.mind.things.iter().map(|known| known.id).find(|id| !before.contains(id));
            if let Some(id) = new
                && let Some(found) = self.actor.touch_anew(&felt.found)?
            {
                self.mind.things.felt_again(id, &found);
                self.mind.things.mean(before.is_empty().then_some(id));
                return Ok(self.feels(if before.is_empty() { "something" } else { "something else" }, id));
            }
        }
        self.settle();
        let nothing = match self.mind.things.len() {
            0 => "nothing".to_string(),
            1 => "only the one thing".to_string(),
            count => format!("only the {count} things"),
        };
        let said = format!("I felt around on the table as far as I can reach and found {nothing}");
        Ok(Answer::done(format!("{said}{}", self.unsearched())))
    }

    /// Searches all that it reaches and tells how many things it found: "how many things are there?"
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn count(&mut self, hand: Option<usize>) -> Result<Reply, Error> {
        let answer = self.counted(hand)?;
        Ok(self.reply(Intent::Explore, answer))
    }

    fn counted(&mut self, hand: Option<usize>) -> Result<Answer> {
        if !self.begin(hand)? {
            return Ok(Answer::failed(NO_TABLE));
        }
        if let Some(search) = &mut self.search {
            while self.actor.search_on(search)?.is_some() {}
        }
        self.take_over();
        self.settle();
        Ok(Answer::done(format!("I found {}{}", self.things_in_words(), self.unsearched())))
    }

    /// All things that it knows of, and where they are, in words.
    fn things_in_words(&self) -> String {
        let places: Vec<String> = self.mind.things.iter().map(|known| self.place(&known.at)).collect();
        match places.as_slice() {
            [] => "nothing on the table".to_string(),
            [one] => format!("one thing, {one}"),
            places => format!("{} things: {}", places.len(), places.join("; ")),
        }
    }

    /// It has found the first thing, and keeps touching it.
    fn finds(&mut self, found: &FoundThing) -> Answer {
        let id = self.mind.things.remember(found, Some(found.receptor));
        self.mind.things.mean(Some(id));
        self.feels("something", id)
    }

    /// It feels something and keeps touching it.
    fn feels(&self, something: &str, id: ThingId) -> Answer {
        let said = self.mind.things.get(id).map(|known| {
            let limb = self.limb_in_words(known.found.receptor);
            format!("Yes, I feel {something} with my {limb}, {}", self.place(&known.at))
        });
        Answer::done(said.unwrap_or_default())
    }

    /// Lowers the hands onto the table where it is not known yet: what one of them met above it.
    fn know_table(&mut self) -> Result<Option<FoundThing>> {
        match self.actor.table {
            Some(_) => Ok(None),
            None => Ok(tried(self.actor.find_table())?.flatten()),
        }
    }

    /// Has a search to go on with, anew where the last one is done; whether there is a table.
    fn begin(&mut self, hand: Option<usize>) -> Result<bool> {
        self.let_be();
        if let Some(met) = self.know_table()? {
            self.mind.things.remember(&met, None);
        }
        let again = self.search.take().filter(|search| !search.done || search.only != hand);
        self.search = again.or_else(|| self.actor.begin_search());
        self.search.iter_mut().for_each(|search| search.only = hand);
        Ok(self.search.is_some())
    }

    /// Remembers what the search felt; what it would have felt and did not is forgotten.
    fn take_over(&mut self) {
        let Some(search) = &self.search else { return };
        let felt: Vec<_> = search
            .things()
            .into_iter()
            .filter_map(|thing| Some((search.felt[*thing.touches.last()?].found.clone(), thing.at)))
            .collect();
        self.mind.things.take_over(&felt, |at| search.would_have_felt(at));
    }

    /// What it could not search, in words; nothing where there is no such place.
    fn unsearched(&self) -> String {
        let Some(search) = &self.search else { return String::new() };
        let places = search.unsearched().into_iter().map(|([forward, left], _)| {
            let at = search.map.plane.point([forward, left, 0.0]);
            let behind = |known: &&KnownThing| {
                let apart = known.at - at;
                let flat = apart - self.actor.up * apart.dot(&self.actor.up);
                flat.norm() < BEHIND && known.at.dot(&self.actor.front) < forward
            };
            match self.mind.things.iter().find(behind) {
                Some(known) => format!("behind the one {}", self.place(&known.at)),
                None => self.place(&at),
            }
        });
        let mut places: Vec<String> = places.collect();
        places.dedup();
        if places.is_empty() {
            String::new()
        } else {
            format!("; I could not feel {}", places.join(", nor "))
        }
    }
}
