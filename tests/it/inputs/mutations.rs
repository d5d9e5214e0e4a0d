//! Good files made bad, by a seed.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde_json::{Map, Value, json};

/// What takes the place of a number.
const NUMBERS: [&str; 26] = [
    "1e308",
    "-1e308",
    "1e999",
    "NaN",
    "nan",
    "inf",
    "-inf",
    "Infinity",
    "1e-320",
    "-1",
    "0",
    "-0",
    "1e9",
    "1e5",
    "57.3",
    "99999999999999999999",
    "9223372036854775808",
    "2147483648",
    "0x10",
    "1,5",
    "",
    "null",
    "\"1\"",
    "[1]",
    "{}",
    "true",
];
/// What is put into a text.
const TEXTS: [&str; 10] =
    ["\u{1b}[2J", "\u{0}", "\u{202e}", "\r", "\n", "\"", "<", "&", "\u{9b}", "ä\u{301}"];
/// Ways in which bytes are changed.
const OF_BYTES: usize = 20;
/// Ways in which JSON is changed.
const OF_JSON: usize = 7;

/// A file made bad, and by what.
pub struct Mutated {
    pub bytes: Vec<u8>,
    pub how: String,
}

/// A file with one change, seldom two or three.
pub fn mutated(rng: &mut ChaCha8Rng, original: &[u8]) -> Mutated {
    let mut mutated = Mutated { bytes: original.to_vec(), how: String::new() };
    let changes = if rng.random_range(0..6) == 0 { rng.random_range(2..4) } else { 1 };
    for _ in 0..changes {
        let json = (rng.random_range(0..3) == 0).then(|| changed_json(rng, &mutated.bytes)).flatten();
        let (bytes, how) = json.unwrap_or_else(|| changed_bytes(rng, &mutated.bytes));
        mutated.bytes = bytes;
        mutated.how = format!("{}{}{how}", mutated.how, if mutated.how.is_empty() { "" } else { ", " });
    }
    mutated
}

/// A number below `n`, 0 where that is 0.
fn below(rng: &mut ChaCha8Rng, n: usize) -> usize {
    if n == 0 { 0 } else { rng.random_range(0..n) }
}

