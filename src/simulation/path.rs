//! Ways of things and probes through time.

use nalgebra::Vector3;

/// Where something's middle is to be, at which time: seconds and metres in the world's frame, in order of time. In
/// between it goes straight; before and after it stays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProbePath(pub Vec<(f64, Vector3<f64>)>);

impl ProbePath {
    /// Where the middle is to be at a time.
    pub fn at(&self, time: f64) -> Option<Vector3<f64>> {
        let next = self.0.partition_point(|(t, _)| *t <= time);
        let before = next.checked_sub(1).map(|k| self.0[k]);
        match (before, self.0.get(next)) {
            (Some((t0, p0)), Some((t1, p1))) => Some(p0 + (p1 - p0) * ((time - t0) / (t1 - t0))),
            (Some((_, p)), None) | (None, Some(&(_, p))) => Some(p),
            (None, None) => None,
        }
    }

    /// When it ends, seconds.
    pub fn end(&self) -> f64 {
        self.0.last().map_or(0.0, |(t, _)| *t)
    }
}
