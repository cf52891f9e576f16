//! Named suites: subject × configuration × input class. Any case is replayed by its suite's name, the seed and an index.

use rtl_model::regs::{Kind, Reg};

use super::cases::Class;
use super::harness::Build;
use super::subject::Subject;
use crate::error::InputError;
use crate::stage::Stage;
use crate::unit::{UnitSpec, file};

/// Cases of a suite.
pub const CASES: u64 = 1000;

/// A suite.
#[derive(Clone, Copy, Debug)]
pub struct Suite {
    /// What runs.
    pub subject: Subject,
    /// In which unit.
    pub configuration: &'static Configuration,
    /// On which inputs.
    pub class: Class,
}

/// A unit by its difference to the default one.
#[derive(Clone, Copy, Debug)]
pub struct Configuration {
    /// The name in a suite.
    pub name: &'static str,
    /// Where it starts.
    preset: &'static str,
    /// The settings.
    sets: &'static [&'static str],
    /// The rounding or overflow of every register.
    all: &'static [&'static str],
    /// Whether bump and roughness are built.
    parts: bool,
    /// For which subjects it makes a difference.
    of: Of,
}

/// Groups of subjects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Of {
    /// Everything.
    All,
    /// ENV and its stages.
    Env,
    /// Stages from `covariance` on, and the operations.
    Back,
    /// HIT.
    Hit,
    /// TEX.
    Tex,
    /// Cones.
    Cone,
}

const fn configuration(name: &'static str, of: Of, sets: &'static [&'static str]) -> Configuration {
    Configuration { name, preset: "default", sets, all: &[], parts: true, of }
}

/// Tables without Newton steps and with few bits.
const COARSE: &[&str] = &[
    "tables.recip.entries=16",
    "tables.recip.newton=0",
    "tables.recip.order=0",
    "tables.recip.frac=10",
    "tables.rsqrt.entries=16",
    "tables.rsqrt.newton=0",
    "tables.rsqrt.frac=12",
    "tables.sqrt.entries=16",
    "tables.sqrt.newton=0",
    "tables.sqrt.order=2",
    "tables.log2.entries=16",
    "tables.log2.order=2",
    "eigen.entries=10",
];

/// Every configuration.
pub static CONFIGURATIONS: [Configuration; 34] = [
    configuration("default", Of::All, &[]),
    Configuration { preset: "schilling", ..configuration("schilling", Of::Env, &[]) },
    Configuration { preset: "otk", ..configuration("otk", Of::Tex, &[]) },
    Configuration { preset: "otk", ..configuration("otk", Of::Cone, &[]) },
    Configuration { parts: false, ..configuration("plain", Of::Env, &[]) },
    Configuration { all: &["rounding=\"floor\""], ..configuration("floor", Of::All, &[]) },
    Configuration { all: &["rounding=\"half-up\""], ..configuration("half-up", Of::All, &[]) },
    Configuration {
        all: &["rounding=\"zero\"", "overflow=\"saturate-symmetric\""],
        ..configuration("to-zero", Of::Env, &[])
    },
    Configuration { all: &["overflow=\"wrap\""], ..configuration("wrap", Of::Env, &[]) },
    Configuration { all: &["overflow=\"zero\""], ..configuration("overflow-zero", Of::Env, &[]) },
    configuration("coarse-tables", Of::All, COARSE),
    configuration(
        "rotated",
        Of::All,
        &["transform.rotation=[0.36, 0.48, -0.8, -0.8, 0.6, 0.0, 0.48, 0.64, 0.6]"],
    ),
    configuration("frame", Of::Env, &["jacobian.dnmod=\"frame\""]),
    configuration("paper", Of::Env, &["jacobian.dnmod=\"paper\""]),
    configuration("det", Of::Back, &["eigen.minor=\"det\""]),
    configuration("exact-axis", Of::Back, &["footprint.axis=\"eigen-exact\""]),
    configuration("interpolated-axis", Of::Back, &["tables.eigen.order=1"]),
    configuration("centred-axis", Of::Back, &["eigen.placement=\"centres\""]),
    configuration("round", Of::Back, &["footprint.count=\"round\""]),
    configuration("pow2", Of::Back, &["footprint.count=\"pow2\"", "footprint.max_probes=12"]),
    configuration(
        "feline-gaussian",
        Of::Back,
        &["footprint.count=\"feline\"", "footprint.weights=\"gaussian\""],
    ),
    configuration("one-probe", Of::Back, &["footprint.max_probes=1"]),
    configuration(
        "narrow-filter",
        Of::Back,
        &[
            "filter.weight_bits=5",
            "filter.lod_bits=4",
            "registers.filter.bilinear.frac=12",
            "registers.filter.color.frac=10",
        ],
    ),
    configuration("secant", Of::Hit, &["hit.method=\"secant\"", "hit.iterations=6"]),
    configuration("illinois", Of::Hit, &["hit.method=\"illinois\"", "hit.iterations=8"]),
    configuration("no-tolerance", Of::Hit, &["hit.tolerance_bits=\"off\""]),
    configuration("no-iterations", Of::Hit, &["hit.iterations=0"]),
    configuration("plane", Of::Hit, &["hit.footprint=\"plane\""]),
    configuration("nearest", Of::Hit, &["hit.lookup=\"nearest\"", "hit.outside=\"hlsl\""]),
    configuration(
        "clamp-mirror",
        Of::Tex,
        &["address.wrap_s=\"clamp\"", "address.wrap_t=\"mirror\""],
    ),
    configuration("note-gradients", Of::Tex, &["cone.gradient=\"otk\""]),
    configuration("f16", Of::Cone, &["cone.format=\"f16\""]),
    configuration("f32-truncate", Of::Cone, &["cone.format=\"f32\"", "cone.rounding=\"truncate\""]),
    configuration("stochastic", Of::Cone, &["cone.rounding=\"stochastic\"", "cone.seed=7"]),
];

impl Configuration {
    /// The unit.
    pub fn unit(&self) -> Result<UnitSpec, InputError> {
        let preset = format!("preset:{}", self.preset);
        let mut sets: Vec<String> = self.sets.iter().map(|s| (*s).to_string()).collect();
        for change in self.all {
            for reg in Reg::ALL {
                let info = reg.info();
                // A block has no overflow, and texel sums are exact by default.
                let block = info.kind == Kind::Block && change.starts_with("overflow");
                if !block {
                    sets.push(format!("registers.{reg}.{change}"));
                }
            }
        }
        Ok(file::load(Some(&preset), &sets)?.0)
    }

    /// Which parts are built.
    #[must_use]
    pub fn build(&self) -> Build {
        Build { bump: self.parts, rough: self.parts, ..Build::default() }
    }

    fn concerns(&self, subject: Subject) -> bool {
        use Stage as S;
        let hit = matches!(subject, Subject::Hit | Subject::Stage(S::Hit));
        let tex = matches!(subject, Subject::Tex | Subject::Stage(S::SurfaceFootprint));
        let cone = subject == Subject::Stage(S::RayCone);
        let back = matches!(
            subject,
            Subject::Env
                | Subject::Tex
                | Subject::Hit
                | Subject::Stage(S::Covariance | S::Eigen | S::Footprint | S::Address | S::Filter)
        );
        // A plain unit has no frame, bump and roughness.
        let built = self.parts
            || !matches!(subject, Subject::Stage(S::LocalFrame | S::Bump | S::Roughness));
        built
            && match self.of {
                Of::All => !cone || self.name == "default",
                Of::Env => !(hit || tex || cone),
                Of::Back => back,
                Of::Hit => hit,
                Of::Tex => tex,
                Of::Cone => cone,
            }
    }
}

impl Suite {
    /// Every suite, in a fixed order.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut out = Vec::new();
        for subject in Subject::all() {
            for configuration in &CONFIGURATIONS {
                if !configuration.concerns(subject) {
                    continue;
                }
                for class in Class::ALL.into_iter().filter(|class| class.concerns(subject)) {
                    out.push(Self { subject, configuration, class });
                }
            }
        }
        out
    }

    /// `subject/configuration/class`.
    #[must_use]
    pub fn name(&self) -> String {
        let (subject, class) = (self.subject.name(), self.class.name());
        format!("{subject}/{}/{class}", self.configuration.name)
    }
}

