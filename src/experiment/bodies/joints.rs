//! How a limb moves on the one that carries it.

use nalgebra::Vector3;

use super::draw::Draw;

/// The kinds of MuJoCo's joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moves {
    /// Turns about an axis.
    Hinge,
    /// Shifts along an axis.
    Slide,
    /// Turns freely about a point.
    Ball,
}

/// A degree of freedom as it is drawn, in the frame of the limb that it moves.
#[derive(Clone, Debug)]
pub struct Freedom {
    /// Its kind.
    pub moves: Moves,
    /// Where it is, metres.
    pub anchor: Vector3<f64>,
    /// Its axis; a ball has none.
    pub axis: Vector3<f64>,
    /// Least and greatest coordinate, degrees or metres; of a ball 0 and the largest angle.
    pub range: [f64; 2],
    /// The degree of freedom of the limb before it that it follows, times so much; none where it moves by itself.
    pub follows: Option<f64>,
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
        let hinge = |draw: &mut Draw, axis: &Vector3<f64>, anchor: f64| Freedom {
            moves: Moves::Hinge,
            anchor: z * anchor,
            axis: draw.about(axis, self.skew),
            range: self.hinge_range(draw),
            follows: None,
        };
        let slide = |draw: &mut Draw, skew: f64| Freedom {
            moves: Moves::Slide,
            anchor: Vector3::zeros(),
            axis: draw.about(&z, skew),
            range: [-draw.between(0.02, 0.3) * length, draw.between(0.05, 0.4) * length],
            follows: None,
        };
        match joining {
            Joining::Hinge => {
                let across = if draw.chance(0.5) { x } else { y };
                vec![hinge(draw, &across, 0.0)]
            }
            Joining::TwoHinges => {
                let second = if draw.chance(0.7) { y } else { z };
                vec![hinge(draw, &x, 0.0), hinge(draw, &second, 0.0)]
            }
            Joining::ThreeHinges => [x, y, z].iter().map(|axis| hinge(draw, axis, 0.0)).collect(),
            Joining::Apart => {
                // What is between them has no skin: where it is nobody can feel.
                let apart = draw.between(0.05, 0.2) * length;
                vec![hinge(draw, &x, -apart), hinge(draw, &y, 0.0)]
            }
            Joining::Ball => vec![Freedom {
                moves: Moves::Ball,
                anchor: Vector3::zeros(),
                axis: z,
                range: [0.0, draw.between(40.0, 150.0)],
                follows: None,
            }],
            Joining::Slide => vec![slide(draw, self.skew)],
            Joining::HingeAndSlide => {
                let mut both = vec![hinge(draw, &z, 0.0), slide(draw, 0.0)];
                both[1].axis = both[0].axis;
                both
            }
            Joining::Locked => {
                let mut locked = hinge(draw, &x, 0.0);
                let give = draw.log_between(0.001, 0.5);
                locked.range = [-give, give];
                vec![locked]
            }
            Joining::Spin => {
                let mut spin = hinge(draw, &z, 0.0);
                spin.axis = z;
                vec![spin]
            }
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
