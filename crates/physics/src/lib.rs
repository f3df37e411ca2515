//! Rheologies from Newtonian to nonlocal granular fluidity.
