//! Decoder faults that are caught and reported as errors leave no panic message on stderr.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

thread_local! {
    static QUIET: Cell<u32> = const { Cell::new(0) };
}

/// Installs, once, a panic hook that stays silent while a decoder runs under guard on the
/// panicking thread and otherwise calls the hook that was there before.
///
/// For the binary's `main`; the library never changes the hook by itself.
pub fn install_quiet_panic_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if QUIET.get() == 0 {
                before(info);
            }
        }));
    });
}

/// Runs a decoder and returns its panic's message as text instead of unwinding further.
///
/// The closure's captured state must not be used after an error; the callers drop it.
pub(crate) fn guarded<T>(decode: impl FnOnce() -> T) -> Result<T, String> {
    QUIET.set(QUIET.get() + 1);
    let result = catch_unwind(AssertUnwindSafe(decode));
    QUIET.set(QUIET.get() - 1);
    result.map_err(|payload| {
        let text = payload
            .downcast_ref::<String>()
            .cloned()
            .or_else(|| payload.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        format!("a fault in the decoder ({})", text.unwrap_or_else(|| "no message".to_owned()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_under_guard_becomes_text_and_the_thread_is_loud_again_afterwards() {
        install_quiet_panic_hook();
        let found: Result<(), String> = guarded(|| panic!("bad block {}", 7));
        assert_eq!(found.unwrap_err(), "a fault in the decoder (bad block 7)");
        assert_eq!(QUIET.get(), 0);
        assert_eq!(guarded(|| 3), Ok(3));
    }
}