fn changed_bytes(rng: &mut ChaCha8Rng, old: &[u8]) -> (Vec<u8>, String) {
    let at = below(rng, old.len());
    let mut bytes = old.to_vec();
    let put = |place: std::ops::Range<usize>, new: &[u8]| {
        let mut bytes = old.to_vec();
        bytes.splice(place, new.iter().copied());
        bytes
    };
    match rng.random_range(0..OF_BYTES) {
        0 if !old.is_empty() => {
            bytes[at] ^= 1 << rng.random_range(0..8);
            (bytes, "a bit flipped".into())
        }
        1 => {
            bytes.truncate(at);
            (bytes, "cut off".into())
        }
        2..=6 => {
            let Some(place) = token(rng, old, is_of_number) else { return (bytes, "nothing".into()) };
            let text = String::from_utf8_lossy(&old[place.clone()]).into_owned();
            let new = match (text.parse::<f64>(), rng.random_range(0..4)) {
                (Ok(x), 0) => {
                    let factors = [180.0 / std::f64::consts::PI, 1e3, 1e-3, -1.0, 1e6];
                    (x * factors[below(rng, factors.len())]).to_string()
                }
                _ => NUMBERS[below(rng, NUMBERS.len())].to_string(),
            };
            (put(place, new.as_bytes()), format!("{text} became {new:?}"))
        }
        7 => {
            let Some(place) = token(rng, old, is_of_word) else { return (bytes, "nothing".into()) };
            (put(place, b""), "a word left out".into())
        }
        8 => {
            let (Some(a), Some(b)) = (token(rng, old, is_of_word), token(rng, old, is_of_word)) else {
                return (bytes, "nothing".into());
            };
            let word = old[b].to_vec();
            (put(a, &word), format!("a word became {:?}", String::from_utf8_lossy(&word)))
        }
        9 => {
            let Some(mut place) = token(rng, old, is_of_word) else { return (bytes, "nothing".into()) };
            place.start = place.end - 1;
            (put(place, b""), "a letter left out".into())
        }
        10 => (
            of_lines(rng, old, |rng, lines| drop(lines.remove(below(rng, lines.len())))),
            "a line left out".into(),
        ),
        11 => {
            let twice = |rng: &mut ChaCha8Rng, lines: &mut Vec<Vec<u8>>| {
                let line = lines[below(rng, lines.len())].clone();
                lines.insert(below(rng, lines.len()), line);
            };
            (of_lines(rng, old, twice), "a line twice".into())
        }
        12 => {
            let swap = |rng: &mut ChaCha8Rng, lines: &mut Vec<Vec<u8>>| {
                let (a, b) = (below(rng, lines.len()), below(rng, lines.len()));
                lines.swap(a, b);
            };
            (of_lines(rng, old, swap), "two lines swapped".into())
        }
        13 => {
            let deep = ["[", "{\"a\":", "<a>", "(", "\""][below(rng, 5)].repeat(rng.random_range(1..60_000));
            (put(at..at, deep.as_bytes()), "nested deeply".into())
        }
        14 => (put(at..at, "a".repeat(rng.random_range(1..200_000)).as_bytes()), "a long text put in".into()),
        15 => {
            let text = TEXTS[below(rng, TEXTS.len())];
            let place = token(rng, old, is_of_word).map_or(at, |place| place.start);
            (put(place..place, text.as_bytes()), format!("{text:?} put in"))
        }
        16 => {
            let separators: [(&[u8], &[u8]); 5] =
                [(b",", b";"), (b",", b"\t"), (b".", b","), (b"\n", b"\r\n"), (b",", b", ")];
            let (from, to) = separators[below(rng, separators.len())];
            let text = String::from_utf8_lossy(from).into_owned();
            let parts: Vec<&[u8]> = old.split(|byte| *byte == from[0]).collect();
            (parts.join(to), format!("{text:?} became {:?}", String::from_utf8_lossy(to)))
        }
        17 => match rng.random_range(0..4) {
            0 => (put(0..0, b"\xef\xbb\xbf"), "a mark before it".into()),
            1 => {
                let wide = String::from_utf8_lossy(old)
                    .encode_utf16()
                    .flat_map(u16::to_le_bytes)
                    .collect::<Vec<u8>>();
                ([b"\xff\xfe", wide.as_slice()].concat(), "UTF-16".into())
            }
            2 => (put(at..at, b"\xe4"), "Latin 1".into()),
            _ => ([old, &[0; 100]].concat(), "zeros at its end".into()),
        },
        18 => ([old, old].concat(), "twice".into()),
        _ => {
            let (a, b) = (at, below(rng, old.len()));
            let part = old[a.min(b)..a.max(b)].to_vec();
            let short = &part[..part.len().min(2000)];
            (put(b..b, short), "a part put in elsewhere".into())
        }
    }
}

fn is_of_number(byte: u8) -> bool {
    byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+' | b'e' | b'E')
}

fn is_of_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.' | b'-')
}

/// A run of bytes that are `of` a kind, from somewhere in a file on; of numbers one with a digit.
fn token(rng: &mut ChaCha8Rng, bytes: &[u8], of: fn(u8) -> bool) -> Option<std::ops::Range<usize>> {
    let from = below(rng, bytes.len());
    let mut start = None;
    for at in (from..bytes.len()).chain([bytes.len()]) {
        let inside = bytes.get(at).is_some_and(|byte| of(*byte));
        match start {
            None if inside => start = Some(at),
            Some(begin) if !inside => {
                if bytes[begin..at].iter().any(u8::is_ascii_digit) || of(b'_') {
                    return Some(begin..at);
                }
                start = None;
            }
            _ => {}
        }
    }
    None
}

