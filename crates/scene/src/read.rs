//! From text to [`SceneSpec`], with every error at its place.

use crate::error::{Checked, Fault, SceneError, Wrong, closest};
use crate::json::{KeyPath, Position, Segment, scan};
use crate::limits;
use crate::spec::SceneSpec;
use serde_json::Value;
use serde_path_to_error::Segment as Serde;

/// Reads a scene file's text.
pub(crate) fn read(file: &str, text: &str) -> Result<SceneSpec, SceneError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.len() > limits::SCENE_BYTES_MAX {
        let message =
            format!("the file has {} bytes; expected at most {}", text.len(), limits::SCENE_BYTES_MAX);
        return Err(SceneError::File { file: file.into(), message });
    }
    scan(text).map_err(|r| {
        SceneError::Fault(Box::new(Fault {
            file: file.into(),
            position: Some(Position::of(text, r.offset)),
            key: r.path.to_string(),
            message: r.message,
            expected: r.expected,
            suggestion: None,
        }))
    })?;
    parse(text).map_err(|w| w.locate(file, text))
}

fn parse(text: &str) -> Checked<SceneSpec> {
    let mut json = serde_json::Deserializer::from_str(text);
    let spec: SceneSpec = serde_path_to_error::deserialize(&mut json).map_err(|e| explain(&e))?;
    if spec.jounce != 1 {
        return Err(Wrong::new(format!("version {}", spec.jounce), "1").key("jounce"));
    }
    Ok(spec)
}

/// Serde's message in the words of the scene file.
fn explain(e: &serde_path_to_error::Error<serde_json::Error>) -> Wrong {
    let path = KeyPath(
        e.path()
            .iter()
            .filter_map(|s| match s {
                Serde::Seq { index } => Some(Segment::Index(*index)),
                Serde::Map { key } => Some(Segment::Key(key.clone())),
                Serde::Enum { .. } | Serde::Unknown => None,
            })
            .collect(),
    );
    let whole = e.inner().to_string();
    let message = whole.rsplit_once(" at line ").map_or(whole.as_str(), |(m, _)| m);
    let (message, expected) = message.split_once(", expected ").unwrap_or((message, ""));
    let names: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
    if let Some(key) = quoted(message, "unknown field") {
        let mut path = path;
        if !matches!(path.0.last(), Some(Segment::Key(k)) if k == key) {
            path.0.push(Segment::Key(key.into()));
        }
        let expected = format!("one of {}", names.join(", "));
        return Wrong::at(path, "unknown key", expected).suggest(closest(key, names)).of_key();
    }
    if let Some(word) = quoted(message, "unknown variant") {
        let expected = format!("one of {}", quote(&names));
        return Wrong::at(path, format!("\"{word}\" is unknown"), expected).suggest(closest(word, names));
    }
    if let Some(key) = quoted(message, "missing field") {
        let expected = match key {
            "jounce" => "\"jounce\": 1, the version of the format".into(),
            _ => wanted(&path.0, key),
        };
        return Wrong::at(path, format!("the key `{key}` is missing"), expected);
    }
    if message == "trailing characters" {
        // The file is sound JSON by now: it is an array that goes on.
        let expected = found(&path.0).map_or_else(|| "fewer".into(), |n| kind_of(&n));
        return Wrong::at(path, "the array is too long", expected);
    }
    // Serde takes an array for an object's values in turn, and complains of the first of them.
    if let Some(n) = (0..path.0.len()).find(|&n| is_listed(&path.0, n)) {
        let whole = KeyPath(path.0[..n].to_vec());
        let expected = object(&whole.0);
        return Wrong::at(whole, "an array", expected);
    }
    let expected = plain(expected);
    let expected = if expected == "an object" { object(&path.0) } else { expected };
    Wrong::at(path, plain(message), expected)
}

/// Does a path number the values of what is an object?
fn is_listed(path: &[Segment], n: usize) -> bool {
    let object = |f: Value| f["properties"].is_object() && !f["items"].is_object();
    matches!(path[n], Segment::Index(_)) && found_plainly(&path[..n]).is_some_and(object)
}

/// The object that is wanted at a path, with the keys that it must have.
fn object(path: &[Segment]) -> String {
    let found = found_plainly(path).unwrap_or_default();
    let keys: Vec<&str> =
        found["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    match keys[..] {
        [] => "an object".into(),
        [key] => format!("an object with the key `{key}`"),
        _ => format!("an object with the keys `{}`", keys.join("`, `")),
    }
}

