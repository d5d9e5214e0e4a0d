//! Where a hand can get to: a map of voxels in the chest's frame, near, far and out of reach.
//!
//! The point of a hand is its tip: the place of its skin that is farthest from the joint that carries it. A voxel is
//! near where the tip can be somewhere in it by the joints from the chest outwards, and far where the joints that carry
//! the chest, the spine's, must lean as well. Only the joints' ranges count: whether limbs would be in each other, or in
//! something that is known to be there, is not regarded; [`CollisionChecker`](super::CollisionChecker) tells it of the postures.

use nalgebra::Vector3;

use super::flood::{Reached, beside};
use super::lattice::Lattice;
use super::own_body::OwnBody;
use crate::creature::Posture;
use crate::error::Error;
use crate::geometry::Frame;
use crate::kinematics::{Place, PlaceChain, Workspace};
use crate::learning::Certainty;
use crate::named::named;

/// The most voxels that a map may have about a hand, reached or not.
const MOST_VOXELS: usize = 1 << 27;
/// How near to the point a posture that reaches for it ends, metres, for each coordinate.
const EXACT: f64 = 1e-4;
/// The voxel of a point, and those about it from which it is sought.
const AROUND: [[i32; 3]; 7] =
    [[0, 0, 0], [-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];
/// The most steps of a posture that reaches for a point.
const STEPS: usize = 60;
/// Voxels in the longest reach of a map that is looked at.
pub const FINE: f64 = 50.0;
/// The same of a map that only helps to answer for single points.
pub const COARSE: f64 = 12.0;

/// A side of voxels that are about so many in a length, metres: 1, 2 or 5 of some decimal place.
pub fn voxel_side(length: f64, many: f64) -> f64 {
    let side = (length / many).max(1e-4);
    let decade = 10f64.powf(side.log10().floor());
    [5.0, 2.0, 1.0].into_iter().find(|&round| round * decade <= side).unwrap_or(1.0) * decade
}

named! {
    "level",
    /// How far away a place is, by what it takes to get there.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Level {
        /// The arm alone reaches it.
        Near = "near",
        /// The arm reaches it when the trunk leans.
        Far = "far",
        /// Nothing does.
        OutOfReach = "out of reach",
    }
}

impl Level {
    /// The number that stands for it in a file: 2 near, 1 far, 0 out of reach.
    pub fn number(self) -> u8 {
        match self {
            Level::Near => 2,
            Level::Far => 1,
            Level::OutOfReach => 0,
        }
    }
}

/// Where a point is, by a map or by postures that were sought for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// How far away it is: near or far where a posture was found that reaches it.
    pub level: Level,
    /// The posture that reaches it, or comes nearest to it.
    pub posture: Posture,
    /// How far off the tip stays with that, metres; by a map, how far the nearest voxel is that is reached.
    pub miss: f64,
}

/// The reachable space of one limb.
#[derive(Clone, Debug)]
pub struct ReachableMap {
    /// The limb that reaches.
    pub hand: usize,
    /// The limb in whose frame the map is told: the chest.
    pub chest: usize,
    /// `X_RC`: the chest in the root's frame with the body in the rest posture. It stays there while the chest leans.
    pub frame: Frame,
    /// The point of the hand.
    pub tip: Place,
    reached: Reached,
    near: usize,
    /// The joints that move: from the chest outwards, and all.
    chains: [PlaceChain; 2],
    /// The outermost voxels that are reached.
    shell: Vec<[i32; 3]>,
    at_ease: Posture,
}

impl OwnBody {
    /// The limb that carries all of some limbs: their last common ancestor; for a single one, the last that carries
    /// another part of the body as well.
    pub fn carrier_of(&self, limbs: &[usize]) -> usize {
        let branches = |limb: usize| {
            (0..self.creature().limbs().len())
                .filter(|&other| self.creature().parent_of(other) == Some(limb))
                .count()
        };
        let carries = |ancestor: usize| match limbs {
            [only] => ancestor != *only && branches(ancestor) > 1,
            all => all.iter().all(|&limb| self.carried_by(ancestor)[limb]),
        };
        let mut line = std::iter::successors(limbs.first().copied(), |&limb| self.creature().parent_of(limb));
        line.find(|&ancestor| carries(ancestor)).unwrap_or(0)
    }

    /// The place of a limb's skin that is farthest from the joint that carries it; `None` if it has no receptors.
    pub fn tip_of(&self, limb: usize) -> Option<Place> {
        let pose = self.creature().joint_of(limb).and_then(|joint| self.schema.limb_poses.get(joint));
        let far = |place: &Place| pose.map_or(place.point, |pose| pose.point(&place.point)).norm();
        let places = self.receptors_on(&[limb]).into_iter().map(|receptor| self.place(receptor));
        places.max_by(|a, b| far(a).total_cmp(&far(b)))
    }

    /// How far the tip of a limb, or another place of it, can be from the joint that carries it off the root, metres: a bound, for
    /// limbs in a line.
    pub fn length_of(&self, place: &Place) -> f64 {
        self.chain_to(place, &Frame::identity(), &self.at_ease(), |_| true).reach().1
    }

