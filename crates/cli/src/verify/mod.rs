//! `jounce verify`: every law beside its closed form or measured data.
//!
//! A *law* runs the engine and gives rows; `LAWS` lists them all, one module per topic. A row's tolerance is a
//! formula of the method (order of the integrator × step, contact slop), written where the row is made; it is
//! never what happened to come out.

mod rows;

use crate::args::VerifyArgs;
use crate::error::{Done, Failure};
use crate::output::{Table, note, number, print, print_json, progress};
use serde::Serialize;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};

/// One number of one law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What is measured; unique, since the list of known misses goes by it.
    pub name: String,
    /// The topic it belongs to.
    pub topic: String,
    /// By the closed form or the data.
    pub expected: f64,
    /// From the engine.
    pub got: f64,
    /// |got − expected|.
    pub error: f64,
    /// Largest accepted error.
    pub tolerance: f64,
    /// Unit of expected, got, error and tolerance; empty for a pure number.
    pub unit: String,
    /// The formula or the publication.
    pub source: String,
    /// error ≤ tolerance.
    pub pass: bool,
}

impl Row {
    /// A row that must come within `tolerance` of `expected`. A result that is not finite misses.
    pub fn new(name: &str, expected: f64, got: f64, tolerance: f64, unit: &str, source: &str) -> Self {
        let error = (got - expected).abs();
        Self {
            name: name.into(),
            topic: String::new(),
            expected,
            got,
            error,
            tolerance,
            unit: unit.into(),
            source: source.into(),
            pass: error <= tolerance,
        }
    }
    /// A row that must come within a part of `expected` (0.01: one per cent).
    pub fn relative(name: &str, expected: f64, got: f64, part: f64, unit: &str, source: &str) -> Self {
        Self::new(name, expected, got, part * expected.abs(), unit, source)
    }
    /// A row that counts what must not happen, or measures a drift from zero: at most `limit`.
    pub fn at_most(name: &str, limit: f64, got: f64, unit: &str, source: &str) -> Self {
        Self::new(name, 0.0, got, limit, unit, source)
    }
    /// A row that is true or false.
    pub fn holds(name: &str, yes: bool, source: &str) -> Self {
        Self::new(name, 1.0, f64::from(u8::from(yes)), 0.0, "", source)
    }
}

/// Rows of a law, or why the engine refused to run it.
pub type Rows = Result<Vec<Row>, jounce::Error>;

/// A law: its topic, its name and how it is measured.
pub struct Law {
    /// Group of the table: "collision", "friction", ….
    pub topic: &'static str,
    /// Name; also the name of the row that stands for it where it cannot be run.
    pub name: &'static str,
    /// Measures.
    pub run: fn() -> Rows,
}

/// All laws, in the order of the table. Each topic is a module that ends in a list of its own.
const LAWS: &[&[Law]] = rows::LAWS;

#[derive(Serialize)]
struct Report {
    rows: Vec<Row>,
}

pub(crate) fn verify(a: &VerifyArgs) -> Done {
    let filter = a.filter.as_deref().unwrap_or("").to_lowercase();
    let chosen: Vec<&Law> = LAWS
        .iter()
        .flat_map(|laws| laws.iter())
        .filter(|l| l.topic.to_lowercase().contains(&filter) || l.name.to_lowercase().contains(&filter))
        .collect();
    if chosen.is_empty() && !filter.is_empty() {
        let mut topics: Vec<&str> = Vec::new();
        for topic in LAWS.iter().flat_map(|laws| laws.iter().map(|l| l.topic)) {
            if !topics.contains(&topic) {
                topics.push(topic);
            }
        }
        return Err(Failure::bad(format!(
            "no law or topic holds \"{filter}\"; expected a part of a law's name or one of the topics {}",
            topics.join(", ")
        )));
    }
    let rows = measure(&chosen);
    let misses = rows.iter().filter(|r| !r.pass).count();
    if a.json {
        print_json(&Report { rows })?;
    } else {
        print(&table(&rows))?;
    }
    if misses == 0 { Ok(()) } else { Err(Failure::Misses) }
}

/// Measures the laws on all cores; rows come in the laws' order.
fn measure(laws: &[&Law]) -> Vec<Row> {
    let bar = progress(laws.len() as u64, "verify");
    let next = AtomicUsize::new(0);
    let found: Mutex<Vec<(usize, Vec<Row>)>> = Mutex::new(Vec::new());
    let work = || {
        while let Some((i, law)) = {
            let i = next.fetch_add(1, Ordering::Relaxed);
            laws.get(i).map(|l| (i, l))
        } {
            let mut rows = (law.run)().unwrap_or_else(|e| {
                note(&format!("{}: {e}", law.name));
                vec![Row::new(law.name, f64::NAN, f64::NAN, 0.0, "", "could not be run")]
            });
            for r in &mut rows {
                r.topic = law.topic.into();
            }
            found.lock().unwrap_or_else(PoisonError::into_inner).push((i, rows));
            bar.inc(1);
        }
    };
    std::thread::scope(|s| {
        for _ in 1..std::thread::available_parallelism().map_or(1, usize::from) {
            // Where the system gives no thread, this one does all the work.
            let _ = std::thread::Builder::new().spawn_scoped(s, work);
        }
        work();
    });
    bar.finish_and_clear();
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    found.sort_by_key(|(i, _)| *i);
    found.into_iter().flat_map(|(_, rows)| rows).collect()
}

fn table(rows: &[Row]) -> String {
    let mut t = Table::new(["topic", "law", "expected", "got", "error", "tolerance", "unit", "", "source"])
        .left(1)
        .left(6)
        .left(7)
        .left(8);
    for r in rows {
        t.row([
            r.topic.clone(),
            r.name.clone(),
            number(r.expected),
            number(r.got),
            number(r.error),
            number(r.tolerance),
            r.unit.clone(),
            if r.pass { "ok" } else { "MISS" }.into(),
            r.source.clone(),
        ]);
    }
    let misses = rows.iter().filter(|r| !r.pass).count();
    format!("{}\n{} rows, {} within tolerance, {misses} missing\n", t.text(), rows.len(), rows.len() - misses)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_passes_within_its_tolerance_only() {
        assert!(Row::new("a", 2.0, 2.1, 0.11, "m", "").pass);
        assert!(!Row::new("a", 2.0, 2.1, 0.09, "m", "").pass);
        assert!(!Row::new("a", 2.0, f64::NAN, 1.0, "m", "").pass);
        assert!(!Row::new("a", 2.0, f64::INFINITY, f64::NAN, "m", "").pass);
        assert!(Row::relative("a", -10.0, -10.05, 0.01, "", "").pass);
        assert!(!Row::holds("a", false, "").pass);
    }

    #[test]
    fn names_are_unique() {
        let mut names: Vec<&str> = LAWS.iter().flat_map(|laws| laws.iter().map(|l| l.name)).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
