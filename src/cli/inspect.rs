//! `bodyschema inspect`: shows what the agent is given.

use std::path::PathBuf;
use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::open::{ModelArguments, rehearse};
use super::progress::Bars;
use super::{Outcome, output, progress};
use crate::creature::{Creature, Dof, JointSelection, creatures};
use crate::mujoco::Model;
use crate::senses::{joint_sensors, posture_in_words};
use crate::session::skin_for;
use crate::simulation::{Relation, SelfContact};
use crate::skin::{SomatotopicMap, aura_of};
use crate::view::table::Table;

/// Show a model's tree, degrees of freedom, limbs and receptors.
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

/// Pairs of limbs that are printed at the most.
const MOST_PAIRS: usize = 20;

pub fn run(args: &InspectArguments) -> Outcome {
    let spinner = progress::spinner("reading the model");
    rehearse(&args.model)?;
    let (model, left_out) = Model::read(&args.model)?;
    let model = Arc::new(model);
    let open = |joints| args.open.source(&args.model, joints).body_in(model.clone());
    let (body, learned) = (open(JointSelection::All)?, open(JointSelection::Default)?);
    let contact = SelfContact::new(&learned)?;
    let (skin, own) = skin_for(&args.model, &body, &Bars::default())?;
    let frames = body.limb_frames(&body.reference_data()?);
    let map = SomatotopicMap::new(&body.creature, &skin, &frames);
    let auras = aura_of(&body, &skin, &frames);
    let sensors = joint_sensors(&body);
    spinner.finish_and_clear();
    let (creature, learned) = (&body.creature, &learned.creature);
    let receptors = || skin.receptors.iter().enumerate();
    let across = |[a, b]: [usize; 2]| skin.receptors[a].limb != skin.receptors[b].limb;
    let links = map.pairs().count();
    let dofs = || creature.dofs().zip(&sensors);
    let found = json!({
        "model": args.model,
        "creature": creature.name(),
        "engine": body.model.version().to_string(),
        "creatures": creatures(&model).iter().map(|creature| json!({
            "root": creature.name,
            "joints": creature.joints,
        })).collect::<Vec<_>>(),
        "left_out": { "lost": left_out.lost, "unneeded": left_out.unneeded, "notes": left_out.notes },
        "joints": creature.joints().len(),
        "dof": creature.dof(),
        "torso_joints": learned.joints().len(),
        "torso_dof": learned.dof(),
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
        "receptors_by_limb": creature.aura_limbs().iter().map(|aura| {
            let on = receptors().filter(|(_, receptor)| aura.limbs.contains(&receptor.limb));
            (aura.name.clone(), json!(on.count()))
        }).collect::<Map<_, _>>(),
        "receptors_grown": skin.receptors.len() - own,
        "neighbours_mean": 2.0 * links as f64 / skin.receptors.len().max(1) as f64,
        "neighbours_none": receptors().filter(|(r, _)| map.neighbours(*r).is_empty())
            .map(|(_, receptor)| &receptor.id).collect::<Vec<_>>(),
        "links_across_limbs": map.pairs().filter(|pair| across(*pair)).count(),
        "neighbours": receptors().map(|(r, receptor)| {
            let ids: Vec<&String> = map.neighbours(r).iter().map(|&n| &skin.receptors[n].id).collect();
            (receptor.id.clone(), json!(ids))
        }).collect::<Map<_, _>>(),
        "joint_sensors": {
            "sensed": dofs().filter_map(|(dof, sensor)| sensor.as_ref().map(|sensor| json!({
                "dof": dof.name, "cutoff": sensor.cutoff, "noise": sensor.noise
            }))).collect::<Vec<_>>(),
            "posture_itself": dofs().filter(|(_, sensor)| sensor.is_none())
                .map(|(dof, _)| &dof.name).collect::<Vec<_>>(),
        },
        "constraints_not_heeded": body.constraints_not_heeded() + left_out.unheeded,
        "limb_pairs": contact.pairs.iter().map(|pair| json!({
            "limbs": pair.limbs.map(|limb| &learned.limbs()[limb]),
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
    });
    if args.json {
        return output::json(&found);
    }
    say!(
        "{}: {} joints, {} degrees of freedom, {} limbs in {} aura limbs, {} receptors, {} of them grown here",
        creature.name(),
        found["joints"],
        found["dof"],
        found["limbs"],
        found["aura_limbs"],
        found["receptors"],
        found["receptors_grown"]
    );
    let [joints, dof] = ["torso_joints", "torso_dof"].map(|field| &found[field]);
    say!("learned by default: {joints} joints, {dof} degrees of freedom\n");
    if found["creatures"].as_array().is_some_and(|all| all.len() > 1) {
        list(&found["creatures"], &[("creatures in the file (for --root)", "root"), ("joints", "joints")]);
    }
    counts("left out, because this MuJoCo does not accept it", "lost: ", &found["left_out"]["lost"]);
    counts("left out as well", "not needed: ", &found["left_out"]["unneeded"]);
    left_out.notes.iter().for_each(|note| say!("note: {note}\n"));
    print_tree(creature, learned, 0, 0);
    say!("\n{}\n", posture_in_words(&sensors));
    if found["constraints_not_heeded"] != 0 {
        let count = &found["constraints_not_heeded"];
        say!("{count} constraints that close loops or couple tendons are ignored\n");
    }
    print_contact(&contact, &found["limb_pairs"]);
    counts("receptors of aura limbs", "", &found["receptors_by_limb"]);
    if skin.receptors.is_empty() {
        say!("no touch sensors, and no surface that any can be grown on");
        return Ok(());
    }
    let of_aura =
        [("aura of", "limb"), ("radius, m", "radius"), ("reach, m", "reach"), ("of the model", "of_model")];
    list(&found["auras"], &of_aura);
    say!(
        "each receptor has {:.1} neighbours on average, {} have none; {} of {links} links cross limbs",
        found["neighbours_mean"].as_f64().unwrap_or_default(),
        found["neighbours_none"].as_array().map_or(0, Vec::len),
        found["links_across_limbs"]
    );
    say!("to see them, run `bodyschema view {}`", args.model.display());
    Ok(())
}

/// Prints some fields of objects as a table, and an empty line.
fn list(rows: &Value, columns: &[(&str, &str)]) {
    output::table(&Table::of_json(rows, columns));
    say!("");
}

/// Prints how often there is what, if there is anything, and an empty line.
fn counts(title: &str, kind: &str, counted: &Value) {
    let rows = counted.as_object().into_iter().flatten();
    let table =
        Table::new([title, "count"], rows.map(|(what, count)| [format!("{kind}{what}"), count.to_string()]));
    if !table.is_empty() {
        output::table(&table);
        say!("");
    }
}

/// Which limb pairs can touch, and each that differs from what its model says.
fn print_contact(contact: &SelfContact, pairs: &Value) {
    say!(
        "of {} pairs of learned limbs, {} can touch ({} of them although the model disables it), {} are \
         neighbours, {} always overlap, {} are excluded by the model\n",
        contact.pairs.len(),
        contact.count(Relation::Touch),
        contact.pairs.iter().filter(|pair| pair.switched_on).count(),
        contact.count(Relation::Neighbours),
        contact.count(Relation::Overlap),
        contact.count(Relation::Excluded),
    );
    let is_odd = |pair: &&Value| {
        let of_model = ["touch", "neighbours"].contains(&pair["relation"].as_str().unwrap_or_default());
        !of_model || pair["switched_on"] == true || pair["geom_pairs_left_out"] != 0
    };
    let odd: Vec<&Value> = pairs.as_array().into_iter().flatten().filter(is_odd).collect();
    if odd.is_empty() {
        return;
    }
    let columns = [
        ("special pairs", "limbs"),
        ("relation", "relation"),
        ("switched on", "switched_on"),
        ("geom pairs left out", "geom_pairs_left_out"),
        ("share of postures in contact", "meeting"),
    ];
    list(&json!(odd[..odd.len().min(MOST_PAIRS)]), &columns);
    if odd.len() > MOST_PAIRS {
        say!("… and {} more (see --json)\n", odd.len() - MOST_PAIRS);
    }
}

/// The limbs below `limb`, indented, each with its joint and ranges.
fn print_tree(creature: &Creature, learned: &Creature, limb: usize, depth: usize) {
    let name = &creature.limbs()[limb];
    match creature.joint_of(limb).map(|joint| &creature.joints()[joint]) {
        None => say!("{name}"),
        Some(joint) => {
            let moves = learned.joints().iter().any(|other| other.name == joint.name);
            let ranges: Vec<String> = joint.dofs.iter().map(Dof::range_in_words).collect();
            let (indent, held) = ("  ".repeat(depth), if moves { "" } else { " (held by default)" });
            say!("{indent}{name} — {} {}{held}", joint.name, ranges.join(", "));
        }
    }
    for (j, _) in creature.joints().iter().enumerate().filter(|(_, joint)| joint.parent == limb) {
        print_tree(creature, learned, j + 1, depth + 1);
    }
}
