//! Maps on the device: colours and distances as array textures, tables as storage buffers, and the policy that knows
//! their sizes.

use super::policy::{Policy, Tables};
use super::{Gpu, GpuError};
use crate::base::num;
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::planar::PlanarMap;
use crate::policy::FootprintRule;
use crate::settings::Settings;

/// What kernels read in addition to their operands: maps, tables, and the uniform that says how large they are.
pub struct Maps<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// The uniform.
    pub policy: Policy,
    pub(super) texels: wgpu::TextureView,
    pub(super) distances: wgpu::TextureView,
    pub(super) tables: wgpu::Buffer,
}

/// One level of one layer: columns, rows and the texels' bytes.
struct Layer {
    level: usize,
    layer: usize,
    size: [usize; 2],
    bytes: Vec<u8>,
}

fn wide(texels: &[[f32; 3]]) -> Vec<u8> {
    let rgba = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
    texels.iter().flat_map(|t| rgba(*t)).flat_map(f32::to_le_bytes).collect()
}

impl<'a> Maps<'a> {
    /// The tables of some settings and no maps: one black texel, no walls.
    ///
    /// # Errors
    ///
    /// More tables than a binding may have, or the driver's error.
    pub fn new(gpu: &'a Gpu, settings: &Settings, tables: &Tables) -> Result<Self, GpuError> {
        let policy = settings.policy.footprint.policy;
        if policy != FootprintRule::Paper {
            let (path, value) = ("footprint.policy", policy.name());
            return Err(GpuError::NoPolicy { path, expected: "paper", value });
        }
        let black = [Layer { level: 0, layer: 0, size: [1, 1], bytes: wide(&[[0.0; 3]]) }];
        let words = tables.words();
        Ok(Self {
            gpu,
            policy: Policy::new(settings, tables),
            texels: texture(gpu, "texels", wgpu::TextureFormat::Rgba32Float, &black)?,
            distances: distances(gpu, &Distance::nothing())?,
            tables: gpu.upload("tables", if words.is_empty() { &[0.0] } else { &words })?,
        })
    }

    /// With the faces of a cube map as six layers.
    ///
    /// # Errors
    ///
    /// A larger map than a texture may be, or the driver's error.
    pub fn with_cube(mut self, map: &CubeMap) -> Result<Self, GpuError> {
        let layers: Vec<Layer> = map
            .levels
            .iter()
            .enumerate()
            .flat_map(|(level, from)| {
                let size = from.size;
                from.texels.chunks(size * size).enumerate().map(move |(layer, texels)| Layer {
                    level,
                    layer,
                    size: [size; 2],
                    bytes: wide(texels),
                })
            })
            .collect();
        self.texels = texture(self.gpu, "environment", wgpu::TextureFormat::Rgba32Float, &layers)?;
        self.policy = self.policy.with_size([map.size(); 2], map.levels.len());
        Ok(self)
    }

    /// With a 2-D texture as one layer.
    ///
    /// # Errors
    ///
    /// As [`Maps::with_cube`].
    pub fn with_planar(mut self, map: &PlanarMap) -> Result<Self, GpuError> {
        let levels = map.levels.iter().enumerate();
        let layers: Vec<Layer> = levels
            .map(|(level, from)| Layer {
                level,
                layer: 0,
                size: from.size,
                bytes: wide(&from.texels),
            })
            .collect();
        self.texels = texture(self.gpu, "texture", wgpu::TextureFormat::Rgba32Float, &layers)?;
        self.policy = self.policy.with_size(map.size(), map.levels.len());
        Ok(self)
    }

    /// With a map of distances; an infinite one becomes −1.
    ///
    /// # Errors
    ///
    /// As [`Maps::with_cube`].
    pub fn with_distance(mut self, distance: &Distance) -> Result<Self, GpuError> {
        self.distances = distances(self.gpu, distance)?;
        self.policy = self.policy.with_distance(distance);
        Ok(self)
    }
}

fn distances(gpu: &Gpu, distance: &Distance) -> Result<wgpu::TextureView, GpuError> {
    let Distance::Cube(cube) = distance else {
        // Walls that a formula gives have no texels.
        return distances(gpu, &Distance::nothing());
    };
    let shown = |x: f32| if x.is_finite() { x } else { -1.0 };
    let faces = cube.texels.chunks(cube.size * cube.size).enumerate();
    let layers: Vec<Layer> = faces
        .map(|(layer, texels)| Layer {
            level: 0,
            layer,
            size: [cube.size; 2],
            bytes: texels.iter().flat_map(|x| shown(*x).to_le_bytes()).collect(),
        })
        .collect();
    texture(gpu, "distances", wgpu::TextureFormat::R32Float, &layers)
}

/// An array texture whose layers have their levels.
fn texture(
    gpu: &Gpu,
    label: &str,
    format: wgpu::TextureFormat,
    layers: &[Layer],
) -> Result<wgpu::TextureView, GpuError> {
    let size = layers.first().map_or([1, 1], |l| l.size);
    let most = gpu.limits().max_texture_dimension_2d;
    let largest = num::u32(size[0].max(size[1]));
    let limit = ("maxTextureDimension2D", most.into());
    GpuError::within(format!("texture {label}"), largest.into(), limit)?;
    let count = |of: fn(&Layer) -> usize| num::u32(layers.iter().map(of).max().unwrap_or(0) + 1);
    let extent = wgpu::Extent3d {
        width: num::u32(size[0]),
        height: num::u32(size[1]),
        depth_or_array_layers: count(|l| l.layer),
    };
    let made = gpu.guarded(&format!("texture {label}"), |device, queue| {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: extent,
            mip_level_count: count(|l| l.level),
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for layer in layers {
            write(queue, &texture, layer);
        }
        texture
    })?;
    Ok(made.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..wgpu::TextureViewDescriptor::default()
    }))
}

fn write(queue: &wgpu::Queue, texture: &wgpu::Texture, layer: &Layer) {
    let [columns, rows] = layer.size.map(num::u32);
    let row = layer.bytes.len() / layer.size[1].max(1);
    queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: num::u32(layer.level),
            origin: wgpu::Origin3d { x: 0, y: 0, z: num::u32(layer.layer) },
            aspect: wgpu::TextureAspect::All,
        },
        &layer.bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(num::u32(row)),
            rows_per_image: Some(rows),
        },
        wgpu::Extent3d { width: columns, height: rows, depth_or_array_layers: 1 },
    );
}
