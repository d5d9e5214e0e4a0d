//! Bodies of meshes, made rather than kept: files of thousands of vertices say nothing that a formula does not.

use std::f64::consts::{PI, TAU};

/// A mesh's rings about its x axis: how many corners each has, and per ring how far along and how wide it is, by the half
/// sizes of the limb.
type Rings = (usize, Vec<[f64; 2]>);

/// MJCF of ten bodies, each with its name: two arms on a trunk, of five kinds of meshes, that collide by their file or are
/// for show alone.
pub fn bodies() -> Vec<(String, String)> {
    // A square of this width has sides of 2.
    let square = std::f64::consts::SQRT_2;
    let limbs: [(&str, Rings, f64); 5] = [
        ("brick", (4, vec![[-1.0, square], [1.0, square]]), 1.0),
        ("plate", (4, vec![[-1.0, square], [1.0, square]]), 0.02),
        ("prism", (24, vec![[-1.0, 1.0], [1.0, 0.7]]), 1.0),
        ("pebble", (10, egg(6)), 1.0),
        ("boulder", (60, egg(40)), 1.0),
    ];
    let filters = [("", ""), ("shown ", r#"contype="0" conaffinity="0""#)];
    let made = filters.iter().flat_map(|(shown, filter)| {
        limbs.iter().map(move |(name, rings, flat)| (format!("{shown}{name}"), body(rings, *flat, filter)))
    });
    made.collect()
}

/// Rings of an ellipsoid.
fn egg(rings: usize) -> Vec<[f64; 2]> {
    let turn = |ring: usize| PI * (ring as f64 + 0.5) / rings as f64;
    (0..rings).map(|ring| [-turn(ring).cos(), turn(ring).sin()]).collect()
}

/// A trunk held in the world with two arms of two hinges at the shoulder and two at the elbow; limbs are `flat` times as
/// thick as wide.
fn body(rings: &Rings, flat: f64, filter: &str) -> String {
    let mesh = |name: &str, [x, y, z]: [f64; 3]| mesh(name, rings, [x, y, z * flat]);
    let arm = |side: &str, y: f64| {
        format!(
            r#"<body name="{side}_upper" pos="0 {y} 0.4">
      <joint name="{side}_shoulder_a" axis="1 0.2 0" range="-2.4 2.4"/>
      <joint name="{side}_shoulder_b" axis="0 1 0.3" range="-2.4 2.4"/>
      <geom type="mesh" mesh="upper" pos="0.17 0 0"/>
      <body name="{side}_fore" pos="0.34 0 0">
        <joint name="{side}_elbow_a" axis="0 0 1" range="-2.6 2.6"/>
        <joint name="{side}_elbow_b" axis="0.3 1 0" range="-2.6 2.6"/>
        <geom type="mesh" mesh="fore" pos="0.2 0 0" euler="0.3 0.2 0.1"/>
      </body>
    </body>"#
        )
    };
    format!(
        r#"<mujoco model="two arms of meshes">
  <compiler angle="radian" autolimits="true"/>
  <asset>{}{}{}</asset>
  <default><geom {filter}/></default>
  <worldbody>
    <body name="trunk" pos="0 0 1">
      <geom type="mesh" mesh="trunk" pos="0 0 0.1"/>
      {}
      {}
    </body>
  </worldbody>
</mujoco>"#,
        mesh("trunk", [0.3, 0.1, 0.12]),
        mesh("upper", [0.15, 0.03, 0.035]),
        mesh("fore", [0.18, 0.03, 0.04]),
        arm("left", 0.25),
        arm("right", -0.25)
    )
}

/// A mesh of rings, its faces written out: of a mesh without faces the engine makes the hull in any case.
fn mesh(name: &str, (corners, rings): &Rings, [x, y, z]: [f64; 3]) -> String {
    let turn = |corner: usize| TAU * (corner as f64 + 0.5) / *corners as f64;
    let vertices = rings.iter().flat_map(|&[along, wide]| {
        (0..*corners).map(move |k| [x * along, y * wide * turn(k).cos(), z * wide * turn(k).sin()])
    });
    let last = (rings.len() - 1) * corners;
    let next = |corner: usize| (corner + 1) % corners;
    let sides = (0..rings.len() - 1).flat_map(|ring| {
        (0..*corners).flat_map(move |k| {
            let [a, b] = [ring * corners + k, ring * corners + next(k)];
            [[a, b, b + corners], [a, b + corners, a + corners]]
        })
    });
    let caps = (1..corners - 1).flat_map(|k| [[0, k + 1, k], [last, last + k, last + k + 1]]);
    let numbers = |numbers: Vec<String>| numbers.join(" ");
    format!(
        r#"<mesh name="{name}" vertex="{}" face="{}"/>"#,
        numbers(vertices.flatten().map(|x| ((1e6 * x).round() / 1e6).to_string()).collect()),
        numbers(sides.chain(caps).flatten().map(|vertex| vertex.to_string()).collect())
    )
}
