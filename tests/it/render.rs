//! Pictures and films: they show what they are to show, and where they cannot be made a sentence says why.
//!
//! Those that draw need OpenGL, and are ignored unless they are asked for.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

use crate::common::drawing::Picture;
use crate::common::program::{refused, run, succeeds};
use crate::common::shell::copy;
use crate::common::{repository, sessions};
use bodyschema::mujoco::{Camera, Error, Mark, Model, Renderer, View};
use nalgebra::Point3;
use tempfile::TempDir;

/// A folder with a session of Max in `session`, for what these tests draw.
fn session() -> &'static Path {
    static MADE: LazyLock<PathBuf> = LazyLock::new(|| {
        let folder = sessions::kept("render");
        copy(&sessions::max().join("max"), &folder.join("session"));
        folder
    });
    &MADE
}

fn max() -> String {
    repository("mjcf/max/max.xml").display().to_string()
}

/// Draws a picture with these arguments.
fn picture(place: &Path, arguments: &[&str]) -> Picture {
    let out = place.join(format!(
        "{:x}.png",
        arguments.join(" ").bytes().fold(7u64, |h, b| h.wrapping_mul(31) + u64::from(b))
    ));
    let line = [&["render"], arguments, &["--out", out.to_str().unwrap()]].concat();
    assert_eq!(succeeds(place, &line).trim(), out.to_str().unwrap());
    Picture::read(&out)
}

fn is_white(pixel: &[u8; 3]) -> bool {
    *pixel == [255; 3]
}

/// Whether a pixel is of a place that is lit.
fn is_lit(pixel: &[u8; 3]) -> bool {
    pixel[0] > 220 && pixel[2] < 60
}

/// Whether a pixel is of Max's shirt.
fn is_shirt(pixel: &[u8; 3]) -> bool {
    let [red, green, blue] = pixel.map(i32::from);
    green > red + 40 && blue > red + 40
}

#[test]
#[ignore = "needs OpenGL"]
fn a_model_at_ease_fills_its_picture() {
    let place = tempfile::tempdir().unwrap();
    let drawn = picture(place.path(), &[&max(), "--size", "300x400"]);
    assert_eq!((drawn.width, drawn.height), (300, 400));
    let empty = drawn.share(is_white);
    assert!((0.6..0.95).contains(&empty), "{empty} of it is white");
    // Max stands: he is as high as the picture, but for its margins, and not as wide.
    let [top, bottom, left, right] = drawn.bounds();
    assert!((16..=32).contains(&top) && (368..=384).contains(&bottom), "{top} to {bottom}");
    assert!(left > 40 && right < 260 && right - left > 80, "{left} to {right}");
    let mut colours = drawn.pixels.clone();
    colours.sort_unstable();
    colours.dedup();
    assert!(colours.len() > 500, "{} colours", colours.len());
}

#[test]
#[ignore = "needs OpenGL"]
fn a_posture_is_drawn_as_words_give_it() {
    let place = tempfile::tempdir().unwrap();
    let (model, size) = (max(), ["--size", "160x200", "--camera", "205,-12,3.5"]);
    let posed = |posture: &[&str]| picture(place.path(), &[&[model.as_str()], &size[..], posture].concat());
    let at_ease = posed(&[]);
    let words = posed(&["--posture", "left_shoulder_flexion=60"]);
    let differs = at_ease.pixels.iter().zip(&words.pixels).filter(|(a, b)| a != b).count();
    assert!((200..8000).contains(&differs), "{differs} pixels differ");
    assert!(at_ease.pixels == posed(&[]).pixels, "the same is drawn differently");
}

#[test]
#[ignore = "needs OpenGL"]
fn a_scene_has_its_sky_its_floor_and_its_cameras() {
    let place = tempfile::tempdir().unwrap();
    let table = repository("mjcf/max/table.xml").display().to_string();
    let free = picture(place.path(), &[&table, "--size", "320x240"]);
    let front = picture(place.path(), &[&table, "--size", "320x240", "--camera", "front"]);
    for drawn in [&free, &front] {
        assert!(drawn.share(is_white) < 0.01);
        let wood = |p: &[u8; 3]| {
            let [red, green, blue] = p.map(i32::from);
            red > 120 && red > green + 20 && green > blue + 20
        };
        assert!(drawn.share(wood) > 0.05, "there is no table");
    }
    assert!(free.pixels != front.pixels);
    let nearer = picture(place.path(), &[&table, "--size", "320x240", "--camera", "205,-12,1.5"]);
    assert!(nearer.pixels != free.pixels);
}

