//! Cases on disk: dictionaries to configuration, fields, time directories, functions, plots.

pub mod jsonl;
pub mod plot;
pub mod store;
