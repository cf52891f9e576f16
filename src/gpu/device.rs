//! An open device: buffers, kernels, dispatches within the limits, and errors as values.

use crate::base::num;
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;

use bytemuck::{AnyBitPattern, NoUninit};

use super::adapter::{self, Adapter, AdapterFacts};
use super::error::GpuError;

/// Longest time that one submission may take before the device counts as hung. Software drivers take seconds for
/// what a GPU does in milliseconds.
const PATIENCE: Duration = Duration::from_secs(120);

/// The driver's errors since the last look.
#[derive(Default)]
struct Reports {
    lost: Option<String>,
    error: Option<wgpu::Error>,
}

/// An open device with its queue. It has WebGPU's default limits, so that what runs here runs in a browser.
///
/// Every method that talks to the driver returns what went wrong with it, the first cause first. After
/// [`GpuError::Lost`] each further call returns the same.
pub struct Gpu {
    facts: AdapterFacts,
    device: wgpu::Device,
    queue: wgpu::Queue,
    reports: Arc<Mutex<Reports>>,
    anisotropic: bool,
}

/// A compute kernel: one entry point of a module, bindings of group 0 as the shader has them.
pub struct Kernel {
    label: String,
    pipeline: wgpu::ComputePipeline,
}

impl Gpu {
    /// Opens the adapter that `--adapter` names, or the best one.
    ///
    /// # Errors
    ///
    /// No adapter, none or several meant, or no device with the default limits.
    pub fn open(asked: Option<&str>) -> Result<Self, GpuError> {
        Self::of(&adapter::choose(adapter::list(), asked)?)
    }

