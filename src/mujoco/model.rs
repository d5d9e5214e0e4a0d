//! The model: a creature and its surroundings as MuJoCo compiled them; constant and shared. Long for its accessors, a few lines
//! each.

use std::ffi::CStr;
use std::ops::Range;
use std::ptr::NonNull;

use nalgebra::Vector3;

use super::element::{
    Equality, Geom, GeomKind, JointKind, ModelBody, ModelJoint, ObjectKind, Sensor, SensorKind, Site, Tuple,
    TupleEntry, quaternion, vector,
};
use super::engine::{self, Version};
use super::error::{Error, Result};
use super::ffi;

/// A compiled model: constant, shared by all threads through an `Arc`.
///
/// Elements are numbered from 0 within their type, in the file's order. Accessors panic on an index
/// that is not below the element's count, as slices do.
pub struct Model {
    pub(super) raw: NonNull<ffi::mjModel>,
    pub(super) version: Version,
    pub(super) warning: Option<String>,
}

// SAFETY: after loading nothing writes to the model, neither here nor in the engine, whose functions
// take it as const.
unsafe impl Send for Model {}
// SAFETY: as above; shared reads of constant memory.
unsafe impl Sync for Model {}

impl Drop for Model {
    fn drop(&mut self) {
        // SAFETY: made by mj_loadXML, owned by this value alone, freed once.
        unsafe { ffi::mj_deleteModel(self.raw.as_ptr()) }
    }
}

impl std::fmt::Debug for Model {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Model")
            .field("nbody", &self.nbody())
            .field("njnt", &self.njnt())
            .field("ngeom", &self.ngeom())
            .finish_non_exhaustive()
    }
}

/// Slices one of the model's arrays: `array!(model, geom_pos[ngeom * 3])`.
macro_rules! array {
    ($model:expr, $field:ident[$count:ident $(* $width:literal)?]) => {{
        let raw = $model.raw();
        // SAFETY: the engine allocates `$count * $width` elements for `$field` (mjmodel.h), all
        // initialised and constant for the model's life.
        unsafe { slice(raw.$field, raw.$count as usize $(* $width)?) }
    }};
}

impl Model {
    /// The name under which messages speak of a model from a string.
    pub const STRING_NAME: &'static str = "the model's XML text";

    /// A model of its own with the same content.
    pub(super) fn copy(&self) -> Result<Self> {
        let raw = engine::guarded("mj_copyModel", || {
            // SAFETY: the model is valid and constant; for a null target the engine makes a new model.
            unsafe { ffi::mj_copyModel(std::ptr::null_mut(), self.raw.as_ptr()) }
        })?;
        let no_memory = || Error::Engine {
            call: "mj_copyModel",
            message: "it has no memory for the model: use a smaller model".into(),
        };
        let raw = NonNull::new(raw).ok_or_else(no_memory)?;
        Ok(Self { raw, version: self.version, warning: self.warning.clone() })
    }

    /// A copy in which a body is elsewhere in its parent's frame, metres.
    ///
    /// # Errors
    /// [`Error::Engine`] where there is no memory for it.
    ///
    /// # Panics
    /// Where there is no such body.
    pub fn with_body_position(&self, body: usize, position: &Vector3<f64>) -> Result<Self> {
        assert!(body < self.nbody(), "no body {body}");
        let mut copy = self.copy()?;
        let raw = copy.raw_mut();
        for (i, coordinate) in (3 * body..).zip(position) {
            // SAFETY: the copy is not shared yet, and the array holds three numbers per body.
            unsafe { *(*raw).body_pos.add(i) = *coordinate }
        }
        Ok(copy)
    }

    /// For changes to a model that is not shared yet.
    pub(super) fn raw_mut(&mut self) -> *mut ffi::mjModel {
        self.raw.as_ptr()
    }

    pub(super) fn raw(&self) -> &ffi::mjModel {
        // SAFETY: valid and constant from loading to drop.
        unsafe { self.raw.as_ref() }
    }

    /// The version of the engine that compiled the model.
    pub fn version(&self) -> Version {
        self.version
    }

    /// What the engine warned of while it compiled the model, if anything.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// The number of coordinates of a posture.
    pub fn nq(&self) -> usize {
        self.raw().nq as usize
    }

