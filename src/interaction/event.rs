//! What the creature feels, as one JSON object per event.

use serde_json::{Value, json};

use super::world::World;
use crate::senses::touch_sensor::{Place, Side};
use crate::senses::{Approach, AuraEvent, Sensation, TouchEvent};

/// The object that tells an event: all names, metres, newtons and seconds; points and directions in their limb's
/// frame.
///
/// `began` tells where something begins to touch, as it does; `sensed` what it was, as soon as it is understood.
/// Both carry the same `number`, `self_touch`, and `by`, the name of the body that touches, null in a self-touch.
pub fn event_json(world: &World, time: f64, event: &TouchEvent) -> Value {
    match event {
        TouchEvent::Began { number, contact } => {
            let places: Vec<Value> = contact.places().map(|place| place_json(world, &place)).collect();
            json!({
                "event": "began",
                "time": time,
                "number": number,
                "self_touch": contact.object.is_none(),
                "by": by(world, contact.object),
                "force": contact.force,
                "places": places,
            })
        }
        TouchEvent::Sensed { number, sensation } => sensation_json(world, time, *number, sensation),
    }
}

/// The object that tells an event of the aura: `entered`, where something comes near; `alarm`, where a contact is
/// foreseen; `left`. Distances are metres, speeds metres a second (below 0 where it recedes), times seconds.
pub fn aura_event_json(world: &World, time: f64, event: &AuraEvent) -> Value {
    let told = |name: &str, approach: &Approach| {
        let creature = &world.body.creature;
        let limbs = creature.limbs();
        let contact = approach.contact.as_ref().map(|contact| {
            let ids = contact.receptors.iter().map(|&receptor| &world.skin.receptors[receptor].id);
            json!({
                "limb": limbs[contact.limb],
                "time_to_contact": contact.seconds,
                "receptors": ids.collect::<Vec<_>>(),
            })
        });
        json!({
            "event": name,
            "time": time,
            "by": by(world, Some(approach.object)),
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
        AuraEvent::Left { object } => json!({"event": "left", "time": time, "by": by(world, Some(*object))}),
    }
}

fn sensation_json(world: &World, time: f64, number: u64, sensation: &Sensation) -> Value {
    json!({
        "event": "sensed",
        "time": time,
        "number": number,
        "kind": sensation.kind,
        "self_touch": sensation.object.is_none(),
        "by": by(world, sensation.object),
        "began": sensation.began,
        "duration": sensation.ended - sensation.began,
        "peak_force": sensation.peak_force,
        "mean_force": sensation.mean_force,
        "sides": sensation.sides.iter().map(|side| side_json(world, side)).collect::<Vec<_>>(),
    })
}

/// The name of the body that touches; none for a self-touch.
fn by(world: &World, object: Option<usize>) -> Option<String> {
    object.map(|body| crate::creature::body_name(&world.body.model, body))
}

fn limb_json(world: &World, limb: usize) -> Value {
    let creature = &world.body.creature;
    let aura = creature.aura_of(limb).map(|aura| &creature.aura_limbs()[aura].name);
    json!({"limb": creature.limbs()[limb], "aura_limb": aura})
}

fn place_json(world: &World, place: &Place) -> Value {
    let mut told = limb_json(world, place.limb);
    told["receptor"] = json!(world.skin.receptors[place.receptor].id);
    told["point"] = json!(place.point.as_slice());
    told
}

fn side_json(world: &World, side: &Side) -> Value {
    let mut told = limb_json(world, side.limb);
    told["receptors"] = side
        .receptors
        .iter()
        .map(|(receptor, [first, last])| {
            json!({"receptor": world.skin.receptors[*receptor].id, "first": first, "last": last})
        })
        .collect();
    told["point"] = json!(side.point.as_slice());
    told["path"] = json!(side.path);
    told["direction"] = json!(side.direction.as_slice());
    told["speed"] = json!(side.speed);
    told
}
