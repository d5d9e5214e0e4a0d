//! Pictures by MuJoCo's own renderer, drawn off-screen.

use std::collections::HashMap;
use std::ffi::CString;
use std::mem::MaybeUninit;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::data::Data;
use super::element::GeomKind;
use super::engine::{self, guarded};
use super::error::{Error, Result};
use super::ffi;
use super::model::Model;
use super::opengl::OffscreenContext;
use crate::geometry::z_onto;

/// Most marks of a picture: the largest skin with all its neighbours.
pub const MOST_MARKS: usize = 100_000;
/// Sides of a picture, pixels: a buffer of the largest takes half a gigabyte.
pub const PICTURE_SIDES: std::ops::RangeInclusive<usize> = 16..=4096;
/// MuJoCo's head light where a model says nothing of it: ambient, diffuse and specular, …
const PLAIN_LIGHT: [f32; 3] = [0.1, 0.4, 0.5];
/// … which is dim where there is no other light; what it is replaced by.
const BRIGHT_LIGHT: [f32; 3] = [0.42, 0.56, 0.08];

/// Geoms nearer to each other than this are in one place, metres, and turned alike.
const SAME_PLACE: f32 = 1e-4;
const SAME_TURN: f32 = 1e-3;

/// Pictures of so many rows have larger letters.
const LARGE: usize = 700;

/// MuJoCo asks OpenGL for its functions the first time only, and guards that by nothing.
static MAKING_CONTEXT: Mutex<()> = Mutex::new(());

/// A picture: rows from the top, three bytes a pixel, red, green and blue.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `height * width * 3` bytes.
    pub rgb: Vec<u8>,
}

/// Where a picture is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// An eye that looks at a point, upright.
    Free {
        /// The point, in the world, metres.
        lookat: Point3<f64>,
        /// How far the eye is from it, metres.
        distance: f64,
        /// The direction in which it looks, about the world's z from x, radians.
        azimuth: f64,
        /// How far it looks up, radians; below zero it looks down.
        elevation: f64,
    },
    /// A camera of the model, by its number.
    Fixed(usize),
}

/// Something that is drawn and is no part of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Its shape; no plane, mesh or height field.
    pub kind: GeomKind,
    /// As of a [`Geom`](super::Geom), metres.
    pub size: [f64; 3],
    /// `X_WM`: where it is in the world.
    pub pose: Isometry3<f64>,
    /// Red, green, blue and opacity, 0 to 1.
    pub rgba: [f32; 4],
    /// How much it shines by itself, 0 to 1.
    pub emission: f32,
}

impl Mark {
    /// A ball.
    pub fn sphere(centre: &Point3<f64>, radius: f64, rgba: [f32; 4]) -> Mark {
        let pose = Isometry3::from_parts(Translation3::from(centre.coords), UnitQuaternion::identity());
        Mark { kind: GeomKind::Sphere, size: [radius; 3], pose, rgba, emission: 0.0 }
    }

    /// A rod with round ends.
    pub fn capsule(ends: [Point3<f64>; 2], radius: f64, rgba: [f32; 4]) -> Mark {
        let along = ends[1] - ends[0];
        let rotation = z_onto(&along);
        let middle = nalgebra::center(&ends[0], &ends[1]);
        let pose = Isometry3::from_parts(Translation3::from(middle.coords), rotation);
        let size = [radius, 0.5 * along.norm(), 0.0];
        Mark { kind: GeomKind::Capsule, size, pose, rgba, emission: 0.0 }
    }
}

/// A geom that is drawn a second time, as the model has it, elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeomCopy {
    /// The geom.
    pub geom: usize,
    /// `X_WG`, where.
    pub pose: Isometry3<f64>,
}