/// Whether a name matches a pattern with `*` for any characters.
#[must_use]
pub fn matches(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|first| name.strip_prefix(first)) else {
        return false;
    };
    let mut last = None;
    for part in parts {
        if let Some(part) = last.replace(part) {
            match rest.find(part) {
                Some(at) => rest = &rest[at + part.len()..],
                None => return false,
            }
        }
    }
    last.map_or(rest.is_empty(), |part| rest.ends_with(part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match_as_in_a_shell() {
        for (pattern, name, want) in [
            ("*", "a/b/c", true),
            ("a/*", "a/b/c", true),
            ("*/c", "a/b/c", true),
            ("a/*/c", "a/b/c", true),
            ("a/b/c", "a/b/c", true),
            ("a/b", "a/b/c", false),
            ("*b*", "a/b/c", true),
            ("*c*b*", "a/b/c", false),
            ("aa*a", "aa", false),
        ] {
            assert_eq!(matches(pattern, name), want, "{pattern} {name}");
        }
    }

    #[test]
    fn suites_have_names_of_their_own_and_units_that_are_accepted() {
        let suites = Suite::all();
        assert!(suites.len() >= 250, "{}", suites.len());
        let mut names: Vec<String> = suites.iter().map(Suite::name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), suites.len());
        for configuration in &CONFIGURATIONS {
            if let Err(e) = configuration.unit() {
                panic!("{}: {e}", configuration.name);
            }
        }
    }
}
