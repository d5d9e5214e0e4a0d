//! "Keep still."

use super::{Act, Answer, RequestKind};

/// What says so as a prohibition.
pub(in super::super) const STILL: &[&str] = &[
    "not a|one|another move|muscle|inch|step",
    "not|never ?even ?ever ?dare ?to move|budge|stir|twitch|wiggle|wriggle|fidget|shift at|now|yet|until|again|anymore|from|BODY|yourself|while|so",
    "not|never ?you ?even ?ever ?dare ?to move|budge|stir|twitch|wriggle|fidget|shift $",
    "without =moving",
    "no =moving|movement|movements|motion|motions",
    "stop|quit|cease =moving|=fidgeting|=wriggling",
    "=move not",
    "not|nothing move $",
    "do nothing $",
    "^ nobody move|moves",
    "do not do SOME|anything $",
    "not move|twitch|stir|budge ?even a|an|any muscle|inch|bit|finger",
];

pub(super) const KEEP_STILL: RequestKind = RequestKind {
    told: &[
        "keep|hold|stay|stand|remain|sit|be|lie ?BODY|yourself|THING|completely|absolutely|perfectly|all|very|as ?perfectly still|motionless|immobile|put|frozen|quiet|steady|unmoving|stationary|fixed",
        "stay|remain|stop|hold|keep|wait|halt right|exactly|precisely ?right where|there|here|as|like",
        "stay|remain|stop|hold|keep|wait|halt where|there|here",
        "stay|remain|hold|keep as|like you|THING",
        "freeze",
        "^ stay|still $",
        "stay|remain|hold|keep in|your|that|this|the ?same|present|current ?same|current place|position|posture|pose",
        "^ hold ?THING|it right there|still",
        "hold|keep ?your ground|horses",
        "play|be|like|as ?a dead|statue|rock|stone",
        "rest motionless|still",
        "from =moving",
        "stay BODY",
        "keep|leave|hold BODY|yourself ?just|right where they|it|THING|you be",
    ],
    asked: &["can|could|would|will you stay|keep|hold|stand ?perfectly still|there|put"],
    ..RequestKind::new(
        ["keep still", "kept still"],
        Act::Minds(|mind, _| {
            *mind.still = true;
            Answer::does("I keep still until you ask me to do something", true)
        }),
    )
};
