//! Growing a skin on any creature.
//!
//! The exposed surface of every geom is sampled evenly; Lloyd's iteration gathers the samples into cells
//! of about the wanted area; each cell becomes a receptor, a flat quadrangle that touches the surface at
//! the cell's middle and is just large enough to cover the cell. So the receptors tile all that can be
//! touched, whatever the shape. They go straight into a [`Skin`], or into the model's file as sites with
//! touch sensors.
//!
//! About each limb that has an aura the file also gets its geometry of proximity.
//!
//! How fine the skin is, the model may say itself: a tuple `limb/NAME` names the bodies of a limb, and the
//! `prm` of each is the area of a receptor there in cm².

mod auras;
mod cells;
mod exposed;
mod file;
mod patch_size;

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::from_model::skin_of;
use super::{Receptor, Skin};
use crate::creature::{Body, body_name, matrix};
use crate::error::Error;
use crate::geometry::SurfaceSample;
use crate::mujoco;
use cells::{Patch, Tiling};
use exposed::Exposure;
use patch_size::Ground;

pub use file::{Grown, grow_skin, grow_skin_rooted};
pub use patch_size::{GrowOptions, PatchSize};

/// The share of a geom's exposed surface that receptors must lie on where no more are to grow there: quadrangles leave
/// corners bare on what is small and round.
const COVERED: f64 = 0.6;
/// Samples of a geom, to find out how much of it receptors lie on.
const SAMPLES_OF_GEOM: f64 = 1000.0;
/// Samples per receptor of the surface.
const SAMPLES_PER_RECEPTOR: f64 = 150.0;
/// Samples of a whole creature, to find out how much of it is exposed.
const FIRST_SAMPLES: f64 = 20_000.0;
/// Exposed surface below this share of a receptor's area and below [`REMNANT_OF_GEOM`] is left bare.
const REMNANT: f64 = 0.02;
/// The share of a geom's area.
const REMNANT_OF_GEOM: f64 = 0.1;
/// Most receptors of a skin.
const MOST_RECEPTORS: f64 = 20_000.0;

/// A receptor that grew.
struct Sprout {
    id: String,
    geom: usize,
    body: usize,
    /// In its body's frame.
    patch: Patch,
}

/// The skin of a creature: the receptors that its model has, and grown ones on all that can be touched and
/// has none. It has no receptors where nothing can be touched.
///
/// # Errors
/// If the options do not suit the creature, or if the engine
/// fails.
pub fn grow(body: &Body, options: &GrowOptions) -> Result<Skin, Error> {
    Ok(grow_counted(body, options)?.0)
}

/// The same, and how many of the receptors are the model's own: what grew comes after them.
///
/// # Errors
/// As [`grow`].
pub(crate) fn grow_counted(body: &Body, options: &GrowOptions) -> Result<(Skin, usize), Error> {
    let mut skin = skin_of(body);
    let own = skin.receptors.len();
    for sprout in sprouts(body, &skin, options)? {
        let surface = skin.surfaces.iter().position(|surface| surface.geom == sprout.geom);
        let pose = body.pose_in_limb[sprout.body];
        let axes = matrix(&(pose.rotation * sprout.patch.orientation));
        skin.receptors.push(Receptor {
            id: sprout.id,
            limb: body.limb_of_body[sprout.body].expect("skin grows on limbs alone"),
            position: (pose * Point3::from(sprout.patch.position)).coords,
            normal: axes.column(2).into(),
            tangent: axes.column(0).into(),
            half_extents: sprout.patch.half_extents,
            surface,
        });
    }
    Ok((skin, own))
}

