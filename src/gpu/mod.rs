//! The GPU's side: adapters, a device whose every failure is a value, buffers and dispatches.
//!
//! [`adapter`] says what is there and chooses; [`Gpu`] is an open device. All work goes through its
//! methods: upload, dispatch, read back, and each returns a [`GpuError`] in place of a panic.
//!
//! ```no_run
//! use tapline::gpu::Gpu;
//!
//! let gpu = Gpu::open(None)?;
//! let module = gpu.module("double", "
//!     @group(0) @binding(0) var<storage, read> from: array<f32>;
//!     @group(0) @binding(1) var<storage, read_write> to: array<f32>;
//!     @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
//!         if id.x < arrayLength(&to) { to[id.x] = 2.0 * from[id.x]; }
//!     }")?;
//! let pipeline = gpu.compute("double", &module, "main")?;
//! let from = gpu.upload("from", &[1.0f32, 2.0, 3.0])?;
//! let to = gpu.buffer("to", 3 * 4)?;
//! gpu.dispatch(&pipeline, vec![from.as_entire_binding(), to.as_entire_binding()], 3, 64)?;
//! assert_eq!(gpu.read::<f32>(&to, 3)?, [2.0, 4.0, 6.0]);
//! # Ok::<(), tapline::gpu::GpuError>(())
//! ```

pub mod adapter;
pub mod device;
pub mod dispatch;
mod error;
pub mod kernels;
pub mod maps;
pub mod policy;
pub mod sampling;

pub use adapter::AdapterFacts;
pub use device::Gpu;
pub use error::GpuError;
