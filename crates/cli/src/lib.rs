//! The granflow command.
