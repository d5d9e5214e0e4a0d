//! `bodyschema render`: pictures and films, by MuJoCo's own renderer.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::learned::read_log;
use super::open::{ModelArguments, rehearse, session_body};
use super::progress::Bars;
use super::{Failure, Outcome, output, progress};
use crate::agent::Agent;
use crate::creature::{Body, Creature, JointSelection, Posture};
use crate::error::Error;
use crate::export::to_mjcf;
use crate::mujoco::{Camera, Image, Model, PICTURE_SIDES, Renderer};
use crate::schema::BodySchema;
use crate::senses::RecordedTouch;
use crate::session::{
    Checkpoint, LearningRecord, MadeFolders, ModelSource, ReadLock, SCHEMA_FILE, SESSION_FILE, Session,
    TOUCHES_FILE, folder_of, model_hash, read_schema, same_tree,
};
use crate::view::picture::{Direction, Drawing, Film, SessionDrawing, Shot, is_film, png};

/// Touches of a film that says nothing of them.
const TOUCHES: [usize; 2] = [1, 8];

/// Draw a model in a posture, or a session, as a picture or a film.
///
/// MuJoCo's renderer draws offscreen, with EGL. A picture shows a model or a session in the rest posture or
/// the one given by --posture; for a session, --touch shows a touch with its two receptors lit, and --schema the
/// learned body over a faint true one. A film moves from touch to touch or, with --learning, through the schema's
/// checkpoints from the initial guess on. Films need ffmpeg.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema render mjcf/max/max.xml --out max.png
  bodyschema render mjcf/max/table.xml --posture left_elbow_flexion=90 --camera 140,-20 --out table.png
  bodyschema render sessions/max-1 --touch 3 --schema --out touch.png
  bodyschema render sessions/max-1 --touches 1..2 --size 320x240 --out touches.mp4    # needs ffmpeg
  bodyschema render sessions/max-1 --learning --size 320x320 --out learning.mp4
  bodyschema render sessions/max-1 --touches 2..2 --frames-per-second 4 --size 320x320 --out frame-%03d.png

With BODYSCHEMA_GL=none in the environment no OpenGL is used.")]
pub struct RenderArguments {
    /// An MJCF file, or a session's folder
    #[arg(value_name = "MODEL|SESSION")]
    what: PathBuf,
    /// The file to write: a picture (.png), or a film (.mp4, .webm, .mkv, .mov, .gif, or one picture per frame, such as
    /// frame-%04d.png)
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    out: PathBuf,
    /// The posture: degrees of freedom in degrees or millimetres, balls as quaternions, such as
    /// left_elbow_flexion=90,neck=0.7:0.7:0:0; joints that are not named rest
    #[arg(long, value_name = "NAME=DEG,…", allow_hyphen_values = true, help_heading = "What is drawn")]
    posture: Option<String>,
    /// For a session: the touch to show, counted from 1, with its receptors lit
    #[arg(long, value_name = "N", conflicts_with = "posture", help_heading = "What is drawn")]
    touch: Option<usize>,
    /// For a session: show the learned body over the true one
    #[arg(long, help_heading = "What is drawn")]
    schema: bool,
    /// For a session: film these touches, counted from 1 [default: 1..8]
    #[arg(long, value_name = "N..M", value_parser = touch_range,
        conflicts_with_all = ["posture", "touch", "learning"], help_heading = "What is drawn")]
    touches: Option<[usize; 2]>,
    /// For a session: film the learned body from the initial guess on
    #[arg(long, conflicts_with_all = ["posture", "touch"], help_heading = "What is drawn")]
    learning: bool,
    /// For a session: the model, if it is not at the path recorded in the session
    #[arg(long)]
    model: Option<PathBuf>,
    /// Width and height, pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x960", help_heading = "Output")]
    size: [usize; 2],
    /// The point of view: azimuth and elevation in degrees, as in MuJoCo's viewer, and optionally a distance in metres
    /// (otherwise the body fills the picture); or the name of a camera in the model [default: 205,-12; 245,-20 for
    /// bodies that lie along x]
    #[arg(
        long,
        value_name = "AZIMUTH,ELEVATION[,METRES]|NAME",
        allow_hyphen_values = true,
        help_heading = "What is drawn"
    )]
    camera: Option<String>,
    /// Frames per second of a film
    #[arg(long, value_name = "N", value_parser = frames_per_second, default_value = "25", help_heading = "Output")]
    frames_per_second: f64,
    #[command(flatten)]
    options: ModelArguments,
}

/// Width and height from the command line.
fn size(text: &str) -> Result<[usize; 2], String> {
    let sides =
        text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sides.filter(|sides| sides.iter().all(|side| PICTURE_SIDES.contains(side))).ok_or_else(|| {
        let (least, most) = (PICTURE_SIDES.start(), PICTURE_SIDES.end());
        format!("give two numbers from {least} to {most}, as in 1280x960")
    })
}