    /// The chain to a place, given in a frame that stays still in the root's frame at `X_RF`.
    pub fn chain_to(
        &self,
        place: &Place,
        frame: &Frame,
        posture: &[f64],
        moves: impl Fn(usize) -> bool,
    ) -> PlaceChain {
        let ends = [*place, Place { limb: 0, point: frame.origin, direction: Vector3::zeros() }];
        PlaceChain::new(self.creature(), &self.schema, ends, frame, posture, moves)
    }

    /// Why it is not known where a limb's skin is, in words; `None` if it is, or where the schema is taken as it is.
    pub fn unplaced(&self, limb: usize) -> Option<String> {
        match &self.certainty {
            Certainty::Exact => None,
            Certainty::Estimated(account) => {
                account.openness(self.creature(), limb).map(|why| why.words(self.creature()))
            }
            Certainty::Unknown => Some("its error is unknown".into()),
        }
    }

    /// How far a point in the root's frame is from every limb's surface, metres, negative inside: `frames` are the
    /// limbs' poses. From receptors where a surface is not known; none for a limb without either.
    pub fn distances(&self, frames: &[Frame], point: &Vector3<f64>) -> Vec<Option<f64>> {
        let mut distances: Vec<Option<f64>> = vec![None; frames.len()];
        let mut nearer = |limb: usize, distance: f64| {
            let least = &mut distances[limb];
            *least = Some(least.map_or(distance, |least| least.min(distance)));
        };
        let mut unknown = vec![true; frames.len()];
        for surface in &self.skin().surfaces {
            if let Some((distance, _)) = surface.signed_distance(&frames[surface.limb].inverse_point(point)) {
                nearer(surface.limb, distance);
                unknown[surface.limb] = false;
            }
        }
        for receptor in self.skin().receptors.iter().filter(|receptor| unknown[receptor.limb]) {
            nearer(receptor.limb, (frames[receptor.limb].point(&receptor.position) - point).norm());
        }
        distances
    }
}

impl ReachableMap {
    /// Works out where the tip of `hand` can get to, in the frame of `chest` with the body in the rest posture, by voxels of a
    /// side in metres. The threads of the pool it runs in change nothing but the time.
    ///
    /// # Errors
    /// Where the hand has no skin, or voxels are too many or none.
    pub fn new(own: &OwnBody, hand: usize, chest: usize, voxel: f64) -> Result<ReachableMap, Error> {
        let tip = own.tip_of(hand).ok_or_else(|| {
            let limb = &own.creature().limbs()[hand];
            Error::usage(format!("{limb} has no receptors to reach with: choose another limb"))
        })?;
        ReachableMap::of_place(own, hand, tip, chest, voxel)
    }

    /// The same of another place that the hand carries: the tip of a stick.
    ///
    /// # Errors
    /// Where voxels are too many or none.
    pub fn of_place(
        own: &OwnBody,
        hand: usize,
        tip: Place,
        chest: usize,
        voxel: f64,
    ) -> Result<ReachableMap, Error> {
        let at_ease = own.at_ease();
        let frame = own.frames(&at_ease)[chest];
        let carries_chest = own.joints_to(chest);
        let chain = |moves: &dyn Fn(usize) -> bool| own.chain_to(&tip, &frame, &at_ease, moves);
        let chains = [chain(&|joint| !carries_chest.contains(&joint)), chain(&|_| true)];
        let (begin, reach) = chains[1].reach();
        let countable = voxel > 0.0 && voxel.is_finite();
        let lattice = countable.then(|| Lattice::around(&begin, reach, voxel, MOST_VOXELS)).flatten();
        let mut reached = Reached::new(lattice.ok_or_else(|| {
            Error::usage(format!("voxels of {voxel} m are impossible: give a side such as 0.02"))
        })?);
        reached.fill(&chains[0], &chains[0].of_posture(&at_ease), 0);
        let near = reached.voxels.len();
        // From here on every voxel keeps all coordinates: those of the arm, and the trunk's in the rest posture.
        let mut posture = at_ease.clone();
        let mut coordinates = Vec::with_capacity(near * chains[1].count());
        for number in 0..near {
            let arm = reached.coordinates_of(number, chains[0].count());
            chains[0].put_into(arm, &mut posture);
            coordinates.extend(chains[1].of_posture(&posture).into_iter().map(|q| q as f32));
        }
        reached.coordinates = coordinates;
        if chains[1].count() > chains[0].count() {
            reached.fill(&chains[1], &chains[1].of_posture(&at_ease), 1 << 32);
        }
        let reached = reached.cropped();
        let shell = reached.outermost();
        Ok(ReachableMap { hand, chest, frame, tip, reached, near, chains, shell, at_ease })
    }

