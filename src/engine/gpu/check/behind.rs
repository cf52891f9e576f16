//! The checks of the stages from `covariance` on, which all operations share.

use super::probes::{Probe, ProbeCase, address_expected, color, cube_probe, planar_probe};
use super::{
    Bounded, Case, Checker, Register, Station, bits, float, handed, handed_on, number, recorded,
    whole,
};
use crate::base::num;
use crate::cube::CubeMap;
use crate::engine::gpu::tables;
use crate::gpu::kernels::Kernel;
use crate::gpu::maps::Maps;
use crate::gpu::policy::Policy;
use crate::gpu::{Gpu, GpuError};
use crate::planar::PlanarMap;
use crate::policy::{Axis, Weights};
use crate::reference::covariance::covariance;
use crate::reference::eigen::eigen;
use crate::reference::footprint::{Chain, Rule, footprint};
use crate::reference::planar::PlanarTexture;
use crate::reference::real::Real as _;
use crate::reference::{Texture, probe_weights};
use crate::settings::Settings;
use crate::stage::Stage;

const COVARIANCE: &[Register] = &[float("k", 3)];
const EIGEN: &[Register] =
    &[float("root", 1), float("lambda_sq", 2), float("lambda", 2), float("axis", 2)];
const FOOTPRINT: &[Register] = &[
    float("length", 1),
    float("width", 1),
    whole("probes"),
    float("lod", 1),
    float("step", 2),
    whole("flags"),
];
const ADDRESS: &[Register] =
    &[float("u", 1), float("v", 1), whole("face"), float("place", 2), float("s", 4)];

/// Where a fragment stands before `covariance`.
pub(super) struct Footing {
    pub(super) pixel: [u32; 2],
    pub(super) face: usize,
    pub(super) centre: [Bounded; 2],
    pub(super) d: [[Bounded; 2]; 2],
    pub(super) rough: Option<[[Bounded; 2]; 2]>,
}

/// What the probes of a fragment read.
enum Memory<'a> {
    Cube(Texture<'a>),
    Planar(PlanarTexture<'a>),
}

/// The maps and the policy of the stages from `covariance` on.
pub(super) struct Behind<'a> {
    pub(super) maps: Maps,
    pub(super) policy: Policy,
    settings: Settings,
    memory: Memory<'a>,
    size: [usize; 2],
    levels: usize,
}

/// One fragment's probes as `filter` gets them.
struct Line {
    pixel: [u32; 2],
    face: usize,
    centre: [Bounded; 2],
    step: [Bounded; 2],
    probes: u32,
    lod: Bounded,
}

impl<'a> Behind<'a> {
    fn prepared(gpu: &Gpu, settings: &Settings) -> Result<(Maps, Policy, Settings), GpuError> {
        // The table's axis is compared in the picture; here the axis is the exact one.
        let settings = Settings { reference_table: None, ..settings.clone() };
        let tables = tables(&settings);
        let maps = Maps::none(gpu)?.with_tables(gpu, &tables.words())?;
        Ok((maps, Policy::new(&settings, &tables), settings))
    }

    pub(super) fn cube(gpu: &Gpu, settings: &Settings, map: &'a CubeMap) -> Result<Self, GpuError> {
        let (maps, policy, settings) = Self::prepared(gpu, settings)?;
        Ok(Self {
            maps: maps.with_cube(gpu, map)?,
            policy: policy.with_cube(map),
            settings,
            memory: Memory::Cube(Texture::new(map)),
            size: [map.size(); 2],
            levels: map.levels.len(),
        })
    }

    pub(super) fn planar(
        gpu: &Gpu,
        settings: &Settings,
        map: &'a PlanarMap,
    ) -> Result<Self, GpuError> {
        let (maps, policy, settings) = Self::prepared(gpu, settings)?;
        let wrap = settings.policy.address.wrap();
        Ok(Self {
            maps: maps.with_planar(gpu, map)?,
            policy: policy.with_planar(map),
            settings,
            memory: Memory::Planar(PlanarTexture::new(map, wrap)),
            size: map.size(),
            levels: map.levels.len(),
        })
    }

