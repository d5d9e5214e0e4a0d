//! Skin that grows: on every shape, evenly, everywhere it can be touched and nowhere else; into files of all
//! kinds, and in memory.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::common::{creature, max, repository};
use bodyschema::creature::{Body, JointSelection};
use bodyschema::geometry::Shape;
use bodyschema::mujoco::{Data, GeomKind, Model, ObjectKind, SensorKind, schema};
use bodyschema::skin::{GrowOptions, PatchSize, Receptor, Skin, grow, grow_skin, skin_of};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Numbers are written to a micrometre.
const WRITTEN: f64 = 2e-6;
/// A receptor's centre lies on its surface to this, metres.
const ON_SURFACE: f64 = 1e-9;
/// Standard deviation of the patches' areas on one surface, over their mean.
const UNEVEN: f64 = 0.4;
/// The median of longer over shorter side on one surface.
const OBLONG: f64 = 1.6;
/// The share of exposed points that receptors hold.
const HELD: f64 = 0.995;
/// The same where there are no more receptors than each surface needs.
const HELD_BY_FEW: f64 = 0.9;
/// The same on creatures with limbs that are thin by the size of their receptors.
const HELD_BY_CREATURE: f64 = 0.97;

/// A creature with all shapes, each hinged to a trunk by itself and some with a second geom that it buries in
/// part; `SCALE` is a length. The wedge is a mesh.
fn shapes(scale: f64) -> String {
    let n = |values: &[f64]| values.iter().map(|x| (x * scale).to_string()).collect::<Vec<_>>().join(" ");
    let limb = |k: usize, name: &str, kind: &str, geom: String, more: String| {
        let at = n(&[0.6 * k as f64, 0.0, 0.4]);
        format!(
            "<body name='{name}' pos='{at}' euler='0.3 {k} 0.2'><joint name='{name}' axis='0.2 1 {k}' range='-1 1'/>\
             <geom name='{name}' type='{kind}' {geom}/>{more}</body>"
        )
    };
    let wedge = n(&[
        0.1, 0.0, 0.0, -0.1, 0.02, 0.0, 0.0, 0.15, 0.0, 0.0, -0.1, 0.05, 0.05, 0.05, 0.2, -0.05, 0.1, 0.18,
        0.0, 0.02, 0.05,
    ]);
    let knob = |x: f64| format!("<geom type='sphere' pos='{}' size='{}'/>", n(&[x, 0.03, 0.0]), n(&[0.06]));
    format!(
        "<mujoco model='shapes'><compiler angle='radian' autolimits='true'/>\
         <asset><mesh name='wedge' vertex='{wedge}'/></asset><worldbody><body name='trunk'>\
         <geom name='trunk' type='capsule' fromto='{}' size='{}'/>{}{}{}{}{}{}</body></worldbody></mujoco>",
        n(&[0.0, 0.0, 0.0, 3.0, 0.0, 0.0]),
        n(&[0.1]),
        limb(0, "ball", "sphere", format!("size='{}'", n(&[0.12])), String::new()),
        limb(1, "pill", "capsule", format!("size='{}'", n(&[0.05, 0.12])), knob(0.05)),
        limb(2, "tube", "cylinder", format!("size='{}'", n(&[0.08, 0.1])), String::new()),
        limb(3, "brick", "box", format!("size='{}'", n(&[0.05, 0.1, 0.15])), knob(0.04)),
        limb(4, "egg", "ellipsoid", format!("size='{}'", n(&[0.05, 0.08, 0.16])), String::new()),
        limb(5, "wedge", "mesh", "mesh='wedge'".into(), String::new()),
    )
}

fn counted(receptors: usize) -> GrowOptions {
    GrowOptions { size: PatchSize::Count(receptors), denser: Vec::new() }
}

fn area(receptor: &Receptor) -> f64 {
    4.0 * receptor.half_extents[0] * receptor.half_extents[1]
}

/// A body from a file, moving all joints.
fn from_file(path: &Path) -> Body {
    let model = Model::from_path(path).unwrap_or_else(|error| panic!("{error}"));
    Body::new(Arc::new(model), &JointSelection::All).unwrap()
}

