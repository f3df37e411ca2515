//! OpenFOAM dictionaries: spans, a parser that never fails, typed readers, diagnostics, a writer.
//!
//! ```
//! use granflow_base::Dims;
//! use granflow_dict::{NoFiles, Reader, Severity, Sink, Source, parse};
//!
//! let src = Source::new("constant/transportProperties", "nu [0 2 -1 0 0 0 0] 1e-5; sigma 0;");
//! let (dict, diags) = parse(src, &mut NoFiles);
//! let sink = Sink::new();
//! sink.extend(diags);
//! let r = Reader::new(&dict, &sink);
//! let nu = r.positive("nu", Dims::KINEMATIC_VISCOSITY);
//! let sigma = r.opt_non_negative("sigma", Dims::NONE, 0.0);
//! r.finish(Severity::Error);
//! assert!(!sink.has_errors());
//! assert_eq!((nu, sigma), (1e-5, 0.0));
//! ```
//!
//! | task | door |
//! |---|---|
//! | a dictionary file, a field file | [`parse`] gives a [`Dict`] and [`Diag`]s |
//! | a mesh file | [`parse_list_file`] gives a [`Payload`] |
//! | typed values with checks | [`Reader`], [`TokenReader`] for values by position |
//! | messages | [`Sink`], [`Diags`], [`Diag::render`] |
//! | writing | [`Writer`], [`list_file`] |
//! | gzip, includes | [`decompress`], [`Files`] |
//!
//! The parser goes on after every mistake and a reader returns a harmless value for what is wrong,
//! so that one run names everything. No value may be used before [`Sink::has_errors`] was asked.
//!
//! Expanded on the way: `$name`, `${name}`, `${a${b}}`, `$:from.the.top`, `$.here`, `$..parent`,
//! variables of the environment, `#include`, `#includeIfPresent`, `#sinclude`, `#inputMode`,
//! `#remove`, `#calc`, `#eval`, `${{ }}`, `#if`, `#ifeq`, `#includeFunc`, and of `#includeEtc` the
//! constraint types of fields and what functions of tutorials include. Refused by name:
//! `#codeStream`, any other `#includeEtc`.

mod arith;
mod diag;
mod directives;
mod environment;
mod etc;
mod expand;
mod files;
mod include_func;
mod listfile;
mod lists;
mod nearest;
mod parse;
mod reader;
mod scan;
mod sequence;
mod source;
mod token;
mod tree;
mod writer;

pub use diag::{Diag, Diags, Severity, Sink};
pub use etc::CONSTRAINT_TYPES;
pub use files::{Files, MemoryFiles, NoFiles, compress, decompress};
pub use include_func::PACKAGED_FUNCTIONS;
pub use listfile::parse_list_file;
pub use lists::Payload;
pub use nearest::nearest;
pub use parse::{parse, parse_str};
pub use reader::{FieldValue, Reader, TokenReader};
pub use source::{Source, Span};
pub use tree::{Dict, Entry, Key, Pattern, Tok, Token, Value};
pub use writer::{Format, Header, List, Writer, list_file, number};
