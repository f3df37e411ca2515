//! `log.jsonl` of a case: one JSON object a line, for programs to read while the run goes on.
//!
//! A line is written in one piece and flushed before the call returns; a reader never waits for
//! half a line except when the machine stopped in the middle of one, and that remainder is cut
//! off when the log is opened again.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde_json::{Map, Number, Value};

use crate::store::{Operation, StoreError};

/// The name of the log in the case directory.
pub const LOG_NAME: &str = "log.jsonl";

/// The linear solves of one field in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolveRecord<'a> {
    /// The field solved for.
    pub field: &'a str,
    /// Iterations of the linear solver.
    pub iterations: usize,
    /// Normalised residual before.
    pub first: f64,
    /// Normalised residual after.
    pub last: f64,
    /// Solves of the step that ran out of iterations.
    pub unconverged: usize,
}

/// What happened in one time step or one iteration of a steady solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepRecord<'a> {
    /// Time at the end of the step, s.
    pub time: f64,
    /// Number of the step.
    pub step: u64,
    /// Its length, s.
    pub dt: f64,
    /// Outer (pressure-velocity) iterations.
    pub outer: usize,
    /// Residual of each equation at the end of the step.
    pub residuals: &'a [(&'a str, f64)],
    /// The linear solves, a field each.
    pub solves: &'a [SolveRecord<'a>],
    /// Wall-clock time since the start of the run, s.
    pub wall: f64,
}

/// The open log of a case.
#[derive(Debug)]
pub struct Log {
    file: File,
    path: PathBuf,
    line: Vec<u8>,
    /// End of the last whole line; only known for a regular file.
    end: Option<u64>,
}

impl Log {
    /// Starts a new log, dropping an earlier one.
    pub fn create(case: &Path) -> Result<Log, StoreError> {
        Self::open(case, true)
    }

    /// Goes on with the log of an earlier run, or starts one.
    pub fn append(case: &Path) -> Result<Log, StoreError> {
        Self::open(case, false)
    }

    fn open(case: &Path, fresh: bool) -> Result<Log, StoreError> {
        let path = case.join(LOG_NAME);
        let open = || -> io::Result<(File, Option<u64>)> {
            let mut file = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(fresh)
                .open(&path)?;
            if !file.metadata()?.is_file() {
                return Ok((file, None));
            }
            let end = end_of_last_line(&mut file)?;
            file.set_len(end)?;
            file.seek(SeekFrom::Start(end))?;
            Ok((file, Some(end)))
        };
        match open() {
            Ok((file, end)) => Ok(Log { file, path, line: Vec::new(), end }),
            Err(e) => Err(StoreError::new(Operation::Create, path, e)),
        }
    }

    /// Where the log is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes `{"event": kind, ...fields}`: start, write, stop, warning.
    pub fn event(&mut self, kind: &str, fields: &Map<String, Value>) -> Result<(), StoreError> {
        let mut object = Map::new();
        object.insert("event".to_owned(), kind.into());
        object.extend(fields.iter().map(|(k, v)| (k.clone(), v.clone())));
        self.object(&Value::Object(object))
    }

    /// Writes the report of one step.
    pub fn step(&mut self, r: &StepRecord<'_>) -> Result<(), StoreError> {
        let mut object = Map::new();
        let mut put = |key: &str, value: Value| object.insert(key.to_owned(), value);
        put("time", number(r.time));
        put("step", r.step.into());
        put("dt", number(r.dt));
        put("outer", r.outer.into());
        put("residuals", r.residuals.iter().map(|(k, v)| ((*k).to_owned(), number(*v))).collect());
        put("solves", r.solves.iter().map(solve).collect());
        put("wall", number(r.wall));
        self.object(&Value::Object(object))
    }

    fn object(&mut self, value: &Value) -> Result<(), StoreError> {
        self.line.clear();
        let written =
            serde_json::to_writer(&mut self.line, value).map_err(io::Error::from).and_then(|()| {
                self.line.push(b'\n');
                self.file.write_all(&self.line)?;
                self.file.flush()
            });
        if let Err(e) = written {
            // Cut the half line off, so that a run that goes on writes whole lines.
            if let Some(end) = self.end {
                let _ = self.file.set_len(end);
                let _ = self.file.seek(SeekFrom::Start(end));
            }
            return Err(StoreError::new(Operation::Write, &self.path, e));
        }
        if let Some(end) = &mut self.end {
            *end += self.line.len() as u64;
        }
        Ok(())
    }
}