/// How a picture is drawn.
pub struct View<'a> {
    /// Where it is taken from.
    pub camera: Camera,
    /// What is drawn besides the model.
    pub marks: &'a [Mark],
    /// Whether nothing of the model is drawn, neither its sky: the marks alone, and white behind them.
    pub marks_alone: bool,
    /// The colour and opacity of geoms that are not to look as the model has it.
    pub repaint: &'a dyn Fn(usize) -> Option<[f32; 4]>,
    /// Geoms that are drawn a second time.
    pub copies: &'a [GeomCopy],
    /// What is written below, in ASCII; `None` if that is empty.
    pub caption: &'a str,
}

/// Draws a model in any posture, with MuJoCo's renderer, into memory. It stays in its thread.
pub struct Renderer {
    // What OpenGL holds for MuJoCo goes before the context of OpenGL does.
    buffers: Buffers,
    scene: EngineScene,
    context: OffscreenContext,
    option: Box<ffi::mjvOption>,
    data: Data,
    width: usize,
    height: usize,
}

impl Renderer {
    /// A renderer of a model, for pictures of a size in pixels within [`PICTURE_SIDES`]. Edges are `smooth` as the model
    /// asks for, which takes a renderer without a graphics card three fifths of its time, or they are not.
    ///
    /// # Errors
    /// [`Error::OpenGl`] where there is none; [`Error::Size`] for a size beyond the bounds; [`Error::Engine`] where
    /// MuJoCo cannot draw with the OpenGL there is, or lacks memory.
    pub fn new(model: &Model, width: usize, height: usize, smooth: bool) -> Result<Renderer> {
        for (what, side) in [("the picture's width", width), ("the picture's height", height)] {
            if !PICTURE_SIDES.contains(&side) {
                let nearest = side.clamp(*PICTURE_SIDES.start(), *PICTURE_SIDES.end());
                return Err(Error::Size { what, expected: nearest, found: side });
            }
        }
        let mut copy = model.copy()?;
        // SAFETY: the copy is not shared yet.
        unsafe {
            let visual = &raw mut (*copy.raw_mut()).vis;
            (*visual).global.offwidth = width as i32;
            (*visual).global.offheight = height as i32;
            if !smooth {
                (*visual).quality.offsamples = 0;
            }
            let light = &raw mut (*visual).headlight;
            if [(*light).ambient, (*light).diffuse, (*light).specular] == PLAIN_LIGHT.map(|x| [x; 3]) {
                [(*light).ambient, (*light).diffuse, (*light).specular] = BRIGHT_LIGHT.map(|x| [x; 3]);
            }
        }
        let copy = Arc::new(copy);
        let context = OffscreenContext::new()?;
        let buffers = Buffers::new(&copy, font(height))?;
        let scene = EngineScene::new(&copy)?;
        let mut option = by_default(ffi::mjv_defaultOption);
        // Receptors cover all of a skin: over the body's own looks they would be all that is seen.
        option.sitegroup.fill(0);
        let limbs = || copy.geoms().enumerate().filter(|(g, geom)| geom.body != 0 && !copy.is_aura(*g));
        if !limbs().any(|(_, geom)| geom.is_shown()) {
            // The aura alone stays hidden.
            for (group, shown) in option.geomgroup.iter_mut().enumerate() {
                let of_group = |geom: &super::element::Geom| usize::try_from(geom.group) == Ok(group);
                let any = copy.geoms().any(|geom| of_group(&geom));
                *shown = u8::from(
                    !any || copy.geoms().enumerate().any(|(g, geom)| of_group(&geom) && !copy.is_aura(g)),
                );
            }
        }
        let data = Data::new(copy)?;
        Ok(Renderer { buffers, scene, context, option, data, width, height })
    }

    /// Whether a geom of the model is drawn at all: it is not where its group is one that viewers hide.
    pub fn shows(&self, geom: usize) -> bool {
        let group = self.data.model().geom(geom).group;
        usize::try_from(group).is_ok_and(|group| self.option.geomgroup.get(group).is_some_and(|on| *on != 0))
    }

    /// The height that a free camera sees at a distance of one, as an angle, radians; and a row's length by height.
    pub fn lens(&self) -> (f64, f64) {
        let degrees: f64 = self.data.model().raw().vis.global.fovy.into();
        (degrees.to_radians(), self.width as f64 / self.height as f64)
    }

