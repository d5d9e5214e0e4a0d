//! Which geoms may touch: MuJoCo's collision filters, without a posture; on which of them a rigid part can be touched, and
//! which are no part but the aura about one.

use std::collections::BTreeMap;

use super::element::{GeomKind, SensorKind};
use super::error::Result;
use super::ffi;
use super::model::Model;

/// Geoms without contact whose names start with this are the aura of the limb named after it.
pub const AURA_GEOM: &str = "aura/";
/// The radius about an aura's middle that the engine is told of, metres: 0 would be that of a plane without end.
const AURA_BOUND: f64 = 1e-6;

impl Model {
    /// Whether the engine reports a contact when geoms `a` and `b` come close enough.
    ///
    /// The same decision as `mj_collision`: explicit pairs first, then excluded bodies, bodies welded
    /// together, parent and child (unless the parent is the world or the filter is off), and at last
    /// the contact types and affinities.
    pub fn collides(&self, a: usize, b: usize) -> bool {
        let option = &self.raw().opt;
        let disabled = |bit: u32| option.disableflags as u32 & bit != 0;
        if a == b
            || disabled(ffi::mjDSBL_CONSTRAINT)
            || disabled(ffi::mjDSBL_CONTACT)
            || !shapes_meet(self.geom_kind(a), self.geom_kind(b))
        {
            return false;
        }
        let sources = self.sources();
        if sources.pairs && self.paired(a, b) {
            return true;
        }
        if !sources.dynamic {
            return false;
        }
        let bodies = [self.geom_body(a), self.geom_body(b)];
        if self.is_excluded(bodies[0], bodies[1]) {
            return false;
        }
        let welds = bodies.map(|body| self.weld(body));
        if welds[0] == welds[1] {
            return false;
        }
        let parents = welds.map(|weld| self.weld(self.parents()[weld] as usize));
        let relatives = welds[0] == parents[1] || welds[1] == parents[0];
        if relatives && !welds.contains(&0) && !disabled(ffi::mjDSBL_FILTERPARENT) {
            return false;
        }
        let ((type_a, affinity_a), (type_b, affinity_b)) = (self.contact_bits(a), self.contact_bits(b));
        type_a & affinity_b != 0 || type_b & affinity_a != 0
    }

    /// A copy in which the geoms marked collide with one another and nothing else collides: their filters are
    /// opened, excludes, explicit pairs and contact margins are gone. Parent and child still do not meet. The engine
    /// adds no noise to its sensors, and computes those of touch and joints alone.
    ///
    /// # Errors
    /// [`Error::Engine`](super::Error::Engine) where the engine has no memory for it.
    pub fn touching_with(&self, touchable: &[bool]) -> Result<Model> {
        self.with_contact_bits(|g| if touchable.get(g) == Some(&true) { (1, 1) } else { (0, 0) })
    }

    /// The same, but that the geoms marked as `own` do not collide with one another, only with the rest.
    ///
    /// # Errors
    /// As [`Model::touching_with`].
    pub fn touching_others(&self, touchable: &[bool], own: &[bool]) -> Result<Model> {
        self.with_contact_bits(|g| match (touchable.get(g) == Some(&true), own.get(g) == Some(&true)) {
            (false, _) => (0, 0),
            (true, true) => (1, 2),
            (true, false) => (3, 1),
        })
    }

    /// A copy in which geoms have these types and affinities, and no other filter.
    fn with_contact_bits(&self, bits: impl Fn(usize) -> (i32, i32)) -> Result<Model> {
        let mut copy = self.copy()?;
        copy.set_contact_bits(bits);
        let auras: Vec<usize> = (0..self.ngeom()).filter(|&geom| self.is_aura(geom)).collect();
        let raw = copy.raw_mut();
        // SAFETY: the copy is not shared yet; the arrays hold a number per geom, and so many geoms there are
        // in both models. Counts of zero leave arrays unread whose memory belongs to the model's one buffer.
        unsafe {
            for g in 0..self.ngeom() {
                *(*raw).geom_margin.add(g) = 0.0;
                *(*raw).geom_gap.add(g) = 0.0;
            }
            // What touches nothing counts in the boxes about bodies, too: large auras would make all of them meet.
            for g in auras {
                *(*raw).geom_rbound.add(g) = AURA_BOUND;
            }
            // Where no poses are wanted a rangefinder has no direction to look in, which the engine takes for an error.
            for (s, sensor) in self.sensors().enumerate() {
                if !matches!(sensor.kind, SensorKind::Touch | SensorKind::JointPos | SensorKind::BallQuat) {
                    *(*raw).sensor_type.add(s) = ffi::mjSENS_USER as _;
                }
            }
            (*raw).nexclude = 0;
            (*raw).npair = 0;
            (*raw).opt.disableflags &= !((ffi::mjDSBL_CONSTRAINT | ffi::mjDSBL_CONTACT) as i32);
            // The trees of bounding boxes leave out geoms that did not collide when the model was compiled. Convex shapes
            // are to meet as they do in every version, where newer ones have a way of their own besides.
            (*raw).opt.disableflags |=
                (ffi::mjDSBL_MIDPHASE | ffi::mjDSBL_NATIVECCD | ffi::mjDSBL_MULTICCD) as i32;
            (*raw).opt.enableflags &=
                !((ffi::mjENBL_NATIVECCD | ffi::mjENBL_MULTICCD | ffi::mjENBL_SPECULATIVE) as i32);
            // The engine draws noise from the process's one generator: with threads it is never the same twice.
            (*raw).opt.enableflags &= !(ffi::mjENBL_SENSORNOISE as i32);
            #[cfg(mujoco_collision_option)]
            {
                (*raw).opt.collision = ffi::mjCOL_DYNAMIC as i32;
            }
        }
        Ok(copy)
    }