    /// How long a step of the simulation is, seconds.
    pub fn timestep(&self) -> f64 {
        self.raw().opt.timestep
    }

    /// The acceleration of free fall in the world's frame, m/s².
    pub fn gravity(&self) -> Vector3<f64> {
        vector(&self.raw().opt.gravity)
    }

    /// The number of degrees of freedom.
    pub fn nv(&self) -> usize {
        self.raw().nv as usize
    }

    /// The number of bodies, the world among them.
    pub fn nbody(&self) -> usize {
        self.raw().nbody as usize
    }

    /// The number of joints.
    pub fn njnt(&self) -> usize {
        self.raw().njnt as usize
    }

    /// The number of geoms.
    pub fn ngeom(&self) -> usize {
        self.raw().ngeom as usize
    }

    /// The number of sites.
    pub fn nsite(&self) -> usize {
        self.raw().nsite as usize
    }

    /// The number of sensors.
    pub fn nsensor(&self) -> usize {
        self.raw().nsensor as usize
    }

    #[cfg(feature = "render")]
    /// Whether the model has a sky.
    pub(super) fn has_sky(&self) -> bool {
        array!(self, tex_type[ntex]).contains(&(ffi::mjTEXTURE_SKYBOX as i32))
    }

    /// The names of the cameras, empty where one has none.
    pub fn cameras(&self) -> Vec<&str> {
        let count = self.raw().ncam as usize;
        (0..count).map(|i| self.name(ObjectKind::Camera, i).unwrap_or_default()).collect()
    }

    /// The reference posture: `nq` coordinates in radians and metres, quaternions w x y z.
    pub fn qpos0(&self) -> &[f64] {
        array!(self, qpos0[nq])
    }

