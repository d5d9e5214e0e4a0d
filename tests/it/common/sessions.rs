//! Sessions that several tests begin with, made once by a process and copied by who changes them.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use super::repository;
use super::shell::{copy_models, run};

/// What makes [`checkout`] out of a copy of the models, as the documents show it: the main job, and strokes for the map.
pub const CHECKOUT: [&str; 2] = [
    "bodyschema babble mjcf/max/max.xml",
    "bodyschema skin feel mjcf/max/max.xml --strokes 0.5 --out sessions/stroked",
];
/// The touches of [`max`].
pub const MAX_TOUCHES: usize = 1000;

/// A folder as the documents take it for granted: the models, a session of Max and one of strokes.
pub fn checkout() -> &'static Path {
    static MADE: LazyLock<PathBuf> = LazyLock::new(|| {
        let folder = kept("checkout");
        copy_models(&folder);
        CHECKOUT.iter().for_each(|line| drop(run(&folder, line)));
        folder
    });
    &MADE
}

/// A folder with a session of Max in `max`, learned from contact points.
pub fn max() -> &'static Path {
    static MADE: LazyLock<PathBuf> = LazyLock::new(|| {
        let folder = kept("max");
        let model = repository("mjcf/max/max.xml");
        let babble = format!(
            "bodyschema babble {} --policy random --touches {MAX_TOUCHES} --input contact --out max",
            model.display()
        );
        run(&folder, &babble);
        folder
    });
    &MADE
}

/// An empty folder that lasts as long as the process; what earlier ones left is cleared away.
pub fn kept(name: &str) -> PathBuf {
    let all = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sessions");
    for other in fs::read_dir(&all).into_iter().flatten().flatten() {
        let process = Path::new("/proc").join(other.file_name());
        if Path::new("/proc/self").exists() && !process.exists() {
            let _ = fs::remove_dir_all(other.path());
        }
    }
    let folder = all.join(std::process::id().to_string()).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}
