//! Max learns his body by touch and then acts at a table by what he learned: what a game or an agent framework does.
//!
//! Run with `cargo run --release --example act_at_table`.

use std::path::Path;
use std::sync::Arc;

use bodyschema::babbling::{Babbler, BabblingOptions};
use bodyschema::creature::{Body, JointSelection};
use bodyschema::interaction::{Actor, Conversation, Scene};
use bodyschema::learning::{Input, Learner, SecondOrder};
use bodyschema::mujoco::Model;
use bodyschema::peripersonal::OwnBody;
use bodyschema::record::RecordError;
use bodyschema::skin::skin_of;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Babble and learn; a session that was recorded does as well.
    let joints = JointSelection::default();
    let body = Body::new(Arc::new(Model::from_path("mjcf/max/max.xml")?), &joints)?;
    let skin = skin_of(&body);
    let mut touches = Vec::new();
    let babbler = Babbler::new::<RecordError>(&body, &skin)?;
    babbler.babble(&BabblingOptions { touches: 600, seed: 1, jobs: 2 }, |touch| {
        touches.push(touch.clone());
        Ok::<(), RecordError>(())
    })?;
    let mut learner = SecondOrder::new(&body.creature, &skin, Input::Receptor, 1);
    touches.iter().for_each(|touch| learner.touch(touch));
    let own = OwnBody::new(&body.creature, &skin, learner.learn().schema, &touches, Input::Receptor);

    // From here on he knows of his body what he learned, and of the scene what he feels.
    let scene = Scene::new(Path::new("mjcf/max/table.xml"), &joints, None, &[])?;
    let mut actor = Actor::new(own, scene, ["left_hand", "right_hand"], 1)?;
    let ready = actor.ready();
    actor.place(&ready)?;

    // The tasks themselves: each tells what was felt, or why it could not be done.
    match actor.feel_table(1) {
        Ok(height) => {
            actor.know_table(height);
            println!("the table is {:.1} cm above my hips", 100.0 * height);
        }
        Err(trouble) => println!("no table: {trouble}"),
    }
    match actor.explore(1) {
        Ok(Some(found)) => {
            println!("found something {:.3?} m from my hips", found.point.as_slice());
            match actor.touch(&found, 0, false, 1) {
                Ok(touching) => println!("touched it after {} corrections", touching.corrections),
                Err(trouble) => println!("{trouble}"),
            }
        }
        Ok(None) => println!("nothing there"),
        Err(trouble) => println!("{trouble}"),
    }

    // Or in words.
    let mut conversation = Conversation::new(actor)?;
    for request in ["is there something in front of you?", "how far is it?"] {
        println!("> {request}\n{}", conversation.hear(request)?.said);
    }
    Ok(())
}
