//! The report: one well-formed page that stands alone, whatever the names and however little is known.

use std::sync::Arc;

use bodyschema::agent::Agent;
use bodyschema::creature::{Body, JointSelection};
use bodyschema::evaluation::{Evaluation, evaluate};
use bodyschema::ground_truth::GroundTruth;
use bodyschema::mujoco::Model;
use bodyschema::senses::{ExactContact, RecordedTouch, Touch, TouchEnd};
use bodyschema::session::{self, Checkpoint, LearningRecord};
use bodyschema::view::report::{self, ReportInput};
use roxmltree::{Document, Node, ParsingOptions};
use serde_json::{Value, json};

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
    session: session::Session,
    truth: GroundTruth,
    evaluation: Evaluation,
    touches: Vec<RecordedTouch>,
    record: LearningRecord,
}

impl Session {
    /// Two touches of the left arm with the chest, one with the right arm.
    fn new() -> Session {
        let model = Arc::new(Model::from_xml(ODD).unwrap());
        let body = Body::new(model, &JointSelection::All).unwrap();
        let agent = Agent::of(&body).unwrap();
        let truth = GroundTruth::new(&body).unwrap();
        let evaluation = evaluate(&agent, &truth, &truth.schema, &[]);
        let touch = |a: &str, b: &str| {
            let receptors = [a, b].map(|id| agent.skin().receptor(id).unwrap());
            let (ends, posture) = (receptors.map(TouchEnd::at), body.creature.reference_posture());
            let points = receptors.map(|receptor| agent.skin().receptors[receptor].position);
            let contact = ExactContact { points, deviations: [None; 2], depth: None };
            RecordedTouch::new(Touch { bout: 0, motion: 1, posture, ends, moment: None }, contact)
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
        let record = LearningRecord {
            program: "bodyschema".into(),
            seed: 7,
            facts: vec![("Engine & co".into(), "<b>2.2</b>".into())],
            seconds: Some(4.31),
            converged: true,
            verdict: "It can be relied on, \"mostly\" <so far>.".into(),
            undetermined: vec!["ball".into()],
            open_directions: vec!["<ball> slides".to_string()],
            checkpoints,
            ..LearningRecord::default()
        };
        let command = ["bodyschema", "babble", "<odd>.xml"].map(String::from).to_vec();
        let session = session::Session { agent, command, ..session::Session::default() };
        Session { session, truth, evaluation, touches, record }
    }

    fn input(&self) -> ReportInput<'_> {
        ReportInput {
            session: &self.session,
            record: &self.record,
            schema: &self.truth.schema,
            std: None,
            truth: Some(&self.truth),
            evaluation: Some(&self.evaluation),
            touches: &self.touches,
            predictions: &[],
            space: None,
        }
    }

    /// The page of the same session that came to another end: `None` if that is not recorded.
    fn page_of(&self, converged: Option<bool>, undetermined: &[&str]) -> String {
        let record = LearningRecord {
            program: converged.map_or(String::new(), |_| "bodyschema".into()),
            converged: converged.unwrap_or_default(),
            undetermined: undetermined.iter().map(ToString::to_string).collect(),
            ..self.record.clone()
        };
        report::html(&ReportInput { record: &record, ..self.input() })
    }
}

/// What the page keeps of its body.
fn body(page: &str) -> Value {
    let data = page.split_once("<script type=\"application/json\">").expect("no body").1;
    serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap()
}

/// The names of a list's entries.
fn names(list: &Value) -> Vec<&str> {
    list.as_array().unwrap().iter().map(|entry| entry["name"].as_str().unwrap()).collect()
}

/// An element of a page, which lasts as long as the tests.
type Element = Node<'static, 'static>;

/// The marks of a chart that say something: what, with the mark itself.
fn marks(page: &str, id: &str) -> Vec<(String, Element)> {
    let within = |element: &Element| element.ancestors().any(|around| around.attribute("id") == Some(id));
    let titled = |element: Element| {
        let title = element.children().find(|child| child.has_tag_name("title"))?;
        Some((title.text().unwrap_or_default().to_string(), element))
    };
    parse(page).descendants().filter(within).filter_map(titled).collect()
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
    let text = Box::leak(without_scripts(page).into_boxed_str());
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).unwrap_or_else(|e| panic!("{e}\n{page}"));
    Box::leak(Box::new(document)).root_element()
}

