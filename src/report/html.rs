//! Aligned text tables for terminals.
