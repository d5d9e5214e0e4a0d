//! "Keep still."

use super::{Act, Answer, RequestKind};

pub(super) const KEEP_STILL: RequestKind = RequestKind::new(
    ["keep still", "kept still"],
    Act::Minds(|mind, _| {
        *mind.still = true;
        Answer::done("I keep still until you ask me to do something")
    }),
)
.told(
    "^ KEEP|LOOK ?BODY|yourself|THING ?all ?as STILL ; ^ KEEP ?right where|there|as|like ?you|THING ; \
         STOP|KEEP ?right where|there ; ^ freeze ; ^ stay|still $ ; \
         ^ stay|remain|keep|hold ?in your|that|this|the|same ?same|present|current POSE ; \
         keep|hold ?your ground ; ^ statue $ ; play|be|like|as dead|statue|rock|stone ; \
         rest motionless|still ; from =moving ; BODY stay|remain|keep ?right STILL|where|there ; \
         KEEP BODY|yourself ?right where|as they|THING|you be ; stay|remain BODY ; \
         ^ hold ?THING ?right there|still ; ^ be STILL ; hold that|THING|your POSE ; ^ =hold =it $ ; \
         stand by ; no|not ?any ?MORE movement|movements|motion ; KEEP in ?your|that|this|same POSE ; \
         KEEP ?in POSE $",
)
.denied(
    "not a|one|another move|muscle|inch|step|MORE ; not|never ?you ?even ?ever ?dare ?to STIR !THING ; \
         without =moving ; no =moving|movement|movements|motion|motions ; \
         STOP|cease =moving|=fidgeting|=wriggling ; =move not ; nothing move $ ; do nothing $ ; \
         not STIR $ ; no =moving ; no|not ?any movement|movements|=moving ; \
         not STIR at|now|until|again|from|BODY|yourself|while|so|a|an|any ; nobody move ; \
         not go|get anywhere ; no|quit|stop|STOP =fidgeting|=moving|=wriggling|=squirming|fidget|STIR",
);