/// The cells of a table, row by row.
fn rows(page: &Element, class: &str) -> Vec<Vec<String>> {
    let is_table = |e: &Element| e.has_tag_name("table") && e.attribute("class") == Some(class);
    let found: Vec<Element> = page.descendants().filter(is_table).collect();
    assert_eq!(found.len(), 1);
    let elements = |e: Element| e.children().filter(Element::is_element);
    let text = |cell: Element| cell.text().unwrap_or_default().to_string();
    let lines = elements(found[0]).flat_map(elements);
    lines.map(|line| elements(line).map(text).collect()).collect()
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
    assert!(!page.contains("<script src") && page.matches("<script>").count() == 1);
    assert!(page.len() < 150_000, "{} bytes", page.len());
    let viewer = [
        include_str!("../../src/view/body/paint.js"),
        include_str!("../../src/view/body/pull.js"),
        include_str!("../../src/view/body/body.js"),
    ];
    assert!(viewer.iter().all(|script| page.contains(script)), "the live page's viewer draws");
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
    assert_eq!(rows[1][7..], ["turn", "0.000", "0.000", "1.000", "0.000", "0.000"]);
    assert_eq!(rows[2][..7], ["left_shoulder", "", "", "", "", "", ""]);
    assert_eq!(rows[2][7..], ["lift", "0.000", "1.000", "0.000", "0.000", "0.000"]);
    let ball = ["ball", "trunk", "1", "no", "0.0", "−300.0", "0.0", "unlimited", "", "", "", "–", "–"];
    assert_eq!(rows[3], ball);
}

#[test]
fn the_errors_are_told_in_their_units() {
    let page = parse(&report::html(&Session::new().input()));
    let rows = rows(&page, "errors");
    assert_eq!(rows.len(), 6, "a head, four measures and the residual: this creature has no hands");
    assert_eq!(rows[1][1..], ["mm", "0.000", "0.000", "0.000", "0.000"]);
    assert_eq!(rows[3][1], "°");
    assert_eq!(rows[5][..2], ["contact residual of all touches", "mm"]);
}

#[test]
fn pairs_of_limbs_and_open_joints_are_named() {
    let page = report::html(&Session::new().input());
    assert!(page.contains("3 of 2 pairs of limbs"));
    let pairs: Vec<String> = marks(&page, "touch-matrix").into_iter().map(|(says, _)| says).collect();
    assert_eq!(pairs, ["left\"arm, trunk: 2 touches", "<right>, left\"arm: 1 touch"]);
    assert!(page.contains("do not determine 1 of 2 joints: ball."));
    let session = Session::new();
    let page = |converged, undetermined: &[&str]| session.page_of(Some(converged), undetermined);
    assert!(page(true, &[]).contains("No joint is undetermined"));
    assert!(
        page(true, &[]).contains("without effect on the positions of located limbs"),
        "nor do the directions that stay open"
    );
    assert!(
        page(false, &["left_shoulder", "ball"])
            .contains("All joints: no held-out touches confirm the schema")
    );
}

#[test]
fn a_page_without_truth_touches_or_curve_says_so() {
    let session = Session::new();
    let mut input = session.input();
    (input.truth, input.evaluation) = (None, None);
    let record =
        LearningRecord { program: "bodyschema".into(), converged: true, ..LearningRecord::default() };
    (input.touches, input.record) = (&[], &record);
    let page = report::html(&input);
    assert!(!rows(&parse(&page), "joints")[0].iter().any(|head| head.starts_with("error, ")));
    assert!(page.contains("The true body is not known"));
    assert!(page.contains("Too few checkpoints"));
    assert!(page.contains("No touches between named limbs"));
    let body = body(&page);
    assert_eq!(names(&body["layers"]), ["limbs", "receptors"], "nothing of the true body");
    assert_eq!(names(&body["skeletons"]), ["joints"]);
    assert!(!page.contains("type=\"range\""), "there is nothing to slide through");
}

#[test]
fn the_verdict_stands_first_in_its_colour_with_the_one_number() {
    let session = Session::new();
    let begin =
        |page: String| page.split_once("<canvas").unwrap().0.split_once("</header>").unwrap().1.to_string();
    for (converged, undetermined, colour) in [
        (Some(true), &[][..], "good"),
        (Some(true), &["ball"], "partly"),
        (Some(false), &[], "bad"),
        (None, &[], ""),
    ] {
        let begin = begin(session.page_of(converged, undetermined));
        let class = format!("class=\"verdict {colour}\"").replace(" \"", "\"");
        assert!(begin.contains(&class), "{class}: {begin}");
        assert!(begin.contains("<strong>0.000 mm</strong> after 3 touches in 4.3 s"), "{begin}");
    }
    let unknown = ReportInput { evaluation: None, ..session.input() };
    assert!(!begin(report::html(&unknown)).contains("headline"), "no number that nobody knows");
}

