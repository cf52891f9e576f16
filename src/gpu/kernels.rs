//! The kernels: WGSL of the stages put together, in pipeline order, with an entry point behind it.

use crate::stage::Stage;

/// A kernel, by what it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// A whole operation.
    Fused(Fused),
    /// One stage, which writes every register that it has.
    Stage(Stage),
    /// The stage `filter` on a 2-D texture.
    FilterPlanar,
}

/// A register of a kernel's results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Register {
    /// Its name in its stage.
    pub name: &'static str,
    /// Words.
    pub words: usize,
    /// Whether it is a whole number and not an f32.
    pub whole: bool,
}

impl Register {
    /// `name` for one f32, `name 3` for three, `name u32` for a whole number.
    fn parse(text: &'static str) -> Self {
        let (name, kind) = text.split_once(' ').unwrap_or((text, "1"));
        Self { name, words: kind.parse().unwrap_or(1), whole: kind == "u32" }
    }
}

/// The operations that run in one kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fused {
    /// ENV.
    Env,
    /// HIT and, where a ray has a cone, ENV behind it.
    Hit,
    /// TEX, from the cone at the camera to the colour.
    Tex,
    /// A bare cone into the environment.
    Sky,
}

/// A file of the folder `shaders`, by its name below it.
macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("shaders/", $name)))),*]
    };
}

/// The common part of every kernel, between the uniform and its entry point: name below `src/gpu/shaders` and text.
const COMMON: &[(&str, &str)] = files![
    "kernels/ports.wgsl",
    "vector.wgsl",
    "cube.wgsl",
    "local_frame.wgsl",
    "bump.wgsl",
    "reflect.wgsl",
    "cube_face.wgsl",
    "jacobian.wgsl",
    "roughness.wgsl",
    "ray_cone.wgsl",
    "distances.wgsl",
    "hit.wgsl",
    "surface_footprint.wgsl",
    "covariance.wgsl",
    "eigen.wgsl",
    "footprint.wgsl",
    "address.wgsl",
    "texture.wgsl",
    "planar.wgsl",
    "filter.wgsl",
    "kernels/facing.wgsl",
    "kernels/tex_fragment.wgsl",
    "kernels/back_end.wgsl",
];

/// The entry point of a stage's kernel, behind its function `stage`.
const STAGE_MAIN: &str = include_str!("shaders/kernels/stages/main.wgsl");

impl Kernel {
    /// Every kernel.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let fused = [Fused::Env, Fused::Hit, Fused::Tex, Fused::Sky];
        let stages = Stage::ALL.into_iter().map(Self::Stage);
        fused.into_iter().map(Self::Fused).chain(stages).chain([Self::FilterPlanar]).collect()
    }

    /// Its name, for messages and labels.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fused(Fused::Env) => "ENV",
            Self::Fused(Fused::Hit) => "HIT",
            Self::Fused(Fused::Tex) => "TEX",
            Self::Fused(Fused::Sky) => "TEX, bare cones",
            Self::Stage(stage) => stage.name(),
            Self::FilterPlanar => "filter, 2-D",
        }
    }

    /// The part that only this kernel has.
    const fn own(self) -> &'static str {
        macro_rules! stage {
            ($name:literal) => {
                include_str!(concat!("shaders/kernels/stages/", $name, ".wgsl"))
            };
        }
        match self {
            Self::Fused(Fused::Env) => include_str!("shaders/kernels/env.wgsl"),
            Self::Fused(Fused::Hit) => include_str!("shaders/kernels/hit.wgsl"),
            Self::Fused(Fused::Tex) => include_str!("shaders/kernels/tex.wgsl"),
            Self::Fused(Fused::Sky) => include_str!("shaders/kernels/sky.wgsl"),
            Self::FilterPlanar => stage!("filter_planar"),
            Self::Stage(stage) => match stage {
                Stage::LocalFrame => stage!("local_frame"),
                Stage::Bump => stage!("bump"),
                Stage::Reflect => stage!("reflect"),
                Stage::CubeFace => stage!("cube_face"),
                Stage::Jacobian => stage!("jacobian"),
                Stage::Roughness => stage!("roughness"),
                Stage::RayCone => stage!("ray_cone"),
                Stage::Hit => stage!("hit"),
                Stage::SurfaceFootprint => stage!("surface_footprint"),
                Stage::Covariance => stage!("covariance"),
                Stage::Eigen => stage!("eigen"),
                Stage::Footprint => stage!("footprint"),
                Stage::Address => stage!("address"),
                Stage::Filter => stage!("filter"),
            },
        }
    }

    /// The registers that a stage's kernel writes, as the head of its file lists them: `Registers: a, b 3; of every probe:
    /// c u32.` What comes of every probe or look-up is there `repeats` times.
    #[must_use]
    pub fn registers(self, repeats: usize) -> Vec<Register> {
        let list = self.own().strip_prefix("// Registers: ").and_then(|s| s.split_once('.'));
        let mut out = Vec::new();
        for group in list.map_or("", |(list, _)| list).split(';') {
            let (times, names) = match group.split_once(':') {
                Some((_, names)) => (repeats, names),
                None => (1, group),
            };
            let words = |name: &'static str| name.trim_start_matches(['\n', '/', ' ']);
            let one: Vec<Register> =
                names.split(',').map(|name| Register::parse(words(name))).collect();
            (0..times).for_each(|_| out.extend(&one));
        }
        out
    }

    /// The whole module, as the device compiles it. Its entry point is `main`, 64 invocations a workgroup.
    #[must_use]
    pub fn source(self) -> String {
        let mut out = super::policy::wgsl();
        for (name, text) in COMMON {
            out.push_str(&format!("// {name}\n{text}\n"));
        }
        out.push_str(self.own());
        if !matches!(self, Self::Fused(_)) {
            out.push_str(STAGE_MAIN);
        }
        out
    }
}
