//! Cases on disk: dictionaries to configuration, fields, time directories, functions, plots.
