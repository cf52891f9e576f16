//! Fuzzes one reader of user data, named by the variable `TAPLINE_READER`.
#![no_main]

use std::sync::OnceLock;

use libfuzzer_sys::fuzz_target;
use tapline::base::quiet::install_quiet_panic_hook;
use tapline::cli::untrusted::Reader;

static READER: OnceLock<Reader> = OnceLock::new();

fuzz_target!(|bytes: &[u8]| {
    let reader = READER.get_or_init(|| {
        // A decoder's panic that is caught and reported is no finding.
        install_quiet_panic_hook();
        let name = std::env::var("TAPLINE_READER").unwrap_or_default();
        let found = Reader::ALL.into_iter().find(|r| r.name() == name);
        found.unwrap_or_else(|| {
            let names: Vec<_> = Reader::ALL.iter().map(|r| r.name()).collect();
            eprintln!("set TAPLINE_READER to one of {}", names.join(", "));
            std::process::exit(2)
        })
    });
    let _ = reader.read(bytes, 2);
});
