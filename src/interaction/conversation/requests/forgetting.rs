//! "Forget it", "forget everything you felt".

use super::{Act, Answer, RequestKind};

pub(super) const FORGET: RequestKind = RequestKind {
    told: &[
        "forget|erase|unlearn|delete|disregard|discard|purge",
        "clear|clean|empty|wipe|reset|flush|scrub ?out your|the|its|all ?whole|entire ?memory|mind|memories|head|slate|history|knowledge|record|list",
        "clear|wipe|strike|remove|drop|put|get|banish|dismiss|lose THING|SOME|everything|all ?all ?of ?it ?out from|of ?your memory|mind|head|memories|thoughts|list",
        "wipe THING|everything",
        "clear|wipe|erase|delete|drop what|whatever|everything ?that ?it you remember|know|felt|feel|learn",
        "fresh start|beginning",
        "start all|afresh|anew|over ?again ?afresh $",
        "from scratch",
        "^ reset $",
        "remember nothing",
        "clean slate",
        "let THING slip",
        "no longer|not remember",
        "as if|though .. never",
        "ignore THING|everything|all",
    ],
    ..RequestKind::new(
        ["forget it", "forgot it"],
        Act::Minds(|mind, request| {
            let one = mind.find(request.which).or(mind.things.it());
            let one = one.map(|known| (known.id, mind.place(known)));
            match one.filter(|_| !request.all) {
                _ if mind.things.is_empty() => {
                    Answer::does("There is nothing that I have felt and could forget", true)
                }
                Some((id, place)) => {
                    mind.forget(id);
                    Answer::does(format!("I have forgotten the thing {place}"), true)
                }
                None if request.all => {
                    mind.forget_all();
                    Answer::does("I have forgotten all that I felt of things", true)
                }
                None => Answer { said: mind.question(), done: None, asks: true },
            }
        }),
    )
};
