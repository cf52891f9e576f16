//! Any stage, or a whole operation, bit-exactly behind a C interface: for C test benches, and for SystemVerilog through
//! DPI-C. `include/tapline.h` declares it for C, `include/tapline_dpi_pkg.sv` for SystemVerilog.
//!
//! A bench holds a row of numbers in and a row of numbers out, in the order of the fields that
//! `tapline vectors header` declares. Nothing here panics across the interface: what goes wrong is a status, and
//! [`tapline_error`] has the words.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};

use tapline::conformance::subject::Subject;
use tapline::conformance::{Build, Device as _, Harness, harness};
use tapline::unit::file;

/// A stage or an operation of a unit, with the numbers of one case.
pub struct Bench {
    model: Harness,
    input: Vec<i64>,
    output: Vec<i64>,
    ranges: Vec<[i64; 2]>,
}

thread_local! {
    static ERROR: RefCell<CString> = RefCell::default();
}

fn fail(text: &str) {
    let clean: String = text.chars().filter(|c| *c != '\0').collect();
    ERROR.with(|e| *e.borrow_mut() = CString::new(clean).unwrap_or_default());
}

/// A string that a caller may leave out.
///
/// # Safety
/// `text` is null, or ends with a zero byte and stays as it is during the call.
unsafe fn optional<'a>(text: *const c_char) -> Option<&'a str> {
    if text.is_null() {
        return None;
    }
    // SAFETY: the caller's promise.
    let text = unsafe { CStr::from_ptr(text) }.to_str().ok()?;
    (!text.is_empty()).then_some(text)
}

impl Bench {
    fn open(subject: Option<&str>, unit: Option<&str>, build: Build) -> Result<Self, String> {
        let subject = Subject::parse(subject.unwrap_or("")).map_err(|e| e.to_string())?;
        let (spec, _) = file::load(unit, &[]).map_err(|e| e.to_string())?;
        let model = harness(&spec, subject, build).map_err(|e| e.to_string())?;
        let shape = model.shape();
        let inputs = shape.input_len();
        let ranges = shape.numbers().take(inputs).map(|(f, _)| f.range).collect();
        Ok(Self { input: vec![0; inputs], output: vec![0; shape.output_len()], ranges, model })
    }

    /// Runs the case in `input`; its number where one is outside of its field.
    fn run(&mut self) -> Result<(), usize> {
        for (k, (number, [low, high])) in self.input.iter().zip(&self.ranges).enumerate() {
            if !(low..=high).contains(&number) {
                return Err(k);
            }
        }
        self.model.run(&self.input, &mut self.output);
        Ok(())
    }
}

/// Opens a stage (or `unit`, `unit-hit`, `unit-tex`) of a unit: a file, `preset:NAME`, or null or "" for the default one.
/// `plain` builds it without bump and roughness; `size` is that of the memories' faces. Null where it fails.
///
/// # Safety
/// `subject` and `unit` are null or strings that end with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tapline_open(
    subject: *const c_char,
    unit: *const c_char,
    plain: c_int,
    size: c_int,
) -> *mut Bench {
    // SAFETY: the caller's promise.
    let (subject, unit) = unsafe { (optional(subject), optional(unit)) };
    let build = Build {
        bump: plain == 0,
        rough: plain == 0,
        size: u32::try_from(size).unwrap_or(0).clamp(1, 1024),
    };
    match catch_unwind(|| Bench::open(subject, unit, build)) {
        Ok(Ok(bench)) => Box::into_raw(Box::new(bench)),
        Ok(Err(why)) => {
            fail(&why);
            std::ptr::null_mut()
        }
        Err(_) => {
            fail("a defect of the model");
            std::ptr::null_mut()
        }
    }
}

