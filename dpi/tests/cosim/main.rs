//! The examples in C and SystemVerilog, compiled against the headers and the library, have the model's bits.
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at the first thing that is not as it should be"
)]

mod c;
mod verilator;

use std::path::{Path, PathBuf};

/// The folder in which this test's library lies.
fn library() -> Option<PathBuf> {
    let own = std::env::current_exe().unwrap();
    own.ancestors()
        .skip(1)
        .take(2)
        .find(|folder| folder.join("libtapline_dpi.so").is_file())
        .map(Path::to_path_buf)
}
