//! Linux's memory figures, from /proc and control groups.

use std::fs;
use std::path::{Path, PathBuf};

use super::left::{Left, MACHINE, TOLD};

/// Mount point of control groups of both versions.
const GROUPS: &str = "/sys/fs/cgroup";

/// Memory figures in bytes; `None` where they are not known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct System {
    /// Usage of the process: resident memory, address space and data.
    resident: u64,
    address_space: u64,
    data: u64,
    /// Memory that the machine has available, without the process's own.
    available: Option<u64>,
    /// Least limit of the control groups of the process.
    group: Option<u64>,
    /// Resource limits of the process.
    most_address_space: Option<u64>,
    most_data: Option<u64>,
}

impl System {
    pub(super) fn read() -> Self {
        let text = |path: &str| fs::read_to_string(path).unwrap_or_default();
        let (status, meminfo, limits) = (text("/proc/self/status"), text("/proc/meminfo"), text("/proc/self/limits"));
        let bytes = |name: &str| kilobytes(&status, name).unwrap_or(0);
        let group = group_files(&text("/proc/self/cgroup"))
            .into_iter()
            .filter_map(|path| limit_of_group(&fs::read_to_string(path).ok()?))
            .min();
        Self {
            resident: bytes("VmRSS:"),
            address_space: bytes("VmSize:"),
            data: bytes("VmData:"),
            available: kilobytes(&meminfo, "MemAvailable:").or_else(|| kilobytes(&meminfo, "MemTotal:")),
            group,
            most_address_space: soft_limit(&limits, "Max address space"),
            most_data: soft_limit(&limits, "Max data size"),
        }
    }

    /// Memory that the process can still take. A limit `told` by the user, unless 0, replaces the limits of machine and
    /// control groups.
    pub(super) fn left(&self, told: u64) -> Option<Left> {
        let shared = match told {
            0 => [
                self.available.map(|left| Left { bytes: left, of: left + self.resident, bound: MACHINE }),
                self.group.map(|most| Left::of(most, self.resident, "the control group of the process")),
            ],
            told => [Some(Left::of(told, self.resident, TOLD)), None],
        };
        shared.into_iter().flatten().chain(self.left_to_map()).min_by_key(|left| left.bytes)
    }

    /// Address space that the resource limits leave, whether it is touched or not.
    pub(super) fn left_to_map(&self) -> Option<Left> {
        let own = [
            self.most_address_space.map(|most| Left::of(most, self.address_space, "ulimit -v")),
            self.most_data.map(|most| Left::of(most, self.data, "ulimit -d")),
        ];
        own.into_iter().flatten().min_by_key(|left| left.bytes)
    }
}

/// Memory of this process in bytes by its key of `/proc/self/status`, for example `VmHWM:` for its peak; `None` on
/// systems other than Linux.
pub fn of_process(name: &str) -> Option<u64> {
    kilobytes(&fs::read_to_string("/proc/self/status").ok()?, name)
}

/// Bytes in the line `name` of `/proc/meminfo` or `/proc/PID/status`, which has kilobytes of 1024.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let value = text.lines().find_map(|line| line.strip_prefix(name))?;
    value.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// The soft limit of that name in `/proc/PID/limits`; `None` where there is none.