    /// Takes over the contact types and affinities of another model, before this one is shared; false where the two do not
    /// have the same geoms, and nothing is taken over.
    pub(crate) fn take_filters(&mut self, other: &Model) -> bool {
        let geoms = |model: &Model| -> Vec<_> {
            (0..model.ngeom())
                .map(|g| (model.geom_kind(g), model.geom_body(g), model.mesh_of_geom(g)))
                .collect()
        };
        let same = self.nbody() == other.nbody() && geoms(self) == geoms(other);
        if same {
            self.set_contact_bits(|g| other.contact_bits(g));
        }
        same
    }

    /// Gives geoms these types and affinities.
    fn set_contact_bits(&mut self, bits: impl Fn(usize) -> (i32, i32)) {
        let raw = self.raw_mut();
        for g in 0..self.ngeom() {
            // SAFETY: the model is borrowed exclusively, and its arrays hold a number per geom.
            unsafe { (*(*raw).geom_contype.add(g), *(*raw).geom_conaffinity.add(g)) = bits(g) }
        }
        // What newer engines keep of the filters per body.
        #[cfg(mujoco_body_contact_bits)]
        for b in 0..self.nbody() {
            let geoms = self.body(b).geoms.map(&bits);
            let (types, affinities) = geoms.fold((0, 0), |all, geom| (all.0 | geom.0, all.1 | geom.1));
            // SAFETY: as above, with a number per body.
            unsafe { (*(*raw).body_contype.add(b), *(*raw).body_conaffinity.add(b)) = (types, affinities) }
        }
    }

    /// Whether a geom is an aura: a geometry of proximity, which nothing touches and no limb is made of. One that collides
    /// is none, whatever its name.
    pub fn is_aura(&self, geom: usize) -> bool {
        self.contact_bits(geom) == (0, 0)
            && self.geom(geom).name.is_some_and(|name| name.starts_with(AURA_GEOM))
    }

    /// Per geom, whether it is one of `own` that can be touched: one that collides with anything; and where nothing of a
    /// rigid part does, all of that part's, for many models leave self-contact off.
    pub(crate) fn surface_among(&self, own: &[bool]) -> Vec<bool> {
        let own: Vec<bool> = (0..own.len()).map(|geom| own[geom] && !self.is_aura(geom)).collect();
        let collides = |geom: usize| self.contact_bits(geom) != (0, 0);
        let mut part_collides: BTreeMap<usize, bool> = BTreeMap::new();
        for geom in (0..own.len()).filter(|&geom| own[geom]) {
            *part_collides.entry(self.rigid_part(geom)).or_default() |= collides(geom);
        }
        let bare = |geom: usize| !part_collides[&self.rigid_part(geom)];
        (0..own.len()).map(|geom| own[geom] && (collides(geom) || bare(geom))).collect()
    }

    /// The body at which the rigid part of a geom begins. Of what is fixed to the world, a part begins at each body that is
    /// mounted on it.
    fn rigid_part(&self, geom: usize) -> usize {
        let body = self.geom_body(geom);
        match self.weld(body) {
            0 => std::iter::successors(Some(body), |&body| Some(self.parents()[body] as usize))
                .find(|&body| body == 0 || self.parents()[body] == 0)
                .unwrap_or(0),
            weld => weld,
        }
    }

    /// The pairs of bodies that `<exclude>` keeps from touching, as they stand in the model.
    pub fn excludes(&self) -> impl Iterator<Item = [usize; 2]> {
        let first = if cfg!(mujoco_signature_from_one) { 1 } else { 0 };
        self.exclude_signatures().iter().map(move |&signature| {
            let signature = signature as u32;
            [(signature >> 16) as usize - first, (signature & 0xffff) as usize - first]
        })
    }

    /// Which of the two sources of contacts the model's options leave on.
    #[cfg(mujoco_collision_option)]
    fn sources(&self) -> Sources {
        let collision = self.raw().opt.collision as u32;
        Sources { pairs: collision != ffi::mjCOL_DYNAMIC, dynamic: collision != ffi::mjCOL_PAIR }
    }

    /// Newer engines have no such option: both.
    #[cfg(not(mujoco_collision_option))]
    fn sources(&self) -> Sources {
        Sources { pairs: true, dynamic: true }
    }

    fn is_excluded(&self, a: usize, b: usize) -> bool {
        self.excludes().any(|pair| pair == [a, b] || pair == [b, a])
    }

    fn paired(&self, a: usize, b: usize) -> bool {
        let (first, second) = self.pair_geoms();
        first.iter().zip(second).any(|(&first, &second)| {
            let pair = [first as usize, second as usize];
            pair == [a, b] || pair == [b, a]
        })
    }
}

/// Where contacts come from.
struct Sources {
    /// The explicit pairs.
    pairs: bool,
    /// All other pairs that pass the filters.
    dynamic: bool,
}

/// Whether the engine has a collision function for two shapes: planes and height fields stand still.
fn shapes_meet(a: GeomKind, b: GeomKind) -> bool {
    let ground = |kind| matches!(kind, GeomKind::Plane | GeomKind::HeightField);
    !(ground(a) && ground(b))
}