/// Grows a skin on MJCF text by way of files: what the commands do.
fn grown_file(xml: &str, options: &GrowOptions) -> Body {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bare.xml");
    fs::write(&path, xml).unwrap();
    let text = grow_skin(&path, options).unwrap().text(None);
    fs::write(&path, &text).unwrap();
    from_file(&path)
}

/// That two skins are one but for what rounding in a file does.
fn same(found: &Skin, expected: &Skin, tolerance: f64) {
    assert_eq!(found.receptors.len(), expected.receptors.len());
    let by_id: BTreeMap<&str, &Receptor> = expected.receptors.iter().map(|r| (r.id.as_str(), r)).collect();
    for receptor in &found.receptors {
        let id = receptor.id.as_str();
        let other = by_id.get(id).unwrap_or_else(|| panic!("{id} did not grow in memory"));
        assert_eq!((receptor.limb, receptor.surface), (other.limb, other.surface), "{id}");
        assert!((receptor.position - other.position).norm() < tolerance, "{id}");
        assert!((receptor.normal - other.normal).norm() < 1e-4, "{id}");
        assert!((receptor.tangent - other.tangent).norm() < 1e-4, "{id}");
        for k in 0..2 {
            assert!((receptor.half_extents[k] - other.half_extents[k]).abs() < tolerance, "{id}");
        }
    }
}

/// A random point of a surface, in the limb's frame, with the outward normal: evenly enough to look everywhere.
fn random_point(shape: &Shape, rng: &mut ChaCha8Rng) -> (Vector3<f64>, Vector3<f64>) {
    let reach = 2.0 * shape.half_bounds().norm();
    loop {
        // A point far off, drawn to the surface, and a step along it.
        let direction = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        if !(0.01..1.0).contains(&direction.norm_squared()) {
            continue;
        }
        let bounds = shape.half_bounds();
        let far = direction.normalize().component_mul(&bounds) * (1.0 + rng.random_range(0.0..0.5))
            + direction * (0.01 * reach);
        let (distance, normal) = shape.signed_distance(&far).unwrap();
        if distance > 0.0 {
            return (far - normal * distance, normal);
        }
    }
}

#[test]
fn patches_of_every_shape_are_even_and_nearly_square_and_lie_on_it() {
    let body = creature(&shapes(1.0));
    let skin = grow(&body, &counted(500)).unwrap();
    assert_eq!(skin.receptors.len(), 500);
    let mut kinds = Vec::new();
    for (s, surface) in skin.surfaces.iter().enumerate() {
        let on: Vec<&Receptor> = skin.receptors.iter().filter(|r| r.surface == Some(s)).collect();
        let name = body.model.geom(surface.geom).name;
        assert!(!on.is_empty(), "{name:?} is bare");
        for receptor in &on {
            let id = &receptor.id;
            let (distance, normal) = surface.signed_distance(&receptor.position).unwrap();
            assert!(distance.abs() < ON_SURFACE, "{id}: {distance}");
            assert!(normal.dot(&receptor.normal) > 0.99, "{id}: {normal} and {}", receptor.normal);
            assert_eq!(surface.limb, receptor.limb, "{id}");
        }
        let areas: Vec<f64> = on.iter().map(|r| area(r)).collect();
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        let variance = areas.iter().map(|a| (a - mean).powi(2)).sum::<f64>() / areas.len() as f64;
        let mut sides: Vec<f64> =
            on.iter().map(|r| r.half_extents[0] / r.half_extents[1]).map(|x| x.max(1.0 / x)).collect();
        sides.sort_by(f64::total_cmp);
        let (uneven, oblong) = (variance.sqrt() / mean, sides[sides.len() / 2]);
        println!("{name:?} {} patches, {uneven:.2} uneven, {oblong:.2} oblong", on.len());
        assert!(uneven < UNEVEN, "{name:?}: {uneven}");
        assert!(oblong < OBLONG, "{name:?}: {oblong}");
        kinds.push(body.model.geom_kind(surface.geom));
    }
    use GeomKind::*;
    for kind in [Sphere, Capsule, Cylinder, Box, Ellipsoid, Mesh] {
        assert!(kinds.contains(&kind), "no {kind:?} was looked at");
    }
}