#[test]
fn the_same_session_gives_the_same_page() {
    let session = Session::new();
    assert_eq!(report::html(&session.input()), report::html(&session.input()));
}

#[test]
fn the_body_is_drawn_over_the_true_one_and_from_the_guess_on() {
    let session = Session::new();
    let page = report::html(&session.input());
    let body = body(&page);
    assert_eq!(names(&body["layers"]), ["limbs", "receptors", "true body"]);
    assert_eq!(names(&body["skeletons"]), ["joints", "true joints"]);
    assert_eq!(names(&body["steps"]), ["initial guess", "1", "2", "3"]);
    // What moves the body when it is pulled: the learned joints within their ranges, and where each limb is.
    let dofs = |joint: usize| body["joints"][joint]["dofs"].as_array().unwrap().clone();
    assert_eq!([dofs(0).len(), dofs(1).len()], [2, 1]);
    assert_eq!([&dofs(0)[1]["axis"], &dofs(0)[1]["range"]], [&json!([0, 10_000, 0]), &json!([-1.0, 1.0])]);
    assert_eq!([&body["joints"][1]["at"], &dofs(1)[0]["kind"]], [&json!([0, -3000, 0]), &json!("ball")]);
    assert_eq!(body["says"].as_array().unwrap().len(), 3);
    let errors: Vec<f64> =
        body["steps"].as_array().unwrap().iter().map(|step| step["mm"].as_f64().unwrap()).collect();
    assert_eq!(errors, [300.0, 200.0, 2.5, 1e-9]);
    // Two capsules and a box, and twenty-five corners a receptor: each with its shape, its limb and its corners.
    let lengths = |mesh: usize| -> Vec<usize> {
        body["meshes"][mesh].as_array().unwrap().iter().map(|piece| piece.as_array().unwrap().len()).collect()
    };
    assert_eq!(lengths(0), [2 + 3 * 8, 2 + 3 * 86, 2 + 3 * 86]);
    assert_eq!(lengths(1), [2 + 3 * 25; 3]);
    // Every pose has a quaternion and an origin per limb, and where each limb begins.
    let initial_guess = &body["steps"][0]["poses"]["learned"];
    assert_eq!(
        (
            initial_guess["frames"].as_array().unwrap().len(),
            initial_guess["begins"].as_array().unwrap().len()
        ),
        (21, 9)
    );
    // Coloured by touches: the left arm was touched three times, the chest twice.
    let values: Vec<f64> = body["values"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert_eq!(values[1], 1.0);
    assert!((values[0] - 2f64.ln_1p() / 3f64.ln_1p()).abs() < 1e-3, "{values:?}");
    assert_eq!(body["layers"][1]["labels"][0], "chest: touched 2 times");
    assert_eq!(body["skeletons"][0]["open"], json!([1]), "the second joint is undetermined");
}

#[test]
fn the_curve_has_the_error_its_bound_and_the_guess() {
    let session = Session::new();
    let marks = marks(&report::html(&session.input()), "curve");
    let says: Vec<&str> = marks.iter().map(|(says, _)| says.as_str()).collect();
    let told = [
        "touch 1, chest, l: residual 304 mm",
        "touch 2, chest, l: residual 304 mm",
        "touch 3, l, r: residual 600 mm",
        "random initial guess: 300 mm",
        "random initial guess: 300 mm",
        "held-out error after 1 touch: 200 mm",
        "held-out error after 2 touches: 2.50 mm",
        "held-out error after 3 touches: 1.0·10⁻⁹ mm",
        "Cramér-Rao bound after 2 touches: 1.25 mm",
        "Cramér-Rao bound after 3 touches: 5.0·10⁻¹⁰ mm",
    ];
    assert_eq!(says, told);
    // Both axes are logarithmic, and errors grow upwards.
    let at = |mark: usize, side: &str| marks[mark].1.attribute(side).unwrap().parse::<f64>().unwrap();
    let share = |side: &str, values: [f64; 3]| {
        let drawn = (at(7, side) - at(5, side)) / (at(6, side) - at(5, side));
        let [first, second, third] = values.map(f64::ln);
        drawn / ((third - first) / (second - first))
    };
    assert!((share("cy", [200.0, 2.5, 1e-9]) - 1.0).abs() < 0.01);
    assert!((share("cx", [1.0, 2.0, 3.0]) - 1.0).abs() < 0.01);
    assert!(at(7, "cy") > at(5, "cy"), "the greater error stands higher");
}
