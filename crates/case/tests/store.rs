//! Nothing lost: whatever fails and whenever the process dies, a case holds the earlier state or
//! the new one, and an error is reported by the call that met it.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use granflow_case::store::{
    Compression, DirWriter, Disk, Kind, Operation, RealDisk, Stale, StoreError, TimeName,
    TimeWriter, clean_stale, latest, list_times, nearest_time, purge, write_atomic,
    write_atomic_on,
};

/// What the disk does from the chosen operation on.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    /// One operation fails, the process goes on.
    Once,
    /// The process is dead: nothing happens any more, not even cleaning up.
    Dead,
    /// As `Once`, but a failing write leaves half of its bytes: the disk is full.
    Full,
}

/// A disk that fails at the `n`-th operation.
struct Faulty {
    fault: Fault,
    at: usize,
    count: AtomicUsize,
    exchange: bool,
}

impl Faulty {
    fn new(fault: Fault, at: usize, exchange: bool) -> Arc<Self> {
        Arc::new(Faulty { fault, at, count: AtomicUsize::new(0), exchange })
    }

    fn next(&self) -> io::Result<()> {
        let n = self.count.fetch_add(1, Ordering::Relaxed);
        match self.fault {
            Fault::Dead if n >= self.at => Err(ErrorKind::Interrupted.into()),
            Fault::Once | Fault::Full if n == self.at => Err(ErrorKind::StorageFull.into()),
            _ => Ok(()),
        }
    }
}

impl Disk for Faulty {
    fn create_dir(&self, path: &Path) -> io::Result<()> {
        self.next().and_then(|()| RealDisk.create_dir(path))
    }
    fn write_new(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let next = self.next();
        if next.is_err() && self.fault == Fault::Full {
            RealDisk.write_new(path, &bytes[..bytes.len() / 2])?;
        }
        next.and_then(|()| RealDisk.write_new(path, bytes))
    }
    fn sync_dir(&self, path: &Path) -> io::Result<()> {
        self.next().and_then(|()| RealDisk.sync_dir(path))
    }
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.next().and_then(|()| RealDisk.rename(from, to))
    }
    fn exchange(&self, a: &Path, b: &Path) -> io::Result<()> {
        if !self.exchange {
            return Err(ErrorKind::Unsupported.into());
        }
        self.next().and_then(|()| RealDisk.exchange(a, b))
    }
    fn link(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.next().and_then(|()| RealDisk.link(from, to))
    }
    fn remove_file(&self, path: &Path) -> io::Result<()> {
        // Asking for a file that is not there is not an operation that can fail.
        if !path.exists() {
            return Err(ErrorKind::NotFound.into());
        }
        self.next().and_then(|()| RealDisk.remove_file(path))
    }
    fn remove_dir_all(&self, path: &Path) -> io::Result<()> {
        self.next().and_then(|()| RealDisk.remove_dir_all(path))
    }
}

fn write_time(disk: Arc<dyn Disk>, case: &Path, text: &str) -> Result<PathBuf, StoreError> {
    let mut time = TimeWriter::on(disk, case, "0.5")?;
    for name in ["U", "p", "uniform/time"] {
        time.file(name, text.as_bytes())?;
    }
    time.commit()
}

/// Every file of a directory with its content.
fn content(dir: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(content(&path));
        } else {
            found.push((path.clone(), fs::read_to_string(path).unwrap()));
        }
    }
    found.sort();
    found
}

fn whole(case: &Path, text: &str) -> Vec<(PathBuf, String)> {
    let files = ["U", "p", "uniform/time"];
    files.iter().map(|f| (case.join("0.5").join(f), text.to_owned())).collect()
}

fn visible(case: &Path) -> Vec<PathBuf> {
    list_times(case).unwrap().into_iter().map(|(_, p)| p).collect()
}

