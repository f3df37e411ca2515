//! The one seam for threads and ranks: [`Exec`] (a standing team of threads plus a communicator),
//! [`Comm`] (the ranks) and [`Halo`] (ghost values). A serial run is one thread, one rank and an
//! empty halo, so no code outside this crate asks whether it runs in parallel.
//!
//! Sums are formed over fixed blocks of [`BLOCK`] entries which are added in block order and then
//! in rank order: a run gives the same bits for any number of threads.

mod comm;
mod exec;
mod halo;
mod in_process;
mod pages;
mod rows;
mod team;
mod wide;

pub use comm::{Comm, Solo};
pub use exec::{BLOCK, Exec};
pub use halo::{Halo, Link};
pub use in_process::InProcess;
pub use pages::large_pages;
pub use wide::{gather, wide};
