//! The `gpu` engine: WGSL through wgpu, in single precision.
//!
//! Operands are rounded to f32 on the host, maps are uploaded once, fragments go through one fused kernel in batches.
//! What fails returns the driver's error.

pub mod bounded;
pub mod check;
pub mod hit;
pub mod sampler;
pub mod tex;

use std::collections::BTreeMap;
use std::time::Instant;

use super::{Engine, EnvJob, Progress, Rendering, texels_read};
use crate::cube::CubeMap;
use crate::fragment::{Fragment, PixelFragment};
use crate::gpu::dispatch::{Batch, Program, Words};
use crate::gpu::kernels::{Fused, Kernel};
use crate::gpu::maps::Maps;
use crate::gpu::policy::{Policy, Tables, to_f32};
use crate::gpu::{Gpu, GpuError};
use crate::policy::{Axis, Weights};
use crate::reference::angle::Angles;
use crate::reference::{Flag, probe_weights};
use crate::settings::Settings;

/// Bit and name of each report of a kernel or the host that is no flag of the reference.
const OWN_FLAGS: [(u32, &str); 3] = [
    (OVERFLOW, "gpu.overflow"),
    (INPUT_SATURATED, "gpu.input.saturated"),
    (INPUT_UNDERFLOW, "gpu.input.underflow"),
];
/// A value left the range of f32 on the way.
const OVERFLOW: u32 = 1 << 16;
/// An operand is beyond the largest f32.
const INPUT_SATURATED: u32 = 1 << 17;
/// An operand that is not zero is below the least normal f32: a device may take it for zero.
const INPUT_UNDERFLOW: u32 = 1 << 18;

/// The flags of a fragment that left the range of f32.
fn beyond_range() -> u32 {
    let saturated = [
        Flag::DerivativesSaturated,
        Flag::CovarianceSaturated,
        Flag::LambdaSaturated,
        Flag::LengthSaturated,
        Flag::HitSaturated,
        Flag::SurfSaturated,
    ];
    let bits = saturated.into_iter().fold(0, |bits, flag| bits | bit(flag));
    bits | OVERFLOW | INPUT_SATURATED | INPUT_UNDERFLOW
}

/// The bit of a flag of the float reference.
const fn bit(flag: Flag) -> u32 {
    1 << flag as u32
}

/// The names of a word of flags, in pipeline order, the device's own behind them.
#[must_use]
pub fn flag_names(flags: u32) -> Vec<&'static str> {
    let shared = Flag::ALL.into_iter().map(|f| (bit(f), f.name()));
    shared.chain(OWN_FLAGS).filter(|(bit, _)| flags & bit != 0).map(|(_, name)| name).collect()
}

/// Numbers that the kernels take from tables: probe weights and the angle table of the reference.
#[must_use]
pub fn tables(settings: &Settings) -> Tables {
    let mut out = Tables::default();
    if settings.policy.footprint.weights != Weights::Box {
        let policy = &settings.policy.footprint;
        let most = policy.max_probes.clamp(1, crate::gpu::policy::MOST_PROBES);
        #[expect(clippy::cast_precision_loss, reason = "the kernels count in f32")]
        let weights =
            (1..=most).flat_map(|count| probe_weights(count, policy)).map(|weight| weight as f32);
        out.weights = weights.collect();
    }
    let table = settings.reference_table;
    if let Some(table) = table.filter(|_| settings.policy.footprint.axis == Axis::EigenTable) {
        let (angles, boundaries, order, tan_step) = Angles::new(table).parts();
        out.angles = angles.into_iter().map(|pair| pair.map(to_f32)).collect();
        out.boundaries = boundaries;
        out.angle_order = order;
        out.tan_step = to_f32(tan_step);
    }
    out
}

/// Operands of many fragments as words, with the host's flags for each.
#[derive(Clone, Debug, Default)]
pub struct Operands {
    /// Words of all fragments.
    pub words: Vec<u32>,
    /// Flags of each fragment.
    pub flags: Vec<u32>,
    /// The flag of a number that is not finite.
    non_finite: u32,
}

