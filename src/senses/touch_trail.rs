//! The way of a touch over the skin: limb by limb, and over the joints between them.

use nalgebra::Vector3;

use super::felt_surface::FeltSurface;
use super::{LimbSensation, SensationSide, SkinSpot};

/// Way along the skin from which on a touch moves, metres: the point of contact of something soft shifts as it presses.
const MOVES: f64 = 0.012;
/// Steps in which a way along the skin is measured, metres: less is the jitter of a point of contact.
const STRIDE: f64 = 0.004;
/// A turn back counts once it has gone so far, metres: where a fingertip rolls over a crease, the point of contact jumps
/// back by less.
const TURN_BACK: f64 = 0.008;
/// Directions with a cosine below this are a turn back.
const BACK: f64 = -0.3;
/// How long after its last step along the skin a touch still counts as moving, seconds: at 5 cm/s a step takes 0.08.
const MOVING: f64 = 0.1;

/// One side of what is being followed.
#[derive(Clone, Debug)]
pub(super) struct Trail {
    receptors: Vec<(usize, [f64; 2])>,
    /// Limb by limb, in the order in which it came onto them.
    limbs: Vec<LimbTrail>,
    /// The one it is on.
    on: usize,
    /// Where it was last.
    now: SkinSpot,
    path: f64,
    /// The way over a joint just passed, which counts once it goes on there.
    crossed: f64,
    turns: usize,
    /// When the last step along the skin ended, and how fast it was, metres a second.
    stride: (f64, f64),
}

/// The part of a trail on one limb.
#[derive(Clone, Debug)]
struct LimbTrail {
    limb: usize,
    start: Vector3<f64>,
    now: Vector3<f64>,
    span: [f64; 2],
    /// Where the last step along the skin ended, and the direction it goes; how far it has gone against that.
    anchor: Vector3<f64>,
    heading: Option<Vector3<f64>>,
    back: f64,
    path: f64,
}

impl LimbTrail {
    fn new(time: f64, spot: &SkinSpot) -> LimbTrail {
        LimbTrail {
            limb: spot.limb,
            start: spot.point,
            now: spot.point,
            span: [time; 2],
            anchor: spot.point,
            heading: None,
            back: 0.0,
            path: 0.0,
        }
    }

    /// Goes on to a point: the length of the step that this completes, if it does, and whether it has turned back.
    fn go(&mut self, time: f64, point: Vector3<f64>) -> Option<(f64, bool)> {
        self.now = point;
        self.span[1] = time;
        let stride = point - self.anchor;
        let length = stride.norm();
        if length < STRIDE {
            return None;
        }
        let heading = stride / length;
        self.anchor = point;
        self.path += length;
        if self.heading.is_none_or(|before| before.dot(&heading) >= BACK) {
            (self.heading, self.back) = (Some(heading), 0.0);
            return Some((length, false));
        }
        self.back += length;
        let turned = self.back >= TURN_BACK;
        if turned {
            (self.heading, self.back) = (Some(heading), 0.0);
        }
        Some((length, turned))
    }
}

impl Trail {
    pub fn new(time: f64, spot: &SkinSpot) -> Trail {
        Trail {
            receptors: vec![(spot.receptor, [time; 2])],
            limbs: vec![LimbTrail::new(time, spot)],
            on: 0,
            now: *spot,
            path: 0.0,
            crossed: 0.0,
            turns: 0,
            stride: (f64::NEG_INFINITY, 0.0),
        }
    }

    /// Goes on with the places of one step and the forces there, newtons. It stays on its limb as long as it touches that.
    pub fn add(
        &mut self,
        time: f64,
        spots: impl Iterator<Item = (SkinSpot, f64)> + Clone,
        surface: &FeltSurface,
    ) {
        for (spot, _) in spots.clone() {
            match self.receptors.iter_mut().find(|(receptor, _)| *receptor == spot.receptor) {
                Some((_, span)) => span[1] = time,
                None => self.receptors.push((spot.receptor, [time; 2])),
            }
        }
        let stays = spots.clone().any(|(spot, _)| spot.limb == self.now.limb);
        let strongest = spots
            .clone()
            .filter(|(spot, _)| !stays || spot.limb == self.now.limb)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((strongest, _)) = strongest else { return };
        let (mut sum, mut weight) = (Vector3::zeros(), 0.0);
        for (spot, force) in spots.filter(|(spot, _)| spot.limb == strongest.limb) {
            sum += spot.point * force;
            weight += force;
        }
        let spot = SkinSpot { point: sum / weight, ..strongest };
        if spot.limb != self.now.limb {
            let way = surface.way(&self.now, &spot);
            // Back where it came from before it has gone on: it never left.
            self.crossed = if self.crossed > 0.0 { 0.0 } else { way };
            match self.limbs.iter().position(|part| part.limb == spot.limb) {
                Some(known) => self.on = known,
                None => {
                    self.on = self.limbs.len();
                    self.limbs.push(LimbTrail::new(time, &spot));
                }
            }
            if self.crossed > 0.0 {
                self.limbs[self.on].anchor = spot.point;
            }
        }
        self.now = spot;
        if let Some((length, turned)) = self.limbs[self.on].go(time, spot.point) {
            let passed = (time - self.stride.0).max(1e-3);
            self.stride = (time, if passed < MOVING { length / passed } else { length / MOVING });
            self.path += length + std::mem::take(&mut self.crossed);
            self.turns += usize::from(turned);
        }
    }

    /// Whether it is a way along the skin, not only the shift of a point of contact.
    pub fn moves(&self) -> bool {
        self.path >= MOVES
    }

    /// How often it has turned back.
    pub fn turns(&self) -> usize {
        self.turns
    }

    /// How fast it moves along the skin at a time, metres a second; none where it stays.
    pub fn pace(&self, time: f64) -> Option<f64> {
        (time - self.stride.0 <= MOVING).then_some(self.stride.1)
    }

    /// Whether it was about to leave the patches of the surface that it is on.
    pub fn leads_off(&self, surface: &FeltSurface) -> bool {
        self.limbs[self.on].heading.is_some_and(|heading| surface.leads_off(&self.now, &heading))
    }

    /// What it was, all in all.
    pub fn side(&self, duration: f64) -> SensationSide {
        let moves = self.moves();
        let direction = |from: &Vector3<f64>, to: &Vector3<f64>| {
            if moves { (to - from).try_normalize(1e-9).unwrap_or_default() } else { Vector3::zeros() }
        };
        let limbs: Vec<LimbSensation> = self
            .limbs
            .iter()
            .map(|part| LimbSensation {
                limb: part.limb,
                point: part.start,
                end: part.now,
                span: part.span,
                path: part.path,
                direction: direction(&part.start, &part.now),
            })
            .collect();
        SensationSide {
            limb: limbs[0].limb,
            last_limb: self.now.limb,
            receptors: self.receptors.clone(),
            point: limbs[0].point,
            path: self.path,
            direction: limbs[0].direction,
            speed: if moves && duration > 0.0 { self.path / duration } else { 0.0 },
            limbs,
        }
    }
}
