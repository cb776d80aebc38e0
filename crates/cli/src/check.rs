//! `jounce check`: are these scenes right, and where not?

use crate::args::{CheckArgs, Common};
use crate::error::{Done, Failure};
use crate::output::{clean, complain, print, print_json};
use crate::run::load_options;
use jounce_scene::{Scene, SceneError};
use serde::Serialize;

#[derive(Serialize)]
struct Report {
    files: Vec<FileReport>,
}

#[derive(Serialize)]
struct FileReport {
    file: String,
    ok: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    skipped: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<Fault>,
}

/// What is wrong with a scene, and where, for programs.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Fault {
    message: String,
    line: Option<u64>,
    column: Option<u64>,
    key: Option<String>,
    expected: Option<String>,
    suggestion: Option<String>,
}

pub fn check(a: &CheckArgs) -> Done {
    let options = load_options(&Common { assets: a.assets.clone(), threads: None });
    let mut files = Vec::new();
    let mut text = String::new();
    for path in &a.files {
        let file = clean(&path.display().to_string());
        let mut report = FileReport { file: file.clone(), ok: true, skipped: None, error: None };
        match Scene::load(path, &options) {
            Ok(_) => text += &format!("{file}: ok\n"),
            Err(SceneError::Skipped(why)) => {
                text += &format!("{file}: ok as far as it goes; {why}\n");
                report.skipped = Some(why);
            }
            Err(e) => {
                if let Failure::Bad { message, .. } = Failure::scene(path, &e) {
                    complain(&message);
                }
                report.ok = false;
                report.error = Some(Fault::of(&e));
            }
        }
        files.push(report);
    }
    let wrong = files.iter().filter(|f| !f.ok).count();
    if a.json {
        print_json(&Report { files })?;
    } else {
        print(&text)?;
    }
    match wrong {
        0 => Ok(()),
        n => Err(Failure::bad(format!("{n} of {} scenes refused", a.files.len()))),
    }
}

impl Fault {
    /// A message without a place.
    pub fn plain(message: &str) -> Self {
        Self { message: message.into(), ..Self::default() }
    }
    /// The parts of a scene's error.
    pub fn of(e: &SceneError) -> Self {
        let Some(f) = e.fault() else { return Self::plain(&e.to_string()) };
        let text = |s: &String| (!s.is_empty()).then(|| s.clone());
        Self {
            message: f.message.clone(),
            line: f.position.map(|p| p.line as u64),
            column: f.position.map(|p| p.column as u64),
            key: text(&f.key),
            expected: text(&f.expected),
            suggestion: f.suggestion.clone(),
        }
    }
}
