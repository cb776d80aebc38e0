//! What can be wrong with a scene, and where.

use crate::json::{KeyPath, Position, Segment, locate};
use thiserror::Error;

/// Something wrong at a place of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The file, as it was named.
    pub file: String,
    /// Line and column, where the file is text.
    pub position: Option<Position>,
    /// The key path (`bodies[3].shapes[0].box.half`), or the place in a mesh.
    pub key: String,
    /// What is wrong.
    pub message: String,
    /// What would be accepted.
    pub expected: String,
    /// A key or name that was probably meant.
    pub suggestion: Option<String>,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut text = self.file.clone();
        if let Some(p) = self.position {
            text += &format!(":{}:{}", p.line, p.column);
        }
        if !self.key.is_empty() {
            text += &format!(": {}", self.key);
        }
        text += &format!(": {}", self.message);
        if !self.expected.is_empty() {
            text += &format!("; expected {}", self.expected);
        }
        if let Some(s) = &self.suggestion {
            text += &format!(" (did you mean `{s}`?)");
        }
        f.write_str(&one_line(&text))
    }
}

/// Names from a file may hold line breaks and control characters; a message is one line.
fn one_line(text: &str) -> String {
    // What turns the reading direction would show another text than there is.
    let turns =
        |c: char| matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let escape =
        |c: char| if c.is_control() || turns(c) { c.escape_default().collect() } else { String::from(c) };
    text.chars().map(escape).collect()
}

/// Why a scene was not loaded or not run.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A file that cannot be read.
    #[error("{}: {}", one_line(file), one_line(message))]
    File {
        /// The file, as it was named.
        file: String,
        /// What went wrong, and what was expected.
        message: String,
    },
    /// Something wrong at a place: `file:line:column: key: message; expected …`.
    #[error("{0}")]
    Fault(Box<Fault>),
    /// The scene needs files that this machine does not have; not a mistake in the scene.
    #[error("skipped: {}", one_line(.0))]
    Skipped(String),
    /// The engine refused a step or a timed action.
    #[error("{}: at {time} s: {}", one_line(scene), one_line(message))]
    Run {
        /// Name of the scene.
        scene: String,
        /// Simulated time, seconds.
        time: f64,
        /// What was refused, and why.
        message: String,
    },
}

impl SceneError {
    /// Says which entry of the file asked for what was refused.
    pub(crate) fn within(mut self, entry: &str) -> Self {
        if let Self::Run { message, .. } = &mut self {
            *message = format!("{entry}: {message}");
        }
        self
    }

    /// The place, where there is one.
    pub fn fault(&self) -> Option<&Fault> {
        match self {
            Self::Fault(f) => Some(f),
            _ => None,
        }
    }
}

/// A wrong value on its way up: every level that it passes adds its key.
#[derive(Debug)]
pub(crate) struct Wrong(Box<WrongParts>);

#[derive(Debug)]
struct WrongParts {
    /// Innermost first.
    path: Vec<Segment>,
    message: String,
    expected: String,
    suggestion: Option<String>,
    at_key: bool,
    /// Absent assets: shown as they are.
    ready: Option<SceneError>,
}

pub(crate) type Checked<T> = Result<T, Wrong>;

impl Wrong {
    pub(crate) fn new(message: impl Into<String>, expected: impl Into<String>) -> Self {
        Self(Box::new(WrongParts {
            path: Vec::new(),
            message: message.into(),
            expected: expected.into(),
            suggestion: None,
            at_key: false,
            ready: None,
        }))
    }

    pub(crate) fn at(path: KeyPath, message: impl Into<String>, expected: impl Into<String>) -> Self {
        let mut w = Self::new(message, expected);
        w.0.path = path.0.into_iter().rev().collect();
        w
    }

    pub(crate) fn ready(e: SceneError) -> Self {
        let mut w = Self::new("", "");
        w.0.ready = Some(e);
        w
    }

    pub(crate) fn suggest(mut self, suggestion: Option<String>) -> Self {
        self.0.suggestion = suggestion;
        self
    }

    /// Point at the key instead of the value.
    pub(crate) fn of_key(mut self) -> Self {
        self.0.at_key = true;
        self
    }

    pub(crate) fn key(mut self, key: &str) -> Self {
        self.0.path.push(Segment::Key(key.into()));
        self
    }

    pub(crate) fn index(mut self, index: usize) -> Self {
        self.0.path.push(Segment::Index(index));
        self
    }

    /// The innermost key by another name, where a value stands under one of its own.
    pub(crate) fn renamed(mut self, key: &str) -> Self {
        if let Some(first) = self.0.path.first_mut() {
            *first = Segment::Key(key.into());
        }
        self
    }