/// A range of touches from the command line.
fn touch_range(text: &str) -> Result<[usize; 2], String> {
    let ends = text.split_once("..").and_then(|(from, to)| Some([from.parse().ok()?, to.parse().ok()?]));
    ends.filter(|[from, to]| 1 <= *from && from <= to).ok_or_else(|| "give two numbers, as in 1..8".into())
}

fn frames_per_second(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (1.0..=240.0).contains(number));
    number.ok_or_else(|| "give a number from 1 to 240".into())
}

pub fn run(args: &RenderArguments) -> Outcome {
    let film = is_film(&args.out);
    let out = args.out.display();
    if !film && !args.out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        return Err(Failure::at(
            &args.out,
            "unsupported format; use .png for a picture, .mp4, .webm, .mov, .mkv or .gif for a film",
        ));
    }
    let pictures = [("--touch", args.touch.is_some()), ("--posture", args.posture.is_some())];
    let films = [("--touches", args.touches.is_some()), ("--learning", args.learning)];
    let (others, what, fix) = if film {
        (pictures, "picture", "use a name that ends in .png")
    } else {
        (films, "film", "use a name that ends in .mp4, or one such as frame-%04d.png")
    };
    if let Some((option, _)) = others.iter().find(|(_, given)| *given) {
        return Err(Failure::at(&args.out, format_args!("{option} makes a {what}: {fix}")));
    }
    let spinner = progress::spinner("getting ready");
    let drawing =
        if args.what.join(SESSION_FILE).exists() { session(args, film)? } else { model(args, film)? };
    let [width, height] = args.size;
    let renderer = |smooth| {
        let made = Renderer::new(&drawing.model, width, height, smooth);
        made.map_err(|error| Failure::at(&args.out, error))
    };
    let mut sharp = renderer(true)?;
    let camera = camera(args, &drawing, &sharp)?;
    spinner.finish_and_clear();
    if !film {
        output::file(&args.out, png(&drawing.draw(&mut sharp, &drawing.shots[0], camera)?))?;
        say!("{out}");
        return Ok(());
    }
    let _made = MadeFolders::make(folder_of(&args.out)).map_err(Error::unwritable(&args.out))?;
    let mut film = Film::begin(&args.out, args.size, args.frames_per_second)?;
    let bar = progress::counted("drawing", drawing.shots.len() as u64, "frames");
    let mut quick = renderer(false)?;
    let mut drawn: Option<(&Shot, Image)> = None;
    for (k, shot) in drawing.shots.iter().enumerate() {
        // What stands still is drawn once, and sharp; nobody sees the edges of what moves.
        let image = match drawn.take().filter(|(before, _)| *before == shot) {
            Some((_, image)) => image,
            None if drawing.shots.get(k + 1) == Some(shot) => drawing.draw(&mut sharp, shot, camera)?,
            None => drawing.draw(&mut quick, shot, camera)?,
        };
        film.add(&image)?;
        drawn = Some((shot, image));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let frames = film.finish()?;
    say!("{out}: {frames} frames, {:.1} s", frames as f64 / args.frames_per_second);
    Ok(())
}

/// A model in a posture.
fn model(args: &RenderArguments, film: bool) -> Result<Drawing, Failure> {
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
        return Err(Failure(format!(
            "{place} is not a session, and {option} needs one: give a folder written by `bodyschema babble`"
        )));
    }
    if args.what.is_dir() {
        let what = format!("it contains no {SESSION_FILE}: give an MJCF file or a session folder");
        return Err(Failure::at(&args.what, what));
    }
    model_drawing(&args.options.source(&args.what, JointSelection::All), args.posture.as_deref())
}

/// A model in the posture that is named, else in the rest posture.
pub fn model_drawing(source: &ModelSource, words: Option<&str>) -> Result<Drawing, Failure> {
    // A missing file is reported as such, before anything else.
    model_hash(&source.model)?;
    rehearse(&source.model)?;
    let source = ModelSource { joints: JointSelection::All, textures: true, ..source.clone() };
    let model = Arc::new(source.read(&Bars::default())?);
    let body = match Body::rooted(model.clone(), &source.joints, source.root.as_deref()) {
        // What cannot move can be looked at.
        Err(error) if error.is_no_joints() && words.is_none() => None,
        _ => Some(source.body_in(model.clone())?),
    };
    let qpos = match &body {
        Some(body) => body.qpos(&posture(words, &body.creature)?),
        None => model.qpos0().to_vec(),
    };
    let shots = vec![Shot { qpos, ..Shot::default() }];
    Ok(Drawing { model, body, alone: false, shots, shaded: false })
}

