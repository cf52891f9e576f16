//! Ctrl-C and its kin leave no temporaries behind.
//!
//! A thread waits for SIGINT, SIGTERM and SIGHUP, removes what is on record and then lets the signal
//! have its usual effect, so that a shell sees what ended the command. A signal that the parent chose to
//! ignore (`nohup`) stays ignored. On systems without these signals temporaries named `.tapline-*.tmp`
//! may stay.

#[cfg(unix)]
pub(super) fn install() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|s| !ignored(*s));
    // Registered by the thread itself: if it cannot start, the signals keep their usual effect. The
    // command goes on once that is done, so that no temporary is older.
    let (registered, ready) = std::sync::mpsc::channel::<()>();
    let handler = move || {
        let Ok(mut signals) = signal_hook::iterator::Signals::new(wanted) else {
            return;
        };
        drop(registered);
        if let Some(signal) = signals.forever().next() {
            let _until_the_end = crate::image::temporary::remove_all();
            let _ = signal_hook::low_level::emulate_default_handler(signal);
            std::process::exit(128 + signal);
        }
    };
    let started = std::thread::Builder::new().name("signals".into()).spawn(handler);
    if started.is_ok() {
        // Ends when the thread lets go of its end, which is an error by design.
        let _ = ready.recv();
    }
}

#[cfg(not(unix))]
pub(super) fn install() {}

/// Whether this process ignores a signal; false where the system does not say.
#[cfg(unix)]
fn ignored(signal: i32) -> bool {
    std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|text| {
            let mask = text.lines().find_map(|l| l.strip_prefix("SigIgn:"))?;
            u64::from_str_radix(mask.trim(), 16).ok()
        })
        .is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