fn soft_limit(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The number in `memory.max` or `memory.limit_in_bytes`; `None` where the group has no limit, which is `max`, or the
/// largest number of whole pages.
fn limit_of_group(text: &str) -> Option<u64> {
    const NONE: u64 = 1 << 62;
    text.trim().parse().ok().filter(|&bytes| bytes < NONE)
}

/// The files with the limits of the groups that `/proc/PID/cgroup` names, and of those around them. Not all need be
/// there: a container may see its own group as the root.
fn group_files(text: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for line in text.lines() {
        let mut parts = line.splitn(3, ':');
        let (Some(_), Some(controllers), Some(path)) = (parts.next(), parts.next(), parts.next()) else { continue };
        let (mounts, file): (&[&str], &str) = if controllers.is_empty() {
            (&["", "unified"], "memory.max")
        } else if controllers.split(',').any(|controller| controller == "memory") {
            (&["memory"], "memory.limit_in_bytes")
        } else {
            continue;
        };
        for group in Path::new(path.trim_start_matches('/')).ancestors() {
            files.extend(mounts.iter().map(|mount| Path::new(GROUPS).join(mount).join(group).join(file)));
        }
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_the_system_are_read() {
        let meminfo = "MemTotal:       24684092 kB\nMemFree:        15040640 kB\nMemAvailable:   24072284 kB\n";
        assert_eq!(kilobytes(meminfo, "MemAvailable:"), Some(24_072_284 << 10));
        assert_eq!(kilobytes("VmPeak:\t  1 kB\nVmRSS:\t   20 kB\n", "VmRSS:"), Some(20 << 10));
        for text in ["", "MemAvailable: kB", "MemAvailable: 5 MB", "MemAvailable: 99999999999999999999 kB"] {
            assert_eq!(kilobytes(text, "MemAvailable:"), None, "{text}");
        }
        let limits = "Limit                     Soft Limit           Hard Limit           Units\n\
                      Max data size             unlimited            unlimited            bytes\n\
                      Max address space         409600000            unlimited            bytes\n";
        assert_eq!(soft_limit(limits, "Max address space"), Some(409_600_000));
        assert_eq!([soft_limit(limits, "Max data size"), soft_limit("", "Max data size")], [None; 2]);
    }

    #[test]
    fn limits_of_groups_of_both_versions_are_read() {
        assert_eq!(limit_of_group("2147483648\n"), Some(2 << 30));
        // Of version 2, and of version 1.
        for none in ["max\n", "9223372036854771712\n", ""] {
            assert_eq!(limit_of_group(none), None, "{none}");
        }
        let text = "12:cpu,cpuacct:/a\n4:memory:/pods/one\n1:name=systemd:/init.scope\n0::/user.slice/it\n\nodd";
        let files: Vec<_> = group_files(text).iter().map(|path| path.display().to_string()).collect();
        let expected = [
            "memory/pods/one/memory.limit_in_bytes",
            "memory/pods/memory.limit_in_bytes",
            "memory/memory.limit_in_bytes",
            "user.slice/it/memory.max",
            "unified/user.slice/it/memory.max",
            "user.slice/memory.max",
            "unified/user.slice/memory.max",
            "memory.max",
            "unified/memory.max",
        ];
        assert_eq!(files, expected.map(|file| format!("{GROUPS}/{file}")));
    }

    #[test]
    fn the_least_counts_and_what_was_told_stands_in_for_the_machine() {
        let system = System {
            resident: 10,
            address_space: 100,
            data: 50,
            available: Some(1000),
            group: Some(500),
            most_address_space: None,
            most_data: None,
        };
        let left = |system: System, told| system.left(told).map(|left| (left.bytes, left.of, left.bound));
        assert_eq!(left(system, 0), Some((490, 500, "the control group of the process")));
        assert_eq!(left(System { group: None, ..system }, 0), Some((1000, 1010, MACHINE)));
        assert_eq!(left(system, 2000), Some((1990, 2000, TOLD)));
        assert_eq!(left(system, 5), Some((0, 5, TOLD)));
        let limited = System { most_address_space: Some(300), most_data: Some(290), ..system };
        assert_eq!(left(limited, 2000), Some((200, 300, "ulimit -v")));
        assert_eq!(left(System { most_data: Some(150), ..limited }, 0), Some((100, 150, "ulimit -d")));
        assert_eq!(left(System::default(), 0), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_process_has_something() {
        let system = System::read();
        assert!(system.resident > 0 && system.address_space >= system.resident && system.available.is_some());
    }
}
