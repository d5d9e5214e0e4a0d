//! What the creature feels, as one JSON object per event.

use serde_json::{Value, json};

use crate::senses::{
    Approach, AuraEvent, LimbSensation, Party, Sensation, SensationSide, SkinSpot, TouchEvent,
};
use crate::simulation::Stage;

/// The object that tells an event: all names, metres, newtons and seconds; points and directions in their limb's
/// frame.
///
/// `began` tells where something begins to touch, as it does; `sensed` what it was, as soon as it is understood.
/// Both carry the same `number`, `self_touch`, and `by`, the name of the body that touches, null in a self-touch.
pub fn event_json(stage: &Stage, time: f64, event: &TouchEvent) -> Value {
    match event {
        TouchEvent::Began { number, contact } => {
            let places: Vec<Value> = contact.spots().map(|spot| spot_json(stage, &spot)).collect();
            json!({
                "event": "began",
                "time": time,
                "number": number,
                "self_touch": contact.by.party() == Party::Own,
                "by": by(stage, contact.by.party().thing()),
                "force": contact.force,
                "places": places,
            })
        }
        TouchEvent::Sensed { number, sensation } => sensation_json(stage, time, *number, sensation),
    }
}

/// The object that tells an event of the aura: `entered`, where something comes near; `alarm`, where a contact is
/// predicted; `left`. Distances are metres, speeds metres a second (below 0 where it recedes), times seconds.
pub fn aura_event_json(stage: &Stage, time: f64, event: &AuraEvent) -> Value {
    let told = |name: &str, approach: &Approach| {
        let creature = stage.agent().creature();
        let limbs = creature.limbs();
        let contact = approach.contact.as_ref().map(|contact| {
            let ids = contact.receptors.iter().map(|&receptor| &stage.skin().receptors[receptor].id);
            json!({
                "limb": limbs[contact.limb],
                "time_to_contact": contact.seconds,
                "receptors": ids.collect::<Vec<_>>(),
            })
        });
        json!({
            "event": name,
            "time": time,
            "by": by(stage, Some(approach.object)),
            "aura_limb": creature.aura_limbs().get(approach.aura_limb).map(|aura| &aura.name),
            "limb": limbs[approach.limb],
            "distance": approach.distance,
            "speed": approach.speed,
            "contact": contact,
        })
    };
    match event {
        AuraEvent::Entered(approach) => told("entered", approach),
        AuraEvent::Alarm(approach) => told("alarm", approach),
        AuraEvent::Left { object } => json!({"event": "left", "time": time, "by": by(stage, Some(*object))}),
    }
}

fn sensation_json(stage: &Stage, time: f64, number: u64, sensation: &Sensation) -> Value {
    json!({
        "event": "sensed",
        "time": time,
        "number": number,
        "kind": sensation.kind,
        "self_touch": sensation.by == Party::Own,
        "by": by(stage, sensation.by.thing()),
        "began": sensation.began,
        "duration": sensation.ended - sensation.began,
        "peak_force": sensation.peak_force,
        "mean_force": sensation.mean_force,
        "sides": sensation.sides.iter().map(|side| side_json(stage, side)).collect::<Vec<_>>(),
    })
}

/// The name of the body that touches; none for a self-touch.
fn by(stage: &Stage, object: Option<usize>) -> Option<String> {
    object.map(|body| stage.thing_name(body))
}

fn limb_json(stage: &Stage, limb: usize) -> Value {
    let creature = stage.agent().creature();
    let aura = creature.aura_of(limb).map(|aura| &creature.aura_limbs()[aura].name);
    json!({"limb": creature.limbs()[limb], "aura_limb": aura})
}

fn spot_json(stage: &Stage, spot: &SkinSpot) -> Value {
    let mut told = limb_json(stage, spot.limb);
    let receptor = &stage.skin().receptors[spot.receptor];
    told["receptor"] = json!(receptor.id);
    told["point"] = json!(receptor.position.as_slice());
    told
}

fn side_json(stage: &Stage, side: &SensationSide) -> Value {
    let mut told = limb_json(stage, side.limb);
    told["receptors"] = side
        .receptors
        .iter()
        .map(|(receptor, [first, last])| {
            json!({"receptor": stage.skin().receptors[*receptor].id, "first": first, "last": last})
        })
        .collect();
    told["point"] = json!(side.limbs[0].point.as_slice());
    told["path"] = json!(side.path);
    told["direction"] = json!(side.limbs[0].direction.as_slice());
    told["speed"] = json!(side.speed);
    told["limbs"] = side.limbs.iter().map(|part| part_json(stage, part)).collect();
    told["last_limb"] = json!(stage.agent().creature().limbs()[side.last_limb]);
    told
}

fn part_json(stage: &Stage, part: &LimbSensation) -> Value {
    let mut told = limb_json(stage, part.limb);
    told["first"] = json!(part.span[0]);
    told["last"] = json!(part.span[1]);
    told["point"] = json!(part.point.as_slice());
    told["end"] = json!(part.end.as_slice());
    told["path"] = json!(part.path);
    told["direction"] = json!(part.direction.as_slice());
    told
}
