//! Positions in JSON text: a check of the grammar that knows line, column and key of what it refuses, and the
//! way back from a key path to its line and column.
//!
//! [`scan`] runs before serde sees a byte, so that depth, sizes, duplicates and non-finite numbers are refused
//! with bounded memory. [`locate`] walks the text again, and only when there is something to tell: no table of
//! positions is kept.

use crate::limits;
use std::borrow::Cow;
use std::fmt;

/// One step of a [`KeyPath`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Segment {
    /// Member of an object.
    Key(String),
    /// Element of an array.
    Index(usize),
}

/// Where in a JSON document: `bodies[3].shapes[0].box.half`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KeyPath(pub Vec<Segment>);

impl fmt::Display for KeyPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return f.write_str("(top level)");
        }
        for (n, s) in self.0.iter().enumerate() {
            match s {
                Segment::Key(k) if n == 0 => write!(f, "{k}")?,
                Segment::Key(k) => write!(f, ".{k}")?,
                Segment::Index(i) => write!(f, "[{i}]")?,
            }
        }
        Ok(())
    }
}

/// A place in a text, both from 1; columns count characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

impl Position {
    /// Of a byte offset.
    pub(crate) fn of(text: &str, offset: usize) -> Self {
        let end = offset.min(text.len());
        let before = &text.as_bytes()[..end];
        let line = 1 + before.iter().filter(|&&b| b == b'\n').count();
        let start = before.iter().rposition(|&b| b == b'\n').map_or(0, |n| n + 1);
        // Continuation bytes of UTF-8 are not characters.
        let column = 1 + before[start..].iter().filter(|&&b| b & 0xC0 != 0x80).count();
        Self { line, column }
    }
}

/// What [`scan`] refuses.
#[derive(Clone, Debug)]
pub(crate) struct Refusal {
    pub offset: usize,
    pub path: KeyPath,
    pub message: String,
    pub expected: String,
}

/// What a document may hold.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    /// Objects.
    pub objects: usize,
    /// Bytes of one string.
    pub string: usize,
}

/// Checks that `text` is one JSON value within the limits of scenes, without duplicate keys and with finite numbers.
pub(crate) fn scan(text: &str) -> Result<(), Box<Refusal>> {
    scan_within(text, Budget { objects: limits::JSON_OBJECTS_MAX, string: limits::JSON_STRING_MAX })
}

/// As [`scan`], within other limits.
pub(crate) fn scan_within(text: &str, budget: Budget) -> Result<(), Box<Refusal>> {
    let mut s = Scanner { text, at: 0, path: Vec::new(), objects: 0, values: 0, budget };
    s.space();
    s.value()?;
    s.space();
    if s.at < text.len() {
        return s.fail(s.at, s.seen(), "the end of the file");
    }
    Ok(())
}

struct Scanner<'a> {
    text: &'a str,
    at: usize,
    path: Vec<Step<'a>>,
    objects: usize,
    values: usize,
    budget: Budget,
}

enum Step<'a> {
    Key(Cow<'a, str>),
    Index(usize),
}

type Scan<T = ()> = Result<T, Box<Refusal>>;