    /// Opens an adapter, with those optional features that measurements use where they are there: filtering of 32-bit
    /// floats.
    ///
    /// # Errors
    ///
    /// No device with the default limits.
    pub fn of(adapter: &Adapter) -> Result<Self, GpuError> {
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("tapline"),
            required_features: adapter.raw.features() & wgpu::Features::FLOAT32_FILTERABLE,
            required_limits: wgpu::Limits::default(),
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.raw.request_device(&descriptor));
        let (device, queue) = opened.map_err(|e| GpuError::NoDevice {
            adapter: adapter.facts.title(),
            message: e.to_string(),
        })?;
        let reports = Arc::new(Mutex::new(Reports::default()));
        let on_error = Arc::clone(&reports);
        device.on_uncaptured_error(Arc::new(move |error| {
            let mut reports = on_error.lock().unwrap_or_else(PoisonError::into_inner);
            reports.error.get_or_insert(error);
        }));
        let on_loss = Arc::clone(&reports);
        device.set_device_lost_callback(move |reason, message| {
            // The end of this program destroys the device too.
            if reason != wgpu::DeviceLostReason::Destroyed {
                let mut reports = on_loss.lock().unwrap_or_else(PoisonError::into_inner);
                reports.lost.get_or_insert(message);
            }
        });
        Ok(Self {
            facts: adapter.facts.clone(),
            device,
            queue,
            reports,
            anisotropic: adapter.is_anisotropic(),
        })
    }

    /// The adapter.
    #[must_use]
    pub const fn adapter(&self) -> &AdapterFacts {
        &self.facts
    }

    /// The limits of the device: WebGPU's defaults.
    #[must_use]
    pub fn limits(&self) -> wgpu::Limits {
        self.device.limits()
    }

    /// Whether the driver claims to filter anisotropically.
    #[must_use]
    pub const fn is_anisotropic(&self) -> bool {
        self.anisotropic
    }

    /// Whether textures of 32-bit floats can be filtered.
    #[must_use]
    pub fn filters_f32(&self) -> bool {
        self.device.features().contains(wgpu::Features::FLOAT32_FILTERABLE)
    }

    /// Does something with the device and its queue, and returns what the driver reported about it. Everything that the
    /// other methods do not cover goes through here, `doing` names it in errors.
    ///
    /// # Errors
    ///
    /// The driver's report: loss of the device, no memory, a refusal.
    pub fn guarded<T>(
        &self,
        doing: &str,
        work: impl FnOnce(&wgpu::Device, &wgpu::Queue) -> T,
    ) -> Result<T, GpuError> {
        self.check(doing)?;
        let done = work(&self.device, &self.queue);
        self.check(doing)?;
        Ok(done)
    }

    /// The first report since the last look. A loss stays.
    fn check(&self, doing: &str) -> Result<(), GpuError> {
        let mut reports = self.reports.lock().unwrap_or_else(PoisonError::into_inner);
        let adapter = self.facts.title();
        let doing = doing.to_string();
        if let Some(message) = reports.lost.clone() {
            return Err(GpuError::Lost { adapter, doing, message });
        }
        match reports.error.take() {
            None => Ok(()),
            Some(wgpu::Error::OutOfMemory { .. }) => Err(GpuError::OutOfMemory { adapter, doing }),
            Some(error) => Err(GpuError::Refused { adapter, doing, message: error.to_string() }),
        }
    }

    /// Compiles WGSL.
    ///
    /// # Errors
    ///
    /// What is wrong with the source, with its line.
    pub fn module(&self, label: &str, wgsl: &str) -> Result<wgpu::ShaderModule, GpuError> {
        self.guarded(&format!("shader {label}"), |device, _| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(wgsl.into()),
            })
        })
    }

    /// A kernel from an entry point of a module. The layout of its bindings is the shader's own: only bindings that the
    /// entry point uses are there.
    ///
    /// # Errors
    ///
    /// The driver's refusal.
    pub fn compute(
        &self,
        label: &str,
        module: &wgpu::ShaderModule,
        entry: &str,
    ) -> Result<Kernel, GpuError> {
        let pipeline = self.guarded(&format!("kernel {label}"), |device, _| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(label),
                layout: None,
                module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        })?;
        Ok(Kernel { label: label.into(), pipeline })
    }

    /// A storage buffer of zeros that can be written, read back and bound.
    ///
    /// # Errors
    ///
    /// More bytes than a binding may have, or than there is memory.
    pub fn buffer(&self, label: &str, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
        let limits = self.limits();
        for limit in [
            ("maxStorageBufferBindingSize", limits.max_storage_buffer_binding_size),
            ("maxBufferSize", limits.max_buffer_size),
        ] {
            GpuError::within(format!("buffer {label}"), bytes, limit)?;
        }
        let usage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST;
        self.raw_buffer(label, bytes, usage)
    }

    fn raw_buffer(
        &self,
        label: &str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        self.guarded(&format!("buffer {label}"), |device, _| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                // An empty binding is not valid, and copies go by four bytes.
                size: bytes.next_multiple_of(4).max(16),
                usage,
                mapped_at_creation: false,
            })
        })
    }

    /// A storage buffer with contents.
    ///
    /// # Errors
    ///
    /// As [`Gpu::buffer`].
    pub fn upload<T: NoUninit>(&self, label: &str, data: &[T]) -> Result<wgpu::Buffer, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let buffer = self.buffer(label, num::u64(bytes.len()))?;
        self.write(&buffer, data)?;
        Ok(buffer)
    }

    /// A uniform buffer with contents.
    ///
    /// # Errors
    ///
    /// More bytes than a binding may have, or than there is memory.
    pub fn uniform(&self, label: &str, bytes: &[u8]) -> Result<wgpu::Buffer, GpuError> {
        let size = num::u64(bytes.len());
        let most = self.limits().max_uniform_buffer_binding_size;
        GpuError::within(format!("uniform {label}"), size, ("maxUniformBufferBindingSize", most))?;
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let buffer = self.raw_buffer(label, size, usage)?;
        self.write(&buffer, bytes)?;
        Ok(buffer)
    }

    /// Writes to the start of a buffer. The number of bytes must be a multiple of four.
    ///
    /// # Errors
    ///
    /// The driver's error, such as data beyond the buffer's end.
    pub fn write<T: NoUninit>(&self, buffer: &wgpu::Buffer, data: &[T]) -> Result<(), GpuError> {
        self.guarded("an upload", |_, queue| {
            queue.write_buffer(buffer, 0, bytemuck::cast_slice(data));
        })
    }

    /// Items of `bytes` each that one binding holds and one dispatch in workgroups of `workgroup` invocations covers,
    /// one invocation an item. Work is split into batches of at most that many.
    #[must_use]
    pub fn batch(&self, bytes: u64, workgroup: u32) -> usize {
        let limits = self.limits();
        let binding = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let items = binding / bytes.max(1);
        let covered = u64::from(limits.max_compute_workgroups_per_dimension) * u64::from(workgroup);
        num::usize(items.min(covered))
    }

    /// Runs a kernel over `invocations`, in workgroups of `workgroup` (as its source says) along x. The resources are
    /// bindings 0, 1, … of group 0. Invocations are rounded up to whole workgroups: the shader checks its index.
    ///
    /// # Errors
    ///
    /// More workgroups than one dispatch has, or the driver's error.
    pub fn dispatch(
        &self,
        kernel: &Kernel,
        resources: Vec<wgpu::BindingResource<'_>>,
        invocations: usize,
        workgroup: u32,
    ) -> Result<(), GpuError> {
        let most = self.limits().max_compute_workgroups_per_dimension;
        let groups = num::u64(invocations).div_ceil(u64::from(workgroup.max(1)));
        let limit = ("maxComputeWorkgroupsPerDimension", most.into());
        GpuError::within(format!("dispatch of {}", kernel.label), groups, limit)?;
        if groups == 0 {
            return Ok(());
        }
        self.guarded(&format!("dispatch of {}", kernel.label), |device, queue| {
            let layout = kernel.pipeline.get_bind_group_layout(0);
            let bound = bind_group(device, &layout, (0u32..).zip(resources));
            pass(device, queue, &kernel.pipeline, &bound, num::u32(groups));
        })
    }

    /// Waits until everything that was submitted is done.
    ///
    /// # Errors
    ///
    /// A lost or a hung device.
    pub fn wait(&self) -> Result<(), GpuError> {
        let polled = self.guarded("the wait for results", |device, _| {
            device.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(PATIENCE) })
        })?;
        polled.map(|_| ()).map_err(|e| self.lost("the wait for results", &e.to_string()))
    }

    fn lost(&self, doing: &str, message: &str) -> GpuError {
        GpuError::Lost { adapter: self.facts.title(), doing: doing.into(), message: message.into() }
    }

    /// Reads the first `count` items of a buffer, once all that was submitted before is done.
    ///
    /// # Errors
    ///
    /// A lost device, no memory, or items beyond the buffer's end.
    pub fn read<T: AnyBitPattern + NoUninit>(
        &self,
        buffer: &wgpu::Buffer,
        count: usize,
    ) -> Result<Vec<T>, GpuError> {
        let bytes = num::u64(count.saturating_mul(size_of::<T>()));
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = self.raw_buffer("read back", bytes, usage)?;
        self.guarded("a copy", |device, queue| {
            let mut encoder =
                device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes.next_multiple_of(4));
            queue.submit([encoder.finish()]);
        })?;
        let mapped = self.map(&staging)?;
        Ok(bytemuck::allocation::pod_collect_to_vec::<u8, T>(&mapped[..count * size_of::<T>()]))
    }

    /// The bytes of a buffer that was made for reading.
    ///
    /// # Errors
    ///
    /// A lost device.
    pub(crate) fn map(&self, staging: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
        let doing = "reading back";
        let (send, receive) = mpsc::channel();
        staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only when the wait has failed already.
            let _ = send.send(result);
        });
        self.wait()?;
        let answer =
            receive.try_recv().map_err(|_| self.lost(doing, "no answer within the time limit"))?;
        answer.map_err(|e| self.lost(doing, &e.to_string()))?;
        let view =
            staging.slice(..).get_mapped_range().map_err(|e| self.lost(doing, &e.to_string()))?;
        Ok(view.to_vec())
    }
}

/// Submits workgroups of a kernel along x.
pub(crate) fn pass(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    pipeline: &wgpu::ComputePipeline,
    bound: &wgpu::BindGroup,
    groups: u32,
) {
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, bound, &[]);
        pass.dispatch_workgroups(groups, 1, 1);
    }
    queue.submit([encoder.finish()]);
}

/// A group of resources by their bindings.
pub(crate) fn bind_group<'a>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = (u32, wgpu::BindingResource<'a>)>,
) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry<'_>> = resources
        .into_iter()
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}
