//! OpenFOAM dictionaries: spans, a parser that never fails, typed readers, diagnostics.
