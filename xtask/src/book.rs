//! The course book: runs every command of its chapters, fills in the tables of laws, and builds the pages.
//!
//! A chapter is Markdown under `docs/book/src`. Its ```sh blocks hold the commands that made its pictures; each line that
//! begins with `cargo run --release -- ` or `jounce ` is run from the root. A line `{{verify TOPIC}}` becomes the table of
//! that topic's laws, and `{{run SCENE}}` that of the scene's expectations, as they come out now. Nothing generated is
//! committed.

use crate::program::{build, last_line, run_scene, start};
use crate::{Note, Outcome, cargo, root, run};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Chapters as they are written.
const SOURCE: &str = "docs/book/src";
/// Where the commands of the chapters put pictures.
const PICTURES: &str = "docs/book/src/pictures";
/// The book as mdBook reads it: chapters with their tables, and the pictures.
const FILLED: &str = "target/book-src";
/// The finished pages.
const PAGES: &str = "target/book";

/// Builds the book; fails where a command fails, a picture is missing or a table is empty.
pub fn book() -> Outcome {
    let program = build("release")?;
    fresh(PICTURES)?;
    fresh(&format!("{FILLED}/src"))?;
    let chapters = chapters()?;
    let mut done = BTreeSet::new();
    let mut pictures = 0;
    for (name, text) in &chapters {
        for line in commands(text) {
            if done.insert(line.to_string()) {
                execute(&program, line).map_err(|why| format!("{name}: {line}: {why}"))?;
            }
        }
        for picture in links(text) {
            let path = root().join(SOURCE).join(picture);
            if !std::fs::metadata(&path).is_ok_and(|m| m.len() > 0) {
                return Err(format!("{name}: {picture}: no command of the book made it"));
            }
            pictures += 1;
        }
        let filled = fill(text, &mut |ask, of| match ask {
            Ask::Verify => laws(&program, of),
            Ask::Run => expectations(&program, of),
        })
        .map_err(|e| format!("{name}: {e}"))?;
        write(&root().join(FILLED).join("src").join(name), &filled)?;
    }
    copy_folder(PICTURES, &format!("{FILLED}/src/pictures"))?;
    let settings = root().join("docs/book/book.toml");
    let text = std::fs::read_to_string(&settings).map_err(|e| format!("{}: {e}", settings.display()))?;
    write(&root().join(FILLED).join("book.toml"), &text)?;
    pages()?;
    Ok(Note::Passed(format!(
        "{} chapters, {} commands, {pictures} pictures: {PAGES}/index.html",
        chapters.len() - 1,
        done.len()
    )))
}

