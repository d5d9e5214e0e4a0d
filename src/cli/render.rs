//! `bodyschema render`: pictures and films, by MuJoCo's own renderer.

mod posture;
mod session;

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::Point3;

use super::open::{ModelArguments, open_to_draw};
use super::progress::Bars;
use super::{Failure, Outcome, output, progress};
use crate::creature::{Body, BodyError, JointSelection, Posture};
use crate::experiment::skin_for;
use crate::mujoco::{Camera, Data, Image, MOST_MARKS, Model, PICTURE_SIDES, Renderer};
use crate::record::{MadeFolders, SESSION_FILE, folder_of, model_hash};
use crate::skin::{Skin, SomatotopicMap, aura_of};
use crate::view::picture::{
    self, Direction, Film, Shot, Storyboard, corners_of, draw, extent, frame, is_film, outline, outline_of,
    png,
};

/// Draw a model in a posture, or what a session is about, as a picture or a film.
///
/// MuJoCo's renderer draws it, without a screen, by EGL or OSMesa. Of a model and of a session the posture at ease is
/// drawn, or the one that --posture gives; of a session with --touch that of a touch, its two places lit, and with
/// --schema the learned body over the true one, which becomes a shade. A film goes from touch to touch, or with
/// --learning through the schema's checkpoints, from the initial guess on. Films need ffmpeg.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema render mjcf/max/max.xml --out max.png
  bodyschema render mjcf/max/table.xml --posture left_elbow_flexion=90 --camera 140,-20 --out table.png
  bodyschema render mjcf/max/max.xml --camera front --look-at head --out face.png
  bodyschema render mjcf/hexapod/hexapod.xml --skin --out skin.png
  bodyschema render mjcf/max/max.xml --auras --out auras.png
  bodyschema render mjcf/max/max.xml --map --camera 180,0 --out map.png
  bodyschema render sessions/max-1 --touch 3 --schema --out touch.png
  bodyschema render sessions/max-1 --touches 1..2 --size 320x240 --out touches.mp4    # needs ffmpeg
  bodyschema render sessions/max-1 --learning --size 320x320 --out learning.mp4
  bodyschema render sessions/max-1 --touches 2..2 --frames-per-second 4 --size 320x320 --out frame-%03d.png

Without OpenGL it says so. The environment variable BODYSCHEMA_GL says which library draws: egl, osmesa, or none;
without it EGL is tried, then OSMesa.")]
pub struct RenderArguments {
    /// An MJCF file, or a session's folder
    #[arg(value_name = "MODEL|SESSION")]
    what: PathBuf,
    /// The file to write: a picture (.png), or a film (.mp4, .webm, .mkv, .mov, .gif, or a picture a frame, as in
    /// frame-%04d.png)
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    out: PathBuf,
    /// The posture: names of degrees of freedom with degrees or millimetres, as in
    /// left_elbow_flexion=90,right_elbow_flexion=20, or a JSON file of names with radians, metres or w x y z; what is not named is at ease
    #[arg(long, value_name = "NAME=DEG,…|FILE", allow_hyphen_values = true, help_heading = "What is drawn")]
    posture: Option<String>,
    /// Of a model, its skin: receptors of its own in blue, those that are grown on it in orange
    #[arg(long, help_heading = "What is drawn")]
    skin: bool,
    /// The auras about its limbs: what is inside one is near that limb
    #[arg(long, help_heading = "What is drawn")]
    auras: bool,
    /// The somatotopic map: which receptors are neighbours, red across limbs
    #[arg(long, help_heading = "What is drawn")]
    map: bool,
    /// Of a session, the posture of a touch, counted from 1, its places lit
    #[arg(long, value_name = "N", conflicts_with = "posture", help_heading = "What is drawn")]
    touch: Option<usize>,
    /// Of a session, the learned body over the true one
    #[arg(long, help_heading = "What is drawn")]
    schema: bool,
    /// Of a session, a film of the touches from one to another, counted from 1 [default: 1..8]
    #[arg(long, value_name = "N..M", value_parser = session::touch_range,
        conflicts_with_all = ["posture", "touch", "learning"], help_heading = "What is drawn")]
    touches: Option<[usize; 2]>,
    /// Of a session, a film of the learned body from the initial guess on
    #[arg(long, conflicts_with_all = ["posture", "touch"], help_heading = "What is drawn")]
    learning: bool,
    /// Of a session, the model, where it is not at the path in the session
    #[arg(long)]
    model: Option<PathBuf>,
    /// Width and height, pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x960", help_heading = "Output")]
    size: [usize; 2],
    /// Where it is looked at from: front, back, left, right or above, for creatures that face along x; azimuth and elevation
    /// in degrees, as MuJoCo's viewer has them, with a distance in metres if it is not to fill the picture; or the name of a
    /// camera in the model [default: 205,-12; 245,-20 for what lies along x]
    #[arg(
        long,
        value_name = "SIDE|AZIMUTH,ELEVATION[,METRES]|NAME",
        allow_hyphen_values = true,
        help_heading = "What is drawn"
    )]
    camera: Option<String>,
    /// What the picture is filled with: a body of the model with all that it carries, as in --look-at head
    #[arg(long, value_name = "BODY", help_heading = "What is drawn")]
    look_at: Option<String>,
    /// Nothing is written into the picture, and no scale is drawn
    #[arg(long, help_heading = "What is drawn")]
    no_caption: bool,
    /// Pictures a second of a film
    #[arg(long, value_name = "N", value_parser = frames_per_second, default_value = "25", help_heading = "Output")]
    frames_per_second: f64,
    #[command(flatten)]
    options: ModelArguments,
}

