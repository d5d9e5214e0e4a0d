//! "How big is it?", "what shape is it?": from what feeling its shape told; before that from where it was felt, which is little.

use super::super::Conversation;
use super::{Act, Answer, RequestKind};
use crate::interaction::things::KnownShape;
use crate::peripersonal::FeltLength;

/// A length whose deviation is above this is known roughly only, metres.
const ROUGHLY: f64 = 0.005;

pub(super) const HOW_BIG: RequestKind = RequestKind {
    asked: &[
        "how ?very big|large|small|wide|tall|long|high|thick|thin|broad|huge|tiny|deep|bulky",
        "size|sizes|dimensions|dimension|extent|extents|diameter|width|breadth|volume|length|height|girth|measurements|radius|thickness|proportions",
        "be|do THING|SOME ?seem|feel|look ?very|really|quite|rather|fairly|that|a ?all|bit big|bigger|large|larger|small|smaller|huge|tiny|wide|tall|long|thick|narrow|bulky|little",
        "bigger|smaller|larger|taller|wider|longer",
        "what do THING measure",
        "fit in|into ?one|your HAND|BODY",
        "tiny|huge|big|small|large or",
    ],
    past: &[],
    ..RequestKind::new(
        ["tell how big it is", "told how big it is"],
        Act::Tells(|creature, _| Answer::tells(creature.size_in_words())),
    )
};

pub(super) const WHAT_SHAPE: RequestKind = RequestKind {
    told: &["describe THING|SOME|its"],
    asked: &[
        "can|could|might|may THING be SOME",
        "THING be ?more|like|a round|square|flat|rectangular|spherical|cylindrical|cubic|curved|pointed|smooth|oval|angular|sphere|cylinder",
        "shape|shaped|form|outline|geometry|contour|contours|silhouette",
        "be|do THING|SOME ?seem|feel|look|have|got ?any|more|very|rather|quite|like|all|perfectly|to ?a|an|be ?be ?like round|square|flat|rectangular|spherical|cylindrical|cubic|curved|pointed|sharp|smooth|rough|hard|soft|angular|corners|edges|corner|edge|oval|sphere|cylinder|boxy|pointy|cubical|bumpy|elongated|hollow|conical|symmetric|symmetrical|sides|rounded",
        "be THING roundish|squarish",
        "be|do THING|SOME ?seem|feel|look ?more ?like|to ?be a|an|SOME",
        "describe THING|SOME|its",
        "what ?kind|sort|type|manner ?of ?SOME|THING do|be THING|SOME ?look|feel|seem ?like|resemble $",
        "what do THING look|feel|seem|resemble ?like",
        "what .. THING look|feel like",
        "what kind|sort|type of THING|SOME",
        "round|flat|square|pointed|curved|sharp|angular|rounded or|and|nor",
        "more like a|an|SOME",
        "corners|edges|roundness|curved|rounded|angular",
    ],
    past: &["shape"],
    ..RequestKind::new(
        ["tell its shape", "told its shape"],
        Act::Tells(|creature, _| Answer::tells(creature.shape_in_words())),
    )
};

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
