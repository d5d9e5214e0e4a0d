//! How a limb moves on the one that carries it.

use nalgebra::Vector3;

use super::draw::Draw;
use crate::creature::DofKind;

/// A degree of freedom as it is drawn, in the frame of the limb that it moves.
#[derive(Clone, Debug)]
pub struct Freedom {
    /// Its kind.
    pub kind: DofKind,
    /// Where it is, metres.
    pub anchor: Vector3<f64>,
    /// Its axis; a ball has none.
    pub axis: Vector3<f64>,
    /// Least and greatest coordinate, degrees or metres; of a ball 0 and the largest angle.
    pub range: [f64; 2],
    /// The degree of freedom of the limb before it that it follows, times so much; `None` if it moves independently.
    pub follows: Option<f64>,
}

impl Freedom {
    /// One through the limb's origin, that moves on its own.
    pub fn new(kind: DofKind, axis: Vector3<f64>, range: [f64; 2]) -> Freedom {
        Freedom { kind, anchor: Vector3::zeros(), axis, range, follows: None }
    }
}

/// What joins a limb to the one that carries it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Joining {
    /// One hinge across the limb.
    Hinge,
    /// Two hinges that meet in a point.
    TwoHinges,
    /// Three hinges that meet in a point.
    ThreeHinges,
    /// Two hinges a way apart.
    Apart,
    /// A ball.
    Ball,
    /// A slide.
    Slide,
    /// A hinge and a slide along its axis.
    HingeAndSlide,
    /// A hinge that gives by a fraction of a degree.
    Locked,
    /// A hinge along a limb that is round about it: touch feels nothing of it.
    Spin,
    /// Nothing: both are one.
    Welded,
}

/// Which joints a body has.
#[derive(Clone, Copy, Debug)]
pub struct JointStyle {
    /// Whether there are others than hinges.
    pub mixed: bool,
    /// How far axes are off straight ones: 0 not at all, 1 and more in any direction.
    pub skew: f64,
    /// How wide ranges are, in units of common ones.
    pub width: f64,
}

impl JointStyle {
    /// Draws how a body's joints are.
    pub fn drawn(draw: &mut Draw) -> JointStyle {
        JointStyle {
            mixed: draw.chance(0.5),
            skew: draw.weighted(&[(0.0, 0.15), (0.3, 0.4), (0.8, 0.25), (3.0, 0.2)]),
            width: draw.weighted(&[(0.5, 0.15), (1.0, 0.6), (1.4, 0.25)]),
        }
    }

    /// What joins the next limb.
    pub fn joining(&self, draw: &mut Draw) -> Joining {
        use Joining::{
            Apart, Ball, Hinge, HingeAndSlide, Locked, Slide, Spin, ThreeHinges, TwoHinges, Welded,
        };
        match self.mixed {
            false => draw.weighted(&[(Hinge, 0.68), (TwoHinges, 0.2), (ThreeHinges, 0.08), (Apart, 0.04)]),
            true => draw.weighted(&[
                (Hinge, 0.42),
                (TwoHinges, 0.14),
                (ThreeHinges, 0.05),
                (Apart, 0.05),
                (Ball, 0.1),
                (Slide, 0.07),
                (HingeAndSlide, 0.03),
                (Locked, 0.05),
                (Spin, 0.05),
                (Welded, 0.04),
            ]),
        }
    }

    /// The degrees of freedom of a limb, so long, metres.
    pub fn freedoms(&self, draw: &mut Draw, joining: Joining, length: f64) -> Vec<Freedom> {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let hinge = |draw: &mut Draw, axis: &Vector3<f64>| {
            let axis = draw.about(axis, self.skew);
            Freedom::new(DofKind::Hinge, axis, self.hinge_range(draw))
        };
        let slide = |draw: &mut Draw, skew: f64| {
            let axis = draw.about(&z, skew);
            let range = [-draw.between(0.02, 0.3) * length, draw.between(0.05, 0.4) * length];
            Freedom::new(DofKind::Slide, axis, range)
        };
        match joining {
            Joining::Hinge => {
                let across = if draw.chance(0.5) { x } else { y };
                vec![hinge(draw, &across)]
            }
            Joining::TwoHinges => {
                let second = if draw.chance(0.7) { y } else { z };
                vec![hinge(draw, &x), hinge(draw, &second)]
            }
            Joining::ThreeHinges => [x, y, z].iter().map(|axis| hinge(draw, axis)).collect(),
            Joining::Apart => {
                // What is between them has no skin: where it is nobody can feel.
                let apart = draw.between(0.05, 0.2) * length;
                let first = Freedom { anchor: z * -apart, ..hinge(draw, &x) };
                vec![first, hinge(draw, &y)]
            }
            Joining::Ball => vec![Freedom::new(DofKind::Ball, z, [0.0, draw.between(40.0, 150.0)])],
            Joining::Slide => vec![slide(draw, self.skew)],
            Joining::HingeAndSlide => {
                let hinge = hinge(draw, &z);
                let slide = Freedom { axis: hinge.axis, ..slide(draw, 0.0) };
                vec![hinge, slide]
            }
            Joining::Locked => {
                let hinge = hinge(draw, &x);
                let give = draw.log_between(0.001, 0.5);
                vec![Freedom { range: [-give, give], ..hinge }]
            }
            Joining::Spin => vec![Freedom { axis: z, ..hinge(draw, &z) }],
            Joining::Welded => Vec::new(),
        }
    }

    /// The range of a hinge, degrees: most limbs fold to one side, some to both, a few hardly.
    fn hinge_range(&self, draw: &mut Draw) -> [f64; 2] {
        let [low, high] = match draw.weighted(&[(0, 0.5), (1, 0.4), (2, 0.1)]) {
            0 => [draw.between(10.0, 60.0), draw.between(80.0, 150.0)],
            1 => [draw.between(80.0, 150.0), draw.between(80.0, 150.0)],
            _ => [draw.between(5.0, 25.0), draw.between(5.0, 25.0)],
        };
        let range = [low, high].map(|side| (self.width * side).min(175.0));
        if draw.chance(0.5) { [-range[0], range[1]] } else { [-range[1], range[0]] }
    }
}