/// What the schema says of a key of the object at a path.
fn wanted(path: &[Segment], key: &str) -> String {
    let mut whole: Vec<Segment> = path.to_vec();
    whole.push(Segment::Key(key.into()));
    let Some(found) = found(&whole) else { return format!("\"{key}\": a value") };
    let what = kind_of(&found);
    match found["description"].as_str().and_then(|d| d.lines().next()) {
        Some(d) => format!("{what} ({})", d.trim_end_matches('.')),
        None => what,
    }
}

/// The schema of what is at a path.
fn found(path: &[Segment]) -> Option<Value> {
    let schema = serde_json::to_value(schemars::schema_for!(SceneSpec)).unwrap_or_default();
    walk(&schema, &schema, path).cloned()
}

/// The schema of what is at a path, without the name that it is referred to by, and as if it were given.
fn found_plainly(path: &[Segment]) -> Option<Value> {
    let schema = serde_json::to_value(schemars::schema_for!(SceneSpec)).unwrap_or_default();
    walk(&schema, &schema, path).map(|found| plainly(&schema, found).clone())
}

/// What a schema refers to, or may be beside null.
fn plainly<'a>(root: &'a Value, node: &'a Value) -> &'a Value {
    if let Some(name) = node["$ref"].as_str() {
        let referred = name.strip_prefix('#').and_then(|n| root.pointer(n));
        return referred.map_or(node, |r| plainly(root, r));
    }
    let Some([one, null]) = node["anyOf"].as_array().map(Vec::as_slice) else { return node };
    if null["type"] == "null" { plainly(root, one) } else { node }
}

/// The kind of value that a schema describes.
fn kind_of(found: &Value) -> String {
    let size = |name: &str| found[name].as_u64();
    let type_of = |t: &Value| t.as_str().or_else(|| t[0].as_str()).map(String::from);
    match type_of(&found["type"]).as_deref() {
        Some("number") => "a number".to_string(),
        Some("integer") => "a whole number".into(),
        Some("string") => "a text".into(),
        Some("boolean") => "true or false".into(),
        Some("array") => match size("minItems") {
            Some(n) if size("maxItems") == Some(n) => format!("an array of length {n}"),
            _ => "an array".into(),
        },
        _ => "a value".into(),
    }
}

/// The part of a schema for what is at a path.
fn walk<'a>(root: &'a Value, node: &'a Value, path: &[Segment]) -> Option<&'a Value> {
    let Some((first, rest)) = path.split_first() else { return Some(node) };
    if let Some(name) = node["$ref"].as_str() {
        return walk(root, root.pointer(name.strip_prefix('#')?)?, path);
    }
    let direct = match first {
        Segment::Key(k) => node["properties"].get(k).or(node.get("additionalProperties")),
        Segment::Index(_) => node.get("items"),
    };
    if let Some(found) = direct.and_then(|d| walk(root, d, rest)) {
        return Some(found);
    }
    let choices = ["anyOf", "oneOf", "allOf"].into_iter().filter_map(|k| node[k].as_array()).flatten();
    choices.into_iter().find_map(|c| walk(root, c, path))
}

/// The word in backquotes after a phrase.
fn quoted<'a>(message: &'a str, phrase: &str) -> Option<&'a str> {
    message.strip_prefix(phrase)?.trim_start().strip_prefix('`')?.strip_suffix('`')
}

fn quote(names: &[&str]) -> String {
    names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ")
}

/// Rust's type names in the words of JSON.
fn plain(text: &str) -> String {
    let text = text
        .replace("invalid type: ", "")
        .replace("invalid value: ", "")
        .replace("invalid length ", "an array of length ")
        .replace("floating point", "number")
        .replace("integer", "number")
        .replace("a sequence", "an array")
        .replace("sequence", "an array")
        .replace("a map", "an object")
        .replace("map", "an object")
        .replace("boolean", "true or false:")
        .replace("a boolean", "true or false");
    match text.as_str() {
        "f32" | "f64" => "a number".into(),
        "u32" | "u64" | "usize" | "u128" => "a whole number, 0 or more".into(),
        "i32" | "i64" => "a whole number".into(),
        "true or false:" | "a true or false:" => "true or false".into(),
        t if t.starts_with("struct ") => "an object".into(),
        _ => text,
    }
}
