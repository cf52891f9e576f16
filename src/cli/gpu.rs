//! `gpu list`: the adapters that drivers offer.

use std::io::Write as _;
use std::path::PathBuf;

use serde_json::{Map, Value, json};

use super::Failure;
use super::output::JsonTarget;
use crate::gpu::adapter::{self, Adapter, named_limits};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// List adapters: name, backend, driver, type, limits, features.
    List(List),
}

#[derive(Debug, clap::Args)]
struct List {
    /// The list as JSON; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let Command::List(list) = &args.command;
    let target = JsonTarget::open(list.json.as_deref())?;
    let adapters = adapter::list();
    if !target.takes_stdout() {
        print(&adapters)?;
    }
    let defaults = named_limits(&wgpu::Limits::default());
    target.write(&json!({
        "version": env!("CARGO_PKG_VERSION"),
        "adapters": adapters.iter().map(to_json).collect::<Vec<_>>(),
        "used_limits": object(&defaults),
    }))
}

fn print(adapters: &[Adapter]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    if adapters.is_empty() {
        writeln!(out, "no adapter: no Vulkan driver was found")?;
        writeln!(
            out,
            "  everything but the engines gpu and sampler and the command fingerprint works without one;"
        )?;
        writeln!(out, "  Debian's package mesa-vulkan-drivers has a driver in software")?;
        return Ok(());
    }
    for adapter in adapters {
        let facts = &adapter.facts;
        let [vendor, device] = facts.pci;
        writeln!(out, "{}: {}", facts.index, facts.name)?;
        writeln!(
            out,
            "    type: {}   backend: {}   PCI: {vendor:04x}:{device:04x}",
            facts.kind, facts.backend
        )?;
        writeln!(out, "    driver: {} {}", facts.driver, facts.driver_info)?;
        let [least, most] = facts.subgroup;
        let anisotropic = if adapter.is_anisotropic() { "yes" } else { "no" };
        writeln!(out, "    subgroup: {least} to {most}   anisotropic filter: {anisotropic}")?;
        writeln!(
            out,
            "    limits (WebGPU's default, which the engine asks for, behind the slash):"
        )?;
        let defaults = named_limits(&wgpu::Limits::default());
        for ((name, limit), (_, default)) in adapter.limits().into_iter().zip(defaults) {
            writeln!(out, "        {name}: {limit} / {default}")?;
        }
        writeln!(out, "    features: {}", adapter.features().join(" "))?;
    }
    Ok(())
}

fn to_json(adapter: &Adapter) -> Value {
    let facts = &adapter.facts;
    json!({
        "index": facts.index,
        "name": facts.name,
        "backend": facts.backend,
        "driver": facts.driver,
        "driver_info": facts.driver_info,
        "type": facts.kind,
        "vendor": facts.pci[0],
        "device": facts.pci[1],
        "subgroup": facts.subgroup,
        "anisotropic_filter": adapter.is_anisotropic(),
        "limits": object(&adapter.limits()),
        "features": adapter.features(),
    })
}

fn object(limits: &[(&str, u64)]) -> Map<String, Value> {
    limits.iter().map(|(name, limit)| ((*name).to_string(), json!(limit))).collect()
}
