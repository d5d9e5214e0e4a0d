//! The unit of length that a body is learned in.
//!
//! What is closed, placed or known is told in metres while a body is learned, as it holds for bodies of a person's size: the
//! wrong answers of a hand of four centimetres leave gaps as narrow as right ones of a person. So a smaller body is learned
//! as if it were larger, and a giant as if it were smaller. All lengths are multiplied by a power of two, which changes no
//! digit: of two bodies of one shape the same is learned, whatever their size.

use crate::agent::Agent;

/// The skin of the longest limb, in the unit that its body is learned in: at the least, and less than …
const LONGEST: [f64; 2] = [0.1, 1.6];
/// The smallest and the greatest unit, metres: of what is smaller than a millimetre no touches are exact enough.
const UNITS: [f64; 2] = [1.0 / 1024.0, 1024.0];

/// A unit of length: a power of two, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthUnit(f64);

impl LengthUnit {
    /// The metre, which bodies of a person's size are learned in.
    pub const METRE: LengthUnit = LengthUnit(1.0);

    /// The unit that a body is learned in, by the skin of its longest limb.
    pub fn of(agent: &Agent) -> LengthUnit {
        let longest = agent.skin().longest_limb();
        let mut unit = 1.0;
        if longest <= 0.0 {
            return LengthUnit::METRE;
        }
        while longest < LONGEST[0] * unit && unit > UNITS[0] {
            unit *= 0.5;
        }
        while longest >= LONGEST[1] * unit && unit < UNITS[1] {
            unit *= 2.0;
        }
        LengthUnit(unit)
    }

    /// The unit of so many metres; none of what is no unit of any body.
    pub fn from_metres(metres: f64) -> Option<LengthUnit> {
        let is_unit = (UNITS[0]..=UNITS[1]).contains(&metres) && metres.log2().fract() == 0.0;
        is_unit.then_some(LengthUnit(metres))
    }

    /// How many metres it is.
    pub fn metres(self) -> f64 {
        self.0
    }

    /// An agent in this unit.
    pub fn agent(self, agent: &Agent) -> Agent {
        if self == LengthUnit::METRE { agent.clone() } else { agent.scaled(1.0 / self.0) }
    }
}