    /// The model in a posture: `nq` coordinates in radians and metres, quaternions w x y z.
    ///
    /// # Errors
    /// As [`Data::set_qpos`] and [`Data::kinematics`]; [`Error::Engine`] for a camera that the model does not have,
    /// and where OpenGL fails.
    ///
    /// # Panics
    /// Where there are more than [`MOST_MARKS`] marks, or one is a plane, mesh or height field.
    pub fn render(&mut self, qpos: &[f64], view: &View) -> Result<Image> {
        self.data.set_qpos(qpos)?;
        self.data.place()?;
        self.context.make_current()?;
        self.scene.update(&mut self.data, &self.option, view)?;
        let viewport =
            ffi::mjrRect { left: 0, bottom: 0, width: self.width as i32, height: self.height as i32 };
        let row = 3 * self.width;
        let mut upwards = vec![0u8; row * self.height];
        let (scene, buffers) = (&mut *self.scene.0, &*self.buffers.0);
        let caption = view.caption.replace(|c: char| !c.is_ascii() || c == '\0', "?");
        let caption = CString::new(caption).unwrap_or_default();
        guarded("mjr_render", || {
            // SAFETY: scene and buffers are the engine's own and made for this context of OpenGL, which is current; the
            // bytes are as many as the engine writes for a viewport of this size.
            unsafe {
                ffi::mjr_render(viewport, scene, buffers);
                if !caption.is_empty() {
                    let (font, place) = (ffi::mjFONT_NORMAL as i32, ffi::mjGRID_BOTTOMLEFT as i32);
                    ffi::mjr_overlay(font, place, viewport, caption.as_ptr(), std::ptr::null(), buffers);
                }
                ffi::mjr_readPixels(upwards.as_mut_ptr(), std::ptr::null_mut(), viewport, buffers);
            }
        })?;
        warned("mjr_render")?;
        // OpenGL's rows go upwards.
        let rgb = upwards.chunks_exact(row).rev().collect::<Vec<_>>().concat();
        Ok(Image { width: self.width, height: self.height, rgb })
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        // What is freed belongs to this context, whichever was used last in this thread.
        let _ = self.context.make_current();
    }
}

/// The engine's warning in the last call, as an error.
fn warned(call: &'static str) -> Result<()> {
    engine::take_warning().map_or(Ok(()), |message| Err(Error::Warning { call, message }))
}

/// A structure of the engine, set to its defaults.
fn by_default<T>(set: unsafe extern "C-unwind" fn(*mut T)) -> Box<T> {
    let mut made = Box::new(MaybeUninit::zeroed());
    // SAFETY: the engine fills in what it is given; all zeros are valid before.
    unsafe {
        set(made.as_mut_ptr());
        made.assume_init()
    }
}

/// What MuJoCo keeps in OpenGL.
struct Buffers(Box<ffi::mjrContext>);

impl Buffers {
    /// Those of a model, for drawing off-screen; a context of OpenGL is current.
    fn new(model: &Model, font: u32) -> Result<Buffers> {
        let _one_at_a_time = MAKING_CONTEXT.lock().unwrap_or_else(PoisonError::into_inner);
        let mut buffers = Buffers(by_default(ffi::mjr_defaultContext));
        let raw = &mut *buffers.0;
        guarded("mjr_makeContext", || {
            // SAFETY: the model is valid, the buffers are set to their defaults, and a context is current.
            unsafe {
                ffi::mjr_makeContext(model.raw(), raw, font as _);
                ffi::mjr_setBuffer(ffi::mjFB_OFFSCREEN as i32, raw);
            }
        })?;
        // It warns of what it does without, and pictures are drawn all the same.
        engine::take_warning();
        if raw.currentBuffer != ffi::mjFB_OFFSCREEN as i32 {
            let message = "it has no off-screen buffer".to_string();
            return Err(Error::Engine { call: "mjr_makeContext", message });
        }
        Ok(buffers)
    }
}

