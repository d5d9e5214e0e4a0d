//! The report: one well-formed page that stands alone, whatever the names and however little is known.

use std::sync::Arc;

use bodyschema::creature::{Body, JointSelection};
use bodyschema::evaluation::{Evaluation, evaluate, report};
use bodyschema::ground_truth::GroundTruth;
use bodyschema::learning::Input;
use bodyschema::mujoco::Model;
use bodyschema::record::Checkpoint;
use bodyschema::senses::{Touch, TouchEnd};
use bodyschema::skin::{Skin, skin_of};
use report::ReportInput;
use serde_json::{Value, json};
use xmltree::Element;

/// Two arms on a trunk, with names that would break out of a careless page.
const ODD: &str = r#"<mujoco model="&lt;script&gt;alert('1')&lt;/script&gt; &amp; co">
  <compiler angle="radian"/>
  <worldbody>
    <body name="trunk">
      <freejoint/>
      <geom type="box" size="0.1 0.2 0.3"/>
      <site name="chest" type="box" size="0.02 0.03 0.001" pos="0.1 0 0" quat="0.7 0 0.7 0"/>
      <body name="left&quot;arm" pos="0 0.3 0">
        <joint name="left_shoulder_turn" axis="0 0 1" limited="true" range="-1 1"/>
        <joint name="left_shoulder_lift" axis="0 1 0" limited="true" range="-1 1"/>
        <geom type="capsule" size="0.05 0.1"/>
        <site name="l" type="box" size="0.02 0.02 0.001" pos="0.05 0 0" quat="0.7 0 0.7 0"/>
      </body>
      <body name="&lt;right&gt;" pos="0 -0.3 0">
        <joint name="ball" type="ball"/>
        <geom type="capsule" size="0.05 0.1"/>
        <site name="r" type="box" size="0.02 0.02 0.001" pos="0.05 0 0" quat="0.7 0 0.7 0"/>
      </body>
    </body>
  </worldbody>
  <sensor><touch site="chest"/> <touch site="l"/> <touch site="r"/></sensor>
</mujoco>"#;

struct Session {
    body: Body,
    skin: Skin,
    truth: GroundTruth,
    evaluation: Evaluation,
    touches: Vec<Touch>,
    checkpoints: Vec<Checkpoint>,
    open: Vec<String>,
}

impl Session {
    /// Two touches of the left arm with the chest, one with the right arm.
    fn new() -> Session {
        let model = Arc::new(Model::from_xml(ODD).unwrap());
        let body = Body::new(model, &JointSelection::All).unwrap();
        let skin = skin_of(&body);
        let truth = GroundTruth::new(&body).unwrap();
        let evaluation = evaluate(&body.creature, &skin, &truth, &truth.schema, &[]);
        let touch = |a: &str, b: &str| Touch {
            bout: 0,
            motion: 1,
            posture: body.creature.reference_posture(),
            ends: [a, b].map(|id| {
                let receptor = skin.receptor(id).unwrap();
                TouchEnd { receptor, contact: skin.receptors[receptor].position, deviation: None }
            }),
            moment: None,
        };
        let touches = vec![touch("chest", "l"), touch("chest", "l"), touch("l", "r")];
        let checkpoint = |touches: usize, error: f64| Checkpoint {
            touches,
            schema: truth.schema.clone(),
            error_rms: Some(error),
            bound_rms: (touches > 1).then_some(0.5 * error),
        };
        let checkpoints =
            vec![checkpoint(0, 300.0), checkpoint(1, 200.0), checkpoint(2, 2.5), checkpoint(3, 1e-9)];
        let open = vec!["<ball> slides".to_string()];
        Session { body, skin, truth, evaluation, touches, checkpoints, open }
    }

    fn input(&self) -> ReportInput<'_> {
        ReportInput {
            creature: &self.body.creature,
            skin: &self.skin,
            schema: &self.truth.schema,
            std: None,
            truth: Some(&self.truth.schema),
            evaluation: Some(&self.evaluation),
            touches: &self.touches,
            input: Input::Receptor,
            checkpoints: &self.checkpoints,
            predictions: &[],
            space: None,
            seed: 7,
            commands: vec![("Made by".into(), "bodyschema babble '<odd>.xml'".into())],
            facts: vec![("Engine & co".into(), "<b>2.2</b>".into())],
            verdict: "It can be relied on, \"mostly\" <so far>.".into(),
            undetermined: &[1],
            undetermined_limbs: &[],
            open_directions: &self.open,
        }
    }
}

