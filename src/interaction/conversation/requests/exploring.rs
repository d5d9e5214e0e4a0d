//! "Is there something in front of you?": it feels about on the table.

use super::super::Conversation;
use super::{Act, Intent, Reply, RequestKind};
use crate::interaction::conversation::language::Leave;
use crate::interaction::things::{KnownThing, ThingId};
use crate::interaction::{FoundThing, Trouble};
use crate::simulation::{EngineError, EngineResult};

/// What is no farther behind a thing than this is told of as behind it, metres.
const BEHIND: f64 = 0.15;

pub(super) const EXPLORE: RequestKind = RequestKind {
    told: &[
        "explore|search|scan|scour|sweep|comb|probe|survey|examine|check|inspect|feel|grope|fumble|investigate|rummage ?out|through|over|across|along|on|all|around|about|round ?over|across|on|at|all|of ?the|your|this|what ?whole|entire table|tabletop|space|area|surroundings|desk|surface|scene|environment|place|vicinity|top|front|region|room",
        "feel|look|search|grope|fumble|sweep|hunt|probe|cast|scout|explore|move|wave ?HAND|your ?hands ?out ?all around|about|round",
        "look|search|feel|grope|hunt|seek|check|scan|scout|probe|fish ?out|around|about|round|over ?with ?HAND ?on for SOME|THING|more|another",
        "look|search|feel|grope|seek|check ?around|about ?with ?HAND SOME",
        "see|check|find|test|feel|learn|determine|verify|look ?out if|whether|what ?THING|SOME|there|you ?be",
        "reach ?out ?HAND ?over|out|around ?for|to|into|toward ?find SOME",
        "reach|stretch ?out ?your|HAND ?out|forward|ahead|forth $",
        "sweep|run|move|slide|pass|swing|swipe|wave|glide|drag|pat ?your HAND ?slowly|all|back|gently ?and|over ?forth over|across|along|about|around|on|through|above ?the|top ?of ?the table|tabletop|surface|desk",
        "touch|grab|get|take SOME",
        "explore|search|sweep $",
        "go|run|pass|move|feel ?HAND over|along|across|around ?the table|tabletop|desk|surface",
        "look|search ?around ?once again|more",
        "find|discover|see|check|learn|feel|look ?out what|whatever be ?=lying|=standing in|on|before|around|there|out|here",
        "find|work out what be ?there|here|on|in|around|before",
        "what else",
        "find|locate|seek|discover THING",
        "run|bump|come|stumble ?up into|across|upon|against SOME",
        "have|take a ?good|quick ?look feel|search|rummage|look around|about|round|for",
        "get to know your|the surroundings|table|space|environment",
        "^ explore|search",
        "keep =looking|=searching|=exploring|=feeling",
        "tell|show ?me what|whether ?SOME be on|in|there",
    ],
    needs_body: true,
    ..RequestKind::new(
        ["feel about for things", "felt about for things"],
        Act::Moves(|creature, request, leave| {
            let hand = creature.hand_for(request.hand);
            if request.all { creature.count(hand) } else { creature.explore(hand, true, leave) }
        }),
    )
};

impl Conversation {
    /// Feels about until something is felt that it does not know yet, and keeps touching it: "is there something?",
    /// "anything else?" Where it need not be the nearest, `quick` lets it sweep first.
    pub(in crate::interaction::conversation) fn explore(
        &mut self,
        hand: Option<usize>,
        quick: bool,
        _leave: &Leave,
    ) -> Result<Reply, EngineError> {
        self.let_be();
        // What a hand met on its way down to the table is found already.
        if let Some(met) = self.know_table()?
            && let Some(found) = self.actor.touch_anew(&met)?
        {
            return Ok(self.finds(&found));
        }
        // Where nothing is known yet a quick sweep often does.
        if quick
            && self.things.is_empty()
            && self.search.is_none()
            && let Some(found) = self.sweep(hand)?
        {
            return Ok(self.finds(&found));
        }
        if !self.begin(hand)? {
            return Ok(self.no_table());
        }
        let before: Vec<ThingId> = self.things.iter().map(|known| known.id).collect();
        while let Some(mut search) = self.search.take() {
            let felt = self.actor.search_on(&mut search)?;
            self.search = Some(search);
            self.take_over();
            let Some(felt) = felt else { break };
            let new = self.things.iter().map(|known| known.id).find(|id| !before.contains(id));
            if let Some(id) = new
                && let Some(found) = self.actor.touch_anew(&felt.found)?
            {
                self.things.felt_again(id, &found);
                self.things.mean(before.is_empty().then_some(id));
                return Ok(self.feels(if before.is_empty() { "something" } else { "something else" }, id));
            }
        }
        self.settle_at_ready();
        let said = match self.things.len() {
            0 => "I felt about on the table as far as I reach and found nothing".to_string(),
            1 => "I felt about as far as I reach and found nothing but the one thing".to_string(),
            count => format!("I felt about as far as I reach and found nothing but the {count} things"),
        };
        let said = format!("{said}{}", self.unsearched());
        self.does(Intent::Explore, said)
    }