/// Runs a write with a fault at every operation in turn. `earlier`: over an existing directory.
fn with_every_fault(fault: Fault, earlier: bool, exchange: bool, check: impl Fn(&Path, bool)) {
    for at in 0.. {
        let case = tempfile::tempdir().unwrap();
        if earlier {
            write_time(Arc::new(RealDisk), case.path(), "old").unwrap();
        }
        let disk = Faulty::new(fault, at, exchange);
        let result = write_time(disk.clone(), case.path(), "new");
        check(case.path(), result.is_ok());
        if disk.count.load(Ordering::Relaxed) <= at {
            assert!(result.is_ok() && at > 8, "only {at} operations");
            return;
        }
    }
}

#[test]
fn an_operation_that_fails_is_reported_and_leaves_the_earlier_state() {
    for fault in [Fault::Once, Fault::Full] {
        for (earlier, exchange) in [(false, true), (true, true), (true, false)] {
            with_every_fault(fault, earlier, exchange, |case, ok| {
                let expected = match (ok, earlier) {
                    (true, _) => whole(case, "new"),
                    (false, true) => whole(case, "old"),
                    (false, false) => Vec::new(),
                };
                let seen: Vec<_> = visible(case).iter().flat_map(|dir| content(dir)).collect();
                assert_eq!(seen, expected);
                clean_stale(case).unwrap(); // what could not be removed at once
                assert_eq!(content(case), expected);
            });
        }
    }
}

#[test]
fn a_process_that_dies_leaves_one_whole_state() {
    for (earlier, exchange) in [(false, true), (true, true), (true, false)] {
        with_every_fault(Fault::Dead, earlier, exchange, |case, ok| {
            // Before cleaning: nothing half is visible.
            for dir in visible(case) {
                assert!([whole(case, "old"), whole(case, "new")].contains(&content(&dir)));
            }
            clean_stale(case).unwrap();
            let after = content(case);
            assert!(!ok || after == whole(case, "new"));
            assert!(
                after == whole(case, "new")
                    || after == if earlier { whole(case, "old") } else { Vec::new() },
                "{after:?}"
            );
            assert!(clean_stale(case).unwrap().is_empty());
        });
    }
}

#[test]
fn an_old_directory_set_aside_comes_back() {
    let case = tempfile::tempdir().unwrap();
    write_time(Arc::new(RealDisk), case.path(), "old").unwrap();
    let aside = case.path().join(".granflow-0.5-4194999-3.old");
    fs::rename(case.path().join("0.5"), &aside).unwrap();
    fs::create_dir(case.path().join(".granflow-0.5-4194999-2.new")).unwrap();
    let done = clean_stale(case.path()).unwrap();
    assert_eq!(done.len(), 2);
    assert!(done.contains(&Stale::Restored(case.path().join("0.5"))));
    assert_eq!(content(case.path()), whole(case.path(), "old"));
}

#[test]
fn a_directory_is_replaced_as_a_whole_or_added_to() {
    let case = tempfile::tempdir().unwrap();
    let mut first = TimeWriter::begin(case.path(), "0").unwrap().compressed(Compression::Gzip);
    first.file("U", b"one").unwrap();
    first.file_plain("uniform/time", b"time").unwrap();
    assert!(visible(case.path()).is_empty(), "not before the commit");
    let dir = first.commit().unwrap();
    let names = |dir: &Path| content(dir).into_iter().map(|(p, _)| p).collect::<Vec<_>>();
    let packed = fs::read(dir.join("U.gz")).unwrap();
    let mut text = String::new();
    io::Read::read_to_string(&mut flate2::read::GzDecoder::new(&packed[..]), &mut text).unwrap();
    assert_eq!(text, "one");

    let mut second = TimeWriter::begin(case.path(), "0").unwrap().keep_existing().unwrap();
    second.file("U", b"two").unwrap();
    second.file("uniform/other", b"x").unwrap();
    second.commit().unwrap();
    let expected: Vec<_> = ["U", "uniform/other", "uniform/time"].map(|n| dir.join(n)).into();
    assert_eq!(fs::read_to_string(dir.join("U")).unwrap(), "two");
    assert!(!dir.join("U.gz").exists(), "one name only");
    assert_eq!(names(&dir), expected);

    let mut third = TimeWriter::begin(case.path(), "0").unwrap();
    third.file("p", b"three").unwrap();
    third.commit().unwrap();
    assert_eq!(fs::read_dir(case.path()).unwrap().count(), 1, "no rubbish");
    assert_eq!(fs::read_dir(dir).unwrap().count(), 1);
}