    fn station<'b>(&'b self, kernel: Kernel, registers: &'b [Register]) -> Station<'b> {
        Station { kernel, maps: &self.maps, policy: &self.policy, registers }
    }

    /// Checks the stages from `covariance` to `filter`.
    pub(super) fn check(
        &self,
        checker: &mut Checker<'_>,
        footings: &[Footing],
    ) -> Result<(), GpuError> {
        let mut cases: [Vec<Case>; 3] = Default::default();
        let lines: Vec<Line> = footings.iter().map(|f| self.line(f, &mut cases)).collect();
        let stages =
            [(Stage::Covariance, COVARIANCE), (Stage::Eigen, EIGEN), (Stage::Footprint, FOOTPRINT)];
        for ((stage, registers), cases) in stages.into_iter().zip(&mut cases) {
            let station = self.station(Kernel::Stage(stage), registers);
            checker.stage(&station, cases, &|_, _| {})?;
        }
        match &self.memory {
            Memory::Cube(texture) => {
                self.addresses(checker, &lines)?;
                self.filters(
                    checker,
                    &lines,
                    Kernel::Stage(Stage::Filter),
                    &|case, words, levels| cube_probe(texture, case, words, levels),
                )
            }
            Memory::Planar(texture) => {
                self.filters(checker, &lines, Kernel::FilterPlanar, &|case, words, levels| {
                    planar_probe(texture, case, words, levels)
                })
            }
        }
    }

