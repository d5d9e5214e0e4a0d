//! Growing up: few joints at first, and more as they are known.

use crate::common::program::refused;
use crate::common::two_arms;

/// It knows its body by the surfaces under its receptors: other input would be learned from as if it were that.
#[test]
fn growth_refuses_what_it_cannot_learn_from() {
    let place = tempfile::tempdir().unwrap();
    let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
    std::fs::write(place.path().join("arms.xml"), arms).unwrap();
    for other in [["--input", "contact"], ["--skin", "centres"]] {
        let arguments = [&["babble", "arms.xml", "--learner", "growth"][..], &other].concat();
        let message = refused(place.path(), 1, &arguments);
        assert!(
            message.contains("leave out --input and --skin") && message.contains("--learner lm"),
            "{message}"
        );
    }
}

mod slow {
    use serde_json::Value;

    use crate::common::program::succeeds;

    /// Its 15 joints are learned from a few touches each; it ends before it has made all that it might.
    #[test]
    #[ignore = "slow: 10 s"]
    fn a_body_grows_from_its_trunk_and_claims_nothing_wrong() {
        let model = concat!(env!("CARGO_MANIFEST_DIR"), "/mjcf/fourarms/fourarms.xml");
        let place = tempfile::tempdir().unwrap();
        for seed in ["21", "22"] {
            let arguments =
                ["babble", model, "--policy", "stages", "--learner", "growth", "--touches", "1500"];
            let more = ["--seed", seed, "--out", seed, "--json"];
            let found: Value =
                serde_json::from_str(&succeeds(place.path(), &[&arguments[..], &more].concat())).unwrap();
            assert_eq!(found["converged"], true);
            assert!(found["undetermined"].as_array().unwrap().len() <= 3, "{}", found["undetermined"]);
            let worst = found["determined_mm"]["max"].as_f64().unwrap();
            assert!(worst < 0.1, "{worst} mm of what is claimed");
            // A session that ended early is whole, and what was learned on the way is what its log tells.
            let schema = || std::fs::read(place.path().join(seed).join("schema.json")).unwrap();
            let on_the_way = schema();
            succeeds(place.path(), &["babble", "--resume", seed]);
            assert!(schema() == on_the_way, "learned again from the log, the schema is another");
        }
    }
}