#[test]
fn dropping_a_writer_keeps_a_taken_over_file_intact() {
    let case = tempfile::tempdir().unwrap();
    write_time(Arc::new(RealDisk), case.path(), "old").unwrap();
    let mut time = TimeWriter::begin(case.path(), "0.5").unwrap().keep_existing().unwrap();
    time.file("U", b"never committed").unwrap();
    drop(time);
    assert_eq!(content(case.path()), whole(case.path(), "old"));
}

#[cfg(unix)]
#[test]
fn a_linked_mesh_is_replaced_where_it_lives() {
    let case = tempfile::tempdir().unwrap();
    let (real, link) = (case.path().join("shared/polyMesh"), case.path().join("constant/polyMesh"));
    fs::create_dir_all(&real).unwrap();
    fs::create_dir(case.path().join("constant")).unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    let mut mesh = DirWriter::begin(&link).unwrap();
    mesh.file("points", b"0()").unwrap();
    mesh.commit().unwrap();
    assert!(link.is_symlink());
    assert_eq!(fs::read_to_string(real.join("points")).unwrap(), "0()");
}

#[test]
fn bad_paths_are_refused() {
    let case = tempfile::tempdir().unwrap();
    let mut time = TimeWriter::begin(case.path(), "1").unwrap();
    for bad in ["../U", "/tmp/U", ""] {
        let e = time.file(bad, b"").unwrap_err();
        assert!(e.kind() == Kind::BadPath && !e.is_machine_failure(), "{e}");
    }
    fs::write(case.path().join("2"), "a file").unwrap();
    assert_eq!(TimeWriter::begin(case.path(), "2").err().map(|e| e.kind()), Some(Kind::BadPath));
}

#[test]
fn single_files_are_whole_too() {
    let case = tempfile::tempdir().unwrap();
    let path = case.path().join("plots/profile.csv");
    write_atomic(&path, b"one").unwrap();
    write_atomic(&path, b"two").unwrap();
    assert_eq!(content(case.path()), [(path.clone(), "two".to_owned())]);
    let e = write_atomic(&path.join("below"), b"").unwrap_err();
    assert!(e.to_string().contains("profile.csv"), "{e}");
    for fault in [Fault::Once, Fault::Full, Fault::Dead] {
        for at in 0..3 {
            let e = write_atomic_on(&*Faulty::new(fault, at, true), &path, b"three").unwrap_err();
            clean_stale(case.path()).unwrap();
            let expected = if e.op == Operation::Sync { "three" } else { "two" };
            assert_eq!(content(case.path()), [(path.clone(), expected.to_owned())]);
            write_atomic(&path, b"two").unwrap();
        }
    }
}

#[test]
fn times_are_listed_in_order_and_purged() {
    let case = tempfile::tempdir().unwrap();
    for name in ["0", "0.1", "1e-05", "10", "2", "0.orig", "constant", ".granflow-x", "0.3"] {
        fs::create_dir(case.path().join(name)).unwrap();
    }
    fs::write(case.path().join("5"), "a file").unwrap();
    let names = || {
        let base = |p: PathBuf| p.file_name().unwrap().to_str().unwrap().to_owned();
        visible(case.path()).into_iter().map(base).collect::<Vec<_>>()
    };
    assert_eq!(names(), ["0", "1e-05", "0.1", "0.3", "2", "10"]);
    assert_eq!(latest(case.path()).unwrap().unwrap().0, 10.0);
    assert_eq!(nearest_time(case.path(), 0.26).unwrap().unwrap().0, 0.3);
    assert!(purge(case.path(), 0, "0", "10").unwrap().is_empty());
    // A run from 1e-05 that has come to 2; 10 belongs to an earlier one.
    assert_eq!(purge(case.path(), 1, "1e-05", "2").unwrap().len(), 2);
    assert_eq!(names(), ["0", "1e-05", "2", "10"]);
    assert_eq!(purge(case.path(), 1, "zero", "2").unwrap_err().kind(), Kind::BadPath);
    assert_eq!(list_times(&case.path().join("none")).unwrap_err().kind(), Kind::NotFound);
    assert_eq!(TimeName::default().of(0.1), "0.1");
}

