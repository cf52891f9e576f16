//! The checks of the stages from `covariance` on, which all operations share.

use super::cases::{Cases, Operand as _};
use super::probes::{address_expected, color, cube_probe, planar_probe};
use super::{Bounded, Case, Checker, Expected, number};
use crate::base::num;
use crate::cube::CubeMap;
use crate::distance::Distance;
use crate::engine::gpu::tables;
use crate::gpu::kernels::Kernel;
use crate::gpu::maps::Maps;
use crate::gpu::{Gpu, GpuError};
use crate::planar::PlanarMap;
use crate::policy::{Axis, Weights};
use crate::reference::covariance::covariance;
use crate::reference::eigen::eigen;
use crate::reference::footprint::{Chain, Footprint, footprint};
use crate::reference::planar::PlanarTexture;
use crate::reference::real::Real as _;
use crate::reference::weights::spreads;
use crate::reference::{Texture, probe_weights};
use crate::settings::Settings;
use crate::stage::Stage;

/// The map that a fragment's probes read.
enum Memory<'a> {
    Cube(Texture<'a>),
    Planar(PlanarTexture<'a>),
}

/// The maps and the settings that the stages run with.
pub(super) struct BackEnd<'a> {
    pub(super) maps: Maps<'a>,
    pub(super) settings: Settings,
    memory: Memory<'a>,
    pub(super) size: [usize; 2],
    levels: usize,
}

/// One fragment's probes as `filter` gets them.
pub(super) struct FilterInput {
    pixel: [u32; 2],
    face: usize,
    centre: [Bounded; 2],
    line: Footprint<Bounded>,
}

impl<'a> BackEnd<'a> {
    fn prepared(gpu: &'a Gpu, settings: &Settings) -> Result<(Maps<'a>, Settings), GpuError> {
        // The table's axis is compared in the picture; here the axis is the exact one.
        let settings = Settings { reference_table: None, ..settings.clone() };
        Ok((Maps::new(gpu, &settings, &tables(&settings))?, settings))
    }

    pub(super) fn cube(
        gpu: &'a Gpu,
        settings: &Settings,
        map: &'a CubeMap,
    ) -> Result<Self, GpuError> {
        let (maps, settings) = Self::prepared(gpu, settings)?;
        Ok(Self {
            maps: maps.with_cube(map)?,
            settings,
            memory: Memory::Cube(Texture::new(map)),
            size: [map.size(); 2],
            levels: map.levels.len(),
        })
    }

    pub(super) fn planar(
        gpu: &'a Gpu,
        settings: &Settings,
        map: &'a PlanarMap,
    ) -> Result<Self, GpuError> {
        let (maps, settings) = Self::prepared(gpu, settings)?;
        let wrap = settings.policy.address.wrap();
        Ok(Self {
            maps: maps.with_planar(map)?,
            settings,
            memory: Memory::Planar(PlanarTexture::new(map, wrap)),
            size: map.size(),
            levels: map.levels.len(),
        })
    }

    /// The same with distances.
    pub(super) fn with_distance(self, distance: &Distance) -> Result<Self, GpuError> {
        Ok(Self { maps: self.maps.with_distance(distance)?, ..self })
    }

    /// The cases of a fragment from `covariance` to `footprint`; `rough` is B' where it has roughness.
    pub(super) fn fragment(
        &self,
        cases: &mut Cases,
        face: usize,
        centre: [Bounded; 2],
        d: &[[Bounded; 2]; 2],
        rough: Option<&[[Bounded; 2]; 2]>,
    ) -> FilterInput {
        let settings = &self.settings;
        let matrices = [*d, rough.copied().unwrap_or([[Bounded::exact(0.0); 2]; 2])];
        let k = cases.stage(Stage::Covariance, matrices, |tap, _| covariance(d, rough, tap));
        let policy = (settings.policy.footprint.axis, settings.policy.eigen.minor);
        // The kernel shifts K by a power of two before it squares it, and the results back: exact above subnormals.
        let scale = if policy.0 == Axis::LongerDerivative { 1.0 } else { scale_of(&k) };
        let shifted = k.map(|x| Bounded::exact(x.value * scale));
        let (lambda, axis) = cases.stage(Stage::Eigen, (k, matrices), |tap, _| {
            let mut axes = eigen(shifted, [Some(d), rough], policy, None, tap);
            for (register, component, value, error) in &mut tap.put {
                let back = if ["root", "lambda_sq"].contains(register) {
                    let shifted = Bounded { value: *value, error: *error };
                    shifted.scaled(1.0 / scale)
                } else if *register == "lambda" {
                    let root = axes.lambda_sq[*component].scaled(1.0 / scale).sqrt();
                    axes.lambda[*component] = root;
                    root
                } else {
                    continue;
                };
                (*value, *error) = (back.value, back.error);
            }
            (axes.lambda, axes.axis)
        });
        // λ on a 2-D texture counts in texels: 2 texels are 2.
        let size = match self.memory {
            Memory::Cube(_) => self.size[0],
            Memory::Planar(_) => 2,
        };
        let chain = Chain { size, levels: self.levels };
        let policy = &settings.policy.footprint;
        let spreads = spreads(policy);
        let line = cases.stage(Stage::Footprint, (lambda, axis, size), |tap, flags| {
            let line = footprint(lambda, axis, chain, (policy, &spreads), flags, tap);
            let step = match self.memory {
                Memory::Cube(_) => line.step,
                Memory::Planar(_) => [0, 1].map(|i| {
                    let texel = Bounded::exact(2.0 / self.size[i] as f64);
                    line.step[i] * texel.rounded()
                }),
            };
            Footprint { step, ..line }
        });
        FilterInput { pixel: cases.pixel, face, centre, line }
    }

