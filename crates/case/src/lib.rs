//! Cases on disk: dictionaries to configuration, fields, time directories, functions, plots.
//!
//! [`Case::load`] reads and checks everything and changes nothing; [`Run`] computes, writes and
//! can be asked for one step at a time.

pub mod bad_cells;
pub mod boundary;
mod build;
mod case;
mod collect;
pub mod config;
mod error;
pub mod expect;
pub mod export;
pub mod fields;
pub mod figures;
pub mod files;
mod formulae;
mod frames;
pub mod functions;
pub mod init;
pub mod jsonl;
pub mod meshing;
mod notices;
pub mod output;
pub mod plot;
pub mod restart;
mod run;
mod section;
mod sense;
pub mod set_fields;
pub mod store;
pub mod strays;
pub mod study;
mod superseded;
mod tensile;
mod waves;
mod worker;
mod zones;

pub use case::{Case, From, Options};
pub use config::CaseConfig;
pub use error::CaseError;
pub use notices::Notices;
pub use run::{End, Event, Run, Shortened, StepEvent};
pub use superseded::{SUPERSEDED, SetAside};
pub use tensile::Tensile;
pub use waves::WaveTable;
pub use zones::Zones;