/// Helper of the tests below: what the child process does. Ignored in a normal run.
#[test]
#[ignore = "run by the tests below in a process of its own"]
fn child() {
    let Ok(case) = std::env::var("GRANFLOW_TEST_CASE") else { return };
    let case = Path::new(&case);
    let mut time = TimeWriter::begin(case, "0.5").unwrap();
    time.file("U", b"half of it").unwrap();
    match std::env::var("GRANFLOW_TEST_DO").as_deref() {
        Ok("abort") => std::process::abort(),
        Ok("wait") => {
            fs::write(case.join("ready"), "").unwrap();
            std::thread::sleep(std::time::Duration::from_secs(60));
        }
        _ => {
            let e = time.file("p", &vec![b'x'; 1 << 20]).unwrap_err();
            assert_eq!(e.kind(), Kind::DiskFull, "{e}");
            assert!(e.is_machine_failure() && e.path.ends_with("0.5/p"));
            drop(time);
            fs::write(case.join("reported"), e.to_string()).unwrap();
        }
    }
}

#[cfg(unix)]
fn start_child(case: &Path, what: &str, limit: &str) -> std::process::Child {
    let me = std::env::current_exe().unwrap();
    std::process::Command::new("sh")
        .arg("-c")
        .arg(format!("trap '' XFSZ; {limit} exec \"$0\" --exact child --ignored -q"))
        .arg(me)
        .env("GRANFLOW_TEST_CASE", case)
        .env("GRANFLOW_TEST_DO", what)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap()
}

#[cfg(unix)]
#[test]
fn the_limit_of_a_real_file_system_is_met_in_the_call() {
    let case = tempfile::tempdir().unwrap();
    write_time(Arc::new(RealDisk), case.path(), "old").unwrap();
    let status = start_child(case.path(), "fill", "ulimit -f 64;").wait().unwrap();
    assert!(status.success());
    let report = fs::read_to_string(case.path().join("reported")).unwrap();
    assert!(report.contains("0.5/p: disk full"), "{report}");
    fs::remove_file(case.path().join("reported")).unwrap();
    assert_eq!(content(case.path()), whole(case.path(), "old"));
}

#[cfg(unix)]
#[test]
fn a_killed_process_leaves_nothing_visible_and_is_cleaned_up() {
    let case = tempfile::tempdir().unwrap();
    let hidden = || fs::read_dir(case.path()).unwrap().count();
    assert!(!start_child(case.path(), "abort", "").wait().unwrap().success());
    assert!(visible(case.path()).is_empty());
    assert_eq!((hidden(), clean_stale(case.path()).unwrap().len(), hidden()), (1, 1, 0));

    // What a living process writes stays, until the process is killed.
    let mut child = start_child(case.path(), "wait", "");
    while !case.path().join("ready").exists() {
        assert!(child.try_wait().unwrap().is_none(), "the child died");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(clean_stale(case.path()).unwrap().is_empty());
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(visible(case.path()).is_empty());
    assert_eq!(clean_stale(case.path()).unwrap().len(), 1);
    assert_eq!(hidden(), 1, "only the file `ready`");
}

#[test]
fn our_own_unfinished_directory_is_left_alone() {
    let case = tempfile::tempdir().unwrap();
    let mut time = TimeWriter::begin(case.path(), "1").unwrap();
    time.file("U", b"x").unwrap();
    assert!(clean_stale(case.path()).unwrap().is_empty());
    time.commit().unwrap();
    assert_eq!(visible(case.path()).len(), 1);
}
