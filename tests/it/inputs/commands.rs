//! Whole commands on bad files: with what a reader takes, the rest of the program comes to an end as well.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use super::readers::{CREATURE, Ending, LOG, ROBOT, ROBOT_LOG, Reader, Yard, program};

/// Of so many inputs in all, how many are each command's: they take a hundred times as long as readers.
const SHARE: usize = 2;

/// Ends as the first of some command lines that is not carried out; `{}` stands for the file and `{/}` for its folder.
fn commands(place: PathBuf, lines: &'static [&'static str]) -> Box<dyn Fn(&Path) -> Ending + Sync> {
    Box::new(move |path| {
        let mut ending = Ending::Accepted(String::new());
        for line in lines {
            let _ = fs::remove_dir_all(place.join("out"));
            let words: Vec<OsString> = line
                .split(' ')
                .map(|word| match word {
                    "{}" => path.into(),
                    "{/}" => path.parent().unwrap().into(),
                    word => word.into(),
                })
                .collect();
            let words: Vec<_> = words.iter().map(OsString::as_os_str).collect();
            ending = program(&words, &place);
            if !matches!(ending, Ending::Accepted(_)) {
                return ending;
            }
        }
        ending
    })
}

impl Yard {
    /// Commands on a session and on what else they read, each with one file that is bad.
    pub fn commands(&self) -> Vec<Reader> {
        let place = self.place.path().to_path_buf();
        let mut readers = Vec::new();
        let mut add = |name, file: PathBuf, lines| {
            let good = fs::read(&file).unwrap();
            let read = commands(place.clone(), lines);
            readers.push(Reader { name, file, good, share: SHARE, process: true, read });
        };
        let looked_at: &[&str] = &["report {/}"];
        let learned_from: &[&str] = &["report {/}", "learn {/} --learner lm --out out"];
        for (name, file, lines) in [
            ("commands, session", "session.json", learned_from),
            ("commands, touches", "touches.jsonl", learned_from),
            ("commands, schema", "schema.json", looked_at),
            ("commands, record", "learning.json", looked_at),
            ("commands, table", "learning.csv", looked_at),
        ] {
            let folder = self.path(&format!("of-{file}"));
            fs::create_dir(&folder).unwrap();
            for entry in fs::read_dir(self.path("s")).unwrap() {
                let entry = entry.unwrap();
                fs::copy(entry.path(), folder.join(entry.file_name())).unwrap();
            }
            add(name, folder.join(file), lines);
        }
        let written = |name: &str, text: &str| {
            fs::write(self.path(name), text).unwrap();
            self.path(name)
        };
        written("good_log.csv", LOG);
        written("good_creature.json", CREATURE);
        written("good_robot.json", ROBOT);
        written("good_robot.csv", ROBOT_LOG);
        let learn = &["learn --creature {} --log good_log.csv --learner lm --out out"];
        add("learn, creature", written("bad_creature.json", CREATURE), learn);
        let learn = &["learn --creature good_creature.json --log {} --learner lm --out out"];
        add("learn, log", written("bad_log.csv", LOG), learn);
        add(
            "calibrate, robot",
            written("bad_robot.json", ROBOT),
            &["calibrate {} good_robot.csv --free *.offset"],
        );
        add(
            "calibrate, log",
            written("bad_robot.csv", ROBOT_LOG),
            &["calibrate good_robot.json {} --free *.offset"],
        );
        readers
    }
}