/// All receptors that a creature still wants beside the `skin` of its model, geom by geom in the model's order.
fn sprouts(body: &Body, skin: &Skin, options: &GrowOptions) -> Result<Vec<Sprout>, Error> {
    let model = &body.model;
    let exposure = Exposure::new(body)?;
    let own = OwnReceptors::new(body, skin);
    let all: Vec<usize> = exposure.geoms().collect();
    let whole: f64 = all.iter().filter_map(|&g| exposure.surface(g)).map(|s| s.shape.area()).sum();
    let grounds = || -> Vec<Ground> {
        let ground = |&geom: &usize| {
            let (samples, share) = exposure.samples(geom, whole / FIRST_SAMPLES);
            Ground { geom, limb: body.limb_of_geom(geom), exposed: samples.len() as f64 * share }
        };
        all.par_iter().map(ground).collect()
    };
    let geoms: Vec<usize> = all.par_iter().copied().filter(|&g| !own.cover(&exposure, g)).collect();
    if geoms.is_empty() {
        return Ok(Vec::new());
    }
    let areas = options.areas(model, &geoms, grounds)?;
    let wanted: f64 = geoms
        .iter()
        .zip(&areas)
        .map(|(&g, area)| exposure.surface(g).map_or(0.0, |s| s.shape.area() / area))
        .sum();
    // What is buried does not count, but who asks for this much has mistaken the unit.
    if wanted > MOST_RECEPTORS || wanted.is_nan() {
        return Err(Error::model(format!(
            "about {wanted:.0} receptors would be needed, more than {MOST_RECEPTORS}: ask for larger patches"
        )));
    }
    let mut covers: Vec<GeomCover> = geoms
        .par_iter()
        .zip(&areas)
        .filter_map(|(&geom, &area)| GeomCover::new(&exposure, &own, geom, area))
        .collect();
    if let PatchSize::Count(total) = options.size {
        distribute(&mut covers, total);
    }
    let patches: Vec<Vec<Patch>> = covers.par_iter().map(GeomCover::patches).collect();
    let mut ids = Ids::new(body);
    let mut sprouts = Vec::new();
    for (cover, patches) in covers.iter().zip(patches) {
        let at = model.geom_body(cover.geom);
        let pose = exposure.body_pose(at);
        for patch in patches {
            let outward = patch.orientation * Vector3::z();
            let patch = Patch {
                position: pose.inverse_transform_point(&patch.position.into()).coords,
                orientation: pose.rotation.inverse() * patch.orientation,
                half_extents: patch.half_extents,
            };
            sprouts.push(Sprout { id: ids.next(at, &outward), geom: cover.geom, body: at, patch });
        }
    }
    Ok(sprouts)
}

/// The receptors that a model has itself.
struct OwnReceptors<'a> {
    body: &'a Body,
    skin: &'a Skin,
    /// Per geom, its receptors.
    of_geom: Vec<Vec<usize>>,
}

impl<'a> OwnReceptors<'a> {
    fn new(body: &'a Body, skin: &'a Skin) -> OwnReceptors<'a> {
        let mut of_geom = vec![Vec::new(); body.model.ngeom()];
        for (r, receptor) in skin.receptors.iter().enumerate() {
            if let Some(surface) = receptor.surface {
                of_geom[skin.surfaces[surface].geom].push(r);
            }
        }
        OwnReceptors { body, skin, of_geom }
    }

    /// Whether a sample of a geom, in the world's frame of the reference posture, lies on one of them.
    fn feel(&self, exposure: &Exposure, geom: usize, (point, outward): &SurfaceSample) -> bool {
        if self.of_geom[geom].is_empty() {
            return false;
        }
        let mujoco_body = self.body.model.geom_body(geom);
        let to_limb = self.body.pose_in_limb[mujoco_body] * exposure.body_pose(mujoco_body).inverse();
        let (point, outward) = ((to_limb * Point3::from(*point)).coords, to_limb * outward);
        self.of_geom[geom].iter().any(|&r| self.skin.receptors[r].feels(&point, &outward))
    }

    /// Whether they lie on most of a geom that can be touched.
    fn cover(&self, exposure: &Exposure, geom: usize) -> bool {
        let Some(surface) = exposure.surface(geom).filter(|_| !self.of_geom[geom].is_empty()) else {
            return false;
        };
        let (samples, _) = exposure.samples(geom, surface.shape.area() / SAMPLES_OF_GEOM);
        let felt = samples.iter().filter(|sample| self.feel(exposure, geom, sample)).count();
        felt as f64 >= COVERED * samples.len() as f64
    }
}

/// The exposed part of one geom that has no receptors, to be divided among new ones.
struct GeomCover {
    geom: usize,
    samples: Vec<SurfaceSample>,
    tiling: Tiling,
    count: usize,
    fewest: usize,
}