impl Operands {
    /// No fragments; NaN and infinities will raise `non_finite`.
    #[must_use]
    pub fn new(non_finite: Flag) -> Self {
        Self { non_finite: bit(non_finite), ..Self::default() }
    }

    /// Starts a fragment.
    pub fn begin(&mut self) {
        self.flags.push(0);
    }

    /// A word that is no number.
    pub fn word(&mut self, word: u32) {
        self.words.push(word);
    }

    /// Numbers, rounded to f32: NaN as 0, infinities and numbers beyond the range as the largest f32.
    pub fn numbers(&mut self, values: &[f64]) {
        for &value in values {
            let rounded = to_f32(value);
            self.words.push(rounded.to_bits());
            let raised = if !value.is_finite() {
                self.non_finite
            } else if value.abs() > f64::from(f32::MAX) {
                INPUT_SATURATED
            } else if value != 0.0 && rounded.abs() < f32::MIN_POSITIVE {
                INPUT_UNDERFLOW
            } else {
                0
            };
            if let Some(flags) = self.flags.last_mut() {
                *flags |= raised;
            }
        }
    }
}

/// The first results of every fused kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filtered {
    /// Linear RGB.
    pub color: [f64; 3],
    /// Level of detail.
    pub lod: f64,
    /// Probes.
    pub probes: u32,
    /// Flags.
    pub flags: u32,
}

impl Filtered {
    /// Words of it.
    pub const WORDS: usize = 6;

    /// From the first words of a fragment's results.
    #[must_use]
    pub fn of(words: &[u32]) -> Self {
        let number = |i: usize| f64::from(f32::from_bits(words[i]));
        Self {
            color: [number(0), number(1), number(2)],
            lod: number(3),
            probes: words[4],
            flags: words[5],
        }
    }

    /// Texels that it took.
    #[must_use]
    pub fn texels(&self) -> u64 {
        texels_read(self.lod, self.probes)
    }
}

/// Counts of flags, and the first fragment that left the range.
#[derive(Clone, Debug, Default)]
pub struct Reports {
    /// Fragments by flag.
    pub flags: BTreeMap<String, u64>,
    /// Fragments that left the range of f32, and the pixel of the first.
    pub beyond_f32: Option<(u64, [u32; 2])>,
}

impl Reports {
    /// Counts one fragment's flags.
    pub fn add(&mut self, flags: u32, pixel: [u32; 2]) {
        for name in flag_names(flags) {
            *self.flags.entry(name.to_string()).or_default() += 1;
        }
        if flags & beyond_range() != 0 {
            let (count, _) = self.beyond_f32.get_or_insert((0, pixel));
            *count += 1;
        }
    }
}

/// A fused kernel with its maps.
struct Loaded<'a> {
    program: Program,
    maps: Maps<'a>,
    words: Words,
}

impl<'a> Loaded<'a> {
    fn new(kernel: Fused, maps: Maps<'a>, words: Words) -> Result<Self, GpuError> {
        let program = Program::new(maps.gpu, Kernel::Fused(kernel))?;
        program.warm(&maps, words)?;
        Ok(Self { program, maps, words })
    }

    /// What `result` makes of each fragment's words and flags, those of its operands included; reports are by pixel.
    fn run<T>(
        &self,
        operands: &Operands,
        pixels: impl Iterator<Item = [u32; 2]>,
        progress: Progress<'_>,
        mut result: impl FnMut(Filtered, &[u32]) -> T,
    ) -> Result<(Vec<T>, Reports), GpuError> {
        let input = (operands.words.as_slice(), [].as_slice());
        let words = self.program.run(&self.maps, self.words, input, &|n| progress(n))?;
        let mut reports = Reports::default();
        let results = words.chunks_exact(self.words.output).zip(&operands.flags).zip(pixels);
        let results = results.map(|((words, flags), pixel)| {
            let mut filtered = Filtered::of(words);
            filtered.flags |= flags;
            reports.add(filtered.flags, pixel);
            result(filtered, &words[Filtered::WORDS..])
        });
        let results = results.collect();
        Ok((results, reports))
    }
}

/// Words of ENV's operands and results.
const ENV_WORDS: Words = Words { input: 26, output: Filtered::WORDS };