/// Sides of what faces along x: azimuth and elevation of the eye that looks at it, degrees.
const SIDES: [(&str, [f64; 2]); 5] = [
    ("front", [180.0, -5.0]),
    ("back", [0.0, -5.0]),
    ("left", [270.0, -5.0]),
    ("right", [90.0, -5.0]),
    ("above", [180.0, -89.0]),
];

/// Width and height from the command line.
fn size(text: &str) -> Result<[usize; 2], String> {
    let sides =
        text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sides.filter(|sides| sides.iter().all(|side| PICTURE_SIDES.contains(side))).ok_or_else(|| {
        let (least, most) = (PICTURE_SIDES.start(), PICTURE_SIDES.end());
        format!("give two numbers from {least} to {most}, as in 1280x960")
    })
}

fn frames_per_second(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (1.0..=240.0).contains(number));
    number.ok_or_else(|| "give a number from 1 to 240".into())
}

/// What is drawn: a model, and what moves in it.
struct RenderSubject {
    /// The file, for what is said of it.
    place: String,
    model: Arc<Model>,
    body: Option<Body>,
    /// The skin that it is drawn with.
    skin: Option<Skin>,
    /// Whether only the creature is to fill the picture, and not all that is about it.
    alone: bool,
}

impl RenderSubject {
    /// Data in a posture, poses computed.
    fn data(&self, qpos: &[f64]) -> Result<Data, Failure> {
        let mut data = Data::new(self.model.clone())?;
        data.set_qpos(qpos)?;
        data.kinematics()?;
        Ok(data)
    }

    /// Whether a geom is the creature's.
    fn is_own(&self, geom: usize) -> bool {
        self.body.as_ref().is_some_and(|body| body.limb_of_geom(geom).is_some())
    }
}

pub fn run(args: &RenderArguments) -> Outcome {
    let film = is_film(&args.out);
    if !film && !args.out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        return Err(Failure(format!(
            "{}: unsupported format: end it in .png for a picture, in .mp4, .webm, .mov, .mkv or .gif for a film",
            args.out.display()
        )));
    }
    let makes = |what: &str, given: bool, option: &str, mend: &str| match given {
        true => Err(Failure(format!("{}: {option} makes a {what}: {mend}", args.out.display()))),
        false => Ok(()),
    };
    if film {
        let mend = "end the file's name in .png";
        makes("picture", args.touch.is_some(), "--touch", mend)?;
        makes("picture", args.posture.is_some(), "--posture", mend)?;
    } else {
        let mend = "end the file's name in .mp4, or give one such as frame-%04d.png";
        makes("film", args.touches.is_some(), "--touches", mend)?;
        makes("film", args.learning, "--learning", mend)?;
    }
    let spinner = progress::spinner("getting ready");
    let (subject, mut plan) =
        if args.what.join(SESSION_FILE).exists() { session::plan(args, film)? } else { model(args, film)? };
    add_layers(args, &subject, &mut plan)?;
    if args.no_caption {
        plan.shots.iter_mut().for_each(|shot| shot.caption.clear());
    }
    plan.shots.iter_mut().for_each(|shot| shot.scaled = !args.no_caption);
    let [width, height] = args.size;
    let mut renderer = Renderer::new(&subject.model, width, height)
        .map_err(|error| Failure(format!("{}: {error}", args.out.display())))?;
    let camera = camera(args, &subject, &plan, &renderer)?;
    spinner.finish_and_clear();
    let shaded = |geom: usize| plan.shaded && subject.is_own(geom);
    let mut picture = |shot: &Shot| draw(&mut renderer, shot, camera, &shaded);
    if !film {
        output::file(&args.out, png(&picture(&plan.shots[0])?))?;
        say!("{}", args.out.display());
        return Ok(());
    }
    let _made = MadeFolders::make(folder_of(&args.out)).map_err(output::not_written(&args.out))?;
    let mut film = Film::begin(&args.out, args.size, args.frames_per_second)?;
    let bar = progress::counted("drawing", plan.shots.len() as u64, "frames");
    let mut drawn: Option<(&Shot, Image)> = None;
    for shot in &plan.shots {
        // What stands still is drawn once.
        let image = match drawn.take().filter(|(before, _)| *before == shot) {
            Some((_, image)) => image,
            None => picture(shot)?,
        };
        film.add(&image)?;
        drawn = Some((shot, image));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let frames = film.finish()?;
    say!("{}: {frames} frames, {:.1} s", args.out.display(), frames as f64 / args.frames_per_second);
    Ok(())
}