impl<'a> Scanner<'a> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn space(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    fn fail<T>(&self, offset: usize, message: impl Into<String>, expected: impl Into<String>) -> Scan<T> {
        let path = self.path.iter().map(|s| match s {
            Step::Key(k) => Segment::Key(k.clone().into_owned()),
            Step::Index(i) => Segment::Index(*i),
        });
        Err(Box::new(Refusal {
            offset,
            path: KeyPath(path.collect()),
            message: message.into(),
            expected: expected.into(),
        }))
    }

    /// The next word or character, for messages.
    fn seen(&self) -> String {
        let rest = &self.text[self.at..];
        let Some(first) = rest.chars().next() else { return "the file ends here".into() };
        if rest.starts_with("//") || rest.starts_with("/*") || first == '#' {
            return "comments are not part of JSON".into();
        }
        let word: String =
            rest.chars().take_while(|c| c.is_alphanumeric() || "_-+.".contains(*c)).take(24).collect();
        let word = if word.is_empty() { first.escape_debug().to_string() } else { word };
        format!("found `{word}`")
    }

    fn value(&mut self) -> Scan {
        self.values += 1;
        if self.values > limits::JSON_VALUES_MAX {
            return self.fail(self.at, "too many values", format!("at most {}", limits::JSON_VALUES_MAX));
        }
        match self.peek() {
            Some(b'{') => self.object(),
            Some(b'[') => self.array(),
            Some(b'"') => self.string().map(|_| ()),
            Some(b'-' | b'0'..=b'9') => self.number(),
            _ => self.literal(),
        }
    }

    fn literal(&mut self) -> Scan {
        let rest = &self.text[self.at..];
        let whole = |w: &str| {
            rest.strip_prefix(w).is_some_and(|r| !r.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
        };
        for word in ["true", "false", "null"] {
            if whole(word) {
                self.at += word.len();
                return Ok(());
            }
        }
        if ["NaN", "nan", "Infinity", "inf", "+"].iter().any(|w| rest.starts_with(w)) {
            return self.fail(self.at, self.seen(), "a finite number");
        }
        if rest.starts_with('\'') {
            return self.fail(self.at, self.seen(), "strings in double quotes");
        }
        if rest.starts_with(']') || rest.starts_with('}') {
            return self.fail(self.at, self.seen(), "a value (no comma before a closing bracket)");
        }
        self.fail(self.at, self.seen(), "a value")
    }

    fn number(&mut self) -> Scan {
        let start = self.at;
        let digits = |s: &mut Self| {
            let from = s.at;
            while matches!(s.peek(), Some(b'0'..=b'9')) {
                s.at += 1;
            }
            s.at > from
        };
        if self.peek() == Some(b'-') {
            self.at += 1;
        }
        let zero = self.peek() == Some(b'0');
        let whole = self.at;
        let mut ok = digits(self) && !(zero && self.at - whole > 1);
        if self.peek() == Some(b'.') {
            self.at += 1;
            ok &= digits(self);
        }
        if matches!(self.peek(), Some(b'e' | b'E')) {
            self.at += 1;
            if matches!(self.peek(), Some(b'-' | b'+')) {
                self.at += 1;
            }
            ok &= digits(self);
        }
        ok &= !self.peek().is_some_and(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'.');
        let token = &self.text[start..self.at];
        if !ok || token.len() > 512 {
            self.at = start;
            return self.fail(start, self.seen(), "a number such as 12, -0.5 or 1e-3");
        }
        // Beyond single precision nothing in a scene has a meaning, and conversions would make infinities.
        match token.parse::<f64>() {
            Ok(x) if x.abs() <= f64::from(f32::MAX) => Ok(()),
            _ => self.fail(start, format!("{token} is out of range"), "a number within ±3.4e38"),
        }
    }

    fn string(&mut self) -> Scan<Cow<'a, str>> {
        let start = self.at;
        self.at += 1;
        loop {
            match self.peek() {
                None => return self.fail(start, "the string does not end", "a closing `\"`"),
                Some(b'"') => break,
                Some(b'\\') => self.at += 2,
                Some(0..=0x1F) => {
                    return self.fail(
                        self.at,
                        "a line break or control character inside a string",
                        "a closing `\"`",
                    );
                }
                Some(_) => self.at += 1,
            }
        }
        let body = &self.text[start + 1..self.at];
        self.at += 1;
        if body.len() > self.budget.string {
            let limit = format!("at most {} bytes", self.budget.string);
            return self.fail(start, format!("a string of {} bytes", body.len()), limit);
        }
        if !body.contains('\\') {
            return Ok(Cow::Borrowed(body));
        }
        match serde_json::from_str::<String>(&self.text[start..self.at]) {
            Ok(s) => Ok(Cow::Owned(s)),
            Err(_) => {
                self.fail(start, "a bad escape in a string", "\\\" \\\\ \\/ \\b \\f \\n \\r \\t or \\uXXXX")
            }
        }
    }

    fn deeper(&self) -> Scan {
        if self.path.len() >= limits::JSON_DEPTH_MAX {
            let limit = format!("at most {} levels", limits::JSON_DEPTH_MAX);
            return self.fail(self.at, "nested too deeply", limit);
        }
        Ok(())
    }

    fn array(&mut self) -> Scan {
        self.deeper()?;
        self.at += 1;
        self.space();
        if self.peek() == Some(b']') {
            self.at += 1;
            return Ok(());
        }
        for i in 0.. {
            self.path.push(Step::Index(i));
            self.space();
            self.value()?;
            self.path.pop();
            self.space();
            match self.peek() {
                Some(b',') => self.at += 1,
                Some(b']') => break,
                _ => return self.fail(self.at, self.seen(), "`,` or `]`"),
            }
        }
        self.at += 1;
        Ok(())
    }

    fn object(&mut self) -> Scan {
        self.deeper()?;
        self.objects += 1;
        if self.objects > self.budget.objects {
            let limit = format!("at most {}", self.budget.objects);
            return self.fail(self.at, "too many objects", limit);
        }
        self.at += 1;
        self.space();
        if self.peek() == Some(b'}') {
            self.at += 1;
            return Ok(());
        }
        let mut keys: Vec<(Cow<'a, str>, usize)> = Vec::new();
        loop {
            self.space();
            let key_at = self.at;
            if self.peek() != Some(b'"') {
                let expected = if self.peek() == Some(b'}') {
                    "a key (no comma before `}`)"
                } else {
                    "a key in double quotes"
                };
                return self.fail(key_at, self.seen(), expected);
            }
            let key = self.string()?;
            self.path.push(Step::Key(key.clone()));
            keys.push((key, key_at));
            self.space();
            if self.peek() != Some(b':') {
                return self.fail(self.at, self.seen(), "`:` after the key");
            }
            self.at += 1;
            self.space();
            self.value()?;
            self.path.pop();
            self.space();
            match self.peek() {
                Some(b',') => self.at += 1,
                Some(b'}') => break,
                _ => return self.fail(self.at, self.seen(), "`,` or `}`"),
            }
        }
        self.at += 1;
        self.no_duplicates(keys)
    }

    fn no_duplicates(&mut self, mut keys: Vec<(Cow<'a, str>, usize)>) -> Scan {
        keys.sort_unstable();
        let twice = keys.windows(2).filter(|w| w[0].0 == w[1].0).map(|w| &w[1]).min_by_key(|k| k.1);
        if let Some((key, at)) = twice {
            let (key, at) = (key.clone(), *at);
            self.path.push(Step::Key(key));
            return self.fail(at, "the key is given twice", "each key once");
        }
        Ok(())
    }
}

/// Position of the value at `path` (or of its key), in text that [`scan`] accepted. Where the path leaves the
/// document, the position of the deepest value on the way.
pub(crate) fn locate(text: &str, path: &KeyPath, of_key: bool) -> Position {
    let mut w = Walker { bytes: text.as_bytes(), at: 0 };
    w.space();
    let mut best = w.at;
    for (n, segment) in path.0.iter().enumerate() {
        let last = n + 1 == path.0.len();
        let Some((key_at, value_at)) = w.enter(text, segment) else { break };
        best = if last && of_key { key_at } else { value_at };
        w.at = value_at;
    }
    Position::of(text, best)
}

struct Walker<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Walker<'_> {
    fn peek(&self) -> u8 {
        self.bytes.get(self.at).copied().unwrap_or(0)
    }

    fn space(&mut self) {
        while matches!(self.peek(), b' ' | b'\t' | b'\n' | b'\r') {
            self.at += 1;
        }
    }

    fn string(&mut self) {
        self.at += 1;
        while !matches!(self.peek(), b'"' | 0) {
            self.at += if self.peek() == b'\\' { 2 } else { 1 };
        }
        self.at += 1;
    }

    fn skip(&mut self) {
        let mut depth = 0usize;
        while self.at < self.bytes.len() {
            match self.peek() {
                b'"' => {
                    self.string();
                    if depth == 0 {
                        return;
                    }
                    continue;
                }
                b'{' | b'[' => depth += 1,
                b'}' | b']' if depth == 0 => return,
                b'}' | b']' => {
                    depth -= 1;
                    if depth == 0 {
                        self.at += 1;
                        return;
                    }
                }
                b',' if depth == 0 => return,
                _ => {}
            }
            self.at += 1;
        }
    }

    /// Offsets of the key (or element) and of the value of one member.
    fn enter(&mut self, text: &str, segment: &Segment) -> Option<(usize, usize)> {
        let object = match (self.peek(), segment) {
            (b'{', Segment::Key(_)) => true,
            (b'[', Segment::Index(_)) => false,
            _ => return None,
        };
        self.at += 1;
        for i in 0.. {
            self.space();
            if matches!(self.peek(), b'}' | b']' | 0) {
                return None;
            }
            let key_at = self.at;
            let mut found = matches!(segment, Segment::Index(n) if *n == i);
            if object {
                self.string();
                let raw = text.get(key_at..self.at)?;
                found = matches!(segment, Segment::Key(k) if serde_json::from_str::<String>(raw).is_ok_and(|r| r == *k));
                self.space();
                self.at += 1;
                self.space();
            }
            if found {
                return Some((key_at, self.at));
            }
            self.skip();
            self.space();
            if self.peek() == b',' {
                self.at += 1;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(keys: &[&str]) -> KeyPath {
        let segment = |k: &&str| k.parse().map_or_else(|_| Segment::Key((*k).into()), Segment::Index);
        KeyPath(keys.iter().map(segment).collect())
    }

    #[test]
    fn positions_are_found_again() {
        let text = "{\n  \"a\": [1, {\"b\\u0063\": \"x,]}\\\"\",\n   \"d\": 2}],\n \"é\": {}, \"z\": 3}";
        assert!(scan(text).is_ok());
        let at = |keys: &[&str], key| {
            let p = locate(text, &path(keys), key);
            (p.line, p.column)
        };
        assert_eq!(at(&["a", "0"], false), (2, 9));
        assert_eq!(at(&["a", "1", "bc"], true), (2, 13));
        assert_eq!(at(&["a", "1", "d"], false), (3, 9));
        assert_eq!(at(&["z"], true), (4, 11));
        assert_eq!(at(&["z", "nothing"], false), (4, 16));
        assert_eq!(at(&["a", "7"], false), (2, 8));
    }

    #[test]
    fn scan_refuses_with_the_place() {
        let refused = |text: &str| {
            let r = scan(text).expect_err(text);
            let p = Position::of(text, r.offset);
            (p.line, p.column, r.path.to_string())
        };
        assert_eq!(refused("{\"a\": NaN}"), (1, 7, "a".into()));
        assert_eq!(refused("{\"a\": [1,\n 1e999]}"), (2, 2, "a[1]".into()));
        assert_eq!(refused("{\"a\": 1,\n \"a\": 2}"), (2, 2, "a".into()));
        assert_eq!(refused("[1, 2,]"), (1, 7, "[2]".into()));
        assert_eq!(refused("[01]"), (1, 2, "[0]".into()));
        assert_eq!(refused("[1] x"), (1, 5, "(top level)".into()));
        assert_eq!(refused("{\"a\" 1}").1, 6);
        assert_eq!(refused("\"abc").1, 1);
        assert_eq!(refused("").1, 1);
        assert_eq!(refused(&"[".repeat(100_000)).1, limits::JSON_DEPTH_MAX + 1);
        assert!(scan("[\"\\ud800\"]").is_err());
        assert!(scan(" [0, -0.5, 1e-3, true, null, {}] ").is_ok());
    }
}