fn of_lines(
    rng: &mut ChaCha8Rng,
    old: &[u8],
    change: impl FnOnce(&mut ChaCha8Rng, &mut Vec<Vec<u8>>),
) -> Vec<u8> {
    let mut lines: Vec<Vec<u8>> = old.split_inclusive(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    if !lines.is_empty() {
        change(rng, &mut lines);
    }
    lines.concat()
}

/// JSON with a change at one of its places; of lines of JSON one of them.
fn changed_json(rng: &mut ChaCha8Rng, old: &[u8]) -> Option<(Vec<u8>, String)> {
    if let Ok(mut value) = serde_json::from_slice::<Value>(old) {
        let how = change_value(rng, &mut value)?;
        return Some((serde_json::to_vec_pretty(&value).ok()?, how));
    }
    let mut lines: Vec<Vec<u8>> = old.split_inclusive(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    let at = below(rng, lines.len());
    let mut value = serde_json::from_slice::<Value>(lines.get(at)?).ok()?;
    let how = change_value(rng, &mut value)?;
    lines[at] = format!("{value}\n").into_bytes();
    Some((lines.concat(), how))
}

/// Changes what a value holds at a place drawn, and tells how.
fn change_value(rng: &mut ChaCha8Rng, value: &mut Value) -> Option<String> {
    // Down the tree as long as the coin says so.
    let deeper = rng.random_range(0..5) != 0;
    match value {
        Value::Object(map) if !map.is_empty() => {
            let key = map.keys().nth(below(rng, map.len()))?.clone();
            let inner = map.get_mut(&key)?;
            if deeper && (inner.is_object() || inner.is_array()) {
                return change_value(rng, inner).map(|how| format!("{key}: {how}"));
            }
            Some(change_field(rng, map, &key))
        }
        Value::Array(list) if !list.is_empty() => {
            let at = below(rng, list.len());
            if deeper && (list[at].is_object() || list[at].is_array()) {
                return change_value(rng, &mut list[at]).map(|how| format!("{at}: {how}"));
            }
            Some(match rng.random_range(0..4) {
                0 => {
                    list.remove(at);
                    format!("{at} left out")
                }
                1 => {
                    let twice = list[at].clone();
                    list.insert(at, twice);
                    format!("{at} twice")
                }
                2 => {
                    let other = below(rng, list.len());
                    list.swap(at, other);
                    format!("{at} and {other} swapped")
                }
                _ => {
                    list[at] = other_value(rng);
                    format!("{at} became {}", list[at])
                }
            })
        }
        other => {
            *other = other_value(rng);
            Some(format!("all became {other}"))
        }
    }
}

fn change_field(rng: &mut ChaCha8Rng, map: &mut Map<String, Value>, key: &str) -> String {
    match rng.random_range(0..OF_JSON) {
        0 | 1 => {
            map.remove(key);
            format!("{key} left out")
        }
        2 => {
            let value = map.remove(key).unwrap_or_default();
            let slip = format!("{}x", &key[..key.char_indices().next_back().map_or(0, |(at, _)| at)]);
            map.insert(slip.clone(), value);
            format!("{key} became {slip}")
        }
        3 => {
            let other = map.keys().nth(below(rng, map.len())).cloned().unwrap_or_default();
            let value = map[&other].clone();
            map.insert(key.to_string(), value);
            format!("{key} became that of {other}")
        }
        _ => {
            let value = other_value(rng);
            let how = format!("{key} became {value}");
            map.insert(key.to_string(), value);
            how
        }
    }
}

fn other_value(rng: &mut ChaCha8Rng) -> Value {
    let values = [
        json!(null),
        json!(-1),
        json!(1e308),
        json!(-1e308),
        json!(0),
        json!(1e-320),
        json!(57.3),
        json!(u64::MAX),
        json!(1e5),
        json!(1.5),
        json!(""),
        json!("x"),
        json!("\u{1b}[31m"),
        json!([]),
        json!({}),
        json!([1, 2, 3]),
        json!(true),
        json!("1"),
    ];
    values[below(rng, values.len())].clone()
}
