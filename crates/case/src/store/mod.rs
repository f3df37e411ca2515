//! Time directories and other files on disk: whole or not at all.
//!
//! Everything is written aside, under a hidden name beside its target, synchronised to the disk
//! and then renamed. A reader (ParaView, a restart, a person) therefore sees the earlier state or
//! the new one, never half of either, whatever moment a run is killed at or a disk fills up.
//!
//! - [`TimeName`], [`list_times`], [`latest`], [`nearest_time`]: time values and their directories
//! - [`TimeWriter`], [`DirWriter`], [`write_atomic`]: writing
//! - [`purge`], [`clean_stale`]: removing
//! - [`CaseLock`]: one process at a time
//! - [`StoreError`]: what failed, on which path, and whether the machine is to blame

mod dir;
mod disk;
mod error;
mod lock;
mod stale;
mod time;

pub use dir::{Compression, DirWriter, TimeWriter, write_atomic, write_atomic_on, write_whole};
pub use disk::{Disk, RealDisk};
pub use error::{Kind, Operation, StoreError};
pub use lock::{CaseLock, LOCK_NAME, LockError};
pub use stale::{Stale, clean_stale, purge};
pub use time::{MAX_PRECISION, TimeFormat, TimeName, latest, list_times, nearest_time};
