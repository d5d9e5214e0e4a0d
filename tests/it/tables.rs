//! A session's files in other people's tools: pandas reads them as they are.
//!
//! Where Python or pandas is missing the first is skipped, with a sentence, unless `BODYSCHEMA_PANDAS` is
//! `required`; `BODYSCHEMA_PYTHON` names the Python to use.

use std::fs;
use std::process::Command;

use crate::common::repository;
use crate::common::shell::run;

/// A Python that has pandas.
fn python() -> Option<String> {
    let named = std::env::var("BODYSCHEMA_PYTHON").ok();
    let candidates = named.into_iter().chain(["python3".to_string(), "/usr/bin/python3".to_string()]);
    candidates.into_iter().find(|python| {
        let imported = Command::new(python).args(["-c", "import pandas"]).output();
        imported.is_ok_and(|output| output.status.success())
    })
}

/// The Python code that the documents show.
fn shown() -> String {
    let document = fs::read_to_string(repository("docs/files.md")).unwrap();
    let (_, code) = document.split_once("```python\n").expect("docs/files.md shows some Python");
    code.split_once("```").unwrap().0.to_string()
}

#[test]
fn pandas_reads_a_session_as_the_documents_show() {
    let Some(python) = python() else {
        assert_ne!(
            std::env::var("BODYSCHEMA_PANDAS").as_deref(),
            Ok("required"),
            "there is no Python with pandas"
        );
        eprintln!("skipped: there is no Python with pandas; Debian's is in python3-pandas");
        return;
    };
    let place = tempfile::tempdir().unwrap();
    let max = repository("mjcf/max/max.xml");
    run(
        place.path(),
        &format!("bodyschema babble {} --touches 130 --learner hersch --out sessions/max-1", max.display()),
    );
    let check = r#"
assert len(touches) == 130, len(touches)
assert touches.index.tolist() == list(range(130)), touches.index
assert str(touches["bout"].dtype) == "int64" and str(touches["motion"].dtype) == "int64", touches.dtypes
assert touches["limbs"].map(len).eq(2).all() and touches["posture"].map(len).eq(42).all()
assert not touches.isna().any().any(), touches.columns
assert postures.shape == (130, 42) and postures.columns[0] == "lumbar1_flexion", postures.columns
assert postures.loc[3].tolist() == touches["posture"][3], postures
assert not {"format", "version", "units", "creature"} & set(touches.columns), touches.columns
assert len(learning) >= 4 and str(learning["heldout_mean_mm"].dtype) == "float64", learning
assert learning["touches"].iloc[-1] == 130
import json
lines = open("sessions/max-1/touches.jsonl").read().splitlines()[1:]
assert [json.loads(line)["posture"] for line in lines] == touches["posture"].tolist()
"#;
    fs::write(place.path().join("shown.py"), shown() + check).unwrap();
    run(place.path(), &format!("{python} shown.py"));
}
