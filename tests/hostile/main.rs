//! Every reader of user data on the committed corpus and on damaged copies of it: an answer or an error with a place and a
//! remedy, never a panic, and memory within what the options allow.
#![expect(clippy::unwrap_used, reason = "tests: a failure is the message")]

use std::path::{Path, PathBuf};

use peak_alloc::PeakAlloc;
use rayon::prelude::*;
use tapline::base::quiet::install_quiet_panic_hook;
use tapline::base::random::Random;
use tapline::cli::untrusted::Reader;
use tapline::error::InputError;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Limit of an image in MiB.
const IMAGE_MB: u64 = 2;
/// Damaged copies of each file.
const DAMAGED: u64 = 60;
/// Bytes that one reader may hold at a time. 2 MiB of 8-bit codes are 8 as binary32, read from a file of at most 8 through a decoder's
/// buffer of 2; level 0 of the cube has at most 8, its chain 4/3 of that, and it is resampled from a copy of the planes (8):
/// 37 MiB. The rest has no images: two engines' tables and a line of at most 1 MiB.
const MOST_BYTES: usize = 37 << 20;

fn folder(reader: Reader) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(reader.name())
}

fn corpus(reader: Reader) -> Vec<(String, Vec<u8>)> {
    let files = std::fs::read_dir(folder(reader)).unwrap();
    let mut files: Vec<_> = files
        .map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, std::fs::read(path).unwrap())
        })
        .collect();
    files.sort();
    files
}

/// A copy with a few bytes changed, cut out, doubled or replaced by extremes.
fn damage(bytes: &[u8], seed: u64) -> Vec<u8> {
    let mut random = Random::new(seed);
    let mut out = bytes.to_vec();
    for _ in 0..=random.below(4) {
        if out.is_empty() {
            return out;
        }
        let at = random.index(out.len());
        let end = (at + 1 + random.index(8)).min(out.len());
        match random.below(6) {
            0 => out[at] ^= 1 << random.below(8),
            1 => out[at..end].fill([0, 0x7f, 0x80, 0xff][random.index(4)]),
            2 => out.truncate(at),
            3 => drop(out.drain(at..end)),
            4 => {
                let copy = out[at..end].to_vec();
                out.splice(at..at, copy);
            }
            _ => {
                let word = *b"-1e999999";
                let count = (end - at).min(word.len());
                out[at..at + count].copy_from_slice(&word[..count]);
            }
        }
    }
    out
}

/// An error that helps.
fn useful(error: &InputError) -> bool {
    let InputError { subject, expected, found, remedy, .. } = error;
    [subject, expected, found, remedy].iter().all(|s| !s.is_empty())
}

#[test]
fn the_corpus_and_damaged_copies_of_it_end_in_an_answer_or_a_helpful_error_within_bounded_memory() {
    install_quiet_panic_hook();
    for reader in Reader::ALL {
        let name = reader.name();
        let files = corpus(reader);
        let good: Vec<_> = files
            .iter()
            .filter(|(_, bytes)| reader.read(bytes, IMAGE_MB).is_ok())
            .map(|(file, _)| file.clone())
            .collect();
        let refused = files.len() - good.len();
        assert!(
            good.len() >= 2 && refused >= 2,
            "{name}: a corpus needs both kinds: {good:?} of {}",
            files.len()
        );
        // One reader at a time: what is counted is its own.
        let mut worst = (0, String::new());
        for (file, bytes) in &files {
            let before = MEMORY.current_usage();
            MEMORY.reset_peak_usage();
            let result = reader.read(bytes, IMAGE_MB);
            worst = worst.max((MEMORY.peak_usage() - before, file.clone()));
            assert!(result.as_ref().err().is_none_or(useful), "{name}/{file}: {result:?}");
        }
        assert!(worst.0 <= MOST_BYTES, "{name}: {worst:?}");
        println!(
            "{name}: {} files, {} of them good, at most {} KiB ({})",
            files.len(),
            good.len(),
            worst.0 >> 10,
            worst.1
        );
        let answered: usize = files
            .par_iter()
            .enumerate()
            .map(|(k, (file, bytes))| {
                let copies = (0..DAMAGED).map(|seed| {
                    let seed = seed << 32 | u64::try_from(k).unwrap();
                    let bytes = damage(bytes, seed);
                    let result = std::panic::catch_unwind(|| reader.read(&bytes, IMAGE_MB));
                    let result = result.unwrap_or_else(|_| {
                        let kept = std::env::temp_dir().join(format!("tapline-{name}-{seed:x}"));
                        std::fs::write(&kept, &bytes).unwrap();
                        panic!(
                            "{name}/{file} damaged by {seed:#x}: a panic; the bytes are in {}",
                            kept.display()
                        )
                    });
                    assert!(
                        result.as_ref().err().is_none_or(useful),
                        "{name}/{file} {seed:#x}: {result:?}"
                    );
                    usize::from(result.is_ok())
                });
                copies.sum::<usize>()
            })
            .sum();
        let copies = files.len() * usize::try_from(DAMAGED).unwrap();
        assert!(answered < copies, "{name}: no damage was ever noticed");
    }
}

#[test]
fn every_folder_of_the_corpus_has_a_reader_and_no_file_is_large() {
    let root = folder(Reader::Unit).parent().unwrap().to_path_buf();
    for entry in std::fs::read_dir(root).unwrap() {
        let name = entry.unwrap().file_name();
        assert!(Reader::ALL.iter().any(|r| r.name() == name.to_string_lossy()), "{name:?}");
    }
    for reader in Reader::ALL {
        for (file, bytes) in corpus(reader) {
            assert!(bytes.len() <= 64 << 10, "{}/{file}", reader.name());
        }
    }
}
