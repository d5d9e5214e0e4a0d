//! A model's fingerprint: by it a session knows whether its model has changed.

use std::path::Path;

use sha2::{Digest, Sha256};

use super::files;
use crate::error::Error;
use crate::model_files::Source;

/// The SHA-256 of a model's XML, as `sha256:` and 64 hexadecimal digits.
///
/// It is that of the file's bytes, followed by those of the files that it includes, in the order in
/// which they are named, each followed by its own. So for a model of one file it is what `sha256sum`
/// prints. Meshes and height fields are not part of it.
///
/// # Errors
/// If the file or one that it includes cannot be read, or is malformed.
pub fn model_hash(path: &Path) -> Result<String, Error> {
    let mut hash = Sha256::new();
    let bytes = files::read(path)?;
    hash.update(&bytes);
    for included in &Source::of_bytes(path, &bytes)?.files[1..] {
        hash.update(files::read(included)?);
    }
    let digits = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    Ok(format!("sha256:{digits}"))
}