    /// Checks the stages of `cases`, then `address` and `filter`.
    pub(super) fn check(
        &self,
        checker: &mut Checker,
        cases: Cases,
        inputs: &[FilterInput],
    ) -> Result<(), GpuError> {
        for (stage, (registers, cases)) in Stage::ALL.into_iter().zip(cases.stages) {
            checker.stage(self, (Kernel::Stage(stage), &registers), cases, None)?;
        }
        if matches!(self.memory, Memory::Cube(_)) {
            self.addresses(checker, inputs)?;
        }
        self.filters(checker, inputs)
    }

    fn levels(&self, lod: f64) -> [usize; 2] {
        let levels = crate::reference::filter::Levels::new(lod, self.levels);
        levels.index
    }

    /// The stage `address` on a cube: one case a probe.
    fn addresses(&self, checker: &mut Checker, inputs: &[FilterInput]) -> Result<(), GpuError> {
        let mut cases = Vec::new();
        for FilterInput { pixel, face, centre, line } in inputs {
            let sizes = self.levels(line.lod.value).map(|level| (self.size[0] >> level).max(1));
            for index in 0..line.probes {
                let mut operands = Vec::new();
                (*face, *centre, line.step, index, line.probes, sizes).put(&mut operands);
                cases.push(Case { pixel: *pixel, operands, ..Case::default() });
            }
        }
        let kernel = Kernel::Stage(Stage::Address);
        let expected = |_, operands: &[u32], results: &[u32]| address_expected(operands, results);
        checker.stage(self, (kernel, &kernel.registers(0)), cases, Some(&expected))
    }

    /// The stage `filter`: the words of a probe and its two bilinear values as the device has them.
    fn filters(&self, checker: &mut Checker, inputs: &[FilterInput]) -> Result<(), GpuError> {
        let (kernel, place) = match self.memory {
            Memory::Cube(_) => (Kernel::Stage(Stage::Filter), 3),
            Memory::Planar(_) => (Kernel::FilterPlanar, 2),
        };
        // As many words as the most probes of these fragments need; the kernel writes those of its own.
        let counts: std::collections::BTreeSet<u32> =
            inputs.iter().map(|input| input.line.probes).collect();
        for count in counts {
            let these = inputs.iter().filter(|input| input.line.probes == count);
            let cases = these
                .map(|FilterInput { pixel, face, centre, line }| {
                    let mut operands = Vec::new();
                    if matches!(self.memory, Memory::Cube(_)) {
                        face.put(&mut operands);
                    }
                    (*centre, line.step, line.probes, line.lod).put(&mut operands);
                    Case { pixel: *pixel, operands, ..Case::default() }
                })
                .collect();
            let weights = self.weights(count);
            let expected = |_, operands: &[u32], results: &[u32]| -> Vec<Expected> {
                let lod = number(operands[operands.len() - 1]);
                let levels = self.levels(lod);
                let probes = results[3..].chunks_exact(place + 6);
                let mut expected = color(lod, &weights, probes.clone().map(|p| &p[place..]));
                for (index, words) in (0..).zip(probes) {
                    expected.extend(match &self.memory {
                        Memory::Cube(texture) => cube_probe(texture, words, levels),
                        Memory::Planar(texture) => {
                            let wrap = self.settings.policy.address.wrap();
                            planar_probe(texture, wrap, (operands, index, count), words, levels)
                        }
                    });
                }
                expected
            };
            let registers = kernel.registers(num::usize(count));
            checker.stage(self, (kernel, &registers), cases, Some(&expected))?;
        }
        Ok(())
    }

    fn weights(&self, count: u32) -> Vec<f64> {
        let policy = &self.settings.policy.footprint;
        match policy.weights {
            Weights::Box => vec![1.0; count as usize],
            Weights::Gaussian | Weights::Bell => {
                probe_weights(count, policy).into_iter().map(f64::from).collect()
            }
        }
    }
}

/// The power of two that brings K's largest entry to [1, 2).
fn scale_of(k: &[Bounded; 3]) -> f64 {
    let most = k.iter().fold(0.0f64, |most, x| most.max(x.value.abs()));
    if most < f64::from(f32::MIN_POSITIVE) {
        return 1.0;
    }
    libm::ldexp(1.0, 1 - libm::frexp(most).1)
}