#[test]
fn every_exposed_point_is_held_by_a_receptor_and_no_receptor_is_buried() {
    let fixed: [(&str, Body, GrowOptions); 3] = [
        ("shapes", creature(&shapes(1.0)), counted(300)),
        ("as few as will do", creature(&shapes(1.0)), counted(1)),
        ("Max", max("all"), GrowOptions::default()),
    ];
    let zoo = ["hexapod", "octopus", "snake", "fourarms", "sauropod", "contraption"].map(|name| {
        let body = from_file(&repository(&format!("mjcf/{name}/{name}.xml")));
        (name, body, GrowOptions::default())
    });
    for (name, body, options) in fixed.into_iter().chain(zoo) {
        let skin = grow(&body, &options).unwrap();
        let limb_surfaces = |limb: usize, not: usize| {
            skin.surfaces.iter().enumerate().filter(move |(s, surface)| surface.limb == limb && *s != not)
        };
        let deep = |limb: usize, own: usize, p: &Vector3<f64>| {
            limb_surfaces(limb, own)
                .any(|(_, surface)| surface.signed_distance(p).is_some_and(|(d, _)| d < -1e-3))
        };
        for receptor in &skin.receptors {
            let own = receptor.surface.unwrap();
            assert!(!deep(receptor.limb, own, &receptor.position), "{name}: {} is buried", receptor.id);
        }
        // What a limb next to it covers in the reference posture may be bare; limbs' frames agree there.
        let mut data = Data::new(body.model.clone()).unwrap();
        data.kinematics().unwrap();
        let frames: Vec<_> =
            (0..body.creature.limbs().len()).map(|limb| body.limb_pose(&data, limb)).collect();
        let covered = |limb: usize, p: &Vector3<f64>| {
            let Some(frame) = frames[limb] else { return true };
            let p_w = frame * nalgebra::Point3::from(*p);
            skin.surfaces.iter().any(|other| {
                let inside = frames[other.limb]
                    .and_then(|x| other.signed_distance(&x.inverse_transform_point(&p_w).coords));
                other.limb != limb && inside.is_some_and(|(d, _)| d < 0.0)
            })
        };
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (mut looked, mut held) = (0, 0);
        for (s, surface) in skin.surfaces.iter().enumerate() {
            for _ in 0..100 {
                let (p, normal) = random_point(&surface.shape, &mut rng);
                let p = surface.rotation * p + surface.origin;
                let normal = surface.rotation * normal;
                let buried = limb_surfaces(surface.limb, s)
                    .any(|(_, other)| other.signed_distance(&p).is_some_and(|(d, _)| d < 1e-4));
                if buried || covered(surface.limb, &p) {
                    continue;
                }
                looked += 1;
                let holds =
                    |r: &&Receptor| r.surface == Some(s) && r.holds(&p) && r.normal.dot(&normal) > 0.0;
                held += usize::from(skin.receptors.iter().any(|r| holds(&r)));
            }
        }
        let share = f64::from(held as u32) / f64::from(looked as u32);
        println!("{name}: {} receptors hold {share} of {looked} points", skin.receptors.len());
        // Patches that go half round a limb, as on Max's fingers, miss some of what is at their sides.
        let least = match options.size {
            PatchSize::OfCreature => HELD_BY_CREATURE,
            PatchSize::Count(1) => HELD_BY_FEW,
            _ => HELD,
        };
        assert!(looked > 300 && share >= least, "{name}: {share} of {looked}");
    }
}

#[test]
fn a_skin_in_a_file_is_the_one_in_memory() {
    for name in ["hexapod", "octopus", "snake", "fourarms", "sauropod", "contraption"] {
        let path = repository(&format!("mjcf/{name}/{name}.xml"));
        let folder = tempfile::tempdir().unwrap();
        let grown = grow_skin(&path, &GrowOptions::default()).unwrap();
        let file = folder.path().join("grown.xml");
        fs::write(&file, grown.text(Some(folder.path()))).unwrap();
        let skin = skin_of(&from_file(&file));
        assert_eq!(grown.receptors, skin.receptors.len(), "{name}");
        same(&skin, &grow(&from_file(&path), &GrowOptions::default()).unwrap(), WRITTEN);
    }
    let body = creature(&shapes(1.0));
    same(&skin_of(&grown_file(&shapes(1.0), &counted(200))), &grow(&body, &counted(200)).unwrap(), WRITTEN);
}