impl Drop for Buffers {
    fn drop(&mut self) {
        // SAFETY: made or set to its defaults by the engine, freed once, while its context is still there. An error in
        // it, which leaves things in OpenGL, has nobody to go to.
        let _ = guarded("mjr_freeContext", || unsafe { ffi::mjr_freeContext(&raw mut *self.0) });
    }
}

/// The size of letters for pictures of so many rows, per cent.
fn font(height: usize) -> u32 {
    if height < LARGE { 100 } else { 150 }
}

/// What is to be drawn, as the engine lists it.
struct EngineScene(Box<ffi::mjvScene>);

impl EngineScene {
    fn new(model: &Model) -> Result<EngineScene> {
        let mut scene = EngineScene(by_default(ffi::mjv_defaultScene));
        let room = 2 * (model.ngeom() + model.nsite() + model.nbody()) + MOST_MARKS;
        let raw = &mut *scene.0;
        // SAFETY: the model is valid and the scene is set to its defaults.
        guarded("mjv_makeScene", || unsafe { ffi::mjv_makeScene(model.raw(), raw, room as i32) })?;
        Ok(scene)
    }

    fn update(&mut self, data: &mut Data, option: &ffi::mjvOption, view: &View) -> Result<()> {
        let model = data.model().clone();
        let mut camera = camera(&view.camera, &model)?;
        let scene = &mut *self.0;
        let perturbation = by_default(ffi::mjv_defaultPerturb);
        guarded("mjv_updateScene", || {
            // SAFETY: the data are of the model and borrowed exclusively, and all else is set as the engine wants it.
            unsafe {
                scene.flags[ffi::mjRND_SKYBOX as usize] = (!view.marks_alone).into();
                ffi::mjv_updateScene(
                    model.raw(),
                    data.raw_mut(),
                    option,
                    &raw const *perturbation,
                    &raw mut *camera,
                    ffi::mjCAT_ALL as i32,
                    scene,
                );
            }
        })?;
        warned("mjv_updateScene")?;
        let filled = if view.marks_alone { 0 } else { scene.ngeom as usize };
        let room = scene.maxgeom as usize;
        // SAFETY: the engine has made room for `maxgeom` of them and filled in `ngeom`.
        let geoms = unsafe { std::slice::from_raw_parts_mut(scene.geoms, filled) };
        let looks: Vec<[f32; 4]> = geoms.iter().map(|geom| geom.rgba).collect();
        for geom in geoms.iter_mut().filter(|geom| geom.objtype == ffi::mjOBJ_GEOM as i32) {
            if let Some(rgba) = usize::try_from(geom.objid).ok().and_then(view.repaint) {
                geom.rgba = rgba;
            }
        }
        let copies = copies(geoms, view.copies, &looks);
        assert!(
            view.marks.len() <= MOST_MARKS && filled + copies.len() + view.marks.len() < room,
            "too many marks"
        );
        for (k, copy) in copies.iter().enumerate() {
            // SAFETY: there is room for it.
            unsafe { *scene.geoms.add(filled + k) = *copy };
        }
        let filled = filled + copies.len();
        let wall = (view.marks_alone || !model.has_sky()).then(|| wall(&scene.camera[0]));
        let count = wall.iter().len() + view.marks.len();
        for (k, mark) in wall.iter().chain(view.marks).enumerate() {
            let kind = mark.kind.to_raw().expect("a mark of a shape that stands alone");
            let rotation = mark.pose.rotation.to_rotation_matrix();
            let rows: Rotation3<f64> = rotation.transpose();
            // SAFETY: there is room for it; sizes and position are three numbers, the matrix nine by rows, the colour
            // four.
            unsafe {
                let geom = scene.geoms.add(filled + k);
                ffi::mjv_initGeom(
                    geom,
                    kind,
                    mark.size.as_ptr(),
                    mark.pose.translation.vector.as_ptr(),
                    rows.matrix().as_ptr(),
                    mark.rgba.as_ptr(),
                );
                (*geom).emission = mark.emission;
                if mark.emission >= 1.0 {
                    (*geom).specular = 0.0;
                }
            }
        }
        scene.ngeom = (filled + count) as i32;
        Ok(())
    }
}

