//! Plans: stages, resources and what was left out, as plain data.

use std::fmt;

use glam::UVec3;
use serde::Serialize;

use super::Inputs;
use crate::gpu::{Format, Limits, Specialization};

/// What a technique is going to do for a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Plan {
    /// The technique's name.
    pub technique: &'static str,
    /// Stages in the order they run.
    pub stages: Vec<StagePlan>,
    /// Everything that takes device memory.
    pub resources: Vec<ResourcePlan>,
    /// What this scene does not need, and why.
    pub omitted: Vec<Omission>,
}

/// One stage.
#[derive(Clone, Debug, Serialize)]
pub struct StagePlan {
    /// `technique.stage`.
    pub name: &'static str,
    /// A change of any of these runs it again.
    pub depends_on: Inputs,
    /// Invocations along x, y, z of one dispatch (texels, for a copy).
    pub domain: UVec3,
    /// Dispatches or copies.
    pub dispatches: u32,
    /// Specialisation constants as `NAME = value`.
    #[serde(serialize_with = "specializations")]
    pub specialization: Vec<Specialization>,
}

/// What a resource is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ResourceKind {
    /// The volume's voxels.
    Volume,
    /// Auxiliary data that grows with the volume or the technique.
    Auxiliary,
    /// Data that grows with the image.
    Image,
    /// A staging buffer, alive only while loading.
    Staging,
}

/// One image or buffer.
#[derive(Clone, Debug, Serialize)]
pub struct ResourcePlan {
    /// Its name, also in captures and allocation reports.
    pub name: &'static str,
    /// What it is.
    pub kind: ResourceKind,
    /// Texels along x, y, z; bytes along x for a buffer.
    pub extent: UVec3,
    /// Texel format; `UNDEFINED` for a buffer.
    #[serde(serialize_with = "format")]
    pub format: Format,
    /// Bytes, before the driver's padding.
    pub bytes: u64,
    /// What would make it smaller.
    pub shrink: &'static str,
}

/// Something that the scene does not need.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Omission {
    /// The stage, resource or feature left out.
    pub what: &'static str,
    /// Why the scene cannot show it.
    pub why: String,
}

/// A scene that a device cannot render.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The resources do not fit.
    #[error("{needed} of device memory are needed, {available} are available; largest: {largest}")]
    Memory {
        /// All resources together.
        needed: String,
        /// The device's heap.
        available: String,
        /// The largest items and what would shrink them.
        largest: String,
    },
    /// A single limit is exceeded.
    #[error("{what}: {found}, but {limit}; {fix}")]
    Limit {
        /// What exceeds it.
        what: String,
        /// By how much.
        found: String,
        /// The limit.
        limit: String,
        /// What would help.
        fix: String,
    },
}

impl Plan {
    /// Bytes of all resources that live while rendering (staging not counted).
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.resources
            .iter()
            .filter(|r| r.kind != ResourceKind::Staging)
            .map(|r| r.bytes)
            .sum()
    }

    /// Compares every resource, and all together, with what the device has, before any is created.
    ///
    /// # Errors
    /// Names the largest items and what would shrink them.
    pub fn check(&self, limits: &Limits) -> Result<(), PlanError> {
        for r in &self.resources {
            if r.bytes > limits.max_allocation {
                return Err(PlanError::Limit {
                    what: r.name.to_owned(),
                    found: size(r.bytes),
                    limit: format!(
                        "one allocation is limited to {}",
                        size(limits.max_allocation)
                    ),
                    fix: r.shrink.to_owned(),
                });
            }
        }
        let needed: u64 = self.resources.iter().map(|r| r.bytes).sum();
        if needed <= limits.heap_bytes {
            return Ok(());
        }
        let mut sorted: Vec<_> = self.resources.iter().collect();
        sorted.sort_by_key(|r| std::cmp::Reverse(r.bytes));
        let largest = sorted
            .iter()
            .take(3)
            .map(|r| format!("{} {} ({})", r.name, size(r.bytes), r.shrink))
            .collect::<Vec<_>>()
            .join(", ");
        Err(PlanError::Memory {
            needed: size(needed),
            available: size(limits.heap_bytes),
            largest,
        })
    }
}

/// Bytes for people: `33.6 MB`.
#[must_use]
pub(crate) fn size(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["B", "kB", "MB", "GB", "TB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 1000.0 && unit + 1 < UNITS.len() {
        value /= 1000.0;
        unit += 1;
    }
    if unit == 0 {
        format!("{bytes} B")
    } else {
        format!("{value:.3} {}", UNITS[unit])
    }
}

fn format<S: serde::Serializer>(format: &Format, s: S) -> Result<S::Ok, S::Error> {
    s.serialize_str(&format!("{format:?}"))
}

fn specializations<S: serde::Serializer>(list: &[Specialization], s: S) -> Result<S::Ok, S::Error> {
    s.collect_map(list.iter().map(|c| (c.name, c.value)))
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "technique  {}", self.technique)?;
        writeln!(f, "\nstages")?;
        for s in &self.stages {
            let inputs: Vec<_> = s.depends_on.iter().map(|i| format!("{i:?}")).collect();
            writeln!(
                f,
                "  {:<26} {} x {} x {}, {} dispatch(es); on {}",
                s.name,
                s.domain.x,
                s.domain.y,
                s.domain.z,
                s.dispatches,
                inputs.join(", ")
            )?;
            if !s.specialization.is_empty() {
                let list: Vec<_> = s
                    .specialization
                    .iter()
                    .map(|c| format!("{} = {}", c.name, c.value))
                    .collect();
                writeln!(f, "  {:<26} {}", "", list.join(", "))?;
            }
        }
        writeln!(f, "\nresources")?;
        for r in &self.resources {
            writeln!(
                f,
                "  {:<26} {:>10}  {:?} {} x {} x {}",
                r.name,
                size(r.bytes),
                r.format,
                r.extent.x,
                r.extent.y,
                r.extent.z
            )?;
        }
        writeln!(
            f,
            "  {:<26} {:>10}",
            "total while rendering",
            size(self.bytes())
        )?;
        writeln!(f, "\nleft out")?;
        for o in &self.omitted {
            writeln!(f, "  {:<26} {}", o.what, o.why)?;
        }
        Ok(())
    }
}