#[test]
#[ignore = "needs OpenGL"]
fn a_touch_is_lit_and_the_learned_body_is_over_the_true_one() {
    let place = session();
    let draw = |arguments: &[&str]| picture(place, &[&["session", "--size", "480x480"], arguments].concat());
    let at_ease = draw(&[]);
    assert!(at_ease.share(is_lit) == 0.0 && at_ease.share(is_shirt) > 0.03);
    // Wherever the touch is, also behind the body.
    for touch in ["1", "2", "3", "4", "5", "6"] {
        let touched = draw(&["--touch", touch]);
        let warm = touched.share(|p| p[0] > 140 && p[2] < 90 && p[0] > p[1]);
        assert!(
            warm > at_ease.share(|p| p[0] > 140 && p[2] < 90 && p[0] > p[1]) + 2e-4,
            "touch {touch}: {warm}"
        );
    }
    assert!((1..=6).any(|touch| draw(&["--touch", &touch.to_string()]).share(is_lit) > 3e-4));
    let learned = draw(&["--schema"]);
    // What was learned to a thousandth of a millimetre looks as what is true, and is not drawn over it as a veil.
    let same = |(a, b): (&[u8; 3], &[u8; 3])| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) < 8);
    let alike = at_ease.pixels.iter().zip(&learned.pixels).filter(|pixels| same(*pixels)).count();
    assert!(alike as f64 > 0.99 * at_ease.pixels.len() as f64, "{alike} of {}", at_ease.pixels.len());
    let posed = draw(&["--schema", "--posture", "left_elbow_flexion=90"]);
    assert!(posed.pixels != learned.pixels);
}

#[test]
#[ignore = "needs OpenGL"]
fn a_film_has_a_frame_for_every_moment() {
    let place = session();
    let film = |arguments: &[&str], out: &str| {
        let line = [
            &["render", "session", "--size", "96x128", "--frames-per-second", "5"],
            arguments,
            &["--out", out],
        ];
        let said = succeeds(place, &line.concat());
        let count = said.rsplit(": ").next().unwrap().split(' ').next().unwrap().parse::<usize>().unwrap();
        let files: Vec<PathBuf> =
            (1..=count).map(|k| place.join(out.replace("%03d", &format!("{k:03}")))).collect();
        assert!(!place.join(out.replace("%03d", &format!("{:03}", count + 1))).exists());
        files.iter().map(|file| Picture::read(file)).collect::<Vec<_>>()
    };
    let touches = film(&["--touches", "2..4"], "touches/f-%03d.png");
    assert_eq!(touches.len(), 3 * (5 + 3), "five frames of motion and three of rest for each touch");
    assert!(touches[0].pixels != touches[4].pixels && touches[5].pixels == touches[7].pixels);
    let learning = film(&["--learning"], "learning/f-%03d.png");
    let (first, last) = (&learning[0], &learning[learning.len() - 1]);
    // At the initial guess the true body is nothing but a shade; in the end the learned one is there.
    let upper = |picture: &Picture| {
        let half = &picture.pixels[..picture.pixels.len() / 2];
        half.iter().filter(|pixel| is_shirt(pixel)).count()
    };
    assert!(upper(last) > 2 * upper(first) + 100, "{} and {}", upper(first), upper(last));
}

/// A program that is called ffmpeg.
fn fake_ffmpeg(script: &str) -> TempDir {
    let place = tempfile::tempdir().unwrap();
    let program = place.path().join("ffmpeg");
    fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    place
}

/// Runs the program with other folders to seek programs in.
fn run_with_path(place: &Path, path: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
    command.args(arguments).current_dir(place).env("PATH", path).output().unwrap()
}

