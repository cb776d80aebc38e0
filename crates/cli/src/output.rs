//! Standard output and standard error, tables and progress.

use crate::error::{Done, Failure};
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
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

/// Text of a file as a terminal may see it: what would move the cursor, change colours or turn the reading direction is
/// written out.
pub fn clean(text: &str) -> String {
    let turns = |c: char| matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}');
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() || turns(c) { out.extend(c.escape_default()) } else { out.push(c) }
    }
    out
}

/// Writes a message to standard error; nobody listening is no mistake.
pub fn complain(message: &str) {
    let lines: Vec<String> = message.split('\n').map(clean).collect();
    let _ = writeln!(std::io::stderr().lock(), "error: {}", lines.join("\n"));
}

/// Writes a remark of one line to standard error.
pub fn note(message: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", clean(message));
}

/// A bar on standard error; invisible where that is no terminal.
pub fn progress(length: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr_with_hz(15));
    let look = "{msg:<10} [{bar:36.cyan/blue}] {pos:>5}/{len} {elapsed_precise} (left {left})";
    if let Ok(style) = ProgressStyle::with_template(look) {
        let left = |s: &ProgressState, w: &mut dyn std::fmt::Write| {
            // Before the first step nothing is known of how long one takes.
            let _ = if s.pos() == 0 { w.write_str("?") } else { write!(w, "{:#}", HumanDuration(s.eta())) };
        };
        bar.set_style(style.with_key("left", left).progress_chars("━╸─"));
    }
    bar.set_message(what.to_string());
    // The clock goes on within a step that takes long.
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
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
        Self { rows: vec![head.map(clean).to_vec()], left: vec![0] }
    }
    /// Sets a column to the left.
    pub fn left(mut self, column: usize) -> Self {
        self.left.push(column);
        self
    }
    /// Adds a row.
    pub fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.rows.push(cells.map(|c| clean(&c)).to_vec());
    }
    /// Characters of the widest cell of each column.
    fn widths(&self) -> Vec<usize> {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let length = |c: usize| {
            self.rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0)
        };
        (0..columns).map(length).collect()
    }
    /// The cells of a row, filled up to the widths of their columns.
    fn filled(&self, row: &[String], widths: &[usize]) -> Vec<String> {
        let fill = |(c, cell): (usize, &String)| {
            let gap = " ".repeat(widths[c] - cell.chars().count());
            if self.left.contains(&c) { format!("{cell}{gap}") } else { format!("{gap}{cell}") }
        };
        row.iter().enumerate().map(fill).collect()
    }
    /// The lines as a Markdown table.
    pub fn markdown(&self) -> String {
        let widths = self.widths();
        let rule = |(c, w): (usize, &usize)| {
            let dashes = "-".repeat(w + 1);
            if self.left.contains(&c) { format!(":{dashes}") } else { format!("{dashes}:") }
        };
        let rules: Vec<String> = widths.iter().enumerate().map(rule).collect();
        let mut lines: Vec<String> =
            self.rows.iter().map(|row| format!("| {} |\n", self.filled(row, &widths).join(" | "))).collect();
        lines.insert(1, format!("|{}|\n", rules.join("|")));
        lines.concat()
    }
    /// The lines.
    pub fn text(&self) -> String {
        let widths = self.widths();
        let mut out = String::new();
        for (i, row) in self.rows.iter().enumerate() {
            let line = self.filled(row, &widths).join("  ");
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
    fn names_reach_the_terminal_tame() {
        assert_eq!(clean("a\nb\x1b[31m\u{202e}c é – µ"), "a\\nb\\u{1b}[31m\\u{202e}c é – µ");
        let mut t = Table::new(["", "a\u{1b}"]);
        t.row(["x\ny".into(), "1".into()]);
        assert_eq!(t.text().lines().count(), 3);
        assert!(!t.text().contains('\u{1b}'));
    }

    #[test]
    fn tables_align() {
        let mut t = Table::new(["name", "value"]);
        t.row(["a".into(), "10".into()]);
        t.row(["longer".into(), "5".into()]);
        assert_eq!(t.text(), "name    value\n──────  ─────\na          10\nlonger      5\n");
        assert_eq!(
            t.markdown(),
            "| name   | value |\n|:-------|------:|\n| a      |    10 |\n| longer |     5 |\n"
        );
    }
}
