//! Threads and ranks: Exec, Comm, Halo.