/// What is drawn of a session.
fn session(args: &RenderArguments, film: bool) -> Result<Drawing, Failure> {
    let _reading = ReadLock::take(&args.what)?;
    let session = Session::read(&args.what)?;
    if args.options.root.is_some() {
        return Err(Failure::at(&args.what, "a session already determines the creature: leave out --root"));
    }
    let (agent, creature) = (&session.agent, session.agent.creature());
    let read_schema = || read_schema(&args.what.join(SCHEMA_FILE), creature);
    let body = if session.model.is_empty() && args.model.is_none() {
        // A recording has no true body: the learned one is all there is to see.
        if agent.skin().surfaces.is_empty() {
            return Err(Failure::at(
                &args.what,
                "the shapes of its limbs are unknown: give a model with --model, or surfaces in the creature's skin",
            ));
        }
        learned(&session, &read_schema()?, &args.what)?
    } else {
        session_body(&session, args.model.as_deref(), true)?
    };
    let schema = if args.schema { Some(read_schema()?) } else { None };
    let drawn = SessionDrawing::new(agent, &body, schema, args.frames_per_second)?;
    let shots = match (film, args.learning, args.touch) {
        (true, true, _) => drawn.learning(&checkpoints(args, creature)?),
        (true, false, _) => {
            let (first, touches) = touches(args, agent, args.touches)?;
            drawn.touches(first, &touches)?
        }
        (false, _, Some(number)) => {
            let (_, touches) = touches(args, agent, Some([number; 2]))?;
            vec![drawn.touch(number, &touches[0])?]
        }
        (false, _, None) => vec![drawn.posture(&posture(args.posture.as_deref(), creature)?)],
    };
    let shaded = args.schema || film && args.learning;
    Ok(Drawing { model: body.declared.clone(), body: Some(body), alone: true, shots, shaded })
}

/// The touches of a session from one number to another, counted from 1, or the first ones; and the number of the first.
fn touches(
    args: &RenderArguments,
    agent: &Agent,
    numbers: Option<[usize; 2]>,
) -> Result<(usize, Vec<RecordedTouch>), Failure> {
    let log = read_log(&args.what, agent)?;
    let [first, last] = numbers.unwrap_or([TOUCHES[0], TOUCHES[1].min(log.len().max(1))]);
    let chosen = first.checked_sub(1).and_then(|before| log.get(before..last));
    chosen.map(|touches| (first, touches.to_vec())).ok_or_else(|| {
        let fix = match log.len() {
            0 => "babble first".into(),
            count => format!("give one from 1 to {count}"),
        };
        Failure::at(&args.what.join(TOUCHES_FILE), format_args!("it has no touch {last}: {fix}"))
    })
}

/// What learning went through.
fn checkpoints(args: &RenderArguments, creature: &Creature) -> Result<Vec<Checkpoint>, Failure> {
    let record = LearningRecord::read(&args.what, creature)?;
    Some(record.checkpoints).filter(|all| all.len() > 1).ok_or_else(|| {
        let again = format!("learn again with `bodyschema learn {}`", args.what.display());
        Failure::at(&args.what, format_args!("it has no checkpoints of learning: {again}"))
    })
}

/// The body of a session without a model, as it was learned.
fn learned(session: &Session, schema: &BodySchema, folder: &Path) -> Result<Body, Failure> {
    let model = Arc::new(Model::from_xml(&to_mjcf(&session.agent, schema))?);
    let body = ModelSource::new(folder).with_joints(JointSelection::All).body_in(model)?;
    if same_tree(&body.creature, session.agent.creature()) {
        return Ok(body);
    }
    Err(Failure::at(
        folder,
        "its learned body cannot be drawn without a model: give the creature's with --model",
    ))
}

/// The camera of --camera, or one that holds all that is shown.
fn camera(args: &RenderArguments, drawing: &Drawing, renderer: &Renderer) -> Result<Camera, Failure> {
    let Some(text) = &args.camera else { return Ok(drawing.camera(renderer, None, None)?) };
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[azimuth, elevation, ref rest @ ..])
            if rest.len() <= 1
                && azimuth.is_finite()
                && (-90.0..=90.0).contains(&elevation)
                && rest.iter().all(|metres| *metres > 0.0 && metres.is_finite()) =>
        {
            let [azimuth, elevation] = [azimuth, elevation].map(f64::to_radians);
            Ok(drawing.camera(renderer, Some(Direction { azimuth, elevation }), rest.first().copied())?)
        }
        Some(_) => Err(Failure(format!(
            "--camera {text}: give azimuth, elevation from -90 to 90 and optionally a distance above 0, such as 205,-12,3"
        ))),
        None => {
            let cameras = drawing.model.cameras();
            let number = cameras.iter().position(|camera| camera == text);
            number.map(Camera::Fixed).ok_or_else(|| {
                let named: Vec<&str> = cameras.into_iter().filter(|camera| !camera.is_empty()).collect();
                let there = if named.is_empty() { "none with a name".into() } else { named.join(", ") };
                let fix = "give one of these, or azimuth and elevation, such as 205,-12";
                Failure::at(&args.what, format_args!("it has no camera named {text}; it has {there}: {fix}"))
            })
        }
    }
}

/// The posture of --posture, else the rest posture.
fn posture(words: Option<&str>, creature: &Creature) -> Result<Posture, Failure> {
    let posture = Posture::from_words(creature, words.unwrap_or_default());
    posture.map_err(|message| Failure(format!("--posture {message}")))
}