/// Removes the log of an earlier run, if there is one.
pub fn remove(case: &Path) -> Result<(), StoreError> {
    let path = case.join(LOG_NAME);
    match fs::remove_file(&path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => {
            Err(StoreError::new(Operation::Remove, path, e))
        }
        _ => Ok(()),
    }
}

fn solve(s: &SolveRecord<'_>) -> Value {
    serde_json::json!({
        "field": s.field,
        "iterations": s.iterations,
        "first": number(s.first),
        "last": number(s.last),
        "unconverged": s.unconverged,
    })
}

/// JSON has no infinities and no NaN; a diverged run reports them as the strings that Python's
/// `float` and others read.
fn number(x: f64) -> Value {
    match Number::from_f64(x) {
        Some(n) => Value::Number(n),
        None if x.is_nan() => "nan".into(),
        None if x > 0.0 => "inf".into(),
        None => "-inf".into(),
    }
}

/// Position after the last line feed, read backwards in blocks.
fn end_of_last_line(file: &mut File) -> io::Result<u64> {
    let mut block = [0u8; 4096];
    let mut end = file.seek(SeekFrom::End(0))?;
    while end > 0 {
        let n = end.min(block.len() as u64);
        file.seek(SeekFrom::Start(end - n))?;
        let part = &mut block[..n as usize];
        file.read_exact(part)?;
        if let Some(i) = part.iter().rposition(|b| *b == b'\n') {
            return Ok(end - n + i as u64 + 1);
        }
        end -= n;
    }
    Ok(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Kind;

    fn record<'a>() -> StepRecord<'a> {
        StepRecord {
            time: 0.5,
            step: 7,
            dt: 1e-3,
            outer: 2,
            residuals: &[("U", 1e-5), ("p", f64::NAN)],
            solves: &[SolveRecord {
                field: "p",
                iterations: 12,
                first: 0.1,
                last: 1e-7,
                unconverged: 1,
            }],
            wall: 1.25,
        }
    }

    fn lines(case: &Path) -> Vec<Value> {
        let text = fs::read_to_string(case.join(LOG_NAME)).unwrap();
        text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
    }

    #[test]
    fn a_step_is_one_line_on_the_disk_when_the_call_returns() {
        let case = tempfile::tempdir().unwrap();
        let mut log = Log::create(case.path()).unwrap();
        log.step(&record()).unwrap();
        let expected = serde_json::json!({
            "time": 0.5, "step": 7, "dt": 1e-3, "outer": 2,
            "residuals": {"U": 1e-5, "p": "nan"},
            "solves": [
                {"field": "p", "iterations": 12, "first": 0.1, "last": 1e-7, "unconverged": 1}
            ],
            "wall": 1.25,
        });
        assert_eq!(lines(case.path()), [expected]);
    }

    #[test]
    fn append_goes_on_after_the_last_whole_line() {
        let case = tempfile::tempdir().unwrap();
        let half = format!("{{\"event\":\"start\"}}\n{{\"time\":{}", "1".repeat(10_000));
        fs::write(case.path().join(LOG_NAME), half).unwrap();
        let mut log = Log::append(case.path()).unwrap();
        log.event("restart", &Map::from_iter([("time".to_owned(), number(0.5))])).unwrap();
        let all = lines(case.path());
        assert_eq!(all.len(), 2);
        assert_eq!(all[1], serde_json::json!({"event": "restart", "time": 0.5}));
        Log::create(case.path()).unwrap();
        assert!(lines(case.path()).is_empty(), "create starts anew");
        remove(case.path()).unwrap();
        remove(case.path()).unwrap();
        assert!(!case.path().join(LOG_NAME).exists());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_reported_by_the_line_that_does_not_fit() {
        let case = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink("/dev/full", case.path().join(LOG_NAME)).unwrap();
        let e = Log::append(case.path()).unwrap().step(&record()).unwrap_err();
        assert_eq!(e.kind(), Kind::DiskFull);
        assert!(e.is_machine_failure());
        assert!(e.to_string().contains("log.jsonl: disk full"), "{e}");
    }
}
