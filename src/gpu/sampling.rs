//! The device's own sampler as a [`TextureUnit`].

use std::collections::HashMap;

use half::f16;

use super::device::{Gpu, Kernel, bind_group};
use super::error::GpuError;
use crate::base::num;
use crate::error::InputError;
use crate::sampler::{Format, Image, Query, Shape, Source, State, TextureUnit};

/// Invocations of a workgroup, as the shader says.
const WORKGROUP: u32 = 64;
/// Quads in a row of the target.
const QUADS: u32 = 64;
/// Bytes of a pixel of the target.
const PIXEL: u32 = 16;

/// Kernels and samplers of a device, made when they are first needed.
pub struct DeviceSampler<'a> {
    gpu: &'a Gpu,
    kernels: HashMap<(Shape, Source), Kernel>,
    quads: HashMap<Shape, wgpu::RenderPipeline>,
    samplers: HashMap<State, wgpu::Sampler>,
}

impl<'a> DeviceSampler<'a> {
    /// The samplers of an open device.
    #[must_use]
    pub fn new(gpu: &'a Gpu) -> Self {
        Self { gpu, kernels: HashMap::new(), quads: HashMap::new(), samplers: HashMap::new() }
    }

    fn module(&self, shape: Shape) -> Result<wgpu::ShaderModule, GpuError> {
        let (image, coord) = match shape {
            Shape::Planar => ("texture_2d<f32>", "xy"),
            Shape::Cube => ("texture_cube<f32>", "xyz"),
        };
        let source = include_str!("sampling.wgsl").replace("IMAGE", image).replace("COORD", coord);
        self.gpu.module("sampling", &source)
    }

    fn prepare_kernel(&mut self, shape: Shape, source: Source) -> Result<(), GpuError> {
        if self.kernels.contains_key(&(shape, source)) {
            return Ok(());
        }
        let entry = if source == Source::Level { "level" } else { "gradient" };
        let kernel = self.gpu.compute(entry, &self.module(shape)?, entry)?;
        self.kernels.insert((shape, source), kernel);
        Ok(())
    }

