//! A session's files in other people's tools: pandas reads them as they are, and Parquet holds all of them.
//!
//! Where Python or pandas is missing the first is skipped, with a sentence, unless `BODYSCHEMA_PANDAS` is
//! `required`; `BODYSCHEMA_PYTHON` names the Python to use.

use std::fs;
use std::process::Command;

#[cfg(not(feature = "parquet"))]
use crate::common::program::form_without_its_feature;
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

#[cfg(not(feature = "parquet"))]
#[test]
fn without_parquet_the_mend_is_told() {
    form_without_its_feature("--parquet", "parquet");
}

#[cfg(feature = "parquet")]
mod parquet_file {
    use std::path::Path;

    use bodyschema::record::{Session, TOUCHES_FILE, read_touches};
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::{Field, Row};

    use super::*;

    fn rows(path: &Path) -> Vec<Row> {
        let reader = SerializedFileReader::new(fs::File::open(path).unwrap()).unwrap();
        reader.get_row_iter(None).unwrap().map(Result::unwrap).collect()
    }

    #[test]
    fn a_parquet_file_reads_back_bit_for_bit() {
        let place = tempfile::tempdir().unwrap();
        let models = [("contraption", ""), ("hexapod", "--motion dynamic")];
        for (name, options) in models {
            let model = repository(&format!("mjcf/{name}/{name}.xml"));
            let babble = format!(
                "bodyschema babble {} --touches 30 --learner hersch {options} --out",
                model.display()
            );
            run(place.path(), &format!("{babble} {name}"));
            run(place.path(), &format!("bodyschema convert {name} --parquet --out {name}.parquet"));
            let folder = place.path().join(name);
            let session = Session::read(&folder).unwrap();
            let log = read_touches(&folder.join(TOUCHES_FILE), &session.agent).unwrap();
            let rows = rows(&place.path().join(format!("{name}.parquet")));
            assert_eq!(rows.len(), 30);
            for (row, touch) in rows.iter().zip(&log.touches) {
                let field = |wanted: &str| {
                    let found = row.get_column_iter().find(|(name, _)| *name == wanted);
                    found.unwrap_or_else(|| panic!("no column {wanted}")).1.clone()
                };
                assert_eq!(field("bout"), Field::Long(touch.bout as i64));
                assert_eq!(field("motion"), Field::Long(touch.motion as i64));
                for (k, side) in ["a", "b"].into_iter().enumerate() {
                    let receptor = &session.agent.skin().receptors[touch.ends[k].receptor];
                    assert_eq!(field(&format!("receptor_{side}")), Field::Str(receptor.id.clone()));
                    let limb = &session.agent.creature().limbs()[receptor.limb];
                    assert_eq!(field(&format!("limb_{side}")), Field::Str(limb.clone()));
                    for (axis, coordinate) in ["x", "y", "z"].into_iter().zip(touch.ends[k].contact.iter()) {
                        assert_eq!(field(&format!("{side}{axis}")), Field::Double(*coordinate));
                    }
                }
                let numbers = row.get_column_iter().filter(|(_, field)| matches!(field, Field::Double(_)));
                let coordinates = touch.posture.len() + 6 + if touch.moment.is_some() { 3 } else { 0 };
                assert_eq!(numbers.count(), coordinates);
                for at in session.agent.creature().elements().filter(|at| !at.is_ball()) {
                    assert_eq!(field(&at.name), Field::Double(touch.posture[at.coordinate()]));
                }
                let force = touch.moment.map_or(Field::Null, |moment| Field::Double(moment.force));
                assert_eq!(field("force"), force);
            }
        }
    }
}
