//! Fragments through a kernel, in batches that fit the device's limits.

use super::device::{bind_group, pass};
use super::kernels::Kernel;
use super::maps::Maps;
use super::{Gpu, GpuError};
use crate::base::num;

/// Invocations of a workgroup, as the kernels say.
const WORKGROUP: u32 = 64;
/// Most fragments of a batch, so that progress shows and no driver takes one submission for a hang.
const MOST: usize = 1 << 17;

/// A compiled kernel.
pub struct Program {
    name: &'static str,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

/// Words of one fragment's operands and of its results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    /// Operands.
    pub input: usize,
    /// Results.
    pub output: usize,
}

/// A batch on the device: operands uploaded, room for the results.
pub struct Batch {
    words: Words,
    fragments: usize,
    bound: wgpu::BindGroup,
    output: wgpu::Buffer,
}

impl Program {
    /// Compiles a kernel.
    ///
    /// # Errors
    ///
    /// The driver's refusal.
    pub fn new(gpu: &Gpu, kernel: Kernel) -> Result<Self, GpuError> {
        let name = kernel.name();
        let module = gpu.module(name, &kernel.source())?;
        let entries: Vec<wgpu::BindGroupLayoutEntry> =
            (0u32..).zip(bindings()).map(entry).collect();
        let (layout, pipeline) = gpu.guarded(&format!("kernel {name}"), |device, _| {
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(name),
                entries: &entries,
            });
            let whole = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(name),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&whole),
                module: &module,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            (layout, pipeline)
        })?;
        Ok(Self { name, layout, pipeline })
    }

    /// Most fragments of a batch.
    #[must_use]
    pub fn batch(gpu: &Gpu, words: Words) -> usize {
        let bytes = num::u64(4 * words.input.max(words.output));
        gpu.batch(bytes, WORKGROUP).clamp(1, MOST)
    }

    /// Runs the kernel over one fragment of zeros: drivers compile on first use.
    pub fn warm(&self, maps: &Maps<'_>, words: Words) -> Result<(), GpuError> {
        self.run(maps, words, (&vec![0; words.input], &[]), &|_| {}).map(|_| ())
    }

    /// Uploads the operands of a batch.
    ///
    /// # Errors
    ///
    /// More than the device takes, or the driver's error.
    pub fn upload(
        &self,
        maps: &Maps<'_>,
        words: Words,
        input: &[u32],
        steps: &[f32],
    ) -> Result<Batch, GpuError> {
        let gpu = maps.gpu;
        let fragments = input.len() / words.input.max(1);
        let mut policy = maps.policy.clone();
        policy.fragments = num::u32(fragments);
        policy.input_words = num::u32(words.input);
        policy.output_words = num::u32(words.output);
        let uniform = gpu.uniform("policy", &policy.bytes())?;
        let input = gpu.upload("operands", input)?;
        let output = gpu.buffer("results", num::u64(4 * fragments * words.output))?;
        let steps = gpu.upload("steps", if steps.is_empty() { &[0.0] } else { steps })?;
        let bound = gpu.guarded(&format!("the bindings of {}", self.name), |device, _| {
            let resources = vec![
                uniform.as_entire_binding(),
                input.as_entire_binding(),
                output.as_entire_binding(),
                wgpu::BindingResource::TextureView(&maps.texels),
                wgpu::BindingResource::TextureView(&maps.distances),
                maps.tables.as_entire_binding(),
                steps.as_entire_binding(),
            ];
            bind_group(device, &self.layout, (0u32..).zip(resources))
        })?;
        Ok(Batch { words, fragments, bound, output })
    }

    /// Runs the kernel over a batch, without waiting.
    pub fn dispatch(&self, gpu: &Gpu, batch: &Batch) -> Result<(), GpuError> {
        let groups = num::u32(batch.fragments).div_ceil(WORKGROUP);
        gpu.guarded(&format!("dispatch of {}", self.name), |device, queue| {
            pass(device, queue, &self.pipeline, &batch.bound, groups);
        })
    }

    /// All fragments through the kernel; `done` is told how many a batch had.
    pub fn run(
        &self,
        maps: &Maps<'_>,
        words: Words,
        (input, steps): (&[u32], &[f32]),
        done: &dyn Fn(u64),
    ) -> Result<Vec<u32>, GpuError> {
        let fragments = input.len() / words.input.max(1);
        let mut out = Vec::with_capacity(fragments * words.output);
        for part in input.chunks(words.input * Self::batch(maps.gpu, words)) {
            let batch = self.upload(maps, words, part, steps)?;
            self.dispatch(maps.gpu, &batch)?;
            out.extend(batch.read(maps.gpu)?);
            done(num::u64(part.len() / words.input));
        }
        Ok(out)
    }
}

impl Batch {
    /// The results, once they are there.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u32>, GpuError> {
        gpu.read(&self.output, self.fragments * self.words.output)
    }
}

/// Bindings 0, 1, … of `kernels/ports.wgsl`.
fn bindings() -> [wgpu::BindingType; 7] {
    let buffer =
        |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let read = buffer(wgpu::BufferBindingType::Storage { read_only: true });
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2Array,
        multisampled: false,
    };
    [
        buffer(wgpu::BufferBindingType::Uniform),
        read,
        buffer(wgpu::BufferBindingType::Storage { read_only: false }),
        texture,
        texture,
        read,
        read,
    ]
}

fn entry((binding, ty): (u32, wgpu::BindingType)) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None }
}
