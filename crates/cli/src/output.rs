//! Standard output and standard error, tables and progress.

use crate::error::{Done, Failure};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::Write;

/// Writes text to standard output.
pub fn print(text: &str) -> Done {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

/// Writes one JSON object and a line end to standard output.
pub fn print_json(value: &impl serde::Serialize) -> Done {
    let text = serde_json::to_string(value).map_err(|e| Failure::bad(format!("cannot write JSON: {e}")))?;
    print(&(text + "\n"))
}

/// Writes a message to standard error; nobody listening is no mistake.
pub fn complain(message: &str) {
    let _ = writeln!(std::io::stderr().lock(), "error: {message}");
}

/// Writes a remark to standard error.
pub fn note(message: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{message}");
}

/// A bar on standard error; invisible where that is no terminal.
pub fn progress(length: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr_with_hz(15));
    let look = "{msg:<10} [{bar:36.cyan/blue}] {pos:>5}/{len} {elapsed_precise} (left {eta})";
    if let Ok(style) = ProgressStyle::with_template(look) {
        bar.set_style(style.progress_chars("━╸─"));
    }
    bar.set_message(what.to_string());
    bar
}

/// Columns of text: the first to the left, the others to the right, unless `left` names them.
#[derive(Default)]
pub struct Table {
    rows: Vec<Vec<String>>,
    left: Vec<usize>,
}

impl Table {
    /// A table with a head.
    pub fn new<const N: usize>(head: [&str; N]) -> Self {
        Self { rows: vec![head.map(String::from).to_vec()], left: vec![0] }
    }
    /// Sets a column to the left.
    pub fn left(mut self, column: usize) -> Self {
        self.left.push(column);
        self
    }
    /// Adds a row.
    pub fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.rows.push(cells.to_vec());
    }
    /// The lines.
    pub fn text(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let length = |c: usize| {
            self.rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(length).collect();
        let mut out = String::new();
        for (i, row) in self.rows.iter().enumerate() {
            let cells = row.iter().enumerate().map(|(c, cell)| {
                let gap = " ".repeat(widths[c] - cell.chars().count());
                if self.left.contains(&c) { format!("{cell}{gap}") } else { format!("{gap}{cell}") }
            });
            let line = cells.collect::<Vec<_>>().join("  ");
            out.push_str(line.trim_end());
            out.push('\n');
            if i == 0 {
                let rules: Vec<String> = widths.iter().map(|w| "─".repeat(*w)).collect();
                out.push_str(&rules.join("  "));
                out.push('\n');
            }
        }
        out
    }
}

/// A number with about five significant digits.
pub fn number(v: f64) -> String {
    let a = v.abs();
    if v == 0.0 {
        "0".into()
    } else if !v.is_finite() {
        v.to_string()
    } else if !(1e-4..1e7).contains(&a) {
        format!("{v:.4e}")
    } else {
        let digits = (5 - 1 - a.log10().floor() as i32).clamp(0, 8) as usize;
        let text = format!("{v:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_true() {
        for (v, text) in [(0.0, "0"), (9.81, "9.81"), (-91.743_12, "-91.743"), (1.0 / 3.0, "0.33333")] {
            assert_eq!(number(v), text);
        }
        assert_eq!(number(1.25e-9), "1.2500e-9");
        assert_eq!(number(123_456.7), "123457");
        assert_eq!(number(f64::NAN), "NaN");
    }

    #[test]
    fn tables_align() {
        let mut t = Table::new(["name", "value"]);
        t.row(["a".into(), "10".into()]);
        t.row(["longer".into(), "5".into()]);
        assert_eq!(t.text(), "name    value\n──────  ─────\na          10\nlonger      5\n");
    }
}
