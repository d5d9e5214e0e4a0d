//! `bodyschema inspect`: what the agent is given.

use std::path::PathBuf;
use std::sync::Arc;

use serde_json::json;

use super::Outcome;
use super::open::{ModelArguments, read_model};
use super::progress::Bars;
use super::{output, progress};
use crate::creature::{Creature, CreatureInFile, Dof, JointSelection, creatures};
use crate::geometry::Frame;
use crate::model_files::LeftOut;
use crate::senses::{JointSensor, joint_sensors, posture_in_words};
use crate::session::skin_for;
use crate::simulation::{LimbPair, Relation, SelfContact};
use crate::skin::{ProximityGeometry, Skin, SomatotopicMap, aura_of};

/// Tell a model's tree, degrees of freedom, limbs and receptors.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema inspect mjcf/max/max.xml
  bodyschema inspect mjcf/max/max.xml --json")]
pub struct InspectArguments {
    /// The MJCF or URDF file of a creature
    model: PathBuf,
    #[command(flatten)]
    open: ModelArguments,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

pub fn run(args: &InspectArguments) -> Outcome {
    let spinner = progress::spinner("looking at the model");
    let source = |joints| args.open.source(&args.model, joints);
    let (model, left_out) = read_model(&args.model)?;
    let model = Arc::new(model);
    let open = |joints| source(joints).body_in(model.clone());
    let (body, learned) = (open(JointSelection::All)?, open(JointSelection::Default)?);
    let contact = SelfContact::new(&learned)?;
    let (skin, own) = skin_for(&args.model, &body, &Bars::default())?;
    let frames = body.limb_frames(&body.reference_data()?);
    let map = SomatotopicMap::new(&body.creature, &skin, std::slice::from_ref(&frames));
    let auras = aura_of(&body, &skin, &frames);
    let neighbours = Neighbours::new(&skin, &map);
    let sensors = joint_sensors(&body);
    spinner.finish_and_clear();
    let creature = &body.creature;
    let in_file = creatures(&model);
    let constraints = body.constraints_not_heeded() + left_out.unheeded;
    // Per limb its receptors, and those of them that were grown.
    let mut by_limb: Vec<(String, usize, usize)> =
        creature.aura_limbs().iter().map(|a| (a.name.clone(), 0, 0)).collect();
    for (number, receptor) in skin.receptors.iter().enumerate() {
        if let Some(aura) = creature.aura_of(receptor.limb) {
            by_limb[aura].1 += 1;
            by_limb[aura].2 += usize::from(number >= own);
        }
    }
    if args.json {
        let receptors_by_limb: serde_json::Map<String, serde_json::Value> =
            by_limb.iter().map(|(name, count, _)| (name.clone(), json!(count))).collect();
        return output::json(&json!({
            "model": args.model,
            "creature": creature.name(),
            "engine": body.model.version().to_string(),
            "creatures": in_file.iter().map(|creature| json!({
                "root": creature.name,
                "joints": creature.joints,
            })).collect::<Vec<_>>(),
            "left_out": json!({
                "lost": left_out.lost,
                "unneeded": left_out.unneeded,
                "notes": left_out.notes,
            }),
            "joints": creature.joints().len(),
            "dof": creature.dof(),
            "torso_joints": learned.creature.joints().len(),
            "torso_dof": learned.creature.dof(),
            "limbs": creature.limbs().len(),
            "aura_limbs": creature.aura_limbs().len(),
            "auras": auras.iter().map(|aura| json!({
                "aura_limb": creature.aura_limbs()[aura.aura_limb].name,
                "limb": creature.limbs()[aura.limb],
                "ends": aura.capsule.ends,
                "radius": aura.capsule.radius,
                "reach": aura.reach(creature, &skin, &frames),
                "of_model": aura.of_model,
            })).collect::<Vec<_>>(),
            "receptors": skin.receptors.len(),
            "receptors_by_limb": receptors_by_limb,
            "receptors_grown": skin.receptors.len() - own,
            "neighbours_mean": neighbours.mean,
            "neighbours_none": neighbours.none,
            "links_across_limbs": neighbours.across,
            "neighbours": (0..skin.receptors.len()).map(|r| {
                let ids: Vec<&String> = map.neighbours(r).iter().map(|&n| &skin.receptors[n].id).collect();
                (skin.receptors[r].id.clone(), json!(ids))
            }).collect::<serde_json::Map<String, serde_json::Value>>(),
            "joint_sensors": sensors_json(creature, &sensors),
            "constraints_not_heeded": constraints,
            "limb_pairs": contact.pairs.iter().map(|pair| json!({
                "limbs": pair.limbs.map(|limb| &learned.creature.limbs()[limb]),
                "relation": pair.relation,
                "switched_on": pair.switched_on,
                "geom_pairs_left_out": pair.left_out,
                "meeting": pair.meeting,
            })).collect::<Vec<_>>(),
            "tree": creature.joints().iter().enumerate().map(|(j, joint)| json!({
                "joint": joint.name,
                "parent": creature.limbs()[joint.parent],
                "limb": creature.limbs()[j + 1],
                "dofs": joint.dofs,
            })).collect::<Vec<_>>(),
        }));
    }
    say!(
        "{}: {} joints, {} degrees of freedom, {} limbs in {} aura limbs, {} receptors",
        creature.name(),
        creature.joints().len(),
        creature.dof(),
        creature.limbs().len(),
        creature.aura_limbs().len(),
        skin.receptors.len()
    );
    say!(
        "learned by default: {} joints, {} degrees of freedom\n",
        learned.creature.joints().len(),
        learned.creature.dof()
    );
    print_file(&in_file, &left_out);
    print_tree(creature, &learned.creature, 0, 0);
    say!("\n{}", posture_in_words(&sensors));
    if constraints > 0 {
        say!("\n{constraints} constraints that close the tree or couple tendons are not heeded");
    }
    print_contact(&learned.creature, &contact);
    say!("\n{:<24} {:>9} {:>14}", "aura limb", "receptors", "of these grown");
    for (name, count, grown) in &by_limb {
        say!("{name:<24} {count:>9} {grown:>14}");
    }
    if skin.receptors.is_empty() {
        say!("\nno touch sensors: grow a skin with `bodyschema skin {} --out NEW`", args.model.display());
    } else {
        print_auras(creature, &skin, &frames, &auras);
        let Neighbours { mean, none, across, pairs } = neighbours;
        say!(
            "\neach receptor has {mean:.1} neighbours on average, {} have none; {across} of {pairs} links are across limbs",
            none.len()
        );
        say!("to see them: bodyschema view {}", args.model.display());
    }
    Ok(())
}

/// The somatotopic map in numbers.
struct Neighbours {
    mean: f64,
    /// Ids of receptors without any.
    none: Vec<String>,
    /// Pairs on two limbs, and pairs in all.
    across: usize,
    pairs: usize,
}

impl Neighbours {
    fn new(skin: &Skin, map: &SomatotopicMap) -> Neighbours {
        let receptors = &skin.receptors;
        let alone = (0..receptors.len()).filter(|&r| map.neighbours(r).is_empty());
        let across = map.pairs().filter(|&[a, b]| receptors[a].limb != receptors[b].limb).count();
        let pairs = map.pairs().count();
        Neighbours {
            mean: 2.0 * pairs as f64 / receptors.len().max(1) as f64,
            none: alone.map(|r| receptors[r].id.clone()).collect(),
            across,
            pairs,
        }
    }
}

/// The geometries of the aura: capsules, their length without the round ends.
fn print_auras(creature: &Creature, skin: &Skin, frames: &[Frame], auras: &[ProximityGeometry]) {
    say!("\n{:<24} {:>9} {:>9} {:>8}  {:<10}", "aura", "radius, m", "length, m", "reach, m", "from");
    for aura in auras {
        let length = (aura.capsule.ends[1] - aura.capsule.ends[0]).norm();
        let reach = aura.reach(creature, skin, frames).unwrap_or(f64::NAN);
        let from = if aura.of_model { "the model" } else { "grown here" };
        say!("{:<24} {:>9.3} {length:>9.3} {reach:>8.3}  {from:<10}", aura.name, aura.capsule.radius);
    }
}

/// The creatures of the file where it holds several, and what was left out of it.
fn print_file(creatures: &[CreatureInFile], left_out: &LeftOut) {
    if creatures.len() > 1 {
        say!("{:<48} {:>6}", "creatures in the file, for --root", "joints");
        creatures.iter().for_each(|creature| say!("{:<48} {:>6}", creature.name, creature.joints));
        say!("");
    }
    let parts = [("lost", &left_out.lost), ("not needed", &left_out.unneeded)];
    if !left_out.is_empty() {
        say!("{:<60} {:>6}", "left out of what this MuJoCo does not take as it is", "times");
        for (kind, parts) in parts {
            parts.iter().for_each(|(what, count)| say!("{:<60} {count:>6}", format!("{kind}: {what}")));
        }
        say!("");
    }
    if !left_out.notes.is_empty() {
        left_out.notes.iter().for_each(|note| say!("note: {note}"));
        say!("");
    }
}

/// What tells the joint angles: per degree of freedom with a sensor its bound and its noise, and who has none.
fn sensors_json(creature: &Creature, sensors: &[Option<JointSensor>]) -> serde_json::Value {
    let dofs = || creature.dofs().zip(sensors);
    let sensed = dofs().filter_map(|(dof, sensor)| {
        let sensor = sensor.as_ref()?;
        Some(json!({"dof": dof.name, "cutoff": sensor.cutoff, "noise": sensor.noise}))
    });
    let unsensed = dofs().filter(|(_, sensor)| sensor.is_none()).map(|(dof, _)| &dof.name);
    json!({"sensed": sensed.collect::<Vec<_>>(), "posture_itself": unsensed.collect::<Vec<_>>()})
}

/// Which limb pairs can touch, and each that differs from what its model says.
fn print_contact(creature: &Creature, contact: &SelfContact) {
    const SHOWN: usize = 20;
    let on = contact.pairs.iter().filter(|pair| pair.switched_on).count();
    say!(
        "\nof {} pairs of limbs that are learned, {} can touch ({on} of them though the model switches it off), {} are \
         neighbours, {} overlap for good, {} are excluded by the model",
        contact.pairs.len(),
        contact.count(Relation::Touch),
        contact.count(Relation::Neighbours),
        contact.count(Relation::Overlap),
        contact.count(Relation::Excluded),
    );
    let odd = |pair: &&LimbPair| {
        pair.switched_on
            || pair.left_out > 0
            || matches!(pair.relation, Relation::Overlap | Relation::Excluded)
    };
    let odd: Vec<&LimbPair> = contact.pairs.iter().filter(odd).collect();
    if odd.is_empty() {
        return;
    }
    say!("\n{:<48} {:<28} {:>8}", "pair", "what is special", "meeting");
    for pair in odd.iter().take(SHOWN) {
        let [a, b] = pair.limbs.map(|limb| creature.limbs()[limb].as_str());
        let what = match pair.relation {
            Relation::Overlap => "overlap for good".to_string(),
            Relation::Excluded => "excluded by the model".to_string(),
            Relation::Neighbours => "neighbours".to_string(),
            Relation::Touch if pair.switched_on => "switched on".to_string(),
            Relation::Touch => format!("{} geom pairs left out", pair.left_out),
        };
        say!("{:<48} {what:<28} {:>6.1} %", format!("{a} – {b}"), 100.0 * pair.meeting);
    }
    if odd.len() > SHOWN {
        say!("… and {} more: --json has them all", odd.len() - SHOWN);
    }
}

/// The limbs below `limb`, indented, each with its joint and ranges.
fn print_tree(creature: &Creature, learned: &Creature, limb: usize, depth: usize) {
    let indent = "  ".repeat(depth);
    match creature.joint_of(limb) {
        None => say!("{}", creature.limbs()[limb]),
        Some(j) => {
            let joint = &creature.joints()[j];
            let moved = learned.joints().iter().any(|other| other.name == joint.name);
            say!(
                "{indent}{} — {} {}{}",
                creature.limbs()[limb],
                joint.name,
                joint.dofs.iter().map(Dof::range_in_words).collect::<Vec<_>>().join(", "),
                if moved { "" } else { " (held by default)" }
            );
        }
    }
    for (j, joint) in creature.joints().iter().enumerate() {
        if joint.parent == limb {
            print_tree(creature, learned, j + 1, depth + 1);
        }
    }
}
