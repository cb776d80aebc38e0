//! `jounce check`: are these scenes right, and where not?

use crate::args::CheckArgs;
use crate::error::{Done, Failure};
use crate::output::{complain, print, print_json};
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

#[derive(Serialize)]
struct Fault {
    message: String,
    line: Option<u64>,
    column: Option<u64>,
    key: Option<String>,
    expected: Option<String>,
    suggestion: Option<String>,
}

pub fn check(a: &CheckArgs) -> Done {
    let options = load_options(&a.common);
    let mut files = Vec::new();
    let mut text = String::new();
    for path in &a.files {
        let file = path.display().to_string();
        let mut report = FileReport { file: file.clone(), ok: true, skipped: None, error: None };
        match Scene::load(path, &options) {
            Ok(_) => text += &format!("{file}: ok\n"),
            Err(SceneError::Skipped(why)) => {
                text += &format!("{file}: ok as far as it goes; {why}\n");
                report.skipped = Some(why);
            }
            Err(e) => {
                if let Failure::Bad(message) = Failure::scene(path, &e) {
                    complain(&message);
                }
                report.ok = false;
                report.error = Some(fault(&e));
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

fn fault(e: &SceneError) -> Fault {
    let f = e.fault();
    let text = |s: &String| (!s.is_empty()).then(|| s.clone());
    let position = f.and_then(|f| f.position);
    Fault {
        message: f.map_or_else(|| e.to_string(), |f| f.message.clone()),
        line: position.map(|p| p.line as u64),
        column: position.map(|p| p.column as u64),
        key: f.and_then(|f| text(&f.key)),
        expected: f.and_then(|f| text(&f.expected)),
        suggestion: f.and_then(|f| f.suggestion.clone()),
    }
}
