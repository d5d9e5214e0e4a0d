//! Max learns his body by touch and then acts at a table by what he learned: what a game or an agent framework does.
//!
//! Run with `cargo run --release --example act_at_table`.

use std::path::Path;

use bodyschema::{Actor, Agent, Conversation, Stage, StageOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Babble and learn; a session that was recorded does as well.
    let max = Agent::from_mjcf("mjcf/max/max.xml")?.babble(600)?.learn()?;

    // From here on he knows of his body what he learned, and of the table what he feels: where things are stays with the
    // stage, of which he has no more than a handle.
    let stage = Stage::new(Path::new("mjcf/max/table.xml"), &StageOptions::default())?;
    let mut actor = Actor::new(max.own_body(), stage.handle(), ["left_hand", "right_hand"], 1)?;
    stage.place(&actor.ready())?;

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
            match actor.touch(&found, 0, false) {
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
