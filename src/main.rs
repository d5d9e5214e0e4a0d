use bodyschema::*;
use std::sync::Arc;
fn main(){
    let a: Vec<String> = std::env::args().collect();
    if a[1]=="skin" { let s = bodyschema::skin::grow_skin(std::path::Path::new(&a[2]), &Default::default()).unwrap();
    std::fs::write(&a[3], s).unwrap(); return; }
    let n: usize = a[3].parse().unwrap();
    let model=Arc::new(mujoco::Model::from_path(&a[1]).unwrap());
    let sel = a[2].parse().unwrap();
    let body=creature::Body::new(model,&sel).unwrap();
    println!("{} joints {} dof limbs {:?}", body.creature.joints().len(), body.creature.dof(), body.creature.limbs());
    let skin=skin::skin_of(&body);
    let b=babbling::Babbler::new::<std::convert::Infallible>(&body,&skin).unwrap();
    let t=std::time::Instant::now();
    let mut pairs=std::collections::BTreeMap::new();
    let o=babbling::BabblingOptions{touches:n,seed:1,jobs:1};
    let e=b.babble(&o,|t|{ let l=t.ends.map(|e|body.creature.limbs()[skin.receptors[e.receptor].limb].clone()); *pairs.entry(l).or_insert(0)+=1; Ok::<(),std::convert::Infallible>(())}).unwrap();
    let s=t.elapsed().as_secs_f64();
    println!("{:?} {:.3}s {:.0}/s", e, s, n as f64/s);
    let mut p: Vec<_>=pairs.into_iter().collect(); p.sort_by_key(|x|-(x.1 as i64));
    for (l,c) in p.iter().take(15) { println!("{c} {l:?}"); }
    println!("{} pairs", p.len());
}