    fn prepare_quads(&mut self, shape: Shape) -> Result<(), GpuError> {
        if self.quads.contains_key(&shape) {
            return Ok(());
        }
        let module = self.module(shape)?;
        let pipeline = self.gpu.guarded("the pipeline of quads", |device, _| {
            let options = wgpu::PipelineCompilationOptions::default();
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("quads"),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("corner"),
                    compilation_options: options.clone(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("quad"),
                    compilation_options: options,
                    targets: &[Some(wgpu::TextureFormat::Rgba32Float.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        self.quads.insert(shape, pipeline);
        Ok(())
    }

    fn prepare_sampler(&mut self, state: State) -> Result<(), GpuError> {
        if self.samplers.contains_key(&state) {
            return Ok(());
        }
        if state.anisotropy > 1 && !self.gpu.is_anisotropic() {
            return Err(GpuError::Unsupported {
                adapter: self.gpu.adapter().title(),
                doing: format!("anisotropy_clamp {}", state.anisotropy),
                lacks: "anisotropic filtering".into(),
            });
        }
        let mode = |linear| {
            if linear { wgpu::FilterMode::Linear } else { wgpu::FilterMode::Nearest }
        };
        let sampler = self.gpu.guarded("a sampler", |device, _| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("fingerprint"),
                mag_filter: mode(state.linear),
                min_filter: mode(state.linear),
                mipmap_filter: if state.linear_mips {
                    wgpu::MipmapFilterMode::Linear
                } else {
                    wgpu::MipmapFilterMode::Nearest
                },
                anisotropy_clamp: state.anisotropy,
                ..wgpu::SamplerDescriptor::default()
            })
        })?;
        self.samplers.insert(state, sampler);
        Ok(())
    }

    /// Uploads a texture.
    ///
    /// # Errors
    ///
    /// A texture beyond the device's limits, or no memory.
    pub fn upload(&self, image: &Image) -> Result<wgpu::TextureView, GpuError> {
        let side = num::u32(image.size);
        let most = self.gpu.limits().max_texture_dimension_2d;
        GpuError::within("a texture", side.into(), ("maxTextureDimension2D", most.into()))?;
        let faces = if image.shape == Shape::Cube { 6 } else { 1 };
        self.gpu.guarded("a texture", |device, queue| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("fingerprint"),
                size: extent(side, faces),
                mip_level_count: num::u32(image.levels.len()),
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: match image.format {
                    Format::Unorm8 => wgpu::TextureFormat::Rgba8Unorm,
                    Format::Half => wgpu::TextureFormat::Rgba16Float,
                    Format::Float => wgpu::TextureFormat::Rgba32Float,
                },
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            for (mip_level, texels) in (0u32..).zip(&image.levels) {
                let bytes = encode(image.format, texels);
                let side = (side >> mip_level).max(1);
                queue.write_texture(
                    wgpu::TexelCopyTextureInfo {
                        texture: &texture,
                        mip_level,
                        origin: wgpu::Origin3d::ZERO,
                        aspect: wgpu::TextureAspect::All,
                    },
                    &bytes,
                    wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: u32::try_from(bytes.len()).ok().map(|n| n / (side * faces)),
                        rows_per_image: Some(side),
                    },
                    extent(side, faces),
                );
            }
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(match image.shape {
                    Shape::Planar => wgpu::TextureViewDimension::D2,
                    Shape::Cube => wgpu::TextureViewDimension::Cube,
                }),
                ..wgpu::TextureViewDescriptor::default()
            })
        })
    }

    /// Queries on a texture that is there already.
    pub fn sample_view(
        &mut self,
        view: &wgpu::TextureView,
        shape: Shape,
        state: State,
        source: Source,
        queries: &[Query],
    ) -> Result<Vec<[f32; 4]>, GpuError> {
        self.prepare_sampler(state)?;
        if source == Source::Quad {
            self.prepare_quads(shape)?;
        } else {
            self.prepare_kernel(shape, source)?;
        }
        // A row of quads is two rows of pixels; the target's height is limited.
        let rows = num::usize(self.gpu.limits().max_texture_dimension_2d / 2);
        let most = match source {
            Source::Quad => rows * QUADS as usize,
            Source::Level | Source::Gradient => self.gpu.batch(48, WORKGROUP),
        };
        let mut colors = Vec::with_capacity(queries.len());
        for queries in queries.chunks(most.max(1)) {
            let words: Vec<[f32; 12]> = queries.iter().map(words).collect();
            let buffer = self.gpu.upload("queries", &words)?;
            if source == Source::Quad {
                colors.extend(self.sample_quads(view, shape, state, &buffer, queries.len())?);
                continue;
            }
            let out = self.gpu.buffer("colors", 16 * num::u64(queries.len()))?;
            let resources = vec![
                buffer.as_entire_binding(),
                out.as_entire_binding(),
                wgpu::BindingResource::TextureView(view),
                wgpu::BindingResource::Sampler(&self.samplers[&state]),
            ];
            let kernel = &self.kernels[&(shape, source)];
            self.gpu.dispatch(kernel, resources, queries.len(), WORKGROUP)?;
            colors.extend(self.gpu.read::<[f32; 4]>(&out, queries.len())?);
        }
        Ok(colors)
    }

    /// Draws a quad for each query and reads its upper left pixel.
    fn sample_quads(
        &self,
        view: &wgpu::TextureView,
        shape: Shape,
        state: State,
        queries: &wgpu::Buffer,
        count: usize,
    ) -> Result<Vec<[f32; 4]>, GpuError> {
        let rows = num::u32(count.div_ceil(QUADS as usize));
        let size = wgpu::Extent3d { width: 2 * QUADS, height: 2 * rows, depth_or_array_layers: 1 };
        let bytes = u64::from(size.width) * u64::from(size.height) * u64::from(PIXEL);
        let staging = self.gpu.guarded("a picture of quads", |device, queue| {
            let target = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("quads"),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba32Float,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            });
            let staging = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("quads"),
                size: bytes,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let pipeline = &self.quads[&shape];
            let entries = [
                (0, queries.as_entire_binding()),
                (2, wgpu::BindingResource::TextureView(view)),
                (3, wgpu::BindingResource::Sampler(&self.samplers[&state])),
            ];
            let bound = bind_group(device, &pipeline.get_bind_group_layout(0), entries);
            let mut encoder =
                device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let shown = target.create_view(&wgpu::TextureViewDescriptor::default());
            {
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("quads"),
                    color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                        view: &shown,
                        depth_slice: None,
                        resolve_target: None,
                        ops: wgpu::Operations::default(),
                    })],
                    ..wgpu::RenderPassDescriptor::default()
                });
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, &bound, &[]);
                pass.draw(0..6, 0..num::u32(count));
            }
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(size.width * PIXEL),
                rows_per_image: Some(size.height),
            };
            let to = wgpu::TexelCopyBufferInfo { buffer: &staging, layout };
            encoder.copy_texture_to_buffer(target.as_image_copy(), to, size);
            queue.submit([encoder.finish()]);
            staging
        })?;
        let pixels: Vec<[f32; 4]> =
            bytemuck::allocation::pod_collect_to_vec(&self.gpu.map(&staging)?);
        let quads = QUADS as usize;
        let place = |i: usize| 4 * quads * (i / quads) + 2 * (i % quads);
        Ok((0..count).map(|i| pixels[place(i)]).collect())
    }
}

impl TextureUnit for DeviceSampler<'_> {
    fn sample(
        &mut self,
        image: &Image,
        state: State,
        source: Source,
        queries: &[Query],
    ) -> Result<Vec<[f32; 4]>, InputError> {
        let view = self.upload(image)?;
        Ok(self.sample_view(&view, image.shape, state, source, queries)?)
    }

    fn filters(&self, format: Format) -> bool {
        format != Format::Float || self.gpu.filters_f32()
    }

    fn is_anisotropic(&self) -> bool {
        self.gpu.is_anisotropic()
    }
}

const fn extent(side: u32, faces: u32) -> wgpu::Extent3d {
    wgpu::Extent3d { width: side, height: side, depth_or_array_layers: faces }
}

fn words(query: &Query) -> [f32; 12] {
    let ([x, y, z], [a, b, c], [d, e, f]) = (query.at, query.dx, query.dy);
    [x, y, z, query.lod, a, b, c, 0.0, d, e, f, 0.0]
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the value lies in 0…255"
)]
fn encode(format: Format, texels: &[[f32; 4]]) -> Vec<u8> {
    let components = texels.iter().flatten();
    match format {
        Format::Unorm8 => components.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8).collect(),
        Format::Half => components.flat_map(|c| f16::from_f32(*c).to_le_bytes()).collect(),
        Format::Float => components.flat_map(|c| c.to_le_bytes()).collect(),
    }
}
