//! What a creature feels, as one JSON object per event: all names, metres, newtons and seconds; points and directions in
//! their limb's frame.

use serde_json::{Value, json};

use crate::senses::{Approach, AuraEvent, SensationSide, TouchEvent};
use crate::simulation::Stage;

/// The object of a touch: `began` as something begins to touch, `sensed` as soon as it is understood. Both carry the same
/// `number`, `self_touch`, and `by`, the name of the body that touches, null in a self-touch.
pub fn event_json(stage: &Stage, time: f64, event: &TouchEvent) -> Value {
    let id = |receptor: usize| &stage.skin().receptors[receptor].id;
    let (number, party, mut told) = match event {
        TouchEvent::Began { number, contact } => {
            let places = contact.spots().map(|spot| {
                let point = stage.skin().receptors[spot.receptor].position.as_slice();
                on_limb(stage, spot.limb, json!({"receptor": id(spot.receptor), "point": point}))
            });
            let places: Vec<Value> = places.collect();
            (number, contact.by, json!({"event": "began", "force": contact.force, "places": places}))
        }
        TouchEvent::Sensed { number, sensation } => {
            let told = json!({
                "event": "sensed",
                "kind": sensation.kind,
                "began": sensation.began,
                "duration": sensation.ended - sensation.began,
                "peak_force": sensation.peak_force,
                "mean_force": sensation.mean_force,
                "sides": sensation.sides.iter().map(|side| side_json(stage, side)).collect::<Vec<_>>(),
            });
            (number, sensation.by, told)
        }
    };
    told["time"] = json!(time);
    told["number"] = json!(number);
    told["self_touch"] = json!(party.own().is_some());
    told["by"] = json!(party.thing().map(|thing| stage.thing_name(thing)));
    told
}

/// The object of an event of the aura: `entered`, where something comes near; `alarm`, where a contact is predicted; `left`.
/// Speeds are below 0 where it recedes.
pub fn aura_event_json(stage: &Stage, time: f64, event: &AuraEvent) -> Value {
    let told = |name: &str, approach: &Approach| {
        let creature = stage.agent().creature();
        let limbs = creature.limbs();
        let contact = approach.contact.as_ref().map(|contact| {
            let ids = contact.receptors.iter().map(|&receptor| &stage.skin().receptors[receptor].id);
            let ids: Vec<_> = ids.collect();
            json!({"limb": limbs[contact.limb], "time_to_contact": contact.seconds, "receptors": ids})
        });
        json!({
            "event": name,
            "aura_limb": creature.aura_limbs().get(approach.aura_limb).map(|aura| &aura.name),
            "limb": limbs[approach.limb],
            "distance": approach.distance,
            "speed": approach.speed,
            "contact": contact,
        })
    };
    let (object, mut told) = match event {
        AuraEvent::Entered(approach) => (approach.object, told("entered", approach)),
        AuraEvent::Alarm(approach) => (approach.object, told("alarm", approach)),
        AuraEvent::Left { object } => (*object, json!({"event": "left"})),
    };
    told["time"] = json!(time);
    told["by"] = json!(stage.thing_name(object));
    told
}

fn side_json(stage: &Stage, side: &SensationSide) -> Value {
    let receptors = side.receptors.iter().map(|(receptor, [first, last])| {
        json!({"receptor": stage.skin().receptors[*receptor].id, "first": first, "last": last})
    });
    let parts = side.limbs.iter().map(|part| {
        let told = json!({
            "first": part.span[0],
            "last": part.span[1],
            "point": part.point.as_slice(),
            "end": part.end.as_slice(),
            "path": part.path,
            "direction": part.direction.as_slice(),
        });
        on_limb(stage, part.limb, told)
    });
    let told = json!({
        "receptors": receptors.collect::<Vec<_>>(),
        "point": side.limbs[0].point.as_slice(),
        "path": side.path,
        "direction": side.limbs[0].direction.as_slice(),
        "speed": side.speed,
        "limbs": parts.collect::<Vec<_>>(),
        "last_limb": stage.agent().creature().limbs()[side.last_limb],
    });
    on_limb(stage, side.limb, told)
}

/// What is told of a limb, with its name and that of its aura.
fn on_limb(stage: &Stage, limb: usize, mut told: Value) -> Value {
    let creature = stage.agent().creature();
    told["limb"] = json!(creature.limbs()[limb]);
    told["aura_limb"] = json!(creature.aura_of(limb).map(|aura| &creature.aura_limbs()[aura].name));
    told
}
