//! The `tapline` command.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write as _;

/// The system's memory; where there is none left, the program says so and ends with status 2.
struct Memory;

/// Ends the program without a further allocation. Output files wait in memory, so none is half written.
#[cold]
fn exhausted() -> ! {
    let words = b"tapline: memory: expected enough of it, found none left; choose a smaller --size, --face-size or --max-image-mb, or fewer --threads\n";
    let _ = std::io::stderr().write_all(words);
    std::process::exit(2)
}

/// A block of memory that is there.
fn found(block: *mut u8) -> *mut u8 {
    if block.is_null() { exhausted() } else { block }
}

// SAFETY: every call goes to the system's allocator with the layout that came.
unsafe impl GlobalAlloc for Memory {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise is passed on.
        found(unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise is passed on.
        found(unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller's promise is passed on.
        found(unsafe { System.realloc(block, layout, size) })
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static MEMORY: Memory = Memory;

fn main() -> std::process::ExitCode {
    // Mesa's layer that picks a device by the window system complains on stderr where there is none.
    // SAFETY: no other thread runs yet.
    unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    tapline::cli::run()
}