    /// A coarse map in the frame of whatever carries the hand: [`ReachableMap::reach`] is as exact on it as on a fine one.
    ///
    /// # Errors
    /// As [`ReachableMap::new`].
    pub fn coarse(own: &OwnBody, hand: usize) -> Result<ReachableMap, Error> {
        let length = own.tip_of(hand).map_or(0.0, |tip| own.length_of(&tip));
        ReachableMap::new(own, hand, own.carrier_of(&[hand]), voxel_side(length, COARSE))
    }

    /// What the map is called: the limb that reaches, or a stick that it holds.
    pub fn name(&self, own: &OwnBody) -> String {
        let limb = &own.creature().limbs()[self.hand];
        let bare = own.tip_of(self.hand).is_some_and(|tip| tip.point == self.tip.point);
        if bare { limb.clone() } else { format!("stick_in_{limb}") }
    }

    /// The voxels of the box about all that is reached.
    pub fn lattice(&self) -> &Lattice {
        &self.reached.lattice
    }

    /// How far away a voxel is, counted from the origin.
    pub fn level_of(&self, cell: [i32; 3]) -> Level {
        match self.number(cell) {
            None => Level::OutOfReach,
            Some(number) if number < self.near => Level::Near,
            Some(_) => Level::Far,
        }
    }

    fn number(&self, cell: [i32; 3]) -> Option<usize> {
        let index = self.reached.lattice.index(cell)?;
        (self.reached.numbers[index] as usize).checked_sub(1)
    }

    /// The nearest voxel that is reached to a point that is not, and how far off it is, metres; `None` if no voxel is reached.
    fn nearest(&self, point: &Vector3<f64>) -> Option<([i32; 3], f64)> {
        let far = self.shell.iter().map(|&cell| (cell, self.reached.lattice.distance(cell, point)));
        far.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// How far away a point is, in the map's frame: that of its voxel.
    pub fn level(&self, point: &Vector3<f64>) -> Level {
        self.level_of(self.reached.lattice.cell(point))
    }

    /// All that the map knows about a point in its frame, with a posture that has the tip in the point's voxel or in the nearest one
    /// that is reached.
    pub fn whereabouts(&self, point: &Vector3<f64>) -> Reach {
        let cell = self.reached.lattice.cell(point);
        let (level, number) = (self.level_of(cell), self.number(cell));
        let nearest = if number.is_none() { self.nearest(point) } else { Some((cell, 0.0)) };
        let miss = nearest.map_or(f64::INFINITY, |(_, distance)| distance);
        let mut posture = self.at_ease.clone();
        if let Some(number) = number.or_else(|| self.number(nearest?.0)) {
            let coordinates = self.reached.coordinates_of(number, self.chains[1].count());
            self.chains[1].put_into(coordinates, &mut posture);
        }
        Reach { level, posture, miss }
    }

    /// Seeks postures that reach a point in the map's frame: from those of the voxels about it, by the arm alone, and where
    /// that does not get there by leaning. It is as exact on a coarse map as on a fine one.
    pub fn reach(&self, point: &Vector3<f64>) -> Reach {
        let cell = self.reached.lattice.cell(point);
        let around = AROUND.iter().filter_map(|way| self.number(beside(cell, way)));
        let mut starts: Vec<usize> = around.collect();
        if starts.is_empty() {
            starts.extend(self.nearest(point).and_then(|(cell, _)| self.number(cell)));
        }
        let mut best = Reach { level: Level::OutOfReach, posture: self.at_ease.clone(), miss: f64::INFINITY };
        let mut workspace = Workspace::default();
        for (chain, level) in self.chains.iter().zip([Level::Near, Level::Far]) {
            for &number in starts.iter().filter(|number| level == Level::Far || **number < self.near) {
                let mut posture = self.at_ease.clone();
                let kept = self.reached.coordinates_of(number, self.chains[1].count());
                self.chains[1].put_into(kept, &mut posture);
                let mut coordinates = chain.of_posture(&posture);
                let outside = chain.seek(&mut coordinates, point, EXACT, STEPS, &mut workspace);
                let miss = (chain.point(&coordinates, &mut workspace) - point).norm();
                if outside == 0.0 || miss < best.miss {
                    chain.put_into(coordinates, &mut posture);
                    best = Reach { level: Level::OutOfReach, posture, miss };
                }
                if outside == 0.0 {
                    return Reach { level, ..best };
                }
            }
        }
        best
    }

    /// The voxels that are reached, counted from the origin, with how far away they are.
    pub fn voxels(&self) -> impl Iterator<Item = ([i32; 3], Level)> + '_ {
        let level = |number: usize| if number < self.near { Level::Near } else { Level::Far };
        let cells = self.reached.voxels.iter().map(|&voxel| self.reached.lattice.cell_at(voxel as usize));
        cells.enumerate().map(move |(number, cell)| (cell, level(number)))
    }

    /// The volumes of what is near and of what is far, m³.
    pub fn volumes(&self) -> [f64; 2] {
        let far = self.reached.voxels.len() - self.near;
        [self.near, far].map(|count| count as f64 * self.reached.lattice.voxel.powi(3))
    }
}