/// A model in a posture.
fn model(args: &RenderArguments, film: bool) -> Result<(RenderSubject, Storyboard), Failure> {
    let place = args.what.display().to_string();
    let of_session = [
        (args.touch.is_some(), "--touch"),
        (args.touches.is_some(), "--touches"),
        (args.schema, "--schema"),
        (args.learning, "--learning"),
        (args.model.is_some(), "--model"),
        (film, "a film"),
    ];
    if let Some((_, option)) = of_session.iter().find(|(given, _)| *given) {
        let mend = "give the folder of one, as `bodyschema babble` writes it";
        return Err(Failure(format!("{place} is no session, and {option} is of a session: {mend}")));
    }
    if args.what.is_dir() {
        return Err(Failure(format!(
            "{place}: there is no {SESSION_FILE} in it: give an MJCF file or a session's folder"
        )));
    }
    // A file that is not there is told of as such, before anything else.
    model_hash(&args.what)?;
    let source = args.options.source(&args.what, JointSelection::All);
    let model = Arc::new(open_to_draw(source.clone())?);
    let body = match Body::rooted(model.clone(), &JointSelection::All, args.options.root.as_deref()) {
        // What cannot move can be looked at.
        Err(BodyError::NoJoints) if args.posture.is_none() => None,
        _ => Some(source.body_in(model.clone())?),
    };
    let mut qpos = model.qpos0().to_vec();
    if let Some(body) = &body {
        let posture = match &args.posture {
            Some(text) => posture::read(text, &body.creature)?,
            None => Posture::start(&body.creature),
        };
        body.write_qpos(&posture, &mut qpos);
    }
    let mut marks = Vec::new();
    let mut subject =
        RenderSubject { place, model, body, skin: None, alone: args.skin || args.auras || args.map };
    if let Some(body) = subject.body.as_ref().filter(|_| subject.alone) {
        // The skin that a body babbles with.
        let (skin, own) = skin_for(&args.what, body, &Bars::default())?;
        if args.skin {
            let data = subject.data(&qpos)?;
            let on_limbs = skin.receptors.iter().filter_map(|r| Some((r, body.limb_pose(&data, r.limb)?)));
            marks = picture::skin(on_limbs, own, size_of(body, &data));
        }
        subject.skin = Some(skin);
    }
    Ok((subject, Storyboard::still(Shot { qpos, marks, ..Shot::default() }, false)))
}

/// How large a body is, metres, given data with poses computed.
fn size_of(body: &Body, data: &Data) -> f64 {
    extent(&outline(data, &|geom| body.limb_of_geom(geom).is_some()))
}