#[test]
#[ignore = "needs OpenGL"]
fn ffmpeg_gets_every_frame_and_what_it_says_is_told() {
    let place = session();
    let line = [
        "render",
        "session",
        "--touches",
        "1..1",
        "--size",
        "64x48",
        "--frames-per-second",
        "5",
        "--out",
        "film.mp4",
    ];
    let told = |path: &str| {
        let output = run_with_path(place, path, &line);
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let counts = fake_ffmpeg(r#"for out in "$@"; do :; done; /usr/bin/wc -c > "$out""#);
    let (code, said) = told(counts.path().to_str().unwrap());
    assert_eq!(code, Some(0), "{said}");
    let bytes: usize = fs::read_to_string(place.join("film.mp4")).unwrap().trim().parse().unwrap();
    assert_eq!(bytes, (5 + 3) * 64 * 48 * 3);

    fs::remove_file(place.join("film.mp4")).unwrap();
    let fails = fake_ffmpeg("echo 'no such codec' >&2; exit 1");
    let (code, said) = told(fails.path().to_str().unwrap());
    assert!(code == Some(1) && said.contains("no such codec") && said.contains("film-%04d.png"), "{said}");
    let (code, said) = told("/nowhere");
    assert!(code == Some(1) && said.contains("install Debian's package ffmpeg"), "{said}");
    assert!(said.contains("film-%04d.png"), "{said}");
    // What did not become a film leaves nothing behind.
    let left = fs::read_dir(place).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let left: Vec<String> = left.filter(|name| name.contains("film")).collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn without_opengl_a_sentence_says_so_and_all_else_works() {
    let place = tempfile::tempdir().unwrap();
    let with = |library: &str, arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
        command.args(arguments).current_dir(place.path()).env("BODYSCHEMA_GL", library).output().unwrap()
    };
    let model = max();
    for (library, words) in [("none", "BODYSCHEMA_GL=none"), ("osmesa", "set it to egl or none")] {
        let output = with(library, &["render", &model, "--out", "max.png"]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(words) && said.contains("libegl1"), "{said}");
        assert_eq!(said.trim().lines().count(), 1, "{said}");
        assert!(!place.path().join("max.png").exists());
    }
    assert_eq!(with("none", &["inspect", &model]).status.code(), Some(0));
}

#[test]
fn what_cannot_be_drawn_is_refused_in_a_sentence() {
    let place = session();
    let model = max();
    let cases: [(&[&str], &str); 12] = [
        (&["session", "--root", "other"], "leave out --root"),
        (&[&model, "--posture", "left_elbow=90"], "it has left_elbow_flexion, left_elbow_pronation"),
        (&[&model, "--posture", "left_elbow_flexion=390"], "390° is outside its range of -6° to 140°"),
        (&[&model, "--posture", "left_elbow_flexion=bent"], "give a name, = and a number"),
        (&[&model, "--touch", "1"], "--touch needs one"),
        (&["nowhere.xml"], "nowhere.xml: no such file"),
        (&["."], "it contains no session.json"),
        (&["session", "--touch", "1001"], "it has no touch 1001: give one from 1 to 1000"),
        (&["session", "--touch", "0"], "it has no touch 0"),
        (&["session", "--touches", "1..2"], "--touches makes a film"),
        (&["session", "--learning"], "--learning makes a film"),
        (&["session", "--posture", "left_elbow_flexion=-90"], "-90° is outside its range"),
    ];
    for (arguments, words) in cases {
        let said = refused(place, 1, &[&["render"], arguments, &["--out", "refused.png"]].concat());
        assert!(said.to_lowercase().contains(&words.to_lowercase()), "{arguments:?}: {said}");
    }
    let said = refused(place, 1, &["render", &model, "--out", "refused.jpg"]);
    assert!(said.contains("use .png"), "{said}");
    let said = refused(place, 1, &["render", "session", "--touch", "1", "--out", "refused.mp4"]);
    assert!(said.contains("--touch makes a picture"), "{said}");
    let said = refused(place, 1, &["render", "session", "--touches", "999..1001", "--out", "refused-%d.png"]);
    assert!(said.contains("it has no touch 1001"), "{said}");
    for (option, value) in
        [("--size", "0x10"), ("--size", "big"), ("--frames-per-second", "0"), ("--touches", "3..1")]
    {
        refused(place, 2, &["render", "session", option, value, "--out", "refused.mp4"]);
    }
    assert!(!place.join("refused.png").exists());
}

#[test]
#[ignore = "needs OpenGL"]
fn cameras_that_are_not_there_and_files_that_cannot_be_written_are_refused() {
    let place = session();
    let table = repository("mjcf/max/table.xml").display().to_string();
    let said = refused(place, 1, &["render", &table, "--camera", "top", "--out", "no-camera.png"]);
    assert!(said.contains("it has front, side"), "{said}");
    let said = refused(place, 1, &["render", &table, "--camera", "10,100", "--out", "no-camera.png"]);
    assert!(said.contains("elevation from -90 to 90"), "{said}");
    assert!(!place.join("no-camera.png").exists());
    let output = run(place, &["render", &max(), "--out", "session"]);
    assert_eq!(output.status.code(), Some(1));
}

#[test]
#[ignore = "needs OpenGL"]
fn a_recording_without_a_model_shows_the_learned_body() {
    // What a session of a recording is, as far as drawing goes: one that names no model.
    let place = tempfile::tempdir().unwrap();
    copy(&sessions::max().join("max"), &place.path().join("session"));
    let file = place.path().join("session/session.json");
    let mut said: serde_json::Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    for key in ["model", "model_hash"] {
        said[key] = "".into();
    }
    fs::write(&file, said.to_string()).unwrap();
    let drawn = picture(place.path(), &["session", "--touch", "1", "--size", "200x200"]);
    assert!((0.5..0.97).contains(&drawn.share(is_white)), "{}", drawn.share(is_white));
}

#[test]
#[ignore = "needs OpenGL"]
fn rows_go_from_the_top_and_marks_are_where_they_are_put() {
    let model = Model::from_xml("<mujoco/>").unwrap();
    let mut renderer = Renderer::new(&model, 90, 60, true).unwrap();
    let camera = Camera::Free { lookat: Point3::origin(), distance: 2.0, azimuth: 0.0, elevation: 0.0 };
    let green = [0.0, 1.0, 0.0, 1.0];
    // An eye that looks along x has y to the left.
    let marks = [
        Mark::sphere(&Point3::new(0.0, 0.5, 0.4), 0.1, [1.0, 0.0, 0.0, 1.0]),
        Mark::capsule([Point3::new(0.0, -0.3, -0.5), Point3::new(0.0, -0.8, -0.5)], 0.05, green),
    ];
    let mut render = |camera| {
        let view =
            View { camera, marks: &marks, marks_alone: false, repaint: &|_| None, copies: &[], caption: "" };
        renderer.render(&[], &view)
    };
    let image = render(camera).unwrap();
    assert_eq!((image.width, image.height, image.rgb.len()), (90, 60, 90 * 60 * 3));
    let of = |colour: usize| {
        let others = [0, 1, 2].into_iter().filter(move |k| *k != colour);
        let is = move |p: &[u8]| {
            others.clone().all(|k| p[colour] > 60 && u32::from(p[colour]) > 2 * u32::from(p[k]))
        };
        let places = image.rgb.chunks_exact(3).enumerate().filter(move |(_, p)| is(p));
        places.map(|(i, _)| [i / 90, i % 90]).collect::<Vec<_>>()
    };
    let (red, green) = (of(0), of(1));
    assert!(red.len() > 10 && red.iter().all(|[row, column]| *row < 25 && *column < 40), "{red:?}");
    assert!(green.len() > 10 && green.iter().all(|[row, column]| *row > 35 && *column > 50), "{green:?}");
    assert!(matches!(render(Camera::Fixed(0)), Err(Error::Engine { .. })));
    assert!(matches!(Renderer::new(&model, 10, 60, true), Err(Error::Size { .. })));
    // Two in one thread do not disturb each other.
    let again = |renderer: &mut Renderer| {
        let view =
            View { camera, marks: &marks, marks_alone: false, repaint: &|_| None, copies: &[], caption: "" };
        renderer.render(&[], &view).unwrap()
    };
    drop(Renderer::new(&model, 50, 50, true).unwrap());
    assert_eq!(again(&mut renderer), image);
}