#[test]
fn the_same_creature_of_any_size_has_as_many_receptors() {
    let grown = |scale: f64| grow(&creature(&shapes(scale)), &GrowOptions::default()).unwrap();
    let unit = grown(1.0);
    assert!((200..=300).contains(&unit.receptors.len()), "{}", unit.receptors.len());
    for scale in [0.01, 10.0] {
        let other = grown(scale);
        // Rounding decides where half a receptor goes.
        let more = other.receptors.len() as f64 / unit.receptors.len() as f64;
        assert!((more - 1.0).abs() < 0.02, "{scale}: {more}");
        let mean = |skin: &Skin| skin.receptors.iter().map(area).sum::<f64>() / skin.receptors.len() as f64;
        let ratio = mean(&other) / mean(&unit) / scale.powi(2);
        assert!((ratio - 1.0).abs() < 0.05, "{scale}: {ratio}");
        // Sites this small are still known for patches of their surface.
        let written = skin_of(&grown_file(&shapes(scale), &GrowOptions::default()));
        same(&written, &other, WRITTEN * scale);
    }
}

#[test]
fn patches_have_the_size_and_the_density_that_were_asked_for() {
    let body = creature(&shapes(1.0));
    let on = |skin: &Skin, limb: &str| {
        let limb = body.creature.limb(limb).unwrap();
        skin.receptors.iter().filter(|r| r.limb == limb).count() as f64
    };
    let spaced = |side: f64, denser: &[(String, f64)]| {
        let options = GrowOptions { size: PatchSize::Spacing(side), denser: denser.to_vec() };
        grow(&body, &options).unwrap()
    };
    let expected = |limb: &str, side: f64| {
        let g = body.model.id(ObjectKind::Geom, limb).unwrap();
        let skin = skin_of(&body);
        skin.surfaces.iter().find(|s| s.geom == g).unwrap().shape.area() / (side * side)
    };
    for side in [0.08, 0.05] {
        let skin = spaced(side, &[]);
        for limb in ["ball", "tube", "egg", "wedge"] {
            let ratio = on(&skin, limb) / expected(limb, side);
            assert!((ratio - 1.0).abs() < 0.15, "{limb} at {side}: {ratio}");
        }
    }
    let denser = spaced(0.06, &[("egg".into(), 4.0)]);
    let plain = spaced(0.06, &[]);
    assert!((on(&denser, "egg") / on(&plain, "egg") - 4.0).abs() < 0.4);
    assert_eq!(on(&denser, "ball"), on(&plain, "ball"));
    for total in [200, 333, 1000] {
        assert_eq!(grow(&body, &counted(total)).unwrap().receptors.len(), total);
        assert_eq!(grow(&max_without_skin(), &counted(total)).unwrap().receptors.len(), total);
    }
    for (options, word) in [
        (GrowOptions { size: PatchSize::Spacing(1e-6), denser: Vec::new() }, "larger"),
        (GrowOptions { size: PatchSize::Spacing(-1.0), denser: Vec::new() }, "positive"),
        (GrowOptions { size: PatchSize::OfCreature, denser: vec![("egg".into(), f64::NAN)] }, "positive"),
        (GrowOptions { size: PatchSize::OfCreature, denser: vec![("tail".into(), 2.0)] }, "tail"),
    ] {
        let error = grow(&body, &options).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

fn max_without_skin() -> Body {
    from_file(&repository("mjcf/max/body.xml"))
}

#[test]
fn touch_sensors_that_are_there_stay_and_skin_grows_beside_them() {
    let xml = shapes(1.0)
        .replace("<geom name='egg'", "<site name='own' pos='0 0 0.17' size='0.03'/><geom name='egg'")
        .replace("</mujoco>", "<sensor><touch name='felt' site='own'/></sensor></mujoco>");
    let body = grown_file(&xml, &GrowOptions::default());
    let skin = skin_of(&body);
    let egg = body.creature.limb("egg").unwrap();
    let ids: Vec<&str> = skin.receptors.iter().filter(|r| r.limb == egg).map(|r| r.id.as_str()).collect();
    // It lies on a little of it: the rest is not left bare.
    assert_eq!(ids[0], "own");
    assert!(ids.len() > 5, "{ids:?}");
    assert!(skin.receptors.len() > 100);
    assert!(body.model.id(ObjectKind::Sensor, "felt").is_some());
    for limb in ["trunk", "ball", "pill", "tube", "brick", "wedge"] {
        let limb = body.creature.limb(limb).unwrap();
        assert!(skin.receptors.iter().any(|r| r.limb == limb));
    }
    same(&skin, &grow(&creature(&xml), &GrowOptions::default()).unwrap(), WRITTEN);
}

/// An arm without any name, by way of an include and of what the engine makes bodies of, under defaults made to disturb.
#[test]
fn skin_grows_into_files_of_all_kinds() {
    let arm = "<body pos='0 0 1'><joint axis='0 0 1'/><geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.03'/>\
               <body pos='0.33 0 0'><joint axis='0 1 0'/><joint type='slide' axis='1 0 0'/><geom type='box' size='0.05 0.04 0.03'/></body></body>";
    let model = |rest: &str, body: &str| {
        format!(
            "<mujoco><compiler angle='radian'/>{rest}<worldbody><body>{body}<geom type='sphere' size='0.1'/></body></worldbody></mujoco>"
        )
    };
    let disturbing = "<default><site type='capsule' size='0.3 0.3' rgba='1 0 0 1' group='5'/>\
                      <default class='receptor'><site type='sphere' size='9'/></default>\
                      <default class='limbs'><site type='ellipsoid' size='7 7 7' pos='1 1 1'/></default></default>";
    // Engines from 4.0 on have no composites, those of before 3.2 no replicas.
    let many = if schema().unwrap().contains("composite") {
        "<composite type='rope' count='4 1 1' spacing='0.3' ><geom type='capsule' size='0.05 0.08'/></composite>"
    } else {
        "<replicate count='4' offset='0.3 0 0'><body pos='0.3 0 0'><joint axis='0 1 0'/>\
         <geom type='capsule' size='0.05 0.08'/></body></replicate>"
    };
    let files: [(&str, String, usize); 5] = [
        ("no names", model("", arm), 4),
        (
            "defaults",
            model(disturbing, &arm.replace("<body pos='0.33", "<body childclass='limbs' pos='0.33")),
            4,
        ),
        ("an include", model("", "<include file='parts/arm.xml'/>"), 4),
        ("half the names", model("", &arm.replacen("<body", "<body name='body1'", 1)), 4),
        (
            "many bodies from one element",
            model("", &format!("<joint axis='1 0 0'/>{many}")).replacen("<body", "<body name='B0'", 1),
            0,
        ),
    ];
    for (name, xml, bodies) in files {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("parts")).unwrap();
        fs::write(folder.path().join("parts/arm.xml"), format!("<mujocoinclude>{arm}</mujocoinclude>"))
            .unwrap();
        let path = folder.path().join("bare.xml");
        fs::write(&path, &xml).unwrap();
        let grown =
            grow_skin(&path, &GrowOptions::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let in_memory = grow(&from_file(&path), &GrowOptions::default()).unwrap();
        fs::write(&path, grown.text(None)).unwrap();
        let body = from_file(&path);
        let skin = skin_of(&body);
        assert_eq!(skin.receptors.len(), grown.receptors, "{name}");
        assert!(grown.receptors > 100, "{name}: {}", grown.receptors);
        assert_eq!(in_memory.receptors.len(), grown.receptors, "{name}");
        for (receptor, other) in skin.receptors.iter().zip(&in_memory.receptors) {
            assert!((receptor.position - other.position).norm() < WRITTEN, "{name}: {}", receptor.id);
            assert!((receptor.normal - other.normal).norm() < 1e-4, "{name}: {}", receptor.id);
        }
        assert!(bodies == 0 || body.model.nbody() == bodies, "{name}");
        assert!((1..body.model.nbody()).all(|b| body.model.body(b).name.is_some()), "{name}");
        let positions = body.model.sensors().filter(|s| s.kind == SensorKind::JointPos).count();
        assert_eq!(positions, body.creature.dof(), "{name}");
    }
}

#[test]
fn files_are_found_from_another_folder() {
    let folder = tempfile::tempdir().unwrap();
    for part in ["robot/meshes", "results"] {
        fs::create_dir_all(folder.path().join(part)).unwrap();
    }
    let corners = [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
    let lines = corners.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let obj = format!("{lines}f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    fs::write(folder.path().join("robot/meshes/link.obj"), obj).unwrap();
    let path = folder.path().join("robot/robot.xml");
    fs::write(
        &path,
        "<mujoco><compiler meshdir='meshes'/><asset><mesh name='link' file='link.obj'/></asset><worldbody>\
         <body><geom type='mesh' mesh='link'/><body pos='0 0 0.5'><joint/><geom type='mesh' mesh='link'/></body></body>\
         </worldbody></mujoco>",
    )
    .unwrap();
    let grown = grow_skin(&path, &GrowOptions::default()).unwrap();
    for place in ["results", "robot"] {
        let place = folder.path().join(place);
        let file = place.join("grown.xml");
        fs::write(&file, grown.text(Some(&place))).unwrap();
        let skin = skin_of(&from_file(&file));
        assert_eq!(skin.receptors.len(), grown.receptors, "{}", place.display());
        for surface in &skin.surfaces {
            assert!(matches!(surface.shape, Shape::Hull(_)));
        }
    }
}

#[test]
fn a_slide_draws_out_what_was_inside_and_a_hinge_does_not() {
    let rod = |joint: &str| {
        format!(
            "<mujoco><compiler angle='radian' autolimits='true'/><worldbody><body name='barrel'>\
             <geom type='cylinder' size='0.1 0.2'/><body name='rod'>{joint}\
             <geom name='rod' type='capsule' size='0.05 0.1'/></body></body></worldbody></mujoco>"
        )
    };
    let on_rod = |joint: &str| {
        let body = creature(&rod(joint));
        let limb = body.creature.limb("rod").unwrap();
        let skin = grow(&body, &GrowOptions::default()).unwrap();
        skin.receptors.iter().filter(|r| r.limb == limb).count()
    };
    assert_eq!(on_rod("<joint axis='0 0 1' range='-1 1'/>"), 0);
    let (short, long) = (
        on_rod("<joint type='slide' axis='0 0 1' range='0 0.1'/>"),
        on_rod("<joint type='slide' axis='0 0 1' range='0 0.3'/>"),
    );
    assert!(0 < short && short < long, "{short} and {long}");
}

#[test]
fn other_limbs_of_the_reference_posture_bury_nothing() {
    // Two arms that lie in each other in the reference posture, which the trunk alone carries.
    let arm = |name: &str, y: f64| {
        format!(
            "<body name='{name}' pos='0 {y} 0'><joint axis='0 0 1'/>\
             <geom type='capsule' fromto='0.1 0 0 0.4 {} 0' size='0.04'/></body>",
            -y
        )
    };
    let body = |arms: &str| {
        creature(&format!(
            "<mujoco><worldbody><body name='trunk'><geom size='0.05'/>{arms}</body></worldbody></mujoco>"
        ))
    };
    let (left, right) = (arm("left", 0.1), arm("right", -0.1));
    let size = GrowOptions { size: PatchSize::Spacing(0.03), denser: Vec::new() };
    let on_left = |body: &Body| {
        let limb = body.creature.limb("left").unwrap();
        grow(body, &size).unwrap().receptors.iter().filter(|r| r.limb == limb).count()
    };
    assert_eq!(on_left(&body(&(left.clone() + &right))), on_left(&body(&left)));
}

#[test]
fn what_can_not_be_touched_grows_no_skin() {
    let inertia = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>";
    let xml = format!(
        "<mujoco><worldbody><geom size='1'/><body name='trunk'>{inertia}\
         <body name='limb'><joint/>{inertia}</body></body></worldbody></mujoco>"
    );
    assert!(grow(&creature(&xml), &GrowOptions::default()).unwrap().receptors.is_empty());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ghost.xml");
    fs::write(&path, xml).unwrap();
    let error = grow_skin(&path, &GrowOptions::default()).unwrap_err().to_string();
    assert!(error.contains("ghost.xml") && error.contains("geom"), "{error}");
}