    /// Body `i`.
    pub fn body(&self, i: usize) -> ModelBody<'_> {
        ModelBody {
            name: self.name(ObjectKind::Body, i),
            parent: array!(self, body_parentid[nbody])[i] as usize,
            weld: self.weld(i),
            pos: vector(&array!(self, body_pos[nbody * 3])[3 * i..]),
            quat: quaternion(&array!(self, body_quat[nbody * 4])[4 * i..]),
            joints: range(array!(self, body_jntadr[nbody])[i], array!(self, body_jntnum[nbody])[i]),
            geoms: range(array!(self, body_geomadr[nbody])[i], array!(self, body_geomnum[nbody])[i]),
            mass: array!(self, body_mass[nbody])[i],
            ipos: vector(&array!(self, body_ipos[nbody * 3])[3 * i..]),
            iquat: quaternion(&array!(self, body_iquat[nbody * 4])[4 * i..]),
            inertia: vector(&array!(self, body_inertia[nbody * 3])[3 * i..]),
        }
    }

    /// All bodies, the world first; parents come before their children.
    pub fn bodies(&self) -> impl ExactSizeIterator<Item = ModelBody<'_>> {
        (0..self.nbody()).map(|i| self.body(i))
    }

    /// Joint `i`.
    pub fn joint(&self, i: usize) -> ModelJoint<'_> {
        let limits = &array!(self, jnt_range[njnt * 2])[2 * i..];
        ModelJoint {
            name: self.name(ObjectKind::Joint, i),
            kind: JointKind::from_raw(array!(self, jnt_type[njnt])[i]),
            body: array!(self, jnt_bodyid[njnt])[i] as usize,
            qposadr: array!(self, jnt_qposadr[njnt])[i] as usize,
            dofadr: array!(self, jnt_dofadr[njnt])[i] as usize,
            pos: vector(&array!(self, jnt_pos[njnt * 3])[3 * i..]),
            axis: vector(&array!(self, jnt_axis[njnt * 3])[3 * i..]),
            limited: is_set(array!(self, jnt_limited[njnt])[i]),
            range: [limits[0], limits[1]],
        }
    }

    /// All joints; those of one body are adjacent.
    pub fn joints(&self) -> impl ExactSizeIterator<Item = ModelJoint<'_>> {
        (0..self.njnt()).map(|i| self.joint(i))
    }

    /// Geom `i`.
    pub fn geom(&self, i: usize) -> Geom<'_> {
        let size = &array!(self, geom_size[ngeom * 3])[3 * i..];
        Geom {
            name: self.name(ObjectKind::Geom, i),
            kind: self.geom_kind(i),
            body: self.geom_body(i),
            size: [size[0], size[1], size[2]],
            pos: vector(&array!(self, geom_pos[ngeom * 3])[3 * i..]),
            quat: quaternion(&array!(self, geom_quat[ngeom * 4])[4 * i..]),
            contype: array!(self, geom_contype[ngeom])[i] as u32,
            conaffinity: array!(self, geom_conaffinity[ngeom])[i] as u32,
            group: array!(self, geom_group[ngeom])[i],
            rbound: array!(self, geom_rbound[ngeom])[i],
        }
    }

    /// The colour of geom `i`, red, green, blue and opacity, 0 to 1: its own, or that of its material where it has
    /// none; `None` if nobody painted it.
    pub fn geom_rgba(&self, i: usize) -> Option<[f32; 4]> {
        /// What the engine gives geoms without a colour.
        const NONE: [f32; 4] = [0.5, 0.5, 0.5, 1.0];
        let four = |numbers: &[f32], k: usize| [0, 1, 2, 3].map(|part| numbers[4 * k + part]);
        let own = four(array!(self, geom_rgba[ngeom * 4]), i);
        let material = usize::try_from(array!(self, geom_matid[ngeom])[i]).ok();
        let of_material = material.map(|material| four(array!(self, mat_rgba[nmat * 4]), material));
        Some(own).filter(|own| *own != NONE).or(of_material)
    }

    /// All geoms; those of one body are adjacent.
    pub fn geoms(&self) -> impl ExactSizeIterator<Item = Geom<'_>> {
        (0..self.ngeom()).map(|i| self.geom(i))
    }

    /// The shape of geom `i`.
    pub fn geom_kind(&self, i: usize) -> GeomKind {
        GeomKind::from_raw(array!(self, geom_type[ngeom])[i])
    }

    /// The body that geom `i` is fixed to.
    pub fn geom_body(&self, i: usize) -> usize {
        array!(self, geom_bodyid[ngeom])[i] as usize
    }

    /// The mesh's vertices in the frame of geom `i`, in metres; empty where it is no mesh.
    ///
    /// The engine's own frame of the mesh: the geom's position and orientation go with it, which are
    /// those of the mesh's inertia and not the file's.
    pub fn mesh_vertices(&self, i: usize) -> Vec<Vector3<f64>> {
        let mesh = self.mesh_of_geom(i).filter(|_| self.geom_kind(i) == GeomKind::Mesh);
        let Some(mesh) = mesh else { return Vec::new() };
        let vertices =
            range(array!(self, mesh_vertadr[nmesh])[mesh], array!(self, mesh_vertnum[nmesh])[mesh]);
        let coordinates = array!(self, mesh_vert[nmeshvert * 3]);
        coordinates[3 * vertices.start..3 * vertices.end]
            .chunks_exact(3)
            .map(|xyz| Vector3::new(xyz[0].into(), xyz[1].into(), xyz[2].into()))
            .collect()
    }

    /// The convex hull of the mesh of geom `i`, in the frame of [`Model::mesh_vertices`]: its corners, in metres, and its
    /// faces, three corners each; `None` if the engine made no hull, which it does for meshes that can collide alone.
    #[allow(clippy::type_complexity, reason = "corners and faces are what every mesh is")]
    pub fn mesh_hull(&self, i: usize) -> Option<(Vec<Vector3<f64>>, Vec<[usize; 3]>)> {
        let vertices = self.mesh_vertices(i);
        let mesh = self.mesh_of_geom(i).filter(|_| !vertices.is_empty())?;
        let start = usize::try_from(array!(self, mesh_graphadr[nmesh])[mesh]).ok()?;
        // Counts of vertices and faces; per vertex its first edge and its index; the edges; the faces.
        let graph = array!(self, mesh_graph[nmeshgraph]).get(start..)?;
        let [corners, faces] = [graph.first()?, graph.get(1)?].map(|&count| count.max(0) as usize);
        let numbers = graph.get(2 + corners..2 + 2 * corners)?;
        let from = 2 + 3 * corners + 3 * faces;
        let faces = graph.get(from..from + 3 * faces)?;
        // Of all the mesh's vertices only the corners matter.
        let mut place = vec![usize::MAX; vertices.len()];
        let mut kept = Vec::with_capacity(corners);
        for &vertex in numbers {
            *place.get_mut(usize::try_from(vertex).ok()?)? = kept.len();
            kept.push(vertices[vertex as usize]);
        }
        let corner = |vertex: i32| place.get(usize::try_from(vertex).ok()?).copied();
        let faces =
            faces.chunks_exact(3).map(|face| Some([corner(face[0])?, corner(face[1])?, corner(face[2])?]));
        Some((kept, faces.collect::<Option<_>>()?))
    }

    /// The mesh that geom `i` is of, if it is of one.
    pub(crate) fn mesh_of_geom(&self, i: usize) -> Option<usize> {
        usize::try_from(array!(self, geom_dataid[ngeom])[i]).ok()
    }

    /// The name of mesh `i`, where it has one and the engine made no hull for it.
    pub(crate) fn name_without_hull(&self, i: usize) -> Option<String> {
        let has_hull = array!(self, mesh_graphadr[nmesh])[i] >= 0;
        self.name(ObjectKind::from_raw(ffi::mjOBJ_MESH as i32), i).filter(|_| !has_hull).map(str::to_string)
    }

    /// Site `i`.
    pub fn site(&self, i: usize) -> Site<'_> {
        let size = &array!(self, site_size[nsite * 3])[3 * i..];
        Site {
            name: self.name(ObjectKind::Site, i),
            kind: GeomKind::from_raw(array!(self, site_type[nsite])[i]),
            body: array!(self, site_bodyid[nsite])[i] as usize,
            size: [size[0], size[1], size[2]],
            pos: vector(&array!(self, site_pos[nsite * 3])[3 * i..]),
            quat: quaternion(&array!(self, site_quat[nsite * 4])[4 * i..]),
        }
    }

    /// Sensor `i`.
    pub fn sensor(&self, i: usize) -> Sensor {
        Sensor {
            kind: SensorKind::from_raw(array!(self, sensor_type[nsensor])[i]),
            object: ObjectKind::from_raw(array!(self, sensor_objtype[nsensor])[i]),
            id: usize::try_from(array!(self, sensor_objid[nsensor])[i]).ok(),
            adr: array!(self, sensor_adr[nsensor])[i] as usize,
            dim: array!(self, sensor_dim[nsensor])[i] as usize,
            cutoff: array!(self, sensor_cutoff[nsensor])[i],
            noise: array!(self, sensor_noise[nsensor])[i],
        }
    }

    /// Whether sensors are computed at all: a file may disable them.
    pub fn has_sensors_enabled(&self) -> bool {
        self.raw().opt.disableflags as u32 & ffi::mjDSBL_SENSOR == 0
    }

    /// Whether the file asks for the noise of its sensors; newer engines know of no such wish.
    pub fn has_sensor_noise(&self) -> bool {
        let wish = ffi::mjENBL_SENSORNOISE;
        self.raw().opt.enableflags as u32 & wish != 0
    }

    /// The active equality constraints, in the file's order.
    pub fn equalities(&self) -> Vec<Equality> {
        let kinds = array!(self, eq_type[neq]);
        let (first, second) = (array!(self, eq_obj1id[neq]), array!(self, eq_obj2id[neq]));
        #[cfg(not(mujoco_eq_active0))]
        let active = array!(self, eq_active[neq]);
        #[cfg(mujoco_eq_active0)]
        let active = array!(self, eq_active0[neq]);
        let width = ffi::mjNEQDATA as usize;
        // SAFETY: the engine allocates `neq * mjNEQDATA` numbers (mjmodel.h), constant for the model's life.
        let numbers = unsafe { slice(self.raw().eq_data, kinds.len() * width) };
        let equality = |e: usize| {
            if kinds[e] as u32 != ffi::mjEQ_JOINT {
                return Equality::Other;
            }
            let mut polynomial = [0.0; 5];
            polynomial.copy_from_slice(&numbers[e * width..e * width + 5]);
            Equality::Joint {
                follower: first[e] as usize,
                leader: usize::try_from(second[e]).ok(),
                polynomial,
            }
        };
        (0..kinds.len()).filter(|&e| is_set(active[e])).map(equality).collect()
    }

    /// All sensors.
    pub fn sensors(&self) -> impl ExactSizeIterator<Item = Sensor> {
        (0..self.nsensor()).map(|i| self.sensor(i))
    }

    /// The tuples under `<custom>`, in the file's order.
    pub fn tuples(&self) -> Vec<Tuple<'_>> {
        let kinds = array!(self, tuple_objtype[ntupledata]);
        let ids = array!(self, tuple_objid[ntupledata]);
        let numbers = array!(self, tuple_objprm[ntupledata]);
        let starts = array!(self, tuple_adr[ntuple]);
        let sizes = array!(self, tuple_size[ntuple]);
        let entry = |k: usize| TupleEntry {
            object: ObjectKind::from_raw(kinds[k]),
            id: ids[k] as usize,
            prm: numbers[k],
        };
        (0..starts.len())
            .map(|i| Tuple {
                name: self.name(ObjectKind::Tuple, i),
                entries: range(starts[i], sizes[i]).map(entry).collect(),
            })
            .collect()
    }

    /// The model's name: `<mujoco model="…">`, or MuJoCo's default.
    pub fn model_name(&self) -> Option<&str> {
        // SAFETY: `names` starts with the model's name, zero-terminated, and lives in the model.
        unsafe { CStr::from_ptr(self.raw().names).to_str().ok() }
    }

    /// The index of the element called `name`, if there is one; none of elements that the crate has no word for.
    ///
    /// The engine's own index of names is of no use in copies: it goes by counts of excludes and pairs, which a copy may
    /// have none of.
    pub fn id(&self, object: ObjectKind, name: &str) -> Option<usize> {
        (0..self.count(object)).find(|&i| self.name(object, i) == Some(name))
    }

    /// How many elements of a type there are; none of those that the crate has no word for.
    fn count(&self, object: ObjectKind) -> usize {
        match object {
            ObjectKind::Body => self.nbody(),
            ObjectKind::Joint => self.njnt(),
            ObjectKind::Geom => self.ngeom(),
            ObjectKind::Site => self.nsite(),
            ObjectKind::Sensor => self.nsensor(),
            ObjectKind::Tuple => self.raw().ntuple as usize,
            ObjectKind::Camera => self.raw().ncam as usize,
            ObjectKind::Other(_) => 0,
        }
    }

    /// The name of an element, if it has one and it is UTF-8.
    pub fn name(&self, object: ObjectKind, i: usize) -> Option<&str> {
        let i = i32::try_from(i).ok()?;
        // SAFETY: the model is valid; an index out of range gives null, a name lives in the model.
        unsafe {
            let name = ffi::mj_id2name(self.raw(), object.to_raw(), i);
            if name.is_null() { None } else { CStr::from_ptr(name).to_str().ok() }
        }
    }

    /// The body that body `i` moves as one with: itself, or the ancestor that it has no joint to.
    pub fn weld(&self, i: usize) -> usize {
        array!(self, body_weldid[nbody])[i] as usize
    }

    pub(super) fn parents(&self) -> &[i32] {
        array!(self, body_parentid[nbody])
    }

    pub(crate) fn contact_bits(&self, i: usize) -> (i32, i32) {
        (array!(self, geom_contype[ngeom])[i], array!(self, geom_conaffinity[ngeom])[i])
    }

    pub(super) fn exclude_signatures(&self) -> &[i32] {
        array!(self, exclude_signature[nexclude])
    }

    /// The geoms of the explicit contact pairs.
    pub(super) fn pair_geoms(&self) -> (&[i32], &[i32]) {
        (array!(self, pair_geom1[npair]), array!(self, pair_geom2[npair]))
    }
}

/// A slice of one of the engine's arrays, empty for null.
///
/// # Safety
/// `pointer` is null or points to `count` initialised elements that live and stay constant for `'a`.
pub(super) unsafe fn slice<'a, T>(pointer: *const T, count: usize) -> &'a [T] {
    if pointer.is_null() || count == 0 {
        return &[];
    }
    // SAFETY: as promised by the caller; the engine aligns its arrays for their type.
    unsafe { std::slice::from_raw_parts(pointer, count) }
}

/// `count` indices from `start`; MuJoCo writes -1 for the start of nothing.
fn range(start: i32, count: i32) -> Range<usize> {
    let start = start.max(0) as usize;
    start..start + count.max(0) as usize
}

/// One of the engine's flags, which it keeps in a byte or a bool as the version has it.
fn is_set(flag: impl Into<u8>) -> bool {
    flag.into() != 0
}
