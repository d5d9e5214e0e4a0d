//! Shares: work in numbered pieces that several processes make between them.

use crate::error::Error;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// The most shares that work is cut into.
const MOST: u64 = 100_000;

/// What is wrong with a share's name.
fn no_share() -> Error {
    Error::usage(format!(
        "give a share and their number, such as 3/16: from 1/16 to 16/16, at most {MOST} shares"
    ))
}

/// One of so many equal shares of work that comes in numbered pieces: every so-manieth piece, so that all shares take
/// about as long, however much there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Share {
    of: u64,
    number: u64,
}

impl Share {
    /// All of it.
    pub const WHOLE: Share = Share { of: 1, number: 1 };

    /// The share of a number, from 1 on; `None` if it is not one of so many.
    pub fn new(number: u64, of: u64) -> Option<Share> {
        (1..=of.min(MOST)).contains(&number).then_some(Share { of, number }).filter(|_| of <= MOST)
    }

    /// All shares of work that is cut into so many.
    pub fn all(of: u64) -> impl Iterator<Item = Share> {
        (1..=of).map(move |number| Share { of, number })
    }

    /// Its number, from 1 on.
    pub fn number(self) -> u64 {
        self.number
    }

    /// How many there are.
    pub fn of(self) -> u64 {
        self.of
    }

    /// Its own among numbered pieces of work.
    pub fn own(self, pieces: Range<u64>) -> impl Iterator<Item = u64> {
        pieces.skip(self.number as usize - 1).step_by(self.of as usize)
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Share {
    type Err = Error;

    fn from_str(text: &str) -> Result<Share, Error> {
        let (number, of) = text.split_once('/').ok_or_else(no_share)?;
        let whole = |text: &str| text.parse::<u64>().map_err(|_| no_share());
        Share::new(whole(number)?, whole(of)?).ok_or_else(no_share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_have_every_piece_once() {
        for of in [1, 3, 16] {
            for pieces in [0, 1, 7, 48, 100] {
                let mut had: Vec<u64> = Vec::new();
                for share in Share::all(of) {
                    had.extend(share.own(0..pieces));
                }
                had.sort_unstable();
                assert_eq!(had, (0..pieces).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn a_share_is_read_as_it_is_written_and_no_other_is() {
        assert_eq!("3/16".parse::<Share>().unwrap().to_string(), "3/16");
        for wrong in [
            "",
            "3",
            "/",
            "0/3",
            "4/3",
            "1/0",
            "-1/3",
            "1/3/5",
            "1 / 3",
            "1/100001",
            "99999999999999999999/1",
        ] {
            assert!(wrong.parse::<Share>().is_err(), "{wrong}");
        }
    }
}