/// What the page keeps of a picture: its traces and layout.
fn picture(page: &str, id: &str) -> Value {
    let begin = format!("<script type=\"application/json\" data-plot=\"{id}\">");
    let data = page.split_once(&begin).unwrap_or_else(|| panic!("no picture {id}")).1;
    serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap()
}

/// The page without what only a browser reads: scripts, and the data of pictures.
fn without_scripts(page: &str) -> String {
    let mut parts = page.split("<script");
    let mut rest = parts.next().unwrap().to_string();
    parts.for_each(|part| rest.push_str(part.split_once("</script>").unwrap().1));
    rest
}

/// The page as a tree: it is written so that it is XML as well.
fn parse(page: &str) -> Element {
    Element::parse(without_scripts(page).as_bytes()).unwrap_or_else(|e| panic!("{e}\n{page}"))
}

fn tables<'a>(element: &'a Element, class: &str, found: &mut Vec<&'a Element>) {
    if element.name == "table" && element.attributes.get("class").is_some_and(|c| c == class) {
        found.push(element);
    }
    for child in element.children.iter().filter_map(|child| child.as_element()) {
        tables(child, class, found);
    }
}

/// The cells of a table, row by row.
fn rows(page: &Element, class: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    tables(page, class, &mut found);
    assert_eq!(found.len(), 1);
    let elements =
        |e: &'_ Element| e.children.iter().filter_map(|c| c.as_element()).cloned().collect::<Vec<Element>>();
    let text = |cell: &Element| cell.get_text().map(String::from).unwrap_or_default();
    let lines = elements(found[0]).iter().flat_map(elements).collect::<Vec<_>>();
    lines.iter().map(|line| elements(line).iter().map(text).collect()).collect()
}

#[test]
fn the_page_is_well_formed_and_stands_alone() {
    let page = report::html(&Session::new().input());
    parse(&page);
    let read = without_scripts(&page);
    for outside in ["src=", "url(", "@import", "<iframe", "http"] {
        assert!(!read.contains(outside), "{outside}");
    }
    assert_eq!(read.matches("href=").count(), 1, "the icon, which is empty");
    assert!(!page.contains("<script src") && page.matches("plotly.js v").count() == 1);
    assert!(page.len() < 6_000_000, "{} bytes", page.len());
    assert!(page.contains("&lt;script&gt;alert(&#39;1&#39;)&lt;/script&gt; &amp; co"));
    assert!(page.contains("<code>bodyschema babble &#39;&lt;odd&gt;.xml&#39;</code>"));
    assert!(page.contains("<li>&lt;ball&gt; slides</li>"));
    assert!(page.contains("&lt;b&gt;2.2&lt;/b&gt;"));
    assert!(page.contains("&quot;mostly&quot; &lt;so far&gt;"));
}

#[test]
fn the_joints_are_told_with_their_touches_and_errors() {
    let page = parse(&report::html(&Session::new().input()));
    let rows = rows(&page, "joints");
    assert_eq!(rows.len(), 4, "a head, two axes of a shoulder, a ball");
    let shoulder = ["left_shoulder", "trunk", "3", "yes", "0.0", "300.0", "0.0"];
    assert_eq!(rows[1][..7], shoulder);
    assert_eq!(rows[1][7..], ["turn", "0.000", "0.000", "1.000", "0", "0"]);
    assert_eq!(rows[2], ["lift", "0.000", "1.000", "0.000", "0", "0"]);
    let ball = ["ball", "trunk", "1", "no", "0.0", "−300.0", "0.0", "", "turns freely", "–", "–"];
    assert_eq!(rows[3], ball);
}

#[test]
fn the_errors_are_told_in_their_units() {
    let page = parse(&report::html(&Session::new().input()));
    let rows = rows(&page, "errors");
    assert_eq!(rows.len(), 5, "a head and four measures: this creature has no hands");
    assert_eq!(rows[1][1..], ["mm", "0", "0", "0", "0"]);
    assert_eq!(rows[3][1], "°");
}

