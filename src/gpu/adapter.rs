//! Adapters: the list of them, and the choice of one.

use super::error::GpuError;

/// The properties of an adapter that are known before it is opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterFacts {
    /// Place in the list; `--adapter` takes it.
    pub index: usize,
    /// Name of the device.
    pub name: String,
    /// Interface through which it is driven.
    pub backend: String,
    /// Name of the driver.
    pub driver: String,
    /// Version of the driver.
    pub driver_info: String,
    /// discrete GPU, integrated GPU, virtual GPU, CPU or other.
    pub kind: &'static str,
    /// PCI vendor and device.
    pub pci: [u32; 2],
    /// Smallest and largest subgroup.
    pub subgroup: [u32; 2],
}

impl AdapterFacts {
    /// Name, driver and its version in one line, as reports name the adapter.
    #[must_use]
    pub fn title(&self) -> String {
        let driver = [self.driver.as_str(), self.driver_info.as_str()];
        let driver: Vec<&str> = driver.into_iter().filter(|d| !d.is_empty()).collect();
        format!("{} ({})", self.name, driver.join(" "))
    }
}

/// An adapter that can be opened.
pub struct Adapter {
    /// What is known of it.
    pub facts: AdapterFacts,
    pub(super) raw: wgpu::Adapter,
}

impl Adapter {
    /// The limits of the hardware by WebGPU's names.
    #[must_use]
    pub fn limits(&self) -> Vec<(&'static str, u64)> {
        named_limits(&self.raw.limits())
    }

    /// Names of WebGPU's optional features and of wgpu's own that it has.
    #[must_use]
    pub fn features(&self) -> Vec<String> {
        self.raw
            .features()
            .iter_names()
            .map(|(name, _)| name.to_ascii_lowercase().replace('_', "-"))
            .collect()
    }

    /// Whether the driver claims to filter anisotropically.
    #[must_use]
    pub fn is_anisotropic(&self) -> bool {
        let flags = self.raw.get_downlevel_capabilities().flags;
        flags.contains(wgpu::DownlevelFlags::ANISOTROPIC_FILTERING)
    }
}

/// Those limits that the work of this project meets.
#[must_use]
pub fn named_limits(limits: &wgpu::Limits) -> Vec<(&'static str, u64)> {
    let invocations = limits.max_compute_invocations_per_workgroup;
    let groups = limits.max_compute_workgroups_per_dimension;
    vec![
        ("maxTextureDimension2D", limits.max_texture_dimension_2d.into()),
        ("maxTextureArrayLayers", limits.max_texture_array_layers.into()),
        ("maxBufferSize", limits.max_buffer_size),
        ("maxStorageBufferBindingSize", limits.max_storage_buffer_binding_size),
        ("maxStorageBuffersPerShaderStage", limits.max_storage_buffers_per_shader_stage.into()),
        ("maxComputeInvocationsPerWorkgroup", invocations.into()),
        ("maxComputeWorkgroupsPerDimension", groups.into()),
        ("maxComputeWorkgroupStorageSize", limits.max_compute_workgroup_storage_size.into()),
    ]
}

/// The interfaces that a device may have: Vulkan on Linux, Metal on macOS, Direct3D 12 and Vulkan on Windows.
const BACKENDS: wgpu::Backends =
    wgpu::Backends::VULKAN.union(wgpu::Backends::METAL).union(wgpu::Backends::DX12);

/// Every adapter that a driver offers, in the drivers' order. Empty without a driver.
#[must_use]
pub fn list() -> Vec<Adapter> {
    if wgpu::Instance::enabled_backend_features().is_empty() {
        return Vec::new();
    }
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = BACKENDS;
    // A driver that is being written is not conformant yet; its author wants to see it here.
    descriptor.flags = wgpu::InstanceFlags::ALLOW_UNDERLYING_NONCOMPLIANT_ADAPTER;
    let instance = wgpu::Instance::new(descriptor);
    let adapters = pollster::block_on(instance.enumerate_adapters(BACKENDS));
    adapters
        .into_iter()
        .enumerate()
        .map(|(index, raw)| Adapter { facts: facts(index, raw.get_info()), raw })
        .collect()
}