/// Runs mdBook, which is a workspace of its own: no dependency of the project.
fn pages() -> Result<(), String> {
    let target = root().join("target/book-builder");
    let manifest = "docs/book/builder/Cargo.toml";
    run(cargo(&["build", "--quiet", "--release", "--locked", "--manifest-path", manifest])
        .env("CARGO_TARGET_DIR", &target))?;
    let builder = target.join("release").join(format!("jounce_book{}", std::env::consts::EXE_SUFFIX));
    let (output, _) = start(&builder, &[FILLED])?;
    if !output.status.success() {
        return Err(format!("mdBook: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    let index = root().join(PAGES).join("index.html");
    if index.exists() { Ok(()) } else { Err(format!("mdBook wrote no {}", index.display())) }
}

/// Name and text of every page, sorted; each is in the table of contents.
fn chapters() -> Result<Vec<(String, String)>, String> {
    let folder = root().join(SOURCE);
    let mut found = Vec::new();
    for entry in std::fs::read_dir(&folder).map_err(|e| format!("{SOURCE}: {e}"))? {
        let name = entry.map_err(|e| format!("{SOURCE}: {e}"))?.file_name().to_string_lossy().into_owned();
        if name.ends_with(".md") {
            let text = std::fs::read_to_string(folder.join(&name)).map_err(|e| format!("{name}: {e}"))?;
            found.push((name, text));
        }
    }
    found.sort();
    let contents = found.iter().find(|(name, _)| name == "SUMMARY.md").ok_or("no SUMMARY.md")?.1.clone();
    match found.iter().find(|(name, _)| name != "SUMMARY.md" && !contents.contains(&format!("({name})"))) {
        Some((name, _)) => Err(format!("{name}: not in SUMMARY.md")),
        None => Ok(found),
    }
}

/// Words after the program's name, of every command line in a ```sh block.
fn commands(text: &str) -> Vec<&str> {
    let mut shell = false;
    let mut found = Vec::new();
    for line in text.lines() {
        if let Some(language) = line.strip_prefix("```") {
            shell = !shell && language.trim() == "sh";
        } else if shell {
            let words = line.strip_prefix("cargo run --release -- ").or_else(|| line.strip_prefix("jounce "));
            found.extend(words.map(|w| w.split(" #").next().unwrap_or(w).trim()));
        }
    }
    found
}

/// Splits at blanks outside double quotes.
fn words(line: &str) -> Vec<String> {
    let mut all = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ' ' if !quoted => all.push(String::new()),
            _ => all.last_mut().expect("never empty").push(c),
        }
    }
    all.retain(|w| !w.is_empty());
    all
}

fn execute(program: &Path, line: &str) -> Result<(), String> {
    let words = words(line);
    let (output, time) = start(program, &words.iter().map(String::as_str).collect::<Vec<_>>())?;
    eprintln!("  {:>5.1} s  jounce {line}", time.as_secs_f64());
    if output.status.success() {
        Ok(())
    } else {
        Err(format!("{}: {}", output.status, last_line(&output.stderr)))
    }
}

/// Pictures that a page shows.
fn links(text: &str) -> Vec<&str> {
    let ends = text.split("](pictures/").skip(1).filter_map(|rest| rest.split(')').next());
    ends.map(|name| {
        let at = name.as_ptr() as usize - text.as_ptr() as usize;
        &text[at - "pictures/".len()..at + name.len()]
    })
    .collect()
}

/// What a table is made of.
#[derive(Clone, Copy)]
enum Ask {
    Verify,
    Run,
}

/// The text with its `{{verify TOPIC}}` and `{{run SCENE}}` lines replaced.
fn fill(text: &str, table: &mut dyn FnMut(Ask, &str) -> Result<String, String>) -> Result<String, String> {
    let mut filled = String::new();
    for line in text.lines() {
        let asked = line.strip_prefix("{{").and_then(|rest| rest.strip_suffix("}}"));
        match asked.and_then(|words| words.split_once(' ')) {
            Some(("verify", topic)) => filled += &table(Ask::Verify, topic)?,
            Some(("run", scene)) => filled += &table(Ask::Run, scene)?,
            _ if asked.is_some() => {
                return Err(format!("{line}: expected {{{{verify TOPIC}}}} or {{{{run SCENE}}}}"));
            }
            _ => filled += line,
        }
        filled.push('\n');
    }
    Ok(filled)
}

/// The expectations of a scene as a Markdown table.
fn expectations(program: &Path, scene: &str) -> Result<String, String> {
    let (value, _) = run_scene(program, scene, "1")?;
    let rows = value["expectations"].as_array().map(Vec::as_slice).unwrap_or_default();
    if rows.is_empty() {
        return Err(format!("{scene}: expects nothing"));
    }
    let mut text = format!(
        "`jounce run {scene}`:\n\n| expectation | at | expected | got | tolerance | holds |\n|---|---:|---:|---:|---:|---|\n"
    );
    for row in rows {
        let name = row["name"].as_str().unwrap_or("").replace('|', "\\|");
        // A number with its tolerance, or a range in words that has none.
        let range = row["expected"].as_str();
        let expected = range.map_or_else(|| shown(row["expected"].as_f64()), Into::into);
        let tolerance = if range.is_some() { "–".into() } else { shown(row["tolerance"].as_f64()) };
        let (at, got) = (shown(row["at"].as_f64()), shown(row["got"].as_f64()));
        let holds = if row["pass"] == true { "yes" } else { "**no**" };
        text += &format!("| {name} | {at} s | {expected} | {got} | {tolerance} | {holds} |\n");
    }
    Ok(text)
}

/// The laws of one topic as a Markdown table. A law that misses is shown as missing.
fn laws(program: &Path, topic: &str) -> Result<String, String> {
    let (output, _) = start(program, &["verify", topic, "--json"])?;
    let value: Value =
        serde_json::from_slice(&output.stdout).map_err(|e| format!("verify {topic}: no JSON: {e}"))?;
    let all = value["rows"].as_array().map(Vec::as_slice).unwrap_or_default();
    let rows: Vec<&Value> = all.iter().filter(|row| row["topic"] == topic).collect();
    if rows.is_empty() {
        return Err(format!("verify {topic}: no rows of that topic"));
    }
    let mut text = format!(
        "`jounce verify \"{topic}\"`:\n\n| law | expected | got | tolerance | unit | holds |\n|---|---:|---:|---:|---|---|\n"
    );
    for row in rows {
        let name = row["name"].as_str().unwrap_or("").replace('|', "\\|");
        let number = |key: &str| shown(row[key].as_f64());
        let holds = if row["pass"] == true { "yes" } else { "**no**" };
        let unit = row["unit"].as_str().unwrap_or("");
        text += &format!(
            "| {name} | {} | {} | {} | {unit} | {holds} |\n",
            number("expected"),
            number("got"),
            number("tolerance")
        );
    }
    Ok(text)
}

/// Seven significant digits, without trailing zeros.
fn shown(number: Option<f64>) -> String {
    let Some(x) = number else { return "–".into() };
    if x == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e7).contains(&x.abs()) {
        return format!("{x:.2e}");
    }
    let before = x.abs().log10().floor() as i32 + 1;
    let text = format!("{x:.*}", (7 - before).clamp(0, 9) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// An empty folder in the checkout.
fn fresh(folder: &str) -> Result<(), String> {
    let path = root().join(folder);
    // Absent is as good as removed.
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).map_err(|e| format!("{folder}: {e}"))
}

fn write(path: &PathBuf, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}

fn copy_folder(from: &str, to: &str) -> Result<(), String> {
    fresh(to)?;
    for entry in std::fs::read_dir(root().join(from)).map_err(|e| format!("{from}: {e}"))? {
        let entry = entry.map_err(|e| format!("{from}: {e}"))?;
        let target = root().join(to).join(entry.file_name());
        std::fs::copy(entry.path(), &target).map_err(|e| format!("{}: {e}", target.display()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "# A\n\n```sh\ncargo run --release -- render a.json -o x.png\nls\njounce solve projectile # why\n```\n\n\
        ```rust\njounce no\n```\n![a](pictures/x.png) and [b](pictures/y.svg)\n\n{{verify a b}}\n{{run s.json}}\n";

    #[test]
    fn only_lines_of_shell_blocks_are_commands() {
        assert_eq!(commands(PAGE), ["render a.json -o x.png", "solve projectile"]);
        assert_eq!(words("plot  --y \"a b\",c"), ["plot", "--y", "a b,c"]);
    }

    #[test]
    fn pictures_and_tables_are_found() {
        assert_eq!(links(PAGE), ["pictures/x.png", "pictures/y.svg"]);
        let mut echo = |ask, of: &str| {
            Ok(if matches!(ask, Ask::Run) { format!("run <{of}>") } else { format!("<{of}>") })
        };
        let filled = fill(PAGE, &mut echo).expect("it fills");
        assert!(
            filled.contains("\n<a b>\n") && filled.contains("\nrun <s.json>\n") && !filled.contains("{{")
        );
        assert!(fill(PAGE, &mut |_, _| Err("no rows".into())).is_err());
        assert!(fill("{{plot a}}", &mut echo).is_err());
    }

    /// What stands in backquotes in a cell of a table.
    fn quoted(cell: &str) -> impl Iterator<Item = &str> {
        cell.split('`').skip(1).step_by(2)
    }

    #[test]
    fn the_list_of_slides_names_scenes_and_pages_that_are_there() {
        let text = std::fs::read_to_string(root().join(SOURCE).join("slides.md")).expect("the list");
        let mut slides = 0;
        for line in text.lines().filter(|l| l.starts_with("| ") && !l.starts_with("| slide")) {
            let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
            let page =
                |link: &str| link.split(')').next().map(|name| root().join(SOURCE).join(name).exists());
            let links = line.split("](").skip(1).filter_map(page);
            assert!(links.into_iter().all(|there| there), "{line}");
            let [.., scenes, _] = cells[..] else { continue };
            let scenes = if cells.len() == 6 { scenes } else { cells[1] };
            for name in quoted(scenes) {
                let path =
                    if name.contains('/') { name.into() } else { format!("scenes/course/{name}.json") };
                assert!(root().join(&path).exists(), "{path}: {line}");
            }
            slides += usize::from(cells.len() == 6);
        }
        assert!(slides >= 49, "{slides} slides");
    }

    #[test]
    fn numbers_are_short() {
        let short = |x| shown(Some(x));
        assert_eq!(
            (short(91.743_119_3), short(-0.5), short(1e-9)),
            ("91.74312".into(), "-0.5".into(), "1.00e-9".into())
        );
        assert_eq!((short(550.0), shown(None)), ("550".into(), "–".into()));
    }
}