#[test]
fn pairs_of_limbs_and_open_joints_are_named() {
    let page = report::html(&Session::new().input());
    assert!(page.contains("3, between 2 pairs of aura limbs"));
    let matrix = picture(&page, "touch-matrix");
    assert_eq!(matrix["data"][0]["hovertext"][1][0], "left&quot;arm, trunk: 2 touches");
    assert_eq!(matrix["data"][0]["hovertext"][2][1], "&lt;right&gt;, left&quot;arm: 1 touch");
    assert_eq!(matrix["layout"]["annotations"].as_array().unwrap().len(), 2);
    assert!(page.contains("do not determine 1 of 2 joints: ball."));
    let session = Session::new();
    let page = |undetermined| report::html(&ReportInput { undetermined, ..session.input() });
    assert!(page(&[]).contains("found no joint undetermined"));
    assert!(page(&[0, 1]).contains("Of no joint is it known"));
}

#[test]
fn a_page_without_truth_touches_or_curve_says_so() {
    let session = Session::new();
    let mut input = session.input();
    (input.truth, input.evaluation) = (None, None);
    (input.touches, input.checkpoints, input.undetermined) = (&[], &[], &[]);
    let page = report::html(&input);
    assert!(!rows(&parse(&page), "joints")[0].iter().any(|head| head.starts_with("off by")));
    assert!(page.contains("The truth is not known"));
    assert!(page.contains("Too little was kept"));
    assert!(page.contains("No touch between named limbs"));
    let body = picture(&page, "body");
    assert_eq!(body["data"].as_array().unwrap().len(), 4, "nothing of the true body");
    assert!(body["layout"].get("sliders").is_none());
}

#[test]
fn the_same_session_gives_the_same_page() {
    let session = Session::new();
    assert_eq!(report::html(&session.input()), report::html(&session.input()));
}

#[test]
fn the_body_is_drawn_over_the_true_one_and_from_the_onset_on() {
    let session = Session::new();
    let body = picture(&report::html(&session.input()), "body");
    let names: Vec<&str> =
        body["data"].as_array().unwrap().iter().filter_map(|trace| trace["name"].as_str()).collect();
    assert_eq!(names, ["limbs", "receptors", "bones", "joints", "true body", "true joints"]);
    let steps = body["layout"]["sliders"][0]["steps"].as_array().unwrap();
    let labels: Vec<&str> = steps.iter().filter_map(|step| step["label"].as_str()).collect();
    assert_eq!(labels, ["onset", "1", "2", "3"]);
    // Two capsules and a box of corners, and four corners a receptor, coloured by its touches.
    let (limbs, receptors) = (&body["data"][0], &body["data"][1]);
    assert_eq!(limbs["x"].as_array().unwrap().len(), 2 * 42 + 8);
    let shades: Vec<f64> =
        receptors["intensity"].as_array().unwrap().iter().map(|shade| shade.as_f64().unwrap()).collect();
    assert_eq!(shades[0], 2f64.ln_1p(), "the chest was touched twice");
    assert_eq!(shades.len(), 12);
    // The second joint is undetermined.
    let colours = &body["data"][3]["marker"]["color"];
    assert_ne!(colours[0], colours[1]);
}

#[test]
fn the_curve_has_the_error_its_bound_and_the_onset() {
    let session = Session::new();
    let curve = picture(&report::html(&session.input()), "curve");
    let trace = |name: &str| {
        let traces = curve["data"].as_array().unwrap();
        traces.iter().find(|trace| trace["name"] == name).unwrap_or_else(|| panic!("no {name}"))["y"].clone()
    };
    assert_eq!(trace("held-out error"), json!([200.0, 2.5, 1e-9]));
    assert_eq!(trace("Cramér-Rao bound"), json!([1.25, 5e-10]));
    assert_eq!(trace("error of a random onset"), json!([300.0, 300.0]));
    for axis in ["xaxis", "yaxis"] {
        assert_eq!(curve["layout"][axis]["type"], "log");
    }
}
