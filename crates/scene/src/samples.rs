//! Probes over time, with bounded memory: when the rows are full, every second one goes and the stride doubles.

use crate::limits;
use std::fmt::Write;

/// Columns of numbers over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    names: Vec<String>,
    stride: u64,
    times: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

impl Samples {
    pub(crate) fn new(names: Vec<String>) -> Self {
        let columns = names.iter().map(|_| Vec::new()).collect();
        Self { names, stride: 1, times: Vec::new(), columns }
    }

    /// Keeps only steps that are multiples of this many. Rows that are there stay.
    pub(crate) fn keep_every(&mut self, steps: u64) {
        self.stride = steps.max(1);
    }

    pub(crate) fn push(&mut self, step: u64, time: f64, values: &[f64]) {
        if self.names.is_empty() || !step.is_multiple_of(self.stride) {
            return;
        }
        let limit = (limits::ROWS_MAX / self.names.len()).max(1024);
        if self.times.len() >= limit {
            halve(&mut self.times);
            self.columns.iter_mut().for_each(halve);
            self.stride *= 2;
            if !step.is_multiple_of(self.stride) {
                return;
            }
        }
        self.times.push(time);
        self.columns.iter_mut().zip(values).for_each(|(c, v)| c.push(*v));
    }

    /// Names of the probes, in the order of the file.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Steps from row to row.
    pub fn stride(&self) -> u64 {
        self.stride
    }

    /// Time of each row, s; the first is the start.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The numbers of a probe, one for each row; NaN while its body is not there.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let n = self.names.iter().position(|m| m == name)?;
        self.columns.get(n).map(Vec::as_slice)
    }

    /// As comma-separated values with a header, a row a line.
    pub fn csv(&self) -> String {
        let quoted = |n: &String| {
            if n.contains([',', '"', '\n']) { format!("\"{}\"", n.replace('"', "\"\"")) } else { n.clone() }
        };
        let mut out = String::from("time");
        self.names.iter().for_each(|n| {
            out.push(',');
            out.push_str(&quoted(n));
        });
        out.push('\n');
        for row in 0..self.times.len() {
            // Writing to a String cannot fail.
            let _ = write!(out, "{}", self.times[row]);
            for c in &self.columns {
                let _ = if c[row].is_finite() { write!(out, ",{}", c[row]) } else { write!(out, ",") };
            }
            out.push('\n');
        }
        out
    }
}

fn halve(column: &mut Vec<f64>) {
    let mut n = 0;
    column.retain(|_| {
        n += 1;
        n % 2 == 1
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stay_bounded_and_even() {
        let mut s = Samples::new(vec!["a,b".into()]);
        let n = 3 * limits::ROWS_MAX as u64;
        for step in 0..n {
            s.push(step, step as f64, &[2.0 * step as f64]);
        }
        assert!(s.times().len() <= limits::ROWS_MAX);
        assert_eq!(s.stride(), 4);
        let column = s.column("a,b").expect("there");
        for (row, t) in s.times().iter().enumerate() {
            assert_eq!((*t, column[row]), (4.0 * row as f64, 8.0 * row as f64));
        }
    }

    #[test]
    fn csv_leaves_gaps() {
        let mut s = Samples::new(vec!["a,b".into(), "c".into()]);
        s.push(0, 0.0, &[1.5, f64::NAN]);
        s.push(1, 0.25, &[2.0, 3.0]);
        assert_eq!(s.csv(), "time,\"a,b\",c\n0,1.5,\n0.25,2,3\n");
    }
}
