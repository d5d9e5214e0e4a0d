//! How many touches and motions each policy takes until Max knows his joints to a millimetre:
//! `cargo run --release --example policies -- [SEEDS [FIRST_SEED [POLICY…]]]`.

use std::convert::Infallible;
use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use bodyschema::babbling::{Babbler, BabblingOptions, PolicyName};
use bodyschema::creature::{Body, JointSelection};
use bodyschema::evaluation::evaluate;
use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::annealing::anneal;
use bodyschema::learning::rough::prepare;
use bodyschema::learning::{AxisModel, Input, Known, Learner, Parameters, RoughFit, SecondOrder};
use bodyschema::mujoco::Model;
use bodyschema::schema::BodySchema;
use bodyschema::senses::Touch;
use bodyschema::skin::skin_of;
use clap::ValueEnum;

const COUNTS: [usize; 18] =
    [100, 120, 140, 160, 180, 200, 220, 250, 280, 320, 360, 400, 450, 500, 600, 700, 850, 1000];
const REACHED_MM: f64 = 1.0;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number =
        |k: usize, default| arguments.get(k).map_or(Ok(default), |text: &String| text.parse::<u64>());
    let (seeds, first) = (number(0, 10)?, number(1, 1)?);
    let named: Vec<PolicyName> =
        arguments.iter().skip(2).map(|name| PolicyName::from_str(name, true)).collect::<Result<_, _>>()?;
    let policies = if named.is_empty() { PolicyName::value_variants().to_vec() } else { named };

    let model = Model::from_path(Path::new("mjcf/max/max.xml"))?;
    let body = Body::new(Arc::new(model), &JointSelection::Default)?;
    let skin = skin_of(&body);
    let truth = GroundTruth::new(&body)?;
    let babbler = Babbler::new::<Infallible>(&body, &skin)?;
    let creature = &body.creature;
    let most: usize = std::env::var("MOST").map_or(Ok(1000), |text| text.parse())?;

    for policy in policies {
        let mut reached = Vec::new();
        for seed in first..first + seeds {
            let began = Instant::now();
            let mut touches: Vec<Touch> = Vec::new();
            let mut motions = Vec::new();
            let options = BabblingOptions { touches: most, seed, jobs: 2 };
            let mut bouts = (0, 0, 0);
            let mut receive = |touch: &Touch| {
                if touch.bout != bouts.0 {
                    // Motions are counted anew in every bout.
                    bouts = (touch.bout, bouts.1 + bouts.2, 0);
                }
                bouts.2 = touch.motion;
                motions.push(bouts.1 + bouts.2);
                touches.push(touch.clone());
                Ok::<(), Infallible>(())
            };
            match policy {
                PolicyName::Random => babbler.babble(&options, &mut receive)?,
                _ => {
                    let mut chosen = policy.policy(creature, &skin, seed);
                    babbler.babble_with(chosen.as_mut(), &options, &mut receive)?
                }
            };
            let babbled = began.elapsed().as_secs_f64();
            let at = |n: usize| motions.get(n - 1).copied().unwrap_or(0);
            println!(
                "{policy} seed {seed}: {babbled:.1} s; motions at 25, 50, 100, 200, {most} touches: {:?}",
                [25, 50, 100, 200, most].map(at)
            );
            let mut learner = SecondOrder::new(creature, &skin, Input::Receptor, seed);
            let mut rough = RoughFit::new(creature, &skin, seed);
            let (mut given, mut local_at, mut rough_at, mut at_last) = (0, None, None, None);
            let error = |schema: &BodySchema| evaluate(creature, &skin, &truth, schema, &[]).heldout_mm.mean;
            for count in COUNTS.into_iter().filter(|&count| count <= most) {
                for touch in &touches[given..count] {
                    learner.touch(touch);
                    rough.touch(touch);
                }
                given = count;
                if rough_at.is_none() && error(&rough.learn().schema) < REACHED_MM {
                    rough_at = Some((count, at(count)));
                }
                // The best that any learner could do: from the truth itself. Below a millimetre from there
                // on, it is worth while to ask a learner that knows no truth.
                if local_at.is_none() {
                    let set = prepare(creature, &skin, &touches[..count]);
                    let parameters = Parameters::new(creature, AxisModel::Unit, |_| true);
                    let prior = Known::nothing(creature, &skin).prior;
                    let fit = anneal(creature, &skin, &set, &parameters, &prior, truth.schema.clone());
                    if error(&fit.schema) < REACHED_MM {
                        local_at = Some((count, at(count)));
                    }
                }
                if local_at.is_some() && error(&learner.learn().schema) < REACHED_MM {
                    at_last = Some((count, at(count)));
                    break;
                }
            }
            reached.extend(at_last);
            println!(
                "   (touches, motions) at 1 mm: from the truth {local_at:?}, rough {rough_at:?}, second order {at_last:?}; {:.0} s",
                began.elapsed().as_secs_f64()
            );
        }
        let median = |mut values: Vec<u64>| {
            values.sort_unstable();
            values.get((values.len().max(1) - 1) / 2).copied()
        };
        println!(
            "{policy}: {} of {seeds} reached 1 mm; median {:?} touches, {:?} motions\n",
            reached.len(),
            median(reached.iter().map(|r| r.0 as u64).collect()),
            median(reached.iter().map(|r| r.1).collect())
        );
    }
    Ok(())
}
