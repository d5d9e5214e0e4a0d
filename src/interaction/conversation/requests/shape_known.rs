//! "How big is it?", "what shape is it?": from what feeling its shape told; before that from where it was felt, which is little.

use super::super::Conversation;
use super::{Act, Answer, RequestKind};
use crate::interaction::things::KnownShape;
use crate::peripersonal::FeltLength;

/// A length whose deviation is above this is known roughly only, metres.
const ROUGHLY: f64 = 0.005;

pub(super) const HOW_BIG: RequestKind = RequestKind::new(
    ["tell how big it is", "told how big it is"],
    Act::Tells(|creature, _| Answer::tells(creature.size_in_words())),
)
.asked(
    "how ?SIZED SIZED ; how SIZED .. THING ; as SIZED as ; how SIZED do THING FEEL|look|seem ; \
         TELL|give ?me ?about ?its SIZE ; SIZE ; \
         be|do THING|SOME ?seem|feel|look|appear ?that|ALL|BIT SIZED ; \
         bigger|smaller|larger|taller|wider|longer|higher ?or|than ; \
         bigger|smaller|larger|taller|wider|longer than ; what do THING measure ; \
         fit in|into|inside|between ?one|your HAND|BODY ; SIZED or SIZED ; what SIZE ; SIZE of THING ; \
         idea how SIZED ; THING ?be SIZED ; measure THING ; be THING SOME & SIZED ; how SIZED ?be|do ; \
         how much space|room .. take|have ; UNIT SIZED ; how many UNIT SIZED ; what .. SIZE ; \
         how SIZED .. be ; small|big|large enough",
)
.past("how SIZED ; SIZE");

pub(super) const WHAT_SHAPE: RequestKind = RequestKind::new(
    ["tell its shape", "told its shape"],
    Act::Tells(|creature, _| Answer::tells(creature.shape_in_words())),
)
.told("describe THING|SOME|its ; TELL ?me ?about its|the FORM")
.asked(
    "HELPING THING be SOME ; THING ?be ?MORE|like SHAPED ; FORM ; what ?be FORM ; \
         be|do THING|SOME|they ?seem|feel|look|have|got|get ?any|MORE|like|ALL|to ?be ?be ?like SHAPED ; \
         be|do THING|SOME ?seem|feel|look ?MORE ?like|to ?be SOME ; describe THING|SOME|its ; \
         what ?KIND ?of ?SOME|THING do|be|HELPING THING|SOME ?look|feel|seem|be ?like|resemble ; \
         what .. THING look|feel ?like ; what KIND of THING|SOME ?be|have|do ; SHAPED or|and|nor SHAPED ; \
         any SHAPED|EDGE ON ; THING have SHAPED|EDGE ; be there any SHAPED|EDGE ; MORE like a|an|SOME ; \
         SOME or SOME ; call THING SHAPED ; what be THING $ ; what FORM ; \
         have THING ?get|any SHAPED|EDGE|a ; what do THING ?look|seem ; be THING SOME ; \
         what could|might THING be ; SHAPED or ; recognise|recognize|identify THING ; what THING|that be ; \
         what be THING|this|that ; be|do ?its side|sides|top|edges|surface SHAPED ; \
         what ?HELPING you TELL|say|KNOW ?me about|of THING|its ; how do THING FEEL ; \
         how HELPING you describe|call THING|its ; THING SHAPED ; how be THING SHAPED ; any SHAPED ; \
         THING be .. SHAPED ; description ; how be THING FORM ; how do THING FEEL|look|seem ; \
         what have ?you ?we get|=got there|here ; impression of ; what HELPING you call THING ; \
         what do you make of THING ; how many side|sides|corners|edges|faces ; what you think THING be ; \
         make out ?its FORM",
)
.past("FORM ; SHAPED ; what KIND");

impl Conversation {
    /// What it may say of the size of the thing of which they talk.
    fn size_in_words(&self) -> String {
        self.felt_in_words("how big it is")
    }

    /// What it may say of its shape.
    pub(super) fn shape_in_words(&self) -> String {
        self.felt_in_words("its shape")
    }

    fn felt_in_words(&self, what: &str) -> String {
        let Some(known) = self.things.it() else {
            return match self.things.is_empty() {
                true => "I have not felt anything yet".into(),
                false => self.question(),
            };
        };
        if let Some(shape) = &known.shape {
            return said_of(shape);
        }
        let places = self.felt_places(known);
        let apart =
            places.iter().enumerate().flat_map(|(k, a)| places.iter().take(k).map(move |b| (a - b).norm()));
        let widest = apart.fold(0.0, f64::max);
        match places.len() {
            0 | 1 => {
                format!("I have felt it at one place only, so I cannot tell {what}: ask me to feel its shape")
            }
            n => format!(
                "I have felt it at {n} places, at most {:.0} cm apart: so wide it is at least, more I do not know of {what}",
                100.0 * widest
            ),
        }
    }
}

/// What it may say of a shape that it has felt: how large it is, and where it could not feel it. What kind of thing that is
/// touches do not tell for certain.
fn said_of(shape: &KnownShape) -> String {
    let told = |felt: &FeltLength| {
        let about = if felt.deviation > ROUGHLY { "roughly" } else { "about" };
        format!("{about} {:.0} cm", 100.0 * felt.length)
    };
    let size = &shape.size;
    let mut said = format!(
        "I have touched it {} times: it is {} high, {} long and {} wide; what kind of thing it is I am not sure",
        shape.touches,
        told(&size.height),
        told(&size.length),
        told(&size.breadth)
    );
    if !shape.unfelt.is_empty() {
        said += &format!(". I could not feel it well {}", shape.unfelt.join(", nor "));
    }
    said
}