    /// With its place in the file.
    pub(crate) fn locate(self, file: &str, text: &str) -> SceneError {
        let mut w = *self.0;
        if let Some(e) = w.ready {
            return e;
        }
        w.path.reverse();
        let path = KeyPath(w.path);
        SceneError::Fault(Box::new(Fault {
            file: file.into(),
            position: Some(locate(text, &path, w.at_key)),
            key: path.to_string(),
            message: w.message,
            expected: w.expected,
            suggestion: w.suggestion,
        }))
    }
}

/// Adds keys to errors that pass.
pub(crate) trait Under<T> {
    fn key(self, key: &str) -> Checked<T>;
    fn index(self, index: usize) -> Checked<T>;
}

impl<T> Under<T> for Checked<T> {
    fn key(self, key: &str) -> Checked<T> {
        self.map_err(|w| w.key(key))
    }
    fn index(self, index: usize) -> Checked<T> {
        self.map_err(|w| w.index(index))
    }
}

/// The engine's complaint about a value, with the field it names as the last key.
impl From<jounce::Error> for Wrong {
    fn from(e: jounce::Error) -> Self {
        use jounce::Error;
        match e {
            Error::BadValue { field, value, expected, .. } => {
                let mut w = Self::new(format!("is {value}"), expected);
                w.0.path.extend(field.rsplit('.').map(|k| Segment::Key(k.into())));
                w
            }
            Error::Geometry(g) => g.into(),
            Error::Unsupported { what, advice } => Self::new(format!("{what}: {advice}"), ""),
            Error::Limit { what, limit } => {
                Self::new(format!("too many: {what}"), format!("at most {limit}"))
            }
            e => Self::new(e.to_string(), ""),
        }
    }
}

impl From<jounce::geometry::GeometryError> for Wrong {
    fn from(e: jounce::geometry::GeometryError) -> Self {
        use jounce::geometry::GeometryError as G;
        match e {
            G::BadNumber { shape, field, value, expected } => {
                let mut w = Self::new(format!("is {value}"), expected);
                w.0.path.extend(field.rsplit('.').map(|k| Segment::Key(k.into())));
                w.key(shape)
            }
            G::Unsupported { shape, what } => Self::new(what, "").key(shape),
            G::BadCount { shape, what, count, expected } => {
                Self::new(format!("{what}: {count}"), expected).key(shape)
            }
            G::NotFinite { shape, what, index } => {
                Self::new(format!("{what} {index} is not finite"), "finite coordinates").key(shape)
            }
            G::BadIndex { shape, triangle, index, vertices } => Self::new(
                format!("triangle {triangle} names vertex {index}"),
                format!("less than {vertices}"),
            )
            .key(shape),
            e @ G::Degenerate { .. } => {
                let s = e.to_string();
                let (message, expected) = s.split_once(", expected ").unwrap_or((&s, ""));
                Self::new(message.trim_start_matches("hull: "), expected).key("hull")
            }
        }
    }
}

/// The candidate closest to `word` by edits (insert, delete, replace, swap), if close enough to be a slip.
pub(crate) fn closest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let word: Vec<char> = word.chars().take(64).flat_map(char::to_lowercase).collect();
    let mut best: Option<(usize, &str)> = None;
    for c in candidates {
        let other: Vec<char> = c.chars().take(64).flat_map(char::to_lowercase).collect();
        let d = edits(&word, &other);
        let contained = word.len() >= 4 && c.to_lowercase().contains(&word.iter().collect::<String>());
        let same_start = word.iter().zip(&other).take_while(|(a, b)| a == b).count();
        let close = d <= 1 + other.len().max(word.len()) / 4 || contained || (same_start >= 3 && d <= 3);
        if close && best.is_none_or(|(b, _)| d < b) {
            best = Some((d, c));
        }
    }
    best.map(|(_, c)| c.to_string())
}

/// Optimal string alignment distance.
fn edits(a: &[char], b: &[char]) -> usize {
    let width = b.len() + 1;
    let mut d = vec![0usize; (a.len() + 1) * width];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            d[i * width + j] = if i == 0 || j == 0 {
                i + j
            } else {
                let replace = d[(i - 1) * width + j - 1] + usize::from(a[i - 1] != b[j - 1]);
                let mut v = replace.min(d[(i - 1) * width + j] + 1).min(d[i * width + j - 1] + 1);
                if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                    v = v.min(d[(i - 2) * width + j - 2] + 1);
                }
                v
            };
        }
    }
    d[a.len() * width + b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_one_line() {
        let w = Wrong::new("there is no body \"a\nb\"", "").key("body");
        assert_eq!(w.locate("x", "{}").to_string(), "x:1:1: body: there is no body \"a\\nb\"");
    }

    #[test]
    fn slips_are_guessed() {
        let keys = ["position", "rotation", "rotation_deg", "velocity", "density"];
        assert_eq!(closest("positoin", keys).as_deref(), Some("position"));
        assert_eq!(closest("Velocity", keys).as_deref(), Some("velocity"));
        assert_eq!(closest("banana", keys), None);
    }
}