fn facts(index: usize, info: wgpu::AdapterInfo) -> AdapterFacts {
    AdapterFacts {
        index,
        backend: info.backend.to_string(),
        kind: match info.device_type {
            wgpu::DeviceType::DiscreteGpu => "discrete GPU",
            wgpu::DeviceType::IntegratedGpu => "integrated GPU",
            wgpu::DeviceType::VirtualGpu => "virtual GPU",
            wgpu::DeviceType::Cpu => "CPU",
            wgpu::DeviceType::Other => "other",
        },
        name: info.name,
        driver: info.driver,
        driver_info: info.driver_info,
        pci: [info.vendor, info.device],
        subgroup: [info.subgroup_min_size, info.subgroup_max_size],
    }
}

/// The adapter that `asked` names: an index of the list, else a part of the name, the driver or its version, small
/// and capital letters alike. Without a wish a real GPU comes before software, then the drivers' order counts.
///
/// # Errors
///
/// Nothing there; no or several adapters meant.
pub fn choose(mut adapters: Vec<Adapter>, asked: Option<&str>) -> Result<Adapter, GpuError> {
    let there: Vec<AdapterFacts> = adapters.iter().map(|a| a.facts.clone()).collect();
    let at = chosen(&there, asked)?;
    Ok(adapters.swap_remove(at))
}

/// Index of the adapter that is meant.
fn chosen(there: &[AdapterFacts], asked: Option<&str>) -> Result<usize, GpuError> {
    if there.is_empty() {
        return Err(GpuError::NoAdapter);
    }
    let Some(asked) = asked else {
        let rank = |kind: &str| match kind {
            "discrete GPU" => 0,
            "integrated GPU" => 1,
            "virtual GPU" => 2,
            "other" => 3,
            _ => 4,
        };
        return (0..there.len()).min_by_key(|at| rank(there[*at].kind)).ok_or(GpuError::NoAdapter);
    };
    let fails = |problem| {
        let names: Vec<String> = there.iter().map(|a| format!("{}: {}", a.index, a.name)).collect();
        GpuError::Choice { asked: asked.to_string(), problem, there: names.join(", ") }
    };
    if let Ok(index) = asked.parse::<usize>() {
        return if index < there.len() { Ok(index) } else { Err(fails("names none")) };
    }
    let wanted = asked.to_lowercase();
    let meant = |a: &AdapterFacts| !wanted.is_empty() && a.title().to_lowercase().contains(&wanted);
    let matching: Vec<usize> = (0..there.len()).filter(|at| meant(&there[*at])).collect();
    match matching.as_slice() {
        [one] => Ok(*one),
        [] => Err(fails("names none")),
        [..] => Err(fails("names more than one")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(index: usize, name: &str, kind: &'static str) -> AdapterFacts {
        AdapterFacts {
            index,
            name: name.into(),
            backend: "vulkan".into(),
            driver: "maker".into(),
            driver_info: "1.2".into(),
            kind,
            pci: [0; 2],
            subgroup: [8, 8],
        }
    }

    #[test]
    fn a_real_gpu_comes_before_software_and_a_wish_before_both() {
        let there = [adapter(0, "llvmpipe", "CPU"), adapter(1, "Big GPU", "discrete GPU")];
        assert_eq!(chosen(&there, None), Ok(1));
        assert_eq!(chosen(&there, Some("0")), Ok(0));
        assert_eq!(chosen(&there, Some("LLVM")), Ok(0));
        assert_eq!(chosen(&there, Some("big")), Ok(1));
        assert_eq!(chosen(&[], None), Err(GpuError::NoAdapter));
        assert_eq!(chosen(&[], Some("0")), Err(GpuError::NoAdapter));
    }

    #[test]
    fn fails_when_the_wish_names_none_or_several_and_lists_what_is_there() {
        let there = [adapter(0, "llvmpipe", "CPU"), adapter(1, "Big GPU", "discrete GPU")];
        for (asked, problem) in
            [("2", "names none"), ("", "names none"), ("maker", "names more than one")]
        {
            let error = chosen(&there, Some(asked)).expect_err("no single adapter is meant");
            let text = error.to_string();
            assert!(text.contains(problem), "{text}");
            assert!(text.contains("0: llvmpipe, 1: Big GPU"), "{text}");
        }
    }
}