impl GeomCover {
    /// `None` if next to nothing is exposed.
    fn new(exposure: &Exposure, own: &OwnReceptors, geom: usize, area: f64) -> Option<GeomCover> {
        let surface = exposure.surface(geom)?;
        let (mut samples, share) = exposure.samples(geom, area / SAMPLES_PER_RECEPTOR);
        samples.retain(|sample| !own.feel(exposure, geom, sample));
        let exposed = samples.len() as f64 * share;
        if samples.is_empty() || exposed < (REMNANT * area).min(REMNANT_OF_GEOM * surface.shape.area()) {
            return None;
        }
        let (edges, long_axis) = (surface.shape.has_edges(), surface.rotation.column(2).into());
        let tiling = Tiling { share, area, edges, long_axis };
        let fewest = tiling.fewest(&samples);
        let count = ((samples.len() as f64 * share / area).round() as usize).max(fewest).min(samples.len());
        Some(GeomCover { geom, samples, tiling, count, fewest })
    }

    /// In the world's frame of the reference posture.
    fn patches(&self) -> Vec<Patch> {
        self.tiling.patches(&self.samples, self.count)
    }
}

/// Shares out a number of receptors, in proportion to what each geom would have; none gets fewer than it needs
/// to be covered, even if that makes more in all.
fn distribute(covers: &mut [GeomCover], total: usize) {
    let ideal = |cover: &GeomCover| cover.samples.len() as f64 * cover.tiling.share / cover.tiling.area;
    let ideal: Vec<f64> = covers.iter().map(ideal).collect();
    let mut scarce = vec![false; covers.len()];
    loop {
        let fixed: usize = covers.iter().zip(&scarce).filter(|(_, s)| **s).map(|(p, _)| p.fewest).sum();
        let free: f64 = ideal.iter().zip(&scarce).filter(|(_, s)| !**s).map(|(x, _)| x).sum();
        let scale = total.saturating_sub(fixed) as f64 / free;
        let short = (0..covers.len()).filter(|&k| !scarce[k] && ideal[k] * scale < covers[k].fewest as f64);
        let short: Vec<usize> = short.collect();
        if short.is_empty() {
            let mut rest: Vec<(f64, usize)> = Vec::new();
            for (k, cover) in covers.iter_mut().enumerate() {
                let exact = if scarce[k] { cover.fewest as f64 } else { ideal[k] * scale };
                cover.count = (exact.floor() as usize).min(cover.samples.len());
                rest.push((exact - exact.floor(), k));
            }
            rest.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            let left = total.saturating_sub(covers.iter().map(|p| p.count).sum());
            for &(_, k) in rest.iter().filter(|(_, k)| !scarce[*k]).take(left) {
                covers[k].count = (covers[k].count + 1).min(covers[k].samples.len());
            }
            for (cover, exact) in covers.iter_mut().zip(&ideal) {
                cover.tiling.area *= exact / cover.count as f64;
            }
            return;
        }
        short.into_iter().for_each(|k| scarce[k] = true);
    }
}

/// Names for receptors: the limb, where on it, and a number.
struct Ids<'a> {
    body: &'a Body,
    limbs: BTreeMap<usize, String>,
    count: BTreeMap<String, usize>,
}

impl Ids<'_> {
    fn new(body: &Body) -> Ids<'_> {
        Ids { body, limbs: patch_size::limb_names(&body.model), count: BTreeMap::new() }
    }

    /// A new id for a receptor on a body that faces `outward` in the reference posture, in the world's frame.
    fn next(&mut self, body: usize, outward: &Vector3<f64>) -> String {
        let model = &self.body.model;
        let stem = self.limbs.get(&body).cloned().unwrap_or_else(|| {
            // MJCF's custom: x is ahead, y to the left, z up.
            let sides = [["front", "back"], ["left", "right"], ["top", "bottom"]];
            let axis = outward.iamax();
            let side = sides[axis][usize::from(outward[axis] < 0.0)];
            format!("{}_{side}", body_name(model, body))
        });
        let count = self.count.entry(stem.clone()).or_insert(0);
        loop {
            *count += 1;
            let id = format!("{stem}_{count:02}");
            let taken = |object, name: &str| model.id(object, name).is_some();
            let sensor = format!("{id}_touch");
            if !taken(mujoco::ObjectKind::Site, &id) && !taken(mujoco::ObjectKind::Sensor, &sensor) {
                return id;
            }
        }
    }
}
