//! Which part of a creature's surface can be touched.
//!
//! What lies inside other geometry of the same limb is buried for good. So is what lies inside a limb next to
//! it across a joint, such as the two ends that overlap in a joint's ball, or inside a body that the model excludes
//! from touching it, unless a slide between them draws it out. Geometry of any other limb moves out of the way.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Vector3};

use crate::creature::{Body, UNLIMITED_SLIDE};
use crate::error::Result;
use crate::geometry::{Frame, Shape, SurfaceSample, box_about};
use crate::mujoco::{Data, JointKind};
use crate::skin::Surface;

/// A point this deep inside another geom is not exposed, metres, on a creature of a metre and more; on
/// smaller ones less in proportion.
const BURIED: f64 = 5e-4;

/// A creature's geoms that can be touched, where they are.
pub struct Exposure {
    /// Per posture of the slides, the reference posture first, and per geom, its surface in the world's frame.
    placed: Vec<Vec<Option<Surface>>>,
    /// Per geom, the others that can bury it.
    over: Vec<Vec<usize>>,
    /// Poses of the bodies in the reference posture.
    bodies: Vec<Isometry3<f64>>,
    /// The creature's size, metres: the diagonal of the box about it.
    pub size: f64,
}

impl Exposure {
    /// Looks at the creature in its reference posture.
    ///
    /// # Errors
    /// Where the engine fails.
    pub fn new(body: &Body) -> Result<Exposure> {
        let model = &body.model;
        let mut data = Data::new(model.clone())?;
        let (mut placed, mut bodies) = (Vec::new(), Vec::new());
        for qpos in postures(body) {
            data.set_qpos(&qpos)?;
            data.kinematics()?;
            let place = |g: usize| {
                // What the world itself is made of is no limb.
                let on_limb = body.feels(g);
                let shape = Shape::of_geom(model, g).filter(|shape| on_limb && shape.is_solid())?;
                let Frame { origin, rotation } = data.geom_pose(g).into();
                Some(Surface { limb: 0, origin, rotation, shape, geom: g })
            };
            placed.push((0..model.ngeom()).map(place).collect::<Vec<_>>());
            if bodies.is_empty() {
                bodies = (0..model.nbody()).map(|b| data.body_pose(b)).collect();
            }
        }
        let touchable = |g: usize| placed[0][g].is_some();
        let carriers = carriers(body, touchable);
        let excluded: BTreeSet<[usize; 2]> = body.declared.excludes().collect();
        let overlap_for_good = |g: usize, other: usize| {
            let bodies = [g, other].map(|g| model.geom_body(g));
            let [a, b] = bodies.map(|body| model.weld(body));
            let [one, two] = bodies;
            let apart = excluded.contains(&[one, two]) || excluded.contains(&[two, one]);
            a == b || carriers[a] == Some(b) || carriers[b] == Some(a) || apart
        };
        let over = |g: usize| {
            (0..model.ngeom()).filter(|&o| o != g && touchable(o) && overlap_for_good(g, o)).collect()
        };
        let over = (0..model.ngeom()).map(over).collect();
        let size = size(placed[0].iter().flatten());
        Ok(Exposure { placed, over, bodies, size })
    }

    /// The geoms that can be touched.
    pub fn geoms(&self) -> impl Iterator<Item = usize> {
        (0..self.over.len()).filter(|&g| self.placed[0][g].is_some())
    }

    /// A geom in the reference posture, in the world's frame.
    pub fn surface(&self, geom: usize) -> Option<&Surface> {
        self.placed[0][geom].as_ref()
    }

    /// The pose of a body in the reference posture.
    pub fn body_pose(&self, body: usize) -> &Isometry3<f64> {
        &self.bodies[body]
    }

    /// Samples of a geom's exposed surface in the reference posture, about one per `spacing` m², in the world's
    /// frame, and the area that each stands for.
    pub fn samples(&self, geom: usize, spacing: f64) -> (Vec<SurfaceSample>, f64) {
        let Some(surface) = self.surface(geom) else { return (Vec::new(), 0.0) };
        let mut samples = surface.shape.samples(spacing);
        let share = surface.shape.area() / samples.len().max(1) as f64;
        for (point, normal) in &mut samples {
            *point = surface.rotation * *point + surface.origin;
            *normal = surface.rotation * *normal;
        }
        samples.retain(|(point, _)| self.is_exposed(geom, point));
        (samples, share)
    }

    /// Whether a point of a geom, given in the world's frame of the reference posture, can be touched.
    pub fn is_exposed(&self, geom: usize, point: &Vector3<f64>) -> bool {
        let depth = BURIED * self.size.min(1.0);
        let pose = |placed: &[Option<Surface>]| placed[geom].as_ref().map(Surface::pose);
        let Some(reference) = pose(&self.placed[0]) else { return false };
        self.placed.iter().enumerate().any(|(k, placed)| {
            let moved = |there: Frame| there.point(&reference.inverse_point(point));
            let point = pose(placed).filter(|_| k > 0).map_or(*point, moved);
            let holds = |&other: &usize| placed[other].as_ref().is_some_and(|s| s.holds(&point, depth));
            !self.over[geom].iter().any(holds)
        })
    }
}

/// The reference posture, and with all slides drawn in and out where there are any.
fn postures(body: &Body) -> Vec<Vec<f64>> {
    let model = &body.model;
    let reference = model.qpos0().to_vec();
    let slides = || model.joints().filter(|joint| joint.kind == JointKind::Slide);
    if slides().next().is_none() {
        return vec![reference];
    }
    let drawn = |end: usize| {
        let mut posture = reference.clone();
        for slide in slides() {
            let at = &mut posture[slide.qposadr];
            *at = if slide.limited { slide.range[end] } else { *at + [-1.0, 1.0][end] * UNLIMITED_SLIDE };
        }
        posture
    };
    vec![reference.clone(), drawn(0), drawn(1)]
}

/// Per body, the nearest one that carries it across a joint and has geoms that can be touched; both by the
/// first of the bodies that are welded together.
fn carriers(body: &Body, touchable: impl Fn(usize) -> bool) -> Vec<Option<usize>> {
    let model = &body.model;
    let mut solid = vec![false; model.nbody()];
    (0..model.ngeom()).filter(|&g| touchable(g)).for_each(|g| solid[model.weld(model.geom_body(g))] = true);
    let carrier = |b: usize| {
        let above = |&at: &usize| (at != 0).then(|| model.weld(model.body(at).parent));
        std::iter::successors(Some(model.weld(b)), above).skip(1).find(|&at| solid[at])
    };
    (0..model.nbody()).map(carrier).collect()
}

/// The diagonal of the box about surfaces, metres.
fn size<'a>(surfaces: impl Iterator<Item = &'a Surface>) -> f64 {
    let corners = surfaces.flat_map(|surface| {
        let half = surface.rotation.abs() * surface.shape.half_bounds();
        [surface.origin - half, surface.origin + half]
    });
    box_about(corners).map_or(0.0, |[low, high]| (high - low).norm())
}