    /// Searches all that it reaches and tells how many things it found: "how many things are there?"
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn count(&mut self, hand: Option<usize>) -> Result<Reply, EngineError> {
        if !self.begin(hand)? {
            return Ok(self.no_table());
        }
        if let Some(mut search) = self.search.take() {
            while self.actor.search_on(&mut search)?.is_some() {}
            self.search = Some(search);
        }
        self.take_over();
        self.settle_at_ready();
        let places: Vec<String> = self.things.iter().map(|known| self.place(&known.at)).collect();
        let said = match places.len() {
            0 => "I found nothing on the table as far as I reach".to_string(),
            1 => format!("I found one thing, {}", places.join("; ")),
            count => format!("I found {count} things: {}", places.join("; ")),
        };
        let said = format!("{said}{}", self.unsearched());
        self.does(Intent::Explore, said)
    }

    /// It has found the first thing, and keeps touching it.
    fn finds(&mut self, found: &FoundThing) -> Reply {
        let id = self.things.remember(found, Some(found.receptor));
        self.things.mean(Some(id));
        self.feels("something", id)
    }

    /// It feels something and keeps touching it.
    fn feels(&self, something: &str, id: ThingId) -> Reply {
        let known = self.things.get(id);
        let said = known.map(|known| {
            let limb = self.limb_in_words(known.found.receptor);
            format!("Yes, I feel {something} with my {limb}, {}", self.place(&known.at))
        });
        self.reply(Intent::Explore, said.unwrap_or_default(), Some(true), false)
    }

    /// Sweeps the table with one hand, or with one after the other, until something is felt.
    fn sweep(&mut self, hand: Option<usize>) -> EngineResult<Option<FoundThing>> {
        let hands = hand.map_or(vec![1, 0], |hand| vec![hand]);
        for hand in hands {
            match self.actor.explore(hand) {
                Ok(Some(found)) => return Ok(Some(found)),
                Err(Trouble::Engine(error)) => return Err(error),
                Ok(None) | Err(_) => {
                    self.settle_at_ready();
                }
            }
        }
        Ok(None)
    }

    /// Lowers the hands onto the table where it is not known yet, and remembers what one of them met above it.
    fn know_table(&mut self) -> EngineResult<Option<FoundThing>> {
        if self.actor.table.is_some() {
            return Ok(None);
        }
        match self.actor.find_table() {
            Err(Trouble::Engine(error)) => Err(error),
            found => Ok(found.ok().flatten()),
        }
    }

    /// Has a search to go on with, anew where the last one is done; whether there is a table.
    fn begin(&mut self, hand: Option<usize>) -> EngineResult<bool> {
        self.let_be();
        if let Some(met) = self.know_table()? {
            self.things.remember(&met, None);
        }
        let again = self.search.take().filter(|search| !search.done || search.only != hand);
        self.search = match again {
            Some(search) => Some(search),
            None => self.actor.begin_search(),
        };
        if let Some(search) = &mut self.search {
            search.only = hand;
        }
        Ok(self.search.is_some())
    }

    fn no_table(&self) -> Reply {
        let said = "I lowered my hands and felt no table in front of me".to_string();
        self.reply(Intent::Explore, said, Some(false), false)
    }

    /// Remembers what the search felt; what it would have felt and did not is forgotten.
    fn take_over(&mut self) {
        let Some(search) = &self.search else { return };
        let felt: Vec<_> = search
            .things()
            .into_iter()
            .filter_map(|thing| Some((search.felt[*thing.touches.last()?].found.clone(), thing.at)))
            .collect();
        self.things.take_over(&felt, |at| search.would_have_felt(at));
    }

    /// What it has not searched, or could not, in words; nothing where it knows all of the table that it reaches.
    pub(super) fn not_searched(&self) -> String {
        match &self.search {
            Some(search) if search.done => self.unsearched(),
            _ => "; I have not searched all of the table".to_string(),
        }
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
            match self.things.iter().find(behind) {
                Some(known) if self.things.len() > 1 => {
                    format!("behind the one {}", self.place(&known.at))
                }
                Some(_) => "behind it".to_string(),
                None => self.place(&at),
            }
        });
        let mut places: Vec<String> = places.collect();
        places.dedup();
        match places.as_slice() {
            [] => String::new(),
            places => format!("; I could not feel {}", places.join(", nor ")),
        }
    }
}