/// Draws the aura and the somatotopic map into every picture where they are asked for.
fn add_layers(args: &RenderArguments, subject: &RenderSubject, plan: &mut Storyboard) -> Outcome {
    let (Some(body), Some(skin)) = (&subject.body, &subject.skin) else { return Ok(()) };
    let at_rest = body.reference_data()?;
    let size = size_of(body, &at_rest);
    let geometries = match args.auras {
        true => aura_of(body, skin, &body.limb_frames(&at_rest)),
        false => Vec::new(),
    };
    let map = args.map.then(|| SomatotopicMap::at_ease(body, skin)).transpose()?;
    for shot in &mut plan.shots {
        if args.auras || args.map {
            let frames = body.limb_frames(&subject.data(&shot.qpos)?);
            shot.marks.extend(picture::auras(&geometries, &frames));
            shot.marks.extend(map.iter().flat_map(|map| picture::map(skin, map, &frames, size)));
        }
        let count = shot.marks.len() + shot.lit.len();
        if count > MOST_MARKS {
            return Err(Failure(format!(
                "{}: {count} marks are more than the {MOST_MARKS} of a picture: leave out --map or --skin",
                subject.place
            )));
        }
    }
    Ok(())
}

/// The camera that is asked for, or one that holds all that is shown.
fn camera(
    args: &RenderArguments,
    subject: &RenderSubject,
    plan: &Storyboard,
    renderer: &Renderer,
) -> Result<Camera, Failure> {
    let mut direction = None;
    let mut distance = None;
    if let Some((_, side)) =
        args.camera.as_deref().and_then(|name| SIDES.iter().find(|(side, _)| *side == name))
    {
        let [azimuth, elevation] = side.map(f64::to_radians);
        direction = Some(Direction { azimuth, elevation });
    } else if let Some(text) = &args.camera {
        let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[azimuth, elevation, ref rest @ ..])
                if rest.len() <= 1
                    && azimuth.is_finite()
                    && (-90.0..=90.0).contains(&elevation)
                    && rest.iter().all(|metres| *metres > 0.0 && metres.is_finite()) =>
            {
                let [azimuth, elevation] = [azimuth, elevation].map(f64::to_radians);
                direction = Some(Direction { azimuth, elevation });
                distance = rest.first().copied();
            }
            Some(_) => {
                return Err(Failure(format!(
                    "--camera {text}: give azimuth, elevation from -90 to 90 and, if wanted, a distance above 0, as in \
                     205,-12,3"
                )));
            }
            None => return named_camera(text, subject),
        }
    }
    let looked_at = args.look_at.as_deref().map(|name| carried_by(name, subject)).transpose()?;
    let shown = |geom: usize| {
        renderer.shows(geom)
            && looked_at
                .as_ref()
                .map_or(!subject.alone || subject.is_own(geom), |geoms| geoms.contains(&geom))
    };
    let mut points: Vec<Point3<f64>> = Vec::new();
    for &held in &plan.held {
        let shot = &plan.shots[held];
        points.extend(outline(&subject.data(&shot.qpos)?, &shown));
        points.extend(shot.marks.iter().flat_map(corners_of));
        let copies = shot.copies.iter().filter(|copy| shown(copy.geom));
        points.extend(copies.flat_map(|copy| outline_of(&subject.model, copy.geom, &copy.pose)));
    }
    let direction = direction.unwrap_or_else(|| Direction::suiting(&points));
    Ok(frame(points, direction, renderer.lens(), distance))
}

/// The geoms of a body of a name and of all bodies that it carries.
fn carried_by(name: &str, subject: &RenderSubject) -> Result<HashSet<usize>, Failure> {
    let model = &subject.model;
    let body = (0..model.nbody()).find(|&body| model.body(body).name == Some(name)).ok_or_else(|| {
        let named = (1..model.nbody()).filter_map(|body| model.body(body).name);
        let place = &subject.place;
        Failure(format!(
            "{place}: it has no body named {name}, to look at: give one of {}",
            named.collect::<Vec<_>>().join(", ")
        ))
    })?;
    let mut carried = vec![false; model.nbody()];
    // Bodies come after those that carry them.
    for at in body..model.nbody() {
        carried[at] = at == body || (at > body && carried[model.body(at).parent]);
    }
    Ok((0..model.ngeom()).filter(|&geom| carried[model.geom_body(geom)]).collect())
}

fn named_camera(name: &str, subject: &RenderSubject) -> Result<Camera, Failure> {
    let cameras = subject.model.cameras();
    if let Some(number) = cameras.iter().position(|camera| *camera == name) {
        return Ok(Camera::Fixed(number));
    }
    let named: Vec<&str> = cameras.into_iter().filter(|camera| !camera.is_empty()).collect();
    let there = if named.is_empty() { "none with a name".into() } else { named.join(", ") };
    Err(Failure(format!(
        "{}: it has no camera named {name}, it has {there}: give one of these, or azimuth and elevation as in 205,-12",
        subject.place
    )))
}