impl Drop for EngineScene {
    fn drop(&mut self) {
        // SAFETY: made or set to its defaults by the engine, and freed once.
        unsafe { ffi::mjv_freeScene(&raw mut *self.0) }
    }
}

/// Geoms of a scene a second time, in the colours that they had, where they are to be then; where one is where it was, the
/// first is not to be seen.
fn copies(geoms: &mut [ffi::mjvGeom], wanted: &[GeomCopy], looks: &[[f32; 4]]) -> Vec<ffi::mjvGeom> {
    let place: HashMap<usize, &Isometry3<f64>> = wanted.iter().map(|copy| (copy.geom, &copy.pose)).collect();
    let of_model = geoms.iter_mut().zip(looks).filter(|(geom, _)| geom.objtype == ffi::mjOBJ_GEOM as i32);
    let copy = |(geom, rgba): (&mut ffi::mjvGeom, &[f32; 4])| {
        let pose = place.get(&usize::try_from(geom.objid).ok()?)?;
        let rows = pose.rotation.to_rotation_matrix().transpose();
        let mut copy = ffi::mjvGeom { rgba: *rgba, ..*geom };
        let position = pose.translation.vector.cast::<f32>();
        copy.pos.iter_mut().zip(position.iter()).for_each(|(own, x)| *own = *x);
        // Rows one after the other.
        copy.mat.iter_mut().zip(rows.matrix().iter()).for_each(|(own, x)| *own = *x as f32);
        let apart =
            |own: &[f32], other: &[f32], by: f32| own.iter().zip(other).any(|(a, b)| (a - b).abs() > by);
        if !apart(&geom.pos, &copy.pos, SAME_PLACE) && !apart(&geom.mat, &copy.mat, SAME_TURN) {
            geom.rgba[3] = 0.0;
        }
        Some(copy)
    };
    of_model.filter_map(copy).collect()
}

/// A white wall that fills all that a camera sees, behind everything: MuJoCo paints black where a model has no sky.
fn wall(camera: &ffi::mjvGLCamera) -> Mark {
    const NEARER_THAN_FAR: f32 = 0.9;
    let far = f64::from(NEARER_THAN_FAR * camera.frustum_far);
    let [ahead, eye] = [camera.forward, camera.pos].map(|v| Vector3::from(v).cast::<f64>());
    // Wide enough for any lens and picture.
    let size = [4.0 * far, 4.0 * far, 1e-3 * far];
    let rotation = z_onto(&ahead);
    let pose = Isometry3::from_parts(Translation3::from(eye + ahead * far), rotation);
    // With any light on it, it is as white as can be.
    Mark { kind: GeomKind::Box, size, pose, rgba: [1.0; 4], emission: 1.0 }
}

/// A camera as the engine has it.
fn camera(camera: &Camera, model: &Model) -> Result<Box<ffi::mjvCamera>> {
    let mut raw = by_default(ffi::mjv_defaultCamera);
    match *camera {
        Camera::Free { lookat, distance, azimuth, elevation } => {
            raw.type_ = ffi::mjCAMERA_FREE as i32;
            raw.lookat = [lookat.x, lookat.y, lookat.z];
            raw.distance = distance;
            (raw.azimuth, raw.elevation) = (azimuth.to_degrees(), elevation.to_degrees());
        }
        Camera::Fixed(i) if i < model.cameras().len() => {
            raw.type_ = ffi::mjCAMERA_FIXED as i32;
            raw.fixedcamid = i as i32;
        }
        Camera::Fixed(i) => {
            let message = format!("the model has no camera {i}");
            return Err(Error::Engine { call: "mjv_updateScene", message });
        }
    }
    Ok(raw)
}