    fn line(&self, footing: &Footing, cases: &mut [Vec<Case>; 3]) -> Line {
        let settings = &self.settings;
        let pixel = footing.pixel;
        let zero = [[Bounded::exact(0.0); 2]; 2];
        let (d, rough) = (&footing.d, footing.rough.as_ref());
        let matrices = d.as_flattened().iter().chain(rough.unwrap_or(&zero).as_flattened());
        let matrices: Vec<Bounded> = matrices.copied().collect();
        let (k, recorder, undecided) = recorded(|tap, _| covariance(d, rough, tap));
        cases[0].push(Case {
            pixel,
            operands: bits(&matrices).collect(),
            expected: recorder.expected(COVARIANCE),
            undecided,
        });
        let k = handed(k);
        let policy = (settings.policy.footprint.axis, settings.policy.eigen.minor);
        // The kernel shifts K by a power of two before it squares it, and the results back: exact above subnormals.
        let scale = if settings.policy.footprint.axis == Axis::LongerDerivative {
            1.0
        } else {
            scale_of(&k)
        };
        let shifted = k.map(|x| Bounded::exact(x.value * scale));
        let (mut axes, mut recorder, undecided) =
            recorded(|tap, _| eigen(shifted, [Some(d), rough], policy, None, tap));
        for (register, component, value, error) in &mut recorder.put {
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
        cases[1].push(Case {
            pixel,
            operands: bits(&k).chain(bits(&matrices)).collect(),
            expected: recorder.expected(EIGEN),
            undecided,
        });
        let (lambda, axis) = (handed(axes.lambda), handed(axes.axis));
        // λ on a 2-D texture counts in texels: 2 texels are 2.
        let size = match self.memory {
            Memory::Cube(_) => self.size[0],
            Memory::Planar(_) => 2,
        };
        let chain = Chain { size, levels: self.levels };
        let rule = Rule {
            count: settings.policy.footprint.count,
            max_probes: settings.policy.footprint.max_probes,
        };
        let (line, recorder, undecided) =
            recorded(|tap, flags| footprint(lambda, axis, chain, rule, flags, tap));
        let mut operands: Vec<u32> = bits(&lambda).chain(bits(&axis)).collect();
        operands.push(num::u32(size));
        cases[2].push(Case { pixel, operands, expected: recorder.expected(FOOTPRINT), undecided });
        let step = match self.memory {
            Memory::Cube(_) => handed(line.step),
            Memory::Planar(_) => [0, 1].map(|i| {
                let texel = Bounded::exact(2.0 / self.size[i] as f64);
                handed_on(line.step[i] * handed_on(texel))
            }),
        };
        Line {
            pixel,
            face: footing.face,
            centre: footing.centre,
            step,
            probes: line.probes,
            lod: handed_on(line.lod),
        }
    }

    fn levels(&self, lod: f64) -> [usize; 2] {
        let levels = crate::reference::filter::Levels::new(lod, self.levels);
        levels.index
    }

    /// The stage `address` on a cube: one case a probe.
    fn addresses(&self, checker: &mut Checker<'_>, lines: &[Line]) -> Result<(), GpuError> {
        let small = |n: usize| num::u32(n);
        let mut cases = Vec::new();
        for line in lines {
            let sizes = self.levels(line.lod.value).map(|level| (self.size[0] >> level).max(1));
            for index in 0..line.probes {
                let mut operands = vec![small(line.face)];
                operands.extend(bits(&line.centre).chain(bits(&line.step)));
                operands.extend([index, line.probes, small(sizes[0]), small(sizes[1])]);
                cases.push(Case { pixel: line.pixel, operands, ..Case::default() });
            }
        }
        let station = self.station(Kernel::Stage(Stage::Address), ADDRESS);
        checker.stage(&station, &mut cases, &|case, results| {
            let _ = Bounded::undecided();
            case.expected = address_expected(&case.operands, results);
            case.undecided = Bounded::undecided() > 0;
        })
    }

    /// The stage `filter`; `probe` gives what the words of a probe must be and its two bilinear values as the device has
    /// them.
    fn filters(
        &self,
        checker: &mut Checker<'_>,
        lines: &[Line],
        kernel: Kernel,
        probe: Probe<'_>,
    ) -> Result<(), GpuError> {
        let planar = matches!(self.memory, Memory::Planar(_));
        let place = if planar { 2 } else { 3 };
        // As many words as the most probes of these fragments need; the kernel writes those of its own.
        let counts: std::collections::BTreeSet<u32> = lines.iter().map(|l| l.probes).collect();
        for count in counts {
            let mut cases: Vec<Case> = lines
                .iter()
                .filter(|line| line.probes == count)
                .map(|line| {
                    let mut operands = Vec::new();
                    if !planar {
                        operands.push(num::u32(line.face));
                    }
                    operands.extend(bits(&line.centre).chain(bits(&line.step)));
                    operands.push(line.probes);
                    operands.extend(bits(&[line.lod]));
                    Case { pixel: line.pixel, operands, ..Case::default() }
                })
                .collect();
            let mut registers = vec![float("color", 3)];
            for _ in 0..count {
                if !planar {
                    registers.push(whole("face"));
                }
                registers.push(float("place", 2));
                registers.push(float("bilinear", 6));
            }
            let station = self.station(kernel, &registers);
            let weights = self.weights(count);
            checker.stage(&station, &mut cases, &|case, results| {
                let _ = Bounded::undecided();
                let lod = number(case.operands[case.operands.len() - 1]);
                let levels = self.levels(lod);
                let probes = results[3..].chunks_exact(place + 6);
                let mut expected = color(lod, &weights, probes.clone().map(|p| &p[place..]));
                for (index, words) in probes.enumerate() {
                    let at = ProbeCase {
                        operands: &case.operands,
                        index: num::u32(index),
                        probes: count,
                        settings: &self.settings,
                    };
                    expected.extend(probe(at, words, levels));
                }
                case.expected = expected;
                case.undecided = Bounded::undecided() > 0;
            })?;
        }
        Ok(())
    }

    fn weights(&self, count: u32) -> Vec<f64> {
        let policy = &self.settings.policy.footprint;
        match policy.weights {
            Weights::Box => vec![1.0; count as usize],
            Weights::Gaussian => {
                let end_points = policy.count.has_end_points();
                let weights = probe_weights(count, policy.weight_bits, end_points);
                weights.into_iter().map(f64::from).collect()
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
