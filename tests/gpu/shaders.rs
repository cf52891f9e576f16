//! The shaders without a GPU: valid by naga and by tint, the uniform as the host writes it, numbers as the policies have them.

use std::io::Write as _;
use std::process::{Command, Stdio};

use naga::valid::{Capabilities, ValidationFlags, Validator};
use tapline::gpu::kernels::Kernel;
use tapline::gpu::policy::{Policy, Tables};
use tapline::policy::{HitStatus, Legal, ROWS};
use tapline::settings::Settings;

fn parsed(source: &str, name: &str) -> naga::Module {
    naga::front::wgsl::parse_str(source)
        .unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(source)))
}

#[test]
fn every_kernel_is_valid_without_any_optional_capability() {
    let kernels = Kernel::all();
    assert!(kernels.len() >= 19, "four operations, fourteen stages, filter on 2-D textures");
    for kernel in kernels {
        let source = kernel.source();
        let module = parsed(&source, kernel.name());
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        let checked = validator.validate(&module);
        assert!(checked.is_ok(), "{}: {:?}", kernel.name(), checked.err());
        let entries = &module.entry_points;
        assert_eq!(entries.len(), 1);
        assert_eq!(entries[0].workgroup_size, [64, 1, 1]);
    }
}

#[test]
fn tint_accepts_every_kernel_where_it_is_installed() {
    if Command::new("tint")
        .arg("--help")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_err()
    {
        eprintln!("skipped, not checked: there is no `tint` on the PATH");
        return;
    }
    for kernel in Kernel::all() {
        let mut file = tempfile::Builder::new().suffix(".wgsl").tempfile().expect("a temporary");
        file.write_all(kernel.source().as_bytes()).expect("room for a shader");
        let out = Command::new("tint")
            .args(["--format", "wgsl", "-o"])
            .arg(if cfg!(windows) { "NUL" } else { "/dev/null" })
            .arg(file.path())
            .output()
            .expect("tint runs");
        let words = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.success(), "{}: {words}", kernel.name());
    }
}

#[test]
fn the_uniform_has_the_members_that_the_host_writes_at_their_offsets() {
    let kernel = Kernel::all()[0];
    let module = parsed(&kernel.source(), "ENV");
    let (_, ty) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some("Policy"))
        .expect("the shader has the uniform");
    let naga::TypeInner::Struct { members, span } = &ty.inner else {
        panic!("Policy is no struct");
    };
    let policy = Policy::new(&Settings::default(), &Tables::default());
    let host = policy.members();
    assert_eq!(members.len(), host.len());
    let mut offset = 0;
    for (member, entry) in members.iter().zip(&host) {
        assert_eq!((member.name.as_ref(), member.offset), (Some(&entry.name), offset));
        offset += 4 * u32::try_from(entry.words.len()).expect("a few words");
    }
    assert_eq!(*span, offset, "no padding at the end");
    assert_eq!(policy.bytes().len(), offset as usize);
}

/// The value of `const NAME: u32`.
fn constant(module: &naga::Module, name: &str) -> u32 {
    let (_, constant) = module
        .constants
        .iter()
        .find(|(_, c)| c.name.as_deref() == Some(name))
        .unwrap_or_else(|| panic!("no constant {name}"));
    let naga::Expression::Literal(naga::Literal::U32(value)) =
        module.global_expressions[constant.init]
    else {
        panic!("{name} is no u32");
    };
    value
}

#[test]
fn numbers_of_the_choices_are_the_places_of_the_policies_values() {
    let source = Kernel::all()[1].source();
    let module = parsed(&source, "HIT");
    let mut seen = 0;
    let mut check = |prefix: &str, names: &[&str]| {
        for (at, name) in (0u32..).zip(names) {
            let name = format!("{prefix}_{name}").to_uppercase().replace(['-', '.'], "_");
            assert_eq!(constant(&module, &name), at);
            seen += 1;
        }
    };
    for row in ROWS.iter().filter(|row| row.all_engines) {
        if let Legal::Names(names) = row.legal {
            check(row.path, names);
        }
    }
    check("STATUS", HitStatus::NAMES);
    assert!(seen > 38, "{seen}");
}

#[test]
fn flags_are_the_bits_of_the_reference_s_flags() {
    let source = Kernel::all()[1].source();
    let module = parsed(&source, "HIT");
    let names = [
        "NON_FINITE",
        "PARALLEL",
        "ZERO",
        "DERIVATIVES_SATURATED",
        "COVARIANCE_SATURATED",
        "LAMBDA_SATURATED",
        "LENGTH_SATURATED",
        "HIT_NOT_FINITE",
        "HIT_NO_DIRECTION",
        "HIT_NO_PLANE",
        "HIT_OVERSHOOT",
        "HIT_SATURATED",
        "SURF_NOT_FINITE",
        "SURF_PARALLEL",
        "SURF_DEGENERATE",
        "SURF_SATURATED",
    ];
    let flags = tapline::reference::Flag::ALL;
    assert_eq!(flags.len(), names.len());
    for (flag, name) in flags.iter().zip(names) {
        assert_eq!(constant(&module, &format!("FLAG_{name}")), 1 << *flag as u32);
    }
}
