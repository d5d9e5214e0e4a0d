//! Reading the skin from a model: every site with a touch sensor is a receptor.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Vector3};

use super::{Receptor, Skin, Surface};
use crate::creature::{Body, matrix, site_name};
use crate::geometry::{Frame, Shape};
use crate::mujoco::{GeomKind, Model, ObjectKind, Sensor, SensorKind, Site};

/// A box site at least this many times wider than thick is a patch; its z axis is the normal.
const FLATNESS: f64 = 3.0;

/// The skin of a creature: its receptors and the surfaces of its limbs, in the limbs' frames.
///
/// Sites that are not flat boxes along the surface become patches of their size at the surface's nearest
/// point.
pub fn skin_of(body: &Body) -> Skin {
    let model = &body.model;
    let mut surfaces = Vec::new();
    let mut surface_of_geom = vec![None; model.ngeom()];
    for g in (0..model.ngeom()).filter(|&g| body.feels(g)) {
        if let Some(surface) = self::surface_of_geom(body, g) {
            surface_of_geom[g] = Some(surfaces.len());
            surfaces.push(surface);
        }
    }
    let mut receptors = Vec::new();
    for s in touch_sites(model) {
        let site = model.site(s);
        let Some(limb) = body.limb_of_body[site.body] else { continue };
        let on_body: Vec<usize> = model.body(site.body).geoms.filter_map(|g| surface_of_geom[g]).collect();
        let pose = body.pose_in_limb[site.body] * Isometry3::from_parts(site.pos.into(), site.quat);
        let id = site_name(model, s);
        receptors.push(receptor(id, limb, &site, &pose, &surfaces, &on_body));
    }
    Skin { receptors, surfaces }
}

/// The surface that a geom is on its limb; none for what no limb is made of.
pub(crate) fn surface_of_geom(body: &Body, geom: usize) -> Option<Surface> {
    let (limb, shape) = (body.limb_of_geom(geom)?, Shape::of_geom(&body.model, geom)?);
    let Frame { origin, rotation } = body.geom_in_limb(&body.model.geom(geom)).into();
    Some(Surface { limb, origin, rotation, shape, geom })
}

/// The surfaces of a model's body, whoever's it is, in its own frame; their limb means nothing.
pub(crate) fn surface_of_body(model: &Model, body: usize) -> Vec<Surface> {
    let geoms = (0..model.ngeom()).filter(|&geom| model.geom_body(geom) == body && !model.is_aura(geom));
    let surface = |geom: usize| {
        let (info, shape) = (model.geom(geom), Shape::of_geom(model, geom)?);
        Some(Surface { limb: 0, origin: info.pos, rotation: matrix(&info.quat), shape, geom })
    };
    geoms.filter_map(surface).collect()
}

/// The sites with touch sensors, in the model's order.
pub(super) fn touch_sites(model: &Model) -> impl Iterator<Item = usize> {
    let touch = |sensor: &Sensor| sensor.kind == SensorKind::Touch && sensor.object == ObjectKind::Site;
    let sites: BTreeSet<usize> = model.sensors().filter(touch).filter_map(|sensor| sensor.id).collect();
    sites.into_iter()
}

fn receptor(
    id: String,
    limb: usize,
    site: &Site,
    pose: &Isometry3<f64>,
    surfaces: &[Surface],
    on_body: &[usize],
) -> Receptor {
    let centre = pose.translation.vector;
    let axes = matrix(&pose.rotation);
    let (x_axis, z_axis): (Vector3<f64>, Vector3<f64>) = (axes.column(0).into(), axes.column(2).into());
    let measured = |&s: &usize| surfaces[s].signed_distance(&centre).map(|(d, normal)| (s, d, normal));
    let nearest = on_body.iter().filter_map(measured).min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let mesh = || on_body.iter().copied().find(|&s| !surfaces[s].shape.is_solid());
    let flat = site.kind == GeomKind::Box && FLATNESS * site.size[2] <= site.size[0].min(site.size[1]);
    let half =
        Shape::primitive(site.kind, site.size).map_or(Vector3::repeat(site.size[0]), |s| s.half_bounds());
    let mut found = Receptor {
        id,
        limb,
        position: centre,
        normal: z_axis,
        tangent: x_axis,
        half_extents: [half.x, half.y],
        surface: nearest.map(|(s, ..)| s).or_else(mesh),
    };
    let Some((_, distance, normal)) = nearest else { return found };
    if flat && z_axis.dot(&normal) > 0.5 {
        return found;
    }
    found.position = centre - normal * distance;
    found.normal = normal;
    let along = x_axis - normal * normal.dot(&x_axis);
    let along = along.try_normalize(1e-6);
    found.tangent = along.unwrap_or_else(|| crate::geometry::tangent_basis(&normal).column(0).into());
    found
}