/// The ENV operation on a device.
pub struct GpuEnv<'a>(Loaded<'a>);

/// The words of fragments: a missing input is zero.
fn operands(fragments: &[PixelFragment]) -> Operands {
    let mut operands = Operands::new(Flag::NonFinite);
    for PixelFragment { fragment: f, .. } in fragments {
        operands.begin();
        for v in [f.v, f.n, f.dv_dx, f.dv_dy, f.dn_dx, f.dn_dy, f.h.unwrap_or_default()] {
            operands.numbers(&v);
        }
        operands.numbers(&f.bump.unwrap_or_default());
        operands.numbers(&f.rough.unwrap_or_default());
    }
    operands
}

/// The policy of fragments that have what this one has.
#[must_use]
pub fn with_needs(mut policy: Policy, fragment: Option<&Fragment>) -> Policy {
    policy.bump = fragment.is_some_and(|f| f.h.is_some() && f.bump.is_some());
    policy.rough = fragment.is_some_and(|f| f.h.is_some() && f.rough.is_some());
    policy
}

impl<'a> GpuEnv<'a> {
    /// Compiles the kernel and uploads the map, for fragments that have what `first` has.
    ///
    /// # Errors
    ///
    /// A map beyond the device's limits, or the driver's error.
    pub fn new(
        gpu: &'a Gpu,
        settings: &Settings,
        map: &CubeMap,
        first: Option<&Fragment>,
    ) -> Result<Self, GpuError> {
        let mut maps = Maps::new(gpu, settings, &tables(settings))?.with_cube(map)?;
        maps.policy = with_needs(maps.policy, first);
        Ok(Self(Loaded::new(Fused::Env, maps, ENV_WORDS)?))
    }

    /// Every fragment's result, flags of its operands included, and what left the range of f32.
    pub fn filter(
        &self,
        fragments: &[PixelFragment],
        progress: Progress<'_>,
    ) -> Result<(Vec<Filtered>, Reports), GpuError> {
        let pixels = fragments.iter().map(|fragment| fragment.pixel);
        self.0.run(&operands(fragments), pixels, progress, |filtered, _| filtered)
    }

    /// The fragments of one batch on the device, and how many there are: at most what a batch holds.
    pub fn upload(&self, fragments: &[PixelFragment]) -> Result<(Batch, usize), GpuError> {
        let Loaded { program, maps, words } = &self.0;
        let count = fragments.len().min(Program::batch(maps.gpu, *words));
        let operands = operands(&fragments[..count]);
        Ok((program.upload(maps, *words, &operands.words, &[])?, count))
    }

    /// Runs the kernel over a batch that is on the device, and waits for it.
    pub fn run(&self, batch: &Batch) -> Result<(), GpuError> {
        self.0.program.dispatch(self.0.maps.gpu, batch)?;
        self.0.maps.gpu.wait()
    }
}

/// Kernels of a device. The seconds of a rendering hold the rounding of operands to f32, uploads and read-backs, but
/// neither maps nor the compilation of kernels.
pub struct GpuEngine<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// Policies.
    pub settings: Settings,
}

impl Engine<EnvJob> for GpuEngine<'_> {
    fn render(&self, job: &EnvJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let first = job.scene.fragments.first().map(|f| &f.fragment);
        GpuEnv::new(self.gpu, &self.settings, &job.map, first)?.render(job, progress)
    }
}

impl Engine<EnvJob> for GpuEnv<'_> {
    fn render(&self, job: &EnvJob, progress: Progress<'_>) -> Result<Rendering, GpuError> {
        let start = Instant::now();
        let (results, reports) = self.filter(&job.scene.fragments, progress)?;
        let seconds = start.elapsed().as_secs_f64();
        let colors: Vec<[f64; 3]> = results.iter().map(|r| r.color).collect();
        Ok(Rendering {
            picture: job.picture(&colors),
            seconds,
            probes: results.iter().map(|r| u64::from(r.probes)).sum(),
            texels: results.iter().map(Filtered::texels).sum(),
            flags: reports.flags,
            beyond_f32: reports.beyond_f32,
            ..Rendering::default()
        })
    }
}