/// Closes a bench; null does nothing.
///
/// # Safety
/// `bench` is null or came from [`tapline_open`] and was not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tapline_close(bench: *mut Bench) {
    if !bench.is_null() {
        // SAFETY: it was made by `Box::into_raw`, and the caller promises that it was not closed.
        drop(unsafe { Box::from_raw(bench) });
    }
}

/// Numbers in; 0 for null.
///
/// # Safety
/// `bench` is null or open.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tapline_inputs(bench: *const Bench) -> c_int {
    // SAFETY: the caller's promise.
    unsafe { bench.as_ref() }.map_or(0, |b| c_int::try_from(b.input.len()).unwrap_or(0))
}

/// Numbers out; 0 for null.
///
/// # Safety
/// `bench` is null or open.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tapline_outputs(bench: *const Bench) -> c_int {
    // SAFETY: the caller's promise.
    unsafe { bench.as_ref() }.map_or(0, |b| c_int::try_from(b.output.len()).unwrap_or(0))
}

/// Sets number `index` of the inputs; nothing happens outside of them.
///
/// # Safety
/// `bench` is null or open, and no other thread uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tapline_set(bench: *mut Bench, index: c_int, number: i64) {
    // SAFETY: the caller's promise.
    if let Some(bench) = unsafe { bench.as_mut() }
        && let Ok(index) = usize::try_from(index)
        && let Some(slot) = bench.input.get_mut(index)
    {
        *slot = number;
    }
}

/// Number `index` of the outputs; 0 outside of them.
///
/// # Safety
/// `bench` is null or open.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tapline_get(bench: *const Bench, index: c_int) -> i64 {
    // SAFETY: the caller's promise.
    let bench = unsafe { bench.as_ref() };
    let index = usize::try_from(index).unwrap_or(usize::MAX);
    bench.and_then(|b| b.output.get(index).copied()).unwrap_or(0)
}

/// Runs the case that was set: 0, or −1 with words in [`tapline_error`].
///
/// # Safety
/// `bench` is null or open, and no other thread uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tapline_eval(bench: *mut Bench) -> c_int {
    // SAFETY: the caller's promise.
    let Some(bench) = (unsafe { bench.as_mut() }) else {
        fail("no bench");
        return -1;
    };
    match catch_unwind(AssertUnwindSafe(|| bench.run())) {
        Ok(Ok(())) => 0,
        Ok(Err(k)) => {
            let [low, high] = bench.ranges[k];
            fail(&format!("input {k} is {}, not from {low} to {high}", bench.input[k]));
            -1
        }
        Err(_) => {
            fail("a defect of the model");
            -1
        }
    }
}

/// Runs a case from `input` to `output`, which hold as many numbers as [`tapline_inputs`] and [`tapline_outputs`] say.
///
/// # Safety
/// `bench` is null or open, and no other thread uses it; the arrays are as long as that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tapline_run(
    bench: *mut Bench,
    input: *const i64,
    output: *mut i64,
) -> c_int {
    // SAFETY: the caller's promise.
    if let Some(bench) = unsafe { bench.as_mut() }
        && !input.is_null()
        && !output.is_null()
    {
        // SAFETY: the caller's promise about its length.
        let from = unsafe { std::slice::from_raw_parts(input, bench.input.len()) };
        bench.input.copy_from_slice(from);
        // SAFETY: an open bench.
        let status = unsafe { tapline_eval(bench) };
        if status == 0 {
            // SAFETY: the caller's promise about its length.
            let to = unsafe { std::slice::from_raw_parts_mut(output, bench.output.len()) };
            to.copy_from_slice(&bench.output);
        }
        return status;
    }
    fail("no bench, or no arrays");
    -1
}

/// Words about the last failure on this thread; they stay until the next one.
#[unsafe(no_mangle)]
pub extern "C" fn tapline_error() -> *const c_char {
    ERROR.with(|e| e.borrow().as_ptr())
}

/// The version, `MAJOR.MINOR.PATCH`.
#[unsafe(no_mangle)]
pub extern "C" fn tapline_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
