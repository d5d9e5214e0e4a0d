use bodyschema::*;
use bodyschema::learning::Learner;
use std::sync::Arc;
fn main(){
    let a: Vec<String> = std::env::args().collect();
    if a[1]=="skin" { let s = bodyschema::skin::grow_skin(std::path::Path::new(&a[2]), &Default::default()).unwrap();
    std::fs::write(&a[3], s).unwrap(); return; }
    let n: usize = a[3].parse().unwrap();
    let model=Arc::new(mujoco::Model::from_path(&a[1]).unwrap());
    let sel = a[2].parse().unwrap();
    let body=creature::Body::new(model,&sel).unwrap();
    let skin=skin::skin_of(&body);
    let input = if a[4]=="contact" { learning::Input::Contact } else { learning::Input::Receptor };
    let truth=ground_truth::GroundTruth::new(&body).unwrap();
    let b=babbling::Babbler::new::<std::convert::Infallible>(&body,&skin).unwrap();
    for seed in 0..a[5].parse::<u64>().unwrap() {
    let mut touches=vec![];
    let o=babbling::BabblingOptions{touches:n,seed,jobs:2};
    b.babble(&o,|t|{ touches.push(t.clone()); Ok::<(),std::convert::Infallible>(())}).unwrap();
    let misses=evaluation::touch_misses(&body.creature,&skin,&truth.schema,&touches);
    let s=std::time::Instant::now();
    let mut l=learning::SecondOrder::new(&body.creature,&skin,input,seed);
    for t in &touches { l.touch(t); }
    let r=l.learn();
    let dt=s.elapsed().as_secs_f64();
    let e=evaluation::evaluate(&body.creature,&skin,&truth,&r.schema,&r.untouched);
    println!("seed {seed} truth miss {:.5} mean; {dt:.3}s onsets {} fresh {:.3} conv {} untouched {} heldout {:.3e} hand {:.3e} axis {:.3}/{:.3}", misses.mean, r.onsets, r.fresh_rms, r.verdict.converged(), r.untouched.len(), e.heldout_mm.mean, e.hand_mm.map_or(0.0,|h|h.mean), e.axis_deg.median, e.axis_deg.max);
    }
}
