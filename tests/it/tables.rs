//! A session's files in other people's tools: pandas and polars read them as they are, and Rerun shows them.

use std::fs;
use std::path::Path;

use crate::common::shell::run;
use crate::common::{python, repository};

/// The Python code that the documents show, which imports this.
fn shown(imports: &str) -> String {
    let document = fs::read_to_string(repository("docs/files.md")).unwrap();
    let import = format!("import {imports}\n");
    let mut blocks = document.split("```python\n").skip(1).filter_map(|rest| rest.split("```").next());
    blocks.find(|code| code.contains(&import)).expect("docs/files.md shows it").to_string()
}

/// Makes a session of 130 touches in `sessions/max-1`.
fn babble(place: &Path) {
    let max = repository("mjcf/max/max.xml");
    run(
        place,
        &format!("bodyschema babble {} --touches 130 --learner hersch --out sessions/max-1", max.display()),
    );
}

#[test]
#[ignore = "needs Python with pandas"]
fn pandas_reads_a_session_as_the_documents_show() {
    let place = tempfile::tempdir().unwrap();
    babble(place.path());
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
    python::run(place.path(), &(shown("pandas") + check));
}

#[test]
#[ignore = "needs Python with polars and rerun-sdk"]
fn polars_reads_a_session_and_rerun_gets_it_as_the_documents_show() {
    let place = tempfile::tempdir().unwrap();
    babble(place.path());
    let check = r#"
rerun.get_global_data_recording().flush()
assert touches.shape == (130, 7), touches.shape
assert touches.null_count().sum_horizontal().item() == 0, touches
import json
lines = open("sessions/max-1/touches.jsonl").read().splitlines()[1:]
for column in ["bout", "motion", "posture", "limbs", "contacts"]:
    assert [json.loads(line)[column] for line in lines] == touches[column].to_list(), column
# Rerun's own program says how many points it has of which limb.
import collections, re, subprocess, sys
told = [sys.executable, "-m", "rerun", "rrd", "print", "max-1.rrd"]
told = subprocess.run(told, capture_output=True, text=True, check=True).stdout
shown = collections.Counter()
for rows, limb in re.findall(r"with (\d+) rows .* - /(\w+) - data columns: \[Points3D:positions\]", told):
    shown[limb] += int(rows)
assert shown == collections.Counter(limb for limbs in touches["limbs"] for limb in limbs), (shown, told)
"#;
    python::run(place.path(), &(shown("polars, rerun") + check));
}
